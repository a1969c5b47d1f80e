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
from time import monotonic
from typing import Any

import meshio
import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bladewhirl.files import claim, owned, replacing, write_atomically
from bladewhirl.meshes.plane import directions, unit
from bladewhirl.models.inputs.units import handy_unit
from bladewhirl.postprocess.fields.by_blade import blade_count
from bladewhirl.postprocess.fields.joint_nodes import JOINT_FIELDS
from bladewhirl.postprocess.fields.kinematics import (
    IntArray,
    contact_forces,
    frame_records,
    history,
    sampling_hint,
    turn,
)
from bladewhirl.postprocess.fields.rigid_wall import with_wall
from bladewhirl.postprocess.paraview.parts import UP
from bladewhirl.postprocess.paraview.rotor_parts import RotorParts
from bladewhirl.postprocess.paraview.shaft_line import (
    LINE_PARTS,
    LineGrids,
    exaggeration_of,
)
from bladewhirl.postprocess.pictures.bodies import ARC, TOWARDS, axes_of_view, middle_of, opening
from bladewhirl.postprocess.pictures.choices import View
from bladewhirl.postprocess.pictures.colouring import is_normalised, scale_end
from bladewhirl.postprocess.plotting.style import COLOUR_MAPS

logger = logging.getLogger(__name__)

#: line of view.py that is replaced by the description of the series
FILL = "SERIES: dict[str, Any] = {}"
INDEX = "series.pvd"  #: name of the index of a series

METRES = ("displacement", "radial_displacement", "deformation", "warp", "gap", "wear")
UNITS: Mapping[str, str] = {
    **dict.fromkeys((*METRES, "remaining_thickness"), "m"),
    **dict.fromkeys(("axial_strain", "bending_strain"), "1"),
    **dict.fromkeys(("axial_stress", "bending_stress", "surface_stress"), "Pa"),
    "von_mises_stress": "Pa",
    "velocity": "m/s",
    "contact_force": "N",
    **{name.replace("-", "_"): each.unit or "1" for name, each in JOINT_FIELDS.items()},
    **dict.fromkeys(("rotor", "casing", "tips", "centre", "blade"), "1"),
}
"""Units of the arrays on points."""

IN_MEMORY = 2e8  #: largest size of a result that is read at once, and not record by record [bytes]

INDEXED = 1.0  #: time between two writings of the index, which names the frames so far [s]

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
    * `deformation` [m]: the displacement without that of the centre, or without the mean of the
      wall.
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
    * on `contact`, of a run with friction joints, NaN elsewhere: `joint_force`, the normal force
      [N], `joint_slip`, the distance since the start [m], and `joint_state`: 0 open, 1 stuck, 2
      slipping.
    * on `coating`: `wear`, the removed depth, and `remaining_thickness` [m] to the metal, which
      tips touch where the share `limit` is removed, and the number `track`, -1 beside the tracks.
    * on cells: the numbers `part` and `blade` (-1 for no blade), and `thickness` [m].

    `warp` [m] is the vector from each point to its position in `bladewhirl render`. The filter Warp
    By Vector with `warp` and factor 1 shows displacement and clearance multiplied by `exaggeration`
    (chosen when None); in this view bodies touch exactly when they touch in the run. Units and
    the exaggeration are FieldData. With
    `contact.foreshortening` blades are drawn back in `warp`, and not in `displacement`.

    Separate blades, whose file does not contain a disk, have the part `hub`, a ring below them with
    zero `displacement` and `warp`. Of several wheels on a shaft line a part is one grid of those of
    all wheels; further wheels have no stress. A shaft line has the parts `shaft`, its surface, and
    `bearings`, rings that move with the supports, with `displacement` and `warp`; without a wheel
    it has no others.

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
    if records is None:
        records = frame_records(dataset, frames, start, end)
        if hint := sampling_hint(dataset, records):
            logger.info(hint)
    if not dataset.sizes["contact_node"]:
        factor = exaggeration_of(dataset, records, exaggeration)
        line = LineGrids(dataset, rotating=rotating, exaggeration=factor)
        return write_series(
            Path(directory),
            LINE_PARTS,
            dataset["time"].values[records],
            map(line.at, records.tolist()),
            {},
            factor,
            overwrite=overwrite,
            progress=progress,
        )
    if dataset.nbytes <= IN_MEMORY:
        dataset = dataset.load()
    dataset = with_wall(dataset)
    look: dict[str, Any] = {"surface": surface, "rotating": rotating, "exaggeration": exaggeration}
    parts = RotorParts(dataset, records, **look)
    others: dict[str, meshio.Mesh | str] = {
        "view.py": view_script(_about(dataset, records, parts, **look))
    }
    if parts.body.flat:
        others["mesh.vtu"] = undeformed_mesh(dataset)
    return write_series(
        Path(directory),
        parts.grid_names,
        dataset["time"].values[records],
        parts.grids(),
        others,
        parts.exaggeration,
        overwrite=overwrite,
        progress=progress,
    )


