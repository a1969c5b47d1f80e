"""Pictures of mode shapes (the paper's Fig. 6): undeformed and deformed body, and its centre."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.meshes.plane import directions, rotate
from bladewhirl.models.modal.labels import Body
from bladewhirl.postprocess.fields.enlarged import magnify
from bladewhirl.postprocess.fields.kinematics import casing_rows, line_rows, ring_angles, tip_rows
from bladewhirl.postprocess.plotting.legends import complete
from bladewhirl.postprocess.plotting.style import (
    COLOURS,
    FULL_WIDTH,
    SEQUENTIAL,
    new_figure,
    styled,
)

DRAWN = 0.2  #: largest displacement in a picture, divided by the radius
BEAM_PIECES = 4  #: largest number of straight pieces by which the Hermite curve of a beam is drawn
MOST_PIECES = 16_000
"""Largest number of pieces in all beams of the bladed disk; with many beams, each beam has fewer
than `BEAM_PIECES`."""

RING_POINTS = 360  #: least number of drawn points of the casing
COLUMNS = 6  #: largest number of panels side by side
#: number of pictures of a travelling wave over a quarter of its period, including both ends
INSTANTS = 4
PURE = 0.9995
"""If the purity of a mode exceeds this value, only its nodal diameter is printed. The purity is the
share of the kinetic energy of the mode in its nodal diameter."""

MIXED = 0.5  #: a mode with a lower purity is named "mixed k" instead of by its nodal diameter
OUTSIDE = 1.1  #: radius at which crests are marked, relative to the largest drawn radius
#: half the width of a picture divided by the largest distance of a drawn point from its middle
MARGIN = 1.02
CENTRE_RESTS = 1e-6
"""A centre that moves by less than this fraction of the largest displacement of the mode is
regarded as at rest."""


class Outline:
    """Drawn lines of one body, undeformed, and displaced for given modal coordinates.

    As in `enlarged`, the mean displacement of the body is a shift along a straight line, and the
    remaining displacement is drawn along arcs about the shifted centre: bent blades keep their
    length.
    """

    def __init__(self, data: xr.Dataset, body: Body) -> None:
        if body == "bladed-disk":
            pieces = min(BEAM_PIECES, max(1, MOST_PIECES // data.sizes["rotor_line"]))
            stations, rows = line_rows(data, pieces)
            self.rest = stations
            self._rows = rows.reshape(-1, 2, rows.shape[-1])
            self._shift = data["rotor_shape"].values[int(data["centre_node"]), :2]
            self.radius = float(data.attrs["tip_radius"])
        else:
            angle = ring_angles(data, -(-RING_POINTS // data.sizes["casing_node"]))
            angle = np.append(angle, angle[0])
            self.radius = float(data.attrs["casing_radius"])
            self.rest = self.radius * directions(angle)[None]
            self._rows = rotate(casing_rows(data, angle), angle[:, None], axis=1)
            self._shift = self._rows[:-1].mean(axis=0)

    def largest(self, coordinates: FloatArray) -> float:
        """Return the largest displacement of any point for all `coordinates` (..., modes)."""
        return float(np.linalg.norm(self._rows @ np.atleast_2d(coordinates).T, axis=1).max())

    def moved(self, coordinates: FloatArray, factor: float) -> FloatArray:
        """Return the drawn points (lines, stations, 2) [m], with displacements multiplied by
        `factor`."""
        drawn = magnify(
            self.rest.reshape(-1, 2), self._rows @ coordinates, self._shift @ coordinates, factor
        )
        return drawn.reshape(self.rest.shape)

    def size(self, coordinates: FloatArray) -> FloatArray:
        """Return the magnitude of the displacement in the middle of each piece, (lines, stations -
        1)."""
        magnitude = np.linalg.norm(self._rows @ coordinates, axis=-1).reshape(self.rest.shape[:2])
        return np.asarray(0.5 * (magnitude[:, 1:] + magnitude[:, :-1]))

    def centre(self, coordinates: FloatArray, factor: float) -> FloatArray:
        """Return the drawn centre, (2,) [m]."""
        return np.asarray(factor * self._shift @ coordinates)


def draw_shape(
    axes: Axes, outline: Outline, coordinates: FloatArray, motion: FloatArray
) -> LineCollection:
    """Draw a body: undeformed in grey, deformed with the displacement as colour.

    Args:
        axes: the panel.
        outline: lines of the body.
        coordinates: modal coordinates of the drawn instant (modes,).
        motion: modal coordinates of all instants (..., modes), which determine the size of the
            panel and the largest displacement, to which colours and drawn displacements refer.

    Returns:
        the deformed lines, for the colour bar.
    """
    largest = outline.largest(motion)
    factor = DRAWN * outline.radius / largest
    axes.add_collection(LineCollection([*outline.rest], color=COLOURS["rest"], linewidth=0.4))
    points = outline.moved(coordinates, factor)
    pieces = np.stack([points[:, :-1], points[:, 1:]], axis=-2)
    lines = LineCollection(
        [*pieces.reshape(-1, 2, 2)], cmap=SEQUENTIAL, norm=Normalize(0.0, 1.0), linewidth=0.8
    )
    lines.set_array((outline.size(coordinates) / largest).ravel())
    axes.add_collection(lines)
    axes.plot(
        0.0, 0.0, "x", color=COLOURS["total"], markersize=2.5, zorder=4, label="centre at rest"
    )
    centre = outline.centre(coordinates, factor)
    axes.plot(*centre, "o", color=COLOURS["k = 1"], markersize=3.6, label="centre displaced")
    drawn = [outline.moved(instant, factor) for instant in np.atleast_2d(motion)]
    reach = MARGIN * max(outline.radius, np.linalg.norm(drawn, axis=-1).max())
    axes.set(aspect="equal", xlim=(-reach, reach), ylim=(-reach, reach))
    axes.set_axis_off()
    return lines


@styled
def plot_mode_shapes(data: xr.Dataset, body: Body) -> Figure:
    """Draw the mode shapes of a body from `motion.shapes_dataset` side by side (the paper's Fig.
    6).

    A cross marks the centre at rest, a dot the displaced centre; the centre of the casing moves by
    the mean displacement of the casing. The text below each shape gives the frequency, the
    displacement of the centre in percent of the largest displacement of the mode, the purity and,
    for whirling modes, the directions of travel in the rotating and in the static frame.
    """
    prefix = "rotor" if body == "bladed-disk" else "casing"
    modes = data.sizes[f"{prefix}_mode"]
    rows = -(-modes // COLUMNS)
    columns = -(-modes // rows)
    figure = new_figure(
        width=FULL_WIDTH, height=0.022 + rows * (0.85 * FULL_WIDTH / columns + 0.022)
    )
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    outline = Outline(data, body)
    for mode, axes in enumerate(panels):
        if mode >= modes:
            axes.set_axis_off()
            continue
        coordinates = np.eye(modes)[mode]
        lines = draw_shape(axes, outline, coordinates, coordinates)
        mode_data = data.isel({f"{prefix}_mode": mode})
        share = float(
            np.linalg.norm(outline.centre(coordinates, 1.0)) / outline.largest(coordinates)
        )
        moves = f"centre {100 * share:.1f} %" if share > CENTRE_RESTS else "centre at rest"
        purity = float(mode_data[f"{prefix}_purity"])
        k = int(mode_data[f"{prefix}_nodal_diameter"])
        axes.set_title(mode_title(str(mode_data[f"{prefix}_family"].values), k, purity))
        words = [*_frequency(data, float(mode_data[f"{prefix}_frequency"])).split(" = "), moves]
        if purity < PURE:
            words.append(f"k = {k}: {100 * purity:.0f} %" if k >= 0 else "no nodal diameter")
        if f"{prefix}_direction" in data:
            words.append(str(mode_data["rotor_direction"].values))
            words.append(f"static: {mode_data['rotor_direction_static'].values}")
        below = {"transform": axes.transAxes, "ha": "center", "va": "top"}
        axes.text(0.5, -0.02, "\n".join(words), **below)
    figure.colorbar(
        lines,
        ax=[*panels],
        location="right",
        label="displacement / largest one [–]",
        shrink=0.8,
        aspect=20,
        ticks=[0.0, 0.5, 1.0],
    )
    names = {"bladed-disk": "the bladed disk, rotating frame", "casing": "the casing"}
    note = "Exaggerated. Centre: % of the largest displacement. k: % of the kinetic energy."
    complete(figure, data, f"Modes of {names[body]}; {_sense(data)}", note)
    return figure


@styled
def plot_travelling_wave(data: xr.Dataset, body: Body) -> Figure:
    """Draw a travelling wave from `motion.mode_motion` at `INSTANTS` instants of a quarter of its
    period, with its crests."""
    prefix = "rotor" if body == "bladed-disk" else "casing"
    coordinates = data[f"{prefix}_displacement"].values
    figure = new_figure(width=FULL_WIDTH, height=0.062)
    panels = figure.subplots(1, INSTANTS)
    outline = Outline(data, body)
    k = int(data[f"{prefix}_nodal_diameter"].values[0])
    crests = "tips furthest ahead, ↺" if body == "bladed-disk" else "wall furthest out"
    for number, axes in enumerate(panels):
        record = len(coordinates) * number // (4 * (INSTANTS - 1))
        lines = draw_shape(axes, outline, coordinates[record], coordinates)
        _mark_crests(axes, _crest(data, prefix, coordinates[record], k), k, f"crest: {crests}")
        degrees = 90 * number // (INSTANTS - 1)
        axes.set_title("start" if not number else f"{degrees}° of its period")
    figure.colorbar(
        lines, ax=[*panels], label="displacement / largest [–]", shrink=0.8, ticks=[0, 1]
    )
    frame = "rotating frame" if body == "bladed-disk" else "static frame"
    hertz = _frequency(data, float(data[f"{prefix}_frequency"].values[0]))
    name = str(data.attrs["title"])
    complete(figure, data, f"{name[:1].upper()}{name[1:]}, {hertz}, {frame}; {_sense(data)}")
    return figure


def _sense(data: xr.Dataset) -> str:
    return f"rotation is {data.attrs['rotation']}"


def _mark_crests(axes: Axes, angle: float, k: int, label: str) -> None:
    """Mark the k crests of a wave outside the structure; only the first marker is filled."""
    radius = axes.get_xlim()[1]
    for number in range(k):
        turned = angle + 2.0 * np.pi * number / k
        place = radius * directions(turned)
        face = "none" if number else COLOURS["contact"]
        axes.plot(*place, "D", ms=4.0, color=COLOURS["contact"], mfc=face, label=label)
    reach = OUTSIDE * radius
    axes.set(xlim=(-reach, reach), ylim=(-reach, reach))


def _crest(data: xr.Dataset, prefix: str, coordinates: FloatArray, k: int) -> float:
    """Return the angle of a crest of the wave along the tips or the wall [rad]."""
    if prefix == "rotor":
        angle, along = data["tip_angle"].values, tip_rows(data)[1] @ coordinates
    else:
        angle, along = data["casing_angle"].values, data["casing_shape"].values[:, 0] @ coordinates
    return float(-np.angle(along @ np.exp(-1j * k * angle)) / k) if k else 0.0


def mode_title(family: str, nodal_diameter: int, purity: float = 1.0) -> str:
    """Return the name of a mode, such as "1F, k = 2", "suspension" or "1F, mixed k"; only the
    family, such as "1F", if the body is not divided into sectors."""
    if family == "suspension" or nodal_diameter < 0:
        return family
    if purity < MIXED:
        return f"{family}, mixed k"
    return f"{family}, k = {nodal_diameter}"


def _frequency(data: xr.Dataset, frequency: float) -> str:
    """Return a frequency [rad/s] in multiples of the reference and in Hz."""
    ratio = frequency / float(data.attrs["reference_frequency"])
    return f"{ratio:.4g} ω₁ = {frequency / (2 * np.pi):.4g} Hz"
