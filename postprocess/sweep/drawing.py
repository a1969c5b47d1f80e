"""Shared parts of the figures of sweeps: axes of swept keys, styles and names of lines, colours of
regimes, titles.

A line belongs to one combination of values of the swept keys that are not on an axis.
"""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FixedLocator, FuncFormatter, MaxNLocator, NullLocator
from numpy.typing import NDArray

from bladewhirl.models.inputs.units import handy_unit
from bladewhirl.postprocess.fields.kinematics import Array
from bladewhirl.postprocess.plotting.axes import SPEED, cell_edges, rpm_axis
from bladewhirl.postprocess.plotting.legends import Group, legends_below
from bladewhirl.postprocess.plotting.style import (
    COLOUR_MAPS,
    COLOURS,
    FULL_WIDTH,
    INCH,
    is_narrow,
    new_figure,
    rows_of_panels,
)
from bladewhirl.postprocess.plotting.titles import key_words, set_title
from bladewhirl.postprocess.sweep.quantities import LINE, other_keys
from bladewhirl.solvers.march.schema import POINT

MOST_LINES = 8  #: largest number of lines in a figure; more lines cannot be distinguished
MOST_ROWS = 4  #: largest number of lines in a figure with a row of panels for each line
KEY_PARTS = 2  #: a key is named by this number of its last parts: casing.clearance

#: the axis is logarithmic if the largest value of a key is at least this many times the smallest
WIDE_RANGE = 50.0
MOST_TICKS = 12
"""Largest number of ticks at swept values on an axis as wide as a page. If there are more than
twice as many values, matplotlib chooses the ticks."""

REGIME_COLOURS: Mapping[str, str] = {
    "no-contact": COLOURS["rest"],
    "damped": COLOURS["casing"],
    "sustained": COLOURS["k = 0"],
    "divergent": COLOURS["k = 1"],
}
"""Colours of the regimes, the least dangerous first."""

REGIME_MARKS: Mapping[str, str] = dict(zip(REGIME_COLOURS, "_vo^", strict=True))

#: dashes and marks of the lines of a figure, in the order of the lines
DASHES: Sequence[Any] = (
    "-",
    (0, (4, 1.5)),
    (0, (1.2, 1.2)),
    (0, (6, 1.5, 1.5, 1.5)),
    (0, (8, 3)),
    (0, (4, 1, 1, 1, 1, 1)),
    (0, (2.5, 2.5)),
    (0, (1, 3)),
)
MARKS = ("o", "s", "D", "^", "v", "P", "X", "h")
MARK_SIZE = 3.5  #: [points]


def in_handy_units(data: xr.Dataset) -> xr.Dataset:
    """Convert the values of swept keys to convenient units, and speeds to multiples of the
    reference frequency.

    Args:
        data: Dataset with swept keys in SI units, as coordinates with a `long_name`, and the
            attribute `reference_hz` if all points have the same reference frequency.
    """
    handy = {}
    reference = 2 * np.pi * float(data.attrs.get("reference_hz", np.nan))
    for name, values in data.coords.items():
        if values.attrs.get("units") == "rad/s" and np.isfinite(reference):
            ratio = values.values / reference
            handy[str(name)] = (values.dims, ratio, {**values.attrs, "units": "1"})
        elif "long_name" in values.attrs and values.dtype.kind == "f" and values.size:
            size = float(np.abs(values.values).max())
            unit, scale = handy_unit(size, str(values.attrs.get("units", "1")))
            rounded = np.round(scale * values.values, 12)  # 0.1 mm, not 0.10000000000000002
            handy[str(name)] = (values.dims, rounded, {**values.attrs, "units": unit})
    return data.assign_coords(handy)


