"""Reading of line meshes from Abaqus input, .inp.

Groups are sets: NSET for nodes, ELSET for lines. The data are rectangular sections with their
materials (BEAM SECTION, ELASTIC, DENSITY) and point masses (MASS, ROTARYI); their units are the
choice of the author of the file.

meshio is not used, although it reads such files. meshio assigns elements to wrong sets if blocks of
elements share a set or have none, reads only the last of several blocks of nodes, and supports
neither B23 elements nor sections. This module therefore reads the few relevant keywords itself.
Keywords that would change the mesh without being evaluated are an error.
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from bladewhirl.meshes.files.groups import GroupedLines, MeshFileError, in_plane
from bladewhirl.meshes.line_mesh import FloatArray, IntArray

STRAIGHT = re.compile(r"(T[23]D2|B[23][13]|PIPE[23]1|FRAME[23]D)(OS|R)?H?")
CURVED = re.compile(r"(T[23]D3|B[23]2|PIPE[23]2)(OS|R)?H?")
POINT_MASSES = {"MASS": "mass", "ROTARYI": "inertia"}
"""Types of elements with one node, and the names of their data."""

SECTION = ("width", "thickness", "young_modulus", "density")
OWN_SETS = re.compile(r"(section|mass|inertia)-\d+", re.I)
"""Names of sets that the writer makes for sections and masses; they are not groups of the mesh."""

CHANGES_THE_MESH = frozenset(
    ["INCLUDE", "SYSTEM", "NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY", "NODETHICKNESS"]
)


UNSOUND = (ValueError, IndexError, KeyError)
"""Exceptions that are raised if data do not match their keyword."""

MOST_MEMBERS = 1_000_000
"""Largest number of members of a set that is given by ranges."""


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
class _Content:
    """Contents of a file, with the numbers of nodes and elements in the file."""

    points: dict[int, list[float]] = field(default_factory=dict)
    lines: dict[int, list[int]] = field(default_factory=dict)
    point_elements: dict[int, int] = field(default_factory=dict)  #: number of element -> of node
    node_sets: dict[str, list[int]] = field(default_factory=dict)
    element_sets: dict[str, list[int]] = field(default_factory=dict)
    sections: list[tuple[str, str, float, float]] = field(default_factory=list)
    materials: dict[str, dict[str, float]] = field(default_factory=dict)
    masses: list[tuple[str, str, float]] = field(default_factory=list)  #: data, set, value
    material: str = ""  #: name of the material that is being read


def read_inp(path: Path) -> GroupedLines:
    """Read an .inp file.

    Raises:
        MeshFileError: the file is not a valid .inp file, has other elements than straight lines and
            point masses, or has unsupported keywords that would change the mesh.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise MeshFileError(f"a readable file ({error.strerror})") from None
    except ValueError as error:
        raise MeshFileError(f"an .inp file in plain text ({error})") from None
    content = _Content()
    for card in cards(text):
        try:
            _read(card, content)
        except MeshFileError:
            raise
        except UNSOUND:
            raise MeshFileError(f"an .inp file with valid data under *{card.keyword}") from None
    return _grouped(content)


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


def _read(card: Card, content: _Content) -> None:
    """Add the data of a keyword to the contents; irrelevant keywords are skipped."""
    match card.keyword:
        case "NODE":
            _read_nodes(card, content)
        case "ELEMENT":
            _read_elements(card, content)
        case "NSET":
            _read_node_set(card, content)
        case "ELSET":
            sets = content.element_sets
            extend(sets, card.needs("ELSET"), members_of(card, sets))
        case "BEAM SECTION" if card.parameters.get("SECTION", "").upper() == "RECT":
            _read_section(card, content)
        case "MATERIAL":
            content.material = card.needs("NAME").upper()
            content.materials[content.material] = {}
        case "ELASTIC" if card.parameters.get("TYPE", "ISOTROPIC").upper().startswith("ISO"):
            content.materials[content.material]["young_modulus"] = float(card.rows[0][0])
        case "DENSITY":
            content.materials[content.material]["density"] = float(card.rows[0][0])
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


def _read_nodes(card: Card, content: _Content) -> None:
    if card.parameters.get("SYSTEM", "R").upper() != "R":
        raise MeshFileError("nodes in Cartesian coordinates, *NODE without SYSTEM")
    for number, *coordinates in card.rows:
        if int(number) in content.points:
            raise MeshFileError(
                f"each node at most once; node number {number} is defined twice"
                " (only one part per file can be read)"
            )
        xyz = [float(value or 0.0) for value in coordinates[:3]]
        content.points[int(number)] = xyz + [0.0] * (3 - len(xyz))
    extend(content.node_sets, card.parameters.get("NSET"), [int(row[0]) for row in card.rows])


