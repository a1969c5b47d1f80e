"""Branches of periodic motions over a parameter, by arclength continuation through folds.

With the unknowns x of `contact`, normal forces and directions of sliding on the active set, and a
parameter p, a branch satisfies F(x, p) = 0. A step predicts a point along the tangent (x', p'),

    F_x x' + F_p p' = 0,

and Newton's method corrects it in the plane that is normal to the tangent,

    <lambda', lambda - lambda_0> / s^2 + p' (p - p_0) / s_p^2 = 0,

with a scale s of the normal forces and s_p of the parameter; x includes the active set, which
changes in each step as in `contact.solve`. p' changes its sign at a fold. The scalar product is
that of the first harmonics of the sum of the normal forces: single members change much where the
motion hardly does.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import lapack

from bladewhirl.meshes.line_mesh import BoolArray, FloatArray, IntArray
from bladewhirl.solvers.periodic.arclength import TURN, follow
from bladewhirl.solvers.periodic.blade import Grid
from bladewhirl.solvers.periodic.contact import (
    Motion,
    NotConverged,
    active,
    equations,
    moved,
    released,
    resampled,
    values,
)

CLOSE, CLOSE_ANGLE = 1e-7, 1e-6
"""Relative change of the forces, and change of the directions of sliding [rad], at which a
correction ends."""
PATIENCE = 5  #: Newton steps without fewer wrong members of the active set after which one ends
RENEWED = 4  #: Newton steps with the responses of one speed
CORRECTIONS = 12  #: largest number of Newton steps of a correction
NUDGE = 1e-6  #: change of the parameter for F_p, relative to its scale
SHORT = 5e-2  #: length of a step, relative to the longest, from which on any turn is accepted
FAR = 2.0  #: largest distance of two points, relative to the length of the step
FARTHEST = 0.5  #: largest change of the parameter in a Newton step, relative to its scale
FIRST = 4  #: number of harmonics of the forces in scalar products, with the mean
FAINT = 0.02  #: least scale of the forces, relative to the mean gap times the contact stiffness

Place = Callable[[float, int], tuple[Grid, float | FloatArray]]
"""Grid and `Motion.offset` of a parameter and a number of instants."""


@dataclass(frozen=True)
class Point:
    """A periodic motion on a branch, and the tangent of the branch."""

    motion: Motion
    parameter: float
    normal: FloatArray  #: change of the normal forces along the tangent, (instants, nodes)
    angle: FloatArray  #: change of the directions of sliding along the tangent, (instants, nodes)
    heading: float  #: change p' of the parameter along the tangent
    steps: int = 0  #: Newton steps of the correction
    ahead: float = 0.0  #: length of the step that follows

    @property
    def scale(self) -> float:
        """Scale s of the normal forces [N]."""
        motion = self.motion
        faint = FAINT * motion.grid.blade.stiffness_scale * np.abs(motion.gap).mean()
        return float(np.sqrt((smooth(motion.normal) ** 2).mean() + faint**2))

    def on(self, instants: int) -> "Point":
        """Return the point with forces and tangent between its instants, to start Newton's method
        on another grid."""
        grid = Grid(self.motion.grid.blade, instants)
        return replace(
            self,
            motion=self.motion.on(grid),
            normal=resampled(self.normal, instants),
            angle=resampled(self.angle, instants),
        )


def smooth(normal: FloatArray) -> FloatArray:
    """Return the first harmonics of the sum of the normal forces on all nodes, (instants,)."""
    spectrum = np.fft.rfft(normal.sum(axis=1))
    return np.fft.irfft(np.where(np.arange(len(spectrum)) < FIRST, spectrum, 0.0), len(normal))


@dataclass(frozen=True)
class _Factors:
    """Triangular factors of a matrix."""

    matrix: FloatArray
    pivots: IntArray

    @classmethod
    def of(cls, matrix: FloatArray) -> "_Factors":
        """Return the factors of a matrix.

        Raises:
            NotConverged: the matrix is singular.
        """
        factors, pivots, singular = lapack.dgetrf(matrix)
        if singular:
            raise NotConverged("the equations of a step are singular")
        return cls(factors, pivots)

    def solve(self, side: FloatArray) -> FloatArray:
        """Return the solution for a right-hand side, (rows,)."""
        return np.asarray(lapack.dgetrs(self.matrix, self.pivots, side)[0])


@dataclass(frozen=True)
class Continuation:
    """Branches over a parameter."""

    place: Place
    unit: float  #: scale s_p of the parameter

    def begin(self, motion: Motion, parameter: float, sign: float) -> Point:
        """Return a periodic motion at a parameter with its tangent, along which the parameter
        changes with a sign.

        Raises:
            NotConverged: Newton's method failed.
        """
        still = np.zeros_like(motion.normal)
        return self.corrected(Point(motion, parameter, still, still, sign * self.unit), 0.0)

    def corrected(self, start: Point, length: float) -> Point:
        """Return the point of the branch in the plane that is normal to the tangent of a point, at
        a distance from it.

        Raises:
            NotConverged: Newton's method failed.
        """
        parameter = start.parameter + length * start.heading
        normal = np.maximum(0.0, start.motion.normal + length * start.normal)
        angle = start.motion.angle + length * start.angle
        motion = self._at(normal, angle, parameter)
        first, chosen = (motion.normal, parameter), active(motion)
        row = self._row(start, motion)
        heading = self._along_parameter(start, motion)
        fewest, patience, factors, seen = chosen.size, PATIENCE, None, {chosen.tobytes()}
        for step in range(CORRECTIONS):
            motion = released(motion, chosen)
            if step % RENEWED == 0:
                slope, by, factors = self._slope(motion, parameter), motion.grid, None
            if factors is None:
                factors = _Factors.of(self._bordered(start, motion, chosen, slope, by))
            off = (row * (motion.normal - first[0])).sum()
            off += (parameter - first[1]) / self.unit * heading
            change = factors.solve(-np.append(values(motion, chosen), off))
            count, size = np.count_nonzero(chosen), len(change) - 1
            if not np.isfinite(change).all() or abs(change[size]) > FARTHEST:
                break
            parameter += float(change[size]) * self.unit
            largest = np.abs(change[:count]).max(initial=0.0)
            turned = np.abs(change[count:size]).max(initial=0.0)
            motion = moved(motion, chosen, change[:size])
            motion = self._at(motion.normal, motion.angle, parameter)
            wrong = active(motion) != chosen
            converged = largest <= CLOSE * np.abs(motion.normal).max() and turned <= CLOSE_ANGLE
            if converged and abs(change[size]) <= CLOSE and not wrong.any():
                point = replace(start, motion=motion, parameter=parameter, steps=step + 1)
                return self._headed(point, chosen, factors.solve(np.eye(size + 1)[-1]))
            if not wrong.any():
                continue
            number = int(np.count_nonzero(wrong))
            fewest, patience = (number, PATIENCE) if number < fewest else (fewest, patience - 1)
            motion, factors = _entered(motion, wrong & ~chosen), None
            chosen = chosen ^ wrong
            if not patience or chosen.tobytes() in seen:
                break
            seen.add(chosen.tobytes())
        raise NotConverged(f"the correction of a step failed at the parameter {parameter:.6g}")

    def _row(self, start: Point, motion: Motion) -> FloatArray:
        """Return the coefficients of the normal forces in the plane normal to a tangent, as
        lengths like the rows of gaps, (instants, nodes)."""
        soft = len(start.normal) * start.scale * motion.grid.blade.stiffness_scale
        return np.broadcast_to(smooth(start.normal)[:, None] / soft, start.normal.shape)

    def _along_parameter(self, start: Point, motion: Motion) -> float:
        """Return the coefficient of the relative parameter in the plane normal to a tangent."""
        return start.heading / self.unit * start.scale / motion.grid.blade.stiffness_scale

    def _bordered(
        self,
        start: Point,
        motion: Motion,
        chosen: BoolArray,
        slope: FloatArray,
        by: Grid,
    ) -> FloatArray:
        """Return the derivatives of the equations of an active set and of the plane normal to the
        tangent of a point, by forces, angles and the relative parameter, with the responses of a
        grid near that of the motion."""
        own, count = equations(motion, chosen, by).matrix, np.count_nonzero(chosen)
        size = len(own)
        matrix = np.zeros((size + 1, size + 1), order="F")
        matrix[:size, :size] = own
        matrix[:size, size] = slope[np.tile(chosen.ravel(), 2)[: len(slope)]] * self.unit
        matrix[size, :count] = self._row(start, motion)[chosen]
        matrix[size, size] = self._along_parameter(start, motion)
        return matrix

    def _at(self, normal: FloatArray, angle: FloatArray, parameter: float) -> Motion:
        """Return forces at a parameter, (instants, nodes)."""
        grid, offset = self.place(parameter, len(normal))
        return Motion(grid, normal, angle, offset=offset)

    def _slope(self, motion: Motion, parameter: float) -> FloatArray:
        """Return the derivatives F_p of the equations of all members."""
        nudge, every = NUDGE * self.unit, np.ones(motion.normal.shape, dtype=np.bool_)
        ahead = self._at(motion.normal, motion.angle, parameter + nudge)
        return (values(ahead, every) - values(motion, every)) / nudge

    def _headed(self, point: Point, chosen: BoolArray, tangent: FloatArray) -> Point:
        """Return a point with a tangent of unit length along changes of its active set."""
        count, still = np.count_nonzero(chosen), np.zeros(chosen.shape)
        normal, angle = still.copy(), still.copy()
        normal[chosen] = tangent[:count]
        if len(tangent) > count + 1:
            angle[chosen] = tangent[count:-1]
        heading = float(tangent[-1]) * self.unit
        ahead = replace(point, normal=normal, angle=angle, heading=heading)
        length = np.sqrt(self.along(ahead, ahead))
        return replace(
            ahead, normal=normal / length, angle=angle / length, heading=heading / length
        )

    def round_corner(self, point: Point, length: float) -> Point:
        """Return a point of the branch at a distance from the next change of the active set along
        the tangent. There the tangent changes; the branch can turn back, at a fold with a corner.

        Raises:
            NotConverged: the active set does not change near the point.
        """
        motion, chosen = point.motion, active(point.motion)
        stiff = motion.grid.blade.stiffness_scale
        share = NUDGE * self.unit / max(abs(point.heading), NUDGE * self.unit)
        opening = (self._moved(point, share).gap - motion.gap) / share
        room = np.maximum(0.0, np.where(chosen, motion.normal, stiff * motion.gap))
        closing = np.maximum(0.0, -np.where(chosen, point.normal, stiff * opening))
        far = np.divide(room, closing, out=np.full(room.shape, np.inf), where=closing > 0.0)
        member = np.unravel_index(int(np.argmin(far)), far.shape)
        if not far[member] <= FAR * length:
            raise NotConverged("nothing changes near the point")
        beyond, entering = chosen.copy(), not chosen[member]
        beyond[member] = entering
        motion = self._moved(point, float(far[member]))
        motion = _entered(released(motion, beyond), beyond & ~chosen)
        parameter = point.parameter + float(far[member]) * point.heading
        corner = replace(point, motion=motion, parameter=parameter)
        matrix = self._bordered(corner, motion, beyond, self._slope(motion, parameter), motion.grid)
        try:
            tangent = np.linalg.solve(matrix, np.eye(len(matrix))[-1])
        except np.linalg.LinAlgError:
            raise NotConverged("the tangent is not unique") from None
        corner = self._headed(corner, beyond, tangent)
        change = corner.normal if entering else self._moved(corner, share).gap - motion.gap
        sign = np.sign(change[member])
        ahead = self._near(
            replace(
                corner,
                normal=sign * corner.normal,
                angle=sign * corner.angle,
                heading=float(sign * corner.heading),
            ),
            length,
        )
        if active(ahead.motion)[member] != entering:
            raise NotConverged("the correction leads back before the corner")
        return ahead

    def _moved(self, point: Point, length: float) -> Motion:
        """Return the forces at a distance along the tangent of a point."""
        normal = point.motion.normal + length * point.normal
        angle = point.motion.angle + length * point.angle
        return self._at(normal, angle, point.parameter + length * point.heading)

    def along(self, one: Point, other: Point) -> float:
        """Return the scalar product of the tangents of two points, with the scale of the first."""
        forces = (smooth(one.normal) * smooth(other.normal)).mean() / one.scale**2
        return float(forces + one.heading * other.heading / self.unit**2)

    def distance(self, one: Point, other: Point) -> float:
        """Return the distance of two points, with the scale of the first."""
        apart = smooth(one.motion.normal - other.motion.normal)
        forces = (apart**2).mean() / one.scale**2
        return float(np.sqrt(forces + ((one.parameter - other.parameter) / self.unit) ** 2))

    def landed(self, before: Point, after: Point, parameter: float) -> Point:
        """Return the point at a parameter between those of two points.

        Raises:
            NotConverged: Newton's method failed.
        """
        share = (parameter - before.parameter) / (after.parameter - before.parameter)
        one, other = before.motion, after.motion
        normal, angle = (
            (1.0 - share) * a + share * b
            for a, b in ((one.normal, other.normal), (one.angle, other.angle))
        )
        return self.begin(self._at(normal, angle, parameter), parameter, after.heading)

    def follow(self, start: Point, longest: float, first: float) -> Iterator[Point]:
        """Yield further points of a branch, see `arclength.follow`.

        Raises:
            NotConverged: the branch was lost.
        """

        def ahead(point: Point, length: float) -> Point | None:
            return self._ahead(point, length, short=length < SHORT * longest)

        for point, length in follow(start, ahead, longest, first):
            yield replace(point, ahead=length)

    def _ahead(self, point: Point, length: float, *, short: bool) -> Point | None:
        """Return the next point, for short steps also behind a corner; None if it is not near."""
        for step in (self._near, self.round_corner)[: 2 if short else 1]:
            try:
                ahead = step(point, length)
            except NotConverged:
                continue
            if short or self.along(ahead, point) >= TURN:
                return ahead
        return None

    def _near(self, start: Point, length: float) -> Point:
        """Return the point of `corrected` if it is not on a part of a branch that is far away.

        Raises:
            NotConverged: Newton's method failed, or the point is far away.
        """
        point = self.corrected(start, length)
        if self.distance(start, point) > FAR * length:
            raise NotConverged("the correction leads to another branch")
        return point


def _entered(motion: Motion, entering: BoolArray) -> Motion:
    """Return a motion in which friction on new members of the active set opposes their slip."""
    return replace(motion, angle=np.where(entering, motion.sliding, motion.angle))
