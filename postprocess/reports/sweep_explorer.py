"""Interactive plots of a sweep: spectra against a swept key, and all points with their details."""

from typing import Any

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from bladewhirl.postprocess.energy.growth_rates import CERTAINTY, rate_text
from bladewhirl.postprocess.fields.kinematics import Array
from bladewhirl.postprocess.plotting.axes import cell_edges
from bladewhirl.postprocess.reports.interactive import COLOUR_SCALE, buttons, colour_bar, plot
from bladewhirl.postprocess.reports.page import Explorer
from bladewhirl.postprocess.shaft.orbits import MILLI
from bladewhirl.postprocess.sweep.dataset import POINT
from bladewhirl.postprocess.sweep.drawing import (
    REGIME_COLOURS,
    in_handy_units,
    is_wide,
    key_label,
    line_label,
)
from bladewhirl.postprocess.sweep.frequency_map import DECADES, LINES
from bladewhirl.postprocess.sweep.quantities import LINE, table_keys

MOST_ROWS, MOST_COLUMNS = 500, 500
"""Largest number of frequencies and largest number of points in a map. If a spectrum has more,
neighbours share a cell of the map, which has their largest value."""

#: marks of the regimes, and dashes of the lines of modes
SYMBOLS = ("circle-open", "triangle-down", "circle", "triangle-up")
DASHES = ("longdash", "dash", "dashdot")

MAP_CAPTION = (
    "Amplitude of the shaft [mm], as colour on a logarithmic scale, against the swept key and "
    "the frequency in the rotating frame, forward positive. Dotted lines are engine orders, dashed "
    "lines are modes with one nodal diameter. Point at the map for numbers, drag to zoom in, "
    "double-click to reset, click names to hide lines. Look for a band of large amplitudes that "
    "leaves an engine order and follows a mode."
)

POINTS_CAPTION = (
    "Largest displacement of the shaft [mm] at every point of the sweep, against the swept key; "
    "the colour and the shape of a mark show the regime. Point at a mark for its numbers; growth "
    f"rates are ± {CERTAINTY:g} standard errors. Click the name of a regime to hide its points. "
    "Divergent marches end at the displacement limit, so their displacements are not maxima."
)


def frequency_explorer(maps: xr.Dataset) -> Explorer:
    """Return a plot of the spectra from `frequency_map` against a swept key. With further swept
    keys, buttons select the combination of their values."""
    maps = in_handy_units(maps)
    unit = "/ ω₁" if maps["frequency"].attrs["units"] == "1" else "[Hz]"
    title = f"frequency {unit}, forward positive"
    top = np.log10(np.nanmax(MILLI * maps["amplitude"].values, initial=0.0) or 1.0)
    lines = [maps.isel({LINE: number}) for number in range(maps.sizes[LINE])]
    traces = [_map_traces(line, top, shown=number == 0) for number, line in enumerate(lines)]
    owner = [number for number, group in enumerate(traces) for _ in group]
    limit = float(np.abs(cell_edges(maps["frequency"].values, logarithmic=False)).max())
    figure = plot(
        [trace for group in traces for trace in group],
        xaxis=_key_axis(maps[str(maps.attrs["along"])]),
        yaxis={"title_text": title, "range": [-limit, limit], "showgrid": False},
        updatemenus=buttons([line_label(line) for line in lines], owner),
    )
    return Explorer(
        name="frequency-explorer", title="Frequency map", caption=MAP_CAPTION, plots=[figure]
    )


def points_explorer(points: xr.Dataset) -> Explorer:
    """Return a plot of the largest displacement, of the shaft or of a contact node, at every point
    against a swept key.

    Args:
        points: quantities over (line, key), see `sweep.quantities`: `regime`,
            `largest_displacement` [m], `growth_rate` and `growth_error` [1/s], `end_time` [s],
            number of blades `touched`.
    """
    points = in_handy_units(points)
    key = points[str(points.attrs["along"])]
    regime, texts = points["regime"].values, _texts(points)
    keys = np.broadcast_to(key.values, regime.shape)
    radius = MILLI * points["largest_displacement"].values
    traces = [
        go.Scatter(
            x=keys[here],
            y=radius[here],
            mode="markers",
            name=f"{name} ({np.count_nonzero(here)})",
            marker={"color": colour, "symbol": symbol, "size": 9, "line_width": 1.5},
            text=texts[here],
            hovertemplate="%{text}<extra></extra>",
        )
        for (name, colour), symbol in zip(REGIME_COLOURS.items(), SYMBOLS, strict=True)
        if (here := regime == name).any()
    ]
    positive = radius[radius > 0]
    wide = positive.size > 0 and is_wide(positive)
    figure = plot(
        traces,
        xaxis=_key_axis(key),
        yaxis={
            "title_text": f"largest recorded displacement of the {points.attrs['moving']} [mm]",
            "type": "log" if wide else "linear",
            "rangemode": "normal" if wide else "tozero",
        },
        showlegend=True,
    )
    return Explorer(
        name="points-explorer", title="Every point", caption=POINTS_CAPTION, plots=[figure]
    )


