"""Finite elements of tetrahedra and hexahedra of scikit-fem for cells with nodes as in VTK."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from skfem import (
    ElementHex1,
    ElementHex2,
    ElementHexS2,
    ElementTetP1,
    ElementTetP2,
    MeshHex1,
    MeshHex2,
    MeshTet1,
    MeshTet2,
)

from bladewhirl.meshes.line_mesh import FloatArray

Face = tuple[tuple[int, int, int], ...]
"""Triangles that cover one face of a cell, seen counter-clockwise from outside."""

_TETRA = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
_HEXAHEDRON = np.array(
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]
)
_TETRA_EDGES = ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))
_TETRA_FACES = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2))
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
    """Finite element of one type of cell."""

    reference: FloatArray  #: nodes in the reference cell, in the order of VTK, (nodes, 3)
    edges: tuple[tuple[int, int], ...]  #: corners of each edge, in the order of mid-side nodes
    faces: tuple[tuple[int, ...], ...]  #: corners of each face, counter-clockwise from outside
    element: type[Any]  #: element of displacements
    mesh: type[Any]  #: mesh of scikit-fem, whose element describes the shape
    stiffness_order: int  #: degree to which the quadrature of the stiffness is exact
    mass_order: int  #: degree to which the quadrature of the mass is exact

    @cached_property
    def triangles(self) -> tuple[Face, ...]:
        """Triangles that cover all faces; nodes are given by their place in the cell."""
        middle = {frozenset(edge): len(self.corners) + n for n, edge in enumerate(self.edges)}
        first_order = len(self.reference) == len(self.corners)
        return tuple(_face(face, {} if first_order else middle) for face in self.faces)

    @property
    def corners(self) -> FloatArray:
        """Corners of the reference cell, (corners, 3)."""
        return self.reference[: 4 if len(self.edges) == 6 else 8]


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


_FIRST_TETRA, _FIRST_HEXAHEDRON = _reference(_TETRA), _reference(_HEXAHEDRON)
_SECOND_HEXAHEDRON = _reference(_HEXAHEDRON, _HEXAHEDRON_EDGES)
_FULL_HEXAHEDRON = _reference(_HEXAHEDRON, _HEXAHEDRON_EDGES, _HEXAHEDRON_FACES, (tuple(range(8)),))

# The quadratures are the usual ones: 1, 4, 2 x 2 x 2 and 3 x 3 x 3 points for the stiffness.
CELL_TYPES = {
    "tetra": CellType(_FIRST_TETRA, _TETRA_EDGES, _TETRA_FACES, ElementTetP1, MeshTet1, 1, 2),
    "tetra10": CellType(
        _reference(_TETRA, _TETRA_EDGES),
        *(_TETRA_EDGES, _TETRA_FACES, ElementTetP2, MeshTet2, 2, 6),
    ),
    "hexahedron": CellType(
        _FIRST_HEXAHEDRON, _HEXAHEDRON_EDGES, _HEXAHEDRON_FACES, ElementHex1, MeshHex1, 3, 3
    ),
    "hexahedron20": CellType(
        _SECOND_HEXAHEDRON, _HEXAHEDRON_EDGES, _HEXAHEDRON_FACES, ElementHexS2, MeshHex2, 5, 5
    ),
    "hexahedron27": CellType(
        _FULL_HEXAHEDRON, _HEXAHEDRON_EDGES, _HEXAHEDRON_FACES, ElementHex2, MeshHex2, 5, 5
    ),
}
