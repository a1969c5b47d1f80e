"""A run as a ParaView time series: line meshes written through meshio, and their index.

The folder holds `series.pvd` (open this), `mesh.vtu` (the undeformed mesh with its named sets)
and `frames/` (one .vtu per body and instant). meshio has no .pvd, so the index is written here;
it is replaced atomically after every frame, so that a killed export leaves a readable series.
"""

import logging
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from xml.sax.saxutils import quoteattr

import meshio
import numpy as np
import xarray as xr

from bladewhirl.meshes.files.drafts import replacing, write_whole
from bladewhirl.meshes.files.manifest import claim, owned
from bladewhirl.postprocess.fields.kinematics import (
    Array,
    IntArray,
    casing_field,
    casing_points,
    casing_polar_field,
    contact_forces,
    frame_records,
    history,
    radial_part,
    ring_angles,
    rotor_field,
    rotor_points,
    sampling_hint,
)
from bladewhirl.postprocess.fields.sections import rotor_sections
from bladewhirl.postprocess.fields.strains import Strains, casing_strain_rows, rotor_strain_rows
from bladewhirl.postprocess.paraview.surfaces import SurfaceSeries, casing_boxes, rotor_boxes

logger = logging.getLogger(__name__)

ARC_POINTS = 360  #: the casing is cut into at least this many chords, so that it looks round
PORTION = 300  #: records whose fields are computed together, at most
PORTION_POINTS = 1_000_000  #: and points at all of them together, of large stages

Progress = Callable[[int, int], None]


def export_vtk(
    dataset: xr.Dataset,
    directory: str | Path,
    *,
    frames: int = 300,
    start: float | None = None,
    end: float | None = None,
    rotating: bool = False,
    surface: bool = False,
    overwrite: bool = False,
    progress: Progress | None = None,
) -> Path:
    """Write a time series of the run between `start` and `end` [s]; returns series.pvd's path.

    Two parts, `rotor` and `casing`, as line cells. Points are undeformed, the rotor's turned by
    Omega t; fields are true in size, so Warp By Vector with factor 1 gives the deformed stage:

    * `displacement` [m], `velocity` [m/s]: vectors in static axes. The velocity is the rate of
      displacement, without the transport velocity of the turning disk.
    * `radial_displacement` [m]: along the outward radius; zero at the centre.
    * `gap` [m], rotor only: at a tip the smallest gap since the record before; elsewhere the
      undeformed clearance (its mean), so that no value is missing and a threshold on small gaps
      ("All Scalars" off) selects the ends of the blades that touch.
    * `contact_force` [N], rotor only: at a tip the impulse since the record before divided by
      `record_step`, as a vector (normal inward, positive friction towards -theta); zero elsewhere.
    * on cells `axial_strain`, `bending_strain` [1], `axial_stress`, `bending_stress` [Pa]: of a
      cell's two ends the one larger in magnitude, bending at the right or inner surface
      (`strains`).

    With `surface`, beams and wall are boxes of their true thickness and width, made of quads,
    strains and stresses are on points, with `surface_stress` [Pa] the sum of axial and bending
    at each corner, and a third part, `contact`, holds the tips with `gap` and `contact_force`.
    With `rotating`, everything is seen from the rotor: its points stay, the casing's turn back,
    and all vectors are in rotating axes. Frames that the manifest of the folder lists go first;
    other files are replaced with `overwrite` only.
    `progress` is told frames done and frames in all.

    Raises:
        ViewError: an empty window or number of frames.
        ResultError: an old result that knows no sections.
        FileExistsError: a file that the manifest does not list is in the way.
    """
    records = frame_records(dataset, frames, start, end)
    hint = sampling_hint(dataset, records)
    if hint:
        logger.info(hint)
    return write_series(
        dataset,
        directory,
        records,
        rotating=rotating,
        surface=surface,
        overwrite=overwrite,
        progress=progress,
    )


