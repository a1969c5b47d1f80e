"""Meshes of solids in bulk data of Nastran, read with pyyeti: free, small and large fields.

Groups are the nodes of SPC1 and SPC entries that hold x, y and z (``SPC1 5``), of SET1 entries and
of SET commands (``SET 9``), and the elements of each property (``PSOLID 1``), which also have the
material of its MAT1 entry.
"""

import re
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import meshio
import numpy as np

from bladewhirl.files import open_text
from bladewhirl.meshes.files.abaqus_solids import Section, SolidMesh
from bladewhirl.meshes.files.groups import MeshFileError, check_numbers, constant
from bladewhirl.meshes.files.meshio_cells import readable
from bladewhirl.meshes.line_mesh import IntArray

CELLS = {
    "CTETRA": {4: "tetra", 10: "tetra10"},
    "CPENTA": {6: "wedge", 15: "wedge15"},
    "CHEXA": {8: "hexahedron", 20: "hexahedron20"},
}
"""Type of the cell by the entry and the number of nodes, named as in meshio."""

ORDERS = {
    "wedge15": [*range(9), 12, 13, 14, 9, 10, 11],
    "hexahedron20": [*range(12), 16, 17, 18, 19, 12, 13, 14, 15],
}
"""Places of the nodes of VTK among those of Nastran, where upright edges come before upper ones."""

OTHER_SOLIDS = ("CPYRAM", "CPYRA", "CTETRAR", "CHEXA1", "CHEXA2")
IGNORED = ("RBE2", "RBE3", "CONM2", "CELAS2", "CBUSH", "CBAR", "CBEAM", "CQUAD4", "CTRIA3")
"""Entries that connect or load nodes and are not read."""

OTHER_MATERIALS = ("MAT2", "MAT9", "MAT10", "MAT11")

ENTRIES = (
    *("GRID", "GRDSET", "PSOLID", "MAT1", "SPC1", "SPC", "SET1"),
    *(*CELLS, *OTHER_SOLIDS, *OTHER_MATERIALS, *IGNORED),
)
"""Names of the entries that are looked for."""

Cards = Mapping[str, list[list[Any]]]
"""Fields of all entries by their name; none for other names."""

SET = re.compile(r"^[ \t]*SET[ \t]+(\d+)[ \t]*=[ \t]*((?:.*,[ \t]*\n)*.*)$", re.I | re.M)
INCLUDE = re.compile(r"^[ \t]*INCLUDE\b", re.I | re.M)


class _Material(Section):
    """Material of the elements of one property."""

    __slots__ = ()

    def missing(self, key: str) -> str:
        field = {"density": "RHO", "young_modulus": "E", "poisson_ratio": "NU"}[key]
        if self.unread:
            return f"material {self.material} of {self.group} is {self.unread}, which is not read"
        return f"{self.group} has no MAT1 {self.material} with {field}"


def nastran_mesh(path: Path) -> SolidMesh:
    """Return the elements CTETRA, CPENTA and CHEXA of bulk data, with its sets.

    Raises:
        MeshFileError: pyyeti is not installed, the file cannot be read, or has other elements of
            solids, pyramids for instance, or nodes in other than the basic coordinates.
    """
    try:
        from pyyeti.nastran import bulk
    except ImportError:
        needed = "pip install 'bladewhirl[nastran]'"
        raise MeshFileError(f"pyyeti, which reads bulk data of Nastran: {needed}") from None
    with readable(path, "pyyeti"):
        with open_text(path, errors="replace") as stream:
            text = stream.read()
        check_numbers(text.splitlines())
        options = {"return_var": "list", "no_data_return": [], "follow_includes": False}
        pattern = f"({'|'.join(ENTRIES)})"  # of the start of a line
        found = bulk.rdcards(str(path), pattern, regex=True, keep_name=True, **options)
        cards = defaultdict[str, list[list[Any]]](list)
        for name, *values in found:
            cards[name.strip().rstrip("*").upper()].append(values)
        if INCLUDE.search(text):
            raise MeshFileError("one file with all bulk data, without INCLUDE")
        if others := [name for name in OTHER_SOLIDS if name in cards]:
            raise MeshFileError(f"elements CTETRA, CPENTA and CHEXA; found {others[0]}")
        ignored = (name for name in IGNORED if name in cards)
        return _mesh(cards, text)._replace(ignored=(*ignored,))


