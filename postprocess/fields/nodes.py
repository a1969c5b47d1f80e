"""Motion of the points of a superelement, and of the nodes of the casing."""

from os import PathLike

import numpy as np
import xarray as xr

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.postprocess.fields.kinematics import ViewError, combine, history
from bladewhirl.postprocess.fields.netcdf import need
from bladewhirl.postprocess.fields.result import open_result, portions

DIRECTIONS = ("radial", "tangential", "axial")
"""Names of the components of the displacement of a contact node."""


def displacement(
    result: xr.Dataset | str | PathLike[str], point: int, *, copy: int = 0
) -> xr.DataArray:
    """Return the displacement of a point of a superelement over time, in rotating axes.

    The points are those in the file of the superelement; their displacement follows from the matrix
    `recovery` in this file. The flexible part of the displacement near contact nodes is not
    included.

    Args:
        result: result of a superelement, or its file or folder.
        point: number of the point.
        copy: number of the copy.

    Returns:
        DataArray (time, xyz) [m]; x, y and z are the axes of the first copy turned to this copy.

    Raises:
        ViewError: the superelement has no point, or no copy, of this number.
        ResultError: it is the result of a bladed disk of beams.
    """
    if not isinstance(result, xr.Dataset):
        with open_result(result) as dataset:
            return displacement(dataset, point, copy=copy).load()
    need(result, "point_shape")
    points, copies = result.sizes.get("point", 0), result.sizes["copy"]
    if not 0 <= point < points:
        raise ViewError(f"point {point}: expected a point from 0 to {points - 1}")
    if not 0 <= copy < copies:
        raise ViewError(f"copy {copy}: expected a copy from 0 to {copies - 1}")
    shape = result["point_shape"].isel(point=point).values
    moved = np.empty((result.sizes["time"], 3))
    for portion in portions(result):
        modal = result["rotor_displacement"][portion].values
        moved[portion] = modal.reshape(len(modal), copies, -1)[:, copy] @ shape.T
    return xr.DataArray(
        moved,
        dims=("time", "xyz"),
        coords={"time": result["time"], "xyz": ["x", "y", "z"]},
        attrs={"units": "m", "long_name": f"displacement of point {point} of copy {copy}"},
    )


def ring_displacement(dataset: xr.Dataset, records: IntArray) -> FloatArray:
    """Return radial and tangential displacements of the casing nodes [m], (records, nodes, 2)."""
    moved = history(dataset, "casing_displacement", records)
    return combine(moved, dataset["casing_shape"].values[:, ::2])
