"""Meshes of lines from input of Abaqus and CalculiX, .inp.

Groups are sets: NSET for nodes, ELSET for elements. The data of lines are rectangular sections with
their materials (BEAM SECTION, ELASTIC, DENSITY) and point masses (MASS, ROTARYI); their units are
the choice of the author of the file.
"""

import re
from collections import Counter
from collections.abc import Iterator, Mapping
from itertools import chain
from pathlib import Path

import numpy as np

from bladewhirl.meshes.files.abaqus_mesh import AbaqusMesh, by_place
from bladewhirl.meshes.files.abaqus_reader import read_abaqus
from bladewhirl.meshes.files.groups import GroupedLines, MeshFileError, OtherCellsError, in_plane
from bladewhirl.meshes.line_mesh import FloatArray

STRAIGHT = re.compile(r"(T[23]D2|B[23][13]|PIPE[23]1|FRAME[23]D)(OS|R)?H?")
CURVED = re.compile(r"(T[23]D3|B[23]2|PIPE[23]2)(OS|R)?H?")
POINT_MASSES = {"MASS": "mass", "ROTARYI": "inertia"}
"""Types of elements with one node, and the names of their data."""

SECTION = ("width", "thickness", "young_modulus", "density")
OWN_SETS = re.compile(r"(section|mass|inertia)-\d+", re.I)
"""Names of sets that the writer makes for sections and masses; they are not groups of the mesh."""


def read_inp(path: Path) -> GroupedLines:
    """Read the lines of an .inp file, with their sets, sections and point masses.

    Raises:
        MeshFileError: the file is not a valid .inp file, has other elements than straight lines and
            point masses, or has unsupported keywords that would change the mesh.
    """
    content = read_abaqus(path, follow=False)
    for kind, count in Counter(content.types.values()).items():
        if CURVED.fullmatch(kind):
            raise MeshFileError(
                f"straight two-node lines, found {count} curved cells of type {kind}: mesh with "
                "elements of first order, and shorter ones along curves"
            )
        if kind not in POINT_MASSES and not STRAIGHT.fullmatch(kind):
            raise OtherCellsError(f"lines only, found {count} cells of type {kind}")
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
        node_groups=by_place(content.node_sets, node),
        line_groups=by_place(elements, line),
        node_data=_mass_data(content, node),
        line_data=_section_data(content, line),
        ignored=(*_ignored(content),),
    )


def _ignored(content: AbaqusMesh) -> Iterator[str]:
    """Yield the keywords that change the motion and are not read, with their number."""
    counts = content.others + Counter(keyword[1:] for keyword, *_ in content.couplings)
    yield from (f"{count} *{keyword}" for keyword, count in sorted(counts.items()))
    if content.held:
        yield f"*BOUNDARY of {len(content.held)} nodes"


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
