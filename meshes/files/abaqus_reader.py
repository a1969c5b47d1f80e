"""Reading of input of Abaqus and CalculiX, .inp: nodes, elements, sets, materials and sections.

meshio is not used, although it reads such files. meshio assigns elements to wrong sets if blocks of
elements share a set or have none, reads only the last of several blocks of nodes, and supports
neither B23 elements nor sections nor parts. This module therefore reads the few relevant keywords
itself. Keywords that would change the mesh without being evaluated are an error.
"""

import re
from collections import defaultdict
from collections.abc import Collection, Sequence
from itertools import chain
from pathlib import Path

from bladewhirl.meshes.files.abaqus_faces import surface_nodes
from bladewhirl.meshes.files.abaqus_instances import name_sets, place_instance
from bladewhirl.meshes.files.abaqus_mesh import AbaqusMesh
from bladewhirl.meshes.files.abaqus_text import Card, cards, real, whole
from bladewhirl.meshes.files.groups import MeshFileError, constant

SOLID = re.compile(r"(?:A?C3D|DC3D|F3D)(\d+).*")
"""Elements of solids, whether supported or not; the number is that of their nodes."""

CHANGES_THE_MESH = frozenset(
    ["SYSTEM", "NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY", "NODETHICKNESS"]
)

HARMLESS = frozenset(
    line.strip()
    for line in """
    HEADING, PREPRINT, RESTART, END PART, ASSEMBLY, END ASSEMBLY, STEP, END STEP, STATIC, FREQUENCY,
    BUCKLE, STEADY STATE DYNAMICS, MODAL DYNAMIC, DYNAMIC, COMPLEX FREQUENCY, CONTROLS, OUTPUT,
    NODE OUTPUT, ELEMENT OUTPUT, CONTACT OUTPUT, NODE PRINT, EL PRINT, NODE FILE, EL FILE, MONITOR,
    FILE FORMAT, SECTION PRINT, CONTACT FILE, CONTACT PRINT, ENERGY OUTPUT, SELECT CYCLIC SYMMETRY
    MODES, CYCLIC SYMMETRY MODEL, CLOAD, DLOAD, DSLOAD, TEMPERATURE, FIELD, AMPLITUDE, INITIAL
    CONDITIONS, PHYSICAL CONSTANTS, EXPANSION, CONDUCTIVITY, SPECIFIC HEAT, PLASTIC, ORIENTATION,
    TRANSFORM, SOLID SECTION, SHELL SECTION, MEMBRANE SECTION, BEAM SECTION, BEAM GENERAL SECTION,
    SURFACE SECTION, SURFACE, SURFACE INTERACTION, SURFACE BEHAVIOR, FRICTION, DISTRIBUTION,
    DISTRIBUTION TABLE, PARAMETER, DIAGNOSTICS, USER MATERIAL, DEPVAR, MASS, ROTARY INERTIA,
    SPRING, DASHPOT, CONNECTOR SECTION, VISUALIZATION, INCLUDE, VIEWFACTOR, MODAL DAMPING,
    CONTACT CONTROLS, SECTION CONTROLS, HOURGLASS STIFFNESS, BASE MOTION, TIME POINTS, PRINT
    """.replace("\n    ", " ").split(",")
)
"""Keywords that say nothing about the linear motion at rest, or belong to elements that are named.
"""

NODES, ELEMENTS = 0, 1


def read_abaqus(path: Path, *, follow: bool = True, outside: bool = False) -> AbaqusMesh:
    """Read nodes, elements, sets, sections and masses of an .inp file; other keywords are skipped.

    Sets of instances are named as those of their parts, or with the name of the instance before
    them, as in ``blade-1.root``, if a set of the assembly has this name or there are several
    instances; a set with the name without the instance then contains those of all instances.

    Args:
        path: path of the file.
        follow: whether files that it names in *INCLUDE and INPUT= are read.
        outside: whether these files may be outside the folder of the file.

    Raises:
        MeshFileError: the file is not a valid .inp file, or has keywords that generate nodes or
            elements.
    """
    deck = _Deck()
    for card in cards(path, follow=follow, outside=outside):
        with card.located():
            deck.read(card)
    return deck.finished()


