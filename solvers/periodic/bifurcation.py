"""Bifurcations between two points of a branch, confirmed on a grid of twice as many instants."""

from dataclasses import dataclass

import numpy as np

from bladewhirl.meshes.line_mesh import ComplexArray
from bladewhirl.solvers.periodic.contact import NotConverged
from bladewhirl.solvers.periodic.continuation import Continuation, Point
from bladewhirl.solvers.periodic.stability import monodromy

KINDS = ("fold", "period doubling", "Neimark-Sacker")
"""Kinds of bifurcation: a multiplier leaves the unit circle at +1, at -1, or with its conjugate."""
CLOSER = 6  #: factor by which steps shorten in each search for a bifurcation
SEARCHES = 3  #: number of searches, each with shorter steps
BEYOND = 3  #: length of a search, relative to the distance of the points
NEAR = 0.1  #: largest distance from the unit circle of a multiplier that leaves it
REAL = 1e-9  #: largest relative imaginary part of a real multiplier


@dataclass(frozen=True)
class Bifurcation:
    """A bifurcation on a branch."""

    kind: str  #: one of `KINDS`
    point: Point  #: point of the branch near it, on twice as many instants
    shift: float  #: difference of its parameter from that on half as many instants


def multipliers(point: Point) -> ComplexArray:
    """Return the multipliers of a point, the largest first."""
    return monodromy(point.motion).multipliers


def found(branch: Continuation, one: Point, other: Point, kinds: set[str]) -> list[Bifurcation]:
    """Return the bifurcations of some kinds between two points in turn, as far as there are also
    such on twice as many instants."""
    confirmed = []
    for kind in sorted(kinds):
        try:
            coarse = _located(branch, one, other, kind)
            twice = 2 * len(one.normal)
            start, end = (branch.corrected(each.on(twice), 0.0) for each in (one, other))
            fine = _located(branch, start, end, kind)
        except NotConverged:
            continue
        if not _crosses(kind, multipliers(fine)):
            continue
        shift = abs(fine.parameter - coarse.parameter)
        confirmed.append(Bifurcation(kind, fine, shift))
    return confirmed


def changed(one: Point, other: Point, before: ComplexArray, after: ComplexArray) -> set[str]:
    """Return the kinds of bifurcation between two points with their multipliers."""
    both = (_state(one, before), _state(other, after))
    return {kind for kind, a, b in zip(KINDS, *both, strict=True) if a != b}


def _crosses(kind: str, values: ComplexArray) -> bool:
    """Return whether a multiplier is near the unit circle where it leaves it. At a fold with a
    corner, multipliers jump."""
    if kind == "fold":
        return True
    if kind == "period doubling":
        return bool(np.abs(values + 1.0).min() < NEAR)
    pairs = values[np.abs(values.imag) > REAL * np.abs(values)]
    return bool(len(pairs) and np.abs(np.abs(pairs) - 1.0).min() < NEAR)


def _state(point: Point, values: ComplexArray) -> tuple[int, int, int]:
    """Return what changes at a bifurcation of each kind: the direction of the parameter, and the
    numbers of multipliers beyond -1 and of pairs outside the unit circle."""
    real = np.abs(values.imag) <= REAL * np.abs(values)
    pairs = int(np.count_nonzero(~real & (np.abs(values) > 1.0))) // 2
    doubled = int(np.count_nonzero(real & (values.real < -1.0)))
    return int(np.sign(point.heading)), doubled, pairs


def _located(branch: Continuation, one: Point, other: Point, kind: str) -> Point:
    """Return the point at a bifurcation, by searches with shorter and shorter steps.

    Raises:
        NotConverged: there is none near.
    """
    number = KINDS.index(kind)

    def measure(point: Point) -> int:
        values = multipliers(point) if number else np.zeros(0, dtype=np.complex128)
        return _state(point, values)[number]

    first, length = one, branch.distance(one, other)
    state = measure(first)
    for _ in range(SEARCHES):
        gone, before, length = 0.0, first, length / CLOSER
        for after in branch.follow(first, length, length):
            if measure(after) != state:
                break
            gone += branch.distance(before, after)
            before = after
            if gone > BEYOND * CLOSER * length:
                raise NotConverged(f"there is no {kind} near")
        first = before
        length = branch.distance(before, after)
    if number:
        return after
    share = before.heading / (before.heading - after.heading)
    try:
        return branch.corrected(before, share * length)
    except NotConverged:  # a corner
        return max(before, after, key=lambda point: point.parameter * state)