def key_axis(
    axes: Axes, data: xr.Dataset, *, of_y: bool = False, key: str = "", share: float = 1.0
) -> None:
    """Set label, limits, scale and ticks of an axis for a swept key; few values get a tick each.

    The axis is logarithmic if the range of the values is wide, see `is_wide`.

    Args:
        axes: the panel.
        data: Dataset with the key.
        of_y: true for the vertical axis, false for the horizontal axis.
        key: name of the key; the key of the horizontal axis by default.
        share: width of the axis, relative to the width of the figure, or height of it, relative to
            the width of a page.
    """
    values = data[key or str(data.attrs["along"])]
    place, way = values.values, "y" if of_y else "x"
    axes.set(
        **{
            f"{way}scale": "log" if is_wide(place) else "linear",
            f"{way}label": key_label(values),
            f"{way}lim": edges_of(place)[[0, -1]],
        }
    )
    figure = axes.get_figure(root=True)
    share *= figure.get_figwidth() * INCH / FULL_WIDTH if figure and not of_y else 1.0
    most = max(2, int(MOST_TICKS * share))
    if len(place) <= 2 * most:
        axis = axes.yaxis if of_y else axes.xaxis
        axis.set_major_locator(FixedLocator(place.tolist(), nbins=most))
        axis.set_minor_locator(NullLocator())
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:.4g}"))


def rpm_on_top(data: xr.Dataset, *panels: Axes) -> None:
    """Add an axis in rpm on top of the uppermost panels of a figure if their abscissa is the speed.
    The drawn `data` are from `in_handy_units`."""
    key = data[str(data.attrs["along"])]
    if key_label(key) == SPEED and "reference_hz" in data.attrs:
        for axes in panels:
            rpm_axis(axes, float(data.attrs["reference_hz"]))


def grid_of_panels(
    data: xr.Dataset, widths: Sequence[float], height: float, **options: Any
) -> tuple[Figure, list[int], NDArray[Any]]:
    """Return a figure with a row of panels for each of up to `MOST_ROWS` lines, the numbers of
    these lines, and the panels (row, column), see `rows_of_panels`; rows have titles."""
    shown, titles = chosen(data.sizes[LINE], MOST_ROWS), line_values(data)
    figure = new_figure(width=FULL_WIDTH, height=height)
    panels = np.array(rows_of_panels(figure, len(shown), widths, sharex=True, **options))
    for number, first in zip(shown, panels[:, 0], strict=True):
        first.set_title(titles[number], loc="left")
    return figure, shown, panels


def label_grid(data: xr.Dataset, panels: NDArray[Any], share: float) -> None:
    """Add axes of the swept key below panels (row, column), and axes in rpm above them if the key
    is the speed. `share` is the width of a panel in a row, relative to that of the figure."""
    narrow = is_narrow(panels[0, 0].get_figure(root=True))
    for axes in panels[-1, -1:] if narrow else panels[-1]:
        key_axis(axes, data, share=0.9 if narrow else share)
    rpm_on_top(data, *panels[0, : 1 if narrow else None])


def finish_maps(
    data: xr.Dataset, panels: NDArray[Any], bars: Mapping[int, tuple[Any, str]]
) -> None:
    """Add axes of both swept keys to maps in panels (row, column), and colour bars: of each column
    its map and its label."""
    figure, (rows, columns) = panels[0, 0].get_figure(root=True), panels.shape
    narrow, of_speed = is_narrow(figure), key_label(data[str(data.attrs["along"])]) == SPEED
    for axes in panels[:, : columns if narrow else 1].flat:
        key_axis(axes, data, of_y=True, key=str(data.attrs["across"]), share=0.5)
    label_grid(data, panels, 1.3 / columns)
    for column, (drawn, label) in bars.items():
        # above the axis in rpm
        pad = 0.02 + (0.13 / rows if of_speed and not narrow else 0.0)
        place, aspect = ("right", 20 * rows) if narrow else ("top", 30)
        look: dict[str, Any] = {"location": place, "pad": pad, "aspect": aspect, "label": label}
        bar = figure.colorbar(drawn, ax=panels[:, column].tolist(), **look)
        if isinstance(bar.norm, Normalize) and bar.norm.__class__ is Normalize:
            bar.ax.locator_params(nbins=4)


def key_edges(one: xr.Dataset) -> Array:
    """Return the borders of cells around the values of the horizontal key, (values + 1,)."""
    return edges_of(one[str(one.attrs["along"])].values)


def edges_of(place: Array) -> Array:
    """Return the borders of cells around ascending values, (values + 1,), midway between the values
    on a linear or, for a wide range, on a logarithmic scale."""
    return cell_edges(place, logarithmic=is_wide(place))


