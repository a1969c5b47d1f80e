"""Reading and writing of line meshes as VTK unstructured grids, .vtu, with meshio.

Lines are cells of type line. A group is an array of integers on points or on cells, which is 1 for
its members and 0 elsewhere. An array of other integers, such as material numbers, gives a group
with the name ``name=value`` for each of its values. Data are arrays of real numbers.
"""

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import meshio
import numpy as np
from numpy.typing import NDArray

from bladewhirl.meshes.files.groups import GroupedLines, in_plane
from bladewhirl.meshes.files.meshio_cells import line_blocks, readable, stacked
from bladewhirl.meshes.line_mesh import FloatArray, IntArray

TAG, TEXT = re.compile(rb"<((?:Data)?Array)\b[^<>]*?(/?)>"), re.compile(rb"""type=["']String["']""")
"""Start of an array, and its attribute if it contains text."""

MOST_VALUES = 1000
"""Largest number of different values of an array of integers that defines groups. An array with
more values, or with a value of its own for each point or cell, is assumed to be a numbering."""


def read_vtu(path: Path) -> GroupedLines:
    """Read a .vtu file.

    Raises:
        MeshFileError: the file is unreadable or has unsupported cells.
    """
    mesh = vtu_mesh(path)
    blocks = line_blocks(mesh)
    cell_arrays = {
        name: stacked([values[block] for block in blocks])
        for name, values in mesh.cell_data.items()
    }
    return GroupedLines(
        points=in_plane(mesh.points),
        lines=stacked([mesh.cells[block].data for block in blocks]),
        node_groups=dict(integer_groups(mesh.point_data)),
        line_groups=dict(integer_groups(cell_arrays)),
        node_data=dict(_data(mesh.point_data)),
        line_data=dict(_data(cell_arrays)),
    )


def vtu_mesh(path: Path) -> meshio.Mesh:
    """Return the contents of a .vtu file as meshio reads them, without arrays of text.

    Raises:
        MeshFileError: meshio cannot read the file.
    """
    with readable(path):
        content = path.read_bytes()
        head, mark, data = content.partition(b"<AppendedData")
        if not TEXT.search(head):
            return meshio.vtu.read(str(path))
        with TemporaryDirectory() as folder:
            numbers = Path(folder) / path.name
            numbers.write_bytes(b"".join(_without_text(head)) + mark + data)
            return meshio.vtu.read(str(numbers))


def _without_text(content: bytes) -> Iterator[bytes]:
    """Yield the pieces between arrays of text, which PyVista writes and meshio cannot read. A
    pattern for whole arrays would take quadratic time."""
    after = 0
    for tag in TAG.finditer(content):
        if tag.start() >= after and TEXT.search(tag[0]):
            end = b"</" + tag[1] + b">"
            closed = tag.end() if tag[2] else content.find(end, tag.end()) + len(end)
            if closed < tag.end():  # nothing ends this array, nor those that follow
                break
            yield content[after : tag.start()]
            after = closed
    yield content[after:]


def write_vtu(path: Path, mesh: GroupedLines) -> None:
    """Write a .vtu file with all contents; `read_vtu` returns an equal mesh, with the members of
    groups in ascending order."""
    nodes, lines = len(mesh.points), len(mesh.lines)
    point_data = {k: _mark(nodes, v) for k, v in mesh.node_groups.items()} | dict(mesh.node_data)
    cell_data = {k: _mark(lines, v) for k, v in mesh.line_groups.items()} | dict(mesh.line_data)
    meshio.vtu.write(
        str(path),
        meshio.Mesh(
            np.column_stack([mesh.points, np.zeros(nodes)]),
            [("line", mesh.lines)],
            point_data=point_data,
            cell_data={name: [values] for name, values in cell_data.items()},
        ),
    )


def _mark(size: int, chosen: IntArray) -> IntArray:
    marks = np.zeros(size, dtype=np.int64)
    marks[chosen] = 1
    return marks


def integer_groups(arrays: Mapping[str, NDArray[Any]]) -> Iterator[tuple[str, IntArray]]:
    """Yield the names and members of the groups that arrays of integers define."""
    for name, values in arrays.items():
        if values.ndim != 1 or values.dtype.kind not in "iub":
            continue
        distinct = np.unique(values)
        if set(distinct.tolist()) <= {0, 1}:
            yield name, np.flatnonzero(values)
        elif len(distinct) <= MOST_VALUES and len(distinct) < len(values):
            for value in distinct:
                yield f"{name}={value}", np.flatnonzero(values == value)


def _data(arrays: Mapping[str, NDArray[Any]]) -> Iterator[tuple[str, FloatArray]]:
    for name, values in arrays.items():
        if values.ndim == 1 and values.dtype.kind == "f":
            yield name, np.asarray(values, dtype=np.float64)
