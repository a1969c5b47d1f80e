"""The stage in a pyvista plotter: actors that are made once and moved from record to record."""

import textwrap
from pathlib import Path

import matplotlib
import numpy as np
import pyvista
import xarray as xr

from bladewhirl.postprocess.drawing import Drawing, Picture, arrows, widened
from bladewhirl.postprocess.fields import Array, IntArray
from bladewhirl.postprocess.style import SEQUENTIAL

INK = "#20262e"
FAINT = "#5f6872"
BACKGROUND = "white"
FORCE_COLOUR = "#d55e00"  #: vermilion, apart from the whole map in every kind of colour vision

# Sizes of drawn things, as shares of the picture's radius.
OUTLINE = 0.0035
HUB = 0.022
MARK = 0.014
CONTACT_DISC = 0.014
ARROW_WIDTH = 0.011
LONGEST_ARROW = 0.17
MARGIN = 1.04

DISC_CORNERS = 32
SQUARE = 0.75  #: share of the window's width that the stage takes; the panel has the rest


class StageScene:
    """A drawing of the stage in a plotter, moved in place by `show`.

    Works in any `pyvista.Plotter`, on a screen or off it. Colours are true displacements, in the
    unit `unit`. Layers are a hair apart in z, so look along z, as `look` does.
    """

    def __init__(self, plotter: pyvista.Plotter, drawing: Drawing) -> None:
        self.plotter = plotter
        self.drawing = drawing
        self.unit, self._per_metre = length_unit(drawing.largest_displacement)
        stage, contact = drawing.reach()
        self._size = max(stage, contact / (1 - LONGEST_ARROW))  # arrows end on the tips
        force = drawing.largest_force
        self._metres_per_newton = LONGEST_ARROW * self._size / force if force else 0.0
        first = drawing.picture(0)
        self._outlines, self._ribbons = [], []
        for ribbon in (first.casing, first.rotor):
            quads = _strip_quads(*ribbon.displacement.shape)
            corners = 2 * ribbon.displacement.size
            self._outlines.append(self._add(corners, quads, layer=0, color=INK))
            self._ribbons.append(self._add(corners, quads, layer=1))
        blades: IntArray = np.arange(len(first.tips))[:, None]
        disc = _disc_triangles(1)
        self._hub = self._add(DISC_CORNERS, disc, layer=2, color=INK)
        self._mark = self._add(DISC_CORNERS, disc, layer=2, color=INK)
        self._discs = self._add(
            blades.size * DISC_CORNERS, _disc_triangles(blades.size), layer=3, color=FORCE_COLOUR
        )
        self._arrows = self._add(
            7 * blades.size,
            7 * blades + np.array([0, 1, 5, 6]),
            7 * blades + np.array([2, 3, 4]),
            layer=4,
            color=FORCE_COLOUR,
        )
        self.show(first)

    def show(self, picture: Picture) -> None:
        """Move everything to where it is in the picture; points and colours change in place."""
        for outline, mesh, ribbon in zip(
            self._outlines, self._ribbons, (picture.casing, picture.rotor), strict=True
        ):
            _move(outline, widened(ribbon.sides, OUTLINE * self._size))
            _move(mesh, ribbon.sides)
            colour = self._per_metre * ribbon.displacement.ravel()
            mesh.point_data["displacement"][:] = np.repeat(colour, 2)
        angle = 2 * np.pi * np.arange(DISC_CORNERS) / DISC_CORNERS
        circle = self._size * np.column_stack([np.cos(angle), np.sin(angle)])
        _move(self._hub, picture.shaft + HUB * circle)
        _move(self._mark, picture.mark + MARK * circle)
        touching = np.any(picture.forces, axis=1)[:, None, None]
        _move(self._discs, picture.tips[:, None] + CONTACT_DISC * touching * circle)
        width = ARROW_WIDTH * self._size
        _move(self._arrows, arrows(picture.tips, picture.forces, self._metres_per_newton, width))

    def look(self) -> None:
        """Look along the axis, the stage in the left part of the window, at a fixed scale."""
        width, height = self.plotter.window_size
        half_height = MARGIN * self._size * max(1.0, height / (SQUARE * width))
        aside = (1 - SQUARE) * half_height * width / height
        self.plotter.enable_parallel_projection()
        self.plotter.camera_position = [(aside, 0, 10 * self._size), (aside, 0, 0), (0, 1, 0)]
        self.plotter.camera.parallel_scale = half_height
        self.plotter.reset_camera_clipping_range()

    def _add(
        self, points: int, *faces: IntArray, layer: int, color: str | None = None
    ) -> pyvista.PolyData:
        """An unlit mesh of polygons, coloured by displacement where no colour is given."""
        space = np.zeros((points, 3))
        space[:, 2] = 1e-3 * layer * self._size
        cells = np.concatenate([np.insert(f, 0, f.shape[1], axis=1).ravel() for f in faces])
        mesh = pyvista.PolyData(space, cells)
        if color is None:
            mesh.point_data["displacement"] = np.zeros(points)
        actor = self.plotter.add_mesh(
            mesh,
            color=color,
            scalars=None if color else "displacement",
            cmap=None if color else SEQUENTIAL,
            clim=(0.0, scale_end(self._per_metre * self.drawing.largest_displacement)),
            lighting=False,
            show_scalar_bar=False,
        )
        if color is None:
            self.colours = actor.mapper
        return mesh


