"""Reading of meshes of lines and of solids from input of Abaqus and CalculiX, .inp.

Groups are sets: NSET for nodes, ELSET for elements. The data of lines are rectangular sections with
their materials (BEAM SECTION, ELASTIC, DENSITY) and point masses (MASS, ROTARYI); their units are
the choice of the author of the file. The order of the nodes of tetrahedra and hexahedra is that of
VTK.

meshio is not used, although it reads such files. meshio assigns elements to wrong sets if blocks of
elements share a set or have none, reads only the last of several blocks of nodes, and supports
neither B23 elements nor sections. This module therefore reads the few relevant keywords itself.
Keywords that would change the mesh without being evaluated are an error.
"""

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import chain
from pathlib import Path
from typing import NamedTuple

import meshio
import numpy as np

from bladewhirl.files import open_text
from bladewhirl.meshes.files.groups import GroupedLines, MeshFileError, in_plane
from bladewhirl.meshes.files.meshio_cells import POINT
from bladewhirl.meshes.line_mesh import FloatArray, IntArray

STRAIGHT = re.compile(r"(T[23]D2|B[23][13]|PIPE[23]1|FRAME[23]D)(OS|R)?H?")
CURVED = re.compile(r"(T[23]D3|B[23]2|PIPE[23]2)(OS|R)?H?")
POINT_MASSES = {"MASS": "mass", "ROTARYI": "inertia"}
"""Types of elements with one node, and the names of their data."""

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

SOLID = re.compile(r"(?:A?C3D|DC3D|F3D)(\d+).*")
"""Elements of solids, whether supported or not; the number is that of their nodes."""

SECTION = ("width", "thickness", "young_modulus", "density")
OWN_SETS = re.compile(r"(section|mass|inertia)-\d+", re.I)
"""Names of sets that the writer makes for sections and masses; they are not groups of the mesh."""

CHANGES_THE_MESH = frozenset(
    ["INCLUDE", "SYSTEM", "NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY", "NODETHICKNESS"]
)

MOST_MEMBERS = 1_000_000  #: largest number of members of a set that is given by ranges


@dataclass
class Card:
    """A keyword with its parameters and the data lines after it."""

    keyword: str
    parameters: dict[str, str]
    rows: list[list[str]] = field(default_factory=list)

    def needs(self, name: str) -> str:
        """Return the value of a required parameter."""
        if name not in self.parameters:
            raise MeshFileError(f"*{self.keyword} with {name}=")
        return self.parameters[name]


@dataclass
class AbaqusMesh:
    """Contents of a file, with the numbers that nodes and elements have in the file.

    Names of sets are not case-sensitive; the spelling of their first occurrence is used.
    """

    points: dict[int, list[float]] = field(default_factory=dict)  #: node -> x, y, z
    elements: dict[int, list[int]] = field(default_factory=dict)  #: element -> nodes
    types: dict[int, str] = field(default_factory=dict)  #: element -> type, in capitals
    node_sets: dict[str, list[int]] = field(default_factory=dict)
    element_sets: dict[str, list[int]] = field(default_factory=dict)
    names: dict[str, str] = field(default_factory=dict)  #: name in capitals -> name
    solid_sections: list[tuple[str, str]] = field(default_factory=list)  #: set and material
    sections: list[tuple[str, str, float, float]] = field(default_factory=list)
    """Set, material, width and thickness of each rectangular section."""
    materials: dict[str, dict[str, float]] = field(default_factory=dict)
    unread: dict[str, str] = field(default_factory=dict)  #: material -> keyword that is not read
    masses: list[tuple[str, str, float]] = field(default_factory=list)  #: type of data, set, value
    material: str = ""  #: name of the material that is being read

    def nodes_of(self, elements: Iterable[int]) -> list[int]:
        """Return the nodes of elements, each once; elements that are not defined are skipped."""
        return [*dict.fromkeys(chain.from_iterable(self.elements.get(n, []) for n in elements))]

    def groups(self) -> dict[str, list[int]]:
        """Return the nodes of each set of nodes and of each set of elements."""
        groups = {name: list(members) for name, members in self.node_sets.items()}
        for name, members in self.element_sets.items():
            groups[name] = [*groups.get(name, []), *self.nodes_of(members)]
        return groups


class Section(NamedTuple):
    """Material of a group of cells, in the units of the file."""

    group: str  #: name of the group
    material: str  #: name of the material
    properties: Mapping[str, float]  #: young_modulus, poisson_ratio and density, as far as given
    unread: str  #: keyword of the material that is not read, or nothing

    def missing(self, key: str) -> str:
        """Return why a property is missing."""
        keyword = self.unread or ("*DENSITY" if key == "density" else "an isotropic *ELASTIC")
        verb = f"has {keyword}, which is not read" if self.unread else f"lacks {keyword}"
        return f"material {self.material} of their set {self.group} {verb}"


