"""Motion of the contact nodes and the points of a superelement, and of the wall around it."""

from collections.abc import Callable
from os import PathLike

import meshio
import numpy as np
import xarray as xr
from scipy.interpolate import CubicSpline
from scipy.spatial import KDTree

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.meshes.plane import directions, rotate, unit
from bladewhirl.postprocess.fields.kinematics import ViewError
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
    need(result, "copy_angle")
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


def deformed_points(dataset: xr.Dataset, records: IntArray) -> FloatArray:
    """Return the displacement of all points of all copies, in axes that turn with the first copy.

    Returns:
        displacements [m], (records, copies, points, 3).
    """
    shape = dataset["point_shape"].values
    modal = dataset["rotor_displacement"].isel(time=records).values
    modal = modal.reshape(len(modal), dataset.sizes["copy"], -1)
    moved = np.einsum("rcm,pam->rcpa", modal, shape)
    return rotate(moved, dataset["copy_angle"].values[:, None])


def is_flexible(dataset: xr.Dataset) -> bool:
    """Return true if the casing is flexible, false for a rigid wall."""
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


def ring_mesh(dataset: xr.Dataset, record: int, turn: float) -> meshio.Mesh:
    """Return the inner face of the casing as quadrilaterals at undeformed positions, with the
    displacement at a record, in axes in which the casing is turned by an angle [rad]."""
    angle, radius = dataset["casing_angle"].values, float(dataset.attrs["casing_radius"])
    axial, half = dataset["axial_position"].values, 0.5 * dataset["casing_width"].values
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


def frame_meshes(dataset: xr.Dataset, record: int, rotating: bool) -> dict[str, meshio.Mesh]:
    """Return the meshes of blades, contact nodes and a flexible casing at a record; points are at
    undeformed positions, and displacements are arrays."""
    copies = dataset.sizes["copy"]
    ahead = float(dataset.attrs["speed"] * dataset["time"][record])
    turn = 0.0 if rotating else ahead
    points = dataset["point"].values
    placed = rotate(points, dataset["copy_angle"].values[:, None])
    moved = deformed_points(dataset, np.array([record]))[0]
    flat, motion = (rotate(values.reshape(-1, 3), turn) for values in (placed, moved))
    kind, cells = "vertex", np.arange(len(points))[:, None]
    if "triangle" in dataset:
        kind, cells = "triangle", dataset["triangle"].values
    meshes = {"casing": ring_mesh(dataset, record, turn - ahead)} if is_flexible(dataset) else {}
    return meshes | {
        "blades": meshio.Mesh(
            flat,
            [(kind, np.vstack([cells + n * len(points) for n in range(copies)]))],
            {
                "displacement": motion,
                "radial_displacement": np.sum(unit(flat * [1.0, 1.0, 0.0]) * motion, axis=1),
                "blade": _blades(dataset, placed),
            },
        ),
        "contact": _contact(dataset, record, turn),
    }


def _blades(dataset: xr.Dataset, placed: FloatArray) -> IntArray:
    """Return the blade of each point at its position at rest, (points,): its copy or, on a single
    body with several blades, the blade of the nearest contact node."""
    copies, points = placed.shape[:2]
    if copies > 1:
        return np.repeat(np.arange(copies), points)
    radius, axial = dataset["contact_radius"].values, dataset["axial_position"].values
    nodes = np.column_stack([radius[:, None] * directions(dataset["tip_angle"].values), axial])
    return np.asarray(dataset["blade"].values[KDTree(nodes).query(placed[0])[1]])


def _contact(dataset: xr.Dataset, record: int, turn: float) -> meshio.Mesh:
    angle = dataset["tip_angle"].values + turn
    radius, axial = dataset["contact_radius"].values, dataset["axial_position"].values
    moved, force = (
        rotate(dataset[name][record].values, angle)
        for name in ("contact_displacement", "contact_force")
    )
    return meshio.Mesh(
        np.column_stack([radius[:, None] * directions(angle), axial]),
        [("vertex", np.arange(len(angle))[:, None])],
        {"displacement": moved, "contact_force": force, "blade": dataset["blade"].values},
    )
