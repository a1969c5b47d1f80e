"""Parallel efficiency of sweeps: `python benchmarks/sweep.py [--workers 2]`.

Worker processes march points of a sweep of the imbalance case, with speeds from 0.95 to 1.15 ω₁:
in each turn first one worker alone, then all workers at once. All workers march the same points, so
that no worker has more contact than another. The time per step includes the model and the analysis
of a point, not the start of the workers. The shortest time of all turns is printed. The efficiency
is the time with one worker divided by the time with all workers: 1 if workers do not slow each
other down. On a machine with other load, compare processor times instead of wall-clock times.
"""

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
from bladewhirl.models.inputs.machine import cores
from bladewhirl.studies.sweeps.axes import make_grid
from bladewhirl.studies.sweeps.plan import SweepPlan, plan_sweep
from bladewhirl.studies.sweeps.points import Failure, Point, Work, march_point

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"


def planned(duration: float, points: int) -> SweepPlan:
    """Return a sweep of a number of points, each marched for a duration [s]."""
    case = read_case(EXAMPLES / "imbalance.toml", [f"march.duration={duration!r}"])
    speeds = [0.95 + 0.2 * point / points for point in range(points)]
    grid = make_grid(case, {"march.speed": speeds}, large=False)
    return plan_sweep(case, grid)


class PointCost(NamedTuple):
    """Times that workers need for their points."""

    wall: float  #: wall-clock time until all workers have ended [s]
    processor: float  #: processor time, mean of the workers [s]


def processor_time(work: Work, points: list[Point]) -> float:
    """March points in this process; return the processor time [s]."""
    began = time.process_time()
    for point in points:
        outcome = march_point(work, point)
        if isinstance(outcome, Failure):
            raise RuntimeError(outcome.reason)
    return time.process_time() - began


def cost(pool: ProcessPoolExecutor, plan: SweepPlan, workers: int, points: int) -> PointCost:
    """Let a number of workers march, each of them all points; return the times of the workers."""
    work = Work(case=dumps_case(plan.case), layout=plan.layout, histories="")
    began = time.perf_counter()
    chosen = [Point(number=number, values=plan.grid.values(number)) for number in range(points)]
    used = list(pool.map(processor_time, [work] * workers, [chosen] * workers))
    return PointCost(wall=time.perf_counter() - began, processor=sum(used) / len(used))


def main() -> None:
    """Measure the times and print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--workers", type=int, default=cores())
    parser.add_argument("--points", type=int, default=2, help="points of each worker in a turn")
    parser.add_argument("--duration", type=float, default=0.5, help="duration of each march [s]")
    parser.add_argument("--turns", type=int, default=3)
    given = parser.parse_args()
    plan = planned(given.duration, max(2, given.points))
    context = get_context("spawn")
    with ProcessPoolExecutor(given.workers, mp_context=context) as pool:
        cost(pool, plan, given.workers, 1)  # not timed: imports
        alone, together = [], []
        for _ in range(given.turns):
            alone.append(cost(pool, plan, 1, given.points))
            together.append(cost(pool, plan, given.workers, given.points))
    scale = 1e6 / (given.points * plan.case.march.steps)
    table = Table(
        "per step of a worker [µs]", "alone", f"one of {given.workers}", "efficiency", box=None
    )
    for name in PointCost._fields:
        one, many = (min(getattr(turn, name) for turn in turns) for turns in (alone, together))
        table.add_row(name, f"{scale * one:.3f}", f"{scale * many:.3f}", f"{one / many:.1%}")
    Console().print(table)


if __name__ == "__main__":
    main()
