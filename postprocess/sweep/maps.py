"""Maps over two swept keys: regime, largest displacement of the shaft, growth rate."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import PatchCollection, QuadMesh
from matplotlib.colors import LogNorm, Normalize, SymLogNorm
from matplotlib.figure import Figure
from matplotlib.patches import Patch, Rectangle
from matplotlib.ticker import FixedLocator, Locator, MaxNLocator, NullLocator
from numpy.typing import NDArray

from bladewhirl.models.inputs.units import handy_unit
from bladewhirl.postprocess.energy.growth_rates import CERTAINTY
from bladewhirl.postprocess.fields.kinematics import Array, ViewError
from bladewhirl.postprocess.plotting.axes import SPEED
from bladewhirl.postprocess.plotting.legends import Group, legends_below
from bladewhirl.postprocess.plotting.style import (
    COLOURS,
    FULL_WIDTH,
    SEQUENTIAL,
    new_figure,
    styled,
)
from bladewhirl.postprocess.plotting.titles import set_title
from bladewhirl.postprocess.sweep.axes import (
    edges_of,
    in_handy_units,
    key_axis,
    key_label,
    linear_threshold,
    rpm_on_top,
    threshold_ticks,
)
from bladewhirl.postprocess.sweep.dataset import swept
from bladewhirl.postprocess.sweep.drawing import (
    MOST_ROWS,
    chosen,
    left_out_note,
    panel_titles,
    panels_note,
)
from bladewhirl.postprocess.sweep.quantities import LINE, as_lines, in_order
from bladewhirl.postprocess.sweep.regimes import HATCH, NOT_JUDGED, draw_regimes, regime_entries

DIVERGING = "PuOr_r"
"""Colours on both sides of zero: told apart by colour-blind readers."""

CLEAR_RANGE = 30.0
"""Ratio of the largest value to the median from which colours are logarithmic."""

DOUBTFUL_HATCH, DOUBTFUL_COLOUR = "xxx", "#777777"
"""Look of cells whose growth rate is too uncertain to tell its sign."""

DOUBTFUL = "growth rate within two standard errors of zero"


def sweep_maps(dataset: xr.Dataset, key: str) -> xr.Dataset:
    """Regime, largest displacement [m] and growth rate [1/s] over two swept keys.

    Args:
        dataset: from `open_sweep`, of two swept keys or more.
        key: the horizontal one; the vertical one is the next in order, all others make lines.

    Returns:
        over (line, vertical key, key): `regime`, `shaft_radius_max`, `growth_rate` and its standard
        error `growth_error`; attributes `along` and `across`.

    Raises:
        ViewError: one key only, or no point is done.
    """
    others = [name for name in swept(dataset) if name != key]
    if not others:
        raise ViewError("maps need two swept keys, this sweep is over one")
    across, *lines = others
    data = in_order(dataset, ["regime", "shaft_radius_max", "growth_rate", "growth_error"])
    growth = ", growth" if np.isfinite(data["growth_rate"].values).any() else ""
    return (
        as_lines(data, lines)
        .transpose(LINE, across, key)
        .assign_attrs(title="regime, displacement of the shaft" + growth, along=key, across=across)
    )


@styled
def plot_sweep_maps(maps: xr.Dataset) -> Figure:
    """Draw maps from `sweep_maps`, a row for each combination of further keys.

    Growth rates within `regimes.CERTAINTY` standard errors of zero are crossed out. There is no
    map of the growth rate where it can't be judged anywhere.
    """
    maps = in_handy_units(maps)
    shown = chosen(maps.sizes[LINE], MOST_ROWS)
    unit, scale = handy_unit(float(maps["shaft_radius_max"].max().fillna(0.0)), "m")
    radius = scale * maps["shaft_radius_max"].values
    growth, error = maps["growth_rate"].values, maps["growth_error"].values
    pictures = [_Picture(radius, f"largest radius [{unit}]", SEQUENTIAL, *_of_magnitudes(radius))]
    doubtful = np.abs(growth) <= CERTAINTY * error
    if np.isfinite(growth).any():
        rate_colours = _rate_colours(growth, error)
        pictures.append(_Picture(growth, "growth rate [1/s]", DIVERGING, *rate_colours))
    figure = new_figure(width=FULL_WIDTH, height=0.04 + 0.05 * len(shown))
    columns = 1 + len(pictures)
    rows = figure.subplots(len(shown), columns, sharex=True, sharey=True, squeeze=False)
    across = str(maps.attrs["across"])
    along = str(maps.attrs["along"])
    beside, up = maps[along].values, maps[across].values
    x, y = edges_of(beside), edges_of(up)
    titles = panel_titles(maps)
    for number, row in zip(shown, rows, strict=True):
        draw_regimes(row[0], beside, up, maps["regime"].values[number])
        key_axis(row[0], maps, of_y=True, key=across, cells=True, share=0.5)
        if titles[number]:
            row[0].set_title(titles[number], loc="left")
        drawn = [
            _draw_values(axes, x, y, number, picture)
            for axes, picture in zip(row[1:], pictures, strict=True)
        ]
        if len(pictures) > 1:
            _cross_out(row[2], x, y, doubtful[number])
    for axes in rows[-1]:
        key_axis(axes, maps, cells=True, share=1.3 / columns)
    rpm_on_top(maps, *rows[0])
    of_speed = key_label(maps[along]) == SPEED
    for column, picture in enumerate(pictures):
        bar = figure.colorbar(
            drawn[column],
            ax=rows[:, 1 + column].tolist(),
            label=picture.label,
            location="top",
            aspect=30,
            pad=0.02 + (0.14 / len(shown) if of_speed else 0.0),  # over its axis in rpm
        )
        if picture.ticks is not None:
            bar.set_ticks(picture.ticks)
            bar.ax.xaxis.set_minor_locator(NullLocator())
    set_title(
        figure,
        maps.attrs["case"],
        maps.attrs["title"]
        + left_out_note(maps.sizes[LINE], MOST_ROWS)
        + panels_note(maps, "rows"),
    )
    crossed = Patch(fc="white", ec=DOUBTFUL_COLOUR, hatch=DOUBTFUL_HATCH, lw=0.0)
    legends_below(
        figure,
        Group(
            [
                *regime_entries(maps["regime"].values),
                *([(crossed, DOUBTFUL)] if doubtful[shown].any() else []),
            ],
            "" if len(pictures) > 1 else NOT_JUDGED,
        ),
    )
    return figure


class _Picture(NamedTuple):
    """A quantity, and how it is coloured."""

    values: Array  #: (line, vertical, horizontal)
    label: str
    colours: str
    norm: Normalize
    ticks: Locator | None  #: of the bar of colours; None for the usual ones


def _draw_values(axes: Axes, x: Array, y: Array, line: int, picture: _Picture) -> QuadMesh:
    axes.grid(False)
    axes.patch.set(hatch=HATCH, edgecolor=COLOURS["rest"])
    return axes.pcolormesh(
        x, y, picture.values[line], cmap=picture.colours, norm=picture.norm, rasterized=True
    )


def _cross_out(axes: Axes, x: Array, y: Array, cells: NDArray[np.bool_]) -> None:
    """Make cells pale and cross them out; `cells` is (rows, columns)."""
    boxes = [
        Rectangle((x[column], y[row]), x[column + 1] - x[column], y[row + 1] - y[row])
        for row, column in np.argwhere(cells)
    ]
    pale = PatchCollection(boxes, facecolor="white", alpha=0.5, linewidth=0.0, rasterized=True)
    crosses = PatchCollection(
        boxes,
        facecolor="none",
        edgecolor=DOUBTFUL_COLOUR,
        hatch=DOUBTFUL_HATCH,
        linewidth=0.0,
        rasterized=True,
    )
    for collection in (pale, crosses):
        axes.add_collection(collection, autolim=False)


def _of_magnitudes(values: Array) -> tuple[Normalize, Locator | None]:
    """Return a colour scale from the smallest value, logarithmic if a few values would darken the
    rest."""
    known = values[np.isfinite(values) & (values > 0)]
    if not known.size:
        return Normalize(0.0, 1.0), MaxNLocator(4)
    if known.max() > CLEAR_RANGE * np.median(known):
        return LogNorm(known.min(), known.max()), None
    least = known.min() if np.ptp(known) > 0 else 0.0
    return Normalize(least, known.max()), MaxNLocator(4)


def _rate_colours(rate: Array, error: Array) -> tuple[Normalize, Locator]:
    """Return a colour scale symmetric about zero, linear near it only if a few rates are far
    larger."""
    top = float(np.nanmax(np.abs(rate))) or 1.0
    if threshold := linear_threshold(rate, error):
        ticks = FixedLocator(threshold_ticks(threshold, top))
        return SymLogNorm(threshold, vmin=-top, vmax=top), ticks
    return Normalize(-top, top), MaxNLocator(4, symmetric=True)
