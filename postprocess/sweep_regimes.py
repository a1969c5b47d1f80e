"""Regime of each point of a sweep, and how fast the motion grows or decays."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from numpy.typing import NDArray

from bladewhirl.postprocess.fields import Array
from bladewhirl.postprocess.regimes import CERTAINTY
from bladewhirl.postprocess.style import COLOURS, FULL_WIDTH, new_figure, styled
from bladewhirl.postprocess.sweep_drawing import (
    MOST_LINES,
    REGIME_COLOURS,
    REGIME_MARKS,
    Line,
    is_wide,
    key_axis,
    left_out_note,
    lines_of,
)
from bladewhirl.postprocess.sweep_quantities import LINE, cell_edges

CLEAR_RANGE = 30.0
"""Ratio of the largest growth to the median from which the axis is linear about zero only."""

NOT_JUDGED = "no growth rate: the marches are too short to judge it, or at rest"

HATCH = "//////"
"""Where there is no result."""

Names = NDArray[np.str_]


@styled
def plot_regimes(found: xr.Dataset) -> Figure:
    """Draw the regime of every point as a strip for each line, and below it the growth rate.

    Bars reach to `regimes.CERTAINTY` standard errors. Points without a result are hatched.

    Args:
        found: from `sweep_quantities.regimes`.
    """
    key, lines = str(found.attrs["along"]), list(lines_of(found))
    strips = 0.005 * len(lines) + 0.005
    figure = new_figure(width=FULL_WIDTH, height=0.08 + strips)
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(strips, 0.05))
    _draw_strips(upper, lines, key)
    for line in lines:
        _draw_growth(lower, line, key)
    rates = np.abs(found["growth_rate"].values)
    rates = rates[np.isfinite(rates) & (rates > 0)]
    if rates.size and rates.max() > CLEAR_RANGE * np.median(rates):
        lower.set_yscale("symlog", linthresh=float(np.median(rates)))
    if not rates.size:
        lower.text(0.5, 0.6, NOT_JUDGED, ha="center", transform=lower.transAxes)
        lower.set_yticks([0.0])
    lower.axhline(0.0, color=COLOURS["total"], linewidth=0.6, zorder=1)
    lower.set_ylabel("growth rate [1/s]")
    key_axis(lower, found)
    figure.suptitle(
        f"{found.attrs['title']}, ± {CERTAINTY:g} standard errors"
        + left_out_note(found.sizes[LINE], MOST_LINES)
    )
    handles: list[Artist] = [*regime_handles(found["regime"].values)]
    if len(lines) > 1:
        handles += lower.get_legend_handles_labels()[0]
    figure.legend(handles=handles, loc="outside lower center", ncols=5)
    return figure


def draw_regimes(axes: Axes, x_edges: Array, y_edges: Array, regime: Names) -> None:
    """Draw cells coloured by regime, hatched where there is none.

    Args:
        axes: that the cells fill.
        x_edges: borders of the cells, (columns + 1,).
        y_edges: the same, (rows + 1,).
        regime: names, (rows, columns).
    """
    codes = np.full(regime.shape, -1)
    for number, name in enumerate(REGIME_COLOURS):
        codes[regime == name] = number
    axes.grid(False)
    axes.patch.set(hatch=HATCH, edgecolor=COLOURS["rest"])
    axes.pcolormesh(
        x_edges,
        y_edges,
        np.ma.masked_less(codes, 0),
        cmap=ListedColormap(list(REGIME_COLOURS.values())),
        vmin=-0.5,
        vmax=len(REGIME_COLOURS) - 0.5,
        rasterized=True,
    )


def regime_handles(regime: Names) -> list[Patch]:
    """Entries of a legend: the regimes that there are, with how many points each has."""
    handles = [
        Patch(color=colour, label=f"{name}: {np.count_nonzero(regime == name)}")
        for name, colour in REGIME_COLOURS.items()
        if (regime == name).any()
    ]
    if rest := int(np.count_nonzero(~np.isin(regime, list(REGIME_COLOURS)))):
        label = f"no result: {rest}"
        handles.append(Patch(fc="white", ec=COLOURS["rest"], hatch=HATCH, label=label))
    return handles


def _draw_strips(axes: Axes, lines: list[Line], key: str) -> None:
    place = lines[0].data[key].values
    edges = cell_edges(place, logarithmic=is_wide(place))
    rows = np.array([line.data["regime"].values for line in lines])
    draw_regimes(axes, edges, np.arange(len(lines) + 1, dtype=np.float64) - 0.5, rows)
    axes.set(xlim=edges[[0, -1]], yticks=np.arange(len(lines)))
    axes.set_yticklabels([line.label or "regime" for line in lines])
    axes.invert_yaxis()


def _draw_growth(axes: Axes, line: Line, key: str) -> None:
    one = line.data
    place, rate = one[key].values, one["growth_rate"].values
    axes.errorbar(
        place,
        rate,
        CERTAINTY * one["growth_error"].values,
        color=line.colour,
        linewidth=0.8,
        elinewidth=0.8,
        label=line.label,
    )
    for name, mark in REGIME_MARKS.items():
        own = one["regime"].values == name
        axes.plot(place[own], rate[own], mark, color=line.colour, markersize=3.5)