class SolidMesh(NamedTuple):
    """Mesh of meshio with what it cannot hold."""

    mesh: meshio.Mesh
    elements: tuple[str, ...] = ()  #: element of each block of cells; empty if the source has none
    sections: tuple[Section, ...] = ()  #: materials of groups of cells; later ones replace earlier


def abaqus_mesh(path: Path) -> SolidMesh:
    """Return the solid elements of an .inp file, and its sets as sets of points.

    Raises:
        MeshFileError: the file is not a valid .inp file, or has elements that are not supported.
    """
    content = read_abaqus(path)
    place = {number: row for row, number in enumerate(content.points)}
    solids: dict[str, list[list[int]]] = {}
    cell: dict[int, tuple[str, int]] = {}
    for number, kind in content.types.items():
        if SOLID.fullmatch(kind):
            rows = solids.setdefault(kind, [])
            cell[number] = kind, len(rows)
            rows.append([place.get(node, -1) for node in content.elements[number]])
    if other := [kind for kind in solids if kind not in SOLIDS]:
        raise MeshFileError(
            f"elements of the types {', '.join(SOLIDS)}; found {len(solids[other[0]])} of type"
            f" {other[0]}{_instead(other[0])}"
        )
    cells = [(SOLIDS[kind], np.array(rows)) for kind, rows in solids.items()]
    members = {name: [cell[n] for n in m if n in cell] for name, m in content.element_sets.items()}
    mesh = meshio.Mesh(
        np.array([*content.points.values()]).reshape(-1, 3),
        cells or [(POINT, np.zeros((0, 1), dtype=np.int64))],
        point_sets=_by_place(content.groups(), place),
        cell_sets={
            name: [np.array([row for k, row in chosen if k == kind], dtype=int) for kind in solids]
            for name, chosen in members.items()
            if chosen
        },
    )
    return SolidMesh(mesh, tuple(solids), tuple(_sections(content)))


def _sections(content: AbaqusMesh) -> Iterator[Section]:
    for group, material in content.solid_sections:
        if material.upper() not in content.materials:
            raise MeshFileError(f"*MATERIAL, NAME={material}, which a *SOLID SECTION names")
        unread = content.unread.get(material.upper(), "")
        properties = {
            key: value
            for key, value in content.materials[material.upper()].items()
            if not unread.startswith("*DENSITY" if key == "density" else "*ELASTIC")
        }
        yield Section(group, material, properties, unread)


def _instead(kind: str) -> str:
    """Return the supported elements with the nodes of another one, as the end of a message."""
    size = SOLID.sub(r"C3D\1", kind)
    alike = [name for name in SOLIDS if name.rstrip("IR") == size]
    return f"; write {' or '.join(alike)} if that is what you mean" if alike else ""


def read_abaqus(path: Path) -> AbaqusMesh:
    """Read nodes, elements, sets, sections and masses of an .inp file; other keywords are skipped.

    Raises:
        MeshFileError: the file is not a valid .inp file, or has keywords that generate nodes or
            elements.
    """
    try:
        with open_text(path, errors="replace") as stream:
            text = stream.read()
    except OSError as error:
        raise MeshFileError(f"a readable file ({error.strerror})") from None
    content = AbaqusMesh()
    for card in cards(text):
        try:
            _read(card, content)
        except MeshFileError:
            raise
        except (ValueError, IndexError, KeyError, OverflowError):
            raise MeshFileError(f"an .inp file with valid data under *{card.keyword}") from None
    return content


def cards(text: str) -> Iterator[Card]:
    """Yield the keywords of an .inp file; comments are skipped, continued lines are joined."""
    card: Card | None = None
    lines = iter(line for line in text.splitlines() if line.strip() and not line.startswith("**"))
    for line in lines:
        if not line.startswith("*"):
            if card is None:
                raise MeshFileError("an .inp file that begins with a keyword such as *NODE")
            card.rows.append([part.strip() for part in line.rstrip().rstrip(",").split(",")])
            continue
        parts = [line.rstrip()]
        while parts[-1].endswith(","):
            following = next(lines, None)
            if following is None:
                raise MeshFileError("another line: the last line ends with a comma")
            parts.append(following.rstrip())
        line = "".join(parts)
        if card is not None:
            yield card
        keyword, *parameters = (part.strip() for part in line[1:].split(","))
        pairs = (parameter.partition("=") for parameter in parameters if parameter)
        values = {key.strip().upper(): value.strip().strip('"') for key, _, value in pairs}
        card = Card(" ".join(keyword.upper().split()), values)
    if card is None:
        raise MeshFileError("an .inp file, with keywords such as *NODE")
    yield card


