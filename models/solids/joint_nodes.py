"""Nodes of solids at which neighbouring blades touch each other, in pairs."""

import numpy as np
from scipy.spatial import cKDTree

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.meshes.plane import rotate
from bladewhirl.models.solids.groups import invalid


def joint_pairs(
    points: FloatArray, left: IntArray, right: IntArray, copies: int | None, count: int | None
) -> tuple[IntArray, IntArray]:
    """Return nodes of the left face and those of the right face that they touch on the blade
    before, (pairs,) each: nodes that are nearest to each other after a turn by one pitch.

    Args:
        points: positions of all nodes, axis of rotation z [m], (n, 3).
        left: nodes on the clockwise side.
        right: nodes on the counter-clockwise side.
        copies: number of sectors; None for a blade, whose pitch is the angle between the middles of
            both faces.
        count: number of pairs, far from each other; None for all.

    Raises:
        CaseError: a node is on both faces, the right face is not ahead, or there are too few pairs.
    """
    if len(both := np.intersect1d(left, right)):
        expected = f"nodes that are not those of joint_left; {len(both)} of them would touch itself"
        raise invalid("joint_right", None, expected)
    middle = [points[side, :2].mean(axis=0) for side in (left, right)]
    angles = [np.arctan2(y, x) for x, y in middle]
    pitch = float((angles[1] - angles[0]) % (2.0 * np.pi))
    if not 0.0 < pitch < np.pi:
        expected = "nodes on the counter-clockwise side of the blade, less than half a turn ahead"
        raise invalid("joint_right", None, f"{expected} of joint_left")
    turned = rotate(points[left], pitch if copies is None else 2.0 * np.pi / copies)
    there = cKDTree(points[right]).query(turned)[1]
    back = cKDTree(turned).query(points[right])[1]
    own = np.flatnonzero(back[there] == np.arange(len(left)))
    if count is not None:
        if isinstance(count, bool) or not isinstance(count, int) or not 1 <= count <= len(own):
            expected = f"a whole number from 1 to {len(own)}, all pairs of nodes"
            raise invalid("joint_nodes", count, expected)
        own = own[_spread(points[left[own]], count)]
    return left[own], right[there[own]]


def _spread(points: FloatArray, count: int) -> IntArray:
    """Return points that are far from each other, ascending: one is nearest to the middle; of
    several, the first is farthest from it, and each next one is farthest from those chosen."""
    distance = np.linalg.norm(points - points.mean(axis=0), axis=1)
    if count == 1:
        return np.array([distance.argmin()])
    chosen = [int(distance.argmax())]
    while len(chosen) < count:
        apart = np.linalg.norm(points[:, None] - points[chosen], axis=2).min(axis=1)
        chosen.append(int(apart.argmax()))
    return np.sort(chosen)
