"""Shapes of the cells of solids, with nodes in the order of VTK, which is also that of Abaqus."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray

Face = tuple[tuple[int, int, int], ...]
"""Triangles that cover one face of a cell, seen counter-clockwise from outside."""

_TETRA = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
_WEDGE = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1]])
_HEXAHEDRON = np.array(
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]
)
_TETRA_EDGES = ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))
_TETRA_FACES = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2))
_WEDGE_EDGES = (
    *((0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3)),
    *((0, 3), (1, 4), (2, 5)),
)
_WEDGE_FACES = ((0, 2, 1), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5))
_HEXAHEDRON_EDGES = (
    *((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6)),
    *((6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)),
)
_HEXAHEDRON_FACES = (
    *((0, 4, 7, 3), (1, 2, 6, 5), (0, 1, 5, 4)),
    *((3, 7, 6, 2), (0, 3, 2, 1), (4, 5, 6, 7)),
)
"""Edges and faces in the order of the mid-side nodes in VTK."""


def _reference(corners: FloatArray, *sides: tuple[tuple[int, ...], ...]) -> FloatArray:
    """Return corners, followed by the centres of edges, faces and the cell."""
    return np.array([*corners, *(corners[[*side]].mean(axis=0) for side in sum(sides, ()))])


@dataclass(frozen=True)
class CellType:
    """Shape of one type of cell."""

    reference: FloatArray  #: nodes in the reference cell, in the order of VTK, (nodes, 3)
    edges: tuple[tuple[int, int], ...]  #: corners of each edge, in the order of mid-side nodes
    faces: tuple[tuple[int, ...], ...]  #: corners of each face, counter-clockwise from outside

    @cached_property
    def triangles(self) -> tuple[Face, ...]:
        """Triangles that cover each face; nodes are given by their place in the cell."""
        middle = {frozenset(edge): len(self.corners) + n for n, edge in enumerate(self.edges)}
        first_order = len(self.reference) == len(self.corners)
        return tuple(_face(face, {} if first_order else middle) for face in self.faces)

    @cached_property
    def face_nodes(self) -> tuple[list[int], ...]:
        """Places in the cell of all nodes on each face."""
        at = self.reference
        normals = [np.cross(at[b] - at[a], at[c] - at[a]) for a, b, c, *_ in self.faces]
        flat = [
            abs((at - at[face[0]]) @ n) < 1e-9 for face, n in zip(self.faces, normals, strict=True)
        ]
        return tuple(np.flatnonzero(on).tolist() for on in flat)

    @property
    def corners(self) -> FloatArray:
        """Corners of the reference cell, (corners, 3)."""
        return self.reference[: {6: 4, 9: 6, 12: 8}[len(self.edges)]]


def _face(face: tuple[int, ...], middle: dict[frozenset[int], int]) -> Face:
    """Return triangles that cover a face. With mid-side nodes, one triangle at each corner comes
    first, then triangles between the mid-side nodes; a node at the centre of the face is not used.
    """
    ring = list(face)
    cut: list[tuple[int, int, int]] = []
    if middle:
        mid = [middle[frozenset((a, b))] for a, b in zip(face, face[1:] + face[:1], strict=True)]
        cut = [(corner, mid[n], mid[n - 1]) for n, corner in enumerate(face)]
        ring = mid
    return (*cut, *((ring[0], ring[n], ring[n + 1]) for n in range(1, len(ring) - 1)))


_CENTRES = (_HEXAHEDRON_EDGES, _HEXAHEDRON_FACES, (tuple(range(8)),))
CELL_TYPES = {
    "tetra": CellType(_reference(_TETRA), _TETRA_EDGES, _TETRA_FACES),
    "tetra10": CellType(_reference(_TETRA, _TETRA_EDGES), _TETRA_EDGES, _TETRA_FACES),
    "wedge": CellType(_reference(_WEDGE), _WEDGE_EDGES, _WEDGE_FACES),
    "wedge15": CellType(_reference(_WEDGE, _WEDGE_EDGES), _WEDGE_EDGES, _WEDGE_FACES),
    "hexahedron": CellType(_reference(_HEXAHEDRON), _HEXAHEDRON_EDGES, _HEXAHEDRON_FACES),
    "hexahedron20": CellType(
        _reference(_HEXAHEDRON, _HEXAHEDRON_EDGES), _HEXAHEDRON_EDGES, _HEXAHEDRON_FACES
    ),
    "hexahedron27": CellType(
        _reference(_HEXAHEDRON, *_CENTRES), _HEXAHEDRON_EDGES, _HEXAHEDRON_FACES
    ),
}
"""Shapes by the names of meshio."""
