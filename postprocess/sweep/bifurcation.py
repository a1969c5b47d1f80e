"""Bifurcation diagram of a sweep: what recurs of the late motion, over a swept key."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from bladewhirl.models.inputs.units import handy_unit
from bladewhirl.postprocess.plotting.style import FULL_WIDTH, new_figure, styled
from bladewhirl.postprocess.shaft.orbits import LONG_LINE
from bladewhirl.postprocess.sweep.axes import in_handy_units, key_axis
from bladewhirl.postprocess.sweep.drawing import label_figure, lines_group, lines_of
from bladewhirl.postprocess.sweep.quantities import along

PARTS = {
    "section_x": "x once a revolution",
    "section_radius": "radius once a revolution",
    "radius_peak": "local maxima of radius",
}

DOT = 2.2  #: size of marks [points]


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
    data = along(dataset, key, ["section_x", "section_y", "radius_peak"])
    radius = ((data["section_x"] ** 2 + data["section_y"] ** 2) ** 0.5).assign_attrs(units="m")
    return data.assign(section_radius=radius).assign_attrs(
        title="bifurcation diagram: the shaft in the last third of each march"
    )


@styled
def plot_bifurcation(data: xr.Dataset) -> Figure:
    """Draw sections and maxima in mm or µm as markers.

    Args:
        data: from `bifurcation`.
    """
    data = in_handy_units(data)
    largest = max(float(np.nanmax(np.abs(data[name].values), initial=0.0)) for name in PARTS)
    unit, scale = handy_unit(largest, "m")
    lines = lines_of(data)
    figure = new_figure(width=FULL_WIDTH, height=0.17)
    panels = figure.subplots(len(PARTS), 1, sharex=True)
    for axes, (name, label) in zip(panels, PARTS.items(), strict=True):
        for line in lines:
            values = scale * line.data[name].values
            axes.plot(
                np.repeat(line.place, values.shape[1]),
                values.ravel(),
                line.mark,
                color=line.colour,
                markersize=DOT,
                markeredgewidth=0.0,
                rasterized=values.size > LONG_LINE,
            )
        axes.set_ylabel(f"{label} [{unit}]")
    key_axis(panels[-1], data)
    label_figure(figure, data, lines_group(lines, dashed=False))
    return figure
