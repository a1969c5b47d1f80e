"""Map of critical speeds against the stiffness of the shaft."""

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from bladewhirl.postprocess.plotting.axes import coloured_line
from bladewhirl.postprocess.plotting.legends import Group, entries_of, legends_below
from bladewhirl.postprocess.plotting.style import COLOURS, COLUMN_WIDTH, new_figure, styled
from bladewhirl.postprocess.plotting.titles import set_title

WIDTHS = {"forward": 1.6, "backward": 0.7}
"""Widths of the lines of forward and of backward critical speeds [points]."""


@styled
def plot_critical_speeds(data: xr.Dataset) -> Figure:
    """Draw the critical speeds from `bladewhirl.critical_speeds` against the shaft stiffness.

    Colours show the share of the shaft springs in the strain energy. If this share is large, the
    disk moves on its springs, and the critical speed increases with the root of the stiffness; if
    the share is small, the blades bend. Grey lines are stiffness and speed of the case.
    """
    figure = new_figure(width=COLUMN_WIDTH, height=0.09)
    axes = figure.subplots()
    stiffness, speeds = data["stiffness"].values, data["critical_speed"]
    low, high = float(speeds.min()), float(speeds.max())
    axes.set(
        xscale="log",
        xlim=(stiffness[0], stiffness[-1]),
        yscale="log",
        ylim=(0.8 * low, 1.25 * high),
        xlabel="stiffness of each shaft spring [N/m]",
        ylabel="critical speed [rpm]",
    )
    grey: Any = {"color": COLOURS["rest"], "linewidth": 0.8, "zorder": 1}
    axes.axvline(data.attrs["case_stiffness"], label="stiffness and speed of the case", **grey)
    if data.attrs["case_speed"] > 0.0:
        axes.axhline(data.attrs["case_speed"], **grey)
    for direction, width in WIDTHS.items():
        axes.plot([], [], color=COLOURS["total"], linewidth=width, label=direction)
        for branch in data["branch"].values:
            line = {"direction": direction, "branch": branch}
            speed, share = (
                data[name].sel(line).values for name in ("critical_speed", "spring_share")
            )
            if np.isfinite(speed).sum() > 1:
                lines = coloured_line(axes, stiffness, speed, share)
                lines.set_linewidth(width)
    figure.colorbar(
        lines, ax=axes, label="share of energy in the shaft springs [–]", location="top", aspect=30
    )
    set_title(figure, data.attrs["case"], "Critical speeds against shaft stiffness")
    legends_below(figure, Group(entries_of(axes)))
    return figure
