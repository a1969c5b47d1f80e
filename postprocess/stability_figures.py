"""Figures of the linear stability of the coupled stage: Figs 11 and 12, and what truncation hides.

Each figure is drawn from a Dataset that holds all its numbers, so the file saved beside it draws
it again. Speeds are in multiples of the reference frequency.
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

from bladewhirl.models.coupling import BoolArray, ComplexArray, CouplingModes, FloatArray
from bladewhirl.postprocess.style import COLOURS, new_figure, styled
from bladewhirl.solvers.stability import (
    UNSTABLE_GROWTH,
    StabilityChart,
    coincidence_speeds,
    is_unstable,
)
from bladewhirl.solvers.zones import UnstableZones

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

TYPES = {
    "oscillatory": COLOURS["total"],
    "divergent": COLOURS["k = 1"],
    "damped": COLOURS["k = 0"],
}
"""Colours of the three types of modes."""


def chart_dataset(
    chart: StabilityChart, zones: UnstableZones, modes: CouplingModes, *, reference: float
) -> xr.Dataset:
    """Everything behind a stability chart.

    Args:
        chart: growth rates on a grid.
        zones: borders of its unstable zones.
        modes: the modes coupled.
        reference: frequency that speeds are multiples of [rad/s].
    """
    names = np.array(modes.name)
    pairs = coincidence_speeds(modes)
    rad_s = {"units": "rad/s"}
    return xr.Dataset(
        data_vars={
            "growth": (
                ("kappa", "speed"),
                chart.growth,
                {"units": "1/s", "long_name": "largest real part of the spectrum"},
            ),
            "zone_kappa": ("zone", zones.kappa, {"units": "N/m"}),
            "zone_lower": ("zone", zones.lower / reference, {"units": "1"}),
            "zone_upper": ("zone", zones.upper / reference, {"units": "1"}),
            "zone_growth": ("zone", zones.growth, {"units": "1/s"}),
            "zone_nodal_diameter": ("zone", modes.nodal_diameter[zones.casing]),
            "zone_casing": ("zone", names[zones.casing]),
            "zone_rotor": ("zone", names[zones.rotor]),
            "coincidence": (
                "pair",
                np.array([*pairs.values()]) / reference,
                {"units": "1", "long_name": "coincidence speed, Eq. (14)"},
            ),
            "coincidence_nodal_diameter": (
                "pair",
                modes.nodal_diameter[[casing for casing, _ in pairs]],
            ),
            "coincidence_pair": ("pair", [_pair(names[i], names[j]) for i, j in pairs]),
            "coincidence_rotor": ("pair", names[[rotor for _, rotor in pairs]]),
            "mode_frequency": ("mode", modes.frequency, rad_s),
            "mode_nodal_diameter": ("mode", modes.nodal_diameter),
            "mode_amplitude": ("mode", modes.amplitude, {"units": "kg^-1/2"}),
            "mode_damping_ratio": ("mode", modes.damping_ratio),
        },
        coords={
            "kappa": ("kappa", chart.kappa, {"units": "N/m", "long_name": "coupling stiffness"}),
            "speed": (
                "speed",
                chart.speed / reference,
                {"units": "1", "long_name": "speed in multiples of reference_frequency"},
            ),
            "mode": names,
        },
        attrs={"title": "stability chart", "reference_frequency": reference},
    )


def spectrum_dataset(
    speed: FloatArray, branches: ComplexArray, *, kappa: float, reference: float
) -> xr.Dataset:
    """Eigenvalues along a line of constant stiffness.

    Args:
        speed: [rad/s], (speeds,).
        branches: eigenvalues, a column a branch [1/s], (speeds, branches).
        kappa: spring stiffness [N/m].
        reference: frequency that speeds are multiples of [rad/s].
    """
    plane = ("speed", "branch")
    return xr.Dataset(
        data_vars={
            "real": (plane, branches.real, {"units": "1/s", "long_name": "growth rate"}),
            "imaginary": (plane, branches.imag, {"units": "rad/s", "long_name": "frequency"}),
        },
        coords={"speed": ("speed", speed / reference, {"units": "1"})},
        attrs={
            "title": "eigenvalues in the invariant frame",
            "kappa": kappa,
            "reference_frequency": reference,
        },
    )


@styled
def plot_chart(data: xr.Dataset, point: tuple[float, float] | None = None) -> Figure:
    """Draw the stability chart, Fig. 11: zones, growth rates, coincidence speeds.

    Where few waves can coincide, zones are lettered from the left as in the paper.

    Args:
        data: from `chart_dataset`.
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
    _draw_borders(axes, data, colour=COLOURS["total"])
    _draw_coincidences(axes, data)
    if point is not None:
        axes.plot(*point, "o", color=COLOURS["contact"], markerfacecolor="none", label="point")
    axes.set(
        xlim=(speed[0], speed[-1]), ylim=(kappa[0], kappa[-1]), xlabel=SPEED_AXIS, ylabel=KAPPA_AXIS
    )
    handles, labels = axes.get_legend_handles_labels()
    if handles:
        figure.legend(handles, labels, loc="outside lower center", ncols=3, columnspacing=1.0)
    return figure