def view_script(about: Mapping[str, Any]) -> str:
    """Return the text of view.py for the description of a series."""
    script = files("bladewhirl.postprocess.paraview").joinpath("view.py").read_text("utf-8")
    return script.replace(FILL, f"SERIES: dict[str, Any] = {pformat(about)}")


def write_vtu(path: Path, mesh: meshio.Mesh, exaggeration: float) -> None:
    """Write a mesh as a binary .vtu file in single precision; all cells have the same type. The
    exaggeration is an array of its FieldData, and so is each array on points with its unit, such as
    `gap [m]`, of the value 1."""
    ((kind, cells),) = ((block.type, block.data) for block in mesh.cells)
    single = meshio.Mesh(
        _single(mesh.points),
        [(kind, _single(cells))],
        {name: _single(values) for name, values in mesh.point_data.items()},
        {name: [_single(values)] for name, (values,) in mesh.cell_data.items()},
    )
    meshio.write(path, single, "vtu", binary=True, compression="zlib")
    units = {f"{name} [{UNITS[name]}]": 1.0 for name in mesh.point_data}
    fields = [
        f'<DataArray type="Float64" Name="{name}" NumberOfTuples="1" format="ascii">{value!r}'
        for name, value in {"exaggeration": exaggeration, **units}.items()
    ]
    grid = "<UnstructuredGrid>"
    told = f"{grid}<FieldData>{'</DataArray>'.join([*fields, ''])}</FieldData>"
    text = path.read_bytes().replace(grid.encode(), told.encode(), 1)
    if "warp" in mesh.point_data:  # ParaView's filter chooses it
        text = text.replace(b"<PointData>", b'<PointData Vectors="warp">', 1)
    path.write_bytes(text)


def _single(values: NDArray[Any]) -> NDArray[Any]:
    return values.astype(np.float32 if values.dtype.kind == "f" else np.int32)


