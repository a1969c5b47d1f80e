"""Displacement of the shaft over a swept key (Fig. 24)."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bladewhirl.postprocess.orbits import MILLI
from bladewhirl.postprocess.style import FULL_WIDTH, new_figure, styled
from bladewhirl.postprocess.sweep_drawing import (
    MOST_LINES,
    Line,
    key_axis,
    left_out_note,
    lines_of,
)
from bladewhirl.postprocess.sweep_quantities import LINE

WIDE = 1e3
"""Ratio of the largest to the median displacement from which its axis is logarithmic."""

PARTS = {"shaft_radius_max": "largest", "shaft_radius_final": "at the end"}


@styled
def plot_shaft_radius(radius: xr.Dataset) -> Figure:
    """Draw largest and final displacements in mm, a line for each other combination.

    Divergent points are open: their march was ended, or the motion would have grown further.

    Args:
        radius: from `sweep_quantities.shaft_radius`.
    """
    figure = new_figure(width=FULL_WIDTH, height=0.11)
    panels = figure.subplots(2, 1, sharex=True)
    for axes, (name, label) in zip(panels, PARTS.items(), strict=True):
        for line in lines_of(radius):
            _draw_line(axes, line, name)
        values = MILLI * radius[name].values
        moving = values[values > 0]
        if moving.size and moving.max() > WIDE * np.median(moving):
            axes.set_yscale("log")
        else:
            axes.set_ylim(bottom=0.0)
        axes.set_ylabel(f"{label} [mm]")
    key_axis(panels[1], radius)
    if (radius["regime"] == "divergent").any():
        panels[0].plot([], [], "o", markersize=3.5, mfc="white", mec="black", label="divergent")
    figure.suptitle(radius.attrs["title"] + left_out_note(radius.sizes[LINE], MOST_LINES))
    handles, labels = panels[0].get_legend_handles_labels()
    if handles:
        figure.legend(handles, labels, loc="outside lower center", ncols=4)
    return figure


def _draw_line(axes: Axes, line: Line, name: str) -> None:
    place = line.data[str(line.data.attrs["along"])].values
    size = MILLI * line.data[name].values
    divergent = line.data["regime"].values == "divergent"
    axes.plot(place, size, color=line.colour, label=line.label or None)
    axes.plot(place[~divergent], size[~divergent], "o", markersize=2.5, color=line.colour)
    axes.plot(place[divergent], size[divergent], "o", markersize=3.5, mfc="white", mec=line.colour)
