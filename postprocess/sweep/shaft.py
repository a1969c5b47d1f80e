"""Displacement and whirl of the shaft, and the side of its contact, over a swept key (Fig. 24)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.transforms import Transform

from bladewhirl.models.inputs.units import handy_unit
from bladewhirl.postprocess.plotting.legends import Group
from bladewhirl.postprocess.plotting.style import COLOURS, FULL_WIDTH, new_figure, styled
from bladewhirl.postprocess.sweep.axes import in_handy_units, key_axis
from bladewhirl.postprocess.sweep.drawing import (
    SIDE_BY_SIDE,
    SIZES,
    WIDTHS,
    Line,
    dodged,
    draw_marks,
    label_figure,
    lines_group,
    lines_of,
    mark_entry,
)
from bladewhirl.solvers.stability.scenario import STEADY

WIDE = 1e3
"""Ratio of the largest to the median displacement from which its axis is logarithmic."""

LEAST_WHIRL = 0.1
"""Frequency that the axis of whirl reaches at least on both sides [Hz]: less is noise."""

PARTS = {"shaft_radius_max": "largest", "shaft_radius_final": "at the end"}

SCENARIO_MARKS: Mapping[str, tuple[str, bool]] = {
    "standard": ("o", True),
    "inverted": ("s", True),
    "unsteady": ("o", False),
}
"""Mark of each scenario, and whether it is filled."""

BELOW = {"unsteady": f", steadiness below {STEADY:g}"}
"""What a name of a scenario needs said."""

SCATTER = "scatter within the march, where larger than the mark"
"""What bars of a whirl are, in words."""

NO_SCATTER = "\nmarches too short to tell its scatter"

UNDRAWN: Mapping[str, str] = {"no-contact": "nothing touches", "at-rest": "the shaft rests"}
"""Of points without a side of the contact, in words."""


@styled
def plot_shaft_radius(radius: xr.Dataset) -> Figure:
    """Draw largest and final displacements in mm or µm, a line for each other combination.

    Divergent points are open: their march was ended, or the motion would have grown further.

    Args:
        radius: from `sweep_quantities.shaft_radius`.
    """
    radius = in_handy_units(radius)
    unit, scale = handy_unit(float(radius["shaft_radius_max"].max().fillna(0.0)), "m")
    lines = list(lines_of(radius))
    figure = new_figure(width=FULL_WIDTH, height=0.11)
    panels = figure.subplots(2, 1, sharex=True)
    for axes, (name, label) in zip(panels, PARTS.items(), strict=True):
        for line in lines:
            _draw_line(axes, line, name, scale)
        values = scale * radius[name].values
        moving = values[values > 0]
        if moving.size and moving.max() > WIDE * np.median(moving):
            axes.set_yscale("log")
        else:
            axes.margins(y=0.08)
            axes.set_ylim(bottom=0.0)
        axes.set_ylabel(f"{label} [{unit}]")
    key_axis(panels[1], radius)
    divergent = (radius["regime"] == "divergent").any()
    marks = [mark_entry("o", "divergent (open marks)", filled=False)] if divergent else []
    group = lines_group(radius, lines, "shaft_radius_max")
    label_figure(figure, radius, Group(marks), group)
    return figure


@styled
def plot_whirls(data: xr.Dataset) -> Figure:
    """Draw the whirl's frequency in both frames in Hz, forward upwards, with its scatter.

    Filled marks have a clear direction. A shaft that hardly moves has no mark.

    Args:
        data: from `sweep_quantities.whirls`.
    """
    data = in_handy_units(data)
    lines = list(lines_of(data))
    several = len(lines) > 1
    if several:  # side by side, where none has to be seen below another
        lines = [line._replace(width=WIDTHS[-1], size=SIZES[-1]) for line in lines]
    figure = new_figure(width=FULL_WIDTH, height=0.12)
    panels = figure.subplots(2, 1, sharex=True)
    for axes, frame in zip(panels, data["frame"].values, strict=True):
        axes.axhline(0.0, color=COLOURS["total"], linewidth=0.6)
        for number, line in enumerate(lines):
            place_of = dodged(axes, number, len(lines))
            _draw_whirl(axes, line._replace(data=line.data.sel(frame=frame)), place_of)
        axes.set_ylabel(f"{frame} frame [Hz]\n← backward  forward →")
        axes.margins(y=0.1)
        low, high = axes.get_ylim()
        axes.set_ylim(min(low, -LEAST_WHIRL), max(high, LEAST_WHIRL))
    key_axis(panels[1], data)
    known = bool(np.isfinite(data["scatter"].values).any())
    marks = [
        mark_entry("o", "clear direction (filled)"),
        mark_entry("o", "no clear direction (open): swings to and fro", filled=False),
    ]
    marks += [mark_entry("|", SCATTER)] if known else []
    group = lines_group(data, lines, "frequency")
    label_figure(
        figure,
        data,
        Group(marks),
        group,
        note=(SIDE_BY_SIDE if several else "") + (NO_SCATTER if not known else ""),
    )
    return figure


@styled
def plot_contact_sides(data: xr.Dataset) -> Figure:
    """Draw by how much the shaft leads the contact, and how steadily.

    Within 90 degrees, the grey band, contact is standard, outside it is inverted; open marks are
    motions without a steady lead. Points at which nothing touches have no mark.

    Args:
        data: from `sweep_quantities.contact_sides`.
    """
    data = in_handy_units(data)
    figure = new_figure(width=FULL_WIDTH, height=0.11)
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(2.0, 1.0))
    lines = list(lines_of(data))
    for number, line in enumerate(lines):
        positions = dodged(upper, number, len(lines))
        _draw_side(upper, lower, line, positions, several=len(lines) > 1)
    band = upper.axhspan(-90, 90, color=COLOURS["rest"], alpha=0.25, linewidth=0, zorder=0)
    upper.set(
        ylim=(-190, 190), yticks=(-180, -90, 0, 90, 180), ylabel="shaft ahead of\ncontact [°]"
    )
    lower.set(ylim=(0.0, 1.05), ylabel="steadiness [–]")
    lower.axhline(STEADY, color=COLOURS["total"], linestyle=":", linewidth=0.6)
    key_axis(lower, data)
    counts = {name: int((data["scenario"] == name).sum()) for name in (*SCENARIO_MARKS, *UNDRAWN)}
    marks = [
        mark_entry(
            "o" if len(lines) > 1 else mark,
            f"{name}: {counts[name]}{BELOW.get(name, '')}",
            filled=filled,
        )
        for name, (mark, filled) in SCENARIO_MARKS.items()
        if counts[name]
    ]
    unmarked = [
        (Line2D([], [], linestyle="none"), f"{words}: {counts[name]}, no mark")
        for name, words in UNDRAWN.items()
        if counts[name]
    ]
    within = (band, "where contact is standard")
    label_figure(
        figure,
        data,
        Group([within, *marks, *unmarked]),
        lines_group(data, lines, "shaft_lead"),
        note=SIDE_BY_SIDE if len(lines) > 1 else "",
    )
    return figure


def _draw_line(axes: Axes, line: Line, name: str, scale: float) -> None:
    place = line.data[str(line.data.attrs["along"])].values
    size = scale * line.data[name].values
    divergent = line.data["regime"].values == "divergent"
    axes.plot(place, size, color=line.colour, linestyle=line.dash, linewidth=line.width)
    draw_marks(axes, line, place, size, filled=~divergent)


def _draw_side(upper: Axes, lower: Axes, line: Line, place_of: Transform, *, several: bool) -> None:
    one = line.data
    place, lead = one[str(one.attrs["along"])].values, np.degrees(one["shaft_lead"].values)
    for name, (mark, filled) in SCENARIO_MARKS.items():
        of_scenario = one["scenario"].values == name
        face = line.colour if filled else "white"
        shape = line.mark if several else mark
        (marks,) = upper.plot(place[of_scenario], lead[of_scenario], shape, color=line.colour)
        marks.set_transform(place_of)
        marks.set(markerfacecolor=face, markersize=SIZES[-1] if several else line.size)
    lower.plot(
        place,
        one["lead_steadiness"].values,
        marker=".",
        markersize=line.size,
        color=line.colour,
        linestyle=line.dash,
        linewidth=line.width,
    )


def _draw_whirl(axes: Axes, line: Line, place_of: Transform) -> None:
    one, before = line.data, set(axes.get_children())
    place, frequency = one[str(one.attrs["along"])].values, one["frequency"].values
    clear = np.isin(one["direction"].values, ["forward", "backward"])
    axes.plot(
        place,
        np.where(clear, frequency, np.nan),
        color=line.colour,
        linestyle=line.dash,
        linewidth=line.width,
    )
    axes.errorbar(
        place,
        frequency,
        one["scatter"].fillna(0.0).values,
        color=line.colour,
        linestyle="none",
        elinewidth=0.6 * line.width,
        capsize=1.5,
    )
    draw_marks(axes, line, place, frequency, filled=clear)
    for artist in set(axes.get_children()) - before:  # the axes know the data by now
        artist.set_transform(place_of)
