"""Writing of line meshes as Abaqus input, .inp.

Groups are written as sets, NSET for nodes and ELSET for lines; rectangular sections with their
materials and point masses are written as data. `abaqus_lines` reads such files.
"""

import re
from pathlib import Path
from typing import TextIO

import numpy as np

from bladewhirl.meshes.files.abaqus_lines import OWN_SETS, POINT_MASSES, SECTION
from bladewhirl.meshes.files.groups import GroupedLines, MeshFileError
from bladewhirl.meshes.line_mesh import IntArray

ELEMENT = "B23"
"""Type of the elements: cubic Euler-Bernoulli beams in the plane, as in this package."""

A_LINE = 8  #: number of members of a set on one line


def write_inp(path: Path, mesh: GroupedLines) -> None:
    """Write the beams of a mesh as an .inp file, with sets, sections and point masses.

    Lines that are not beams and all other data are left out.

    Raises:
        MeshFileError: Abaqus does not allow a name.
    """
    mesh = mesh.beams()
    for name in [*mesh.node_groups, *mesh.line_groups]:
        if not re.fullmatch(r"[A-Za-z][\w -]{0,79}", name, re.ASCII) or OWN_SETS.fullmatch(name):
            raise MeshFileError(f"for .inp, names of letters, digits, _ and -, not {name!r}")
    with path.open("w", encoding="utf-8", newline="\n") as stream:
        stream.write("*HEADING\nline mesh written by bladewhirl\n*NODE\n")
        for number, (x, y) in enumerate(mesh.points.tolist(), 1):
            stream.write(f"{number}, {x!r}, {y!r}, 0.\n")
        stream.write(f"*ELEMENT, TYPE={ELEMENT}\n")
        for number, (first, second) in enumerate((mesh.lines + 1).tolist(), 1):
            stream.write(f"{number}, {first}, {second}\n")
        for name, nodes in mesh.node_groups.items():
            _write_set(stream, "NSET", name, nodes)
        for name, lines in mesh.line_groups.items():
            _write_set(stream, "ELSET", name, lines)
        _write_sections(stream, mesh)
        _write_masses(stream, mesh)


def _write_set(stream: TextIO, kind: str, name: str, members: IntArray) -> None:
    stream.write(f"*{kind}, {kind}={name}\n")
    numbers = [str(number) for number in (np.asarray(members) + 1).tolist()]
    for begin in range(0, len(numbers), A_LINE):
        stream.write(", ".join(numbers[begin : begin + A_LINE]) + "\n")


def _write_sections(stream: TextIO, mesh: GroupedLines) -> None:
    if not all(name in mesh.line_data for name in SECTION):
        return
    table = np.column_stack([mesh.line_data[name] for name in SECTION])
    known = np.flatnonzero(np.isfinite(table).all(axis=1))
    sections, kind = np.unique(table[known], axis=0, return_inverse=True)
    materials = [*dict.fromkeys(map(tuple, sections[:, 2:].tolist()))]
    for number, (young_modulus, density) in enumerate(materials, 1):
        stream.write(f"*MATERIAL, NAME=material-{number}\n*ELASTIC\n{young_modulus!r}, 0.\n")
        stream.write(f"*DENSITY\n{density!r}\n")
    for number, (width, thickness, *material) in enumerate(sections.tolist(), 1):
        _write_set(stream, "ELSET", f"section-{number}", known[kind.ravel() == number - 1])
        name = f"material-{materials.index(tuple(material)) + 1}"
        stream.write(f"*BEAM SECTION, ELSET=section-{number}, MATERIAL={name}, SECTION=RECT\n")
        stream.write(f"{width!r}, {thickness!r}\n0., 0., -1.\n")


def _write_masses(stream: TextIO, mesh: GroupedLines) -> None:
    number = len(mesh.lines)
    for kind, name in POINT_MASSES.items():
        values = mesh.node_data.get(name, np.zeros(len(mesh.points)))
        for place, value in enumerate(np.unique(values[values > 0.0]).tolist(), 1):
            stream.write(f"*ELEMENT, TYPE={kind}, ELSET={name}-{place}\n")
            for node in np.flatnonzero(values == value):
                number += 1
                stream.write(f"{number}, {node + 1}\n")
            keyword = "MASS" if kind == "MASS" else "ROTARY INERTIA"
            row = f"{value!r}" if kind == "MASS" else f"0., 0., {value!r}"
            stream.write(f"*{keyword}, ELSET={name}-{place}\n{row}\n")
