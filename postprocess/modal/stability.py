"""Figures of the linear stability of the coupled stage: the paper's Figs 11 and 12, and a figure of
the effect of modal truncation.

Each figure is drawn from a Dataset of `studies.modal.stability_chart`. The Dataset contains all
numbers of the figure, so the figure can be drawn again from the file saved with it. Speeds are in
multiples of the reference frequency.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from bladewhirl.meshes.line_mesh import BoolArray, FloatArray
from bladewhirl.models.inputs.units import handy
from bladewhirl.postprocess.plotting import axes as panels
from bladewhirl.postprocess.plotting.legends import Group, complete, legends_below
from bladewhirl.postprocess.plotting.style import COLOURS, FULL_WIDTH, is_narrow, new_figure, styled
from bladewhirl.postprocess.plotting.titles import set_title
from bladewhirl.solvers.stability.growth import UNSTABLE_GROWTH, is_unstable

KAPPA_AXIS = "coupling stiffness κ [N/m]"

MARK: Mapping[str, Any] = {
    "linestyle": "none",
    "marker": "^",
    "markersize": 3.5,
    "clip_on": False,
    "zorder": 5,
}
"""Marks of coincidence speeds on the axis of speeds."""

MANY = 24
"""In a spectrum with more branches than this, lines are thin and only growing branches are
named."""

NAMED = 0.3
"""Width of the space to the left of a spectrum, for the names of its branches, divided by the
width of the spectrum."""

FEW = 4
"""Up to this number, unstable zones are named by both waves, on casing and rotor; if there are
more, only by the wave on the rotor."""

TYPES = {"oscillatory": COLOURS["total"], "divergent": COLOURS["k = 1"], "damped": COLOURS["k = 0"]}
"""Colours of the three types of modes."""


@styled
def plot_chart(data: xr.Dataset, point: tuple[float, float] | None = None) -> Figure:
    """Draw the stability chart (the paper's Fig. 11): growth rates and, if the data contain them,
    named unstable zones and coincidence speeds. `point` is the normalised speed and the stiffness
    [N/m] of a point to mark."""
    figure, axes = _new_chart(data)
    speed, kappa, growth = (data[name].values for name in ("speed", "kappa", "growth"))
    unstable = is_unstable(growth, speed * data.attrs["reference_frequency"])
    shown = np.ma.masked_array(growth, ~unstable)
    colours = Normalize(0.0, float(growth[unstable].max()) if unstable.any() else 1.0)
    mesh = panels.draw_map(axes, speed, kappa, shown, norm=colours)
    if unstable.any():
        figure.colorbar(mesh, ax=axes, label="growth rate [1/s]; white is stable", pad=0.02)
    else:
        axes.text(0.5, 0.5, "stable everywhere", transform=axes.transAxes, ha="center")
    if "zone" in data.dims:
        _draw_borders(axes, data)
        low, high = data.attrs["speed_range"]
        met, k = data["coincidence"].values, data["coincidence_nodal_diameter"].values
        inside = (met >= low) & (met <= high)
        for here, name in ((inside & (k == 1), "k = 1"), (inside & (k != 1), "other k")):
            if here.any():
                base = np.full(np.count_nonzero(here), data.attrs["kappa_range"][0])
                label = f"coincidence, {name}"
                axes.plot(met[here], base, color=COLOURS[name], label=label, **MARK)
    if point is not None:
        axes.plot(*point, "o", color=COLOURS["contact"], markerfacecolor="none", label="point")
    complete(figure, data, _words("Growth of coupled modes", data))
    if "zone" in data.dims:
        _name_zones(axes, data)
    return figure


@styled
def plot_spectrum(data: xr.Dataset) -> Figure:
    """Draw real and imaginary parts of the eigenvalues against the speed at a constant
    coupling stiffness (the paper's Fig. 12).

    Divergent (growing), damped and oscillatory modes have different colours; with damping every
    mode that does not grow is damped. A branch is named by the wave from which it begins, a growing
    branch by the two waves that coincide. If there are many branches, only the frequencies near
    growing modes are shown. The spectrum is symmetric about zero frequency, so only its upper half
    is drawn. If all real parts are zero, the panel of growth rates is replaced by a sentence.
    """
    reference = float(data.attrs["reference_frequency"])
    speed, real = data["speed"].values, data["real"].values
    frequency = data["imaginary"].values / reference
    limit = UNSTABLE_GROWTH * speed[:, None] * reference
    many = real.shape[1] > MANY
    # Where divergent and damped modes have the same frequency, divergent modes are drawn on top.
    kinds = {
        "oscillatory": np.abs(real) <= limit,
        "damped": real < -limit,
        "divergent": real > limit,
    }
    neutral = bool(kinds["oscillatory"].all())
    figure = new_figure(width=FULL_WIDTH, height=0.08 if neutral else 0.12)
    ratios = (1.5,) if neutral else (1.0, 1.5)
    rows = figure.subplots(len(ratios), 1, sharex=True, height_ratios=ratios, squeeze=False)[:, 0]
    lower, entries = rows[-1], []
    for kind, here in kinds.items():
        for axes, values in zip(rows[::-1], (frequency, real), strict=False):
            thin = many and kind != "divergent"
            lines = axes.plot(
                speed,
                np.where(_widened(here), values, np.nan),
                color=TYPES[kind],
                linewidth=0.3 if thin else 1.2,
                alpha=0.4 if thin else 1.0,
            )
        if here.any():
            entries.append((lines[0], f"{kind} mode"))
    growing = kinds["divergent"]
    above = np.abs(frequency[growing if many and growing.any() else ...]).max()
    room = NAMED * (4.5 if is_narrow(figure) else 1.0)
    first = speed[0] - (0.0 if many else room * (speed[-1] - speed[0]))
    lower.set(ylim=(0.0, (1.5 if many else 1.05) * above), xlim=(first, speed[-1]))
    panels.speed_axis(rows[0], reference / (2.0 * np.pi))
    if not neutral:
        reach = 1.5 * np.abs(real[growing] if many and growing.any() else real).max()
        rows[0].set(ylabel="growth rate [1/s]", ylim=(-reach, reach), xlabel="")
        lower.set_xlabel(panels.SPEED)
    panels.frequency_axis(lower, reference / (2.0 * np.pi))
    shown = _words(f"Eigenvalues along κ = {handy(data.attrs['kappa'], 'N/m', 4)}", data)
    sentence = "\nNo mode grows or decays: the real parts are zero." if neutral else ""
    set_title(figure, data.attrs["case"], f"{shown}, frame turning at Ω/2{sentence}")
    legends_below(figure, Group(entries))
    if not neutral:
        _name_meetings(rows[0], data, data["zone_growth"].values)
    if many:
        _name_meetings(lower, data, _growing_frequencies(data, frequency, growing))
    else:
        begins = frequency[0] > 0.0
        names = [panels.spaced(str(name)) for name in data["branch_name"].values[begins]]
        left, heights = float(speed[0]), frequency[0, begins]
        panels.name_ends(lower, left, heights, names, COLOURS["total"], right=False)
    return figure


@styled
def plot_truncation(data: xr.Dataset) -> Figure:
    """Draw the unstable zones of all modes and the unstable zones of six modes, to show the zones
    that are lost by truncation.

    The variable `zone_of` is "all" for zones of all modes and "few" for zones of six modes. A zone
    that is narrower than a line is drawn as a line.
    """
    figure, axes = _new_chart(data)
    whole = data["zone_of"].values == "all"
    first = data["zone_nodal_diameter"].values == 1
    for shown, name in ((whole & first, "k = 1"), (whole & ~first, "other k")):
        for zone in _zones(data.isel(zone=shown)):
            axes.fill_betweenx(
                zone.kappa,
                zone.lower,
                zone.upper,
                color=COLOURS[name],
                linewidth=0.5,
                label=f"zones of all modes, {name}",
            )
    _draw_borders(axes, data.isel(zone=~whole), "zones of six modes")
    complete(figure, data, "Unstable zones that the six modes hide")
    _name_zones(axes, data.isel(zone=whole))
    return figure


def _words(shown: str, data: xr.Dataset) -> str:
    """Return the title: the quantity `shown`, the number of modes, and "damped" with damping."""
    count = len(np.atleast_1d(data.attrs["modes"])) if "modes" in data.attrs else 0
    modes = f", {count} coupled pairs of modes" if count else ""
    return f"{shown}{modes}{', damped' if data.attrs.get('damped') else ''}"


def _new_chart(data: xr.Dataset) -> tuple[Figure, Axes]:
    """Return a figure with axes of speed and coupling stiffness."""
    figure = new_figure(width=FULL_WIDTH, height=0.085)
    axes = figure.subplots()
    axes.set(
        xlim=tuple(data.attrs["speed_range"]),
        ylim=tuple(data.attrs["kappa_range"]),
        ylabel=KAPPA_AXIS,
    )
    panels.speed_axis(axes, float(data.attrs["reference_frequency"]) / (2.0 * np.pi))
    return figure, axes


def _name_zones(axes: Axes, data: xr.Dataset) -> None:
    """Label zones next to their borders, the widest first; labels without space are omitted."""
    labels = panels.Labels(axes)
    zones = _zones(data)
    for zone in sorted(zones, key=lambda zone: -np.ptp([zone.lower[-1], zone.upper[-1]])):
        text = _meeting(zone.casing, zone.rotor, len(zones))
        colour = COLOURS["total"]
        if not labels.add(zone.upper[::-1], zone.kappa[::-1], text, colour, [(5, 0)]):
            labels.add(zone.lower[::-1], zone.kappa[::-1], text, colour, [(-5, 0)])


def _meeting(casing: str, rotor: str, zones: int) -> str:
    """Return the name of a zone: both waves or, if there are many `zones`, only the wave on the
    rotor."""
    return panels.spaced(f"{casing} and {rotor}" if zones <= FEW else rotor)


def _name_meetings(axes: Axes, data: xr.Dataset, heights: FloatArray) -> None:
    """Label each zone of growth in a spectrum with the waves that coincide, the fastest first.

    Args:
        axes: the panel.
        data: a spectrum.
        heights: heights of the names, nan for no name, (zone,).
    """
    labels = panels.Labels(axes)
    middle = 0.5 * (data["zone_lower"].values + data["zone_upper"].values)
    for i in np.argsort(-data["zone_growth"].values):
        pair = str(data["zone_casing"].values[i]), str(data["zone_rotor"].values[i])
        text = _meeting(*pair, data.sizes["zone"])
        labels.add(middle[i], heights[i], text, COLOURS["k = 1"], panels.AROUND)


def _growing_frequencies(data: xr.Dataset, frequency: FloatArray, growing: BoolArray) -> FloatArray:
    """Return the frequency of a growing mode in the middle of each zone, (zone,); nan for a zone
    without a growing mode."""
    middle = 0.5 * (data["zone_lower"].values + data["zone_upper"].values)
    rows = np.abs(data["speed"].values - middle[:, None]).argmin(axis=1)
    positive = np.where(growing & (frequency > 0.0), frequency, np.nan)[rows]
    return np.array(
        [row[np.isfinite(row)][0] if np.isfinite(row).any() else np.nan for row in positive]
    )


def _draw_borders(axes: Axes, data: xr.Dataset, label: str = "_") -> None:
    for zone in _zones(data):
        for side in (zone.lower, zone.upper):
            axes.plot(side, zone.kappa, color=COLOURS["total"], linewidth=0.5, label=label)


@dataclass(frozen=True, kw_only=True)
class _Zone:
    """Borders of an unstable zone as functions of the coupling stiffness, in ascending order."""

    casing: str
    rotor: str
    kappa: FloatArray  #: coupling stiffness [N/m]
    lower: FloatArray  #: normalised speed at which the zone begins
    upper: FloatArray  #: normalised speed at which the zone ends


def _zones(data: xr.Dataset) -> list[_Zone]:
    zones = []
    pairs = np.stack([data["zone_casing"].values, data["zone_rotor"].values], axis=-1)
    for pair in np.unique(pairs, axis=0):
        rows = np.flatnonzero(np.all(pairs == pair, axis=-1))
        zone = {name: data[f"zone_{name}"].values[rows] for name in ("kappa", "lower", "upper")}
        # At zero stiffness a zone has no width, and the data have no row for it.
        if data.attrs["kappa_range"][0] == 0.0:
            apex = float(data["zone_start"].values[rows[0]])
            for name, value in (("kappa", 0.0), ("lower", apex), ("upper", apex)):
                zone[name] = np.insert(zone[name], 0, value)
        zones.append(_Zone(casing=str(pair[0]), rotor=str(pair[1]), **zone))
    return zones


def _widened(here: BoolArray) -> BoolArray:
    """Return a mask in which every run of True values is one sample longer at both ends, so that
    lines of different colours join."""
    wide = here.copy()
    wide[1:] |= here[:-1]
    wide[:-1] |= here[1:]
    return wide
