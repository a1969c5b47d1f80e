"""Periodic motions with joints from paths of loads, where Newton's method alone does not converge.

The motion at rest is known, and so is that without loads. From there a path of motions leads to
the whole loads: its points solve F(l, a) = 0 with the natural map F of `joints` and the share a of
the loads, which falls at folds, where contacts open or slip. As long as forces stay bounded, a path
from the only motion without loads cannot end or return before the loads are whole. On a finer grid
the path leads from the motion of the coarse one, with the forces l_0, by F(l) = (1 - a) F(l_0).

Pseudo-arclength: from a point, a step along the tangent, and Newton's method in the plane across
it. At a kink, where the states of nodes change, the path may turn back by more than a right angle;
the sign of the determinant of the equations with the tangent as their last row stays the same on
both sides and tells the way on.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
import scipy.linalg as la

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.joints.wheel import DIRECTIONS, JointedWheel
from bladewhirl.solvers.periodic.contact import NotConverged
from bladewhirl.solvers.periodic.joints import (
    EXACT,
    OPEN,
    REGULAR,
    SLIPPING,
    STUCK,
    JointGrid,
    JointMotion,
    common_order,
    solve,
    stuck,
)

FIRST_INSTANTS, LEAST_INSTANTS, MOST_INSTANTS = 64, 128, 512
"""Instants of the first grid, of a result, and of the finest grid, approximately."""
COMPARED = 2  #: number of harmonics of the forces of which two grids are compared
CONVERGED = 1e-2
"""Largest relative change of these harmonics with the last refinement; the error of the finer grid
is smaller."""
TOLERATED = 2e-2
"""The same for motions that have no finer ones; they tell their change."""
FIRST_STEP, SHORTEST = 0.05, 1e-5
"""First and shortest step along a path, relative to the loads and typical forces."""
SOLUTIONS = 20_000_000
"""Number of linear equations that may be solved on a path, times the square of the number of
instants."""
TRIES, QUICK = 8, 4
"""Newton steps after which a step is shortened, and below which the next one is longer."""
SHORTER, LONGER, BEYOND = 0.4, 1.6, 30.0
"""Factors of the steps, and first step after a kink relative to the shortest one."""
SHARP = 0.3  #: cosine of the angle between tangents from which on a step is shortened
TURNED = 0.9  #: cosine of the angle between the tangents at a kink
FAR = (1.0, 10.0, 100.0, 1000.0)  #: distances from a kink, relative to the shortest step
NEAR = 1e-8  #: largest error of a point of a path, relative to typical forces


class Point(NamedTuple):
    """Natural map at forces and a share of the way."""

    error: FloatArray  #: F divided by typical forces, (values,)
    by_force: FloatArray  #: its derivatives by the forces divided by the same, (values, values)
    by_share: FloatArray  #: its derivatives by the share, (values,)


@dataclass(frozen=True)
class Path:
    """Motions between a start and one with whole loads."""

    start: JointMotion
    loads: bool  #: the loads grow; otherwise the error of the start falls

    @cached_property
    def flexible(self) -> FloatArray:
        """Gaps and slips by all forces [m/N], (values, values)."""
        grid = self.start.grid
        lag = (np.arange(grid.instants)[:, None] - np.arange(grid.instants)) % grid.instants
        size = grid.instants * grid.wheel.values
        return np.asarray(grid.lagged[lag].transpose(0, 2, 1, 3).reshape(size, size))

    @cached_property
    def unloaded(self) -> FloatArray:
        """Displacements and slips without joint forces [m], (values,)."""
        free = replace(self.start, force=np.zeros_like(self.start.force))
        moved = free.displacement.copy()
        moved[:, self.start.grid.tangential] = free.slip
        return moved.ravel()

    @cached_property
    def soft(self) -> FloatArray:
        """Flexibilities of the natural map [m/N], (values,)."""
        return np.tile(self.start.grid.soft, self.start.grid.instants)

    @cached_property
    def size(self) -> float:
        """Typical force [N]."""
        typical = np.abs(self.unloaded).max() / np.median(self.soft)
        return float(typical + np.abs(self.start.force).max())

    @cached_property
    def first(self) -> FloatArray:
        """Natural map of the start, (values,)."""
        return self.at(self.start.force.ravel() / self.size, 1.0, whole=True).error

    def at(self, force: FloatArray, share: float, *, whole: bool = False) -> Point:
        """Return the natural map at forces relative to the typical one.

        Args:
            force: the forces, (values,).
            share: share of the way.
            whole: with the whole loads, and without the error of the start.
        """
        soft, grid = self.soft, self.start.grid
        count = grid.instants * len(grid.wheel.joint)
        friction = np.tile(grid.wheel.friction, grid.instants)
        given = np.zeros((grid.instants, grid.wheel.values))
        given[:, ::DIRECTIONS] = grid.wheel.gap
        moved = given.ravel() + (share if self.loads and not whole else 1.0) * self.unloaded
        trial = force - (moved / self.size + self.flexible @ force) / soft
        pressure, tau = trial[::DIRECTIONS], trial.reshape(count, DIRECTIONS)[:, 1:]
        length = np.linalg.norm(tau, axis=1)
        limit = friction * np.maximum(pressure, 0.0)
        states = np.where(pressure > 0.0, np.where(length > limit, SLIPPING, STUCK), OPEN)
        way = tau / np.where(length > 0.0, length, 1.0)[:, None]
        held = np.where(states == SLIPPING, limit / np.where(length > 0.0, length, 1.0), 1.0)
        kept = np.zeros((count, DIRECTIONS))  # what the law leaves of the trial forces
        kept[:, 0] = np.maximum(pressure, 0.0)
        kept[:, 1:] = np.where((states != OPEN)[:, None], held[:, None] * tau, 0.0)
        law = np.zeros((count, DIRECTIONS, DIRECTIONS))  # its derivatives
        law[states != OPEN] = np.eye(DIRECTIONS)
        slips = np.flatnonzero(states == SLIPPING)
        law[slips, 1:, 0] = friction[slips, None] * way[slips]
        across = np.eye(2) - way[slips, :, None] * way[slips, None]
        law[slips, 1:, 1:] = held[slips, None, None] * across
        relative = (self.flexible / soft[:, None]).reshape(count, DIRECTIONS, -1)
        matrix = (law @ relative).reshape(self.flexible.shape)
        each = DIRECTIONS * np.arange(count)
        for a in range(DIRECTIONS):
            for b in range(DIRECTIONS):
                matrix[each + a, each + b] += float(a == b) - law[:, a, b]
        matrix[np.diag_indices(len(matrix))] += REGULAR * np.repeat(states == STUCK, DIRECTIONS)
        error = force - kept.ravel()
        if whole:
            return Point(error, matrix, np.zeros_like(error))
        if not self.loads:
            return Point(error - (1.0 - share) * self.first, matrix, self.first)
        by_load = (self.unloaded / soft / self.size).reshape(count, DIRECTIONS, 1)
        return Point(error, matrix, (law @ by_load).ravel())

    def end(self) -> JointMotion:
        """Return the motion at the end of the path.

        Raises:
            NotConverged: it was not reached.
        """
        grid, spread = self.start.grid, np.sqrt(self.start.force.size)
        left = SOLUTIONS // grid.instants**2

        def at(place: FloatArray) -> Point:
            nonlocal left
            left -= 1
            found = self.at(place[:-1] * spread, float(place[-1]))
            return found._replace(by_force=found.by_force * spread)

        place = np.append(self.start.force.ravel() / self.size / spread, 0.0)
        along = np.zeros_like(place)
        along[-1] = 1.0
        along, sign = _tangent(_bordered(at(place), along))
        step = FIRST_STEP

        def ahead(point: Point) -> FloatArray:
            found, side = _tangent(_bordered(point, along))
            return found if side == sign else -found

        while left > 0:
            reached, point, tries = place + step * along, None, 0
            for tries in range(TRIES):
                point = at(reached)
                if tries and np.abs(point.error).max() < NEAR:
                    break
                off = np.append(point.error, along @ (reached - place) - step)
                reached = reached - np.linalg.solve(_bordered(point, along), off)
            else:
                step *= SHORTER
                if step < SHORTEST:
                    along, step = _turned(place, along, at, ahead), BEYOND * SHORTEST
                continue
            assert point is not None
            after = ahead(point)
            if after @ along < SHARP and step > FAR[-2] * SHORTEST:
                step *= SHORTER
                continue
            if place[-1] < 1.0 <= reached[-1]:
                share = (1.0 - place[-1]) / (reached[-1] - place[-1])
                force = self.size * spread * (place + share * (reached - place))[:-1]
                try:
                    return solve(replace(self.start, force=force.reshape(self.start.force.shape)))
                except NotConverged:
                    step *= SHORTER
                    if step > SHORTEST:
                        continue
                    raise
            place, along = reached, after
            step *= LONGER if tries <= QUICK else 1.0
        raise NotConverged(
            f"Newton's method did not converge with {grid.instants} instants, and the path of"
            " growing loads is too long; joints can have several motions here, and jump"
        )


def _bordered(point: Point, along: FloatArray) -> FloatArray:
    """Return the derivatives of a point, and a direction as the last row."""
    return np.block([[point.by_force, point.by_share[:, None]], [along[None]]])


def _tangent(matrix: FloatArray) -> tuple[FloatArray, float]:
    """Return the direction in which all but the last row of bordered equations vanish, and the sign
    of their determinant with this direction as the last row, which is that with the given row."""
    factors, swaps = la.lu_factor(matrix)
    unit = np.zeros(len(matrix))
    unit[-1] = 1.0
    found = la.lu_solve((factors, swaps), unit)
    odd = np.count_nonzero(swaps != np.arange(len(swaps))) % 2
    sign = np.prod(np.sign(np.diag(factors))) * (-1.0 if odd else 1.0)
    return np.asarray(found / np.linalg.norm(found)), float(sign)


def _turned(
    place: FloatArray,
    along: FloatArray,
    at: Callable[[FloatArray], Point],
    ahead: Callable[[Point], FloatArray],
) -> FloatArray:
    """Return the direction of a path beyond a kink near a place.

    Raises:
        NotConverged: there is no kink.
    """
    for far in FAR:
        for side in (1.0, -1.0):
            found = ahead(at(place + side * far * SHORTEST * along))
            if found @ along < TURNED:
                return found
    raise NotConverged("the path of growing loads ends; joints can have several motions here")


def joint_motion(wheel: JointedWheel, start: JointMotion | None = None) -> JointMotion:
    """Return a periodic motion on so many instants that the forces have converged.

    Newton's method begins on a coarse grid with the start, with closed joints without slip, and
    with open ones; then a path of growing loads is followed.

    Args:
        wheel: the wheel with joints.
        start: a motion near it, as at another speed; None: none is known.

    Raises:
        NotConverged: no motion was found.
    """
    highest = max(wheel.orders) // common_order(wheel)
    grid = JointGrid.near(wheel, max(FIRST_INSTANTS, int(EXACT) * highest))
    missed = NotConverged("no attempt")
    for way in _ways(grid, start):
        try:
            return _refined(way())
        except NotConverged as reason:
            missed = reason
    raise missed


def _ways(grid: JointGrid, start: JointMotion | None) -> Iterator[Callable[[], JointMotion]]:
    """Yield methods that may find a motion on a grid."""
    if start is not None:
        yield lambda: solve(start.on(grid))
    yield lambda: stuck(grid)
    yield lambda: solve(JointMotion(grid, np.zeros_like(grid.free)))
    yield lambda: Path(JointMotion.at_rest(grid), loads=True).end()
    if start is not None:
        yield lambda: Path(start.on(grid), loads=False).end()
    finer = JointGrid.near(grid.wheel, 2 * grid.instants)
    yield lambda: Path(JointMotion.at_rest(finer), loads=True).end()


def _refined(motion: JointMotion) -> JointMotion:
    """Return a motion on so many instants that the forces have converged.

    Raises:
        NotConverged: there is no such motion on finer grids, or the forces still change.
    """
    while True:
        grid = JointGrid.near(motion.grid.wheel, 2 * motion.grid.instants)
        try:
            if grid.instants > 2 * MOST_INSTANTS:
                raise NotConverged("the forces still change with the finest grid")
            finer = _finer(motion, grid)
        except NotConverged:
            if motion.change <= TOLERATED and motion.grid.instants >= LEAST_INSTANTS:
                return motion
            raise
        one, other = (each.harmonics[:COMPARED] for each in (motion, finer))
        size = float(np.linalg.norm(other))
        change = float(np.linalg.norm(other - one)) / size if size > 0.0 else 0.0
        motion = replace(finer, change=change)
        if change <= CONVERGED and grid.instants >= LEAST_INSTANTS:
            return motion


def _finer(motion: JointMotion, grid: JointGrid) -> JointMotion:
    """Return the motion on a finer grid.

    Raises:
        NotConverged: there is no such motion.
    """
    try:
        return solve(motion.on(grid))
    except NotConverged:
        return Path(motion.on(grid), loads=False).end()
