"""Sectors of wheels in meshes: cut faces that match after a turn about an axis, and faces that
bound a sector and do not match."""

from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from bladewhirl.meshes.coincident import COINCIDENT
from bladewhirl.meshes.files.volumes import VolumeMesh
from bladewhirl.meshes.line_mesh import BoolArray, FloatArray, IntArray
from bladewhirl.meshes.plane import rotate
from bladewhirl.models.solids.rings import Rings, rings
from bladewhirl.models.solids.surface import surface_faces

SLOPE = 1e-3
"""Normals are equal up to this difference of their components."""

SHARE = 0.1
"""Faces that match by chance have a smaller share of the largest area that matches."""

FULL = 0.01
"""Circles are inside a sector by a pitch up to this fraction of it, or a quarter of the difference
between numbers of sectors; and both faces reach as far but for this fraction of their size."""

BESIDE = 0.1
"""Faces that bound a sector have a smaller slope of `Rings`, which is not zero because meshes that
differ do not approximate curved faces alike."""

WIDE, MOSTLY = 0.8, 0.75
"""Circles that are inside a sector by more than the first fraction of a pitch go through its cut
faces, but for the second fraction of the area. Those through the parallel sides of a blade are
inside of it by different angles."""

OVERLAP, LITTLE = 1.1, 0.01
"""Sectors overlap if circles are inside of one by more than the first multiple of a pitch, at more
than the second fraction of the area. Shrouds are made a little wider than a pitch, so that they
press on each other."""

OPEN = 0.75
"""Smallest share of a pitch that nodes of a sector leave free about the axis."""


FEW = 6
"""A box or a prism with an edge or a face on the axis looks like one of so few sectors."""

MOST_COPIES = 1000  #: largest number of sectors that is found


class Sector(NamedTuple):
    """Cut faces of a sector."""

    copies: int  #: number of sectors of the wheel
    left: IntArray  #: nodes of the clockwise face, ascending
    right: IntArray  #: nodes of the counter-clockwise face, ascending
    unmatched: IntArray
    """Nodes of faces that touch the next sector and match no node of it, ascending."""

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
            f"cut faces match in part: {len(self.unmatched)} nodes that touch the next sector, at"
            f" radii from {radius.min():.6g} to {radius.max():.6g}, are not where a node of the"
            f" other face is after 1/{self.copies} of a turn and stay free: mesh both faces alike"
        )


class Bounds(NamedTuple):
    """Faces that bound a sector and do not match, since their meshes differ."""

    copies: int  #: number of sectors of the wheel
    left: IntArray  #: nodes that look clockwise, ascending
    right: IntArray  #: nodes that look counter-clockwise, ascending
    share: float  #: their share of the surface that looks along the circumference

    def missed(self, points: FloatArray, unit: str) -> str:
        """Return a sentence on how far the faces are from matching.

        Args:
            points: positions of the nodes about the axis z, (nodes, 3).
            unit: their unit.
        """
        forward = rotate(points[self.left], 2.0 * np.pi / self.copies)
        sides = (forward, points[self.right]), (points[self.right], forward)
        apart = max(cKDTree(one).query(other)[0].max() for one, other in sides)
        y, x = np.array([points[one, 1::-1].mean(axis=0) for one in (self.left, self.right)]).T
        angles = " and ".join(f"{one:.3g}" for one in np.degrees(np.arctan2(y, x)))
        return (
            f"faces at angles about {angles} degrees bound 1/{self.copies} of a turn, but their"
            f" {len(self.left)} and {len(self.right)} nodes do not match: after that turn some are"
            f" {apart:.3g} {unit} from the nearest one; mesh both faces alike"
        )


def find_sector(mesh: VolumeMesh, copies: int | None = None) -> Sector | None:
    """Return the cut faces of a sector of a wheel; None if no faces match.

    A face of an element on the surface that looks clockwise is cut if, after a turn about z by one
    pitch, it is the face of another element that looks the opposite way, and if sectors do not
    overlap. Of several numbers of sectors the smallest is taken, unless few faces match.

    Args:
        mesh: mesh with the axis of rotation z.
        copies: number of sectors; by default any, but above `FEW` if the axis meets the surface.
    """
    corners, nodes = surface_faces(mesh)
    at, normal, area = _centres(mesh.points, corners)
    size = float(np.ptp(mesh.points, axis=0).max())
    left, right, number = _pairs(at, normal, COINCIDENT * size)
    fits = number == copies if copies is not None else (number > 1) & (number <= MOST_COPIES)
    left, right, number = left[fits], right[fits], number[fits]
    if not len(left):
        return None
    matched = np.bincount(number, weights=area[left])
    around = rings(mesh.points, corners)
    likely = np.flatnonzero(matched >= SHARE * matched.max()).tolist()
    found = next((one for one in likely if _apart(mesh.points, around, area, one)), None)
    if found is None:
        return None
    pairs = number == found
    first, second = (_nodes(nodes[side[pairs]]) for side in (left, right))
    forward = rotate(mesh.points[first], 2.0 * np.pi / found)
    apart = cKDTree(mesh.points[second]).query(forward)[0].max()
    touching = _filled(around, np.full(len(corners), found))
    touching[np.concatenate([left[pairs], right[pairs]])] = False
    beside = np.setdiff1d(_nodes(corners[touching]), np.concatenate([first, second]))
    by_chance = copies is None and found <= FEW and _on_axis(mesh.points, corners)
    if apart > COINCIDENT * size or by_chance:
        return None
    return Sector(found, first, second, beside)


