"""ParaView time series of a run: grids of the parts at some instants, and an index of the files.

The folder contains `series.pvd` (the index, which ParaView opens), `view.py` (a script for
ParaView), `mesh.vtu` (undeformed mesh with named sets) and `frames/` (a .vtu file per part and
instant). The index is updated after every instant, so that an interrupted export is readable.
"""

import logging
from collections.abc import Callable, Iterable, Mapping
from importlib.resources import files
from pathlib import Path
from pprint import pformat
from typing import Any

import meshio
import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bladewhirl.files import claim, owned, replacing, write_atomically
from bladewhirl.meshes.plane import directions
from bladewhirl.postprocess.fields.kinematics import (
    IntArray,
    contact_forces,
    frame_records,
    history,
    sampling_hint,
)
from bladewhirl.postprocess.fields.rigid_wall import with_wall
from bladewhirl.postprocess.paraview.parts import StageParts
from bladewhirl.postprocess.pictures.bodies import TOWARDS
from bladewhirl.postprocess.pictures.colouring import is_normalised

logger = logging.getLogger(__name__)

#: line of view.py that is replaced by the description of the series
FILL = "SERIES: dict[str, Any] = {}"
INDEX = "series.pvd"  #: name of the index of a series

Progress = Callable[[int, int], None]


def export_vtk(
    dataset: xr.Dataset,
    directory: str | Path,
    *,
    frames: int = 300,
    start: float | None = None,
    end: float | None = None,
    records: IntArray | None = None,
    rotating: bool = False,
    surface: bool = False,
    exaggeration: float | None = None,
    overwrite: bool = False,
    progress: Progress | None = None,
) -> Path:
    """Write a time series of the run between `start` and `end` [s]; return the path of series.pvd.

    If the numbers of the `records` are given, `frames`, `start` and `end` are not used.

    Parts are `rotor`, the bladed disk: lines, with `surface` boxes of the true thickness and width
    of beams, or the points and triangles of a superelement; `casing`, the wall without its coating
    as a solid ring; `contact`, the contact nodes; `coating`, in strips, one for each axial track;
    and `supports`: springs, dampers, struts and links as lines. Points are at their undeformed
    positions; the points of the rotor are turned by Omega t. All fields have their true size:

    * `displacement` [m], `velocity` [m/s]: vectors in static axes. The velocity is the rate of the
      displacement vector, without the velocity due to the rotation of the undeformed disk; that of
      contact nodes is without the part of their own flexibility.
    * `radial_displacement` [m]: displacement along the outward radius; zero at the centre.
    * of beams and of the wall `axial_strain`, `bending_strain` [1], `axial_stress`,
      `bending_stress` [Pa] (`strains`), and `surface_stress` [Pa], the sum of axial and bending
      stress at the surface; for lines, at the side with the larger sum. Of a superelement whose
      file gives the recovery of stress, `von_mises_stress` [Pa].
    * `gap` [m]: at contact nodes, the smallest gap since the previous record; on beams of a blade
      that of its tip, on other beams the clearance, so that a threshold filter selects the blades
      in contact.
    * `contact_force` [N], only on `contact`: the impulse since the previous record divided by the
      time between the records, as a vector (normal inward, positive friction towards -theta).
    * on `coating`: `wear`, the removed depth, and `remaining_thickness` [m], and the number
      `track`, -1 beside the tracks.
    * on cells: the numbers `part` and `blade` (-1 for no blade), and `thickness` [m].

    `warp` [m] is the vector from each point to its position in `bladewhirl render`. The filter Warp
    By Vector with `warp` and factor 1 shows displacement and clearance multiplied by `exaggeration`
    (chosen when None); in this view bodies touch exactly when they touch in the run. With
    `contact.foreshortening` blades are drawn back in `warp`, and not in `displacement`.

    With `rotating`, the points of the rotor are fixed, the points of the casing turn backward, and
    all vectors are in rotating axes. Frames of an earlier export are removed; files that are not
    listed in the manifest of the folder are replaced only with `overwrite`. `progress` is called
    with the number of finished frames and the number of frames.

    Raises:
        ViewError: no record lies in the time window, or the number of frames or the exaggeration is
            not positive.
        ResultError: the result is of an old format without cross-sections.
        FileExistsError: a file exists that the manifest does not list.
    """
    dataset = with_wall(dataset)
    if records is None:
        records = frame_records(dataset, frames, start, end)
        if hint := sampling_hint(dataset, records):
            logger.info(hint)
    look: dict[str, Any] = {"surface": surface, "rotating": rotating, "exaggeration": exaggeration}
    parts = StageParts(dataset, records, **look)
    others: dict[str, meshio.Mesh | str] = {"view.py": view_script(_about(dataset, records, parts))}
    if parts.body.flat:
        others["mesh.vtu"] = undeformed_mesh(dataset)
    return write_series(
        Path(directory),
        parts.grid_names,
        dataset["time"].values[records],
        parts.grids(),
        others,
        overwrite=overwrite,
        progress=progress,
    )


def view_script(about: Mapping[str, Any]) -> str:
    """Return the text of view.py for the description of a series."""
    script = files("bladewhirl.postprocess.paraview").joinpath("view.py").read_text("utf-8")
    return script.replace(FILL, f"SERIES: dict[str, Any] = {pformat(about)}")


def write_vtu(path: Path, mesh: meshio.Mesh) -> None:
    """Write a mesh as a binary .vtu file in single precision; all cells have the same type."""
    ((kind, cells),) = ((block.type, block.data) for block in mesh.cells)
    single = meshio.Mesh(
        _single(mesh.points),
        [(kind, _single(cells))],
        {name: _single(values) for name, values in mesh.point_data.items()},
        {name: [_single(values)] for name, (values,) in mesh.cell_data.items()},
    )
    meshio.write(path, single, "vtu", binary=True, compression=None)


