"""Surface of a solid for pictures, and evenly spaced nodes along the chord of a blade tip."""

import numpy as np

from bladewhirl.meshes.files.volumes import VolumeMesh
from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.solids.elements import ELEMENTS

OBLIQUE = 0.1
"""Largest component of a unit vector that is small."""

MOST_CORNERS, MOST_ON_FACE = 4, 9
"""Largest number of corners, and of nodes, of a face."""


def surface_faces(mesh: VolumeMesh) -> tuple[IntArray, IntArray]:
    """Return the corners of each face on the surface, counter-clockwise when seen from outside,
    (faces, 4), and all its nodes, (faces, 9), with -1 in place of those that it lacks."""
    corners: list[IntArray] = []
    nodes: list[IntArray] = []
    for name, cells in mesh.blocks:
        kind = ELEMENTS[name].cell
        for face, places in zip(kind.faces, kind.face_nodes, strict=True):
            for rows, of, width in ((corners, face, MOST_CORNERS), (nodes, places, MOST_ON_FACE)):
                row = np.full((len(cells), width), -1)
                row[:, : len(of)] = cells[:, of]
                rows.append(row)
    every = np.concatenate(corners)
    keys = np.sort(every, axis=1)
    _, first, count = np.unique(keys, axis=0, return_index=True, return_counts=True)
    outside = np.sort(first[count == 1])
    return every[outside], np.concatenate(nodes)[outside]


def surface_triangles(mesh: VolumeMesh) -> tuple[IntArray, IntArray]:
    """Return the nodes on the surface, (p,), and triangles between them, (t, 3). Corners of
    triangles are positions in the first array, counter-clockwise when seen from outside."""
    keys, covers, places = [], [], []
    for block, (name, cells) in enumerate(mesh.blocks):
        kind = ELEMENTS[name].cell
        for number, (face, cover) in enumerate(zip(kind.faces, kind.triangles, strict=True)):
            corners = np.full((len(cells), MOST_CORNERS), -1)
            corners[:, : len(face)] = cells[:, face]
            keys.append(np.sort(corners, axis=1))
            covers += [*cells[:, cover]]
            places += [(block, cell, number) for cell in range(len(cells))]
    _, first, count = np.unique(np.concatenate(keys), axis=0, return_index=True, return_counts=True)
    outside = sorted(first[count == 1].tolist(), key=places.__getitem__)
    triangles = np.concatenate([covers[face] for face in outside])
    shown, numbers = np.unique(triangles, return_inverse=True)
    return shown, numbers.reshape(-1, 3)


def evenly_along_chord(points: FloatArray, nodes: IntArray, count: int) -> IntArray:
    """Return nodes that are evenly spaced along a chord, in the middle of the thickness.

    The chord is the direction in which the nodes spread most; nodes are numbered along the axis of
    rotation z or, if the chord is hardly inclined to the plane of rotation, along y or x. The
    middle line is a parabola through the nodes; the nearest node to each of its evenly spaced
    points is chosen, each node at most once.

    Args:
        points: positions of all nodes [m], (n, 3).
        nodes: nodes among which to choose, at least `count`.
        count: number of nodes to choose.
    """
    if len(nodes) == 1:
        return nodes
    place = points[nodes] - points[nodes].mean(axis=0)
    _, _, directions = np.linalg.svd(place, full_matrices=False)
    directions = directions * _sign(directions[0])
    along, across = place @ directions[0], place @ directions[1]
    degree = min(2, len(np.unique(along.round(12))) - 1)
    middle = np.polynomial.Polynomial.fit(along, across, degree)
    chosen: list[int] = []
    for station in np.linspace(along.min(), along.max(), count):
        distance = np.hypot(along - station, across - middle(station))
        distance[chosen] = np.inf
        chosen.append(int(distance.argmin()))
    return np.asarray(nodes[chosen])


def _sign(direction: FloatArray) -> float:
    """Return the sign of the first component in the order z, y, x that is not small, so that it
    does not depend on rounding errors or on the order of the nodes."""
    return float(np.sign(next(one for one in direction[::-1] if abs(one) > OBLIQUE)))