def find_bounds(mesh: VolumeMesh) -> Bounds | None:
    """Return faces that bound a sector of a wheel; None if there are none.

    Circles about z through such faces are inside the sector by one pitch.

    Args:
        mesh: mesh with the axis of rotation z, no cut faces of which match.
    """
    corners, nodes = surface_faces(mesh)
    at, normal, area = _centres(mesh.points, corners)
    around = rings(mesh.points, corners)
    seen = np.isfinite(around.inside)
    number = np.zeros(len(corners), dtype=np.int64)
    number[seen] = np.rint(2.0 * np.pi / np.maximum(around.inside[seen], 1.0 / MOST_COPIES))
    number[~_filled(around, number)] = 0
    bounding, least = np.bincount(number, weights=area), FEW * _on_axis(mesh.points, corners)

    def of_wheel(number: int) -> bool:
        wide = area[around.inside > WIDE * 2.0 * np.pi / number].sum()
        return bounding[number] > MOSTLY * wide and _apart(mesh.points, around, area, number)

    likely = np.flatnonzero(bounding >= SHARE * area[seen].sum()).tolist()
    found = next((one for one in likely if one > max(least, 1) and of_wheel(one)), None)
    if found is None:
        return None
    ahead = at[:, 0] * normal[:, 1] - at[:, 1] * normal[:, 0] > 0.0
    left, right = (_nodes(nodes[(number == found) & side]) for side in (~ahead, ahead))
    if not _alike(mesh.points[left], mesh.points[right]):
        return None
    return Bounds(found, left, right, float(bounding[found] / area[seen].sum()))


def _pairs(at: FloatArray, normal: FloatArray, close: float) -> tuple[IntArray, IntArray, IntArray]:
    """Return faces that look clockwise, faces that are where these are after a part of a turn and
    look the opposite way, and the number of such parts in a turn."""
    radius, angle = np.hypot(at[:, 0], at[:, 1]), np.arctan2(at[:, 1], at[:, 0])
    # Components along the radius, the circumference and the axis do not change by a turn.
    c, s = np.cos(angle), np.sin(angle)
    turned = np.stack([c * normal[:, 0] + s * normal[:, 1], c * normal[:, 1] - s * normal[:, 0]])
    along = close / SLOPE * np.column_stack([*turned, normal[:, 2]])
    meridian = np.column_stack([radius, at[:, 2]])
    clockwise = np.flatnonzero(turned[1] < -SLOPE)
    ahead = np.flatnonzero(turned[1] > SLOPE)
    if not len(clockwise) or not len(ahead):
        return ahead[:0], ahead[:0], ahead[:0]
    tree = cKDTree(np.hstack([meridian[ahead], along[ahead]]))
    partners = tree.query_ball_point(np.hstack([meridian, -along])[clockwise], 2.0 * close)
    left = np.repeat(clockwise, [len(one) for one in partners])
    right = ahead[np.concatenate([np.asarray(one, dtype=np.int64) for one in partners])]
    turn = (angle[right] - angle[left]) % (2.0 * np.pi)
    number = np.rint(2.0 * np.pi / np.maximum(turn, 1e-9)).astype(np.int64)
    fits = abs(turn * number - 2.0 * np.pi) * radius[left] < 2.0 * close * number
    return left[fits], right[fits], number[fits]


def _filled(around: Rings, number: IntArray) -> BoolArray:
    """Return which faces can bound one of a number of sectors, (faces,)."""
    pitch = 2.0 * np.pi / np.maximum(number, 1)
    near = np.minimum(FULL, 0.25 / np.maximum(number, 1)) * pitch
    return np.asarray((abs(around.inside - pitch) < near) & (around.slope < BESIDE))


def _apart(points: FloatArray, around: Rings, area: FloatArray, number: int) -> bool:
    """Return whether a number of sectors leaves room for all of them."""
    pitch, seen = 2.0 * np.pi / number, np.isfinite(around.inside)
    over = area[around.inside > OVERLAP * pitch].sum()
    return bool(largest_gap(points) >= OPEN * pitch and over < LITTLE * area[seen].sum())


def _on_axis(points: FloatArray, corners: IntArray) -> bool:
    """Return whether the axis z goes through a face of the surface, or is in its plane."""
    quads = corners[corners[:, 3] >= 0]
    triangles = points[np.vstack([corners[:, :3], quads[:, [0, 2, 3]]]), :2]
    after = np.roll(triangles, -1, axis=1)
    close = COINCIDENT * float(np.ptp(points, axis=0).max()) ** 2
    turn = triangles[..., 0] * after[..., 1] - triangles[..., 1] * after[..., 0]
    around = (turn > -close).all(axis=1) | (turn < close).all(axis=1)
    return bool((around & ((triangles * after).sum(axis=-1).min(axis=1) < close)).any())


def _alike(left: FloatArray, right: FloatArray) -> bool:
    """Return whether the nodes of two faces, (n, 3) and (m, 3), reach as far along r and z."""
    if not len(left) or not len(right):
        return False
    places = [np.column_stack([np.hypot(*face[:, :2].T), face[:, 2]]) for face in (left, right)]
    one, other = (np.array([each.min(axis=0), each.max(axis=0)]) for each in places)
    return bool(abs(other - one).max() <= FULL * np.ptp(one, axis=0).max())


def _nodes(of_faces: IntArray) -> IntArray:
    """Return the nodes of faces, ascending; -1 is none."""
    every = np.unique(of_faces)
    return every[every >= 0]


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
