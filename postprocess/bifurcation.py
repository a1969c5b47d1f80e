"""Bifurcation diagram of a sweep: what recurs of the late motion, over a swept key."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bladewhirl.postprocess.orbits import LONG_LINE, MILLI
from bladewhirl.postprocess.style import FULL_WIDTH, new_figure, styled
from bladewhirl.postprocess.sweep_drawing import (
    MOST_LINES,
    Line,
    key_axis,
    left_out_note,
    lines_of,
)
from bladewhirl.postprocess.sweep_quantities import LINE, along

PARTS = {
    "section_x": "x once a revolution [mm]",
    "section_radius": "radius once a revolution [mm]",
    "radius_peak": "local maxima of radius [mm]",
}


def bifurcation(dataset: xr.Dataset, key: str) -> xr.Dataset:
    """Poincaré sections and local maxima of the shaft's displacement in the last third.

    A motion that repeats with every revolution has one section, one that repeats with every
    second has two, a whirl out of step with the rotor lies in a band; a circle about the origin has
    one radius in any case.

    Args:
        dataset: from `open_sweep`.
        key: dimension to go along.

    Returns:
        over (line, key, section) [m]: `section_x` and `section_y`, whenever blade 0 lies on +x, so
        the same in both frames; `section_radius`; `radius_peak`. NaN behind the last.
    """
    found = along(dataset, key, ["section_x", "section_y", "radius_peak"])
    radius = ((found["section_x"] ** 2 + found["section_y"] ** 2) ** 0.5).assign_attrs(units="m")
    return found.assign(section_radius=radius).assign_attrs(
        title="bifurcation diagram: the shaft in the last third of each march"
    )


@styled
def plot_bifurcation(found: xr.Dataset) -> Figure:
    """Draw sections and maxima in mm, a dot each.

    Args:
        found: from `bifurcation`.
    """
    figure = new_figure(width=FULL_WIDTH, height=0.15)
    panels = figure.subplots(len(PARTS), 1, sharex=True)
    for axes, (name, label) in zip(panels, PARTS.items(), strict=True):
        for line in lines_of(found):
            _draw_dots(axes, line, name)
        axes.set_ylabel(label)
    key_axis(panels[-1], found)
    figure.suptitle(found.attrs["title"] + left_out_note(found.sizes[LINE], MOST_LINES))
    handles, labels = panels[0].get_legend_handles_labels()
    if handles:
        figure.legend(handles, labels, loc="outside lower center", ncols=4, markerscale=3)
    return figure


def _draw_dots(axes: Axes, line: Line, name: str) -> None:
    values = MILLI * line.data[name].values
    place = np.repeat(line.data[str(line.data.attrs["along"])].values, values.shape[1])
    axes.plot(
        place,
        values.ravel(),
        ".",
        color=line.colour,
        markersize=3.0,
        markeredgewidth=0.0,
        rasterized=values.size > LONG_LINE,
        label=line.label or None,
    )