class _Deck:
    """Assembly of a file, its parts, and what is being read."""

    def __init__(self) -> None:
        self.whole = self._here = AbaqusMesh()
        self._parts: dict[str, AbaqusMesh] = {}
        self._instance: Card | None = None

    def read(self, card: Card) -> None:
        """Add the data of a keyword."""
        match card.keyword:
            case "PART":
                self._here = self._parts.setdefault(card.needs("NAME").upper(), self.whole.part())
            case "INSTANCE":
                if (part := self._parts.get(card.needs("PART").upper())) is None:
                    raise MeshFileError(f"a *PART, NAME={card.needs('PART')} before its instance")
                self._here, self._instance = part.instance(), card
            case "END INSTANCE" if self._instance is not None:
                place_instance(self._instance, self._here, self.whole)
                self._here, self._instance = self.whole, None
            case "END PART" | "ASSEMBLY":
                self._here = self.whole
            case "BOUNDARY" if self._here is not self.whole:
                self.whole.constraints.add("*BOUNDARY of a part")
            case _:
                _read(card, self._here)

    def finished(self) -> AbaqusMesh:
        """Return the assembly; a single part without an instance is one.

        Raises:
            MeshFileError: parts have no instance.
        """
        whole = self.whole
        if self._instance is not None:
            raise MeshFileError(f"*END INSTANCE after *INSTANCE, {self._instance.place}")
        filled = [name for name, part in self._parts.items() if part.elements]
        if filled and not whole.instances:
            if len(filled) > 1:
                raise MeshFileError(
                    f"an *INSTANCE of each *PART that is used; {' and '.join(filled)} have none"
                )
            place_instance(Card("INSTANCE", {"NAME": filled[0]}), self._parts[filled[0]], whole)
        whole.check_sets()
        name_sets(whole)
        return whole


def _read(card: Card, content: AbaqusMesh) -> None:
    """Add the data of a keyword to the contents; irrelevant keywords are skipped."""
    instance = card.parameters.get("INSTANCE")
    for parameter in ("NSET", "ELSET", "NAME"):
        if given := card.parameters.get(parameter):
            if parameter == "ELSET" and instance is not None and card.keyword == "NSET":
                given = f"{instance}.{given}"
            card.parameters[parameter] = content.names.setdefault(given.upper(), given)
    match card.keyword:
        case "NODE":
            _read_nodes(card, content)
        case "ELEMENT":
            _read_elements(card, content)
        case "NSET" if "ELSET" in card.parameters:
            elements = content.element_sets.get(card.parameters["ELSET"], {})
            content.count(len(elements))
            content.extend(content.node_sets, card.needs("NSET"), content.nodes_of(elements))
        case "NSET":
            _read_members(card, content, NODES, card.needs("NSET"))
        case "ELSET":
            _read_members(card, content, ELEMENTS, card.needs("ELSET"))
        case "SURFACE" if card.parameters.get("TYPE", "").upper() == "NODE":
            card.rows = [row[:1] for row in card.rows]
            _read_members(card, content, NODES, card.needs("NAME"))
        case "SURFACE" if card.parameters.get("TYPE", "ELEMENT").upper() == "ELEMENT":
            _read_surface(card, content)
        case "BEAM SECTION" if card.parameters.get("SECTION", "").upper() == "RECT":
            _read_section(card, content)
        case "MATERIAL":
            content.material = card.needs("NAME").upper()
            if content.material in content.materials:
                raise MeshFileError(f"each material once; {card.needs('NAME')} is defined twice")
            content.materials[content.material] = {}
        case "SOLID SECTION":
            group = _section_of(card, content)
            content.solid_sections.append((group, card.parameters.get("MATERIAL", "")))
        case "ELASTIC" | "DENSITY":
            _read_property(card, content)
        case "MASS":
            content.masses.append(("mass", card.needs("ELSET"), real(card.rows[0][0])))
        case "ROTARY INERTIA":
            content.masses.append(("inertia", card.needs("ELSET"), real(card.rows[0][-1])))
        case "COUPLING" | "RIGID BODY" | "KINEMATIC COUPLING" | "KINEMATIC" | "DISTRIBUTING":
            _read_coupling(card, content)
        case "BOUNDARY":
            _read_boundary(card, content)
        case "TIE" if "CYCLIC SYMMETRY" in card.parameters:
            pass
        case keyword if keyword in CHANGES_THE_MESH:
            raise MeshFileError(
                f"an .inp file without *{keyword}, with all nodes and elements listed"
            )
        case keyword if keyword not in HARMLESS:
            content.constraints.add(f"*{keyword}")


