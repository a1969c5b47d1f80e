"""Search of periodic motions with joints: Newton's method, growing loads, and refinement.

Newton's method for the equations of `joints` begins with a motion nearby, or with that of a smooth
law under growing loads: at rest the motion is known, and a branch of motions leads from there to
the whole loads, also where the loads fall along it for a while, see `arclength`. The smoothing then
falls until Newton's method finds the motion of the true law. It begins with few harmonics, which
are doubled until amplitude and work have converged.

Motions in which joints lift off under light damping can depend on the number of harmonics, or be
unstable; with more harmonics, there may be none nearby. The motion with the most harmonics is then
the result, and `change` tells how much the last refinement changed it; without any refinement, how
much it differs from the motion with half as many harmonics.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.models.joints.wheel import DIRECTIONS, JointedWheel
from bladewhirl.solvers.periodic import joint_law
from bladewhirl.solvers.periodic.arclength import Branch, Equations, follow
from bladewhirl.solvers.periodic.contact import NotConverged
from bladewhirl.solvers.periodic.joints import JointGrid, JointMotion, common_order

ROUGH = 16  #: harmonics of a rough motion, for each engine order
FIRST, SEARCHED, MOST, MISSED = 8, 48, 128, 2
"""Harmonics with which the search begins, up to which it may begin anew, and the most, for each
engine order relative to their common divisor; numbers of harmonics without a motion after which the
refinement ends."""
CONVERGED, WORK_CONVERGED = 1e-3, 5e-3
"""Largest change of forces and displacements of the engine orders, and of the work, with the last
refinement, relative to themselves."""
STEPS, CLOSE = 15, 1e-11
"""Largest number of Newton steps, and largest error at their end, relative to typical forces."""
STALLED, PROGRESS = 4, 0.8
"""Number of Newton steps that have to reduce the least error so far, and by which factor."""
HALVINGS, DESCENT = 6, 0.1
"""Largest number of halvings of a Newton step, and the least share of its decrease."""
SMOOTH, SHARPEST = (0.02, 0.1), 1e-6
"""Smoothings of the law that are tried in turn, and the least one, relative to typical forces."""
FALL, SLOWEST = 0.25, 0.95
"""Least and largest factor from a smoothing to the next one."""
PATH_STEPS, LONGEST, SHORT, NEAR = 150, 0.3, 0.05, 1e-4
"""Largest number of points of a branch of loads, its longest and first steps, and the largest error
of a point, relative to the forces."""
FARTHEST, NUDGE = 0.1, 1e-7
"""Longest step of a branch over a parameter, relative to the forces, and the change of the share of
its range for derivatives."""
ROUNDED = 1e-2  #: smoothing of the law along it, relative to the forces at its start
LEAST = 0.1  #: least size of forces in lengths along a branch, relative to those at its start


def _errors(motion: JointMotion, smooth: float, share: float) -> tuple[FloatArray, FloatArray]:
    """Return the errors of the coefficients of forces [N], (2 H + 1, values), and the derivatives
    of the law at the instants, (instants, nodes, 3, 3)."""
    grid = motion.grid
    trial = (grid.series @ motion.trial(share)).reshape(grid.instants, -1, DIRECTIONS)
    law = joint_law.projected(trial, grid.wheel.friction, smooth)
    return motion.forces - grid.to_coefficients @ law.force.reshape(grid.instants, -1), law.slope


def _matrix(grid: JointGrid, slope: FloatArray) -> FloatArray:
    """Return the derivatives of the errors by the coefficients of forces, (unknowns, unknowns),
    from those of the law.

    The harmonic h of the forces follows from the harmonics h - k and h + k of the derivatives of
    the law and from the harmonic k of the trial forces and its conjugate.
    """
    count, values = grid.harmonics + 1, grid.wheel.values
    spectrum = -np.fft.fft(slope, axis=0) / len(slope)
    every = np.arange(2 * count - 1)
    less, more = (
        sliding_window_view(spectrum[each % len(slope)], count, axis=0)
        for each in (every - grid.harmonics, every)
    )
    less, more = (each.transpose(1, 0, 3, 4, 2) for each in (less[::-1], more))
    found = np.zeros((count, 2, values, count, 2, values))  # columns in the first axes
    for node, (down, up) in enumerate(zip(less, more, strict=True)):
        own = slice(DIRECTIONS * node, DIRECTIONS * (node + 1))
        np.add(down.real, up.real, out=found[:, 0, own, :, 0, own])
        np.add(down.imag, up.imag, out=found[:, 0, own, :, 1, own])
        np.subtract(up.imag, down.imag, out=found[:, 1, own, :, 0, own])
        np.subtract(down.real, up.real, out=found[:, 1, own, :, 1, own])
    found[:, :, :, 0] *= 0.5
    by_trial = found.reshape(count, 2 * values, -1)
    columns = (grid.to_trial.swapaxes(1, 2) @ by_trial).reshape(-1, by_trial.shape[2])
    columns[values : 2 * values] = columns[:values]  # the mean has no imaginary part
    columns[:, values : 2 * values] = columns[:, :values]
    matrix = columns[values:, values:].T
    matrix[np.diag_indices(len(matrix))] += 1.0
    matrix[:values, :values] -= grid.balance.share
    return matrix


def _by_share(grid: JointGrid, slope: FloatArray) -> FloatArray:
    """Return the derivatives of the errors by the share of the engine orders, (unknowns,)."""
    trial = (grid.series @ grid.load).reshape(grid.instants, -1, DIRECTIONS, 1)
    return np.asarray(-(grid.to_coefficients @ (slope @ trial).reshape(grid.instants, -1)).ravel())


def solve(start: JointMotion, smooth: float = 0.0) -> JointMotion:
    """Return the periodic motion to which Newton's method leads.

    Args:
        start: where it begins.
        smooth: smoothing of the law [N]; 0: the true law.

    Raises:
        NotConverged: no motion was found.
    """
    motion, (error, slope) = start, _errors(start, smooth, 1.0)
    sizes = list[float]()
    for _ in range(STEPS):
        size = float(np.linalg.norm(error))
        if size <= CLOSE * (start.grid.size + np.abs(motion.forces - error).max()):
            return motion
        sizes.append(size)
        if min(sizes) > PROGRESS * min(sizes[:-STALLED], default=np.inf):
            break
        try:
            change = np.linalg.solve(_matrix(start.grid, slope), error.ravel())
            change = change.reshape(error.shape)
        except np.linalg.LinAlgError:
            break
        length = 2.0
        for _ in range(HALVINGS):
            length *= 0.5
            after = replace(motion, parts=motion.parts - length * change)
            error, slope = _errors(after, smooth, 1.0)
            if np.linalg.norm(error) <= (1.0 - DESCENT * length) * size:
                break
        motion = after
    raise NotConverged(
        f"Newton's method did not converge with {start.grid.harmonics} harmonics; joints can have"
        " several motions here, and jump"
    )


def loaded(grid: JointGrid, smooth: float) -> JointMotion:
    """Return the motion to which growing loads lead with a smoothing relative to typical forces.

    Raises:
        NotConverged: no motion was found.
    """
    rest = JointMotion.at_rest(grid)

    def at(forces: FloatArray, share: float) -> Equations:
        error, slope = _errors(_with(rest, forces), smooth * grid.size, share)
        by_share = _by_share(grid, slope) / grid.size
        return Equations(error.ravel() / grid.size, _matrix(grid, slope), by_share)

    branch = Branch(at, near=NEAR)
    before = branch.begin(rest.parts.ravel() / grid.size, 0.0, 1.0)
    points = follow(before, branch.ahead, LONGEST, SHORT)
    for _, (point, _) in zip(range(PATH_STEPS), points, strict=False):
        if point.parameter >= 1.0:
            return sharpened(_with(rest, branch.landed(before, point, 1.0).unknowns), smooth)
        before = point
    raise NotConverged(
        f"the branch of motions with {grid.harmonics} harmonics under growing loads is too long;"
        " joints can have several motions here, and jump"
    )


def _with(motion: JointMotion, forces: FloatArray) -> JointMotion:
    """Return a motion with forces relative to typical ones, (unknowns,)."""
    return replace(motion, parts=(forces * motion.grid.size).reshape(motion.parts.shape))


def sharpened(motion: JointMotion, smooth: float) -> JointMotion:
    """Return the motion to which one of a law with a smoothing leads while the smoothing falls.

    Raises:
        NotConverged: no motion was found.
    """
    factor = FALL
    while True:
        try:
            return solve(motion)
        except NotConverged:
            if smooth < SHARPEST:
                raise
        while True:
            try:
                motion = solve(motion, factor * smooth * motion.grid.size)
            except NotConverged:
                factor **= 0.5
                if factor > SLOWEST:
                    raise
                continue
            smooth, factor = factor * smooth, max(FALL, factor**1.5)
            break


def joint_motion(
    wheel: JointedWheel, start: JointMotion | None = None, *, thorough: bool = True
) -> JointMotion:
    """Return a periodic motion with so many harmonics that forces and work have converged.

    Args:
        wheel: the wheel with joints.
        start: a motion near it, as at another speed; None: none is known.
        thorough: whether motions with more harmonics are sought through smooth laws, too.

    Raises:
        NotConverged: no motion was found.
    """
    unit = max(wheel.main_orders) // common_order(wheel)
    motion = _first(JointGrid(wheel, FIRST * unit), start)
    highest, missed = 2 * motion.grid.harmonics, 0
    while highest <= MOST * unit:
        grid = JointGrid(wheel, highest)
        try:
            finer = _refined(motion, grid, anew=thorough and highest <= SEARCHED * unit)
        except NotConverged:
            highest, missed = highest + highest // 4, missed + 1
            if missed > MISSED:
                break
            continue
        moved, worked = _changes(motion, finer)
        motion, highest = replace(finer, change=max(moved, worked)), 2 * highest
        if moved <= CONVERGED and worked <= WORK_CONVERGED:
            break
    return motion if np.isfinite(motion.change) else _compared(motion)


def rough_motion(wheel: JointedWheel, start: JointMotion | None = None) -> JointMotion:
    """Return a periodic motion with `ROUGH` harmonics, or `FIRST` ones if it is found with these
    alone, for searches over many wheels; see `joint_motion`.

    Raises:
        NotConverged: no motion was found.
    """
    unit = max(wheel.orders) // common_order(wheel)
    coarse, fine = (JointGrid(wheel, count * unit) for count in (FIRST, ROUGH))
    near = [] if start is None else [start.on(fine), start.on(coarse)]
    ways: list[Callable[[], JointMotion]] = [partial(solve, each) for each in near]
    return _first_of([*ways, *(partial(loaded, coarse, smooth) for smooth in SMOOTH)])


def _compared(motion: JointMotion) -> JointMotion:
    """Return a motion with the change from half as many harmonics, if there is such a motion."""
    grid = JointGrid(motion.grid.wheel, motion.grid.harmonics // 2)
    try:
        return replace(motion, change=max(_changes(_refined(motion, grid, anew=True), motion)))
    except NotConverged:
        return motion


def _changes(coarse: JointMotion, fine: JointMotion) -> tuple[float, float]:
    """Return the relative changes of forces and displacements, and of the work of joints."""
    pairs = zip(*map(_loaded, (coarse, fine)), strict=True)
    joints = np.resize(fine.grid.wheel.radius == 0.0, len(fine.work))
    return max(_relative(*pair) for pair in pairs), _relative(
        coarse.work[joints], fine.work[joints]
    )


def _loaded(motion: JointMotion) -> tuple[ComplexArray, ComplexArray]:
    """Return the amplitudes of the engine orders of forces (orders, values) and of displacements of
    points (orders, points, 3); with a wall also those of its main order, and the means."""
    wheel = motion.grid.wheel
    orders = [*([0] if wheel.rubs and 0 not in wheel.orders else []), *wheel.main_orders]
    forces = np.stack([motion.of_order(order) for order in orders])
    pairs = zip(orders, forces, strict=True)
    return forces, np.stack([wheel.at_points(*pair) for pair in pairs])


def _relative(one: FloatArray | ComplexArray, other: FloatArray | ComplexArray) -> float:
    """Return the change from one array to another relative to the latter."""
    size = float(np.linalg.norm(other))
    return float(np.linalg.norm(other - one)) / size if size > 0.0 else 0.0


def _first(grid: JointGrid, start: JointMotion | None) -> JointMotion:
    """Return a motion with few harmonics.

    Raises:
        NotConverged: no motion was found.
    """
    ways: list[Callable[[], JointMotion]] = [
        partial(loaded, each, smooth)
        for each in (grid, JointGrid(grid.wheel, 2 * grid.harmonics))
        for smooth in SMOOTH
    ]
    if start is not None:
        ways.insert(0, partial(solve, start.on(grid)))
    return _first_of(ways)


def _first_of(ways: Iterable[Callable[[], JointMotion]]) -> JointMotion:
    """Return the motion of the first way that finds one.

    Raises:
        NotConverged: none does.
    """
    missed = NotConverged()
    for way in ways:
        try:
            return way()
        except NotConverged as reason:
            missed = reason
    raise missed


def _refined(motion: JointMotion, grid: JointGrid, *, anew: bool) -> JointMotion:
    """Return the motion with other harmonics; `anew`: it may be reached through smooth laws.

    Raises:
        NotConverged: no motion was found.
    """
    near = motion.on(grid)
    ways: list[Callable[[], JointMotion]] = [partial(solve, near)]
    if anew:
        ways += [partial(_smoothed, near, each) for each in SMOOTH]
        ways += [partial(loaded, grid, each) for each in SMOOTH]
    return _first_of(ways)


def _smoothed(near: JointMotion, smooth: float) -> JointMotion:
    """Return the motion to which one nearby leads through smooth laws.

    Raises:
        NotConverged: no motion was found.
    """
    return sharpened(solve(near, smooth * near.grid.size), smooth)


def branch(
    start: JointMotion, grid_at: Callable[[float], JointGrid], points: int
) -> Iterator[tuple[float, JointMotion, float]]:
    """Yield the share of a range, the motion, and the direction in which the share changes, of the
    points of a branch, until it leaves the range.

    Args:
        start: motion at the share 0.
        grid_at: wheel at a share, with the harmonics of the start.
        points: number of the longest steps over the range.

    Raises:
        NotConverged: the branch was lost.
    """
    unit, length = float(np.linalg.norm(start.parts)), points * FARTHEST
    smooth = ROUNDED * float(np.abs(start.parts).max())

    def motion(forces: FloatArray, share: float) -> JointMotion:
        return JointMotion(grid_at(share), unit * forces.reshape(start.parts.shape))

    def at(forces: FloatArray, place: float) -> Equations:
        here, ahead = (motion(forces, place / length + step) for step in (0.0, NUDGE))
        error, slope = _errors(here, smooth, 1.0)
        after, _ = _errors(ahead, smooth, 1.0)
        by_place = (after - error).ravel() / NUDGE / length / unit
        return Equations(error.ravel() / unit, _matrix(here.grid, slope), by_place)

    def true(found: JointMotion) -> JointMotion:
        try:
            return solve(found)
        except NotConverged:  # as near a fold, which the smooth law moves
            return found

    curve = Branch(at, LEAST)
    near = solve(start, smooth)
    point = curve.begin(near.parts.ravel() / unit, 0.0, 1.0)
    yield 0.0, start, 1.0
    for ahead, _ in follow(point, curve.ahead, FARTHEST, FARTHEST):
        edge = min(max(ahead.parameter, 0.0), length)
        if left := edge != ahead.parameter:
            ahead = curve.landed(point, ahead, edge)
        share = ahead.parameter / length
        found = true(motion(ahead.unknowns, share))
        yield share, found, float(np.sign(ahead.tangent[-1]))
        if left:
            return
        point = ahead
