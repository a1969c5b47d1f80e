"""Bifurcation diagram of a sweep: what recurs of the late motion, over a swept key."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.transforms import Transform

from bladewhirl.models.inputs.units import handy_unit
from bladewhirl.postprocess.plotting.style import FULL_WIDTH, new_figure, styled
from bladewhirl.postprocess.shaft.orbits import LONG_LINE
from bladewhirl.postprocess.sweep.axes import in_handy_units, key_axis
from bladewhirl.postprocess.sweep.drawing import (
    SIDE_BY_SIDE,
    Line,
    dodged,
    label_figure,
    lines_group,
    lines_of,
)
from bladewhirl.postprocess.sweep.quantities import along

PARTS = {
    "section_x": "x once a revolution",
    "section_radius": "radius once a revolution",
    "radius_peak": "local maxima of radius",
}

FEW = 10
"""Revolutions below which marks show how a motion settles rather than how it repeats."""

DOT = 2.2
"""Size of marks [points]."""


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
    """Draw sections and maxima in mm or µm as markers; those of several lines are side by side.

    Args:
        data: from `bifurcation`.
    """
    data = in_handy_units(data)
    largest = max(float(np.nanmax(np.abs(data[name].values), initial=0.0)) for name in PARTS)
    unit, scale = handy_unit(largest, "m")
    lines = [line._replace(size=DOT) for line in lines_of(data)]
    figure = new_figure(width=FULL_WIDTH, height=0.17)
    panels = figure.subplots(len(PARTS), 1, sharex=True)
    for axes, (name, label) in zip(panels, PARTS.items(), strict=True):
        for number, line in enumerate(lines):
            _draw_marks(axes, line, scale, name, dodged(axes, number, len(lines)))
        axes.set_ylabel(f"{label} [{unit}]")
    key_axis(panels[-1], data)
    group = lines_group(data, lines, "radius_peak", dashed=False)
    turns = int(np.isfinite(data["section_x"].values).sum(axis=-1).max(initial=0))
    few = f"\nrevolutions in it, at most: {turns}, too few to tell motions apart"
    peaks = np.isfinite(data["radius_peak"].values)
    most = f"\nof maxima the last {peaks.shape[-1]} at most" if peaks.all(axis=-1).any() else ""
    note = (SIDE_BY_SIDE if len(lines) > 1 else "") + most + (few if turns < FEW else "")
    label_figure(figure, data, group, note=note)
    return figure


def _draw_marks(axes: Axes, line: Line, scale: float, name: str, place_of: Transform) -> None:
    values = scale * line.data[name].values
    (marks,) = axes.plot(
        np.repeat(line.data[str(line.data.attrs["along"])].values, values.shape[1]),
        values.ravel(),
        line.mark,
        color=line.colour,
        markersize=line.size,
        markeredgewidth=0.0,
        rasterized=values.size > LONG_LINE,
    )
    marks.set_transform(place_of)
