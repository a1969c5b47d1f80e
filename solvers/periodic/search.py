"""Search for a periodic motion: on a coarse grid first, from the motion without contact."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from bladewhirl.solvers.periodic.blade import Blade, Grid
from bladewhirl.solvers.periodic.contact import Motion, NotConverged, relaxed, solve
from bladewhirl.solvers.periodic.continuation import Continuation

FIRST_INSTANTS, LEAST_INSTANTS, MOST_INSTANTS = 64, 512, 4096
"""Instants of the first grid, of a result, and of the finest grid, in a period of the wall."""
FINE_INSTANTS = 1024
"""Least instants of a motion in contact: with 512, multipliers can be wrong by 0.008."""
IMPULSE_ERROR = 1e-3
"""Change of the impulse with the last refinement; the error of the finer grid is smaller."""
MOST_POINTS = 500  #: largest number of points of a branch to a motion
LONGEST = 0.2  #: longest step on such a branch
FOLLOWED, FEW_POINTS = 1024, 40
"""Most instants and points of a branch that leads from a coarser grid."""


def periodic_motion(blade: Blade, start: Motion | None = None) -> Motion:
    """Return a periodic motion on so many instants that the impulse has converged.

    Coarse grids can have motions that finer grids do not have, and each method can fail on one grid
    only. The grid is therefore refined until two in turn agree, and several ways lead to a motion
    on a coarse grid: Newton's method, an interior-point method, and at last a branch along which
    the wall moves in.

    Args:
        blade: the structure in its wall.
        start: where Newton's method begins; None: the motion without contact.

    Raises:
        NotConverged: no motion was found; the reason is that of the last attempt.
    """
    grid, missed = Grid(blade, FIRST_INSTANTS * _finer(blade)), NotConverged("no attempt")
    begin = Motion.free(grid) if start is None else start.on(grid)
    ways: list[Callable[[], Motion]] = [
        lambda: solve(begin),
        lambda: solve(relaxed(begin)),
        lambda: by_clearance(grid),
        lambda: by_clearance(grid.finer()),
    ]
    for way in ways:
        try:
            return refined(way())
        except NotConverged as reason:
            missed = reason
    raise missed


def refined(motion: Motion) -> Motion:
    """Return a motion on so many instants that the impulse has converged.

    Raises:
        NotConverged: on finer grids there is no such motion, or the impulse still changes.
    """
    if not motion.touches:
        return motion
    missed, grid = "on finer grids Newton's method does not converge", motion.grid
    finer_by = _finer(grid.blade)
    while (grid := grid.finer()).instants <= MOST_INSTANTS * finer_by:
        try:
            finer = prolonged(motion.on(grid))
        except NotConverged:
            continue
        error = abs(finer.impulse - motion.impulse)
        motion = finer
        if grid.instants >= FINE_INSTANTS * finer_by and error <= IMPULSE_ERROR * motion.impulse:
            return motion
        missed = (
            f"with {grid.instants} instants the impulse still changes by"
            f" {error / motion.impulse:.2%}"
        )
    raise NotConverged(missed)


def _finer(blade: Blade) -> int:
    """Return the factor of the instants of a motion with several periods of the wall: a power of
    two."""
    return 1 << (blade.periods - 1).bit_length()


def prolonged(guess: Motion) -> Motion:
    """Return the periodic motion near a guess from a coarser grid, if necessary by a branch.

    It begins at the wall that the guess touches with its forces, which moves to its own place.

    Raises:
        NotConverged: no motion was found.
    """
    try:
        return solve(guess)
    except NotConverged:
        if guess.grid.instants > FOLLOWED:
            raise
    pressed = guess.normal > 0.0
    moved_out = np.where(pressed, -guess.gap, np.maximum(0.0, -guess.gap))
    branch = Continuation(lambda share, _: (guess.grid, share * moved_out), 1.0)
    return _to_zero(branch, replace(guess, offset=moved_out), 1.0, FEW_POINTS)


def by_clearance(grid: Grid) -> Motion:
    """Return a periodic motion to which a branch leads along which the wall moves in, from the
    motion that just touches it.

    Raises:
        NotConverged: the branch does not lead to the place of the wall.
    """
    outward = -float(grid.free_gap.min())
    if outward <= 0.0:
        return Motion.free(grid)
    branch = Continuation(lambda offset, _: (grid, offset), outward)
    return _to_zero(branch, Motion.free(grid, outward), outward, MOST_POINTS)


def _to_zero(branch: Continuation, start: Motion, parameter: float, most: int) -> Motion:
    """Return the motion at which a parameter becomes zero on the branch of a motion, which has at
    most so many points.

    Raises:
        NotConverged: the branch does not lead to it.
    """
    before = branch.begin(start, parameter, -1.0)
    for _, point in zip(range(most), branch.follow(before, LONGEST, LONGEST), strict=False):
        if point.parameter <= 0.0:
            return branch.landed(before, point, 0.0).motion
        before = point
    raise NotConverged("no branch leads from the motion without contact to the place of the wall")
