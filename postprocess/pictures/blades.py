"""Stills and films of a superelement: deformed blades, contact forces, and the wall."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import xarray as xr

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.inputs.units import handy, handy_unit
from bladewhirl.postprocess.fields.enlarged import round_factor
from bladewhirl.postprocess.fields.kinematics import ViewError, frame_records
from bladewhirl.postprocess.fields.nodes import (
    deformed_points,
    frame_meshes,
    is_flexible,
    ring_displacement,
    wall_at,
)
from bladewhirl.postprocess.pictures.films import write_pictures
from bladewhirl.postprocess.pictures.offscreen import Pixels, off_screen_plotter, pixels_of, tiled
from bladewhirl.postprocess.plotting.style import SEQUENTIAL

SIZE = (900, 700)  #: size of a picture [pixels]
LEVELS = 32  #: number of colours of the scale of displacements in a GIF; others are shaded
SHADES = 12  #: number of colours of arrows in a GIF
BAR: dict[str, Any] = {
    "vertical": True,
    "n_labels": 4,
    "color": "black",
    "title_font_size": 30,
    "label_font_size": 26,
    "fmt": "%.3g",
    "position_x": 0.86,
    "position_y": 0.1,
}
"""Appearance of the scale of displacements."""

SUFFIXES = (".png", ".gif", ".mp4")  #: files that can be drawn
FRAMES = 60  #: default number of pictures of a film
TURNS = 0.5  #: default length of a film, in revolutions around the largest force
LARGE = 0.08  #: default of the largest drawn displacement, divided by the size of a blade
REACH = 0.06  #: angle over which the wall is drawn on each side of a blade [rad]
STILL = "#4C78A8"  #: colour of blades that do not move
FORCE = "#CC79A7"  #: colour of forces
ARROW = 0.35  #: length of the arrow of the largest force, divided by the size of a blade


def strongest_force(dataset: xr.Dataset) -> int:
    """Return the record of the largest normal force on a contact node; 0 without contact."""
    return int(dataset["contact_force"].values[:, :, 0].min(axis=1).argmin())


def film_records(
    dataset: xr.Dataset, *, frames: int | None, start: float | None, end: float | None
) -> IntArray:
    """Return the records of a film, by default of half a revolution around the largest force.

    Raises:
        ViewError: the window or the number of frames is invalid.
    """
    if start is None and end is None:
        turn = 2.0 * np.pi / max(abs(float(dataset.attrs["speed"])), 1e-9)
        last = float(dataset["time"][-1])
        length = min(TURNS * turn, last)
        middle = float(dataset["time"][strongest_force(dataset)])
        start = min(max(0.0, middle - 0.5 * length), last - length)
        end = start + length
    return frame_records(dataset, frames or FRAMES, start, end)


def render_blades(
    dataset: xr.Dataset,
    path: str | Path,
    records: IntArray,
    *,
    exaggeration: float | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Path:
    """Draw a superelement in axes that rotate with it; return the path.

    All displacements and the clearance are multiplied by `exaggeration`, so that blade and wall
    touch in the picture when they touch in the run. Colours show the size of the displacement.
    Arrows are the contact forces at the record.

    Args:
        dataset: result of a superelement with points and triangles.
        path: file, .png (a still, or a sheet if there are several records), .gif or .mp4 (films).
        records: records to draw.
        exaggeration: factor on displacements and clearance; automatic if None.
        progress: called with the numbers of finished and of all pictures.

    Raises:
        ViewError: the result has no surface.
        OffScreenError: the system cannot draw without a display.
    """
    target = Path(path)
    if "triangle" not in dataset:
        raise ViewError("expected a superelement whose file has points, recovery and triangles")
    scale = matplotlib.colormaps[SEQUENTIAL](np.linspace(0.0, 1.0, LEVELS))[:, :3]
    shades = np.linspace(0.3, 1.0, SHADES)[:, None] * matplotlib.colors.to_rgb(FORCE)
    colours = np.concatenate([np.ones((1, 3)), scale, shades])
    with blade_view(dataset, records, exaggeration) as picture:
        if target.suffix.lower() != ".png" or len(records) == 1:
            return write_pictures(target, picture, len(records), colours, progress)
        sheet = tiled([picture(index) for index in range(len(records))])
        return write_pictures(target, lambda _: sheet, 1, colours, progress)


@contextmanager
def blade_view(
    dataset: xr.Dataset, records: IntArray, exaggeration: float | None
) -> Iterator[Callable[[int], Pixels]]:
    """Yield a function of an index, which returns the picture of the index-th record."""
    size = float(np.ptp(dataset["point"].values, axis=0).max())
    largest = float(np.linalg.norm(deformed_points(dataset, records), axis=-1).max())
    furthest = largest
    if is_flexible(dataset):
        furthest = max(largest, float(np.abs(ring_displacement(dataset, records)).max()))
    factor = exaggeration or round_factor(size, (LARGE, furthest))
    strongest = float(np.abs(dataset["contact_force"].values[:, :, 0]).max())
    unit, scale = handy_unit(largest, "m")
    words = f", {'displacement and ' if largest > 0.0 else ''}clearance x {factor:g}"
    if strongest > 0.0:
        words += f", force at most {handy(strongest, 'N', 3)}"
    with off_screen_plotter(SIZE) as plotter:
        import pyvista

        first = frame_meshes(dataset, int(records[0]), rotating=True)["blades"]
        blades = pyvista.PolyData.from_regular_faces(first.points.copy(), first.cells[0].data)
        blades["shown"] = np.zeros(len(first.points))
        colours: dict[str, Any] = {"color": STILL}
        if largest > 0.0:
            limits = (0.0, scale * largest)
            colours = {"scalars": "shown", "cmap": SEQUENTIAL, "clim": limits}
            colours["scalar_bar_args"] = BAR | {"title": f"displacement [{unit}]"}
        plotter.add_mesh(blades, smooth_shading=True, ambient=0.25, **colours)
        _aim(plotter, dataset, size)

        def picture(index: int) -> Pixels:
            record = int(records[index])
            meshes = frame_meshes(dataset, record, rotating=True)
            moved = meshes["blades"].point_data["displacement"]
            blades.points = meshes["blades"].points + factor * moved
            blades["shown"] = scale * np.linalg.norm(moved, axis=1)
            _draw_wall(plotter, dataset, record, factor)
            _draw_forces(plotter, meshes["contact"], factor, strongest, ARROW * size)
            time = handy(float(dataset["time"][record]), "s", 4)
            text = f"{dataset.attrs['title']}\nt = {time}{words}"
            plotter.add_text(text, font_size=18, color="black", name="text")
            return pixels_of(plotter)

        yield picture


def _aim(plotter: Any, dataset: xr.Dataset, size: float) -> None:
    """Aim the camera: at the face of a single blade from the side, where bending is visible, and
    slightly from the root; at several blades nearly along the axis."""
    if dataset.sizes["copy"] > 1 or len(np.unique(dataset["blade"].values)) > 1:
        plotter.view_vector((0.4, -0.3, 1.0), viewup=(0.0, 1.0, 0.0))
        plotter.reset_camera()
        return
    points = dataset["point"].values
    middle = points.mean(axis=0)
    face = np.linalg.svd(points - middle, full_matrices=False)[2][2]  # normal to the blade
    out = middle * [1.0, 1.0, 0.0] / np.hypot(*middle[:2])
    face = face if face[2] >= 0.0 else -face
    towards = face - 0.35 * out + 1.1 * np.cross(out, face)
    plotter.camera.focal_point = middle + 0.18 * size * out
    plotter.camera.position = middle + 2.0 * size * towards
    plotter.camera.up = out
    plotter.reset_camera_clipping_range()


def _draw_wall(plotter: Any, dataset: xr.Dataset, record: int, factor: float) -> None:
    """Draw the wall at its clearance at the record: near the contact nodes of each blade or, if the
    casing is flexible, all around."""
    import pyvista

    angle, blade = dataset["tip_angle"].values, dataset["blade"].values
    axial, recess = dataset["axial_position"].values, dataset["tip_recess"].values
    turned = float(dataset.attrs["speed"] * dataset["time"][record])
    wall = wall_at(dataset, record)

    def clearance(at: FloatArray) -> FloatArray:
        return wall(at + turned)

    removable = float(dataset.attrs.get("coating_removable", 0.0))  # gaps are those to the metal
    known = dataset["gap"].values[record] + dataset["contact_displacement"].values[record, :, 0]
    closed = float(np.median(known - removable - recess - clearance(angle)))  # closure by now
    radius = float((dataset["contact_radius"].values + recess).max())
    margin = 0.15 * np.ptp(axial) + 0.01 * radius
    arcs = [
        np.linspace(nodes.min() - REACH, nodes.max() + REACH, 41)
        for nodes in (angle[blade == number] for number in np.unique(blade))
    ]
    if is_flexible(dataset):
        arcs = [np.linspace(0.0, 2.0 * np.pi, 361)]
    grids = []
    for across in arcs:
        along = np.linspace(axial.min() - margin, axial.max() + margin, 2)
        at = radius + factor * (clearance(across) + closed)
        x, z = np.meshgrid(at * np.cos(across), along, indexing="ij")
        y = np.repeat((at * np.sin(across))[:, None], len(along), axis=1)
        grids.append(pyvista.StructuredGrid(x, y, z).extract_surface(algorithm="dataset_surface"))
    plotter.add_mesh(pyvista.merge(grids), color="#BBBBBB", opacity=0.55, name="wall")


def _draw_forces(plotter: Any, mesh: Any, factor: float, strongest: float, length: float) -> None:
    """Draw the contact forces as arrows that end at the contact nodes, and the nodes as points."""
    import pyvista

    nodes = pyvista.PolyData(mesh.points + factor * mesh.point_data["displacement"])
    force = mesh.point_data["contact_force"]
    touching = np.linalg.norm(force, axis=1) > 0.0
    plotter.add_mesh(
        nodes, color="black", point_size=8, render_points_as_spheres=True, name="nodes"
    )
    if not touching.any() or not strongest > 0.0:
        plotter.remove_actor("forces")
        return
    arrows = force[touching] * (length / strongest)
    tails = pyvista.PolyData(nodes.points[touching] - arrows)
    tails["vectors"] = arrows
    glyphs = tails.glyph(orient="vectors", scale="vectors", factor=1.0)
    plotter.add_mesh(glyphs, color=FORCE, name="forces")
