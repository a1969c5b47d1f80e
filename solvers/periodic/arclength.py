"""Length of the steps along a branch of solutions, and branches of smooth equations.

A branch satisfies F(x, p) = 0 for unknowns x and a parameter p. A step predicts a point along the
tangent (x', p'), F_x x' + F_p p' = 0, and Newton's method corrects it in the plane across the
tangent. The parameter may turn back, at a fold. Lengths are relative to the unknowns, (|x'|^2 / s^2
+ p'^2)^(1/2) with s = |x| or a least size.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple, Protocol, TypeVar

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.solvers.periodic.contact import NotConverged

SHORTEST = 1e-5  #: shortest step, relative to the longest
GROWTH = 2.0  #: change of the length of steps
FEW, MANY = 4, 7  #: numbers of Newton steps below and above which the steps grow and shrink
CORRECTIONS = 8  #: largest number of Newton steps of a correction
NEAR = 1e-8  #: default of the largest error of a point, relative to the unknowns
TURN = 0.7  #: smallest cosine of the angle between two tangents, unless steps are short


class Stepped(Protocol):
    """A point that a correction has found."""

    @property
    def steps(self) -> int:
        """Newton steps of the correction."""

    @property
    def parameter(self) -> float:
        """Parameter of the branch."""


P = TypeVar("P", bound=Stepped)


def follow(
    start: P, ahead: Callable[[P, float], P | None], longest: float, first: float
) -> Iterator[tuple[P, float]]:
    """Yield further points of a branch and the length of the step that follows, without end.

    Args:
        start: point at which the branch begins.
        ahead: the point at a distance from another one; None if it is not near.
        longest: length of the longest step.
        first: length of the first step.

    Raises:
        NotConverged: the branch was lost.
    """
    point, length = start, min(first, longest)
    while length >= SHORTEST * longest:
        found = ahead(point, length)
        if found is None:
            length /= GROWTH
            continue
        if found.steps <= FEW:
            length = min(longest, length * GROWTH)
        elif found.steps >= MANY:
            length /= GROWTH
        point = found
        yield point, length
    raise NotConverged(f"Newton's method fails beyond {point.parameter:.6g}")


class Equations(NamedTuple):
    """Errors F and their derivatives."""

    error: FloatArray  #: F, (unknowns,)
    matrix: FloatArray  #: F_x, (unknowns, unknowns)
    by_parameter: FloatArray  #: F_p, (unknowns,)


@dataclass(frozen=True)
class Point:
    """A solution, and the tangent of its branch."""

    place: FloatArray  #: unknowns, and the parameter as the last one, (unknowns + 1,)
    tangent: FloatArray  #: tangent of the length 1, (unknowns + 1,)
    metric: FloatArray  #: 1 / s^2, and 1 for the parameter, (unknowns + 1,)
    steps: int = 0  #: Newton steps of the correction

    @property
    def unknowns(self) -> FloatArray:
        """Unknowns x."""
        return self.place[:-1]

    @property
    def parameter(self) -> float:
        """Parameter p."""
        return float(self.place[-1])


@dataclass(frozen=True)
class Branch:
    """Solutions of equations."""

    equations: Callable[[FloatArray, float], Equations]
    least: float = 1.0  #: least size s
    near: float = NEAR  #: largest error of a point, relative to the unknowns

    def begin(self, unknowns: FloatArray, parameter: float, sign: float) -> Point:
        """Return a solution at a parameter, which changes with a sign along the tangent.

        Raises:
            NotConverged: Newton's method failed.
        """
        along = np.zeros(len(unknowns) + 1)
        along[-1] = sign
        found = self._corrected(np.append(unknowns, parameter), along, np.ones_like(along))
        if found is None:
            raise NotConverged("Newton's method fails at the start of a branch")
        return found

    def ahead(self, start: Point, length: float) -> Point | None:
        """Return the point at a distance from another one; None if it is not near."""
        along, metric = start.tangent, start.metric
        found = self._corrected(start.place + length * along, along, metric)
        if found is None or (found.tangent * metric) @ along < TURN * _length(
            found.tangent, metric
        ):
            return None
        return found

    def landed(self, before: Point, after: Point, parameter: float) -> Point:
        """Return the solution at a parameter between those of two points.

        Raises:
            NotConverged: Newton's method failed.
        """
        share = (parameter - before.parameter) / (after.parameter - before.parameter)
        place = before.unknowns + share * (after.unknowns - before.unknowns)
        return self.begin(place, parameter, float(np.sign(after.tangent[-1])))

    def _corrected(self, first: FloatArray, along: FloatArray, metric: FloatArray) -> Point | None:
        """Return the point in the plane across a direction through a place; None if Newton's method
        fails."""
        place, across = first, along * metric
        for step in range(CORRECTIONS):
            found = self.equations(place[:-1], float(place[-1]))
            size = max(self.least, float(np.linalg.norm(place[:-1])))
            largest = np.abs(found.error).max(initial=0.0) / size
            if not np.isfinite(largest):
                return None
            matrix = np.block([[found.matrix, found.by_parameter[:, None]], [across[None]]])
            sides = np.zeros((len(place), 2))
            sides[:-1, 0], sides[-1] = found.error, (across @ (place - first), 1.0)
            try:
                change, tangent = np.linalg.solve(matrix, sides).T
            except np.linalg.LinAlgError:
                return None
            if largest <= self.near:
                own = np.append(np.full(len(place) - 1, size**-2), 1.0)
                return Point(place, tangent / _length(tangent, own), own, step)
            place = place - change
        return None


def _length(tangent: FloatArray, metric: FloatArray) -> float:
    """Return the length of a tangent."""
    return float(np.sqrt((tangent**2 * metric).sum()))
