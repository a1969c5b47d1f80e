"""Meshes of solids from input of Abaqus and CalculiX, .inp.

Groups are sets of nodes and of elements, and surfaces. The order of the nodes of an element is that
of VTK.
"""

import re
from collections import Counter
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

import meshio
import numpy as np

from bladewhirl.meshes.files.abaqus_faces import SOLIDS
from bladewhirl.meshes.files.abaqus_keywords import HOURGLASS
from bladewhirl.meshes.files.abaqus_mesh import AbaqusMesh, by_place
from bladewhirl.meshes.files.abaqus_reader import SOLID, read_abaqus
from bladewhirl.meshes.files.groups import MeshFileError, OtherCellsError, places_of_nodes
from bladewhirl.meshes.files.meshio_cells import POINT
from bladewhirl.meshes.line_mesh import IntArray


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
    ignored: tuple[str, ...] = ()  #: what connects or loads nodes and is not read
    rigid: tuple[tuple[str, IntArray], ...] = ()  #: keyword and nodes of each rigid body
    held: str = ""  #: set of the nodes whose displacements the file fixes, if there is one


HELD = "*BOUNDARY"  #: name of the group of the nodes that the file holds

FACES = re.compile("(CPS|CPE|CAX|[TR][23]D|SFM3D)[2-9].*|HEATCAP")
"""Elements that change the motion of a solid only with a section, or as part of a rigid body: faces
and edges of the solid, as which Gmsh writes them."""


def abaqus_mesh(path: Path, *, outside: bool = False) -> SolidMesh:
    """Return the solid elements of an .inp file, and its sets as sets of points.

    Args:
        path: path of the file.
        outside: whether files that it names may be outside its folder.

    Raises:
        MeshFileError: the file is not a valid .inp file, or has elements that are not supported.
    """
    content = read_abaqus(path, outside=outside)
    place = {number: row for row, number in enumerate(content.points)}
    solids: dict[str, list[list[int]]] = {}
    cell: dict[int, tuple[str, int]] = {}
    for number, kind in content.types.items():
        if SOLID.fullmatch(kind):
            rows = solids.setdefault(kind, [])
            cell[number] = kind, len(rows)
            rows.append(places_of_nodes(place, number, content.elements[number]))
    if other := [kind for kind in solids if kind not in SOLIDS]:
        raise MeshFileError(
            f"elements of the types {', '.join(SOLIDS)}; found {len(solids[other[0]])} of type"
            f" {other[0]}{_instead(other[0])}"
        )
    if content.types and not solids:
        kinds = Counter(content.types.values()).items()
        found = ", ".join(f"{count} of type {kind}" for kind, count in kinds)
        raise OtherCellsError(
            f"solids, elements of the types {', '.join(SOLIDS)}; found {found}: shells and beams"
            " are not read"
        )
    cells = [(SOLIDS[kind], np.array(rows)) for kind, rows in solids.items()]
    whole, notes = content.held_nodes()
    groups = content.groups() | ({HELD: whole} if whole else {})
    members = {name: [cell[n] for n in m if n in cell] for name, m in content.element_sets.items()}
    mesh = meshio.Mesh(
        np.array([*content.points.values()]).reshape(-1, 3),
        cells or [(POINT, np.zeros((0, 1), dtype=np.int64))],
        point_sets=by_place(groups, place),
        cell_sets={
            name: [np.array([row for k, row in chosen if k == kind], dtype=int) for kind in solids]
            for name, chosen in members.items()
            if chosen
        },
    )
    return SolidMesh(
        *(mesh, tuple(solids), tuple(_sections(content))),
        ignored=(*_ignored(content, solids), *notes, *_other_elements(content)),
        rigid=(*_rigid_bodies(content, place),),
        held=HELD if 2 * len(whole) > len(content.held) else "",
    )


def _ignored(content: AbaqusMesh, solids: Collection[str]) -> Iterator[str]:
    """Yield the keywords that change the motion and are not read, with their number."""
    for keyword, count in sorted(content.others.items()):
        if keyword not in HOURGLASS or "C3D8R" in solids:
            yield f"{count} *{keyword}"


def _other_elements(content: AbaqusMesh) -> Iterator[str]:
    """Yield the elements beside solids that change the motion, with their number."""
    counts = Counter(
        kind
        for number, kind in content.types.items()
        if not SOLID.fullmatch(kind) and (number in content.built or not FACES.fullmatch(kind))
    )
    yield from (f"{count} elements {kind}" for kind, count in counts.items())


def _rigid_bodies(content: AbaqusMesh, place: Mapping[int, int]) -> Iterator[tuple[str, IntArray]]:
    """Yield the keyword and the nodes of each rigid body. Couplings with one reference node are one
    body, and the reference node belongs to it."""
    bodies: dict[tuple[int, ...], tuple[str, list[int]]] = {}
    for keyword, reference, nodes in content.couplings:
        bodies.setdefault((*reference,), (keyword, [*reference]))[1].extend(nodes)
    for keyword, nodes in bodies.values():
        yield keyword, by_place({"": nodes}, place)[""]


def _sections(content: AbaqusMesh) -> Iterator[Section]:
    """Yield the materials of sets of solids; a section of trusses, for instance, has none."""
    for group, material in content.solid_sections:
        kinds = {content.types.get(number, "") for number in content.element_sets.get(group, ())}
        if not kinds:
            raise MeshFileError(f"a set {group} with elements, which a *SOLID SECTION names")
        if not any(map(SOLID.fullmatch, kinds)):
            continue
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