def _map_traces(line: xr.Dataset, top: float, *, shown: bool) -> list[go.Heatmap | go.Scatter]:
    """Return the traces of a map: amplitudes, engine orders and modes.

    Args:
        line: data from `frequency_map` for one combination of values of the other swept keys.
        top: decimal logarithm of the largest amplitude of all maps [mm].
        shown: true for the map that is visible at first.
    """
    key = str(line.attrs["along"])
    rows, columns = (
        np.unique(np.arange(min(size, most)) * size // min(size, most))  # starts of groups
        for size, most in ((line.sizes["frequency"], MOST_ROWS), (line.sizes[key], MOST_COLUMNS))
    )
    frequency = line["frequency"].values
    amplitude = np.fmax.reduceat(MILLI * line["amplitude"].values, columns, axis=0)
    amplitude = np.fmax.reduceat(amplitude, rows, axis=1).T.astype(np.float32)
    ticks = np.arange(np.ceil(top - DECADES), np.floor(top) + 1)
    heat = go.Heatmap(
        x=np.maximum.reduceat(line[key].values, columns),
        y=np.add.reduceat(frequency, rows) / np.diff(rows, append=len(frequency)),
        z=np.log10(np.maximum(amplitude, np.float32(10.0 ** (top - DECADES)))),
        zmin=top - DECADES,
        zmax=top,
        colorscale=COLOUR_SCALE,
        colorbar={
            **colour_bar("amplitude of the shaft [mm]"),
            "tickvals": ticks.tolist(),
            "ticktext": [f"{10.0**tick:g}" for tick in ticks],
        },
        customdata=amplitude,
        hoverongaps=False,
        hovertemplate="%{x:.5g}, frequency %{y:.4g}<br>amplitude %{customdata:.3g} mm"
        "<extra></extra>",
        visible=shown,
    )
    done = line.isel({key: np.flatnonzero(np.isfinite(line["engine_order"][:, 0].values))})
    orders, modes = done["engine_order"], done["mode_line"]
    group = "engine orders"
    # Name, group, values, style, and True for an entry in the legend. White engine orders would be
    # invisible in the legend, where a grey line represents them.
    curves: list[tuple[str, str, Array, tuple[str, str, float], bool]] = [
        *(
            (f"{n:+d} Ω", group, orders.sel(order=n).values, ("#ffffff", "dot", 1), False)
            for n in done["order"].values
        ),
        (group, group, np.full(done.sizes[key], np.nan), ("#5b6575", "dot", 1.5), True),
        *(
            (
                f"{name}, {direction}",
                name,
                modes.sel(mode=name, direction=direction).values,
                (colour, dash, 1.5),
                direction == "forward",
            )
            for (name, (colour, *_)), dash in zip(LINES.items(), DASHES, strict=True)
            for direction in ("backward", "forward")
        ),
    ]
    return [heat] + [
        go.Scatter(
            x=done[key].values,
            y=values,
            mode="lines",
            line={"color": colour, "dash": dash, "width": width},
            name=family,
            legendgroup=family,
            showlegend=in_legend,
            visible=shown,
            hovertemplate=f"{name}: %{{y:.4g}}<extra></extra>",
        )
        for name, family, values, (colour, dash, width), in_legend in curves
    ]


def _texts(points: xr.Dataset) -> Any:
    """Return texts with the details of every point, (line, key)."""
    key = points[str(points.attrs["along"])]
    names = [line_label(points.isel({LINE: number})) for number in range(points.sizes[LINE])]
    unit = "" if key.attrs["units"] == "1" else f" {key.attrs['units']}"
    listed = [
        line_label(points[[str(values.name) for values in table_keys(points)]].isel({POINT: n}))
        for n in range(points.sizes.get(POINT, 0))
    ]
    texts = np.empty(points["regime"].shape, dtype=object)
    for at in np.ndindex(texts.shape):
        point = points.isel({LINE: at[0], str(points.attrs["along"]): at[1]})
        done = str(point["state"].values) == "done"
        lines = [
            f"<b>{point['regime' if done else 'state'].values}</b>",
            f"{key.attrs['long_name']} = {key.values[at[1]]:.6g}{unit}",
            listed[at[1]] if listed else "",
            names[at[0]],
        ]
        if done:
            rate, error = float(point["growth_rate"]), float(point["growth_error"])
            growth = f"{rate_text(rate, error)} 1/s" if np.isfinite(rate) else "not determined"
            lines += [
                f"largest recorded displacement of the {points.attrs['moving']}"
                f" {MILLI * float(point['largest_displacement']):.4g} mm",
                f"growth rate {growth}",
                f"blades that touched {int(point['touched'])}",
                f"end {float(point['end_time']):.4g} s",
            ]
        texts[at] = "<br>".join(filter(None, lines))
    return texts


def _key_axis(values: xr.DataArray) -> dict[str, Any]:
    axis_type = "log" if is_wide(values.values) else "linear"
    return {"title_text": key_label(values), "type": axis_type}
