"""Surfaces with fewer points, which keep their edges and corners.

Points are moved onto neighbours, those first whose planes are nearest to that neighbour (Garland
and Heckbert 1997, SIGGRAPH, with the quadric of the removed point alone, and with neighbours as the
only places).
"""

from collections.abc import Collection

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray, IntArray

EVEN = 1e-3
"""Share of the square of the length of an edge that adds to the square of the distance from planes,
so that plane surfaces keep points, too."""

ROUND = 0.1
"""Share of the points of which so many are moved before the distances are computed again, those
whose neighbours have not changed."""

TURNED = 0.2  #: least cosine of the angle by which a triangle turns


def decimated(
    points: FloatArray, triangles: IntArray, most: int, needed: Collection[int]
) -> tuple[IntArray, IntArray]:
    """Return the numbers of the points that are left, ascending, and triangles between these
    numbers, (t, 3); more points than demanded if others cannot be removed.

    Args:
        points: positions [m], (n, 3).
        triangles: points of each triangle, (t, 3).
        most: largest number of points, apart from those needed.
        needed: numbers of points that must be left.
    """
    surface, fixed = _Surface(points, triangles), set(needed)
    left = len(np.setdiff1d(triangles, [*fixed]))
    while left > most:
        enough, changed = left - max(1, min(left - most, int(ROUND * left))), set[int]()
        for one, other in surface.ways():
            if one in changed or other in changed or one in fixed or not surface.move(one, other):
                continue
            changed |= surface.neighbours(other) | {one, other}
            left -= 1
            if left == enough:
                break
        if not changed:
            break
    kept = surface.triangles
    return np.union1d(kept, np.array([*fixed], dtype=np.int64)), kept


class _Surface:
    """Triangles, with the planes of those at each point."""

    def __init__(self, points: FloatArray, triangles: IntArray) -> None:
        self._points = points
        self._corners: list[tuple[int, ...] | None] = [tuple(one) for one in triangles.tolist()]
        self._faces_of: list[set[int]] = [set() for _ in points]
        for number, face in enumerate(triangles.tolist()):
            for corner in face:
                self._faces_of[corner].add(number)
        a, b, c = (points[one] for one in triangles.T)
        normal = np.cross(b - a, c - a)
        area = np.linalg.norm(normal, axis=1)
        normal /= np.maximum(area, np.finfo(float).tiny)[:, None]
        planes = np.column_stack([normal, -np.einsum("ti,ti->t", normal, a)])
        own = area[:, None, None] * planes[:, :, None] * planes[:, None]
        self._planes = np.zeros((len(points), 4, 4))
        self._area = np.zeros(len(points))
        for corner in triangles.T:
            np.add.at(self._planes, corner, own)
            np.add.at(self._area, corner, area)

    @property
    def triangles(self) -> IntArray:
        """Triangles that are left, (t, 3)."""
        return np.array([face for face in self._corners if face], dtype=np.int64).reshape(-1, 3)

    def neighbours(self, one: int) -> set[int]:
        faces = (self._corners[each] for each in self._faces_of[one])
        return {corner for face in faces for corner in face or ()} - {one}

    def ways(self) -> list[list[int]]:
        """Return points and neighbours onto which they can be moved, the least change first."""
        sides = self.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
        ways = np.unique(np.vstack([sides, sides[:, ::-1]]), axis=0)
        one, other = ways.T
        places = np.column_stack([self._points[other], np.ones(len(other))])
        away = ((self._points[other] - self._points[one]) ** 2).sum(axis=1)
        cost = np.einsum("ni,nij,nj->n", places, self._planes[one], places)
        order = np.argsort(cost + EVEN * self._area[one] * away, kind="stable")
        found: list[list[int]] = ways[order].tolist()
        return found

    def move(self, one: int, other: int) -> bool:
        """Move a point onto a neighbour, unless the surface would fold; return whether it did."""
        lost = self._faces_of[one] & self._faces_of[other]
        stay = sorted(self._faces_of[one] - lost)
        if len(self.neighbours(one) & self.neighbours(other)) != len(lost) or not stay:
            return False
        before = np.array([self._corners[each] for each in stay])
        after = np.where(before == one, other, before)
        normals = [
            np.cross(*(self._points[face[:, k]] - self._points[face[:, 0]] for k in (1, 2)))
            for face in (before, after)
        ]
        sizes = np.linalg.norm(normals[0], axis=1) * np.linalg.norm(normals[1], axis=1)
        if (np.einsum("fi,fi->f", *normals) <= TURNED * sizes).any():
            return False
        for each in lost:
            for corner in self._corners[each] or ():
                self._faces_of[corner].discard(each)
            self._corners[each] = None
        for each, face in zip(stay, after.tolist(), strict=True):
            self._corners[each] = tuple(face)
            self._faces_of[other].add(each)
        self._faces_of[one] = set()
        self._planes[other] += self._planes[one]
        self._area[other] += self._area[one]
        return True
