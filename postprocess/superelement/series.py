"""ParaView series of a superelement: surface triangles of all copies, and the contact nodes."""

from pathlib import Path

import meshio
import numpy as np
import xarray as xr

from bladewhirl.meshes.plane import directions, rotate, unit
from bladewhirl.postprocess.fields.kinematics import IntArray, ViewError
from bladewhirl.postprocess.paraview.series import Progress, write_series
from bladewhirl.postprocess.superelement.motion import (
    check_superelement,
    deformed_points,
)
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
    adds it to the positions. Blades and casing also have `radial_displacement` [m], contact nodes
    the vector `force` [N].

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
        {},
        overwrite=overwrite,
        progress=progress,
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
                "copy": np.repeat(np.arange(copies), len(points)),
            },
        ),
        "contact": _contact(dataset, record, turn),
    }


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
        {"displacement": moved, "force": force, "blade": dataset["blade"].values},
    )
