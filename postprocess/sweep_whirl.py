"""Whirl of the shaft, and the side of its contact, over a swept key."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bladewhirl.postprocess.style import COLOURS, FULL_WIDTH, new_figure, styled
from bladewhirl.postprocess.sweep_drawing import (
    MOST_LINES,
    Line,
    key_axis,
    left_out_note,
    lines_of,
)
from bladewhirl.postprocess.sweep_quantities import LINE

SCENARIO_MARKS: Mapping[str, tuple[str, bool]] = {
    "standard": ("o", True),
    "inverted": ("s", True),
    "unsteady": ("o", False),
}
"""Mark of each scenario, and whether it is filled."""


@styled
def plot_whirls(found: xr.Dataset) -> Figure:
    """Draw the whirl's frequency in both frames in Hz, forward upwards, with its scatter.

    Filled marks have a clear direction. A shaft that hardly moves has no mark.

    Args:
        found: from `sweep_quantities.whirls`.
    """
    figure = new_figure(width=FULL_WIDTH, height=0.12)
    panels = figure.subplots(2, 1, sharex=True)
    for axes, frame in zip(panels, found["frame"].values, strict=True):
        axes.axhline(0.0, color=COLOURS["total"], linewidth=0.6)
        for line in lines_of(found.sel(frame=frame)):
            _draw_whirl(axes, line)
        axes.set_ylabel(f"{frame} frame [Hz]\n← backward  forward →")
        axes.margins(y=0.1)
    for name, filled in (("clear direction", True), ("no clear direction", False)):
        face = COLOURS["rotor"] if filled else "white"
        panels[0].plot([], [], "o", color=COLOURS["rotor"], mfc=face, markersize=3, label=name)
    key_axis(panels[1], found)
    figure.suptitle(found.attrs["title"] + left_out_note(found.sizes[LINE], MOST_LINES))
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return figure


@styled
def plot_contact_sides(found: xr.Dataset) -> Figure:
    """Draw by how much the shaft leads the contact, and how steadily.

    Within 90 degrees, the grey band, contact is standard, outside it is inverted; open marks are
    motions without a steady lead.

    Args:
        found: from `sweep_quantities.contact_sides`.
    """
    figure = new_figure(width=FULL_WIDTH, height=0.11)
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(2.0, 1.0))
    lines = list(lines_of(found))
    key = str(found.attrs["along"])
    for line in lines:
        place, lead = line.data[key].values, np.degrees(line.data["shaft_lead"].values)
        for name, (mark, filled) in SCENARIO_MARKS.items():
            own = line.data["scenario"].values == name
            face = line.colour if filled else "white"
            upper.plot(place[own], lead[own], mark, color=line.colour, mfc=face, markersize=3.5)
        steadiness = line.data["lead_steadiness"].values
        lower.plot(
            place,
            steadiness,
            ".-",
            color=line.colour,
            markersize=3,
            linewidth=0.7,
            label=line.label or None,
        )
    band = upper.axhspan(-90, 90, color=COLOURS["rest"], alpha=0.25, linewidth=0, zorder=0)
    band.set_label("standard")
    for name, (mark, filled) in SCENARIO_MARKS.items():
        count = int((found["scenario"] == name).sum())
        face = COLOURS["rotor"] if filled else "white"
        label = f"{name}: {count}"
        upper.plot([], [], mark, color=COLOURS["rotor"], mfc=face, markersize=3.5, label=label)
    upper.set(ylim=(-190, 190), yticks=(-180, -90, 0, 90, 180), ylabel="shaft leads [°]")
    lower.set(ylim=(0.0, 1.05), ylabel="steadiness")
    key_axis(lower, found)
    figure.suptitle(found.attrs["title"] + left_out_note(found.sizes[LINE], MOST_LINES))
    handles, labels = upper.get_legend_handles_labels()
    more = lower.get_legend_handles_labels()
    figure.legend(handles + more[0], labels + more[1], loc="outside lower center", ncols=4)
    return figure


def _draw_whirl(axes: Axes, line: Line) -> None:
    one = line.data
    place, frequency = one[str(one.attrs["along"])].values, one["frequency"].values
    axes.errorbar(
        place,
        frequency,
        one["scatter"].fillna(0.0).values,
        color=line.colour,
        linewidth=0.8,
        elinewidth=0.8,
        capsize=1.5,
        label=line.label or None,
    )
    clear = np.isin(one["direction"].values, ["forward", "backward"])
    for own, face in ((clear, line.colour), (~clear, "white")):
        axes.plot(place[own], frequency[own], "o", color=line.colour, mfc=face, markersize=3)