def _single(values: NDArray[Any]) -> NDArray[Any]:
    return values.astype(np.float32 if values.dtype.kind == "f" else np.int32)


def write_series(
    folder: Path,
    parts: Iterable[str],
    times: NDArray[np.float64],
    instants: Iterable[Mapping[str, meshio.Mesh]],
    others: Mapping[str, meshio.Mesh | str],
    *,
    overwrite: bool,
    progress: Progress | None,
) -> Path:
    """Write a series: first the files `others`, then the grids of the parts at each of the `times`
    [s]; return the path of the index. `others` maps names of files, `instants` names of parts to
    contents.

    See `export_vtk` for `overwrite`, `progress` and the frames of an earlier series.
    """
    name_of = "frames/{}_{:05d}.vtu".format
    claimed = {name_of(part, number) for part in parts for number in range(len(times))}
    earlier = [*owned(folder)]
    claim(folder, {INDEX, *others, *claimed}, overwrite=overwrite)
    (folder / "frames").mkdir(exist_ok=True)
    entries: list[str] = []
    _write_index(folder / INDEX, entries)  # first: it must not name removed frames
    for path in earlier:
        if path.parent == folder / "frames":
            path.unlink()
    for name, other in others.items():
        with replacing(folder / name) as draft:
            if isinstance(other, str):
                draft.write_text(other, encoding="utf-8")
            else:
                write_vtu(draft, other)
    for frame, (time, grids) in enumerate(zip(times.tolist(), instants, strict=True)):
        for number, (name, grid) in enumerate(grids.items()):
            file = name_of(name, frame)
            write_vtu(folder / file, grid)
            entries.append(
                f'    <DataSet timestep="{time!r}" part="{number}" name="{name}" file="{file}"/>\n'
            )
        _write_index(folder / INDEX, entries)
        if progress is not None:
            progress(frame + 1, len(times))
    return folder / INDEX


def _write_index(path: Path, entries: list[str]) -> None:
    write_atomically(
        path,
        '<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1" '
        f'byte_order="LittleEndian">\n  <Collection>\n{"".join(entries)}'
        "  </Collection>\n</VTKFile>\n",
    )


def _about(dataset: xr.Dataset, records: IntArray, parts: StageParts) -> dict[str, Any]:
    """Return the description of the series for view.py: title, first instant to show, sizes, names
    of the parts."""
    force = np.linalg.norm(contact_forces(dataset, records), axis=-1).max(axis=1)
    moved = np.linalg.norm(history(dataset, "rotor_displacement", records), axis=1)
    shown = int(np.argmax(force if force.any() else moved))
    return {
        "title": str(dataset.attrs["title"]),
        "time": float(dataset["time"].values[records[shown]]),
        "exaggeration": parts.exaggeration,
        "largest_displacement": parts.largest_displacement,
        "largest_force": float(force.max()),
        "size": parts.size,
        "towards": TOWARDS["axial" if parts.body.flat else "oblique"],
        "parts": parts.names,
        "scale": "displacement [m]" + ", arbitrary" * is_normalised(dataset),
    }


def undeformed_mesh(dataset: xr.Dataset) -> meshio.Mesh:
    """Return bladed disk and casing as one mesh of lines at t = 0, with named sets as arrays of 0
    and 1 on cells and points.

    Arrays on cells are `rotor`, `casing`, each part of the rotor (`blades`, `spokes`, ...) and
    `thickness` [m]. Arrays on points are `rotor`, `casing`, `tips`, `centre` and `blade`: the
    number of the blade on the node at its tip, -1 on all other nodes. The nodes of the casing are
    joined by straight lines.
    """
    dataset = with_wall(dataset)
    rotor = dataset["rotor_point"].values
    angle, radius = dataset["casing_angle"].values, dataset.attrs["casing_radius"]
    ring = radius * directions(angle)
    rotor_lines = dataset["rotor_line"].values
    number = len(rotor) + np.arange(len(ring))
    ring_lines = np.column_stack([number, np.roll(number, -1)])
    is_rotor = _members(len(rotor) + len(ring), np.arange(len(rotor)))
    tips = dataset["tip_node"].values
    blade = np.full(len(is_rotor), -1)
    blade[tips] = np.arange(len(tips))
    cells = len(rotor_lines) + len(ring_lines)
    cell_data = {
        "rotor": _members(cells, np.arange(len(rotor_lines))),
        "casing": _members(cells, np.arange(len(rotor_lines), cells)),
        "thickness": np.concatenate(
            [dataset["rotor_thickness"].values, dataset["casing_thickness"].values]
        ),
    }
    part = dataset["rotor_part"].values.astype(str)
    for name in np.unique(part):
        cell_data[name] = _members(cells, np.flatnonzero(part == name))
    return meshio.Mesh(
        points=np.pad(np.vstack([rotor, ring]), ((0, 0), (0, 1))),
        cells=[("line", np.vstack([rotor_lines, ring_lines]))],
        point_data={
            "rotor": is_rotor,
            "casing": 1 - is_rotor,
            "tips": _members(len(is_rotor), tips),
            "centre": _members(len(is_rotor), dataset["centre_node"].values.reshape(1)),
            "blade": blade,
        },
        cell_data={name: [values] for name, values in cell_data.items()},
    )


def _members(size: int, chosen: IntArray) -> IntArray:
    """Return an array (size,) that is 1 at the chosen positions and 0 elsewhere."""
    return np.isin(np.arange(size), chosen).astype(np.int64)