class Panel:
    """What the picture shows, in words, and the colour scale, right of the stage."""

    def __init__(self, scene: StageScene, dataset: xr.Dataset, *, note: str = "") -> None:
        self._scene = scene
        plotter, drawing = scene.plotter, scene.drawing
        speed = float(dataset.attrs["speed"])
        title = textwrap.fill(str(dataset.attrs["title"]), 24, max_lines=2)
        relative = speed / float(dataset.attrs["reference_frequency"])
        shown = [
            f"{drawing.frame} frame",
            "true size"
            if drawing.exaggeration == 1
            else f"displacement and clearance\ndrawn {drawing.exaggeration:g} times as large",
        ]
        self._add(title, 0.97, 16)
        self._time = self._add("", 0.885, 22)
        self._add(
            f"speed\n{speed:.5g} rad/s\n{speed * 30 / np.pi:.5g} rpm\n{relative:.4g} × lowest mode",
            0.82,
            13,
        )
        self._add("\n".join([*shown, note] if note else shown), 0.7, 13, color=FAINT)
        self._contact = self._add("", 0.565, 14, color=FORCE_COLOUR)
        self._add(f"displacement [{scene.unit}]", 0.455, 13)
        bar = plotter.add_scalar_bar(
            title="",
            mapper=scene.colours,
            vertical=True,
            position_x=SQUARE + 0.02,
            position_y=0.05,
            width=0.05,
            height=0.36,
            n_labels=5,
            fmt="%.3g",
            color=INK,
            label_font_size=round(14 * plotter.window_size[1] / 960),
        )
        bar.GetLabelTextProperty().SetFontFamily(4)  # VTK_FONT_FILE
        bar.GetLabelTextProperty().SetFontFile(FONT)

    def show(self, picture: Picture) -> None:
        """Bring time and contacts up to date."""
        self._time.input = f"t = {1e3 * picture.time:.1f} ms"
        forces = np.linalg.norm(picture.forces, axis=1)
        touching = int(np.count_nonzero(forces))
        self._contact.input = (
            f"{touching} of {len(forces)} blades touch\nlargest force {newtons(forces.max())}"
            if touching
            else "no contact"
        )

    def _add(self, text: str, top: float, size: float, color: str = INK) -> pyvista.Text:
        width, height = self._scene.plotter.window_size
        actor: pyvista.Text = self._scene.plotter.add_text(
            text,
            position=(round((SQUARE + 0.02) * width), round(top * height)),
            font_size=round(0.7 * size * height / 960),
            color=color,
            font_file=FONT,
            name=f"panel at {top}",
        )
        actor.prop.SetVerticalJustificationToTop()
        actor.prop.SetLineSpacing(1.25)
        return actor


#: The font of matplotlib's figures, so that pictures and plots look alike; it has every sign used.
FONT = str(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / "DejaVuSans.ttf")


def scene_colours(levels: int) -> Array:
    """The colours (colour, 3) between 0 and 1 that a scene is made of, the map's in steps."""
    own = [pyvista.Color(name).float_rgb for name in (BACKGROUND, INK, FAINT, FORCE_COLOUR)]
    colours: Array = np.vstack(
        [own, matplotlib.colormaps[SEQUENTIAL](np.linspace(0.0, 1.0, levels))[:, :3]]
    )
    return colours


def length_unit(length: float) -> tuple[str, float]:
    """Unit in which a length [m] reads well, and how many of it are a metre."""
    return ("mm", 1e3) if length >= 1e-4 or length == 0 else ("µm", 1e6)


def scale_end(largest: float) -> float:
    """The end of a colour scale from 0 that holds a value and whose quarters are short numbers."""
    if largest == 0:
        return 1.0
    decade = 10.0 ** np.floor(np.log10(largest))
    steps = (1, 1.2, 1.6, 2, 2.4, 3.2, 4, 5, 6, 8, 10)
    # The tolerance keeps a value of 1.2 that rounding made 1.2000000000000002.
    return float(decade * min(step for step in steps if step * decade >= largest * (1 - 1e-9)))


def newtons(force: float) -> str:
    """A force with three figures in N, kN or MN."""
    for unit, size in (("MN", 1e6), ("kN", 1e3)):
        if force >= size:
            return f"{force / size:.3g} {unit}"
    return f"{force:.3g} N"


def _strip_quads(lines: int, stations: int) -> IntArray:
    """Quads (quad, 4) of ribbons whose points are ordered (line, station, side)."""
    start = 2 * (np.arange(lines)[:, None] * stations + np.arange(stations - 1)).reshape(-1, 1)
    quads: IntArray = start + np.array([0, 1, 3, 2])
    return quads


def _disc_triangles(discs: int) -> IntArray:
    """Triangles (triangle, 3) of discs. As one polygon each they would be cut into triangles when
    first shown, which fails for good while a disc has no size.
    """
    corner = np.arange(1, DISC_CORNERS - 1)
    fan = np.column_stack([np.zeros_like(corner), corner, corner + 1])
    triangles: IntArray = (DISC_CORNERS * np.arange(discs)[:, None, None] + fan).reshape(-1, 3)
    return triangles


def _move(mesh: pyvista.PolyData, points: Array) -> None:
    mesh.points[:, :2] = points.reshape(-1, 2)
