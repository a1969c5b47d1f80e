"""Motion of the points and the contact nodes of a superelement."""

from os import PathLike

import numpy as np
import xarray as xr

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.meshes.plane import rotate
from bladewhirl.postprocess.fields.kinematics import ViewError
from bladewhirl.postprocess.fields.labelled import labelled
from bladewhirl.postprocess.fields.result import ResultError, open_result, portions
from bladewhirl.solvers.march.schema import NODES, tables_of

DIRECTIONS = ("radial", "tangential", "axial")
"""Names of the components of the displacement of a contact node."""


def check_superelement(dataset: xr.Dataset) -> xr.Dataset:
    """Return the result if it is that of a superelement.

    Raises:
        ResultError: it is the result of a bladed disk of beams.
    """
    if tables_of(dataset.attrs) is not NODES:
        raise ResultError("expected the result of a superelement, not of a bladed disk of beams")
    return dataset


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
    check_superelement(result)
    points, copies = result.sizes.get("point", 0), result.sizes["copy"]
    if not 0 <= point < points:
        raise ViewError(f"point {point}: expected a point from 0 to {points - 1}")
    if not 0 <= copy < copies:
        raise ViewError(f"copy {copy}: expected a copy from 0 to {copies - 1}")
    shape = result["point_shape"].isel(point=point).values
    moved = np.empty((result.sizes["time"], 3))
    for portion in portions(result):
        moved[portion] = result["modal_displacement"][portion, copy].values @ shape.T
    return xr.DataArray(
        moved,
        dims=("time", "xyz"),
        coords={"time": result["time"], "xyz": ["x", "y", "z"]},
        attrs={"units": "m", "long_name": f"displacement of point {point} of copy {copy}"},
    )


def deformed_points(dataset: xr.Dataset, records: IntArray) -> FloatArray:
    """Return the displacement of all points of all copies, in axes that turn with the first copy.

    Returns:
        displacements [m], (records, copies, points, 3).
    """
    shape = dataset["point_shape"].values
    moved = np.einsum(
        "rcm,pam->rcpa", dataset["modal_displacement"].isel(time=records).values, shape
    )
    return rotate(moved, dataset["copy_angle"].values[:, None])


def contact_nodes(result: xr.Dataset) -> xr.Dataset:
    """Compute the mean contact forces between records, and the share of time in contact.

    Args:
        result: result of a superelement.

    Returns:
        Dataset over (time, contact_node): `force` and `friction` [N], means of the normal and the
        tangential force since the last record; `share` [1]. `impulse` [N s] over (contact_node) is
        the sum of the normal impulses.
    """
    check_superelement(result)
    spacing = np.diff(result["time"].values, prepend=-np.inf)[:, None]
    steps = spacing / float(result.attrs["time_step"])
    over = ("time", "contact_node")
    impulse = result["contact_impulse"].values
    computed = labelled(
        result,
        "contact forces by contact node",
        {
            "force": (over, impulse / spacing, "N"),
            "friction": (over, result["friction_impulse"].values / spacing, "N"),
            "share": (over, result["contact_steps"].values / steps, "1"),
            "impulse": (("contact_node",), impulse.sum(axis=0), "N s"),
        },
        {"time": result["time"].values},
    )
    places = ("blade", "node", "contact_angle", "contact_axial")
    return computed.assign_coords({name: result[name] for name in places})


def tip_orbits(result: xr.Dataset, *, turns: float = 5.0, copy: int = 0) -> xr.Dataset:
    """Return the displacements of the contact nodes of a copy in the last revolutions.

    Args:
        result: result of a superelement.
        turns: number of revolutions; at standstill the whole run is returned.
        copy: number of the copy.

    Returns:
        Dataset over (time, node): `radial`, `tangential` and `axial` [m], in rotating axes.
    """
    check_superelement(result)
    time, speed = result["time"].values, abs(float(result.attrs["speed"]))
    last = time >= time[-1] - (2.0 * np.pi * turns / speed if speed else np.inf)
    nodes = result.sizes["contact_node"] // result.sizes["copy"]
    moved = result["contact_displacement"][last, copy * nodes : (copy + 1) * nodes].values
    return labelled(
        result,
        f"displacements of the contact nodes of copy {copy}",
        {name: (("time", "node"), moved[:, :, i], "m") for i, name in enumerate(DIRECTIONS)},
        {"time": time[last]},
    )
