"""Unstructured grids of VTK as binary .vtu files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from bladewhirl.postprocess.fields.kinematics import Array, IntArray

CELL_TYPES = {"vertex": 1, "line": 3, "quad": 9}
"""Cell types of VTK."""

SINGLE, WHOLE = np.dtype("<f4"), np.dtype("<i4")
TYPES = {"f4": "Float32", "i4": "Int32", "u1": "UInt8"}


@dataclass(frozen=True, kw_only=True)
class Grid:
    """Points, cells of one kind, and data on both; numbers are written in single precision."""

    points: Array  #: (point, 3) [m]
    kind: Literal["vertex", "line", "quad"]
    cells: IntArray  #: points of each cell (cell, corner)
    point_data: Mapping[str, NDArray[Any]] = field(default_factory=dict)  #: (point, ...)
    cell_data: Mapping[str, NDArray[Any]] = field(default_factory=dict)  #: (cell,)


def write_vtu(path: Path, grid: Grid) -> None:
    """Write a grid as a binary .vtu file; a field `warp` is the default vector of ParaView."""
    count, corners = grid.cells.shape
    mesh = {
        "connectivity": grid.cells.ravel(),
        "offsets": corners * np.arange(1, count + 1),
        "types": np.full(count, CELL_TYPES[grid.kind], dtype=np.uint8),
    }
    active = ' Vectors="warp"' if "warp" in grid.point_data else ""
    blocks: list[NDArray[Any]] = []
    end = 0

    def described(arrays: Mapping[str, NDArray[Any]]) -> str:
        nonlocal end
        lines = []
        for name, values in arrays.items():
            block = np.ascontiguousarray(values, dtype=_stored(values))
            blocks.append(block)
            # Left out for scalars: meshio would add an axis.
            parts = f'NumberOfComponents="{block.shape[1]}" ' if block.ndim > 1 else ""
            lines.append(
                f'<DataArray type="{TYPES[block.dtype.str[1:]]}" Name="{name}" '
                f'{parts}format="appended" offset="{end}"/>\n'
            )
            end += 8 + block.nbytes
        return "".join(lines)

    head = (
        '<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" version="1.0" '
        'byte_order="LittleEndian" header_type="UInt64">\n<UnstructuredGrid>\n'
        f'<Piece NumberOfPoints="{len(grid.points)}" NumberOfCells="{count}">\n'
        f"<Points>\n{described({'points': grid.points})}</Points>\n"
        f"<Cells>\n{described(mesh)}</Cells>\n"
        f"<PointData{active}>\n{described(grid.point_data)}</PointData>\n"
        f"<CellData>\n{described(grid.cell_data)}</CellData>\n"
        '</Piece>\n</UnstructuredGrid>\n<AppendedData encoding="raw">\n_'
    )
    with path.open("wb") as file:
        file.write(head.encode())
        for block in blocks:
            file.write(block.nbytes.to_bytes(8, "little"))
            file.write(block.data)
        file.write(b"\n</AppendedData>\n</VTKFile>\n")


def _stored(values: NDArray[Any]) -> np.dtype[Any]:
    """Type in which numbers are written."""
    if values.dtype.kind == "f":
        return SINGLE
    return values.dtype if values.dtype.itemsize == 1 else WHOLE
