"""Figures of a sweep: displacement (the paper's Fig. 24), whirl and contact side of the shaft, wear
of the coating."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from bladewhirl.models.inputs.units import handy_unit
from bladewhirl.postprocess.fields.kinematics import ViewError
from bladewhirl.postprocess.plotting.legends import Group
from bladewhirl.postprocess.plotting.style import COLOURS, styled
from bladewhirl.postprocess.shaft.orbits import LONG_LINE
from bladewhirl.postprocess.sweep import drawing
from bladewhirl.postprocess.sweep.quantities import along
from bladewhirl.solvers.stability.scenario import STEADY

#: the axis is logarithmic if the largest displacement exceeds this many times the median
WIDE = 1e3
LEAST_WHIRL = 0.1  #: the axis of the whirl reaches at least this far on both sides of zero [Hz]
SECTION_PARTS = {
    "section_x": "x once a revolution",
    "section_radius": "radius once a revolution",
    "radius_peak": "local maxima of radius",
}

SECTION_SIZE = 2.2  #: size of marks of sections [points]

PARTS = {"shaft_radius_max": "largest", "shaft_radius_final": "at the end"}

WEAR = {
    "wear_volume": (1e6, "removed\nvolume [cm³]"),
    "wear_strain_max": (100.0, "deepest cut\n[% of thickness]"),
    "wear_lobes": (1.0, "lobes"),
}
"""Factor and label of each quantity of the wear."""


@styled
def plot_shaft_radius(radius: xr.Dataset) -> Figure:
    """Draw the largest and the final displacement of the shaft against the swept key, from
    `quantities.shaft_radius`.

    Divergent points have open marks, because their displacements would have grown further.
    """
    unit, scale = handy_unit(float(radius["shaft_radius_max"].max().fillna(0.0)), "m")
    radius, lines, figure, panels = drawing.stacked(radius, len(PARTS), 0.11)
    for axes, (name, label) in zip(panels, PARTS.items(), strict=True):
        drawing.draw_quantity(axes, lines, name, scale)
        values = scale * radius[name].values
        moving = values[values > 0]
        if moving.size and moving.max() > WIDE * np.median(moving):
            axes.set_yscale("log")
        else:
            axes.margins(y=0.08)
            axes.set_ylim(bottom=0.0)
        axes.set_ylabel(f"{label} [{unit}]")
    marks = drawing.divergent_mark(radius)
    drawing.label_figure(figure, radius, marks, drawing.lines_group(lines))
    return figure


@styled
def plot_whirls(data: xr.Dataset) -> Figure:
    """Draw the frequency of the whirl from `quantities.whirls` in both frames [Hz], positive for
    forward whirl, with bars for the scatter of the frequency.

    Whirls with a clear direction have filled marks. Where the shaft hardly moves there is no mark.
    """
    data, lines, figure, panels = drawing.stacked(data, data.sizes["frame"], 0.12)
    for axes, frame in zip(panels, data["frame"].values, strict=True):
        axes.axhline(0.0, color=COLOURS["total"], linewidth=0.6)
        for line in lines:
            one = line.data.sel(frame=frame)
            frequency, scatter = one["frequency"].values, one["scatter"].fillna(0.0).values
            clear = np.isin(one["direction"].values, ["forward", "backward"])
            path = np.where(clear, frequency, np.nan)
            axes.plot(line.place, path, color=line.colour, linestyle=line.dash)
            axes.errorbar(line.place, frequency, scatter, fmt="none", ecolor=line.colour)
            drawing.draw_marks(axes, line, frequency, filled=clear)
        axes.set_ylabel(f"{frame} frame [Hz]\n← backward  forward →")
        axes.margins(y=0.1)
        low, high = axes.get_ylim()
        axes.set_ylim(min(low, -LEAST_WHIRL), max(high, LEAST_WHIRL))
    marks = Group([drawing.open_mark("no clear direction (open marks)")])
    drawing.label_figure(figure, data, marks, drawing.lines_group(lines))
    return figure


@styled
def plot_contact_sides(data: xr.Dataset) -> Figure:
    """Draw the angle by which the shaft leads the contact, and the steadiness of this angle, from
    `quantities.contact_sides`.

    The contact scenario is standard within 90 degrees, in the grey band, and inverted outside of
    the band. Points with an unsteady angle have open marks, points without contact have no mark.
    """
    data, lines, figure, panels = drawing.stacked(data, 2, 0.11, height_ratios=(2.0, 1.0))
    upper, lower = panels
    for line in lines:
        lead = np.degrees(line.data["shaft_lead"].values)
        drawing.draw_marks(upper, line, lead, filled=line.data["scenario"].values != "unsteady")
        lower.plot(
            line.place,
            line.data["lead_steadiness"].values,
            marker=line.mark,
            markersize=drawing.MARK_SIZE,
            color=line.colour,
            linestyle=line.dash,
        )
    band = upper.axhspan(-90, 90, color=COLOURS["rest"], alpha=0.25, linewidth=0, zorder=0)
    upper.set(
        ylim=(-190, 190), yticks=(-180, -90, 0, 90, 180), ylabel="shaft ahead of\ncontact [°]"
    )
    lower.set(ylim=(0.0, 1.05), ylabel="steadiness [–]")
    lower.axhline(STEADY, color=COLOURS["total"], linestyle=":", linewidth=0.6)
    unsteady = drawing.open_mark(f"unsteady, below {STEADY:g} (open marks)")
    marks = Group([(band, "where contact is standard"), unsteady])
    drawing.label_figure(figure, data, marks, drawing.lines_group(lines))
    return figure


@styled
def plot_bifurcation(data: xr.Dataset) -> Figure:
    """Draw Poincaré sections and local maxima of the displacement against the swept key, from
    `quantities.bifurcation`."""
    sizes = [np.nanmax(np.abs(data[name].values), initial=0.0) for name in SECTION_PARTS]
    unit, scale = handy_unit(float(max(sizes)), "m")
    data, lines, figure, panels = drawing.stacked(data, len(SECTION_PARTS), 0.17)
    for axes, (name, label) in zip(panels, SECTION_PARTS.items(), strict=True):
        for line in lines:
            values = scale * line.data[name].values
            axes.plot(
                np.repeat(line.place, values.shape[1]),
                values.ravel(),
                line.mark,
                color=line.colour,
                markersize=SECTION_SIZE,
                markeredgewidth=0.0,
                rasterized=values.size > LONG_LINE,
            )
        axes.set_ylabel(f"{label} [{unit}]")
    drawing.label_figure(figure, data, drawing.lines_group(lines, dashed=False))
    return figure


def wear_quantities(dataset: xr.Dataset, key: str) -> xr.Dataset:
    """Load the quantities of the wear of a sweep along a key, see `quantities.along`.

    Raises:
        ViewError: no point has a coating.
    """
    data = along(dataset, key, [*WEAR, "wear_dissipated", "regime"])
    if not np.isfinite(data["wear_volume"]).any():
        raise ViewError("no point of this sweep has a casing.coating, so nothing can be worn")
    return data.assign_attrs(title="wear of the coating")


@styled
def plot_wear_quantities(data: xr.Dataset) -> Figure:
    """Draw removed volume, deepest cut and number of lobes against the swept key, from
    `wear_quantities`. Divergent points have open marks."""
    return drawing.plot_quantities(data, WEAR)