def _mesh(cards: Cards, text: str) -> SolidMesh:
    grid = cards["GRID"]
    default = [row[1] for row in cards["GRDSET"] if row[1:] and row[1]]
    turned = [row[0] for row in grid if row[1] not in ("", 0)]
    if turned or default:
        what = f"node {turned[0]} is in another one" if turned else "GRDSET states another one"
        raise MeshFileError(f"nodes in the basic coordinate system; {what}")
    place = {int(row[0]): number for number, row in enumerate(grid)}
    points = [[float(x or 0.0) for x in (*row[2:5], "", "", "")[:3]] for row in grid]
    rows = defaultdict[str, list[list[int]]](list)
    members = defaultdict[str, defaultdict[str, list[int]]](lambda: defaultdict(list))
    for entry, types in CELLS.items():
        for number, property_, *nodes in cards[entry]:
            while nodes and nodes[-1] == "":
                nodes.pop()
            if len(nodes) not in types or "" in nodes:
                counts = " or ".join(map(str, types))
                raise MeshFileError(f"{counts} nodes of each {entry}; element {number} has others")
            kind = types[len(nodes)]
            members[f"PSOLID {property_ or number}"][kind].append(len(rows[kind]))
            rows[kind].append([place.get(node, -1) for node in nodes])
    cells = [
        (kind, np.array(one)[:, ORDERS.get(kind, list(range(len(one[0]))))])
        for kind, one in rows.items()
    ]
    properties = {f"PSOLID {row[0]}": row[1] for row in cards["PSOLID"]}
    sets = {
        name: np.array([place[node] for node in nodes if node in place], dtype=np.int64)
        for name, nodes in _node_sets(cards, text, list(place))
    }
    mesh = meshio.Mesh(
        np.array(points),
        cells,
        point_sets=sets,
        cell_sets={
            name: [np.array(of_kind[kind], dtype=np.int64) for kind, _ in cells]
            for name, of_kind in members.items()
        },
    )
    return SolidMesh(mesh, sections=tuple(_materials(cards, properties, list(members))))


def _node_sets(cards: Cards, text: str, nodes: list[int]) -> Iterator[tuple[str, list[int]]]:
    """Yield name and nodes of each set; entries with one number are one set."""
    sets = defaultdict[str, list[int]](list)
    for number, components, *members in cards["SPC1"]:
        if {*"123"} <= {*str(components)}:
            sets[f"SPC1 {number}"] += _listed(members, nodes)
    for number, *rest in cards["SPC"]:
        for node, components in zip(rest[::3], rest[1::3], strict=False):
            if {*"123"} <= {*str(components)}:
                sets[f"SPC {number}"].append(node)
    for number, *members in cards["SET1"]:
        sets[f"SET {number}"] += _listed(members, nodes)
    for found in SET.finditer(text):
        words = found[2].replace(",", " ").replace("=", " ").upper().split()
        if all(word == "THRU" or word.isdigit() for word in words):
            members = [word if word == "THRU" else int(word) for word in words]
            sets[f"SET {found[1]}"] += _listed(members, nodes)
    yield from sets.items()


def _listed(members: Sequence[Any], nodes: list[int]) -> list[int]:
    """Return the nodes of a list in which THRU stands between the ends of a range."""
    chosen: list[int] = []
    given = [member for member in members if member != ""]
    numbers: IntArray = np.array(nodes)
    for place, member in enumerate(given):
        if member == "THRU":
            first, last = given[place - 1], given[place + 1]
            chosen += numbers[(numbers > first) & (numbers < last)].tolist()
        else:
            chosen.append(int(member))
    return chosen


def _materials(cards: Cards, properties: dict[str, Any], used: list[str]) -> Iterator[_Material]:
    """Yield the material of each property of the elements."""
    constants = {row[0]: (*row[1:5], "", "", "", "")[:4] for row in cards["MAT1"]}
    others = {row[0]: name for name in OTHER_MATERIALS for row in cards[name]}
    for name in used:
        number = properties.get(name, "")
        young, shear, ratio, density = constants.get(number, ("", "", "", ""))
        if ratio == "" and young and shear:
            ratio = young / (2.0 * shear) - 1.0
        given = {"young_modulus": young, "poisson_ratio": ratio, "density": density}
        values = {
            key: constant(key, float(value), f" (MAT1 {number})")
            for key, value in given.items()
            if value != ""
        }
        yield _Material(name, str(number), values, others.get(number, ""))
