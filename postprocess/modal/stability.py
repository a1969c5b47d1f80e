"""Figures of the linear stability of the coupled stage: Figs 11 and 12, and what truncation hides.

Each figure is drawn from a Dataset of `studies.modal.stability_chart` that holds all its numbers,
so the file saved beside it draws it again. Speeds are in multiples of the reference frequency.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from bladewhirl.meshes.line_mesh import BoolArray, FloatArray
from bladewhirl.postprocess.plotting.style import COLOURS, new_figure, styled
from bladewhirl.solvers.stability.growth import UNSTABLE_GROWTH, is_unstable

SPEED_AXIS = "rotational speed Ω / ω$_1$ [–]"
KAPPA_AXIS = "coupling stiffness κ [N/m]"

MARK: Mapping[str, Any] = {
    "linestyle": "none",
    "marker": "^",
    "markersize": 3.5,
    "clip_on": False,
    "zorder": 5,
}
"""Coincidence speeds, on the axis of speeds."""

LETTERS = "ABC"
"""Names of zones, where there are no more."""

MANY = 24
"""Branches of a spectrum beyond which lines are thin."""

TYPES = {
    "oscillatory": COLOURS["total"],
    "divergent": COLOURS["k = 1"],
    "damped": COLOURS["k = 0"],
}
"""Colours of the three types of modes."""


@styled
def plot_chart(data: xr.Dataset, point: tuple[float, float] | None = None) -> Figure:
    """Draw the stability chart, Fig. 11: zones, growth rates, coincidence speeds.

    Where few waves can coincide, zones are lettered from the left as in the paper.

    Args:
        data: a chart, with zones where there are any.
        point: normalised speed and stiffness [N/m] to mark.
    """
    figure = new_figure(height=0.062)
    axes = figure.subplots()
    speed, kappa, growth = (data[name].values for name in ("speed", "kappa", "growth"))
    unstable = is_unstable(growth, speed * data.attrs["reference_frequency"])
    shown = np.ma.masked_array(growth, ~unstable)
    colours = Normalize(0.0, float(growth[unstable].max()) if unstable.any() else 1.0)
    mesh = axes.pcolormesh(speed, kappa, shown, norm=colours, rasterized=True, shading="nearest")
    figure.colorbar(mesh, ax=axes, label="growth rate [1/s]", pad=0.02)
    if "zone" in data.dims:
        _draw_borders(axes, data)
        _draw_coincidences(axes, data)
    if point is not None:
        axes.plot(*point, "o", color=COLOURS["contact"], markerfacecolor="none", label="point")
    _label(axes, data)
    handles, labels = axes.get_legend_handles_labels()
    if handles:
        figure.legend(handles, labels, loc="outside lower center", ncols=3, columnspacing=1.0)
    return figure


@styled
def plot_spectrum(data: xr.Dataset) -> Figure:
    """Draw real and imaginary parts along a line of constant stiffness, Fig. 12.

    Divergent, damped and oscillatory modes have their own colours; with damping all modes that do
    not grow are damped. Of many branches only the frequencies near those of growing modes are
    shown.
    """
    figure = new_figure(height=0.085)
    upper, lower = figure.subplots(2, 1, sharex=True)
    speed, real = data["speed"].values, data["real"].values
    frequency = data["imaginary"].values / data.attrs["reference_frequency"]
    limit = UNSTABLE_GROWTH * speed[:, None] * data.attrs["reference_frequency"]
    many = real.shape[1] > MANY
    # Where divergent and damped modes share a frequency, the divergent ones are on top.
    kinds = {
        "oscillatory": np.abs(real) <= limit,
        "damped": real < -limit,
        "divergent": real > limit,
    }
    for kind, here in kinds.items():
        for axes, values in ((upper, real), (lower, frequency)):
            shown = np.where(_widened(here), values, np.nan)
            thin = many and kind != "divergent"
            lines = axes.plot(speed, shown, color=TYPES[kind], linewidth=0.3 if thin else 1.0)
        if here.any():
            lines[0].set_label(kind)
    if many and kinds["divergent"].any():
        reach = 1.5 * np.abs(frequency[kinds["divergent"]]).max()
        lower.set_ylim(-reach, reach)
    upper.set_ylabel("real part [1/s]")
    lower.set(ylabel="imaginary part / ω$_1$ [–]", xlabel=SPEED_AXIS, xlim=(speed[0], speed[-1]))
    figure.legend(*lower.get_legend_handles_labels(), loc="outside upper center", ncols=3)
    upper.set_title(f"κ = {data.attrs['kappa']:.4g} N/m, frame at half speed")
    return figure


@styled
def plot_truncation(data: xr.Dataset) -> Figure:
    """Draw what a truncated set of modes hides: zones of the whole set, and of the truncated one.

    A zone narrower than a line is drawn as a line.

    Args:
        data: zones of the whole set and of the truncated one, told apart by `zone_of`.
    """
    figure = new_figure(height=0.07)
    axes = figure.subplots()
    whole = data["zone_of"].values == "all"
    first = data["zone_nodal_diameter"].values == 1
    handles, labels = [], []
    for shown, name in ((whole & first, "k = 1"), (whole & ~first, "other k")):
        for zone in _zones(data.isel(zone=shown)):
            axes.fill_betweenx(
                zone["kappa"],
                zone["lower"],
                zone["upper"],
                facecolor=COLOURS[name],
                edgecolor=COLOURS[name],
                linewidth=0.5,
            )
        handles.append(Patch(color=COLOURS[name]))
        labels.append(f"all modes, {name}")
    _draw_borders(axes, data.isel(zone=~whole))
    handles.append(Patch(facecolor="none", edgecolor=COLOURS["total"]))
    labels.append("six modes")
    _label(axes, data)
    figure.legend(handles, labels, loc="outside upper center", ncols=3, columnspacing=1.0)
    return figure


def _label(axes: Axes, data: xr.Dataset) -> None:
    axes.set(
        xlim=tuple(data.attrs["speed_range"]),
        ylim=tuple(data.attrs["kappa_range"]),
        xlabel=SPEED_AXIS,
        ylabel=KAPPA_AXIS,
    )


def _draw_borders(axes: Axes, data: xr.Dataset) -> None:
    for zone in _zones(data):
        for side in ("lower", "upper"):
            axes.plot(zone[side], zone["kappa"], color=COLOURS["total"], linewidth=0.5)


def _zones(data: xr.Dataset) -> list[dict[str, FloatArray]]:
    """Each zone's stiffnesses and borders, from its coincidence speed upwards in stiffness."""
    found = []
    pairs = np.stack([data["zone_casing"].values, data["zone_rotor"].values], axis=-1)
    for pair in np.unique(pairs, axis=0):
        rows = np.flatnonzero(np.all(pairs == pair, axis=-1))
        zone = {name: data[f"zone_{name}"].values[rows] for name in ("kappa", "lower", "upper")}
        if data.attrs["kappa_range"][0] == 0.0:  # there it has no width, and no row
            apex = float(data["zone_start"].values[rows[0]])
            for name, value in (("kappa", 0.0), ("lower", apex), ("upper", apex)):
                zone[name] = np.insert(zone[name], 0, value)
        found.append(zone)
    return found


