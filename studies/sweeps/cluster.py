"""Points on the workers of an existing dask scheduler; see `march_points`."""

import logging
import socket
import time
import uuid
from collections.abc import Iterable, Iterator

from bladewhirl.models.inputs.errors import UserError
from bladewhirl.studies.runs.folder import version
from bladewhirl.studies.sweeps.points import Failure, Outcome, Point, Work, march_point
from bladewhirl.studies.sweeps.workers import READY, ready

try:
    import dask
    from distributed import CancelledError, Client, as_completed
    from distributed.comm.addressing import get_address_host_port
    from distributed.scheduler import KilledWorker
except ImportError as error:
    raise UserError(
        f"--scheduler: expected dask ({error}): pip install 'bladewhirl[cluster]'"
    ) from None

ENCRYPTION = "distributed.comm.require-encryption"
"""Setting of dask; an explicit false permits a scheduler without TLS."""

PATIENCE = 30.0  #: time limit for the answer of a scheduler [s]

IDLE, PAUSE = 10.0, 0.01
"""Time without a worker after which the user is warned, and time between two looks [s]."""

logger = logging.getLogger(__name__)


def march_on_cluster(
    work: Work, points: Iterable[Point | None], scheduler: str
) -> Iterator[tuple[int, Outcome]]:
    """March points on the workers of a scheduler, given by its address; yield the number and the
    outcome of each point as the outcome arrives.

    Raises:
        UserError: the scheduler does not answer, has no TLS, or its workers have another version;
            or the connection to it was lost.
    """
    dask_log = logging.getLogger("distributed.client")
    level = dask_log.level
    try:
        with _client(scheduler) as client:
            dask_log.setLevel(logging.CRITICAL)  # it would print tracebacks of a lost connection
            yield from _outcomes(work, iter(points), client)
    except (CancelledError, OSError):
        raise UserError(
            f"--scheduler {scheduler}: the connection was lost; finished points are kept, and"
            " bladewhirl sweep --resume DIR marches the others"
        ) from None
    finally:
        dask_log.setLevel(level)


def _outcomes(
    work: Work, waiting: Iterator[Point | None], client: Client
) -> Iterator[tuple[int, Outcome]]:
    """Yield the outcomes of points marched by the workers of a client, see `march_on_cluster`."""
    marching = dict[object, Point]()
    results = as_completed(loop=client.loop)
    # one group name for all keys, since the scheduler stores data for each group
    together = "sweep-" + uuid.uuid4().hex
    while True:
        threads = max(1, sum(client.nthreads().values()))
        for point in ready(waiting, max(0, (1 + READY) * threads - len(marching))):
            key = (together, point.number, int(point.screen))
            future = client.submit(march_point, work, point, key=key, pure=False)
            marching[future.key] = point
            results.add(future)
        if not marching:
            return
        _wait(results, client)
        future = next(results)
        point = marching.pop(future.key)
        try:
            outcome = future.result()
        except KilledWorker:  # raised after the number of deaths that the scheduler allows
            outcome = Failure(reason="the workers that marched this point died")
        except (ImportError, AttributeError) as error:  # errors in a march are returned
            raise UserError(
                f"workers: expected bladewhirl {version()} on the workers, too; its code could"
                f" not be loaded ({error})"
            ) from None
        finally:
            future.release()
        yield point.number, outcome


def _wait(results: as_completed, client: Client) -> None:
    """Wait for an outcome; warn if there is no worker that could march."""
    due = time.monotonic() + IDLE
    while not results.has_ready():
        time.sleep(PAUSE)
        if time.monotonic() > due:
            due = time.monotonic() + IDLE
            if not client.nthreads():
                due = float("inf")
                logger.warning("The scheduler has no worker; the sweep goes on when one joins.")


def _client(scheduler: str) -> Client:
    """Return a client of the scheduler.

    Raises:
        UserError: the scheduler does not answer, or has no TLS.
    """
    if not scheduler.startswith("tls://") and dask.config.get(ENCRYPTION) is not False:
        raise UserError(
            f"--scheduler {scheduler}: expected tls://HOST:PORT; without TLS anybody who"
            " reaches the port runs code as you. If nobody else can, allow it by"
            " DASK_DISTRIBUTED__COMM__REQUIRE_ENCRYPTION=False"
        )
    try:
        # A client that cannot connect is closed by the garbage collection; if this happens while
        # another client starts, both wait for each other forever.
        socket.create_connection(get_address_host_port(scheduler), PATIENCE).close()
        return Client(scheduler, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError, TypeError, TimeoutError) as error:  # TypeError: no TLS keys
        raise UserError(
            f"--scheduler {scheduler}: expected the address of a dask scheduler ({error})"
        ) from None
