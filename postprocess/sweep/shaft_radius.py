"""Displacement of the shaft over a swept key (Fig. 24)."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bladewhirl.postprocess.plotting.legends import Group, legends_below, set_title
from bladewhirl.postprocess.plotting.style import FULL_WIDTH, new_figure, styled
from bladewhirl.postprocess.plotting.units import length_unit
from bladewhirl.postprocess.sweep.drawing import (
    MOST_LINES,
    Line,
    draw_marks,
    left_out_note,
    lines_group,
    lines_of,
    mark_entry,
)
from bladewhirl.postprocess.sweep.quantities import LINE
from bladewhirl.postprocess.sweep.swept_axes import in_handy_units, key_axis

WIDE = 1e3
"""Ratio of the largest to the median displacement from which its axis is logarithmic."""

PARTS = {"shaft_radius_max": "largest", "shaft_radius_final": "at the end"}


@styled
def plot_shaft_radius(radius: xr.Dataset) -> Figure:
    """Draw largest and final displacements in mm or µm, a line for each other combination.

    Divergent points are open: their march was ended, or the motion would have grown further.

    Args:
        radius: from `sweep_quantities.shaft_radius`.
    """
    radius = in_handy_units(radius)
    unit, scale = length_unit(float(radius["shaft_radius_max"].max().fillna(0.0)))
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
    set_title(figure, radius.attrs["title"] + left_out_note(radius.sizes[LINE], MOST_LINES))
    divergent = (radius["regime"] == "divergent").any()
    marks = [mark_entry("o", "divergent (open marks)", filled=False)] if divergent else []
    legends_below(figure, Group(marks), lines_group(radius, lines, "shaft_radius_max"))
    return figure


def _draw_line(axes: Axes, line: Line, name: str, scale: float) -> None:
    place = line.data[str(line.data.attrs["along"])].values
    size = scale * line.data[name].values
    divergent = line.data["regime"].values == "divergent"
    axes.plot(place, size, color=line.colour, linestyle=line.dash, linewidth=line.width)
    draw_marks(axes, line, place, size, filled=~divergent)
