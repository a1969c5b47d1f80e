"""Maps of a sweep to point at: spectra over a swept key, and every point with its numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from bladewhirl.postprocess.energy.growth_rates import CERTAINTY, rate_text
from bladewhirl.postprocess.fields.kinematics import Array
from bladewhirl.postprocess.reports.interactive import (
    COLOUR_SCALE,
    LEGEND_BELOW,
    Plot,
    buttons,
    colour_bar,
    plain_layout,
)
from bladewhirl.postprocess.reports.page import Explorer
from bladewhirl.postprocess.shaft.orbits import MILLI
from bladewhirl.postprocess.sweep.axes import in_handy_units, is_wide, key_label
from bladewhirl.postprocess.sweep.drawing import REGIME_COLOURS, line_label
from bladewhirl.postprocess.sweep.frequency_map import DECADES, LINES
from bladewhirl.postprocess.sweep.quantities import LINE, cell_edges

MOST_ROWS, MOST_COLUMNS = 500, 500
"""Frequencies and points of a map at most: of more, each cell is the largest of neighbours."""

SYMBOLS: Mapping[str, str] = {
    "no-contact": "circle-open",
    "damped": "triangle-down",
    "sustained": "circle",
    "divergent": "triangle-up",
}

MODE_DASHES: Mapping[str, str] = {
    "suspension": "longdash",
    "1F k=1": "dash",
    "casing k=1": "dashdot",
}
"""Of the lines of modes."""

MAP_CAPTION = (
    "Amplitude of the shaft [mm] over the swept key and frequency, forward upwards, rotating "
    "frame, as colour on a logarithmic scale; dotted: engine orders, broken: modes of one nodal "
    "diameter. Point at it for the numbers, drag to zoom in, double-click to see all, click names "
    "to hide lines. Look for a band that leaves an engine order and locks onto a mode."
)

POINTS_CAPTION = (
    "Every point of the sweep: largest displacement of the shaft [mm] over the swept key, coloured "
    "and shaped by regime. Point at one for its numbers, growth rates ± "
    f"{CERTAINTY:g} standard errors; click a regime's name to hide it. An end at the displacement "
    "limit bounds what a divergent point shows."
)

REGIME_MAP_CAPTION = (
    "Regime over the two swept keys. Point at a cell for its numbers, growth rates ± "
    f"{CERTAINTY:g} standard errors; look for where one regime borders on another."
)


def frequency_explorer(maps: xr.Dataset) -> Explorer:
    """Spectra over the swept key; where other keys are swept too, a button shows another line.

    Args:
        maps: from `frequency_map.frequency_map`.
    """
    maps = in_handy_units(maps)
    in_multiples = maps["frequency"].attrs["units"] == "1"
    unit = "/ ω₁" if in_multiples else "[Hz]"
    top = np.log10(np.nanmax(MILLI * maps["amplitude"].values, initial=0.0) or 1.0)
    traces: list[Any] = []
    owner: list[int] = []
    for number in range(maps.sizes[LINE]):
        own = _map_traces(maps.isel({LINE: number}), top, shown=number == 0)
        traces += own
        owner += [number] * len(own)
    limit = float(np.abs(cell_edges(maps["frequency"].values, logarithmic=False)).max())
    labels = [line_label(maps.isel({LINE: number})) for number in range(maps.sizes[LINE])]
    key = maps[str(maps.attrs["along"])]
    layout = plain_layout(
        xaxis=_key_axis(key),
        yaxis={
            "title": {"text": f"frequency {unit}, forward positive"},
            "range": [-limit, limit],
            "showgrid": False,
        },
        legend=LEGEND_BELOW,
        updatemenus=buttons(labels, owner),
    )
    return Explorer(
        name="frequency-explorer",
        title="Frequency map",
        caption=MAP_CAPTION,
        plots=[Plot(traces=traces, layout=layout)],
    )


def points_explorer(points: xr.Dataset) -> Explorer:
    """Largest displacement of the shaft over the swept key, every point with its numbers.

    Args:
        points: over (line, key): `regime`, `shaft_radius_max` [m], `growth_rate` and
            `growth_error` [1/s], `end_time` [s], `touched` [1], as `sweep_report` has them.
    """
    points = in_handy_units(points)
    key = points[str(points.attrs["along"])]
    regime, words = points["regime"].values, _words(points)
    place = np.broadcast_to(key.values, regime.shape)
    radius = MILLI * points["shaft_radius_max"].values
    traces = [
        {
            "type": "scatter",
            "x": place[own],
            "y": radius[own],
            "mode": "markers",
            "name": f"{name} ({np.count_nonzero(own)})",
            "marker": {"color": colour, "symbol": SYMBOLS[name], "size": 9, "line": {"width": 1.5}},
            "text": words[own],
            "hovertemplate": "%{text}<extra></extra>",
        }
        for name, colour in REGIME_COLOURS.items()
        if (own := regime == name).any()
    ]
    spread = radius[radius > 0]
    wide = spread.size > 0 and is_wide(spread)
    layout = plain_layout(
        xaxis=_key_axis(key),
        yaxis={
            "title": {"text": "largest shaft displacement [mm]"},
            "type": "log" if wide else "linear",
            **({} if wide else {"rangemode": "tozero"}),
        },
        legend=LEGEND_BELOW,
        showlegend=True,
    )
    return Explorer(
        name="points-explorer",
        title="Every point",
        caption=POINTS_CAPTION,
        plots=[Plot(traces=traces, layout=layout)],
    )


def regime_explorer(points: xr.Dataset, other: str) -> Explorer:
    """Regime over two swept keys, every point with its numbers.

    Args:
        points: as `points_explorer` takes it.
        other: the other swept key.
    """
    points = in_handy_units(points)
    key = points[str(points.attrs["along"])]
    names = list(REGIME_COLOURS)
    regime = points["regime"].values
    code = np.select([regime == name for name in names], range(len(names)), np.nan)
    share = np.linspace(0.0, 1.0, len(names) + 1)
    scale = [
        [float(edge), colour]
        for colour, low, high in zip(REGIME_COLOURS.values(), share[:-1], share[1:], strict=True)
        for edge in (low, high)
    ]
    # Heatmaps space their cells by the values; categories would hide how far apart they are.
    heat = {
        "type": "heatmap",
        "x": key.values,
        "y": points[other].values,
        "z": code,
        "zmin": -0.5,
        "zmax": len(names) - 0.5,
        "colorscale": scale,
        "colorbar": {"tickvals": list(range(len(names))), "ticktext": names, "thickness": 14},
        "text": _words(points),
        "hovertemplate": "%{text}<extra></extra>",
        "xgap": 1,
        "ygap": 1,
    }
    layout = plain_layout(
        xaxis={**_key_axis(key), "showgrid": False},
        yaxis={**_key_axis(points[other]), "showgrid": False},
    )
    return Explorer(
        name="regime-explorer",
        title="Regime map",
        caption=REGIME_MAP_CAPTION,
        plots=[Plot(traces=[heat], layout=layout)],
    )


def _map_traces(one: xr.Dataset, top: float, *, shown: bool) -> Sequence[Any]:
    key = str(one.attrs["along"])
    place = _thinned(one[key].values, MOST_COLUMNS, np.maximum, 0)
    frequency = one["frequency"].values
    starts = _starts(len(frequency), MOST_ROWS)
    middle = np.add.reduceat(frequency, starts) / np.diff(starts, append=len(frequency))
    amplitude = _thinned(MILLI * one["amplitude"].values, MOST_COLUMNS, np.fmax, 0)
    amplitude = np.fmax.reduceat(amplitude, starts, axis=1).T
    floor = 10.0 ** (top - DECADES)
    ticks = np.arange(np.ceil(top - DECADES), np.floor(top) + 1)
    traces: list[Any] = [
        {
            "type": "heatmap",
            "x": place,
            "y": middle,
            "z": np.log10(np.maximum(amplitude, floor)),
            "zmin": top - DECADES,
            "zmax": top,
            "colorscale": COLOUR_SCALE,
            "colorbar": {
                **colour_bar("amplitude of the shaft [mm]"),
                "tickvals": ticks.tolist(),
                "ticktext": [f"{10.0**tick:g}" for tick in ticks],
            },
            "customdata": amplitude,
            "hoverongaps": False,
            "hovertemplate": (
                "%{x:.5g}, frequency %{y:.4g}<br>amplitude %{customdata:.3g} mm<extra></extra>"
            ),
            "visible": shown,
        }
    ]
    known = one.isel({key: np.flatnonzero(np.isfinite(one["engine_order"][:, 0].values))})
    along = known[key].values

    def line(level: Array, name: str, group: str, look: Mapping[str, Any], legend: bool) -> Any:
        return {
            "type": "scatter",
            "x": along,
            "y": level,
            "mode": "lines",
            "line": look,
            "name": group,
            "legendgroup": group,
            "showlegend": legend,
            "visible": shown,
            "hovertemplate": f"{name}: %{{y:.4g}}<extra></extra>",
        }

    named = "engine orders"
    for order in known["order"].values:
        level = known["engine_order"].sel(order=order).values
        look = {"color": "#ffffff", "dash": "dot", "width": 1}
        traces.append(line(level, f"{order:+d} Ω", named, look, False))
    # White lines would not be seen in the legend, which is on white.
    look = {"color": "#5b6575", "dash": "dot", "width": 1.5}
    traces.append(line(np.full(len(along), np.nan), named, named, look, True))
    for name, (colour, _) in LINES.items():
        for way in ("backward", "forward"):
            level = known["mode_line"].sel(mode=name, direction=way).values
            look = {"color": colour, "dash": MODE_DASHES[name], "width": 1.5}
            traces.append(line(level, f"{name}, {way}", name, look, way == "forward"))
    return traces


def _words(points: xr.Dataset) -> Any:
    """Words for every point, (line, key)."""
    key = points[str(points.attrs["along"])]
    names = [line_label(points.isel({LINE: number})) for number in range(points.sizes[LINE])]
    unit = "" if key.attrs["units"] == "1" else f" {key.attrs['units']}"
    words = np.empty(points["regime"].shape, dtype=object)
    column = {str(name): points[name].values for name in points.data_vars}
    for at in np.ndindex(words.shape):
        own = {name: values[at] for name, values in column.items() if values.ndim == 2}
        done = own["state"] == "done"
        lines = [
            f"<b>{own['regime'] if done else own['state']}</b>",
            f"{key.attrs['long_name']} = {key.values[at[1]]:.6g}{unit}",
            names[at[0]],
        ]
        if done:
            rate, error = float(own["growth_rate"]), float(own["growth_error"])
            judged = f"{rate_text(rate, error)} 1/s" if np.isfinite(rate) else "not to be judged"
            lines += [
                f"largest shaft displacement {MILLI * own['shaft_radius_max']:.4g} mm",
                f"growth rate {judged}",
                f"blades that touched {own['touched']:.0f}",
                f"end {own['end_time']:.4g} s",
            ]
        words[at] = "<br>".join(filter(None, lines))
    return words


def _key_axis(values: xr.DataArray) -> dict[str, Any]:
    return {
        "title": {"text": key_label(values)},
        "type": "log" if is_wide(values.values) else "linear",
    }


def _starts(count: int, most: int) -> Any:
    """First of each of so many groups of neighbours at most."""
    return np.unique(np.arange(min(count, most)) * count // min(count, most))


def _thinned(values: Array, most: int, reduce: np.ufunc, axis: int) -> Array:
    return np.asarray(reduce.reduceat(values, _starts(values.shape[axis], most), axis=axis))
