"""How far a solid reaches around the axis: the part of each circle about z that is inside of it.

Sectors of a wheel touch and do not overlap: no circle is inside of one by more than a pitch, and
those through its cut faces are so by a pitch.
"""

from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from bladewhirl.meshes.line_mesh import FloatArray, IntArray

PLACE = np.array([0.5, 0.3, 0.2])
"""Shares of the corners of a triangle in the point whose circle is measured; it is on no diagonal
of a face, or of one that matches it after a turn."""

LEAST = 1e-9
"""Least area of a triangle in the meridian plane, as a fraction of the square of the size; and
least radius of a node that is not on the axis, as a fraction of the largest."""


class Rings(NamedTuple):
    """Circles about z through a point of each face of the surface; NaN for faces across which no
    circle goes."""

    inside: FloatArray  #: part of the circle that is inside the solid [rad], (faces,)
    slope: FloatArray
    """Radius times the largest change of that part along r or z, (faces,): zero between faces of
    which one is the other after a turn."""


class _Triangles(NamedTuple):
    """Triangles of the surface on which the angle is linear in r and z."""

    corners: FloatArray  #: r and z of their corners [m], (triangles, 3, 2)
    area: FloatArray
    """Twice the area in the meridian plane, positive if the normal outward points ahead [m2],
    (triangles,)."""
    angle: FloatArray  #: angle of the first corner [rad], (triangles,)
    change: FloatArray  #: change of the angle along r and z [rad/m], (triangles, 2)


def rings(points: FloatArray, corners: IntArray) -> Rings:
    """Return how far a solid reaches around the axis at each face of its surface.

    Args:
        points: positions of all nodes [m], (n, 3), which are not all around the axis.
        corners: corners of each face, see `surface.surface_faces`, (faces, 4).
    """
    quads = np.flatnonzero(corners[:, 3] >= 0)
    face = np.concatenate([np.arange(len(corners)), quads])
    surface, seen = _triangles(points, np.vstack([corners[:, :3], corners[quads][:, [0, 2, 3]]]))
    own = face[seen] < len(corners)
    own[np.searchsorted(seen, len(corners)) :] = False  # one point for each face
    at = PLACE @ surface.corners[own]
    point, triangle = _crossings(surface, at)
    away = at[point] - surface.corners[triangle, 0]
    change = surface.change[triangle]
    angle = surface.angle[triangle] + (change * away).sum(axis=1)
    sums = [
        np.bincount(point, np.sign(surface.area[triangle]) * one, len(at))
        for one in (np.ones(len(point)), angle, *change.T)
    ]
    closed = sums[0] == 0  # a circle leaves the solid as often as it enters it
    found = Rings(*np.full((2, len(corners)), np.nan))
    where = face[seen[own]][closed]
    found.inside[where] = sums[1][closed]
    found.slope[where] = (at[:, 0] * abs(np.array(sums[2:])).max(axis=0))[closed]
    return found


def _triangles(points: FloatArray, corners: IntArray) -> tuple[_Triangles, IntArray]:
    """Return triangles with corners (triangles, 3), and which are not seen as a line along the
    circumference."""
    radius, angle = np.hypot(points[:, 0], points[:, 1]), _unwrapped(points)[corners]
    on_axis = radius[corners] <= LEAST * radius.max()
    others = np.where(on_axis, 0.0, angle).sum(axis=1) / np.maximum(3 - on_axis.sum(axis=1), 1)
    angle = np.where(on_axis, others[:, None], angle)
    places = np.stack([radius[corners], points[corners, 2]], axis=-1)
    (r1, z1), (r2, z2) = (places[:, 1] - places[:, 0]).T, (places[:, 2] - places[:, 0]).T
    t1, t2 = (angle[:, 1:] - angle[:, :1]).T
    area = z1 * r2 - z2 * r1
    seen = np.flatnonzero(abs(area) > LEAST * np.ptp(points, axis=0).max() ** 2)
    change = np.stack([z1 * t2 - z2 * t1, t1 * r2 - t2 * r1], axis=1)[seen] / area[seen, None]
    return _Triangles(places[seen], area[seen], angle[seen, 0], change), seen


def _crossings(surface: _Triangles, at: FloatArray) -> tuple[IntArray, IntArray]:
    """Return the numbers of points in the meridian plane, (points, 2), and of triangles which the
    circles through them cross."""
    low, high = surface.corners.min(axis=1), surface.corners.max(axis=1)
    reach = np.linalg.norm(high - low, axis=1) / 2.0
    near = cKDTree(at).query_ball_point((low + high) / 2.0, reach)
    triangle = np.repeat(np.arange(len(near)), [len(one) for one in near])
    none = np.zeros(0, dtype=np.int64)
    point = np.concatenate([none, *(np.asarray(one, dtype=np.int64) for one in near)])
    first, second, third = surface.corners[triangle].transpose(1, 2, 0)
    (r, z), (r1, z1), (r2, z2) = at[point].T - first, second - first, third - first
    shares = np.array([z * r2 - z2 * r, z1 * r - z * r1]) / surface.area[triangle]
    within = (shares >= 0.0).all(axis=0) & (shares.sum(axis=0) <= 1.0)
    return point[within], triangle[within]


def _unwrapped(points: FloatArray) -> FloatArray:
    """Return angles about z without a step between neighbours [rad], (n,)."""
    angle = np.arctan2(points[:, 1], points[:, 0])
    ordered = np.sort(angle)
    gaps = np.diff(ordered, append=ordered[0] + 2.0 * np.pi)
    return np.asarray((angle - ordered[gaps.argmax()] - gaps.max() / 2.0) % (2.0 * np.pi))