def is_wide(values: Array) -> bool:
    """Return true if the values are positive and their range is wide: use a logarithmic axis."""
    return bool(np.min(values) > 0 and np.max(values) >= WIDE_RANGE * np.min(values))


def key_label(values: xr.DataArray) -> str:
    """Return the label of a swept key with its unit."""
    name, units = str(values.attrs["long_name"]), str(values.attrs["units"])
    if name == "march.speed" and units == "1":
        return SPEED
    words = key_words(name)
    return words if units == "1" else f"{words} [{units}]"


class Line(NamedTuple):
    """Data and style of a line, see the module docstring."""

    data: xr.Dataset
    colour: Any
    label: str  #: values of the keys that are not on an axis; empty if there are no such keys
    dash: Any
    mark: str

    @property
    def place(self) -> Array:
        """Values of the key on the horizontal axis, (points,)."""
        return np.asarray(self.data[str(self.data.attrs["along"])].values)


def lines_of(data: xr.Dataset) -> list[Line]:
    """Return the lines of a figure, each with its own colour, dashes and mark. Of more than
    `MOST_LINES` lines an even selection is returned. Points of a table are not joined by lines.
    """
    shown, labels = chosen(data.sizes[LINE], MOST_LINES), line_values(data)
    shades = COLOUR_MAPS["line"](np.linspace(0.0, 1.0, len(shown)))
    joined = data.attrs["along"] != POINT
    return [
        Line(data.isel({LINE: number}), shade, labels[number], dash if joined else "none", mark)
        for number, shade, dash, mark in zip(shown, shades, DASHES, MARKS, strict=False)
    ]


def lines_group(lines: Sequence[Line], *, dashed: bool = True, marked: bool = True) -> Group:
    """Return the legend entries of lines, with dashes and marks if requested; none for one line."""
    entries = []
    for line in lines if len(lines) > 1 else ():
        style: Any = line.dash if dashed else "none"
        mark = line.mark if marked else "none"
        handle = Line2D(
            [], [], color=line.colour, linestyle=style, marker=mark, markersize=MARK_SIZE
        )
        entries.append((handle, line.label))
    return Group(entries, line_keys(lines[0].data) if entries else "")


def draw_marks(axes: Axes, line: Line, values: Array, *, filled: Any) -> None:
    """Draw marks of the points of a line at the ordinates `values` (points,): full marks where
    `filled` (points,) is true, open marks elsewhere."""
    for subset, face in ((filled, line.colour), (~filled, "white")):
        look = {"color": line.colour, "markerfacecolor": face, "markersize": MARK_SIZE}
        axes.plot(line.place[subset], values[subset], line.mark, **look)


def open_mark(label: str) -> tuple[Line2D, str]:
    """Return the legend entry of an open mark with the text `label`."""
    drawn = Line2D([], [], color=COLOURS["rotor"], marker="o", mfc="white", linestyle="none")
    return drawn, label


def label_figure(figure: Figure, data: xr.Dataset, *groups: Group) -> None:
    """Complete a figure of `data` with panels one above another. Add an axis of the swept key below
    the panels, an axis in rpm above the panels if the key is the speed, the title, and legends
    below the figure: a legend for each group of entries, the first uppermost."""
    key_axis(figure.axes[-1], data)
    rpm_on_top(data, figure.axes[0])
    title_figure(figure, data, *groups)


def stacked(
    data: xr.Dataset, count: int, height: float, **arrangement: Any
) -> tuple[xr.Dataset, list[Line], Figure, list[Axes]]:
    """Return data in convenient units, their lines, and a new figure with panels one above another.

    Args:
        data: Dataset over (line, key).
        count: number of panels.
        height: height of the figure [m].
        arrangement: further arguments of `matplotlib.figure.Figure.subplots`.
    """
    data = in_handy_units(data)
    figure = new_figure(width=FULL_WIDTH, height=height)
    panels = figure.subplots(count, 1, sharex=True, squeeze=False, **arrangement)
    return data, lines_of(data), figure, [*panels[:, 0]]


