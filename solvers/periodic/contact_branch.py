"""Branches of constant contact in rotating axes over a parameter, through folds.

As long as the same tips touch the wall, their forces are a function of the parameter. A branch
therefore changes its course only at corners, where a force or a gap becomes zero: there one tip
joins or leaves those in contact, and the branch goes on in the direction in which its new force, or
gap, grows. If this is the direction it came from, the corner is a fold.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
import scipy.optimize as so

from bladewhirl.meshes.line_mesh import BoolArray, FloatArray
from bladewhirl.solvers.periodic.arclength import follow
from bladewhirl.solvers.periodic.bifurcation import KINDS
from bladewhirl.solvers.periodic.contact import NotConverged
from bladewhirl.solvers.periodic.corotating import CorotatingContact, Equations

NUDGE = 1e-4  #: change of the parameter for derivatives at a corner, relative to the longest step
CLOSE = 1e-9  #: error of the parameter of a corner, relative to the longest step
ZERO, TOGETHER = 1e-3, 1e-6
"""Largest force or gap at a corner, relative to that before and behind it, and that of further tips
that meet in it."""
BEND, NEAR, SHORT = 0.2, 1e-6, 1e-2
"""Largest deviation of forces and gaps from the tangent in a step and smallest value within it,
relative to the largest of them; longest step without these limits, relative to the longest of
all."""
NONE, FOLD, HOPF = 0, 1 + KINDS.index("fold"), 1 + KINDS.index("Neimark-Sacker")
"""Numbers of bifurcations; at the last one an oscillation of deviations begins to grow."""


@dataclass(frozen=True)
class Point:
    """A constant contact on a branch."""

    equations: Equations
    contact: CorotatingContact
    parameter: float
    chosen: BoolArray  #: tips in contact ahead
    way: float  #: 1 if the parameter grows ahead, otherwise -1
    slope: FloatArray
    """Change of the forces of these tips, and of the gaps of the others, by the parameter."""
    kind: int = NONE
    steps: int = 0  #: of a correction; there is none


@dataclass(frozen=True)
class ContactBranch:
    """Branches of constant contact.

    Args:
        equations: equations at a value of the parameter.
        start, stop: range of the parameter; from the start it changes towards the stop.
        points: number of the longest steps over the range.
    """

    equations: Callable[[float], Equations]
    start: float
    stop: float
    points: int
    at: Callable[[float], Equations] = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "at", lru_cache(maxsize=64)(self.equations))

    @property
    def longest(self) -> float:
        """Length of the longest step."""
        return abs(self.stop - self.start) / self.points

    def follow(self, contact: CorotatingContact) -> Iterator[Point]:
        """Yield the points of the branch of a contact at the start, until it leaves the range.

        Raises:
            NotConverged: the branch was lost.
        """
        way = float(np.sign(self.stop - self.start))
        chosen, nudge = contact.normal > 0.0, way * NUDGE * self.longest
        slope = self._slope(self.start, self.start + nudge, chosen)
        point = Point(self.at(self.start), contact, self.start, chosen, way, slope)
        yield point
        for ahead, _ in follow(point, self._ahead, self.longest, self.longest):
            before, point = point, ahead
            if before.contact.stable != ahead.contact.stable and self._same(before, ahead):
                yield from self._instability(before, ahead)
            yield ahead
            if ahead.parameter == (self.stop if ahead.way == way else self.start):
                return

    def _same(self, before: Point, after: Point) -> bool:
        """Return whether the same tips touch between two points."""
        return bool(((after.contact.normal > 0.0) <= before.chosen).all())

    def _forces(self, parameter: float, chosen: BoolArray) -> FloatArray:
        """Return the forces on tips in contact.

        Raises:
            NotConverged: they are not unique.
        """
        if (found := self.at(parameter).tips.forces_of(chosen)) is None:
            raise NotConverged(f"the contact forces are not unique at {parameter:.6g}")
        return found[0]

    def _room(self, parameter: float, chosen: BoolArray) -> FloatArray:
        """Return the forces of tips in contact [N] and the gaps of the others [m], (tips,)."""
        normal = self._forces(parameter, chosen)
        return np.where(chosen, normal, self.at(parameter).tips.gap(normal))

    def _slope(self, place: float, other: float, chosen: BoolArray) -> FloatArray:
        """Return the mean change of `_room` by the parameter between two places, (tips,)."""
        return (self._room(other, chosen) - self._room(place, chosen)) / (other - place)

    def _bends(self, point: Point, first: FloatArray, last: FloatArray, step: float) -> bool:
        """Return whether forces and gaps change so unevenly in a step from a point that tips may
        join and leave the contact within it: a parabola with the slope at the point is negative
        between them, or they differ much from the tangent."""
        along = point.slope * step
        bend = last - first - along
        share = np.divide(-0.5 * along, bend, out=np.zeros_like(bend), where=bend > 0.0)
        inside = (share > 0.0) & (share < 1.0)
        lowest = np.where(inside, first + (along + bend * share) * share, 0.0)
        for kind in (point.chosen, ~point.chosen):
            size = max(np.abs(first[kind]).max(initial=0.0), np.abs(last[kind]).max(initial=0.0))
            if (lowest[kind] < -NEAR * size).any() or (np.abs(bend[kind]) > BEND * size).any():
                return True
        return False

    def _ahead(self, point: Point, length: float) -> Point | None:
        """Return the next point, which is a corner if there is one on the way."""
        low, high = sorted((self.start, self.stop))
        place = min(max(point.parameter + point.way * length, low), high)
        if place == point.parameter:
            place = point.parameter + point.way * CLOSE * self.longest
        chosen, step = point.chosen, place - point.parameter
        first, room = (self._room(each, chosen) for each in (point.parameter, place))
        if abs(step) > SHORT * self.longest and self._bends(point, first, room, step):
            return None
        if (room >= 0.0).all():
            return self._point(place, chosen, chosen, point.way, (room - first) / step)
        scale = np.maximum(np.abs(first), np.abs(room))

        def least(parameter: float) -> float:
            return float((self._room(parameter, chosen) / scale).min())

        near = point.parameter + point.way * NUDGE * self.longest  # the point can be a corner
        if (place - near) * point.way <= 0.0 or least(near) <= 0.0:
            return None if length > NUDGE * self.longest else self._corner(point, place, room < 0.0)
        corner = float(so.brentq(least, near, place, xtol=CLOSE * self.longest))
        size = np.abs(self._room(corner, chosen)) / scale
        if size.min() > ZERO:  # a pole between the two points
            return None
        meet = size <= max(TOGETHER, float(size.min()))
        return self._corner(point, corner, meet)

    def _corner(self, point: Point, place: float, meet: BoolArray) -> Point:
        """Return a corner at which forces or gaps of tips become zero.

        Raises:
            NotConverged: no set of tips in contact leads on.
        """
        every = [meet] if np.count_nonzero(meet) > 1 else []
        every += list(np.eye(len(meet), dtype=np.bool_)[meet])
        nudge = -point.way * NUDGE * self.longest  # to where the branch comes from
        for changed in every:
            chosen = point.chosen ^ changed
            slope = self._slope(place, place + nudge, chosen)
            ways = np.sign(slope[meet])
            if ways[0] and (ways == ways[0]).all():
                touching, way = point.chosen & chosen, float(ways[0])
                kind = NONE if way == point.way else FOLD
                return self._point(place, touching, chosen, way, slope, kind)
        raise NotConverged(f"no tips in contact lead beyond {place:.6g}")

    def _point(
        self,
        place: float,
        touching: BoolArray,
        ahead: BoolArray,
        way: float,
        slope: FloatArray,
        kind: int = NONE,
    ) -> Point:
        """Return the point at which tips touch."""
        equations = self.at(place)
        contact = equations.contact(np.maximum(0.0, self._forces(place, touching)))
        return Point(equations, contact, place, ahead, way, slope, kind)

    def _instability(self, before: Point, after: Point) -> Iterator[Point]:
        """Yield where an oscillation begins or ends to grow between two points."""
        chosen = before.chosen

        def point(place: float) -> Point:
            return self._point(place, chosen, chosen, before.way, before.slope, HOPF)

        def growth(place: float) -> float:
            return float(point(place).contact.rates[0].real)

        inside = before.way * NUDGE * self.longest  # both ends can be corners
        first, last = before.parameter + inside, after.parameter - inside
        if (last - first) * before.way > 0.0 > growth(first) * growth(last):
            found = point(so.brentq(growth, first, last, xtol=NUDGE * self.longest))
            if found.contact.rates[0].imag:
                yield found
