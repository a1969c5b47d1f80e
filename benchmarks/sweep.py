"""Speed-up of sweeps by cores: `python benchmarks/sweep.py [--workers 2]`.

Points of a sweep of the imbalance case, between 0.95 and 1.15, are marched by the processes as
`bladewhirl sweep` uses: one of them alone, then all at a time, in turn, in one session. Each turn
gives every working process the same points, so that none waits for one with more contact. What is
timed is all that a point costs (stage, march, analysis), per step of its march; starting workers
and compiling is not. The best turn counts. The efficiency is the time that a worker takes alone
over the time that it takes beside the others: 1 where they don't slow each other down. On a machine
with other work the same ratio of processor times tells how far it is the workers that are in each
other's way.
"""

from __future__ import annotations

import argparse
import time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import NamedTuple

from rich.console import Console
from rich.table import Table

from bladewhirl.models.case.file import read_case
from bladewhirl.models.case.template import dumps_case
from bladewhirl.studies.sweeps.axes import make_grid
from bladewhirl.studies.sweeps.plan import Plan, plan_sweep
from bladewhirl.studies.sweeps.points import Failure, Point, Work, march_point
from bladewhirl.studies.sweeps.workers import cores

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"


def planned(duration: float, points: int) -> Plan:
    """A sweep of that many points, each marched for so long [s]."""
    case = read_case(EXAMPLES / "imbalance.toml", [f"march.duration={duration!r}"])
    speeds = [0.95 + 0.2 * point / points for point in range(points)]
    grid = make_grid(case, {"march.speed": speeds}, large=False)
    return plan_sweep(case, grid, histories=False)


class Cost(NamedTuple):
    """Cost of the points of a worker."""

    wall: float  #: [s]
    processor: float  #: mean of the workers [s]


def processor_time(work: Work, points: list[Point]) -> float:
    """Return the processor time of points [s]."""
    began = time.process_time()
    for point in points:
        outcome = march_point(work, point)
        if isinstance(outcome, Failure):
            raise RuntimeError(outcome.reason)
    return time.process_time() - began


def cost(pool: ProcessPoolExecutor, plan: Plan, workers: int, points: int) -> Cost:
    """Return the times of a number of workers for the same points each."""
    work = Work(case=dumps_case(plan.case), layout=plan.layout, histories="")
    began = time.perf_counter()
    chosen = [Point(number=number, values=plan.grid.values(number)) for number in range(points)]
    used = list(pool.map(processor_time, [work] * workers, [chosen] * workers))
    return Cost(wall=time.perf_counter() - began, processor=sum(used) / len(used))


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--workers", type=int, default=cores())
    parser.add_argument("--points", type=int, default=2, help="of each worker in a turn")
    parser.add_argument("--duration", type=float, default=0.5, help="of each march [s]")
    parser.add_argument("--turns", type=int, default=3)
    given = parser.parse_args()
    plan = planned(given.duration, max(2, given.points))
    context = get_context("spawn")
    with ProcessPoolExecutor(given.workers, mp_context=context) as pool:
        cost(pool, plan, given.workers, 1)  # imports
        alone, together = [], []
        for _ in range(given.turns):
            alone.append(cost(pool, plan, 1, given.points))
            together.append(cost(pool, plan, given.workers, given.points))
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
