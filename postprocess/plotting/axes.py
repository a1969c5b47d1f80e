"""Axes of speed and frequency, maps, and labels next to points and lines."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, QuadMesh
from matplotlib.colors import ListedColormap, LogNorm, Normalize
from matplotlib.patches import Patch
from matplotlib.text import Text
from matplotlib.ticker import MaxNLocator
from matplotlib.transforms import Bbox
from numpy.typing import ArrayLike

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.postprocess.plotting.legends import Group
from bladewhirl.postprocess.plotting.style import COLOUR_MAPS, JOINT_STATES

SPEED = "speed Ω / ω₁ [–]"
FREQUENCY = "frequency / ω₁ [–]"

Offsets = Sequence[tuple[float, float]]

ON: Offsets = [(0, 0)]  #: offset of a label from its point [points]: the label covers the point
#: offsets of a label above, below and at the sides of its point [points]
AROUND: Offsets = [(0, 4), (-4, 3), (4, -3), (0, -4), (4, 3), (-4, -3), (5, 0), (-5, 0)]

LETTERS = 7.0  #: size of labels [points]
LEADER = 12.0  #: horizontal distance of a name from the end of its line [points]
SAME = 0.5  #: distance up to which two points are one [pixels]
NEARER = 1.5  #: least distance of a label from another point, by that from its own
CANDIDATES = 40  #: largest number of points of a line at which a label is tried


def speed_axis(axes: Axes, reference_hz: float) -> None:
    """Label an x axis of speeds in multiples of the reference frequency, and add an axis in rpm on
    top. `reference_hz` is the reference frequency [Hz]."""
    axes.set_xlabel(SPEED)
    rpm_axis(axes, reference_hz)


def rpm_axis(axes: Axes, reference_hz: float) -> None:
    """Add an axis in rpm on top of axes whose x values are normalised speeds, see `speed_axis`."""
    unit = 60.0 * reference_hz
    functions = (lambda x: np.asarray(x) * unit, lambda x: np.asarray(x) / unit)
    axes.secondary_xaxis("top", functions=functions).set_xlabel("speed [rpm]")


def frequency_axis(axes: Axes, reference_hz: float, label: str = FREQUENCY) -> None:
    """Label a y axis of frequencies in multiples of the reference frequency, and add an axis in Hz
    on the right. `reference_hz` is the reference frequency [Hz]."""
    axes.set_ylabel(label)
    functions = (lambda x: np.asarray(x) * reference_hz, lambda x: np.asarray(x) / reference_hz)
    axes.secondary_yaxis("right", functions=functions).set_ylabel("frequency [Hz]")


def blade_axis(axes: Axes, blades: int, *, of_y: bool = False, most: int = 8) -> None:
    """Label an axis of the numbers of blades, with at most `most` intervals between ticks, and set
    its limits."""
    axis, limits = (axes.yaxis, axes.set_ylim) if of_y else (axes.xaxis, axes.set_xlim)
    limits(-0.7, blades - 0.3)
    axis.set_major_locator(MaxNLocator(nbins=most, integer=True, steps=[1, 2, 5, 10]))
    axis.set_label_text("blade")
    if not of_y:
        axes.grid(axis="x", visible=False)


def draw_map(
    axes: Axes, x: ArrayLike, y: ArrayLike, values: ArrayLike, *, label: str = "", **look: Any
) -> QuadMesh:
    """Draw values (row, column) as coloured cells without grid lines; in a PDF the cells are a
    raster image.

    Args:
        axes: the panel.
        x, y: borders, or middles, of the columns and of the rows.
        values: values shown as colours; masked values and nan are left out.
        label: label of a colour bar beside the panel; none if empty.
        look: arguments of `pcolormesh`.
    """
    axes.grid(False)
    x, y = (
        cell_edges(np.asarray(places), logarithmic=False) if np.size(places) == cells else places
        for places, cells in zip((x, y), np.shape(values)[::-1], strict=True)
    )
    mesh = axes.pcolormesh(
        x, y, values, rasterized=True, **{"cmap": COLOUR_MAPS["magnitude"], **look}
    )
    if label:
        axes.figure.colorbar(mesh, ax=axes, label=label)
    return mesh


def draw_states(axes: Axes, x: ArrayLike, y: ArrayLike, states: ArrayLike) -> Group:
    """Draw numbers of states of joints (row, column) as a map, see `draw_map`; return the entries
    of a legend."""
    colours, last = ListedColormap([*JOINT_STATES.values()]), len(JOINT_STATES) - 0.5
    draw_map(axes, x, y, states, cmap=colours, vmin=-0.5, vmax=last)
    patches = [Patch(fc=colour, ec="black", lw=0.5) for colour in JOINT_STATES.values()]
    return Group([*zip(patches, JOINT_STATES, strict=True)])


def draw_decades(
    axes: Axes,
    x: ArrayLike,
    y: ArrayLike,
    values: ArrayLike,
    scale: tuple[float, float],
    **look: Any,
) -> QuadMesh:
    """Draw a map, see `draw_map`, with logarithmic colours. `scale` is the largest value and the
    number of decades below it that colours distinguish; smaller values have the lowest colour."""
    top, number = scale
    low = top * 10**-number
    return draw_map(axes, x, y, np.maximum(values, low), norm=LogNorm(low, top), **look)


def cell_edges(values: FloatArray, *, logarithmic: bool) -> FloatArray:
    """Return the borders of cells around ascending values, (values + 1,): the arithmetic or, if
    `logarithmic`, the geometric means of neighbours. The cell of a single value has unit width on
    the linear or logarithmic scale."""
    places = np.log(values) if logarithmic else np.asarray(values, dtype=np.float64)
    if len(places) == 1:
        edges = places[0] + np.array([-0.5, 0.5])
    else:
        middle = 0.5 * (places[1:] + places[:-1])
        first, last = 2 * places[0] - middle[0], 2 * places[-1] - middle[-1]
        edges = np.concatenate([[first], middle, [last]])
    return np.asarray(np.exp(edges) if logarithmic else edges)


def spaced(name: str) -> str:
    """Return the name of a mode as figures show it: "1F k = 1" for "1F k=1"."""
    return name.replace("k=", "k = ")


def name_ends(
    axes: Axes, x: float, heights: ArrayLike, names: Sequence[str], colour: str, *, right: bool
) -> None:
    """Name lines beside their ends, at one abscissa, each with a leader from the line to its name.

    Names keep their order and are moved up or down as little as necessary (least squares), so that
    they neither overlap nor leave the panel. The figure must be complete except for its names.

    Args:
        axes: the panel.
        x: abscissa of the ends.
        heights: ordinates of the ends, (lines,).
        names: names of the lines, (lines,).
        colour: colour of names and leaders.
        right: true for names to the right of the ends, false for names to the left.
    """
    from scipy.optimize import isotonic_regression  # slow to load

    _lay_out(axes)
    heights = np.asarray(heights, dtype=np.float64)
    order = np.argsort(heights, kind="stable")
    point = axes.figure.dpi / 72.0
    pixels = axes.transData.transform(np.column_stack([np.full(len(order), x), heights[order]]))
    ends = pixels[:, 1]
    apart = 1.2 * LETTERS * point
    steps = apart * np.arange(len(order))
    low, high = axes.bbox.y0 + 0.5 * apart, axes.bbox.y1 - 0.5 * apart
    moved = isotonic_regression(ends - steps).x
    places = np.clip(moved, low, max(low, high - apart * (len(order) - 1))) + steps
    for i, line in enumerate(order):
        axes.annotate(
            names[line],
            (x, float(heights[line])),
            (LEADER if right else -LEADER, float(places[i] - ends[i]) / point),
            textcoords="offset points",
            ha="left" if right else "right",
            va="center",
            color=colour,
            fontsize=LETTERS,
            zorder=7,
            arrowprops={
                "arrowstyle": "-",
                "color": colour,
                "linewidth": 0.4,
                "relpos": (0.0 if right else 1.0, 0.5),
                "shrinkA": 0.0,
                "shrinkB": 3.0,
            },
        )


def _lay_out(axes: Axes) -> None:
    """Lay out the figure of a panel, so that positions in the panel are final."""
    figure = axes.get_figure(root=True)
    layout = figure.get_layout_engine() if figure else None
    if figure and layout:
        layout.execute(figure)


class Labels:
    """Labels in a panel; a label that would cover another label, leave the panel or be nearer to
    another point is left out."""

    def __init__(self, axes: Axes, *, laid_out: bool = False) -> None:
        """Lay out the figure of a panel, unless it is laid out; the figure must be complete except
        for its labels."""
        if not laid_out:
            _lay_out(axes)
        self._axes = axes
        self._taken: list[Bbox] = []
        self._points = np.zeros((0, 2))

    def keep_free(self, x: ArrayLike, y: ArrayLike) -> None:
        """Keep labels away from the points x, y, whose marks have a diameter of 4 points."""
        half = 0.5 * 4.0 * self._axes.figure.dpi / 72.0
        self._points = self._axes.transData.transform(np.column_stack([x, y]))
        self._taken += [Bbox([place - half, place + half]) for place in self._points]

    def add(
        self, x: ArrayLike, y: ArrayLike, text: str, colour: str, offsets: Offsets = ON
    ) -> bool:
        """Write a label at the first position where it covers no other label.

        Args:
            x, y: positions, or points of a line, in the order of preference.
            text: the label.
            colour: colour of the text.
            offsets: offsets of the label from a position, in the order of preference.

        Returns:
            false if no position has space for the label, which is then left out.
        """
        places = np.column_stack([np.atleast_1d(x), np.atleast_1d(y)])
        places = places[np.isfinite(places).all(axis=1)]
        for place in places[:: max(1, len(places) // CANDIDATES)]:
            for dx, dy in offsets:
                label = self._axes.annotate(
                    text,
                    (float(place[0]), float(place[1])),
                    (dx, dy),
                    textcoords="offset points",
                    ha="left" if dx > 0 else "right" if dx < 0 else "center",
                    va="bottom" if dy > 0 else "top" if dy < 0 else "center",
                    color=colour,
                    fontsize=LETTERS,
                    zorder=7,
                    bbox={"boxstyle": "square,pad=0.1", "fc": "white", "ec": "none", "alpha": 0.8},
                )
                label.get_window_extent()  # moves the label to its position
                box = Text.get_window_extent(label)
                inside = self._axes.bbox.containsx(box.x0) and self._axes.bbox.containsx(box.x1)
                inside = inside and self._axes.bbox.y0 <= box.y0 and box.y1 <= self._axes.bbox.y1
                if inside and not box.count_overlaps(self._taken) and self._of(place, box):
                    self._taken.append(box)
                    return True
                label.remove()
        return False

    def _of(self, place: FloatArray, box: Bbox) -> bool:
        """Return whether a label is clearly nearer to its place than to all other points."""
        own = self._axes.transData.transform(place)
        others = self._points[np.linalg.norm(self._points - own, axis=1) > SAME]
        low, high = np.array(box.extents).reshape(2, 2)
        outside = (np.maximum(0.0, np.maximum(low - at, at - high)) for at in (own, others))
        near, far = (np.linalg.norm(each, axis=-1) for each in outside)
        return bool(np.all(far > NEARER * near))


def coloured_line(
    axes: Axes, x: FloatArray, y: FloatArray, value: FloatArray, width: float
) -> LineCollection:
    """Draw a line whose colour along the line shows values between 0 and 1; `width` in points."""
    points = np.column_stack([x, y])
    lines = LineCollection(
        [*np.stack([points[:-1], points[1:]], axis=1)],
        cmap=COLOUR_MAPS["line"],
        norm=Normalize(0.0, 1.0),
        linewidth=width,
        capstyle="round",
    )
    lines.set_array(0.5 * (value[1:] + value[:-1]))
    axes.add_collection(lines)
    return lines