def draw_quantity(axes: Axes, lines: Sequence[Line], name: str, scale: float) -> None:
    """Draw lines of a quantity multiplied by `scale`; divergent points have open marks."""
    for line in lines:
        size = scale * line.data[name].values
        axes.plot(line.place, size, color=line.colour, linestyle=line.dash)
        draw_marks(axes, line, size, filled=line.data["regime"].values != "divergent")


def divergent_mark(data: xr.Dataset) -> Group:
    """Return the legend entry of the marks of divergent points, if there are any."""
    divergent = (data["regime"] == "divergent").any()
    return Group([open_mark("divergent (open marks)")] if divergent else [])


def plot_quantities(data: xr.Dataset, panels: Mapping[str, tuple[float | None, str]]) -> Figure:
    """Draw quantities against the swept key, one in each panel; divergent points have open marks.

    Args:
        data: Dataset over (line, key) with the quantities and `regime`.
        panels: factor and label of each quantity; with None the label is followed by a convenient
            unit.
    """
    data, lines, figure, axes_of = stacked(data, len(panels), 0.02 + 0.04 * len(panels))
    for axes, (name, (scale, label)) in zip(axes_of, panels.items(), strict=True):
        if scale is None:
            largest = float(data[name].max().fillna(0.0))
            unit, scale = handy_unit(largest, str(data[name].attrs["units"]))
            label = f"{label} [{unit}]"
        draw_quantity(axes, lines, name, scale)
        axes.margins(y=0.1)
        axes.set_ylim(bottom=0.0)
        whole = scale * data[name].values
        if np.array_equal(whole, np.round(whole), equal_nan=True):
            axes.yaxis.set_major_locator(MaxNLocator(5, integer=True))
        axes.set_ylabel(label)
    label_figure(figure, data, divergent_mark(data), lines_group(lines))
    return figure


def title_figure(
    figure: Figure, data: xr.Dataset, *groups: Group, most: int = MOST_LINES, lines: int = 0
) -> None:
    """Set the title of a figure: case, quantity, and names of the keys that distinguish its lines;
    and add legends below the figure, the first group of entries uppermost.

    Args:
        figure: the figure.
        data: the drawn Dataset.
        groups: entries of the legends.
        most: largest number of lines in the figure.
        lines: number of lines of the sweep; the number of lines in `data` by default.
    """
    count = lines or data.sizes[LINE]
    keys = line_keys(data)
    left_out = f" ({most} of {count} lines, all lines are in the data)" if count > most else ""
    of_keys = f"\nlines: {keys}{left_out}" if keys else ""
    set_title(figure, data.attrs["case"], f"{data.attrs['title']}{of_keys}")
    legends_below(figure, *groups)


def line_keys(data: xr.Dataset) -> str:
    """Return the names of the keys that distinguish the lines, as text; empty without such keys."""
    return ", ".join(
        key_words(".".join(str(values.attrs["long_name"]).split(".")[-KEY_PARTS:]))
        for values in data.coords.values()
        if values.dims in ((), (LINE,)) and "long_name" in values.attrs
    )


def chosen(count: int, most: int) -> list[int]:
    """Return the numbers of up to `most` of `count` elements, evenly spaced from first to last."""
    spread = np.linspace(0, count - 1, min(count, most))
    return [int(number) for number in spread.round()]


def line_label(one: xr.Dataset) -> str:
    """Return names and values of the keys that distinguish a line, as text."""
    return ", ".join(
        f"{key_words(values.attrs.get('long_name', name))} = {_amount(float(values), values)}"
        for name, values in one.coords.items()
        if values.ndim == 0 and "long_name" in values.attrs
    )


def line_values(data: xr.Dataset) -> list[str]:
    """Return the values, with units, of the keys that distinguish each line, as text."""
    keys = other_keys(data)
    return [
        ", ".join(_amount(float(values[number]), values) for values in keys)
        for number in range(data.sizes[LINE])
    ]


def _amount(value: float, values: xr.DataArray) -> str:
    units = str(values.attrs.get("units", "1"))
    return f"{value:.4g}" if units == "1" else f"{value:.4g} {units}"