@styled
def plot_spectrum(data: xr.Dataset) -> Figure:
    """Draw real and imaginary parts along a line of constant stiffness, Fig. 12.

    Divergent, damped and oscillatory modes have their own colours; with damping all modes that do
    not grow are damped.
    """
    figure = new_figure(height=0.085)
    upper, lower = figure.subplots(2, 1, sharex=True)
    speed, real = data["speed"].values, data["real"].values
    frequency = data["imaginary"].values / data.attrs["reference_frequency"]
    limit = UNSTABLE_GROWTH * speed[:, None] * data.attrs["reference_frequency"]
    # Where divergent and damped modes share a frequency, the divergent ones are on top.
    kinds = {
        "oscillatory": np.abs(real) <= limit,
        "damped": real < -limit,
        "divergent": real > limit,
    }
    for kind, here in kinds.items():
        for axes, values in ((upper, real), (lower, frequency)):
            lines = axes.plot(speed, np.where(_widened(here), values, np.nan), color=TYPES[kind])
        if here.any():
            lines[0].set_label(kind)
    upper.set_ylabel("real part [1/s]")
    lower.set(ylabel="imaginary part / ω$_1$ [–]", xlabel=SPEED_AXIS, xlim=(speed[0], speed[-1]))
    figure.legend(*lower.get_legend_handles_labels(), loc="outside upper center", ncols=3)
    upper.set_title(f"κ = {data.attrs['kappa']:.4g} N/m, frame at half speed")
    return figure


@styled
def plot_truncation(whole: xr.Dataset, truncated: xr.Dataset) -> Figure:
    """Draw what a truncated set of modes hides: zones of the whole set, and of the truncated one.

    A zone narrower than a line is drawn as a line.

    Args:
        whole: chart of all modes, from `chart_dataset`.
        truncated: chart of a few of them, over the same range.
    """
    figure = new_figure(height=0.07)
    axes = figure.subplots()
    handles, labels = [], []
    for one, colour, label in (
        (whole["zone_nodal_diameter"] == 1, COLOURS["k = 1"], "all modes, k = 1"),
        (whole["zone_nodal_diameter"] != 1, COLOURS["other k"], "all modes, other k"),
    ):
        for zone in _zones(whole.isel(zone=one.values)):
            axes.fill_betweenx(
                zone["kappa"],
                zone["lower"],
                zone["upper"],
                facecolor=colour,
                edgecolor=colour,
                linewidth=0.5,
            )
        handles.append(Patch(color=colour))
        labels.append(label)
    _draw_borders(axes, truncated, colour=COLOURS["total"])
    handles.append(Patch(facecolor="none", edgecolor=COLOURS["total"]))
    labels.append(f"{truncated.sizes['mode']} pairs only")
    axes.set(
        xlim=(float(whole["speed"][0]), float(whole["speed"][-1])),
        ylim=(float(whole["kappa"][0]), float(whole["kappa"][-1])),
        xlabel=SPEED_AXIS,
        ylabel=KAPPA_AXIS,
    )
    figure.legend(handles, labels, loc="outside upper center", ncols=3, columnspacing=1.0)
    return figure


def _draw_borders(axes: Axes, data: xr.Dataset, *, colour: str) -> None:
    for zone in _zones(data):
        for side in ("lower", "upper"):
            axes.plot(zone[side], zone["kappa"], color=colour, linewidth=0.5)


def _zones(data: xr.Dataset) -> list[dict[str, FloatArray]]:
    """Each zone's stiffnesses and borders, from its coincidence speed upwards in stiffness."""
    found = []
    pairs = np.stack([data["zone_casing"].values, data["zone_rotor"].values], axis=-1)
    start = dict(zip(data["coincidence_pair"].values, data["coincidence"].values, strict=True))
    for casing, rotor in np.unique(pairs, axis=0):
        rows = np.flatnonzero(np.all(pairs == (casing, rotor), axis=-1))
        zone = {name: data[f"zone_{name}"].values[rows] for name in ("kappa", "lower", "upper")}
        if data["kappa"][0] == 0.0:  # there it has no width, and no row
            apex = start[_pair(casing, rotor)]
            for name, value in (("kappa", 0.0), ("lower", apex), ("upper", apex)):
                zone[name] = np.insert(zone[name], 0, value)
        found.append(zone)
    return found


def _pair(casing: str, rotor: str) -> str:
    """What a zone and its coincidence speed are called."""
    return f"{casing} + {rotor}"


def _draw_coincidences(axes: Axes, data: xr.Dataset) -> None:
    inside = (data["coincidence"] >= data["speed"][0]) & (data["coincidence"] <= data["speed"][-1])
    seen = data.isel(pair=np.flatnonzero(inside)).sortby("coincidence")
    first = (seen["coincidence_nodal_diameter"] == 1).values
    for here, name in ((first, "k = 1"), (~first, "other k")):
        if here.any():
            speeds = seen["coincidence"].values[here]
            base = np.full(len(speeds), float(data["kappa"][0]))
            label = f"coincidence, {name}"
            axes.plot(speeds, base, color=COLOURS[name], label=label, **MARK)
    if seen.sizes["pair"] <= len(LETTERS):
        for letter, speed, rotor in zip(
            LETTERS, seen["coincidence"].values, seen["coincidence_rotor"].values, strict=False
        ):
            top: Mapping[str, Any] = {"ha": "center", "va": "bottom", "textcoords": "offset points"}
            place = (speed, float(data["kappa"][-1]))
            axes.annotate(f"{letter}: {rotor}", place, xytext=(6, 2), **top)


def _widened(here: BoolArray) -> BoolArray:
    """Stretches of True lengthened by one sample, so that lines of different colour meet."""
    wide = here.copy()
    wide[1:] |= here[:-1]
    wide[:-1] |= here[1:]
    return wide