def _read_nodes(card: Card, content: AbaqusMesh) -> None:
    if card.parameters.get("SYSTEM", "R").upper() != "R":
        raise MeshFileError("nodes in Cartesian coordinates, *NODE without SYSTEM")
    for number, *coordinates in card.rows:
        xyz = [real(value or "0") for value in coordinates[:3]]
        xyz += [0.0] * (3 - len(xyz))
        if content.points.setdefault(whole(number), xyz) != xyz:
            raise MeshFileError(f"each node at most once; node number {number} is defined twice")
    name = card.parameters.get("NSET")
    content.extend(content.node_sets, name, [whole(row[0]) for row in card.rows])


def _read_elements(card: Card, content: AbaqusMesh) -> None:
    kind = card.needs("TYPE").upper()
    rows = [_integers(row, content) for row in card.rows]
    if solid := SOLID.fullmatch(kind):  # an element of 20 nodes takes several lines
        length, values = int(solid[1]) + 1, [*chain.from_iterable(rows)]
        if len(values) % length:
            raise MeshFileError(f"elements of {length - 1} nodes under *ELEMENT, TYPE={kind}")
        rows = [values[at : at + length] for at in range(0, len(values), length)]
    for number, first, *others in rows:
        if number in content.elements:
            raise MeshFileError(f"each element once; element number {number} is defined twice")
        content.elements[number], content.types[number] = [first, *others], kind
    name = card.parameters.get("ELSET")
    content.extend(content.element_sets, name, [row[0] for row in rows])


def _integers(row: list[str], content: AbaqusMesh) -> list[int]:
    """Return the numbers in a line, which may end with blank fields; nodes may have the name of an
    instance before them."""
    if "" in row[: max((at for at, value in enumerate(row, 1) if value), default=0)]:
        raise MeshFileError(f"a number in every field, got {', '.join(row)}")
    try:
        return [whole(value) for value in row if value]
    except MeshFileError:
        return [next(iter(_named(value, content, NODES))) for value in row if value]


def _read_property(card: Card, content: AbaqusMesh) -> None:
    """Read a property of the material that is being read; solids need one that is constant."""
    kind = card.parameters.get("TYPE", "ISOTROPIC").upper()
    values = [real(value) if value else None for value in card.rows[0]]
    if card.keyword == "ELASTIC" and not kind.startswith("ISO"):
        content.unread[content.material] = f"*ELASTIC, TYPE={kind}"
        return
    names = ("density",) if card.keyword == "DENSITY" else ("young_modulus", "poisson_ratio")
    if names[0] in content.materials[content.material]:
        raise MeshFileError(f"one *{card.keyword} of each material; {content.material} has two")
    for name, value in zip(names, values, strict=False):
        if value is None:  # a blank field
            continue
        content.materials[content.material][name] = constant(name, value)
    if len(card.rows) > 1:
        content.unread[content.material] = f"*{card.keyword} for several temperatures"


def _section_of(card: Card, content: AbaqusMesh) -> str:
    """Return the set of a section, which must have no other."""
    group = card.needs("ELSET")
    if group in content.sectioned:
        raise MeshFileError(f"one section for each set; {group} has two")
    content.sectioned.add(group)
    return group


def _read_section(card: Card, content: AbaqusMesh) -> None:
    first, second = (real(value) for value in card.rows[0][:2])
    axis = [real(value) for value in card.rows[1]] if len(card.rows) > 1 else [0.0, 0.0, -1.0]
    out_of_plane = abs(axis[2]) > max(abs(axis[0]), abs(axis[1]))
    width, thickness = (first, second) if out_of_plane else (second, first)
    group = _section_of(card, content)
    content.sections.append((group, card.needs("MATERIAL"), width, thickness))


def _read_members(card: Card, content: AbaqusMesh, kind: int, name: str) -> None:
    """Add the members that a keyword lists as numbers, ranges or names of earlier sets to a set.

    Args:
        card: keyword.
        content: contents so far.
        kind: `NODES` or `ELEMENTS`.
        name: name of the set.
    """
    sets = (content.node_sets, content.element_sets)[kind]
    instance = card.parameters.get("INSTANCE")
    content.extend(sets, name, ())
    if "GENERATE" not in card.parameters:
        prefix = "" if instance is None else f"{instance}."
        for value in filter(None, chain.from_iterable(card.rows)):
            members = _named(f"{prefix}{value}", content, kind)
            content.extend(sets, name, members, listed=isinstance(members, list))
        return
    placed = None if instance is None else content.instances[instance.upper()][kind]
    for row in card.rows:
        first, last, step = ([whole(value) for value in row if value] + [1])[:3]
        if not step or (last - first) % step or (last - first) // step < 0:
            raise MeshFileError(
                f"ranges whose step leads from the first number to the last, got {', '.join(row)}"
            )
        run = range(first, last + (1 if step > 0 else -1), step)
        content.count(len(run))
        content.extend(
            sets, name, run if placed is None else (placed[n] for n in run if n in placed)
        )


