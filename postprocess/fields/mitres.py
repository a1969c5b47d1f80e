"""Mitred joints of beams that are drawn as ribbons: where two beams of equal thickness go on from
each other at an angle, both ribbons end on the line that halves it, so that their edges meet."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bladewhirl.meshes.line_mesh import IntArray, absent
from bladewhirl.meshes.plane import rotate, unit
from bladewhirl.postprocess.fields.kinematics import Array

STRAIGHT = 0.5  #: smallest cosine of the angle by which a beam goes on from another


class BeamEnd(NamedTuple):
    """Ends of beams, (joint,) each."""

    line: IntArray = absent()  #: number of the beam
    last: NDArray[np.bool_] = np.zeros(0, dtype=np.bool_)  #: whether it is the end of the beam


class Mitres(NamedTuple):
    """Pairs of ends of beams that are mitred."""

    before: BeamEnd = BeamEnd()
    after: BeamEnd = BeamEnd()


def mitres_of(points: Array, lines: IntArray, thickness: Array) -> Mitres:
    """Return the pairs of beams that go on from each other: at each node the straightest pairs of
    ends of equal thickness.

    Args:
        points: nodes (node, 2) [m].
        lines: nodes of both ends of each beam (line, 2).
        thickness: thickness at both ends (line, 2) [m].
    """
    leaving = unit(np.diff(points[lines], axis=1)[:, 0])
    ends = np.stack([leaving, -leaving], axis=1).reshape(-1, 2)
    node, size = lines.ravel(), thickness.ravel()
    pairs: list[tuple[int, int]] = []
    by_node = np.argsort(node, kind="stable")
    for here in np.split(by_node, np.flatnonzero(np.diff(node[by_node])) + 1):
        first, second = np.triu_indices(len(here), 1)
        first, second = here[first], here[second]
        straight = -np.sum(ends[first] * ends[second], axis=1)
        straight[~np.isclose(size[first], size[second], rtol=1e-6)] = -1.0
        used = set[int]()
        for pair in np.argsort(-straight, kind="stable"):
            both = int(first[pair]), int(second[pair])
            if straight[pair] >= STRAIGHT and used.isdisjoint(both):
                used.update(both)
                pairs.append(both)
    one, other = np.array(pairs, dtype=np.int64).reshape(-1, 2).T
    return Mitres(*(BeamEnd(each // 2, each % 2 == 1) for each in (one, other)))


def mitred(sides: Array, along: Array, line: Array, thickness: Array, mitres: Mitres) -> Array:
    """Return the sides of beams (line, station, side, 2) with mitred joints.

    Args:
        sides: right and left side (line, station, side, 2) [m].
        along: directions of the beams (line, station, 2).
        line: their middle lines (line, station, 2) [m].
        thickness: their thickness (line, station) [m].
        mitres: joints.
    """
    sides, last = sides.copy(), line.shape[1] - 1
    places = [(end.line, np.where(end.last, last, 0)) for end in mitres]
    # Into the joint along the first beam, and out of it along the second one.
    senses = [np.where(mitres.before.last, 1.0, -1.0), np.where(mitres.after.last, -1.0, 1.0)]
    ways = [sense[:, None] * along[at] for sense, at in zip(senses, places, strict=True)]
    middle = unit(ways[0] + ways[1])
    for sense, way, at in zip(senses, ways, places, strict=True):
        straight = np.maximum(np.sum(middle * way, axis=1), STRAIGHT)
        half = (0.5 * sense * thickness[at] / straight)[:, None] * rotate(middle, np.pi / 2)
        sides[at] = np.stack([line[at] - half, line[at] + half], axis=1)
    return sides
