"""Regime of each point of a sweep, and how fast the motion grows or decays."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import NullLocator
from numpy.typing import NDArray

from bladewhirl.postprocess.energy.growth_rates import CERTAINTY
from bladewhirl.postprocess.fields.kinematics import Array
from bladewhirl.postprocess.plotting.legends import Group
from bladewhirl.postprocess.plotting.style import COLOURS, FULL_WIDTH, new_figure, styled
from bladewhirl.postprocess.sweep.axes import (
    edges_of,
    in_handy_units,
    key_axis,
    linear_threshold,
    threshold_ticks,
)
from bladewhirl.postprocess.sweep.drawing import (
    REGIME_COLOURS,
    REGIME_MARKS,
    Line,
    label_figure,
    line_keys,
    lines_group,
    lines_of,
    mark_entry,
)

NOT_JUDGED = "The marches are too short to judge growth: sustained is contact up to the end."

DIVERGES = (
    "Divergent: the amplitude (root of the mean strain energy of bladed disk and shaft springs) or"
    " its ripple grows beyond doubt over the last third, without slowing, to more than before."
)

MOST_MARKED = 24
"""Columns, and rows, of cells up to which each has the mark of its regime."""

HATCH = "//////"
"""Of cells without a result."""

Names = NDArray[np.str_]


@styled
def plot_regimes(data: xr.Dataset) -> Figure:
    """Draw the regime of every point as a strip for each line, and below it the growth rate.

    Bars reach to `regimes.CERTAINTY` standard errors. Points without a result are hatched.

    Args:
        data: from `sweep_quantities.regimes`.
    """
    data = in_handy_units(data)
    key, lines = str(data.attrs["along"]), list(lines_of(data))
    strips = 0.005 * len(lines) + 0.005
    judged = bool(np.isfinite(data["growth_rate"].values).any())
    entries = regime_entries(data["regime"].values)
    groups, note = [Group(entries, DIVERGES if judged else NOT_JUDGED)], ""
    if judged:
        figure = new_figure(width=FULL_WIDTH, height=0.08 + strips)
        upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(strips, 0.05))
        for line in lines:
            _draw_growth(lower, line, key)
        _scale_growth(lower, data)
        lower.axhline(0.0, color=COLOURS["total"], linewidth=0.6, zorder=1)
        lower.set_ylabel("growth rate [1/s]")
        groups.append(lines_group(data, lines, "growth_rate", marked=False))
        note = f", ± {CERTAINTY:g} standard errors"
    else:
        figure = new_figure(width=FULL_WIDTH, height=0.035 + strips)
        upper = lower = figure.subplots()
        data = data.assign_attrs(title="regime")
    _draw_strips(upper, lines, key)
    if len(lines) > 1:
        upper.set_title(f"rows: {line_keys(data)}", loc="left")
    key_axis(lower, data, cells=True)
    label_figure(figure, data, *groups, note=note)
    return figure


def _scale_growth(axes: Axes, data: xr.Dataset) -> None:
    """Make the axis of growth rates linear about zero only where a few are far larger."""
    rate, error = data["growth_rate"].values, data["growth_error"].values
    if threshold := linear_threshold(rate, error):
        reach = float(np.nanmax(np.abs(rate) + CERTAINTY * np.nan_to_num(error)))
        axes.set_yscale("symlog", linthresh=threshold)
        axes.set_yticks(threshold_ticks(threshold, reach))
        axes.yaxis.set_minor_locator(NullLocator())


def draw_regimes(axes: Axes, x: Array, y: Array, regime: Names) -> None:
    """Draw cells coloured by regime, with markers if they are few, hatched without data.

    Args:
        axes: that the cells fill.
        x: middles of the cells, (columns,).
        y: the same, (rows,).
        regime: names, (rows, columns).
    """
    codes = np.full(regime.shape, -1)
    for number, name in enumerate(REGIME_COLOURS):
        codes[regime == name] = number
    axes.grid(False)
    axes.patch.set(hatch=HATCH, edgecolor=COLOURS["rest"])
    axes.pcolormesh(
        edges_of(x),
        edges_of(y),
        np.ma.masked_less(codes, 0),
        cmap=ListedColormap(list(REGIME_COLOURS.values())),
        vmin=-0.5,
        vmax=len(REGIME_COLOURS) - 0.5,
        rasterized=True,
    )
    if max(regime.shape) > MOST_MARKED:
        return
    for name, mark in REGIME_MARKS.items():
        row, column = np.nonzero(regime == name)
        axes.plot(
            x[column], y[row], mark, color="black", markersize=2.5, scalex=False, scaley=False
        )


def regime_entries(regime: Names) -> list[tuple[Patch | tuple[Patch, Line2D], str]]:
    """Return the legend entries: the regimes with their numbers of points.

    Args:
        regime: names, of any shape.
    """
    entries: list[tuple[Patch | tuple[Patch, Line2D], str]] = []
    for name, colour in REGIME_COLOURS.items():
        if count := int(np.count_nonzero(regime == name)):
            mark = mark_entry(REGIME_MARKS[name], name)[0]
            entries.append(((Patch(color=colour), mark), f"{name}: {count}"))
    if rest := int(np.count_nonzero(~np.isin(regime, list(REGIME_COLOURS)))):
        hatched = Patch(fc="white", ec=COLOURS["rest"], hatch=HATCH)
        entries.append((hatched, f"no result: {rest}"))
    return entries


def _draw_strips(axes: Axes, lines: list[Line], key: str) -> None:
    place = lines[0].data[key].values
    rows = np.array([line.data["regime"].values for line in lines])
    at = np.arange(len(lines), dtype=np.float64)
    draw_regimes(axes, place, at, rows)
    axes.set(ylim=(-0.5, len(lines) - 0.5), yticks=at)
    axes.set_yticklabels([line.label or "regime" for line in lines])
    axes.invert_yaxis()


def _draw_growth(axes: Axes, line: Line, key: str) -> None:
    one = line.data
    place, rate = one[key].values, one["growth_rate"].values
    drawn, _, _ = axes.errorbar(
        place,
        rate,
        CERTAINTY * one["growth_error"].values,
        color=line.colour,
        linewidth=line.width,
        elinewidth=0.6 * line.width,
    )
    drawn.set_linestyle(line.dash)
    for name, mark in REGIME_MARKS.items():
        of_regime = one["regime"].values == name
        axes.plot(place[of_regime], rate[of_regime], mark, color=line.colour, markersize=line.size)
