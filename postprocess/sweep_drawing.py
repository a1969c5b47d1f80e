"""What the figures of sweeps have in common: axes, names of lines, colours of regimes, panels."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import matplotlib
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bladewhirl.postprocess.fields import Array
from bladewhirl.postprocess.style import COLOURS, FULL_WIDTH, SEQUENTIAL, new_figure
from bladewhirl.postprocess.sweep_quantities import LINE

MOST_LINES = 8
"""Lines in a figure: more are not told apart."""

MOST_PANELS = 6
"""Panels of a figure that has one for each line."""

WIDE_RANGE = 50.0
"""Ratio of the largest to the smallest value of a key from which its axis is logarithmic."""

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


class Line(NamedTuple):
    """One line of points, and how it is drawn."""

    data: xr.Dataset
    colour: Any
    label: str  #: values of the other keys; empty where there are none


def lines_of(data: xr.Dataset) -> Iterator[Line]:
    """The lines that a figure shows: `MOST_LINES` at most, evenly chosen."""
    count = data.sizes[LINE]
    shown = chosen(count, MOST_LINES)
    shades = matplotlib.colormaps[SEQUENTIAL](np.linspace(0.0, 0.85, len(shown)))
    colours = [COLOURS["rotor"]] if len(shown) == 1 else list(shades)
    for number, colour in zip(shown, colours, strict=True):
        one = data.isel({LINE: number})
        yield Line(one, colour, line_label(one))


def chosen(count: int, most: int) -> list[int]:
    """All of so many, or the first, the last and others evenly between them."""
    spread = np.linspace(0, count - 1, min(count, most))
    return [int(number) for number in spread.round()]


def left_out_note(count: int, most: int) -> str:
    """What a title says of lines that are not drawn."""
    return f" ({most} of {count} lines, the others are in the data)" if count > most else ""


def line_label(one: xr.Dataset) -> str:
    """Values of the other keys of a line, in words."""
    return ", ".join(
        f"{values.attrs.get('long_name', name)} = {float(values):.4g}{_unit(values)}"
        for name, values in one.coords.items()
        if values.ndim == 0 and "long_name" in values.attrs
    )


def _unit(values: xr.DataArray) -> str:
    units = str(values.attrs.get("units", "1"))
    return "" if units == "1" else f" {units}"


def key_axis(axes: Axes, data: xr.Dataset, *, of_y: bool = False, key: str = "") -> None:
    """Label an axis with a swept key, and make it logarithmic where its values ask for it."""
    values = data[key or str(data.attrs["along"])]
    scale = "log" if is_wide(values.values) else "linear"
    if of_y:
        axes.set(ylabel=key_label(values), yscale=scale)
    else:
        axes.set(xlabel=key_label(values), xscale=scale)


def is_wide(values: Array) -> bool:
    """Whether values are better seen on a logarithmic axis."""
    return bool(np.min(values) > 0 and np.max(values) >= WIDE_RANGE * np.min(values))


def key_label(values: xr.DataArray) -> str:
    """Name of a swept key with its unit."""
    name, units = str(values.attrs["long_name"]), str(values.attrs["units"])
    if name == "march.speed" and units == "1":
        return "speed Ω / reference frequency"
    return name if units == "1" else f"{name} [{units}]"


def panel_grid(count: int, *, height: float) -> tuple[Figure, Sequence[Axes]]:
    """A figure of so many panels with none left empty: two columns where that comes out even.

    Args:
        count: of panels, 1 to `MOST_PANELS`.
        height: of a panel [m].
    """
    columns = 2 if count >= 4 and count % 2 == 0 else 1
    rows = count // columns
    figure = new_figure(width=FULL_WIDTH, height=height * rows)
    grid = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    return figure, [axes for row in grid for axes in row]
