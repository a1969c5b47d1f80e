"""What batching and cores do for sweeps: `python benchmarks/sweep.py [--workers 2]`.

The first table tells what a core would gain by marching eight speeds together, one a lane of a
register (`batched_march`). Runs have the step without contact in common: it is timed alone and
batched, from one state, and the gaps compared. In contact each run has other tips to solve for;
there the time batched is the time alone less what the common part saves. The kernel's time alone
holds its ledger and records, the batched one does not, so the ratios are upper bounds.

The second table is the scaling over cores. Points of a sweep of the imbalance case, between 0.95
and 1.15, are marched by the workers that `bladewhirl sweep` uses: one of them alone, then all at a
time, in turn, in one session. Each turn gives every working process the same points, so that none
waits for one with more contact. What is timed is all that a point costs (stage, march, analysis),
per step of its march; starting workers and compiling is not. The best turn counts. The efficiency
is the time that a worker takes alone over the time that it takes beside the others: 1 where they
don't slow each other down. On a machine with other work the same ratio of processor times tells how
far it is the workers that are in each other's way.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from batched_march import BatchedMarch
from dask.system import CPU_COUNT
from distributed import Client, LocalCluster
from march import OUT_OF_REACH, RECORD_EVERY, TIME_STEP, microseconds, settings
from rich.console import Console
from rich.table import Table

from bladewhirl.models.case.file import dumps_case, read_case
from bladewhirl.solvers.kernel.vectors import LANES
from bladewhirl.solvers.march.central_difference import CentralDifference, CentralDifferenceState
from bladewhirl.studies.sweeps.axes import make_grid
from bladewhirl.studies.sweeps.plan import Plan, plan_sweep
from bladewhirl.studies.sweeps.points import Failure, Group, Work, march_group

ALONE_STEPS, BATCHED_STEPS, COMPARED_STEPS = 2000, 600, 200
OPENED = 1000.0  # times the clearance keep casing and tips apart
EXAMPLES = Path(__file__).resolve().parent.parent / "examples"


def batching(repeat: int) -> Table:
    """Cost of a speed-step alone and batched, best of so many interleaved timings."""
    rich = next(setting for setting in settings() if setting.name == "half of the blades")
    casing = rich.problem.casing
    free = replace(
        rich.problem,
        loads=(),
        displacement_limit=OUT_OF_REACH,
        casing=replace(casing, clearance=OPENED * casing.clearance),
    )
    speeds = free.speed * np.linspace(0.95, 1.05, LANES)
    moving = rich.state.arrays.rotor, rich.state.arrays.casing

    def alone(record_every: int) -> tuple[CentralDifference, CentralDifferenceState]:
        problem = replace(free, speed=float(speeds[-1]))
        scheme = CentralDifference(problem, TIME_STEP, record_every)
        start = scheme.init()
        arrays = start.arrays._replace(rotor=moving[0], casing=moving[1])
        return scheme, replace(start, arrays=arrays)

    together = BatchedMarch(free, speeds, TIME_STEP, moving)
    together.advance(0, COMPARED_STEPS)
    scheme, state = alone(1)
    _, chunk, _ = scheme.advance(state, COMPARED_STEPS + 1)
    change = np.abs(chunk.gap[-1] - OPENED * casing.clearance[0, 0]).max()
    difference = np.abs(chunk.gap[-1] - together.gap[:, -1]).max() / change
    scheme, state = alone(RECORD_EVERY)
    times = [
        (
            microseconds(lambda steps: scheme.advance(state, steps), ALONE_STEPS),
            microseconds(lambda steps: together.advance(0, steps), BATCHED_STEPS) / LANES,
            microseconds(rich.kernel, ALONE_STEPS),
        )
        for _ in range(repeat)
    ]
    common, batched, contact = np.min(times, axis=0)
    table = Table(
        "a speed-step [µs]", "alone", f"{LANES} batched", "alone / batched", "gaps differ by",
        box=None,
    )  # fmt: skip
    for name, one, many, differ in (
        ("no contact", common, batched, f"{difference:.0e}"),
        (rich.name, contact, contact - common + batched, ""),
    ):
        table.add_row(name, f"{one:.2f}", f"{many:.2f}", f"{one / many:.2f}", differ)
    return table


def planned(duration: float, points: int) -> Plan:
    """A sweep of that many points, each marched for so long [s]."""
    case = read_case(EXAMPLES / "imbalance.toml", [f"march.duration={duration!r}"])
    speeds = [0.95 + 0.2 * point / points for point in range(points)]
    grid = make_grid(case, {"march.speed": speeds}, large=False)
    return plan_sweep(case, grid, histories=False)


class Cost(NamedTuple):
    """What a worker's points cost."""

    wall: float  #: [s]
    processor: float  #: mean of the workers [s]


def processor_time(work: Work, group: Group) -> float:
    """Time of the processor that a group takes [s]."""
    began = time.process_time()
    for outcome in march_group(work, group).values():
        if isinstance(outcome, Failure):
            raise RuntimeError(outcome.reason)
    return time.process_time() - began


def cost(client: Client, plan: Plan, workers: list[str], points: int) -> Cost:
    """What these workers take for so many points each, all of them the same ones."""
    work = Work(case=dumps_case(plan.case), layout=plan.layout, histories="")
    began = time.perf_counter()
    futures = []
    for place, worker in enumerate(workers):
        group = Group(
            number=place,
            points={point: plan.grid.values(point) for point in range(points)},
            history_names={},
        )
        futures.append(client.submit(processor_time, work, group, workers=worker, pure=False))
    used = client.gather(futures)
    return Cost(wall=time.perf_counter() - began, processor=sum(used) / len(used))


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--workers", type=int, default=CPU_COUNT)
    parser.add_argument("--points", type=int, default=2, help="of each worker in a turn")
    parser.add_argument("--duration", type=float, default=0.5, help="of each march [s]")
    parser.add_argument("--turns", type=int, default=3)
    parser.add_argument("--repeat", type=int, default=100, help="timings of the first table")
    given = parser.parse_args()
    Console().print(batching(given.repeat))
    plan = planned(given.duration, max(2, given.points))
    with (
        LocalCluster(
            n_workers=given.workers, threads_per_worker=1, dashboard_address=":0"
        ) as cluster,
        Client(cluster) as client,
    ):
        workers = list(client.scheduler_info(n_workers=-1)["workers"])
        cost(client, plan, workers, 1)  # compiles
        alone, together = [], []
        for _ in range(given.turns):
            alone.append(cost(client, plan, workers[:1], given.points))
            together.append(cost(client, plan, workers, given.points))
    scale = 1e6 / (given.points * plan.case.march.steps)
    table = Table(
        "per step of a worker [µs]", "alone", f"one of {given.workers}", "efficiency", box=None
    )
    for name in Cost._fields:
        one, many = (min(getattr(turn, name) for turn in turns) for turns in (alone, together))
        table.add_row(name, f"{scale * one:.3f}", f"{scale * many:.3f}", f"{one / many:.1%}")
    Console().print(table)


if __name__ == "__main__":
    main()
