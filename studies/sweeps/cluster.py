"""Points on dask workers: a few at a time, suspects one by one, results in any order."""

from __future__ import annotations

import socket
import uuid
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from itertools import chain, islice

import dask
from dask.system import CPU_COUNT
from distributed import Client, LocalCluster, Security, as_completed
from distributed.comm.addressing import get_address_host_port
from distributed.scheduler import KilledWorker

from bladewhirl.models.inputs.errors import UserError
from bladewhirl.studies.runs.folder import version
from bladewhirl.studies.runs.interrupts import held_back
from bladewhirl.studies.sweeps.points import Failure, Outcome, Point, Work, march_point

ENCRYPTION = "distributed.comm.require-encryption"
"""Setting of dask: false permits a scheduler without TLS, which nobody sets by accident."""

PATIENCE = 30.0
"""Time limit for the answer of an existing scheduler [s]."""

LOCAL: Mapping[str, object] = {
    # A point whose worker died is suspect at once and then tried alone.
    "distributed.scheduler.allowed-failures": 1,
    # Workers leave with their parent.
    "distributed.worker.daemon": True,
    # No web page of workers or scheduler unless requested.
    "distributed.worker.http.routes": [],
    # With its defaults of hundredths of a second, dask takes some 5 % of the time of marches.
    "distributed.admin.tick.interval": "500ms",
    "distributed.admin.system-monitor.interval": "5s",
    # Bounded logs of dask, independent of the number of points.
    "distributed.admin.low-level-log-length": 100,
    "distributed.admin.system-monitor.log-length": 100,
}

UNSEEN: Mapping[str, object] = {
    "distributed.scheduler.http.routes": [],
    "distributed.worker.profile.enabled": False,
}
"""Settings for data shown only on dask's web page."""

DASHBOARD = "127.0.0.1:8787"
"""Address of dask's web page of a local cluster, if requested; local only."""

READY = 1
"""Points that wait at a worker in addition to the running one, so that it is never idle."""


def march_points(
    work: Work,
    points: Iterable[Point],
    *,
    scheduler: str | None,
    workers: int | None,
    dashboard: bool = False,
) -> Iterator[tuple[int, Outcome]]:
    """March points and yield the number and the outcome of each on arrival.

    A worker that dies takes down nothing but what it was doing: dask starts another and gives the
    work to the next. A point that was being marched when workers died again is put aside and tried
    alone at the end, when no other can be to blame; if they die even so, it fails.

    Args:
        work: what the points have in common.
        points: to march.
        scheduler: address of an existing scheduler, or None.
        workers: number of local ones; one a core when None.
        dashboard: show dask's web page of local workers.

    Raises:
        UserError: the scheduler does not answer, has no TLS, or its workers have another version.
    """
    waiting = iter(points)
    count = workers or CPU_COUNT
    first = list(islice(waiting, count))
    if not first:
        return
    with _client(scheduler, min(count, len(first)), dashboard) as client:
        suspects: list[Point] = []
        yield from _in_flight(client, work, chain(first, waiting), suspects)
        for point in suspects:
            dead: list[Point] = []
            yield from _in_flight(client, work, [point], dead)
            if dead:
                reason = "the worker died every time it marched this point, alone too"
                yield point.number, Failure(reason=reason)


def _in_flight(
    client: Client, work: Work, points: Iterable[Point], suspects: list[Point]
) -> Iterator[tuple[int, Outcome]]:
    """March points with a few submitted at a time, which bounds the memory."""
    waiting, marching = iter(points), dict[object, Point]()
    results = as_completed(loop=client.loop)
    together = "sweep-" + uuid.uuid4().hex  # one name: the scheduler keeps books on each

    def submit(most: int) -> None:
        for point in islice(waiting, most):
            key = (together, point.number)
            future = client.submit(march_point, work, point, key=key, pure=False)
            marching[future.key] = point
            results.add(future)

    while True:
        threads = max(1, sum(client.nthreads().values()))
        submit(max(0, (1 + READY) * threads - len(marching)))
        if not marching:
            return
        future = next(results)
        point = marching.pop(future.key)
        try:
            outcome = future.result()
        except KilledWorker:
            suspects.append(point)
            continue
        except (ImportError, AttributeError) as error:  # those of a march become failures
            raise UserError(
                f"workers: expected bladewhirl {version()} there, too; its code could not be loaded"
                f" ({error})"
            ) from None
        finally:
            future.release()
        yield point.number, outcome


@contextmanager
def _client(scheduler: str | None, workers: int, dashboard: bool) -> Iterator[Client]:
    """A client of the scheduler, or of a local cluster that ends with it."""
    if scheduler is not None:
        if not scheduler.startswith("tls://") and dask.config.get(ENCRYPTION) is not False:
            raise UserError(
                f"--scheduler {scheduler}: expected tls://HOST:PORT; without TLS anybody who"
                " reaches the port runs code as you. If nobody else can, allow it by"
                " DASK_DISTRIBUTED__COMM__REQUIRE_ENCRYPTION=False"
            )
        try:
            # A client that can't connect is ended when it is collected; where that happens while
            # another one starts, both wait for each other.
            socket.create_connection(get_address_host_port(scheduler), PATIENCE).close()
            client = Client(scheduler, timeout=PATIENCE, set_as_default=False)
        except (OSError, ValueError, TypeError, TimeoutError) as error:  # TypeError: no keys
            raise UserError(
                f"--scheduler {scheduler}: expected the address of a dask scheduler ({error})"
            ) from None
        with client:
            yield client
        return
    with (
        local_cluster(workers, dashboard=dashboard) as cluster,
        Client(cluster, set_as_default=False) as client,
    ):
        yield client


@contextmanager
def local_cluster(workers: int, *, dashboard: bool = False) -> Iterator[LocalCluster]:
    """A cluster on this machine, one process a worker; Ctrl-C waits until they have started.

    dask can't end a cluster in order whose workers are still starting. What it hears it unpickles,
    so it listens to nobody without the key, which is made for this cluster and kept in memory:
    this process, its clients by address too, and the workers have it.
    """
    security = Security.temporary()
    keys = {
        f"distributed.comm.tls.{role}.{part}": getattr(security, f"tls_{role}_{part}")
        for role in ("client", "worker", "scheduler")
        for part in ("key", "cert")
    }
    keys |= {"distributed.comm.tls.ca-file": security.tls_ca_file}
    unseen = {} if dashboard else UNSEEN
    with dask.config.set({**LOCAL, **keys, **unseen}):
        with held_back():
            cluster = LocalCluster(
                n_workers=workers,
                threads_per_worker=1,
                processes=True,
                dashboard_address=DASHBOARD if dashboard else "127.0.0.1:0",
                worker_dashboard_address="127.0.0.1:0",
                scheduler_kwargs={"dashboard": dashboard},
                security=security,
                silence_logs="CRITICAL",
            )
        with cluster:
            yield cluster