def _read(card: Card, content: AbaqusMesh) -> None:
    """Add the data of a keyword to the contents; irrelevant keywords are skipped."""
    for parameter in ("NSET", "ELSET", "NAME"):
        if given := card.parameters.get(parameter):
            card.parameters[parameter] = content.names.setdefault(given.upper(), given)
    match card.keyword:
        case "NODE":
            _read_nodes(card, content)
        case "ELEMENT":
            _read_elements(card, content)
        case "NSET" if "ELSET" in card.parameters:
            elements = content.element_sets.get(card.parameters["ELSET"], [])
            extend(content.node_sets, card.needs("NSET"), content.nodes_of(elements))
        case "NSET":
            _read_set(card, content, "NSET", content.node_sets)
        case "ELSET":
            _read_set(card, content, "ELSET", content.element_sets)
        case "SURFACE" if card.parameters.get("TYPE", "").upper() == "NODE":
            card.rows = [row[:1] for row in card.rows]
            _read_set(card, content, "NAME", content.node_sets)
        case "BEAM SECTION" if card.parameters.get("SECTION", "").upper() == "RECT":
            _read_section(card, content)
        case "MATERIAL":
            content.material = card.needs("NAME").upper()
            content.materials[content.material] = {}
        case "SOLID SECTION":
            section = card.needs("ELSET"), card.parameters.get("MATERIAL", "")
            content.solid_sections.append(section)
        case "ELASTIC" | "DENSITY":
            _read_property(card, content)
        case "MASS":
            content.masses.append(("mass", card.needs("ELSET"), float(card.rows[0][0])))
        case "ROTARY INERTIA":
            content.masses.append(("inertia", card.needs("ELSET"), float(card.rows[0][-1])))
        case "INSTANCE" if card.rows:
            raise MeshFileError("an *INSTANCE without translation and rotation of its part")
        case keyword if keyword in CHANGES_THE_MESH:
            raise MeshFileError(
                f"an .inp file without *{keyword}, with all nodes and elements listed"
            )


def _read_nodes(card: Card, content: AbaqusMesh) -> None:
    if card.parameters.get("SYSTEM", "R").upper() != "R":
        raise MeshFileError("nodes in Cartesian coordinates, *NODE without SYSTEM")
    for number, *coordinates in card.rows:
        xyz = [float(value or 0.0) for value in coordinates[:3]]
        xyz += [0.0] * (3 - len(xyz))
        if content.points.setdefault(int(np.int64(number)), xyz) != xyz:  # at most 64 bits
            raise MeshFileError(
                f"each node at most once; node number {number} is defined twice"
                " (only one part per file can be read)"
            )
    extend(content.node_sets, card.parameters.get("NSET"), [int(row[0]) for row in card.rows])


def _read_elements(card: Card, content: AbaqusMesh) -> None:
    kind = card.needs("TYPE").upper()
    rows = [[int(value) for value in row if value] for row in card.rows]
    if solid := SOLID.fullmatch(kind):  # an element of 20 nodes takes several lines
        length, values = int(solid[1]) + 1, [*chain.from_iterable(rows)]
        if len(values) % length:
            raise MeshFileError(f"elements of {length - 1} nodes under *ELEMENT, TYPE={kind}")
        rows = [values[at : at + length] for at in range(0, len(values), length)]
    for number, first, *others in rows:
        if number in content.elements:
            raise MeshFileError(f"each element once; element number {number} is defined twice")
        content.elements[number], content.types[number] = [first, *others], kind
    extend(content.element_sets, card.parameters.get("ELSET"), [row[0] for row in rows])


def _read_property(card: Card, content: AbaqusMesh) -> None:
    """Read a property of the material that is being read; solids need one that is constant."""
    kind = card.parameters.get("TYPE", "ISOTROPIC").upper()
    values = [float(value) for value in card.rows[0] if value]
    if card.keyword == "ELASTIC" and not kind.startswith("ISO"):
        content.unread[content.material] = f"*ELASTIC, TYPE={kind}"
        return
    names = ("density",) if card.keyword == "DENSITY" else ("young_modulus", "poisson_ratio")
    content.materials[content.material] |= dict(zip(names, values, strict=False))
    if len(card.rows) > 1:
        content.unread[content.material] = f"*{card.keyword} for several temperatures"


def _read_section(card: Card, content: AbaqusMesh) -> None:
    first, second = (float(value) for value in card.rows[0][:2])
    axis = [float(value) for value in card.rows[1]] if len(card.rows) > 1 else [0.0, 0.0, -1.0]
    out_of_plane = abs(axis[2]) > max(abs(axis[0]), abs(axis[1]))
    width, thickness = (first, second) if out_of_plane else (second, first)
    content.sections.append((card.needs("ELSET"), card.needs("MATERIAL"), width, thickness))