def _read_elements(card: Card, content: _Content) -> None:
    kind = card.needs("TYPE").upper()
    rows = [[int(value) for value in row] for row in card.rows]
    if CURVED.fullmatch(kind):
        raise MeshFileError(
            f"straight two-node lines, found {len(rows)} curved cells of type {kind}: mesh with "
            "elements of first order, and shorter ones along curves"
        )
    if kind in POINT_MASSES:
        content.point_elements.update({number: node for number, node in rows})
    elif STRAIGHT.fullmatch(kind):
        for number, first, second, *_ in rows:
            if number in content.lines:
                raise MeshFileError(f"each element once; element number {number} is defined twice")
            content.lines[number] = [first, second]
    else:
        raise MeshFileError(f"lines only, found {len(rows)} cells of type {kind}")
    extend(content.element_sets, card.parameters.get("ELSET"), [row[0] for row in rows])


def _read_node_set(card: Card, content: _Content) -> None:
    if "ELSET" in card.parameters:
        elements = content.element_sets.get(card.parameters["ELSET"], [])
        nodes = [node for element in elements for node in content.lines.get(element, [])]
        extend(content.node_sets, card.needs("NSET"), list(dict.fromkeys(nodes)))
        return
    extend(content.node_sets, card.needs("NSET"), members_of(card, content.node_sets))


def _read_section(card: Card, content: _Content) -> None:
    first, second = (float(value) for value in card.rows[0][:2])
    axis = [float(value) for value in card.rows[1]] if len(card.rows) > 1 else [0.0, 0.0, -1.0]
    out_of_plane = abs(axis[2]) > max(abs(axis[0]), abs(axis[1]))
    width, thickness = (first, second) if out_of_plane else (second, first)
    content.sections.append((card.needs("ELSET"), card.needs("MATERIAL"), width, thickness))


def extend(sets: dict[str, list[int]], name: str | None, members: list[int]) -> None:
    """Add members to a set without repetition; without a name, do nothing."""
    if name is not None:
        sets[name] = list(dict.fromkeys([*sets.get(name, []), *members]))


def members_of(card: Card, sets: Mapping[str, list[int]]) -> list[int]:
    """Return the members that a *NSET or *ELSET lists as numbers, ranges or names of earlier
    sets."""
    if "GENERATE" in card.parameters:
        ranges = [[int(value) for value in row] for row in card.rows]
        runs = [range(first, last + 1, *step[:1]) for first, last, *step in ranges]
        if sum(map(len, runs)) > MOST_MEMBERS:
            raise MeshFileError(f"sets of at most {MOST_MEMBERS} members")
        return [number for run in runs for number in run]
    members: list[int] = []
    for value in (value for row in card.rows for value in row):
        if value.lstrip("-").isdigit():
            members.append(int(value))
        elif value in sets:
            members += sets[value]
        else:
            raise MeshFileError(
                f"sets that consist of numbers and earlier sets; {value!r} is neither"
            )
    return members


def _grouped(content: _Content) -> GroupedLines:
    if not content.lines:
        raise MeshFileError("a mesh with lines; there are none")
    node = {number: place for place, number in enumerate(content.points)}
    line = {number: place for place, number in enumerate(content.lines)}
    missing = {n for ends in content.lines.values() for n in ends} - set(node)
    missing |= set(content.point_elements.values()) - set(node)
    if missing:
        raise MeshFileError(f"all nodes of the elements; node {min(missing)} is not defined")
    elements = {k: v for k, v in content.element_sets.items() if not OWN_SETS.fullmatch(k)}
    return GroupedLines(
        points=in_plane(np.array([*content.points.values()])),
        lines=np.array([[node[n] for n in ends] for ends in content.lines.values()]),
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


def _mass_data(content: _Content, node: Mapping[int, int]) -> dict[str, FloatArray]:
    data: dict[str, FloatArray] = {}
    for name, elset, value in content.masses:
        values = data.setdefault(name, np.zeros(len(node)))
        for element in content.element_sets.get(elset, []):
            if element not in content.point_elements:
                raise MeshFileError(f"masses on point elements; element {element} is another type")
            values[node[content.point_elements[element]]] += value
    return data


def _material(content: _Content, name: str) -> dict[str, float]:
    """Return Young's modulus and density of a material of a section."""
    if name.upper() not in content.materials:
        raise MeshFileError(f"*MATERIAL, NAME={name}, which a *BEAM SECTION names")
    properties = content.materials[name.upper()]
    for keyword, value in (("ELASTIC", "young_modulus"), ("DENSITY", "density")):
        if value not in properties:
            raise MeshFileError(f"an isotropic *{keyword} under *MATERIAL, NAME={name}")
    return properties


def _section_data(content: _Content, line: Mapping[int, int]) -> dict[str, FloatArray]:
    if not content.sections:
        return {}
    data = {name: np.full(len(line), np.nan) for name in SECTION}
    for elset, material, width, thickness in content.sections:
        properties = _material(content, material)
        numbers = [line[n] for n in content.element_sets.get(elset, []) if n in line]
        for name, value in {"width": width, "thickness": thickness, **properties}.items():
            data[name][numbers] = value
    return data
