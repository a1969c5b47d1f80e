"""Reading of input of Abaqus and CalculiX, .inp: nodes, elements, sets, materials and sections.

meshio is not used, although it reads such files. meshio assigns elements to wrong sets if blocks of
elements share a set or have none, reads only the last of several blocks of nodes, and supports
neither B23 elements nor sections nor parts. This module therefore reads the few relevant keywords
itself. Keywords that would change the mesh without being evaluated are an error.
"""

import re
from itertools import chain
from pathlib import Path

from bladewhirl.meshes.files.abaqus_constraints import read_boundary, read_coupling
from bladewhirl.meshes.files.abaqus_instances import name_sets, place_instance
from bladewhirl.meshes.files.abaqus_keywords import CHANGES_THE_MESH, HARMLESS, HOURGLASS
from bladewhirl.meshes.files.abaqus_mesh import AbaqusMesh
from bladewhirl.meshes.files.abaqus_sets import ELEMENTS, NODES, named, read_members, read_surface
from bladewhirl.meshes.files.abaqus_text import Card, cards, real, whole
from bladewhirl.meshes.files.groups import MeshFileError, constant

SOLID = re.compile(r"(?:A?C3D|DC3D|F3D)(\d+).*")
"""Elements of solids, whether supported or not; the number is that of their nodes."""


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
                self.whole.others["BOUNDARY of a part"] += 1
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
            read_members(card, content, NODES, card.needs("NSET"))
        case "ELSET":
            read_members(card, content, ELEMENTS, card.needs("ELSET"))
        case "SURFACE" if card.parameters.get("TYPE", "").upper() == "NODE":
            card.rows = [row[:1] for row in card.rows]
            read_members(card, content, NODES, card.needs("NAME"))
        case "SURFACE" if card.parameters.get("TYPE", "ELEMENT").upper() == "ELEMENT":
            read_surface(card, content)
        case "BEAM SECTION" if card.parameters.get("SECTION", "").upper() == "RECT":
            _read_section(card, content)
        case "MATERIAL":
            content.material = card.needs("NAME").upper()
            if content.material in content.materials:
                raise MeshFileError(f"each material once; {card.needs('NAME')} is defined twice")
            content.materials[content.material] = {}
        case "SOLID SECTION":
            if "COMPOSITE" in card.parameters:
                raise MeshFileError("a *SOLID SECTION of one MATERIAL, without COMPOSITE")
            group = _section_of(card, content)
            content.solid_sections.append((group, card.needs("MATERIAL")))
        case "SURFACE SECTION":  # a skin without mass has no stiffness, either
            if "DENSITY" in card.parameters:
                _mark_built(card, content)
        case section if section.endswith("SECTION") and "ELSET" in card.parameters:
            _mark_built(card, content)
            if section not in HARMLESS:
                content.others[section] += 1
        case "ELASTIC" | "DENSITY":
            _read_property(card, content)
        case "MASS":
            content.masses.append(("mass", card.needs("ELSET"), real(card.rows[0][0])))
        case "ROTARY INERTIA":
            content.masses.append(("inertia", card.needs("ELSET"), real(card.rows[0][-1])))
        case "COUPLING" | "RIGID BODY" | "KINEMATIC COUPLING" | "KINEMATIC" | "DISTRIBUTING":
            read_coupling(card, content)
        case "STEP":
            content.step += 1
        case "BOUNDARY":
            read_boundary(card, content)
        case "TIE" if "CYCLICSYMMETRY" in card.parameters:
            pass
        case "INITIAL CONDITIONS":
            if (kind := card.needs("TYPE").upper()) == "STRESS":
                content.others[f"INITIAL CONDITIONS, TYPE={kind}"] += 1
        case keyword if keyword in HOURGLASS:
            if keyword != "SECTION CONTROLS" or card.rows or "HOURGLASS" in card.parameters:
                content.others[keyword] += 1
        case keyword if keyword in CHANGES_THE_MESH:
            raise MeshFileError(
                f"an .inp file without *{keyword}, with all nodes and elements listed"
            )
        case keyword if keyword not in HARMLESS:
            content.others[keyword] += 1


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
        return [next(iter(named(value, content, NODES))) for value in row if value]


def _read_property(card: Card, content: AbaqusMesh) -> None:
    """Read a property of the material that is being read; solids need one that is constant."""
    kind = card.parameters.get("TYPE", "ISOTROPIC").upper()
    if not card.rows or content.material not in content.materials:
        raise MeshFileError(f"*{card.keyword} with data, after a *MATERIAL")
    values = [real(value) if value else None for value in card.rows[0]]
    if card.keyword == "ELASTIC" and not kind.startswith("ISO"):
        content.unread[content.material] = f"*ELASTIC, TYPE={kind}"
        return
    if int(card.parameters.get("DEPENDENCIES") or 0):
        content.unread[content.material] = f"*{card.keyword}, DEPENDENCIES"
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
    _mark_built(card, content)
    return group


def _mark_built(card: Card, content: AbaqusMesh) -> None:
    content.built.update(content.element_sets.get(card.needs("ELSET"), ()))


def _read_section(card: Card, content: AbaqusMesh) -> None:
    first, second = (real(value) for value in card.rows[0][:2])
    axis = [real(value) for value in card.rows[1]] if len(card.rows) > 1 else [0.0, 0.0, -1.0]
    out_of_plane = abs(axis[2]) > max(abs(axis[0]), abs(axis[1]))
    width, thickness = (first, second) if out_of_plane else (second, first)
    group = _section_of(card, content)
    content.sections.append((group, card.needs("MATERIAL"), width, thickness))
