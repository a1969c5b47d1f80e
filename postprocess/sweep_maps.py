"""Maps over two swept keys: regime, largest displacement of the shaft, growth rate."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import LogNorm, Normalize, SymLogNorm
from matplotlib.figure import Figure

from bladewhirl.postprocess.fields import Array, ViewError
from bladewhirl.postprocess.orbits import MILLI
from bladewhirl.postprocess.style import COLOURS, FULL_WIDTH, SEQUENTIAL, new_figure, styled
from bladewhirl.postprocess.sweep_blades import MOST_ROWS
from bladewhirl.postprocess.sweep_drawing import (
    chosen,
    is_wide,
    key_axis,
    left_out_note,
    line_label,
)
from bladewhirl.postprocess.sweep_quantities import LINE, as_lines, cell_edges, in_order
from bladewhirl.postprocess.sweep_regimes import HATCH, draw_regimes, regime_handles
from bladewhirl.postprocess.sweep_result import swept

DIVERGING = "PuOr_r"
"""Colours on both sides of zero: told apart by colour-blind readers."""

CLEAR_RANGE = 30.0
"""Ratio of the largest value to the median from which colours are logarithmic."""


def sweep_maps(dataset: xr.Dataset, key: str) -> xr.Dataset:
    """Regime, largest displacement [m] and growth rate [1/s] over two swept keys.

    Args:
        dataset: from `open_sweep`, of two swept keys or more.
        key: the horizontal one; the vertical one is the next in order, all others make lines.

    Returns:
        over (line, vertical key, key): `regime`, `shaft_radius_max`, `growth_rate`; attributes
        `along` and `across`.

    Raises:
        ViewError: one key only, or no point is done.
    """
    others = [name for name in swept(dataset) if name != key]
    if not others:
        raise ViewError("maps need two swept keys, this sweep is over one")
    across, *lines = others
    found = in_order(dataset, ["regime", "shaft_radius_max", "growth_rate"])
    return (
        as_lines(found, lines)
        .transpose(LINE, across, key)
        .assign_attrs(title="regime, displacement of the shaft, growth", along=key, across=across)
    )


@styled
def plot_sweep_maps(maps: xr.Dataset) -> Figure:
    """Draw maps from `sweep_maps`, a row for each combination of further keys.

    There is no map of the growth rate where it can't be judged anywhere.
    """
    shown = chosen(maps.sizes[LINE], MOST_ROWS)
    radius, growth = MILLI * maps["shaft_radius_max"].values, maps["growth_rate"].values
    pictures = [_Picture(radius, "largest radius [mm]", SEQUENTIAL, _of_magnitudes(radius))]
    if np.isfinite(growth).any():
        pictures.append(_Picture(growth, "growth rate [1/s]", DIVERGING, _about_zero(growth)))
    figure = new_figure(width=FULL_WIDTH, height=0.03 + 0.05 * len(shown))
    columns = 1 + len(pictures)
    rows = figure.subplots(len(shown), columns, sharex=True, sharey=True, squeeze=False)
    across = str(maps.attrs["across"])
    x, y = (_edges(maps[name].values) for name in (str(maps.attrs["along"]), across))
    for number, row in zip(shown, rows, strict=True):
        one = maps.isel({LINE: number})
        draw_regimes(row[0], x, y, one["regime"].values)
        key_axis(row[0], maps, of_y=True, key=across)
        if label := line_label(one):
            row[0].set_title(label)
        drawn = [
            _draw_values(axes, x, y, number, picture)
            for axes, picture in zip(row[1:], pictures, strict=True)
        ]
    for axes in rows[-1]:
        key_axis(axes, maps)
    for column, picture in enumerate(pictures):
        figure.colorbar(
            drawn[column],
            ax=rows[:, 1 + column].tolist(),
            label=picture.label,
            location="top",
            aspect=30,
            pad=0.02,
        )
    figure.suptitle(maps.attrs["title"] + left_out_note(maps.sizes[LINE], MOST_ROWS))
    handles = regime_handles(maps["regime"].values)
    figure.legend(handles=handles, loc="outside lower center", ncols=5)
    return figure


class _Picture(NamedTuple):
    """A quantity, and how it is coloured."""

    values: Array  #: (line, vertical, horizontal)
    label: str
    colours: str
    norm: Normalize


def _draw_values(axes: Axes, x: Array, y: Array, line: int, picture: _Picture) -> QuadMesh:
    axes.grid(False)
    axes.patch.set(hatch=HATCH, edgecolor=COLOURS["rest"])
    return axes.pcolormesh(
        x, y, picture.values[line], cmap=picture.colours, norm=picture.norm, rasterized=True
    )


def _edges(values: Array) -> Array:
    return cell_edges(values, logarithmic=is_wide(values))


def _of_magnitudes(values: Array) -> Normalize:
    """From zero; logarithmic where a few values would leave the rest dark."""
    known = values[np.isfinite(values) & (values > 0)]
    if not known.size:
        return Normalize(0.0, 1.0)
    if known.max() > CLEAR_RANGE * np.median(known):
        return LogNorm(known.min(), known.max())
    return Normalize(0.0, known.max())


def _about_zero(values: Array) -> Normalize:
    """The same on both sides of zero; nearly linear below the median where a few are far larger."""
    known = np.abs(values[np.isfinite(values) & (values != 0)])
    if not known.size:
        return Normalize(-1.0, 1.0)
    top, usual = float(known.max()), float(np.median(known))
    if top > CLEAR_RANGE * usual:
        return SymLogNorm(usual, vmin=-top, vmax=top)
    return Normalize(-top, top)
