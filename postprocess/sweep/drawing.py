"""Shared parts of the figures of sweeps: looks and names of lines, regimes, panels."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import matplotlib
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.transforms import ScaledTranslation, Transform

from bladewhirl.postprocess.fields.kinematics import Array
from bladewhirl.postprocess.plotting.legends import Group, legends_below
from bladewhirl.postprocess.plotting.style import COLOURS, FULL_WIDTH, SEQUENTIAL, new_figure
from bladewhirl.postprocess.plotting.titles import set_title
from bladewhirl.postprocess.sweep.axes import in_handy_units, key_axis, key_words, rpm_on_top
from bladewhirl.postprocess.sweep.quantities import LINE, other_keys

MOST_LINES = 8
"""Lines in a figure: more are not told apart."""

MOST_ROWS = 4
"""Lines in a figure that has a row for each."""

MOST_PANELS = 6
"""Panels of a figure that has one for each line."""

KEY_PARTS = 2
"""Last parts of a key that say what it is: casing.clearance."""

REGIME_COLOURS: Mapping[str, str] = {
    "no-contact": COLOURS["rest"],
    "damped": COLOURS["casing"],
    "sustained": COLOURS["k = 0"],
    "divergent": COLOURS["k = 1"],
}
"""In the order of danger."""

REGIME_MARKS: Mapping[str, str] = {
    "no-contact": "_",
    "damped": "v",
    "sustained": "o",
    "divergent": "^",
}

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
"""Of lines in turn."""

MARKS = ("o", "s", "D", "^", "v", "P", "X", "h")
"""Of the points of lines in turn, where marks don't tell something else."""

WIDTHS, SIZES = (2.6, 0.9), (7.0, 3.5)
"""Width of the first and the last line, and size of their marks [points]: earlier ones are larger,
so that they are seen below later ones that coincide with them."""


DODGE = 4.0
"""Between points of lines that are drawn side by side [points]."""

SIDE_BY_SIDE = "; marks at one value stand side by side"
"""What a title says of them."""


class Line(NamedTuple):
    """Line of points and its style."""

    data: xr.Dataset
    colour: Any
    label: str  #: values of the other keys; empty where there are none
    dash: Any
    mark: str
    width: float  #: [points]
    size: float  #: of marks [points]


def lines_of(data: xr.Dataset) -> Iterator[Line]:
    """Return the lines of a figure: at most `MOST_LINES`, evenly selected.

    They differ in colour, dashes, mark and size.
    """
    shown = chosen(data.sizes[LINE], MOST_LINES)
    count, labels = len(shown), line_values(data)
    shades = matplotlib.colormaps[SEQUENTIAL](np.linspace(0.0, 0.8, count))
    widths, sizes = (np.linspace(*ends, count) for ends in (WIDTHS, SIZES))
    for place, number in enumerate(shown):
        yield Line(
            data=data.isel({LINE: number}),
            colour=COLOURS["rotor"] if count == 1 else shades[place],
            label=labels[number],
            dash=DASHES[place],
            mark=MARKS[place],
            width=1.0 if count == 1 else float(widths[place]),
            size=3.5 if count == 1 else float(sizes[place]),
        )


def lines_group(
    data: xr.Dataset,
    lines: Sequence[Line],
    name: str,
    *,
    dashed: bool = True,
    marked: bool = True,
) -> Group:
    """Return the legend entries of lines; empty for a single line.

    Args:
        data: that the lines are of.
        lines: from `lines_of`.
        name: of the variable that is drawn; a line that has no value of it says so.
        dashed: the lines are drawn as such, not by their points only, which then are open but of
            the smallest.
        marked: points have the marks of their lines.
    """
    if len(lines) == 1:
        return Group([])
    entries: list[tuple[Line2D, str]] = []
    for line in lines:
        drawn = Line2D(
            [],
            [],
            color=line.colour,
            linestyle=line.dash if dashed else "none",
            linewidth=line.width,
            marker=line.mark if marked else "none",
            markersize=line.size,
            markerfacecolor=line.colour if dashed or line.size <= SIZES[1] else "none",
        )
        some = bool(np.isfinite(line.data[name].values).any())
        entries.append((drawn, line.label if some else f"{line.label}: no point"))
    return Group(entries, line_keys(data))


def dodged(axes: Axes, number: int, count: int) -> Transform:
    """Return a transform that offsets the points of several lines at one value.

    Args:
        axes: to draw on.
        number: of the line.
        count: of lines.
    """
    aside = DODGE * (number - 0.5 * (count - 1)) / 72.0
    return axes.transData + ScaledTranslation(aside, 0.0, axes.figure.dpi_scale_trans)


def draw_marks(axes: Axes, line: Line, place: Array, values: Array, *, filled: Any) -> None:
    """Draw the marks of a line's points, some filled, the others open.

    Args:
        axes: to draw on.
        line: that the points are of.
        place: of the points along the key, (points,).
        values: (points,).
        filled: which of them, booleans, (points,).
    """
    for subset, face in ((filled, line.colour), (~filled, "white")):
        axes.plot(
            place[subset],
            values[subset],
            line.mark,
            color=line.colour,
            mfc=face,
            markersize=line.size,
        )


def mark_entry(
    mark: str, label: str, *, filled: bool = True, colour: str = COLOURS["rotor"]
) -> tuple[Line2D, str]:
    """Entry of a legend for a mark."""
    face = colour if filled else "white"
    drawn = Line2D([], [], color=colour, marker=mark, mfc=face, linestyle="none", markersize=4.0)
    return drawn, label


