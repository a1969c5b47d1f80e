"""ParaView series of a superelement: surface triangles of all copies, and the contact nodes."""

from pathlib import Path
from typing import Any

import meshio
import numpy as np
import xarray as xr
from scipy.spatial import KDTree

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.meshes.plane import directions, rotate, unit
from bladewhirl.postprocess.fields.kinematics import IntArray, ViewError
from bladewhirl.postprocess.paraview.series import Progress, view_script, write_series
from bladewhirl.postprocess.superelement.motion import check_superelement, deformed_points
from bladewhirl.postprocess.superelement.ring import is_flexible, ring_mesh

PARTS = ("blades", "contact")
"""Parts of every series; with a flexible casing a series also has the part "casing"."""


def export_points(
    dataset: xr.Dataset,
    directory: str | Path,
    *,
    records: IntArray,
    rotating: bool = False,
    overwrite: bool = False,
    progress: Progress | None = None,
) -> Path:
    """Write a time series of the points of all copies.

    The part `blades` has the points and triangles of the superelement file, `contact` the contact
    nodes, `casing` the inner face of a flexible casing. Coordinates are undeformed positions,
    turned with the body. The motion is in the array `displacement` [m]; the filter Warp By Vector
    adds it to the positions, as view.py does. Blades and casing also have `radial_displacement`
    [m], contact nodes the vector `contact_force` [N]; blades and contact nodes have the number
    `blade`, on a wheel that of the nearest contact node.

    Args:
        dataset: result of a superelement with points.
        directory: folder to write.
        records: numbers of records.
        rotating: true for rotating axes, in which the blades do not turn.
        overwrite: true to replace files that the manifest of the folder does not list.
        progress: called with the numbers of finished and of all instants.

    Returns:
        the path of series.pvd.

    Raises:
        ViewError: the result has no points.
    """
    check_superelement(dataset)
    if "point" not in dataset:
        raise ViewError("expected a superelement whose file has points and recovery")
    return write_series(
        Path(directory),
        (*PARTS, "casing") if is_flexible(dataset) else PARTS,
        dataset["time"].values[records],
        (frame_meshes(dataset, int(record), rotating) for record in records),
        {"view.py": view_script(_about(dataset, records))},
        overwrite=overwrite,
        progress=progress,
    )


def _about(dataset: xr.Dataset, records: IntArray) -> dict[str, Any]:
    """Return the description of the series for view.py, which shows the strongest contact."""
    forces = np.linalg.norm(dataset["contact_force"].values[records], axis=-1).max(axis=1)
    moved = [np.linalg.norm(deformed_points(dataset, records[[n]])) for n in range(len(records))]
    shown = int(np.argmax(forces if forces.any() else moved))
    largest = np.linalg.norm(deformed_points(dataset, records[[np.argmax(moved)]]), axis=-1).max()
    copies = dataset["copy_angle"].values[:, None]
    return {
        "title": str(dataset.attrs["title"]),
        "time": float(dataset["time"].values[records[shown]]),
        "vectors": "displacement",
        "exaggeration": 1.0,
        "largest_displacement": float(largest),
        "largest_force": float(forces.max()),
        "size": float(np.ptp(rotate(dataset["point"].values, copies), axis=(0, 1)).max()) / 2.0,
        "parts": [*PARTS],
    }


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
    radius, axial = dataset["contact_radius"].values, dataset["contact_axial"].values
    nodes = np.column_stack([radius[:, None] * directions(dataset["contact_angle"].values), axial])
    return np.asarray(dataset["blade"].values[KDTree(nodes).query(placed[0])[1]])


def _contact(dataset: xr.Dataset, record: int, turn: float) -> meshio.Mesh:
    angle = dataset["contact_angle"].values + turn
    radius, axial = dataset["contact_radius"].values, dataset["contact_axial"].values
    moved, force = (
        rotate(dataset[name][record].values, angle)
        for name in ("contact_displacement", "contact_force")
    )
    return meshio.Mesh(
        np.column_stack([radius[:, None] * directions(angle), axial]),
        [("vertex", np.arange(len(angle))[:, None])],
        {"displacement": moved, "contact_force": force, "blade": dataset["blade"].values},
    )
