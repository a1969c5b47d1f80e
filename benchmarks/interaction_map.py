"""The interaction map of casing distortion: `python benchmarks/interaction_map.py`.

Marches `examples/casing_distortion.toml` at 211 speeds from 0.95 to 2.0 for 3 s in steps of 1 µs,
as a user's `bladewhirl sweep` does, with its figures. Printed are the time that it takes and the
cost of a step of one speed on one core, all that a point costs counted. Beside that stands the
same march in NumPy (`Reference`), timed over short stretches of the map's own motions: points
evenly spread over those that were marched, each at the middle and the end of what it marched. Its
time for the whole map is extrapolated from there, with as many cores that don't slow each other
down.

`--points` and `--duration` shorten the map.
"""

from __future__ import annotations

import argparse
import time
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import xarray as xr
from dask.system import CPU_COUNT
from march import TIME_STEP, Setting, microseconds
from rich.console import Console
from rich.table import Table

from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import read_case, with_values
from bladewhirl.models.stage.build import contact_problem
from bladewhirl.postprocess.sweep.dataset import open_sweep
from bladewhirl.solvers.march.central_difference import CentralDifference
from bladewhirl.studies.sweeps.points import stage_at
from bladewhirl.studies.sweeps.sweep import Watch, run_sweep

EXAMPLE = Path(__file__).resolve().parent.parent / "examples" / "casing_distortion.toml"
FIRST, LAST, POINTS = 0.95, 2.0, 211
SAMPLES = 4
"""Points whose motions NumPy is timed on."""

MOST_STEPS = 400_000
"""Steps that the kernel does at most to come to a stretch for NumPy."""

RECORD_EVERY, STRETCH = 100, 300


def numpy_cost(case: Case, sweep: xr.Dataset) -> float:
    """Mean cost of a step in NumPy over stretches of the sweep's motions [µs]."""
    done = np.flatnonzero((sweep["state"] == "done").values)
    costs = []
    for point in done[np.linspace(0, len(done) - 1, min(SAMPLES, len(done))).round().astype(int)]:
        one = sweep.isel(march_speed=int(point))
        at_speed = with_values(case, {"march.speed": float(one["march_speed"])})
        problem = contact_problem(stage_at(at_speed))
        scheme = CentralDifference(problem, TIME_STEP, RECORD_EVERY)
        state = scheme.init()
        half = min(int(one["steps"]) - STRETCH, MOST_STEPS) // (2 * RECORD_EVERY) * RECORD_EVERY
        for _ in range(2):
            state, _, _ = scheme.advance(state, half)
            setting = Setting(name="", problem=problem, scheme=scheme, state=state)
            plain, begin = setting.numpy()
            costs.append(microseconds(partial(plain.advance, begin), STRETCH))
    return float(np.mean(costs))


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--points", type=int, default=POINTS)
    parser.add_argument("--duration", type=float, default=3.0, help="of each march [s]")
    parser.add_argument("--workers", type=int, default=CPU_COUNT)
    parser.add_argument("-o", "--output", type=Path, help="folder to keep the sweep in")
    given = parser.parse_args()
    case = read_case(EXAMPLE, [f"march.duration={given.duration!r}"])
    if case.march.time_step != TIME_STEP:
        raise SystemExit(f"{EXAMPLE}: expected steps of {TIME_STEP:g} s")
    speeds = np.linspace(FIRST, LAST, given.points).round(6).tolist()
    console = Console(stderr=True)

    def progress(done: int, failed: int, points: int) -> None:
        console.print(f"\r{done + failed} of {points}", end="", highlight=False)

    with TemporaryDirectory() as scratch:
        folder = given.output or Path(scratch) / "map"
        began = time.perf_counter()
        swept = run_sweep(
            case,
            {"march.speed": speeds},
            folder,
            workers=given.workers,
            watch=Watch(progress=progress),
        )
        wall = time.perf_counter() - began
        console.print()
        with open_sweep(folder) as sweep:
            steps = float(sweep["steps"].where(sweep["state"] == "done").sum())
            regimes, counts = np.unique(sweep["regime"].values, return_counts=True)
            plain = numpy_cost(case, sweep)
    cores = min(given.workers, swept.points)
    ours = 1e6 * wall * cores / steps
    table = Table(show_header=False, box=None)
    for name, value in {
        "points": f"{swept.points}, {swept.done} done, {swept.failed} failed",
        "regimes": ", ".join(f"{n} {name}" for name, n in zip(regimes, counts, strict=True)),
        "marches": f"{given.duration:g} s in steps of {TIME_STEP:g} s; {steps:.4g} steps done",
        "wall time": f"{wall:.1f} s on {cores} cores, {wall / 60:.1f} minutes",
        "a speed-step": f"{ours:.2f} µs of a core",
        "the same in NumPy": f"{plain:.1f} µs, {plain * steps / cores / 3.6e9:.2f} h for the map",
        "NumPy / bladewhirl": f"{plain / ours:.1f}",
    }.items():
        table.add_row(name, value)
    Console().print(table)


if __name__ == "__main__":
    main()
