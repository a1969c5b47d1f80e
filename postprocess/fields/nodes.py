"""Motion of the contact nodes and the points of a superelement."""

from os import PathLike

import meshio
import numpy as np
import xarray as xr
from scipy.spatial import KDTree

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.meshes.plane import directions, rotate, unit
from bladewhirl.postprocess.fields import rotation
from bladewhirl.postprocess.fields.by_blade import of_blades
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


def copy_coordinates(dataset: xr.Dataset, name: str, records: IntArray) -> FloatArray:
    """Return modal coordinates or their rates at some records, (record, copy, mode)."""
    values = dataset[name].isel(time=records).values
    return np.asarray(values.reshape(len(values), dataset.sizes["copy"], -1))


def point_vectors(dataset: xr.Dataset, coordinates: FloatArray) -> FloatArray:
    """Return displacements or velocities of all points, in axes that turn with the first copy.

    Args:
        dataset: result of a superelement with points.
        coordinates: modal coordinates, or their rates, (copy, mode).

    Returns:
        vectors (point, 3), of one copy after another [m] or [m/s].
    """
    shape = dataset["point_shape"].values
    moved = (coordinates @ shape.reshape(-1, shape.shape[-1]).T).reshape(len(coordinates), -1, 3)
    return rotate(moved, dataset["copy_angle"].values[:, None]).reshape(-1, 3)


def placed_points(dataset: xr.Dataset) -> FloatArray:
    """Return the undeformed points of all copies, (point, 3) [m]."""
    angle = dataset["copy_angle"].values[:, None]
    return rotate(dataset["point"].values, angle).reshape(-1, 3)


def copied_cells(dataset: xr.Dataset) -> IntArray:
    """Return the points of each triangle of all copies, or each point if there are no triangles,
    (cell, corner)."""
    points = dataset.sizes["point"]
    cells = np.arange(points)[:, None]
    if "triangle" in dataset:
        cells = dataset["triangle"].values
    return np.vstack([cells + n * points for n in range(dataset.sizes["copy"])])


def placed_contact_nodes(dataset: xr.Dataset) -> FloatArray:
    """Return the undeformed contact nodes, (contact_node, 3) [m]."""
    radius, axial = dataset["contact_radius"].values, dataset["axial_position"].values
    return np.column_stack([radius[:, None] * directions(dataset["tip_angle"].values), axial])


def point_blades(dataset: xr.Dataset) -> IntArray:
    """Return the blade of each point of all copies, (point,): its copy or, on a single body with
    several blades, the blade of the nearest contact node."""
    copies, points = dataset.sizes["copy"], dataset.sizes["point"]
    if copies > 1:
        return np.repeat(np.arange(copies), points)
    nearest = KDTree(placed_contact_nodes(dataset)).query(dataset["point"].values)[1]
    return np.asarray(dataset["blade"].values[nearest])


def ring_displacement(dataset: xr.Dataset, records: IntArray) -> FloatArray:
    """Return radial and tangential displacements of the casing nodes [m], (records, nodes, 2)."""
    moved = history(dataset, "casing_displacement", records)
    return combine(moved, dataset["casing_shape"].values[:, ::2])


def frame_meshes(dataset: xr.Dataset, record: int, rotating: bool) -> dict[str, meshio.Mesh]:
    """Return the meshes of blades and contact nodes at a record; points are at undeformed
    positions, and displacements are arrays."""
    speed, ahead = rotation.speeds(dataset)[record], rotation.angles(dataset)[record]
    turn, spin = (0.0, 0.0) if rotating else (ahead, speed)
    coordinates, rates = (
        copy_coordinates(dataset, f"rotor_{name}", np.array([record]))[0]
        for name in ("displacement", "velocity")
    )
    placed, moved = placed_points(dataset), point_vectors(dataset, coordinates)
    # The rate of the displacement vector in the axes of the grid.
    velocity = point_vectors(dataset, rates) + spin * np.cross([0.0, 0.0, 1.0], moved)
    cells, gap = (
        copied_cells(dataset),
        of_blades(dataset, dataset["gap"][[record]].values, np.minimum),
    )
    return {
        "blades": meshio.Mesh(
            rotate(placed, turn),
            [("triangle" if cells.shape[1] == 3 else "vertex", cells)],
            {
                "displacement": rotate(moved, turn),
                "velocity": rotate(velocity, turn),
                "gap": gap[0, point_blades(dataset)],
                "radial_displacement": np.sum(unit(placed * [1.0, 1.0, 0.0]) * moved, axis=1),
                "blade": point_blades(dataset),
            },
        ),
        "contact": _contact(dataset, record, turn),
    }


def _contact(dataset: xr.Dataset, record: int, turn: float) -> meshio.Mesh:
    angle = dataset["tip_angle"].values + turn
    moved = dataset["contact_displacement"][record].values
    force = dataset["contact_force"][record].values if "contact_force" in dataset else 0.0 * moved
    return meshio.Mesh(
        rotate(placed_contact_nodes(dataset), turn),
        [("vertex", np.arange(len(angle))[:, None])],
        {
            "displacement": rotate(moved, angle),
            "contact_force": rotate(force, angle),
            "gap": dataset["gap"][record].values,
            "blade": dataset["blade"].values,
        },
    )
