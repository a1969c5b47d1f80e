"""Points at one place."""

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray, IntArray

COINCIDENT = 1e-5
"""Points are at one place up to a distance of this fraction of the size of a part."""


MOST_PAIRS = 1_000_000
"""Largest number of pairs whose distances are all computed, without loading scipy.spatial."""


def near_pairs(points: FloatArray, others: FloatArray, distance: float) -> IntArray:
    """Return the pairs of a point and another one within a distance of each other, (pairs, 2).

    Args:
        points: positions [m], (points, 3).
        others: positions [m], (others, 3).
        distance: largest distance [m].
    """
    if len(points) * len(others) <= MOST_PAIRS:
        apart = points[:, None] - others
        return np.argwhere(np.einsum("ijx,ijx->ij", apart, apart) <= distance**2)
    from scipy.spatial import KDTree  # long to load

    trees = KDTree(points), KDTree(others)
    near = trees[0].sparse_distance_matrix(trees[1], distance, output_type="ndarray")
    return np.column_stack([near["i"], near["j"]])


def places_of(points: FloatArray, distance: float) -> IntArray:
    """Return the number of the place of each point, (points,).

    Points within a distance of each other are at one place, also through other points. Places are
    numbered from 0 in the order of their first points.

    Args:
        points: positions [m], (points, 3).
        distance: largest distance [m], positive.
    """
    from scipy.sparse import coo_array  # loaded only if a mesh or a superelement is used
    from scipy.sparse.csgraph import connected_components

    # One point of each box is compared, so that there are few pairs even if all points coincide.
    boxes = np.floor(points / (distance / np.sqrt(3.0)))
    _, first, box = np.unique(boxes, axis=0, return_index=True, return_inverse=True)
    pairs = near_pairs(points[first], points[first], distance)
    links = coo_array((np.ones(len(pairs)), pairs.T), shape=(len(first), len(first)))
    group = connected_components(links, directed=False)[1][box.ravel()]
    _, first, place = np.unique(group, return_index=True, return_inverse=True)
    return np.asarray(np.argsort(np.argsort(first))[place])