def _draw_coincidences(axes: Axes, data: xr.Dataset) -> None:
    low, high = data.attrs["speed_range"]
    base, top = data.attrs["kappa_range"]
    inside = (data["coincidence"] >= low) & (data["coincidence"] <= high)
    seen = data.isel(pair=np.flatnonzero(inside)).sortby("coincidence")
    first = (seen["coincidence_nodal_diameter"] == 1).values
    for here, name in ((first, "k = 1"), (~first, "other k")):
        if here.any():
            speeds = seen["coincidence"].values[here]
            label = f"coincidence, {name}"
            axes.plot(speeds, np.full(len(speeds), base), color=COLOURS[name], label=label, **MARK)
    if seen.sizes["pair"] <= len(LETTERS):
        for letter, speed, rotor in zip(
            LETTERS, seen["coincidence"].values, seen["coincidence_rotor"].values, strict=False
        ):
            axes.annotate(
                f"{letter}: {rotor}",
                (speed, top),
                xytext=(6, 2),
                textcoords="offset points",
                ha="center",
                va="bottom",
            )


def _widened(here: BoolArray) -> BoolArray:
    """Stretches of True lengthened by one sample, so that lines of different colour meet."""
    wide = here.copy()
    wide[1:] |= here[:-1]
    wide[:-1] |= here[1:]
    return wide