def label_figure(figure: Figure, data: xr.Dataset, *groups: Group, note: str = "") -> None:
    """Title a figure of `lines_of` with a note on omitted lines, add legends below it and an axis
    in rpm above its first panel.

    Args:
        figure: all else being drawn.
        data: that is drawn.
        groups: legends from the top.
        note: after the title.
    """
    rpm_on_top(data, figure.axes[0])
    left_out = left_out_note(data.sizes[LINE], MOST_LINES)
    set_title(figure, data.attrs["case"], data.attrs["title"] + note + left_out)
    legends_below(figure, *groups)


def two_columns(
    data: xr.Dataset,
    draw: Callable[[Axes, Axes, xr.Dataset], QuadMesh],
    *,
    coloured: int,
    label: str,
) -> Figure:
    """A row of two panels for each line, of which one column is coloured, the other has a legend.

    Args:
        data: over (line, key).
        draw: draws both panels of a line; returns what is coloured.
        coloured: number of the coloured column.
        label: of its colours.
    """
    data = in_handy_units(data)
    titles, shown = panel_titles(data), chosen(data.sizes[LINE], MOST_ROWS)
    figure = new_figure(width=FULL_WIDTH, height=0.02 + 0.05 * len(shown))
    figure.set_layout_engine("constrained", wspace=0.08)
    rows = figure.subplots(len(shown), 2, sharex=True, sharey="col", squeeze=False)
    for number, (left, right) in zip(shown, rows, strict=True):
        picture = draw(left, right, data.isel({LINE: number}))
        if titles[number]:
            left.set_title(titles[number], loc="left")
    for axes in rows[-1]:
        key_axis(axes, data, cells=True, share=0.5)
    figure.colorbar(picture, ax=rows[:, coloured].tolist(), label=label, pad=0.02)
    note = left_out_note(data.sizes[LINE], MOST_ROWS) + panels_note(data, "rows")
    rpm_on_top(data, *rows[0])
    set_title(figure, data.attrs["case"], data.attrs["title"] + note)
    entries = zip(*rows[0, 1 - coloured].get_legend_handles_labels(), strict=True)
    legends_below(figure, Group(list(entries)))
    return figure


def chosen(count: int, most: int) -> list[int]:
    """Return all positions, or the first, the last and evenly spaced ones between them."""
    spread = np.linspace(0, count - 1, min(count, most))
    return [int(number) for number in spread.round()]


def left_out_note(count: int, most: int) -> str:
    """Words of a title for lines that are not drawn."""
    return f" ({most} of {count} lines, the others are in the data)" if count > most else ""


def line_label(one: xr.Dataset) -> str:
    """Return the values of the other keys of a line as text."""
    return ", ".join(
        f"{key_words(values.attrs.get('long_name', name))} = {_amount(float(values), values)}"
        for name, values in one.coords.items()
        if values.ndim == 0 and "long_name" in values.attrs
    )


def line_keys(data: xr.Dataset) -> str:
    """Return the names of the other keys for `line_values`; empty if there are none."""
    return ", ".join(
        key_words(".".join(str(values.attrs["long_name"]).split(".")[-KEY_PARTS:]))
        for values in other_keys(data)
    )


def line_values(data: xr.Dataset) -> list[str]:
    """Values of the other keys of each line with their units, in the order of `line_keys`."""
    keys = other_keys(data)
    return [
        ", ".join(_amount(float(values[number]), values) for values in keys)
        for number in range(data.sizes[LINE])
    ]


def panel_titles(data: xr.Dataset) -> list[str]:
    """Title of a panel for each line: the name of one other key and its value; of several, of
    which `panels_note` gives the names, the values only.
    """
    if len(other_keys(data)) > 1:
        return line_values(data)
    return [line_label(data.isel({LINE: number})) for number in range(data.sizes[LINE])]


def panels_note(data: xr.Dataset, what: str) -> str:
    """Return the names of the keys in the titles of "panels" or "rows"; see `panel_titles`."""
    return f"\n{what}: {line_keys(data)}" if len(other_keys(data)) > 1 else ""


def _amount(value: float, values: xr.DataArray) -> str:
    units = str(values.attrs.get("units", "1"))
    return f"{value:.4g}" if units == "1" else f"{value:.4g} {units}"


def panel_grid(count: int, *, height: float) -> tuple[Figure, Sequence[Axes]]:
    """Return a figure with a number of panels, in two columns from four panels on.

    Args:
        count: of panels, 1 to `MOST_PANELS`.
        height: of a panel [m].
    """
    columns = 2 if count >= 4 else 1
    rows = -(-count // columns)
    figure = new_figure(width=FULL_WIDTH, height=height * rows)
    grid = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    panels = [axes for row in grid for axes in row]
    for spare in panels[count:]:
        spare.remove()
    return figure, panels[:count]


def label_outer(panels: Sequence[Axes]) -> None:
    """Leave labels to the panels of `panel_grid` that have no other one below or to the left."""
    columns = 2 if len(panels) >= 4 else 1
    for number, axes in enumerate(panels):
        below, left = number + columns >= len(panels), number % columns == 0
        axes.tick_params(labelbottom=below, labelleft=left)
        if not below:
            axes.set_xlabel("")
