"""Rotational symmetry of a line mesh, detected from its points and lines."""

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.meshes.plane import rotate

TOLERANCE = 1e-6
"""A rotated node coincides with another node up to a distance of this fraction of the radius of the
mesh. Files have seven digits or more, and meshers place nodes on curves with about nine digits."""


def rotational_sectors(
    points: FloatArray, lines: IntArray, tips: IntArray, centre: int
) -> IntArray | None:
    """Find the sectors of a mesh with rotational symmetry.

    A mesh is symmetric if a rotation by 2 pi / len(tips) about the origin maps every node to a
    node, every line to a line and tip n to tip n + 1. Sections and materials are not compared here;
    differences between blades follow from the matrices. Sector n contains tip n and, as far as
    possible, nodes that are connected to it by lines. The centre belongs to no sector.

    Args:
        points: positions of the nodes, with the centre at the origin, (nodes, 2).
        lines: end nodes of lines and of other connections between two nodes, (lines, 2).
        tips: nodes of the blade tips, counter-clockwise, (blades,).
        centre: node at the origin.

    Returns:
        nodes of each sector, in the same order in every sector, (sectors, nodes per sector); None
        without symmetry.
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
    """Return the points with each sector replaced by the mean of all sectors, (nodes, 2).

    The nodes move by less than the tolerance of `rotational_sectors`. Matrices of the new mesh are
    cyclically symmetric up to rounding errors.

    Args:
        points: positions of the nodes, (nodes, 2).
        sectors: nodes of each sector, (sectors, nodes per sector).
    """
    turns = np.exp(2j * np.pi * np.arange(len(sectors)) / len(sectors))[:, None]
    places = points[sectors] @ np.array([1.0, 1.0j])
    mean = (places / turns).mean(axis=0)
    moved = points.copy()
    moved[sectors] = np.stack([(mean * turns).real, (mean * turns).imag], axis=-1)
    return moved


def _image(points: FloatArray, angle: float) -> IntArray | None:
    """Return the node to which a rotation maps each node, (nodes,); None if this is not a
    permutation of the nodes."""
    radius = np.linalg.norm(points, axis=1).max()
    from scipy.spatial import KDTree  # loaded only if a mesh file is used

    away, image = KDTree(points).query(rotate(points, angle))
    if away.max() > TOLERANCE * radius or len(np.unique(image)) != len(points):
        return None
    return np.asarray(image, dtype=np.int64)


def _sorted(lines: IntArray) -> IntArray:
    """Return lines in an order that is independent of their numbers and directions."""
    ends = np.sort(lines, axis=1)
    return np.asarray(ends[np.lexsort(ends.T)])


def _from_tip(lines: IntArray, nodes: int, tip: int) -> list[int]:
    """Return all nodes in the order of a breadth-first search along lines from a tip; nodes that
    are not connected to the tip come last."""
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
