"""Points at one place."""

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray, IntArray

COINCIDENT = 1e-5
"""Points are at one place up to a distance of this fraction of the size of a part."""


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
    from scipy.spatial import KDTree

    # One point of each box is compared, so that there are few pairs even if all points coincide.
    boxes = np.floor(points / (distance / np.sqrt(3.0)))
    _, first, box = np.unique(boxes, axis=0, return_index=True, return_inverse=True)
    pairs = KDTree(points[first]).query_pairs(distance, output_type="ndarray")
    links = coo_array((np.ones(len(pairs)), pairs.T), shape=(len(first), len(first)))
    group = connected_components(links, directed=False)[1][box.ravel()]
    _, first, place = np.unique(group, return_index=True, return_inverse=True)
    return np.asarray(np.argsort(np.argsort(first))[place])