def _named(value: str, content: AbaqusMesh, kind: int) -> Collection[int]:
    """Return the members of a set, or a list of the node or element with a number, perhaps after
    the name of an instance and a point."""
    sets = (content.node_sets, content.element_sets)[kind]
    if (name := content.names.get(value.upper(), value)) in sets:
        content.count(len(sets[name]))
        return sets[name]
    instance, point, number = value.rpartition(".")
    try:
        if not point:
            return [whole(number)]
        return [content.instances[instance.upper()][kind][whole(number)]]
    except (MeshFileError, KeyError):
        text = f"sets that consist of numbers and earlier sets; {value!r} is neither"
        raise MeshFileError(text) from None


def _read_surface(card: Card, content: AbaqusMesh) -> None:
    """Read a surface of faces of solids as a set of nodes; faces of other elements are skipped, and
    surfaces of sets that are not defined before."""
    instance = card.parameters.get("INSTANCE")
    faces = defaultdict[str, list[int]](list)
    for row in card.rows:
        value = row[0] if instance is None else f"{instance}.{row[0]}"
        try:
            elements = _named(value, content, ELEMENTS)
        except MeshFileError:
            return
        faces[row[1].upper() if len(row) > 1 else ""] += elements
    content.count(len(content.elements) if "" in faces else 0)
    nodes = [node for face, of in faces.items() for node in surface_nodes(content, of, face)]
    content.extend(content.node_sets, card.needs("NAME"), nodes)


AXES = {"ENCASTRE": {1, 2, 3}, "PINNED": {1, 2, 3}, "XSYMM": {1}, "YSYMM": {2}, "ZSYMM": {3}}
AXES |= {"XASYMM": {2, 3}, "YASYMM": {1, 3}, "ZASYMM": {1, 2}}
"""Displacements that the names of boundary conditions hold."""


def _read_boundary(card: Card, content: AbaqusMesh) -> None:
    """Read the displacements that are held."""
    if content.held and card.parameters.get("OP", "").upper() == "NEW":
        content.constraints.add("*BOUNDARY, OP=NEW, which frees nodes held before it,")
    for row in card.rows:
        first, last, value = (*row[1:4], "", "", "")[:3]
        if value and real(value):
            content.constraints.add("*BOUNDARY of motions")
            continue
        axes = AXES.get(first.upper()) or {*range(whole(first), whole(last or first) + 1)}
        if not axes:
            raise MeshFileError(f"degrees of freedom from low to high, got {first}, {last}")
        for node in _named(row[0], content, NODES):
            content.held.setdefault(node, set()).update(axes & {1, 2, 3})


def _read_coupling(card: Card, content: AbaqusMesh) -> None:
    """Read the nodes that move with a reference node as a rigid body."""
    if card.keyword in ("DISTRIBUTING", "KINEMATIC"):  # of the coupling before
        if card.keyword == "DISTRIBUTING":  # its nodes move independently
            content.couplings.pop()
        elif not _displacements(card.rows):
            content.couplings.pop()
            content.constraints.add("*KINEMATIC of some displacements")
        return
    reference = [*_named(card.needs("REF NODE"), content, NODES)]
    keys = ("SURFACE", "NSET", "ELSET", "TIE NSET", "PIN NSET")
    nodes: list[int] = []
    for key, value in card.parameters.items():
        if key in keys and key != "ELSET":
            nodes += _named(value, content, NODES)
        elif key == "ELSET":
            nodes += content.nodes_of(_named(value, content, ELEMENTS))
    if card.keyword == "KINEMATIC COUPLING":
        if not _displacements([row[1:] for row in card.rows]):
            content.constraints.add("*KINEMATIC COUPLING of some displacements")
            return
        nodes += chain.from_iterable(_named(row[0], content, NODES) for row in card.rows)
    content.couplings.append((f"*{card.keyword}", reference, nodes))


def _displacements(rows: Sequence[Sequence[str]]) -> bool:
    """Return whether rows of first and last degrees of freedom contain all three displacements.
    Without a row they do."""
    ranges = [[whole(value) for value in row[:2] if value] for row in rows]
    return not any(ranges) or all(
        any(min(row) <= one <= max(row) for row in ranges if row) for one in (1, 2, 3)
    )
