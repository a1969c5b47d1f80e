"""ParaView series of a superelement: surface triangles of all copies, and the contact nodes."""

from itertools import chain
from pathlib import Path

import meshio
import numpy as np
import xarray as xr

from bladewhirl.files import claim, owned
from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.postprocess.fields.kinematics import ViewError, frame_records
from bladewhirl.postprocess.paraview.series import write_index, write_vtu
from bladewhirl.postprocess.superelement.motion import (
    check_superelement,
    deformed_points,
    turned_copies,
)
from bladewhirl.postprocess.superelement.ring import is_flexible, ring_mesh

PARTS = ("blades", "contact")
"""Parts of a series; a flexible casing is the part "casing"."""


def export_points(
    dataset: xr.Dataset,
    directory: str | Path,
    *,
    frames: int = 300,
    start: float | None = None,
    end: float | None = None,
    rotating: bool = False,
    overwrite: bool = False,
) -> Path:
    """Write a time series of the points of all copies between `start` and `end` [s].

    `blades` has the points and triangles of the file, at their undeformed positions turned by the
    rotation, with `displacement` [m] and `radial_displacement` [m]; Warp By Vector shows
    the motion. `contact` has the contact nodes with `displacement` [m] and `force` [N], vectors.
    `casing` is the inner face of a flexible casing, with `displacement` and `radial_displacement`.

    Args:
        dataset: result of a superelement with points.
        directory: folder to write.
        frames: number of instants.
        start, end: time window [s]; the whole run when None.
        rotating: true for rotating axes, in which the blades do not turn.
        overwrite: true to replace files that the manifest of the folder does not list.

    Returns:
        the path of series.pvd.

    Raises:
        ViewError: the result has no points, or the window is invalid.
    """
    check_superelement(dataset)
    if "point" not in dataset:
        raise ViewError("expected a superelement whose file has points and recovery")
    records = frame_records(dataset, frames, start, end)
    folder = Path(directory)
    parts = (*PARTS, "casing") if is_flexible(dataset) else PARTS
    names = {part: [f"frames/{part}_{n:05d}.vtu" for n in range(len(records))] for part in parts}
    earlier = [*owned(folder)]
    claim(folder, {"series.pvd", *chain.from_iterable(names.values())}, overwrite=overwrite)
    (folder / "frames").mkdir(exist_ok=True)
    index = folder / "series.pvd"
    write_index(index, [])
    for path in earlier:
        if path.parent == folder / "frames":
            path.unlink()
    entries: list[str] = []
    for frame, record in enumerate(records):
        time = float(dataset["time"][record])
        for number, (part, mesh) in enumerate(frame_meshes(dataset, int(record), rotating).items()):
            write_vtu(folder / names[part][frame], mesh)
            entries.append(
                f'    <DataSet timestep="{time!r}" part="{number}" name="{part}"'
                f' file="{names[part][frame]}"/>\n'
            )
    write_index(index, entries)
    return index


def frame_meshes(dataset: xr.Dataset, record: int, rotating: bool) -> dict[str, meshio.Mesh]:
    """Return the meshes of blades, contact nodes and a flexible casing at a record, at undeformed
    positions."""
    copies = dataset.sizes["copy"]
    turn = 0.0 if rotating else float(dataset.attrs["speed"] * dataset["time"][record])
    points = dataset["point"].values
    placed = turned_copies(dataset, np.broadcast_to(points, (copies, *points.shape)))
    moved = deformed_points(dataset, np.array([record]))[0]
    flat, motion = (about_z(values.reshape(-1, 3), turn) for values in (placed, moved))
    triangles = surface(dataset)
    numbers = np.vstack([triangles + n * len(points) for n in range(copies)])
    casing = {}
    if is_flexible(dataset):
        still = ring_mesh(dataset, record)
        back = turn - float(dataset.attrs["speed"] * dataset["time"][record])
        moved_wall = about_z(still.point_data["displacement"], back)
        casing["casing"] = meshio.Mesh(
            about_z(still.points, back),
            still.cells,
            {**still.point_data, "displacement": moved_wall},
        )
    return casing | {
        "blades": meshio.Mesh(
            flat,
            [("triangle" if numbers.shape[1] == 3 else "vertex", numbers)],
            {
                "displacement": motion,
                "radial_displacement": np.sum(outward(flat) * motion, axis=1),
                "copy": np.repeat(np.arange(copies), len(points)),
            },
        ),
        "contact": _contact(dataset, record, turn),
    }


def surface(dataset: xr.Dataset) -> IntArray:
    """Return the triangles of a copy, or each point if there are no triangles."""
    if "triangle" in dataset:
        return np.asarray(dataset["triangle"].values)
    return np.arange(dataset.sizes["point"])[:, None]


def _contact(dataset: xr.Dataset, record: int, turn: float) -> meshio.Mesh:
    angle = dataset["contact_angle"].values + turn
    radius, axial = dataset["contact_radius"].values, dataset["contact_axial"].values
    c, s = np.cos(angle), np.sin(angle)
    axes = np.stack(
        [np.stack([c, s, 0 * c], 1), np.stack([-s, c, 0 * c], 1), np.tile([0, 0, 1.0], (len(c), 1))]
    )
    moved, force = (
        np.einsum("na,anx->nx", dataset[name][record].values, axes)
        for name in ("contact_displacement", "contact_force")
    )
    return meshio.Mesh(
        np.stack([radius * c, radius * s, axial], axis=1),
        [("vertex", np.arange(len(c))[:, None])],
        {"displacement": moved, "force": force, "blade": dataset["blade"].values},
    )


def about_z(vectors: FloatArray, angle: float) -> FloatArray:
    """Return vectors (n, 3) turned about z by an angle [rad]."""
    c, s = np.cos(angle), np.sin(angle)
    return np.asarray(vectors @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]))


def outward(points: FloatArray) -> FloatArray:
    """Return the radial unit vector of each point, (n, 3); zero on the axis."""
    flat = points * [1.0, 1.0, 0.0]
    radius = np.linalg.norm(flat, axis=1, keepdims=True)
    return np.asarray(np.divide(flat, radius, out=np.zeros_like(flat), where=radius > 0.0))