def _read_set(card: Card, content: AbaqusMesh, key: str, sets: dict[str, list[int]]) -> None:
    """Add the members that a keyword lists as numbers, ranges or names of earlier sets."""
    members: list[int] = []
    if "GENERATE" in card.parameters:
        ranges = [[int(value) for value in row if value] for row in card.rows]
        runs = [range(first, last + 1, *step[:1]) for first, last, *step in ranges]
        if sum(map(len, runs)) > MOST_MEMBERS:
            raise MeshFileError(f"sets of at most {MOST_MEMBERS} members")
        members += chain.from_iterable(runs)
    else:
        for value in filter(None, chain.from_iterable(card.rows)):
            name = content.names.get(value.upper(), value)
            if value.lstrip("-").isdigit():
                members.append(int(value))
            elif name in sets:
                members += sets[name]
            else:
                raise MeshFileError(
                    f"sets that consist of numbers and earlier sets; {value!r} is neither"
                )
    extend(sets, card.needs(key), members)


def extend(sets: dict[str, list[int]], name: str | None, members: list[int]) -> None:
    """Add members to a set without repetition; without a name, do nothing."""
    if name is not None:
        sets[name] = list(dict.fromkeys([*sets.get(name, []), *members]))


def read_inp(path: Path) -> GroupedLines:
    """Read the lines of an .inp file, with their sets, sections and point masses.

    Raises:
        MeshFileError: the file is not a valid .inp file, has other elements than straight lines and
            point masses, or has unsupported keywords that would change the mesh.
    """
    content = read_abaqus(path)
    for kind, count in Counter(content.types.values()).items():
        if CURVED.fullmatch(kind):
            raise MeshFileError(
                f"straight two-node lines, found {count} curved cells of type {kind}: mesh with "
                "elements of first order, and shorter ones along curves"
            )
        if kind not in POINT_MASSES and not STRAIGHT.fullmatch(kind):
            raise MeshFileError(f"lines only, found {count} cells of type {kind}")
    ends = {n: v[:2] for n, v in content.elements.items() if content.types[n] not in POINT_MASSES}
    if not ends:
        raise MeshFileError("a mesh with lines; there are none")
    if any(len(nodes) < 2 for nodes in ends.values()):
        raise MeshFileError("an .inp file with valid data under *ELEMENT")
    node = {number: place for place, number in enumerate(content.points)}
    line = {number: place for place, number in enumerate(ends)}
    used = chain.from_iterable(nodes[:2] for nodes in content.elements.values())
    if missing := {*used} - set(node):
        raise MeshFileError(f"all nodes of the elements; node {min(missing)} is not defined")
    elements = {k: v for k, v in content.element_sets.items() if not OWN_SETS.fullmatch(k)}
    return GroupedLines(
        points=in_plane(np.array([*content.points.values()])),
        lines=np.array([[node[n] for n in nodes] for nodes in ends.values()]),
        node_groups=_by_place(content.node_sets, node),
        line_groups=_by_place(elements, line),
        node_data=_mass_data(content, node),
        line_data=_section_data(content, line),
    )


def _by_place(sets: Mapping[str, list[int]], place: Mapping[int, int]) -> dict[str, IntArray]:
    return {
        name: np.array([place[n] for n in members if n in place], dtype=np.int64)
        for name, members in sets.items()
    }


def _mass_data(content: AbaqusMesh, node: Mapping[int, int]) -> dict[str, FloatArray]:
    data: dict[str, FloatArray] = {}
    for name, elset, value in content.masses:
        values = data.setdefault(name, np.zeros(len(node)))
        for element in content.element_sets.get(elset, []):
            if content.types.get(element) not in POINT_MASSES:
                raise MeshFileError(f"masses on point elements; element {element} is another type")
            values[node[content.elements[element][0]]] += value
    return data


def _material(content: AbaqusMesh, name: str) -> dict[str, float]:
    """Return Young's modulus and density of a material of a section."""
    if name.upper() not in content.materials:
        raise MeshFileError(f"*MATERIAL, NAME={name}, which a *BEAM SECTION names")
    properties = content.materials[name.upper()]
    for keyword, value in (("ELASTIC", "young_modulus"), ("DENSITY", "density")):
        if value not in properties:
            raise MeshFileError(f"an isotropic *{keyword} under *MATERIAL, NAME={name}")
    return {key: properties[key] for key in ("young_modulus", "density")}


def _section_data(content: AbaqusMesh, line: Mapping[int, int]) -> dict[str, FloatArray]:
    if not content.sections:
        return {}
    data = {name: np.full(len(line), np.nan) for name in SECTION}
    for elset, material, width, thickness in content.sections:
        properties = _material(content, material)
        numbers = [line[n] for n in content.element_sets.get(elset, []) if n in line]
        for name, value in {"width": width, "thickness": thickness, **properties}.items():
            data[name][numbers] = value
    return data
