"""Figures of sweeps: spectra over a parameter with their lines, largest shaft displacement.

Only the few numbers a point that a figure shows are read from the dataset, line by line.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

import matplotlib
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke

from bladewhirl.postprocess.fields import Array
from bladewhirl.postprocess.style import (
    COLOURS,
    FULL_WIDTH,
    SEQUENTIAL,
    new_figure,
    save_figure,
    styled,
)
from bladewhirl.postprocess.sweep_result import open_sweep, point_slices, swept

MAP_NAME, RADIUS_NAME = "frequency_map", "shaft_radius"

MOST_MAPS = 12
"""Frequency maps drawn of a sweep over several keys."""

MOST_LINES = 8
"""Lines in the figure of displacements: more are not told apart."""

DECADES = 4.0
"""Decades below the largest amplitude that a map shows."""

MARGIN = 1.15
"""How far a map goes beyond the outermost line of a rotor mode that it is to show."""

ORDERS = tuple(order for order in range(-4, 5) if order != 0)
"""Engine orders that have lines; the zeroth is the axis."""

LINES: Mapping[str, tuple[str, bool]] = {
    "suspension": (COLOURS["suspension"], True),
    "1F k=1": (COLOURS["k = 1"], True),
    "casing k=1": (COLOURS["casing"], False),
}
"""Modes that have lines in a map: colour, and whether the map is made to reach them."""

MILLI = 1e3

OUTLINE = [withStroke(linewidth=1.6, foreground="black")]
"""Around white lines and letters, which stand on every colour of a map."""


def draw_sweep(directory: Path) -> None:
    """Write the figures of a sweep into its folder, as PNG and PDF with their data."""
    with open_sweep(directory) as dataset:
        key = main_key(dataset)
        for position, name in _maps(dataset, key):
            line = frequency_map(dataset.isel(position), key)
            save_figure(plot_frequency_map(line), directory / name, line)
        radius = shaft_radius(dataset, key)
        save_figure(plot_shaft_radius(radius), directory / RADIUS_NAME, radius)


def main_key(dataset: xr.Dataset) -> str:
    """The dimension that figures are drawn along: the speed if it is swept, else the first."""
    names = swept(dataset)
    return "march_speed" if "march_speed" in names else names[0]


def frequency_map(dataset: xr.Dataset, key: str) -> xr.Dataset:
    """Spectra of the shaft along a swept key, and the lines to draw over them.

    Args:
        dataset: a sweep at one value of every other key.
        key: the dimension along which.

    Returns:
        `amplitude` (key, frequency) [m]; `frequency` is in multiples of the reference frequency
        where all points share it, else in Hz. In the same unit, as seen in the rotating frame:
        `mode_line` (mode, direction, key), waves on the casing being slowed by the speed, and
        `engine_order` (order, key). Forward is positive.
    """
    ordered = dataset.sortby(key)
    reference = ordered["reference_frequency"].values / (2.0 * np.pi)
    known = reference[np.isfinite(reference)]
    shared = bool(known.size) and bool(np.all(known == known[0]))
    unit = float(known[0]) if shared else 1.0
    speed = np.abs(ordered["rotation_speed"].values) / (2.0 * np.pi)
    direction = np.array([-1.0, 1.0])
    own = ordered["mode_frequency"].sel(mode=list(LINES)).transpose("mode", key).values
    turning = np.array([name.startswith("casing") for name in LINES])
    lines = direction[:, None] * own[:, None, :] - turning[:, None, None] * speed
    units = {"units": "1" if shared else "Hz"}
    return xr.Dataset(
        {
            "amplitude": ordered["spectrum"].transpose(key, "frequency").drop_vars("frequency"),
            "mode_line": (("mode", "direction", key), lines / unit, units),
            "engine_order": (("order", key), np.outer(ORDERS, speed) / unit, units),
        },
        coords={
            "frequency": ("frequency", ordered["frequency"].values / unit, units),
            "direction": ["backward", "forward"],
            "mode": list(LINES),
            "order": list(ORDERS),
        },
        attrs={
            "title": "spectra of the shaft, rotating frame",
            "at": _others(dataset, key),
            "window": dataset.attrs["window"],
        },
    )


@styled
def plot_frequency_map(line: xr.Dataset) -> Figure:
    """Draw a map from `frequency_map`: amplitude over parameter and signed frequency.

    Dotted lines are engine orders, dashed ones modes. Points without a result are left white.
    """
    key = str(line["amplitude"].dims[0])
    amplitude = MILLI * line["amplitude"].values
    top = np.nanmax(amplitude, initial=0.0) or 1.0
    figure = new_figure(width=FULL_WIDTH, height=0.1)
    axes = figure.add_subplot()
    mesh = axes.pcolormesh(
        line[key].values,
        line["frequency"].values,
        np.maximum(amplitude, top * 10.0**-DECADES).T,
        norm=LogNorm(top * 10.0**-DECADES, top),
        cmap=SEQUENTIAL,
        shading="nearest",
        rasterized=True,
    )
    figure.colorbar(mesh, ax=axes, label="amplitude of the shaft [mm]", pad=0.01)
    limit = _reach(line)
    axes.set_ylim(-limit, limit)
    _draw_orders(axes, line, key, limit)
    for name, (colour, _) in LINES.items():
        backward, forward = line["mode_line"].sel(mode=name).values
        axes.plot(line[key].values, backward, color=colour, linestyle="--", label=name)
        axes.plot(line[key].values, forward, color=colour, linestyle="--")
    axes.plot([], [], color="grey", linestyle=":", linewidth=0.8, label="engine orders")
    unit = "/ reference frequency" if line["frequency"].attrs["units"] == "1" else "[Hz]"
    axes.set(xlabel=_axis_label(line[key]), ylabel=f"frequency {unit}, forward positive")
    axes.set_title(line.attrs["title"] + (f", {line.attrs['at']}" if line.attrs["at"] else ""))
    figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return figure


def shaft_radius(dataset: xr.Dataset, key: str) -> xr.Dataset:
    """Largest displacement of the shaft and regime at every point, along a swept key."""
    names = ["shaft_radius_max", "regime", "state"]
    ordered = dataset[names].sortby(key).load()
    ordered.attrs = {"title": "largest displacement of the shaft's centre", "along": key}
    return ordered


@styled
def plot_shaft_radius(radius: xr.Dataset) -> Figure:
    """Draw the largest displacements from `shaft_radius`, a line for each other combination.

    Divergent points are open: their march was ended, so the motion would have grown further.
    """
    key = str(radius.attrs["along"])
    positions = point_slices(radius, key)
    figure = new_figure(width=FULL_WIDTH, height=0.08)
    axes = figure.add_subplot()
    colours = matplotlib.colormaps[SEQUENTIAL](
        np.linspace(0.0, 0.85, min(len(positions), MOST_LINES))
    )
    for position, colour in zip(positions, colours, strict=False):
        line = radius.isel(position)
        place, size = line[key].values, MILLI * line["shaft_radius_max"].values
        divergent = line["regime"].values == "divergent"
        shown = _others(line, key)
        axes.plot(place, size, color=colour, label=shown or None)
        axes.plot(place[~divergent], size[~divergent], "o", markersize=2.5, color=colour)
        axes.plot(place[divergent], size[divergent], "o", markersize=3.5, mfc="white", mec=colour)
    if (radius["regime"].values == "divergent").any():
        axes.plot([], [], "o", markersize=3.5, mfc="white", mec="black", label="divergent")
    axes.set(xlabel=_axis_label(radius[key]), ylabel="largest shaft displacement [mm]")
    axes.set_ylim(bottom=0.0)
    left_out = len(positions) - MOST_LINES
    axes.set_title(
        radius.attrs["title"] + (f" ({left_out} more lines in the data)" if left_out > 0 else "")
    )
    if axes.get_legend_handles_labels()[0]:
        figure.legend(loc="outside lower center", ncols=3)
    return figure


def _maps(dataset: xr.Dataset, key: str) -> Iterator[tuple[dict[str, int], str]]:
    """Where maps are drawn, and the name of each."""
    positions = [
        position
        for position in point_slices(dataset, key)
        if (dataset["state"].isel(position) == "done").any()
    ]
    for number, position in enumerate(positions[:MOST_MAPS]):
        yield position, MAP_NAME if len(positions) == 1 else f"{MAP_NAME}_{number:02d}"


def _reach(line: xr.Dataset) -> float:
    """Largest frequency that a map shows."""
    wanted = [name for name, (_, reached) in LINES.items() if reached]
    outermost = np.nanmax(np.abs(line["mode_line"].sel(mode=wanted).values), initial=0.0)
    available = float(line["frequency"].max())
    return min(MARGIN * outermost, available) if outermost > 0.0 else available


def _draw_orders(axes: Axes, line: xr.Dataset, key: str, limit: float) -> None:
    """Lines of the engine orders, each named where it leaves the map."""
    place = line[key].values
    for order in ORDERS:
        level: Array = line["engine_order"].sel(order=order).values
        seen = np.flatnonzero(np.isfinite(level) & (np.abs(level) <= limit))
        if not seen.size:
            continue
        axes.plot(place, level, color="white", linestyle=":", linewidth=0.8, path_effects=OUTLINE)
        axes.annotate(
            f"{order:+d}Ω".replace("+1Ω", "+Ω").replace("-1Ω", "-Ω").replace("-", "−"),
            (place[seen[-1]], level[seen[-1]]),
            color="white",
            ha="right",
            va="bottom",
            path_effects=OUTLINE,
        )


def _axis_label(values: xr.DataArray) -> str:
    """Name of a swept key with its unit."""
    name, units = str(values.attrs["long_name"]), str(values.attrs["units"])
    if name == "march.speed" and units == "1":
        return "speed Ω / reference frequency"
    return name if units == "1" else f"{name} [{units}]"


def _others(dataset: xr.Dataset, key: str) -> str:
    """Values of the keys that are not swept along, in words."""
    found = [
        f"{values.attrs['long_name']} = {float(values):.4g}"
        for name, values in dataset.coords.items()
        if values.ndim == 0 and name != key and "long_name" in values.attrs
    ]
    return ", ".join(found)
