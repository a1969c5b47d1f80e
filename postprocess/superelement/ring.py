"""Motion of the flexible casing around a superelement."""

from collections.abc import Callable

import meshio
import numpy as np
import xarray as xr
from scipy.interpolate import CubicSpline

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.meshes.plane import directions, rotate
from bladewhirl.postprocess.fields.labelled import labelled
from bladewhirl.postprocess.fields.result import ResultError
from bladewhirl.postprocess.superelement.motion import check_superelement


def is_flexible(dataset: xr.Dataset) -> bool:
    """Return true if the casing around a superelement is flexible, false for a rigid wall."""
    return "casing_shape" in dataset


def ring_displacement(dataset: xr.Dataset, records: IntArray) -> FloatArray:
    """Return radial and tangential displacements of the casing nodes [m], (records, nodes, 2)."""
    shape = dataset["casing_shape"].values[:, ::2]
    moved = dataset["casing_displacement"].isel(time=records).values
    return np.asarray(np.einsum("nam,rm->rna", shape, moved))


def wall_at(dataset: xr.Dataset, record: int) -> Callable[[FloatArray], FloatArray]:
    """Return a function of the angle in the static frame [rad]: clearance plus radial displacement
    of the casing at a record [m]."""
    values = dataset["clearance"].values
    if is_flexible(dataset):
        values = values + ring_displacement(dataset, np.array([record]))[0, :, 0]
    angle = np.append(dataset["wall_angle"].values, 2.0 * np.pi)
    spline = CubicSpline(angle, np.append(values, values[0]), bc_type="periodic")
    return lambda at: np.asarray(spline(np.mod(at, 2.0 * np.pi)))


def ring_motion(result: xr.Dataset) -> xr.Dataset:
    """Compute displacement and strain energy of a flexible casing over time.

    Args:
        result: result of a superelement with a flexible casing.

    Returns:
        Dataset: `radial` and `tangential` [m] over (time, casing_node); `energy` [J] over (time,
        nodal_diameter), the strain energy of the casing and its supports.

    Raises:
        ResultError: the casing is rigid.
    """
    check_superelement(result)
    if not is_flexible(result):
        raise ResultError("expected a flexible casing, found a rigid wall")
    records = np.arange(result.sizes["time"])
    moved = ring_displacement(result, records)
    squares = result["casing_frequency"].values * result["casing_displacement"].values
    diameter, member = np.unique(result["casing_nodal_diameter"].values, return_inverse=True)
    energy = 0.5 * squares**2 @ np.eye(len(diameter))[member]
    over = ("time", "casing_node")
    return labelled(
        result,
        "motion of the casing",
        {
            "radial": (over, moved[:, :, 0], "m"),
            "tangential": (over, moved[:, :, 1], "m"),
            "energy": (("time", "nodal_diameter"), energy, "J"),
        },
        {"time": result["time"].values, "nodal_diameter": diameter},
    ).assign_coords(casing_angle=result["casing_angle"])


def ring_mesh(dataset: xr.Dataset, record: int, turn: float) -> meshio.Mesh:
    """Return the inner face of the casing as quadrilaterals at undeformed positions, with the
    displacement at a record, in axes in which the casing is turned by an angle [rad]."""
    angle, radius = dataset["casing_angle"].values, float(dataset.attrs["casing_radius"])
    axial, half = dataset["contact_axial"].values, 0.5 * dataset["casing_width"].values
    middle, nodes = 0.5 * (axial.min() + axial.max()), len(angle)
    polar = np.pad(ring_displacement(dataset, np.array([record]))[0], ((0, 0), (0, 1)))
    moved = rotate(rotate(polar, angle), turn)
    sides = [
        np.column_stack([radius * directions(angle), middle + sign * half]) for sign in (-1.0, 1.0)
    ]
    first = np.arange(nodes)
    second = (first + 1) % nodes
    return meshio.Mesh(
        rotate(np.vstack(sides), turn),
        [("quad", np.column_stack([first, second, second + nodes, first + nodes]))],
        {"displacement": np.vstack([moved, moved]), "radial_displacement": np.tile(polar[:, 0], 2)},
    )
