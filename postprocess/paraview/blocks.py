"""The stage at an instant as pyvista's own objects, for plots of one's own."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from bladewhirl.postprocess.fields.kinematics import nearest_records
from bladewhirl.postprocess.paraview.series import line_parts, surface_parts

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
    """Parts of the stage by name, with the fields of `export_vtk`.

    Args:
        dataset: a result.
        time: of which the nearest record is taken [s].
        surface: boxes of true thickness and width, not lines.
        rotating: seen from the rotor.
        factor: on the displacement that points are moved by; 0 leaves them undeformed, with
            `displacement` to warp by.

    Raises:
        ResultError: an old result that knows no sections.
    """
    import pyvista

    record = nearest_records(dataset, np.array([time]))
    parts, _ = (surface_parts if surface else line_parts)(dataset, rotating)
    blocks = pyvista.MultiBlock()
    for name, meshes in parts.items():
        block = pyvista.from_meshio(meshes(record)[0])
        block.points = block.points + factor * block.point_data["displacement"]
        blocks[name] = block
    return blocks
