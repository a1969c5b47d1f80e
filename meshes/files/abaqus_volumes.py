"""Reading of meshes of solids from input of Abaqus and CalculiX, .inp.

The module reads nodes, elements and sets itself, because meshio assigns elements to wrong sets if
blocks of elements share a set or have none, and reads only the last of several blocks of nodes. The
order of the nodes of tetrahedra and hexahedra is that of VTK.
"""

import re
from dataclasses import dataclass, field
from itertools import chain
from pathlib import Path

import meshio
import numpy as np

from bladewhirl.meshes.files.abaqus_reader import (
    CHANGES_THE_MESH,
    UNSOUND,
    Card,
    cards,
    extend,
    members_of,
)
from bladewhirl.meshes.files.groups import MeshFileError
from bladewhirl.meshes.files.meshio_cells import POINT

SOLIDS = {4: "tetra", 10: "tetra10", 8: "hexahedron", 20: "hexahedron20"}
"""Types of cells by the number of nodes of solid elements (C3D10 has 10 nodes)."""

SOLID = re.compile(r"(?:C3D|DC3D|F3D)(\d+).*", re.I)


@dataclass
class AbaqusMesh:
    """Nodes, elements and sets of a file, with the numbers that they have in the file.

    Names of sets are not case-sensitive; the spelling of their first occurrence is used.
    """

    points: dict[int, list[float]] = field(default_factory=dict)  #: node -> x, y, z
    elements: dict[int, list[int]] = field(default_factory=dict)  #: element -> nodes
    solids: dict[int, list[int]] = field(default_factory=dict)
    """Number of nodes of the elements of solids -> elements."""
    node_sets: dict[str, list[int]] = field(default_factory=dict)
    element_sets: dict[str, list[int]] = field(default_factory=dict)
    names: dict[str, str] = field(default_factory=dict)  #: name in capitals -> name

    def groups(self) -> dict[str, list[int]]:
        """Return the nodes of each set of nodes and of each set of elements."""
        groups = {name: list(members) for name, members in self.node_sets.items()}
        for name, members in self.element_sets.items():
            known = (self.elements.get(element, []) for element in members)
            groups[name] = [*groups.get(name, []), *dict.fromkeys(chain.from_iterable(known))]
        return groups


def abaqus_mesh(path: Path) -> meshio.Mesh:
    """Return the elements of solids of an .inp file, and its sets as sets of points.

    Raises:
        MeshFileError: the file is not a valid .inp file.
    """
    content = read_abaqus(path)
    place = {number: row for row, number in enumerate(content.points)}
    cells = []
    for size, numbers in content.solids.items():
        rows = [[place.get(node, -1) for node in content.elements[number]] for number in numbers]
        cells.append((SOLIDS.get(size, f"hexahedron{size}"), np.array(rows)))
    return meshio.Mesh(
        np.array([*content.points.values()]).reshape(-1, 3),
        cells or [(POINT, np.zeros((0, 1), dtype=np.int64))],
        point_sets={
            name: np.array([place[node] for node in members if node in place], dtype=np.int64)
            for name, members in content.groups().items()
        },
    )


def read_abaqus(path: Path) -> AbaqusMesh:
    """Read the nodes, elements and sets of an .inp file; other keywords are skipped.

    Raises:
        MeshFileError: the file is not a valid .inp file, or has keywords that generate nodes or
            elements.
    """
    try:
        text = path.read_text(encoding="utf-8", errors="replace")
    except OSError as error:
        raise MeshFileError(f"a readable file ({error.strerror})") from None
    content = AbaqusMesh()
    for card in cards(text):
        try:
            _read(card, content)
        except UNSOUND as error:
            if isinstance(error, MeshFileError):
                raise
            raise MeshFileError(f"an .inp file with valid data under *{card.keyword}") from None
    return content


def _read(card: Card, content: AbaqusMesh) -> None:
    for parameter in ("NSET", "ELSET", "NAME"):
        if given := card.parameters.get(parameter):
            card.parameters[parameter] = content.names.setdefault(given.upper(), given)
    match card.keyword:
        case "NODE":
            for number, *xyz in card.rows:
                values = [float(value or 0.0) for value in xyz[:3]]
                content.points[int(number)] = values + [0.0] * (3 - len(values))
            name = card.parameters.get("NSET")
            extend(content.node_sets, name, [int(row[0]) for row in card.rows])
        case "ELEMENT":
            _read_elements(card, content)
        case "NSET" if "ELSET" in card.parameters:
            members = content.element_sets.get(card.parameters["ELSET"], [])
            nodes = chain.from_iterable(content.elements.get(one, []) for one in members)
            extend(content.node_sets, card.needs("NSET"), list(dict.fromkeys(nodes)))
        case "NSET":
            _read_set(card, content, "NSET", content.node_sets)
        case "ELSET":
            _read_set(card, content, "ELSET", content.element_sets)
        case "SURFACE" if card.parameters.get("TYPE", "").upper() == "NODE":
            card.rows = [row[:1] for row in card.rows]
            _read_set(card, content, "NAME", content.node_sets)
        case "INSTANCE" if card.rows:
            raise MeshFileError("an *INSTANCE without translation and rotation of its part")
        case keyword if keyword in CHANGES_THE_MESH:
            raise MeshFileError(
                f"an .inp file without *{keyword}, with all nodes and elements listed"
            )


def _read_set(card: Card, content: AbaqusMesh, key: str, sets: dict[str, list[int]]) -> None:
    card.rows = [[content.names.get(v.upper(), v) for v in row if v] for row in card.rows]
    extend(sets, card.needs(key), members_of(card, sets))


def _read_elements(card: Card, content: AbaqusMesh) -> None:
    solid = SOLID.fullmatch(card.needs("TYPE"))
    if solid is None:
        rows = [[int(value) for value in row if value] for row in card.rows]
    else:  # an element of 20 nodes takes several lines
        size = int(solid[1])
        values = [int(value) for row in card.rows for value in row if value]
        if len(values) % (size + 1):
            raise MeshFileError(f"elements of {size} nodes under *ELEMENT, TYPE={solid[0]}")
        rows = [values[at : at + size + 1] for at in range(0, len(values), size + 1)]
        content.solids.setdefault(size, []).extend(row[0] for row in rows)
    for number, *nodes in rows:
        if number in content.elements:
            raise MeshFileError(f"each element once; element number {number} is defined twice")
        content.elements[number] = nodes
    extend(content.element_sets, card.parameters.get("ELSET"), [row[0] for row in rows])