def write_series(
    folder: Path,
    parts: Iterable[str],
    times: NDArray[np.float64],
    instants: Iterable[Mapping[str, meshio.Mesh]],
    others: Mapping[str, meshio.Mesh | str],
    exaggeration: float,
    *,
    overwrite: bool,
    progress: Progress | None,
) -> Path:
    """Write a series: first the files `others`, then the grids of the parts at each of the `times`
    [s]; return the path of the index. `others` maps names of files, `instants` names of parts to
    contents; `exaggeration` is for each file.

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
                write_vtu(draft, other, exaggeration)
    indexed, whole = monotonic(), 0
    try:
        for frame, (time, grids) in enumerate(zip(times.tolist(), instants, strict=True)):
            for number, (name, grid) in enumerate(grids.items()):
                file = name_of(name, frame)
                write_vtu(folder / file, grid, exaggeration)
                at = f'timestep="{time!r}" part="{number}" name="{name}"'
                entries.append(f'    <DataSet {at} file="{file}"/>\n')
            whole = len(entries)
            if monotonic() >= indexed + INDEXED:
                _write_index(folder / INDEX, entries)
                indexed = monotonic()
            if progress is not None:
                progress(frame + 1, len(times))
    finally:  # also if it is interrupted
        _write_index(folder / INDEX, entries[:whole])
    return folder / INDEX


def _write_index(path: Path, entries: list[str]) -> None:
    write_atomically(
        path,
        '<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1" '
        f'byte_order="LittleEndian">\n  <Collection>\n{"".join(entries)}'
        "  </Collection>\n</VTKFile>\n",
    )


def _about(
    dataset: xr.Dataset,
    records: IntArray,
    parts: RotorParts,
    *,
    surface: bool,
    rotating: bool,
    **_: Any,
) -> dict[str, Any]:
    """Return the description of the series for view.py: title, first instant to show, colours, view
    of the parts and where the wall is cut open."""
    force = np.linalg.norm(contact_forces(dataset, records), axis=-1).max(axis=1)
    moved = np.linalg.norm(history(dataset, "rotor_displacement", records), axis=1)
    size = force if force.any() else moved
    if blade_count(dataset) == 1 and not rotating:  # not below the part of the wall that is whole
        ahead = opening(unit(np.array(TOWARDS["oblique"])))[1]
        seen = np.cos(dataset["tip_angle"].values.mean() + turn(dataset, records) - ahead)
        size = np.where(size >= 0.5 * size.max(), 2.0 + seen, 0.0)
    shown = int(np.argmax(size))
    solid = surface or not parts.body.flat
    return {
        "title": str(dataset.attrs["title"]),
        "time": float(dataset["time"].values[records[shown]]),
        "exaggeration": parts.exaggeration,
        "largest_force": float(force.max()),
        "colours": _colours(parts, "magnitude" if solid else "line", is_normalised(dataset)),
        "solid": solid,
        "parts": parts.names,
        "grids": list(parts.grid_names),
        **_view(dataset, parts, "oblique" if solid else "axial", int(records[shown]), rotating),
    }


def _colours(parts: RotorParts, of_rotor: str, normalised: bool) -> dict[str, dict[str, Any]]:
    """Return for each part with values: array, factor, label, end of the scale, and its colours as
    shares and RGB values; a mode has an arbitrary amplitude."""
    found = {}
    for part, array, colours in (
        ("rotor", "deformation", of_rotor),
        ("casing", "deformation", "wall"),
        ("coating", "wear", "wall"),
    ):
        if largest := parts.largest[part]:
            unit, factor = handy_unit(largest, "m")
            if normalised:
                unit, factor = "of the largest", 1.0 / largest
            shares = np.linspace(0.0, 1.0, 17)
            shades = np.column_stack([shares, COLOUR_MAPS[colours](shares)[:, :3]])
            found[part] = {
                "array": array,
                "factor": factor,
                "label": f"{array} of the {part} [{unit}]",
                "end": scale_end(factor * largest),
                "shades": shades.round(3).tolist(),
            }
    return found


def _view(
    dataset: xr.Dataset, parts: RotorParts, view: View, record: int, rotating: bool
) -> dict[str, Any]:
    """Return camera and middle, half the height of the picture [m], and origins and normals of
    planes beyond which the wall is cut off: in front of the tips of a single blade at a record, so
    that forces on them are seen."""
    stages, around = parts.drawn, rotating is False or blade_count(dataset) > 1
    axes, focus = axes_of_view(stages[0], view, around=around)
    rests, shaft = parts.rests, parts.shaft
    middles = [float(np.mean(stage.edges)) for stage in stages]
    walls = [
        np.insert(stage.wall_at_rest(), 2, middle - middles[0], axis=1)
        for stage, middle in zip(stages, middles, strict=True)
    ]
    if len(shaft):
        focus = middle_of([*rests, shaft], axes)
    seen = np.vstack([*rests, *walls, shaft] if around else rests) - focus
    gap, ahead = opening(axes[2])
    inner = min(stage.inner_radius.max() for stage in stages)
    middle = inner * np.cos(gap) * directions(ahead)
    planes = [(np.append(middle, 0.0), np.append(directions(ahead), 0.0))] if gap else []
    if not around:  # the wall near the blade
        angle, tips = dataset["tip_angle"].values, parts.tips(record)
        sides = np.stack([angle.max() + ARC + 0.5 * np.pi, angle.min() - ARC - 0.5 * np.pi])
        planes = [(np.zeros(3), end) for end in np.pad(directions(sides), ((0, 0), (0, 1)))]
        chord = tips[np.argmax(tips[:, 2])] - tips[np.argmin(tips[:, 2])]
        front = np.cross(chord if chord.any() else UP, tips.mean(axis=0) * [1.0, 1.0, 0.0])
        front = unit(front if front @ axes[2] > 0.0 else -front)
        planes.append((tips[np.argmin(tips @ front)], front))
    return {
        "towards": axes[2].tolist(),
        "up": axes[1].tolist(),
        "focus": focus.tolist(),
        "size": float((np.abs(seen @ axes[:2].T) * [0.8, 1.0]).max()),
        "cuts": [[each.tolist() for each in plane] for plane in planes],
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
