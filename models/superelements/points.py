"""Fewer points for pictures, where the mode shapes of all points would take too much memory."""

from collections.abc import Collection
from dataclasses import replace
from typing import Any

import numpy as np
import scipy.sparse as sp

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.superelements.decimation import decimated
from bladewhirl.models.superelements.superelement import COMPONENTS, Superelement

MANY = 6000  #: number of points of a surface from which on they are clustered first

WIDER = 1.1  #: factor by which cells grow until there are few enough of them


def with_fewer_points(
    part: Superelement, most: int, needed: Collection[int]
) -> tuple[Superelement, IntArray]:
    """Return a superelement with at most some number of points, and the numbers of these points.

    The points of a surface are those of `decimation.decimated`. Those of a surface of very many
    points, or without triangles, are clustered in the cells of a cubic grid, each of which keeps
    the point nearest to the mean of its points; triangles join clusters (Rossignac and Borrel 1993,
    Modeling in Computer Graphics).

    Args:
        part: superelement.
        most: largest number of points, apart from those needed.
        needed: numbers of points that must be kept.
    """
    count = part.point_count
    if part.points is None or count <= most:
        return part, np.arange(count)
    triangles = part.triangles
    if triangles is None or count > MANY:
        least = most if triangles is None else max(most, MANY)
        shown, triangles = _clustered(part.points, triangles, least, needed)
    if triangles is not None:
        shown, triangles = decimated(part.points, triangles, most, needed)
        triangles = np.searchsorted(shown, triangles)
    chosen: dict[str, Any] = {"points": part.points[shown], "triangles": triangles}
    for key, values in (("recovery", 3), ("stress_recovery", COMPONENTS)):
        if (matrix := getattr(part, key)) is not None:
            rows = (values * shown[:, None] + np.arange(values)).ravel()
            chosen[key] = (sp.csr_array(matrix) if sp.issparse(matrix) else matrix)[rows]
    for key in ("young_modulus", "poisson_ratio"):
        if (numbers := getattr(part, key)) is not None:
            chosen[key] = numbers[shown]
    return replace(part, **chosen), shown


def _clustered(
    points: FloatArray, triangles: IntArray | None, most: int, needed: Collection[int]
) -> tuple[IntArray, IntArray | None]:
    """Return the numbers of the points of clusters, ascending, and triangles between them; see
    `with_fewer_points`."""
    cluster = _clusters(points, most)
    own = np.array(sorted(needed), dtype=np.int64)
    cluster[own] = cluster.max() + 1 + np.arange(len(own))
    _, cluster, size = np.unique(cluster, return_inverse=True, return_counts=True)
    mean = np.stack([np.bincount(cluster, x) for x in points.T], axis=1) / size[:, None]
    distance = np.linalg.norm(points - mean[cluster], axis=1)
    order = np.lexsort((distance, cluster))
    nearest = order[np.unique(cluster[order], return_index=True)[1]]
    if triangles is None:
        return np.sort(nearest), None
    joined = nearest[cluster[triangles]]
    a, b, c = joined.T
    joined = joined[(a != b) & (b != c) & (c != a)]
    _, first = np.unique(np.sort(joined, axis=1), axis=0, return_index=True)
    return np.sort(nearest), joined[np.sort(first)] if len(first) else None


def _clusters(points: FloatArray, most: int) -> IntArray:
    """Return the number of the cell of each point, in the finest grid with few enough cells."""
    place = points - points.min(axis=0)
    width = np.linalg.norm(place.max(axis=0)) / len(points)
    while True:
        cells = np.unique((place // width).astype(np.int64), axis=0, return_inverse=True)[1].ravel()
        if cells.max() < most:
            return np.asarray(cells)
        width *= WIDER
