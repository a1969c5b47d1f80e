"""The orbit of the shaft's centre in rotating and in static axes, and which way it whirls."""

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from bladewhirl.postprocess.fields.kinematics import Array, rotate, smallest_clearance
from bladewhirl.postprocess.fields.labelled import labelled
from bladewhirl.postprocess.fields.result import reduce_modes
from bladewhirl.postprocess.fields.windows import in_window, late_part
from bladewhirl.postprocess.plotting.style import COLOURS, new_figure, speed_label, styled
from bladewhirl.postprocess.plotting.units import length_unit
from bladewhirl.postprocess.shaft.whirl import FRAMES, whirl

LONG_LINE = 5000
"""Points above which a line is a picture inside a PDF: such files would grow unwieldy."""

SEEN = 0.1
"""Share of the axes that a turn must span for arrows on it to be read."""

TINY = 0.05
"""Radius of an orbit, over the clearance, below which the clearance is not drawn around it."""

PALE = "#B0B0B0"
CLEARANCE_LINE: dict[str, Any] = {
    "color": COLOURS["casing"],
    "linestyle": "--",
    "linewidth": 1.2,
    "zorder": 3,  # above the path, which covers it in a growing motion
}
ARROW = {
    "arrowstyle": "-|>,head_width=0.25,head_length=0.5",
    "color": COLOURS["rotor"],
    "shrinkA": 0.0,
    "shrinkB": 0.0,
}
MILLI = 1e3


def shaft_orbit(
    result: xr.Dataset, *, start: float | None = None, end: float | None = None
) -> xr.Dataset:
    """Displacement and velocity of the shaft's centre in both frames.

    Args:
        result: of a run, or an orbit already, of which the window is taken.
        start: of the window [s]; of the run when None.
        end: of the window [s]; of the run when None.

    Returns:
        over (time, axis): `rotating` and `static` [m]; `rotating_velocity` and `static_velocity`
        [m/s], the rates of each as seen in its own axes, so the static one is
        R (u_dot + Omega x u). Over time: `radius` [m], the same in both. A clamped centre rests
        at 0.

    Example:
        ``shaft_orbit(result, start=1.0)["radius"].plot()``
    """
    result = in_window(result, start, end)
    if "rotating" in result:
        return result
    centre = result["rotor_shape"].isel(rotor_node=int(result["centre_node"]))
    rows = centre.values[:2]  # x and y, each over the modes
    rotating = reduce_modes(result, "rotor_displacement", rows)
    velocity = reduce_modes(result, "rotor_velocity", rows)
    speed, time = float(result.attrs["speed"]), result["time"].values
    carried = speed * np.column_stack([-rotating[:, 1], rotating[:, 0]])
    plane = ("time", "axis")
    return labelled(
        result,
        "orbit of the shaft's centre",
        {
            "rotating": (plane, rotating, "m"),
            "rotating_velocity": (plane, velocity, "m/s"),
            "static": (plane, rotate(rotating, speed * time), "m"),
            "static_velocity": (plane, rotate(velocity + carried, speed * time), "m/s"),
            "radius": ("time", np.hypot(*rotating.T), "m"),
        },
        {"time": time, "axis": ["x", "y"]},
        smallest_clearance=smallest_clearance(result),
    )


@styled
def plot_orbit(orbit: xr.Dataset) -> Figure:
    """Draw an orbit from `shaft_orbit` in rotating and static axes, side by side.

    The whole motion is thin and pale; the last turn about the origin within the last third of the
    time (or that third, where it makes less) is strong, with arrows along it. Each frame's title
    names the whirl over the last third. Axes fit the clearance; where the orbit is tiny beside it
    they fit the orbit, and the clearance is told in words.
    """
    late = late_part(orbit)
    clearance, radius = orbit.attrs["smallest_clearance"], float(orbit["radius"].max())
    tiny = 0.0 < radius < TINY * clearance
    reach = radius if tiny else max(radius, clearance)
    unit, scale = length_unit(reach)
    edge = 1.1 * scale * reach or 1.0  # all at rest: 1 mm
    figure = new_figure(height=0.062)
    panels = figure.subplots(1, 2, sharex=True, sharey=True)
    for axes, frame in zip(panels, FRAMES, strict=True):
        axes.set(aspect="equal", xlim=(-edge, edge), ylim=(-edge, edge), xlabel=f"x [{unit}]")
        if not tiny:
            axes.add_patch(Circle((0, 0), scale * clearance, fill=False, **CLEARANCE_LINE))
        _draw_path(axes, scale * orbit[frame].values)
        _draw_turn(axes, _last_turn(scale * late[frame].values), edge)
        axes.set_title(f"{frame} frame\n{whirl(late, frame).text}")
    panels[0].set_ylabel(f"y [{unit}]")
    if not tiny:
        panels[0].plot([], [], label="clearance", **CLEARANCE_LINE)
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
    outside = f"\n(the clearance, {MILLI * clearance:.3g} mm, is far outside)" if tiny else ""
    figure.suptitle(f"orbit of the shaft, {speed_label(orbit)}{outside}")
    return figure


def _draw_path(axes: Axes, place: Array) -> None:
    """A whole path (record, 2), its start and its end."""
    axes.plot(*place.T, color=PALE, linewidth=0.4, rasterized=len(place) > LONG_LINE)
    ends: dict[str, Any] = {"color": COLOURS["rotor"], "linestyle": "none", "markersize": 4}
    axes.plot(*place[:1].T, marker="o", markerfacecolor="white", label="start", **ends)
    axes.plot(*place[-1:].T, marker="s", label="end", **ends)


def _draw_turn(axes: Axes, path: Array, edge: float) -> None:
    """The end of a path, with arrows where it is seen as a line; axes reach to `edge`."""
    long = len(path) > LONG_LINE
    axes.plot(*path.T, color=COLOURS["rotor"], label="late motion", rasterized=long)
    if np.ptp(path, axis=0).max() > SEEN * edge:
        for share in (0.2, 0.5, 0.8):
            _draw_arrow(axes, path, share)


def _draw_arrow(axes: Axes, path: Array, share: float) -> None:
    """An arrow head on a path, at that share of its length."""
    travelled = np.append(0.0, np.cumsum(np.hypot(*np.diff(path, axis=0).T)))
    ahead = int(np.searchsorted(travelled, share * travelled[-1]))
    axes.annotate("", path[ahead], path[ahead - 1], arrowprops=ARROW)


def _last_turn(place: Array) -> Array:
    """The end of a path (record, 2) that turns once about the origin; all of it if it does not."""
    angle = np.unwrap(np.arctan2(place[:, 1], place[:, 0]))
    before = np.flatnonzero(np.abs(angle - angle[-1]) >= 2 * np.pi)
    return place[before[-1] if len(before) else 0 :]
