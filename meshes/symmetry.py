"""Rotational symmetry of a line mesh, detected from its points and lines."""

from __future__ import annotations

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray, IntArray

TOLERANCE = 1e-6
"""Largest distance of a rotated node from another one, over the radius of the mesh, that counts as
zero: files have seven digits or more, and meshers place nodes on curves to about nine."""


def rotational_sectors(
    points: FloatArray, lines: IntArray, tips: IntArray, centre: int
) -> IntArray | None:
    """Nodes of each sector in one order, (sectors, nodes a sector); None without symmetry.

    There is symmetry if a turn by 2 pi / len(tips) about the origin takes every node to a node,
    every line to a line and tip n to tip n + 1. What lines are made of is not looked at: matrices
    tell whether a mesh of equal sectors is tuned. Sector n holds tip n and, so far as lines lead
    there, what hangs together with it; the centre belongs to none.

    Args:
        points: nodes, the centre at the origin, (nodes, 2).
        lines: end nodes of each line and of whatever else joins two nodes, (lines, 2).
        tips: nodes of the blade tips, counter-clockwise, (blades,).
        centre: node at the origin.
    """
    sectors = len(tips)
    if sectors < 3:
        return None
    image = _image(points, 2.0 * np.pi / sectors)
    if image is None or image[centre] != centre:
        return None
    if not np.array_equal(image[tips], np.roll(tips, -1)):
        return None
    if not np.array_equal(_sorted(image[lines]), _sorted(lines)):
        return None
    results: list[IntArray] = []
    seen = {centre}
    for node in _from_tip(lines, len(points), int(tips[0])):
        if node in seen:
            continue
        orbit = [node]
        while image[orbit[-1]] != node:
            orbit.append(int(image[orbit[-1]]))
        if len(orbit) != sectors:
            return None
        seen.update(orbit)
        results.append(np.array(orbit))
    return np.column_stack(results)


def symmetric_points(points: FloatArray, sectors: IntArray) -> FloatArray:
    """Points with every sector put where the mean of all sectors, turned, is, (nodes, 2).

    Moves nodes by less than the tolerance of `rotational_sectors`; afterwards matrices are
    symmetric to rounding.
    """
    turns = np.exp(2j * np.pi * np.arange(len(sectors)) / len(sectors))[:, None]
    places = points[sectors] @ np.array([1.0, 1.0j])
    mean = (places / turns).mean(axis=0)
    moved = points.copy()
    moved[sectors] = np.stack([(mean * turns).real, (mean * turns).imag], axis=-1)
    return moved


def _image(points: FloatArray, angle: float) -> IntArray | None:
    """Return the node that a rotation maps each node to, (nodes,); None if it is not one to one."""
    cos, sin = np.cos(angle), np.sin(angle)
    radius = np.linalg.norm(points, axis=1).max()
    turned = points @ np.array([[cos, sin], [-sin, cos]])
    from scipy.spatial import KDTree  # not loaded by those who mesh no file

    away, image = KDTree(points).query(turned)
    if away.max() > TOLERANCE * radius or len(np.unique(image)) != len(points):
        return None
    return np.asarray(image, dtype=np.int64)


def _sorted(lines: IntArray) -> IntArray:
    """Lines in an order that does not depend on how they are numbered or run through."""
    ends = np.sort(lines, axis=1)
    return np.asarray(ends[np.lexsort(ends.T)])


def _from_tip(lines: IntArray, nodes: int, tip: int) -> list[int]:
    """All nodes, in the order in which lines lead to them from a tip."""
    neighbours: list[list[int]] = [[] for _ in range(nodes)]
    for first, second in lines.tolist():
        neighbours[first].append(second)
        neighbours[second].append(first)
    order, seen = [], np.zeros(nodes, dtype=np.bool_)
    for begin in (tip, *range(nodes)):
        waiting = [begin]
        while waiting:
            ahead = []
            for node in waiting:
                if not seen[node]:
                    seen[node] = True
                    order.append(node)
                    ahead += neighbours[node]
            waiting = ahead
    return order
