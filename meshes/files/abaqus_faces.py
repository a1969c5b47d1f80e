"""Faces of solid elements, numbered as in Abaqus and CalculiX: S1, S2 and so on."""

import re
from collections import Counter
from collections.abc import Iterator

from bladewhirl.meshes.cells import CELL_TYPES, CellType
from bladewhirl.meshes.files.abaqus_mesh import AbaqusMesh

SOLIDS = {
    "C3D4": "tetra",
    "C3D6": "wedge",
    "C3D8": "hexahedron",
    "C3D8I": "hexahedron",
    "C3D8R": "hexahedron",
    "C3D10": "tetra10",
    "C3D15": "wedge15",
    "C3D20": "hexahedron20",
    "C3D20R": "hexahedron20",
}
"""Type of the cells, named as in meshio, of each element of solids."""

FACES = {
    4: ((0, 1, 2), (0, 1, 3), (1, 2, 3), (0, 2, 3)),
    6: ((0, 1, 2), (3, 4, 5), (0, 1, 3, 4), (1, 2, 4, 5), (0, 2, 3, 5)),
    8: (
        *((0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 4, 5)),
        *((1, 2, 5, 6), (2, 3, 6, 7), (0, 3, 4, 7)),
    ),
}
"""Corners of the faces S1, S2 and so on, by the number of corners of the element."""


def surface_nodes(content: AbaqusMesh, elements: list[int], face: str) -> list[int]:
    """Return the nodes of one face of each element of solids, or of its faces without a neighbour.

    Args:
        content: contents so far.
        elements: numbers of the elements.
        face: "S1" to "S6"; "" for faces without a neighbour; none for other text.
    """
    if face and not re.fullmatch("S[1-6]", face):
        return []
    if not face:
        every = Counter(one for n in content.elements for one, _ in _faces(content, n))
        chosen = [nodes for n in elements for one, nodes in _faces(content, n) if every[one] == 1]
    else:
        place = int(face[1]) - 1
        faces = ([*_faces(content, n)] for n in elements)
        chosen = [one[place][1] for one in faces if place < len(one)]
    return [node for nodes in chosen for node in nodes]


def _faces(content: AbaqusMesh, element: int) -> Iterator[tuple[frozenset[int], list[int]]]:
    """Yield corners and all nodes of each face of an element of solids."""
    kind, nodes = SOLIDS.get(content.types.get(element, "")), content.elements.get(element, [])
    cell = CELL_TYPES[kind] if kind is not None else None
    if cell is None or len(nodes) != len(cell.reference):
        return
    for corners in FACES[len(cell.corners)]:
        inside = [*corners, *_middle(cell, corners)]
        yield frozenset(nodes[n] for n in corners), [nodes[n] for n in inside]


def _middle(cell: CellType, corners: tuple[int, ...]) -> Iterator[int]:
    """Yield the places of the mid-side nodes on a face."""
    if len(cell.reference) > len(cell.corners):
        for place, edge in enumerate(cell.edges, len(cell.corners)):
            if set(edge) <= {*corners}:
                yield place
