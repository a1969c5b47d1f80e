"""Sectors of wheels in meshes: cut faces that match after a turn about an axis."""

from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from bladewhirl.meshes.coincident import COINCIDENT
from bladewhirl.meshes.files.volumes import VolumeMesh
from bladewhirl.meshes.line_mesh import BoolArray, FloatArray, IntArray
from bladewhirl.meshes.plane import rotate
from bladewhirl.models.solids.surface import surface_faces

SLOPE = 1e-3
"""Normals are equal up to this difference of their components."""

SHARE = 0.1
"""Faces that match by chance have a smaller share of the largest area that matches."""

FLAT = 0.95  #: least cosine of the angle between faces of elements that continue each other

OPEN = 0.75
"""Smallest share of a pitch that nodes of a sector leave free about the axis."""


FEW = 6  #: a box or a prism with an edge on the axis looks like one of so few sectors

MOST_COPIES = 1000  #: largest number of sectors that is found


class Sector(NamedTuple):
    """Cut faces of a sector."""

    copies: int  #: number of sectors of the wheel
    left: IntArray  #: nodes of the clockwise face, ascending
    right: IntArray  #: nodes of the counter-clockwise face, ascending
    unmatched: IntArray  #: nodes that continue a face and match no node of the other one, ascending

    @property
    def on_axis(self) -> bool:
        """Whether both faces meet on the axis."""
        return len(np.intersect1d(self.left, self.right)) > 0

    def partly(self, points: FloatArray) -> str:
        """Return a sentence on nodes that do not match; "" if all do.

        Args:
            points: positions of the nodes about the axis z, (nodes, 3).
        """
        if not len(self.unmatched):
            return ""
        radius = np.hypot(*points[self.unmatched, :2].T)
        return (
            f"cut faces match in part: {len(self.unmatched)} nodes that continue them, at radii"
            f" from {radius.min():.6g} to {radius.max():.6g}, are not where a node of the other"
            f" face is after 1/{self.copies} of a turn and stay free: mesh both faces alike"
        )


def find_sector(mesh: VolumeMesh, copies: int | None = None) -> Sector | None:
    """Return the cut faces of a sector of a wheel; None if no faces match.

    A face of an element on the surface that looks clockwise is cut if, after a turn about z by one
    pitch, it is the face of another element that looks the opposite way. Of several numbers of
    sectors the smallest is taken, unless few faces match.

    Args:
        mesh: mesh with the axis of rotation z.
        copies: number of sectors; by default any, but above `FEW` if the faces meet on the axis.
    """
    corners, nodes = surface_faces(mesh)
    at, normal, area = _centres(mesh.points, corners)
    radius, angle = np.hypot(at[:, 0], at[:, 1]), np.arctan2(at[:, 1], at[:, 0])
    size = float(np.ptp(mesh.points, axis=0).max())
    close = COINCIDENT * size
    # Components along the radius, the circumference and the axis do not change by a turn.
    c, s = np.cos(angle), np.sin(angle)
    turned = np.stack([c * normal[:, 0] + s * normal[:, 1], c * normal[:, 1] - s * normal[:, 0]])
    along = close / SLOPE * np.column_stack([*turned, normal[:, 2]])
    meridian = np.column_stack([radius, at[:, 2]])
    clockwise = np.flatnonzero(turned[1] < -SLOPE)
    ahead = np.flatnonzero(turned[1] > SLOPE)
    if not len(clockwise) or not len(ahead):
        return None
    tree = cKDTree(np.hstack([meridian[ahead], along[ahead]]))
    partners = tree.query_ball_point(np.hstack([meridian, -along])[clockwise], 2.0 * close)
    left = np.repeat(clockwise, [len(one) for one in partners])
    right = ahead[np.concatenate([np.asarray(one, dtype=np.int64) for one in partners])]
    turn = (angle[right] - angle[left]) % (2.0 * np.pi)
    number = np.rint(2.0 * np.pi / np.maximum(turn, 1e-9)).astype(np.int64)
    fits = (number > 1) & (abs(turn * number - 2.0 * np.pi) * radius[left] < 2.0 * close * number)
    fits &= number == copies if copies is not None else number <= MOST_COPIES
    left, right, number = left[fits], right[fits], number[fits]
    if not len(left):
        return None
    matched = np.bincount(number, weights=area[left])
    found = int(np.flatnonzero(matched >= SHARE * matched.max())[0])
    if largest_gap(mesh.points) < OPEN * 2.0 * np.pi / found:
        return None
    first, second = (np.unique(nodes[side[number == found]]) for side in (left, right))
    first, second = first[first >= 0], second[second >= 0]
    forward = rotate(mesh.points[first], 2.0 * np.pi / found)
    apart = cKDTree(mesh.points[second]).query(forward)[0].max()
    pairs = number == found
    cut = np.isin(np.arange(len(corners)), [left[pairs], right[pairs]])
    beside = corners[_continuing(corners, normal, cut)]
    unmatched = np.setdiff1d(beside[beside >= 0], np.concatenate([first, second]))
    sector = Sector(found, first, second, unmatched)
    by_chance = copies is None and sector.on_axis and found <= FEW
    return sector if apart <= close and not by_chance else None


def _continuing(corners: IntArray, normal: FloatArray, matched: BoolArray) -> BoolArray:
    """Return which other faces of the surface continue matched ones without a bend, (faces,)."""
    after = np.roll(corners, -1, axis=1)
    triangle = corners[:, 3] < 0
    after[triangle, 2] = corners[triangle, 0]
    edges = np.sort(np.stack([corners, after], axis=-1).reshape(-1, 2), axis=1)
    face = np.repeat(np.arange(len(corners)), corners.shape[1])
    face, edges = face[edges[:, 0] >= 0], edges[edges[:, 0] >= 0]
    order = np.lexsort(edges.T)
    same = (np.diff(edges[order], axis=0) == 0).all(axis=1)
    first, second = face[order][:-1][same], face[order][1:][same]
    flat = np.einsum("fi,fi->f", normal[first], normal[second]) > FLAT
    found = np.zeros(len(corners), dtype=np.bool_)
    for one, other in ((first, second), (second, first)):
        found[other[flat & matched[one] & ~matched[other]]] = True
    return found


def _centres(points: FloatArray, corners: IntArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return centre, unit normal outward and area of faces with three or four corners."""
    third = np.where(corners[:, 3] < 0, corners[:, 2], corners[:, 3])
    a, b, c, d = (points[one] for one in (*corners[:, :3].T, third))
    cross = np.cross(c - a, d - b) / 2.0
    area = np.linalg.norm(cross, axis=1)
    centre = np.where((corners[:, 3] < 0)[:, None], (a + b + c) / 3.0, (a + b + c + d) / 4.0)
    return centre, cross / np.maximum(area, 1e-300)[:, None], area


def largest_gap(points: FloatArray) -> float:
    """Return the largest angle about z without nodes [rad]."""
    angle = np.sort(np.arctan2(points[:, 1], points[:, 0]))
    return float(np.diff(angle, append=angle[0] + 2.0 * np.pi).max())
