"""A sweep on dask workers: `python benchmarks/cluster.py [--points 8] [--duration 0.2]`.

The same sweep of the imbalance case is marched by one local worker, by two, and by two worker
processes that join a scheduler by its address, as on a cluster, of which one is then killed: its
points are marched again. All give the same bits of every point. Printed are the clock's time of
the points, once workers have loaded what they need, the efficiency (one worker's time over twice
that of two), and the bytes of a group as it is sent and of what comes back.
"""

from __future__ import annotations

import argparse
import pickle
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

import dask
import numpy as np
from distributed import Client
from rich.console import Console
from rich.table import Table
from sweep import planned

from bladewhirl.models.case.file import dumps_case
from bladewhirl.studies.sweeps.cluster import ENCRYPTION, local_cluster, march_groups
from bladewhirl.studies.sweeps.plan import Plan
from bladewhirl.studies.sweeps.points import Failure, Outcome, Work

DASK = [sys.executable, "-m", "distributed.cli.dask_scheduler"]
WORKER = [sys.executable, "-m", "distributed.cli.dask_worker"]
ALONE = ["--nworkers", "1", "--nthreads", "1", "--no-nanny", "--no-dashboard"]


@contextmanager
def by_hand(folder: Path, workers: int) -> Iterator[tuple[str, list[subprocess.Popen[bytes]]]]:
    """Start a scheduler and workers in processes; return its address and the workers."""
    note = folder / f"scheduler-{time.time_ns()}.json"
    with ExitStack() as stack:

        def start(*command: str) -> subprocess.Popen[bytes]:
            quiet = subprocess.DEVNULL
            process = subprocess.Popen(command, cwd=folder, stdout=quiet, stderr=quiet)
            stack.callback(process.wait)
            stack.callback(process.terminate)
            return process

        start(*DASK, "--host", "127.0.0.1", "--port", "0", "--no-dashboard",
              "--scheduler-file", str(note))  # fmt: skip
        while not note.exists():
            time.sleep(0.05)
        with Client(scheduler_file=str(note), set_as_default=False) as client:
            address = str(client.scheduler.address)
            processes = [start(*WORKER, address, *ALONE) for _ in range(workers)]
            client.wait_for_workers(workers, timeout=60)
        yield address, processes


def marched(
    plan: Plan, address: str, after_one: Callable[[], object] = lambda: None
) -> tuple[float, dict[int, Outcome]]:
    """Return the time of a sweep on the workers of a scheduler [s] and all outcomes."""
    found: dict[int, Outcome] = {}
    left = plan.left(np.zeros(plan.grid.size, dtype=np.int8))
    began = time.perf_counter()
    for outcomes in march_groups(work_of(plan), left, scheduler=address, workers=None):
        if not found:
            after_one()
        found |= outcomes
    return time.perf_counter() - began, found


def work_of(plan: Plan) -> Work:
    """Return the data sent with every group."""
    return Work(case=dumps_case(plan.case), layout=plan.layout, histories="")


def agree(one: Mapping[int, Outcome], other: Mapping[int, Outcome]) -> bool:
    """Return whether all points are done with identical bits."""
    return one.keys() == other.keys() and all(
        not isinstance(found, Failure)
        and all(
            np.array_equal(found[name], wanted, equal_nan=True) for name, wanted in mine.items()
        )
        for found, mine in ((other[point], mine) for point, mine in one.items())
        if not isinstance(mine, Failure)
    )


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--points", type=int, default=8)
    parser.add_argument("--duration", type=float, default=0.2, help="of each march [s]")
    given = parser.parse_args()
    plan = planned(given.duration, given.points)
    times: dict[str, float] = {}
    outcomes: dict[str, dict[int, Outcome]] = {}
    for workers in (1, 2):
        with local_cluster(workers) as cluster:
            name = f"{workers} local"
            marched(plan, cluster.scheduler_address)  # workers load what they need
            times[name], outcomes[name] = marched(plan, cluster.scheduler_address)
    with (
        TemporaryDirectory() as folder,
        dask.config.set({ENCRYPTION: False}),
        by_hand(Path(folder), 2) as (address, processes),
    ):
        marched(plan, address)
        times["2 by address"], outcomes["2 by address"] = marched(plan, address)
        killed = "2 by address, one killed"
        times[killed], outcomes[killed] = marched(plan, address, processes[0].kill)
    first = outcomes["1 local"]
    table = Table(title=f"{given.points} points of {given.duration:g} s")
    for column in ("workers", "time [s]", "efficiency", "same bits"):
        table.add_column(column)
    for name, taken in times.items():
        share = times["1 local"] / (taken * (1 if name in ("1 local", killed) else 2))
        efficiency = "" if name == killed else f"{share:.0%}"
        same = "yes" if agree(first, outcomes[name]) else "no"
        table.add_row(name, f"{taken:.2f}", efficiency, same)
    group = next(plan.left(np.zeros(plan.grid.size, dtype=np.int8)))
    there, back = (len(pickle.dumps(each)) for each in ((work_of(plan), group), first[0]))
    Console().print(table, f"bytes of a point: {there} sent, {back} come back")


if __name__ == "__main__":
    main()
