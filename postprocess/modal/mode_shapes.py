"""Pictures of mode shapes (the paper's Fig. 6): undeformed and deformed body, and its centre."""

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.meshes.plane import directions, rotate
from bladewhirl.models.modal.labels import Body
from bladewhirl.postprocess.fields.enlarged import magnify
from bladewhirl.postprocess.fields.kinematics import casing_rows, ring_angles, tip_rows
from bladewhirl.postprocess.fields.points import points_of
from bladewhirl.postprocess.modal.surface_shapes import DRAWN, SurfaceShape
from bladewhirl.postprocess.plotting.legends import complete
from bladewhirl.postprocess.plotting.style import (
    COLOUR_MAPS,
    COLOURS,
    FULL_WIDTH,
    drawn_width,
    is_narrow,
    new_figure,
    styled,
)

BEAM_PIECES = 4  #: largest number of straight pieces by which the Hermite curve of a beam is drawn
MOST_PIECES = 16_000
"""Largest number of pieces in all beams of the bladed disk; with many beams, each beam has fewer
than `BEAM_PIECES`."""

RING_POINTS = 360  #: least number of drawn points of the casing
#: number of pictures of a travelling wave over a quarter of its period, including both ends
INSTANTS = 4
PURE = 0.9995
"""If the purity of a mode exceeds this value, only its nodal diameter is printed. The purity is the
share of the kinetic energy of the mode in its nodal diameter."""

