"""Stage at one instant as pyvista objects, for users who draw their own plots."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from bladewhirl.postprocess.fields.kinematics import nearest_records
from bladewhirl.postprocess.paraview.parts import StageParts

if TYPE_CHECKING:
    import pyvista


def stage_blocks(
    dataset: xr.Dataset,
    time: float,
    *,
    surface: bool = True,
    rotating: bool = False,
    factor: float = 0.0,
) -> pyvista.MultiBlock:
    """Return the parts of the stage by name, with the fields of `export_vtk`.

    Args:
        dataset: a result.
        time: time of the nearest record [s].
        surface: boxes of true thickness and width instead of lines.
        rotating: rotating instead of static axes.
        factor: exaggeration of displacement and clearance, as in `render`; 0 leaves the points
            undeformed, with `displacement` and, for a suitable factor, `warp` as vectors.

    Raises:
        ResultError: the result is of an old format without cross-sections.
    """
    import pyvista

    record = nearest_records(dataset, np.array([time]))
    parts = StageParts(
        dataset, record, surface=surface, rotating=rotating, exaggeration=factor or None
    )
    blocks = pyvista.MultiBlock()
    for name, grid in next(parts.grids()).items():
        kind = pyvista.CellType[grid.kind.upper()]
        block = pyvista.UnstructuredGrid({kind: grid.cells}, grid.points)
        block.point_data.update(grid.point_data)
        block.cell_data.update(grid.cell_data)
        if factor:
            block.points = block.points + grid.point_data["warp"]
        blocks[name] = block
    return blocks
