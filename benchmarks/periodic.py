"""Computing time of a branch of periodic motions: `python benchmarks/periodic.py`.

A twisted blade with 7 contact nodes and 30 modes in an oval wall is followed from 0.80 times the
speed of a resonance on, over 143 points with 256 instants, on one core; the second time with
multipliers. Two contact nodes are inserted between those of the example. The branch has corners, so
that the number of Newton steps, and the part of the way that 143 points lead, depend on details;
the time of a Newton step is printed too.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import sys
import time
from dataclasses import replace
from functools import lru_cache
from itertools import islice
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests" / "support"))
from periodic_cases import case

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.stage.build import build_stage, contact_problem
from bladewhirl.solvers.periodic.bifurcation import multipliers
from bladewhirl.solvers.periodic.blade import Blade, Grid, between
from bladewhirl.solvers.periodic.continuation import Continuation, Point
from bladewhirl.solvers.periodic.search import periodic_motion, prolonged

POINTS, INSTANTS, NODES = 143, 256, 7
START, STOP = 5268.0, 8890.0  # rpm: 0.80 and 1.35 times a resonance with engine order 4
STEP = 0.1


def blade_at(rpm: float) -> Blade:
    """Return the blade with 7 contact nodes at a speed."""
    changes = {
        "march.speed": f"{rpm} rpm",
        "reduction.free_interface_modes": 30,
        "damping.ratio": 0.02,
    }
    blade = Blade.of_problem(contact_problem(build_stage(case(**changes))))
    old, new = np.arange(float(blade.nodes)), np.linspace(0.0, blade.nodes - 1.0, NODES)
    weights = np.stack([np.interp(new, old, row) for row in np.eye(blade.nodes)], axis=1)

    def at_new(values: FloatArray) -> FloatArray:
        return weights @ values

    wide = np.kron(weights, np.eye(3))
    own = 0.15 * np.diag(blade.compliance).mean() * np.eye(3 * NODES)
    return replace(
        blade,
        contact=wide @ blade.contact,
        compliance=wide @ blade.compliance @ wide.T + own,
        angle=at_new(blade.angle),
        radius=at_new(blade.radius),
        recess=at_new(blade.recess),
        normal_part=at_new(blade.normal_part),
    )


def main() -> None:
    """Follow the branch twice and print times."""
    ends = blade_at(START), blade_at(STOP)

    @lru_cache(maxsize=8)
    def grid(rpm: float, instants: int) -> Grid:
        return Grid(between(*ends, (rpm - START) / (STOP - START)), instants)

    first = prolonged(periodic_motion(ends[0]).on(grid(START, INSTANTS)))
    branch = Continuation(lambda rpm, instants: (grid(rpm, instants), 0.0), 25.5 / STEP)
    begin = branch.begin(first, START, 1.0)

    def follow(with_multipliers: bool) -> tuple[float, list[Point]]:
        grid.cache_clear()
        started, points = time.process_time(), []
        for point in islice(branch.follow(begin, STEP, STEP), POINTS):
            points.append(point)
            if with_multipliers:
                multipliers(point)
        return time.process_time() - started, points

    for with_multipliers in (False, True):
        spent, points = follow(with_multipliers)
        steps = sum(point.steps for point in points)
        print(
            f"{POINTS} points {'with' if with_multipliers else 'without'} multipliers:"
            f" {spent:.1f} s, to {points[-1].parameter:.0f} rpm, {steps} Newton steps,"
            f" {1e3 * spent / steps:.1f} ms each"
        )


if __name__ == "__main__":
    main()