LINE = 0.0045  #: height of a line of text at a panel [m]
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

    Args:
        rest: points of the undeformed lines (lines, stations, 2) [m].
        rows: displacements of these points for unit modal coordinates (points, 2, modes).
        shift: mean displacement of the body (2, modes).
        radius: radius of the body [m].
    """

    columns = 6  #: largest number of panels side by side
    projection = "rectilinear"  #: kind of the panels

    def __init__(
        self, rest: FloatArray, rows: FloatArray, shift: FloatArray, radius: float
    ) -> None:
        self.rest, self._rows, self._shift, self.radius = rest, rows, shift, radius

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

    def centre_share(self, coordinates: FloatArray) -> float | None:
        """Return the displacement of the centre by the largest displacement; None if the motion of
        the centre is not known."""
        return float(np.linalg.norm(self._shift @ coordinates) / self.largest(coordinates))

    def draw(self, axes: Axes, coordinates: FloatArray, motion: FloatArray) -> ScalarMappable:
        """Draw the body: undeformed in grey, deformed with the displacement as colour.

        Args:
            axes: the panel.
            coordinates: modal coordinates of the drawn instant (modes,).
            motion: modal coordinates of all instants (..., modes), which determine the size of the
                panel and the largest displacement, to which colours and drawn displacements refer.

        Returns:
            the deformed body, for the colour bar.
        """
        largest = self.largest(motion)
        factor = DRAWN * self.radius / largest
        axes.add_collection(LineCollection([*self.rest], color=COLOURS["rest"], linewidth=0.4))
        points = self.moved(coordinates, factor)
        pieces = [*np.stack([points[:, :-1], points[:, 1:]], axis=-2).reshape(-1, 2, 2)]
        axes.add_collection(LineCollection(pieces, color=COLOURS["total"], linewidth=1.4))
        colours: Any = {"cmap": COLOUR_MAPS["magnitude"], "norm": Normalize(0.0, 1.0)}
        lines = LineCollection(pieces, linewidth=0.9, **colours)
        lines.set_array((self.size(coordinates) / largest).ravel())
        axes.add_collection(lines)
        axes.plot(
            0.0, 0.0, "x", color=COLOURS["total"], markersize=2.5, zorder=4, label="centre at rest"
        )
        centre = factor * self._shift @ coordinates
        axes.plot(*centre, "o", color=COLOURS["k = 1"], markersize=3.6, label="centre displaced")
        drawn = [self.moved(instant, factor) for instant in np.atleast_2d(motion)]
        reach = MARGIN * max(self.radius, np.linalg.norm(drawn, axis=-1).max())
        axes.set(aspect="equal", xlim=(-reach, reach), ylim=(-reach, reach))
        axes.set_axis_off()
        return lines

    def describe(self, axes: Axes, name: str, words: list[str]) -> None:
        """Write the name of a mode above a panel and further lines below it."""
        axes.set_title(name)
        below: dict[str, Any] = {"transform": axes.transAxes, "ha": "center", "va": "top"}
        axes.text(0.5, -0.02, "\n".join(words), **below)


def shape_of(data: xr.Dataset, body: Body) -> Outline | SurfaceShape:
    """Return what is drawn of a body: lines, or a surface."""
    if body == "casing":
        angle = ring_angles(data, -(-RING_POINTS // data.sizes["casing_node"]))
        angle, radius = np.append(angle, angle[0]), float(data.attrs["casing_radius"])
        rows = rotate(casing_rows(data, angle), angle[:, None], axis=1)
        return Outline(radius * directions(angle)[None], rows, rows[:-1].mean(axis=0), radius)
    pieces = min(BEAM_PIECES, max(1, MOST_PIECES // data.sizes.get("rotor_line", 1)))
    points = points_of(data, pieces)
    if not points.flat:
        return SurfaceShape(points)
    rest, rows = points.stations(points.rest)[..., :2], points.stations(points.shape)[:, :, :2]
    rows = rows.reshape(-1, *rows.shape[2:])
    return Outline(rest, rows, points.centre, float(data.attrs["tip_radius"]))


@styled
def plot_mode_shapes(data: xr.Dataset, body: Body) -> Figure:
    """Draw the mode shapes of a body from `motion.shapes_dataset` side by side (the paper's Fig.
    6): lines, or displaced surfaces; surfaces of many triangles as points.

    Of lines, a cross marks the centre at rest, a dot the displaced centre; the centre of the casing
    moves by the mean displacement of the casing. The text at each shape gives what the tips do, the
    frequency, the displacement of the centre in percent of the largest displacement of the mode,
    the purity and, for whirling modes, the directions of travel in the rotating and in the static
    frame.
    """
    prefix = "rotor" if body == "bladed-disk" else "casing"
    modes, shape = data.sizes[f"{prefix}_mode"], shape_of(data, body)
    width, lines = drawn_width(FULL_WIDTH), 4 + 2 * (f"{prefix}_direction" in data)
    rows = -(-modes // max(2, round(shape.columns * width / FULL_WIDTH)))
    columns = -(-modes // rows)
    height = 0.022 + rows * (0.85 * width / columns + LINE * lines)
    figure = new_figure(width=width, height=height)
    panels = [
        figure.add_subplot(rows, columns, mode + 1, projection=shape.projection)
        for mode in range(modes)
    ]
    notes = dict.fromkeys(["Exaggerated."])
    for mode, axes in enumerate(panels):
        coordinates = np.eye(modes)[mode]
        drawn = shape.draw(axes, coordinates, coordinates)
        row = data.isel({f"{prefix}_mode": mode})
        purity, k = float(row[f"{prefix}_purity"]), int(row[f"{prefix}_nodal_diameter"])
        does = str(row["rotor_tip_motion"].values) if body == "bladed-disk" else ""
        words = [does, *_frequency(data, float(row[f"{prefix}_frequency"])).split(" = ")]
        share = shape.centre_share(coordinates)
        if share is not None:
            moves = f"centre {100 * share:.1f} %" if share > CENTRE_RESTS else "centre at rest"
            words.append(moves)
            notes["Centre: % of the largest displacement."] = None
        if 0 <= k and purity < PURE:
            words.append(f"k = {k}: {100 * purity:.0f} %")
            notes["k: % of the kinetic energy."] = None
        if f"{prefix}_direction" in data:
            words.append(str(row["rotor_direction"].values))
            words.append(f"static: {row['rotor_direction_static'].values}")
        name = mode_title(str(row[f"{prefix}_family"].values), k, purity if k >= 0 else 1.0)
        shape.describe(axes, name, [*filter(None, words)])
    figure.colorbar(
        drawn,
        ax=panels,
        location="right",
        label="displacement / largest one [–]",
        shrink=0.8,
        aspect=20,
        ticks=[0.0, 0.5, 1.0],
    )
    names = {"bladed-disk": "the bladed disk, rotating frame", "casing": "the casing"}
    complete(figure, data, f"Modes of {names[body]}; {_sense(data)}", " ".join(notes))
    return figure


@styled
def plot_travelling_wave(data: xr.Dataset, body: Body) -> Figure:
    """Draw a travelling wave from `motion.mode_motion` at `INSTANTS` instants of a quarter of its
    period, with its crests."""
    prefix = "rotor" if body == "bladed-disk" else "casing"
    coordinates = data[f"{prefix}_displacement"].values
    figure = new_figure(width=FULL_WIDTH, height=0.062)
    rows = 2 if is_narrow(figure) else 1
    figure.set_figheight(rows * figure.get_figheight())
    panels = figure.subplots(rows, INSTANTS // rows, squeeze=False).ravel()
    shape = shape_of(data, body)
    k = int(data[f"{prefix}_nodal_diameter"].values[0])
    crests = "tips furthest ahead, ↺" if body == "bladed-disk" else "wall furthest out"
    for number, axes in enumerate(panels):
        record = len(coordinates) * number // (4 * (INSTANTS - 1))
        drawn = shape.draw(axes, coordinates[record], coordinates)
        _mark_crests(axes, _crest(data, prefix, coordinates[record], k), k, f"crest: {crests}")
        degrees = 90 * number // (INSTANTS - 1)
        axes.set_title("start" if not number else f"{degrees}° of its period")
    figure.colorbar(
        drawn, ax=[*panels], label="displacement / largest [–]", shrink=0.8, ticks=[0, 1]
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