def write_series(
    dataset: xr.Dataset,
    directory: str | Path,
    records: IntArray,
    *,
    rotating: bool = False,
    surface: bool = False,
    overwrite: bool = False,
    progress: Progress | None = None,
) -> Path:
    """Write the series of chosen records, see `export_vtk`; returns series.pvd's path."""
    parts, points = (surface_parts if surface else line_parts)(dataset, rotating)
    folder = Path(directory)
    frames = {frame_name(part, number) for part in parts for number in range(len(records))}
    earlier = [*owned(folder)]
    claim(folder, {"series.pvd", "mesh.vtu", *frames}, overwrite=overwrite)
    # The index is emptied first: it must never name a frame that is gone.
    series = SeriesWriter(folder=folder)
    for path in earlier:
        if path.parent == folder / "frames":
            path.unlink()
    with replacing(folder / "mesh.vtu") as draft:
        meshio.write(draft, undeformed_mesh(dataset))
    # In portions, so that memory does not grow with the number of frames.
    together = max(1, min(PORTION, PORTION_POINTS // points))
    for portion in np.array_split(records, -(-len(records) // together)):
        time = dataset["time"].values[portion]
        meshes = [meshes_of(portion) for meshes_of in parts.values()]
        for instant, *at_instant in zip(time, *meshes, strict=True):
            series.add(float(instant), dict(zip(parts, at_instant, strict=True)))
            if progress is not None:
                progress(series.frames, len(records))
    return series.index


def frame_name(part: str, number: int) -> str:
    """File of a part at an instant, seen from the folder of the series."""
    return f"frames/{part}_{number:05d}.vtu"


Parts = Mapping[str, Callable[[IntArray], list[meshio.Mesh]]]
"""Functions that make the meshes of each part at some records."""


def line_parts(dataset: xr.Dataset, rotating: bool) -> tuple[Parts, int]:
    """Parts as line cells, and their number of points; ResultError for an old result."""
    parts: Parts = {
        "rotor": lambda records: _rotor_meshes(dataset, records, rotating),
        "casing": lambda records: _casing_meshes(dataset, records, rotating),
    }
    return parts, dataset.sizes["rotor_node"] + ARC_POINTS


def surface_parts(dataset: xr.Dataset, rotating: bool) -> tuple[Parts, int]:
    """Parts as boxes, and their number of points; ResultError for an old result."""
    rotor = SurfaceSeries(dataset, rotor_boxes(dataset), rotating=rotating)
    casing = SurfaceSeries(dataset, casing_boxes(dataset), rotating=rotating)
    parts: Parts = {
        "rotor": rotor.meshes,
        "casing": casing.meshes,
        "contact": lambda records: _contact_meshes(dataset, records, rotating),
    }
    return parts, rotor.points + casing.points


@dataclass(kw_only=True)
class SeriesWriter:
    """Writes one .vtu per part and instant, and keeps `series.pvd` true to what is on disk."""

    folder: Path
    _entries: list[str] = field(default_factory=list, init=False)
    _frames: int = field(default=0, init=False)

    def __post_init__(self) -> None:
        (self.folder / "frames").mkdir(parents=True, exist_ok=True)
        self._write_index()

    @property
    def frames(self) -> int:
        """Number of instants written."""
        return self._frames

    @property
    def index(self) -> Path:
        """Path of the .pvd file."""
        return self.folder / "series.pvd"

    def add(self, time: float, parts: dict[str, meshio.Mesh]) -> None:
        """Write the parts at an instant [s] and enter them in the index under their names."""
        for number, (name, mesh) in enumerate(parts.items()):
            file = frame_name(name, self._frames)
            meshio.write(self.folder / file, mesh)
            self._entries.append(
                f'    <DataSet timestep="{time!r}" part="{number}" name={quoteattr(name)} '
                f"file={quoteattr(file)}/>"
            )
        self._frames += 1
        self._write_index()

    def _write_index(self) -> None:
        lines = [
            '<?xml version="1.0"?>',
            '<VTKFile type="Collection" version="0.1" byte_order="LittleEndian">',
            "  <Collection>",
            *self._entries,
            "  </Collection>",
            "</VTKFile>",
            "",
        ]
        write_whole(self.index, "\n".join(lines))


def undeformed_mesh(dataset: xr.Dataset) -> meshio.Mesh:
    """Both bodies as one line mesh at t = 0; named sets are 0/1 arrays on cells and points.

    Cells carry `rotor`, `casing`, each part of the rotor (`blades`, `spokes`, ...) and
    `thickness` [m] in the plane; points carry `rotor`, `casing`, `tips`, `centre` and `blade`,
    the number of a tip's blade (-1 elsewhere). The casing's nodes are joined by chords.
    """
    rotor = dataset["rotor_point"].values
    ring = casing_points(dataset, np.zeros(1, dtype=np.int64), dataset["casing_angle"].values)[0]
    rotor_lines = dataset["rotor_line"].values
    ring_lines = len(rotor) + _closed_lines(len(ring))
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
        _in_space(np.vstack([rotor, ring])),
        [("line", np.vstack([rotor_lines, ring_lines]))],
        point_data={
            "rotor": is_rotor,
            "casing": 1 - is_rotor,
            "tips": _members(len(is_rotor), tips),
            "centre": _members(len(is_rotor), dataset["centre_node"].values.reshape(1)),
            "blade": blade,
        },
        cell_data={name: [values] for name, values in cell_data.items()},
    )


def _rotor_meshes(dataset: xr.Dataset, records: IntArray, rotating: bool) -> list[meshio.Mesh]:
    points = rotor_points(dataset, records, rotating=rotating)
    displacement = rotor_field(dataset, "displacement", records, rotating=rotating)
    tips = dataset["tip_node"].values
    gap = np.full(
        points.shape[:2], float(dataset["clearance"].mean() + dataset["tip_recess"].mean())
    )
    gap[:, tips] = history(dataset, "gap", records)
    force = np.zeros_like(points)
    force[:, tips] = contact_forces(dataset, records, rotating=rotating)
    strains = Strains.of(
        history(dataset, "rotor_displacement", records), rotor_strain_rows(dataset)
    )
    return _meshes(
        points,
        ("line", dataset["rotor_line"].values),
        _cell_strains(strains, rotor_sections(dataset, "young_modulus", 1)),
        displacement=_in_space(displacement),
        velocity=_in_space(rotor_field(dataset, "velocity", records, rotating=rotating)),
        radial_displacement=radial_part(displacement, points),
        gap=gap,
        contact_force=_in_space(force),
    )


def _casing_meshes(dataset: xr.Dataset, records: IntArray, rotating: bool) -> list[meshio.Mesh]:
    per_element = -(-ARC_POINTS // dataset.sizes["casing_node"])
    angle = ring_angles(dataset, per_element)
    displacement = casing_field(dataset, "displacement", records, angle, rotating=rotating)
    velocity = casing_field(dataset, "velocity", records, angle, rotating=rotating)
    rows = casing_strain_rows(dataset, per_element)
    strains = Strains.of(history(dataset, "casing_displacement", records), rows)
    return _meshes(
        casing_points(dataset, records, angle, rotating=rotating),
        ("line", _closed_lines(len(angle))),
        _cell_strains(strains, dataset["casing_young_modulus"].values[:, None]),
        displacement=_in_space(displacement),
        velocity=_in_space(velocity),
        radial_displacement=casing_polar_field(dataset, "displacement", records, angle)[..., 0],
    )


def _contact_meshes(dataset: xr.Dataset, records: IntArray, rotating: bool) -> list[meshio.Mesh]:
    """The tips, with what the casing does to them, at the front of the blades: arrows that start
    inside a blade would not be seen.
    """
    tips = dataset["tip_node"].values
    front = float(dataset["rotor_width"].max()) / 2
    displacement = rotor_field(dataset, "displacement", records, rotating=rotating)[:, tips]
    force = contact_forces(dataset, records, rotating=rotating)
    meshes = _meshes(
        rotor_points(dataset, records, rotating=rotating)[:, tips],
        ("vertex", np.arange(len(tips))[:, None]),
        {},
        displacement=_in_space(displacement),
        gap=history(dataset, "gap", records),
        contact_force=_in_space(force),
    )
    for mesh in meshes:
        mesh.points[:, 2] = front
    return meshes


def _cell_strains(strains: Strains, modulus: Array) -> dict[str, Array]:
    """Strains and stresses of the pieces of every element (record, cell): the larger end's.

    The modulus is (element, station), or (element, 1) where it is the same along each.
    """
    fields = {}
    for name, values in (("axial", strains.axial), ("bending", strains.bending)):
        for kind, own in (("strain", values), ("stress", modulus * values)):
            begin, end = own[..., :-1], own[..., 1:]
            larger = np.where(np.abs(begin) >= np.abs(end), begin, end)
            fields[f"{name}_{kind}"] = larger.reshape(len(larger), -1)
    return fields


def _meshes(
    points: Array, cells: tuple[str, IntArray], on_cells: Mapping[str, Array], **fields: Array
) -> list[meshio.Mesh]:
    """One mesh per record from points (record, point, 2) and fields (record, point, ...)."""
    return [
        meshio.Mesh(
            space,
            [cells],
            point_data={name: values[i] for name, values in fields.items()},
            cell_data={name: [values[i]] for name, values in on_cells.items()},
        )
        for i, space in enumerate(_in_space(points))
    ]


def _in_space(vectors: Array) -> Array:
    """Plane vectors (..., 2) with a zero third component, as VTK wants them."""
    return np.concatenate([vectors, np.zeros_like(vectors[..., :1])], axis=-1)


def _closed_lines(points: int) -> IntArray:
    number = np.arange(points)
    return np.column_stack([number, np.roll(number, -1)])


def _members(size: int, chosen: IntArray) -> IntArray:
    """0/1 array (size,) of a named set."""
    return np.isin(np.arange(size), chosen).astype(np.int64)
