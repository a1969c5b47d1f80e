"""Unstructured grids of VTK as binary .vtu files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import meshio
import numpy as np
from numpy.typing import NDArray

from bladewhirl.postprocess.fields.kinematics import Array, IntArray


@dataclass(frozen=True, kw_only=True)
class Grid:
    """Points, cells of one kind, and data on points and cells; written in single precision."""

    points: Array  #: (point, 3) [m]
    kind: Literal["vertex", "line", "quad"]
    cells: IntArray  #: points of each cell (cell, corner)
    point_data: Mapping[str, NDArray[Any]] = field(default_factory=dict)  #: (point, ...)
    cell_data: Mapping[str, NDArray[Any]] = field(default_factory=dict)  #: (cell,)


def write_vtu(path: Path, grid: Grid) -> None:
    """Write a grid as a binary .vtu file."""
    mesh = meshio.Mesh(
        _single(grid.points),
        [(grid.kind, _single(grid.cells))],
        {name: _single(values) for name, values in grid.point_data.items()},
        {name: [_single(values)] for name, values in grid.cell_data.items()},
    )
    meshio.write(path, mesh, "vtu", binary=True, compression=None)


def _single(values: NDArray[Any]) -> NDArray[Any]:
    return values.astype(np.float32 if values.dtype.kind == "f" else np.int32)
