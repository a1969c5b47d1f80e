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
ZERO = 1e-3  #: largest force or gap at a corner, relative to that before and behind it
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
        chosen = contact.normal > 0.0
        point = Point(self.at(self.start), contact, self.start, chosen, way)
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
        normal = self.at(parameter).tips.forces(chosen)
        if normal is None:
            raise NotConverged(f"the contact forces are not unique at {parameter:.6g}")
        return normal

    def _room(self, parameter: float, chosen: BoolArray) -> FloatArray:
        """Return the forces of tips in contact [N] and the gaps of the others [m], (tips,)."""
        normal = self._forces(parameter, chosen)
        return np.where(chosen, normal, self.at(parameter).tips.gap(normal))

    def _ahead(self, point: Point, length: float) -> Point | None:
        """Return the next point, which is a corner if there is one on the way."""
        low, high = sorted((self.start, self.stop))
        place = min(max(point.parameter + point.way * length, low), high)
        if place == point.parameter:
            place = point.parameter + point.way * CLOSE * self.longest
        chosen = point.chosen
        room = self._room(place, chosen)
        if (room >= 0.0).all():
            return self._point(place, chosen, chosen, point.way, NONE)
        lacks = room < 0.0

        def least(parameter: float) -> float:
            own = self._room(parameter, chosen)[lacks] / -room[lacks]
            return float(own.min())

        near = point.parameter + point.way * NUDGE * self.longest
        if (place - near) * point.way <= 0.0 or least(near) <= 0.0:
            near = point.parameter
        if least(near) <= 0.0:  # several tips meet in a corner
            return self._corner(point, near, lacks)
        corner = float(so.brentq(least, near, place, xtol=CLOSE * self.longest))
        size = self._room(corner, chosen)[lacks]
        meet = np.zeros_like(lacks)
        meet[lacks] = np.abs(size) <= ZERO * np.maximum(
            np.abs(self._room(point.parameter, chosen)[lacks]), -room[lacks]
        )
        if not meet.any():
            raise NotConverged(f"contact forces grow beyond bounds at {corner:.6g}")
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
            slope = (self._room(place + nudge, chosen) - self._room(place, chosen)) / nudge
            ways = np.sign(slope[meet])
            if ways[0] and (ways == ways[0]).all():
                kind = NONE if ways[0] == point.way else FOLD
                return self._point(place, point.chosen & chosen, chosen, float(ways[0]), kind)
        raise NotConverged(f"no tips in contact lead beyond {place:.6g}")

    def _point(
        self, place: float, touching: BoolArray, ahead: BoolArray, way: float, kind: int
    ) -> Point:
        """Return the point at which tips touch."""
        equations = self.at(place)
        contact = equations.contact(np.maximum(0.0, self._forces(place, touching)))
        return Point(equations, contact, place, ahead, way, kind)

    def _instability(self, before: Point, after: Point) -> Iterator[Point]:
        """Yield where an oscillation begins or ends to grow between two points."""
        chosen = before.chosen

        def point(place: float) -> Point:
            return self._point(place, chosen, chosen, before.way, HOPF)

        def growth(place: float) -> float:
            return float(point(place).contact.rates[0].real)

        inside = before.way * NUDGE * self.longest  # both ends can be corners
        first, last = before.parameter + inside, after.parameter - inside
        if (last - first) * before.way > 0.0 > growth(first) * growth(last):
            found = point(so.brentq(growth, first, last, xtol=NUDGE * self.longest))
            if found.contact.rates[0].imag:
                yield found
