"""Whirling modes of a shaft line: deflection along the shaft, and the orbits of its nodes."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.meshes.plane import rotate
from bladewhirl.postprocess.plotting.style import (
    COLOURS,
    FULL_WIDTH,
    NARROW,
    drawn_width,
    new_figure,
    styled,
)
from bladewhirl.postprocess.plotting.titles import set_title

WHIRL: Mapping[str, str] = {
    "forward": COLOURS["k = 1"],
    "backward": COLOURS["k = 0"],
    "planar": COLOURS["total"],
    "axial": COLOURS["casing"],
    "torsional": COLOURS["suspension"],
}
"""Colours of the directions of modes."""

ORBITS = 9  #: largest number of orbits drawn along a shaft
LEAN = 0.35  #: horizontal extent of an orbit, as a fraction of the distance of two orbits


@styled
def plot_line_modes(data: xr.Dataset) -> Figure:
    """Draw modes from `bladewhirl.line_modes`.

    Each panel shows the axis of the shaft at the largest displacement in a turn, and the orbits of
    some nodes seen from the side; a dot marks the position on each orbit at the same instant. The
    line is turned about its axis so that its largest displacement points up.
    """
    count = data.sizes["mode"]
    columns = 1 if drawn_width(FULL_WIDTH) < NARROW else 2
    rows = -(-count // columns)
    figure = new_figure(width=FULL_WIDTH, height=0.012 + 0.032 * rows)
    panels = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False).ravel()
    for axes, number in zip(panels, range(count), strict=False):
        _draw_mode(axes, data.isel(mode=number))
    for axes in panels[count:]:
        axes.set_visible(False)
    for axes in panels[max(0, count - columns) : count]:
        axes.set_xlabel("position along the shaft [m]")
        axes.tick_params(labelbottom=True)
    figure.supylabel("displacement / largest", fontsize="medium")
    set_title(figure, str(data.attrs["title"]), f"Modes at {data.attrs['speed_rpm']:.6g} rpm")
    return figure


def _upright(displacement: FloatArray) -> FloatArray:
    """Return displacements (instant, axis, position), turned about the shaft so that the largest
    one at the first instant points up."""
    x, y = displacement[0]
    most = int(np.hypot(x, y).argmax())
    angle = np.pi / 2.0 - np.arctan2(y[most], x[most])
    return np.stack([rotate(each, angle, axis=0) for each in displacement])


def _draw_mode(axes: Axes, mode: xr.Dataset) -> None:
    position = mode["position"].values
    start, later = _upright(mode["displacement"].values)
    whirl = str(mode["direction"].values)
    colour = WHIRL[whirl]
    axes.axhline(0.0, color=COLOURS["rest"], linewidth=0.6, zorder=0)
    angle = np.linspace(0.0, 2.0 * np.pi, 61)
    shown = np.unique(np.linspace(0, len(position) - 1, ORBITS).round().astype(int))
    lean = LEAN * (position[-1] - position[0]) / ORBITS
    for node in shown:
        x, y = np.outer(start[:, node], np.cos(angle)) + np.outer(later[:, node], np.sin(angle))
        axes.plot(position[node] + lean * x, y, color=colour, linewidth=0.6)
        axes.plot(position[node] + lean * x[0], y[0], "o", color=colour, markersize=2.0)
    axes.plot(position + lean * start[0], start[1], color=colour, linewidth=1.2)
    bottom = -1.25
    axes.set_ylim(bottom, 1.25)
    marks: dict[str, Any] = {"linestyle": "none", "color": COLOURS["total"], "clip_on": False}
    axes.plot(
        mode.attrs["bearing_position"],
        np.full(len(mode.attrs["bearing_position"]), bottom),
        marker="^",
        markersize=4.5,
        **marks,
    )
    for place in mode.attrs["disk_position"]:
        axes.axvline(place, color=COLOURS["rest"], linewidth=2.0, zorder=0)
    name = f"{float(mode['frequency']):.5g} Hz, {whirl}"
    axes.set_title(f"mode {int(mode['mode'])}: {name}, decay {-float(mode['decay']):.3g} 1/s")
