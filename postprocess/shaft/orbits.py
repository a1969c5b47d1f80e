"""Orbit of the shaft's centre in rotating and static axes."""

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from bladewhirl.meshes.plane import rotate
from bladewhirl.models.inputs.units import handy, handy_unit
from bladewhirl.postprocess.fields import rotation
from bladewhirl.postprocess.fields.kinematics import Array, smallest_clearance
from bladewhirl.postprocess.fields.labelled import labelled
from bladewhirl.postprocess.fields.netcdf import need
from bladewhirl.postprocess.fields.result import reduce_modes
from bladewhirl.postprocess.fields.windows import in_window, late_part
from bladewhirl.postprocess.plotting.style import COLOURS, new_figure, styled, time_axis
from bladewhirl.postprocess.plotting.titles import head
from bladewhirl.postprocess.shaft.whirl import FRAMES, centre_rests, whirl

LONG_LINE = 5000
"""A line of more points than this is a raster image in a PDF, to limit the size of the file."""

#: the clearance is not drawn if the radius of the orbit is below this fraction of the clearance
TINY = 0.05
DRAWN_TURNS = 2.0  #: number of turns of the shaft, at the end, that are drawn black
PALE = "#B0B0B0"
CLEARANCE_LINE: dict[str, Any] = {
    "color": COLOURS["casing"],
    "linestyle": "--",
    "linewidth": 1.2,
    "zorder": 3,  # above the path, which covers it in a growing motion
}
END_MARK: dict[str, Any] = {"color": COLOURS["rotor"], "linestyle": "none", "markersize": 4}
MILLI = 1e3


def shaft_orbit(
    result: xr.Dataset, *, start: float | None = None, end: float | None = None
) -> xr.Dataset:
    """Compute displacement and velocity of the shaft's centre in both frames.

    Args:
        result: result of a run; or an orbit that this function returned, which is then cut to the
            time window.
        start, end: limits of the time window [s]; start and end of the run when None.

    Returns:
        Dataset over (time, axis): `rotating` and `static`, the components of the displacement in
        the two frames [m]; `rotating_velocity` and `static_velocity`, the rates of these components
        [m/s]. With the displacement u in rotating axes and the rotation R from rotating to static
        axes the static velocity is R (u_dot + Omega x u). Over time: `radius` [m], the length of
        the displacement. All are zero for a clamped centre.

    Example:
        ``shaft_orbit(result, start=1.0)["radius"].plot()``
    """
    result = in_window(result, start, end)
    if "rotating" in result:
        return result
    rotating = centre_displacement(result)
    velocity = reduce_modes(result, "rotor_velocity", _centre_rows(result))
    time, speed = result.variables["time"].values, rotation.speeds(result)
    carried = speed[:, None] * np.column_stack([-rotating[:, 1], rotating[:, 0]])
    angle = rotation.angles(result)
    static, static_velocity = rotate(np.stack([rotating, velocity + carried]), angle)
    plane = ("time", "axis")
    return labelled(
        result,
        "orbit of the shaft's centre",
        {
            "rotating": (plane, rotating, "m"),
            "rotating_velocity": (plane, velocity, "m/s"),
            "static": (plane, static, "m"),
            "static_velocity": (plane, static_velocity, "m/s"),
            "radius": ("time", np.hypot(*rotating.T), "m"),
            **rotation.histories(result),
        },
        {"time": time, "axis": ["x", "y"]},
        smallest_clearance=smallest_clearance(result),
    )


def centre_displacement(result: xr.Dataset) -> Array:
    """Return the displacement of the shaft's centre in rotating axes at every record of a result
    [m], (time, 2)."""
    return reduce_modes(result, "rotor_displacement", _centre_rows(result))


def _centre_rows(result: xr.Dataset) -> Array:
    """Return x and y of the shaft's centre for unit modal coordinates, (2, rotor_mode)."""
    need(result, "centre_shape")
    return np.asarray(result.variables["centre_shape"].values)


@styled
def plot_orbit(orbit: xr.Dataset) -> Figure:
    """Draw an orbit from `shaft_orbit` in both frames, and the radius of its last turns over time.

    The complete motion is pale, the last two turns are black. Titles give direction and frequency
    of the whirl over the last third of the time. A circle shows the clearance; if the orbit is much
    smaller than the clearance, the axes fit the orbit, and the title gives the clearance instead.
    """
    late = last_turns(orbit)
    clearance, radius = orbit.attrs["smallest_clearance"], float(orbit["radius"].max())
    rests = centre_rests(orbit)
    tiny = not rests and radius < TINY * clearance
    reach = radius if tiny else max(radius, clearance)
    unit, scale = handy_unit(reach, "m")
    edge = 1.1 * scale * reach or 1.0  # 1 mm if nothing moves
    figure = new_figure(height=0.1)
    panels = figure.subplot_mosaic([[*FRAMES], ["radius"] * 2], height_ratios=(2.4, 1.0))
    drawn = handy(float(np.ptp(late["time"].values)), "s", 3)
    for frame in FRAMES:
        axes, turn = panels[frame], scale * late[frame].values
        axes.set(aspect="equal", xlim=(-edge, edge), ylim=(-edge, edge), xlabel=f"x [{unit}]")
        axes.locator_params(nbins=5)
        axes.yaxis.set_major_locator(axes.xaxis.get_major_locator())
        if not tiny:
            axes.add_patch(Circle((0, 0), scale * clearance, fill=False, **CLEARANCE_LINE))
        path, long = scale * orbit[frame].values, orbit.sizes["time"] > LONG_LINE
        axes.plot(*path.T, color=PALE, linewidth=0.4, label="whole motion", rasterized=long)
        axes.plot(*path[:1].T, marker="o", markerfacecolor="white", label="start", **END_MARK)
        axes.plot(*path[-1:].T, marker="s", label="end", **END_MARK)
        long = len(turn) > LONG_LINE
        axes.plot(*turn.T, color=COLOURS["rotor"], label=f"last {drawn}", rasterized=long)
        axes.set_title(f"{frame} frame\n{whirl(late_part(orbit), frame).text}")
    panels[FRAMES[0]].set_ylabel(f"y [{unit}]")
    panels[FRAMES[1]].tick_params(labelleft=False)
    highest = clearance if rests else float(late["radius"].max())
    radius_unit, radius_scale = handy_unit(highest, "m")
    below = panels["radius"]
    below.plot(late["time"], radius_scale * late["radius"], color=COLOURS["rotor"])
    top = 1.1 * radius_scale * highest or 1.0
    below.set(ylabel=f"radius [{radius_unit}]", ylim=(0.0, top))
    below.locator_params(axis="y", nbins=4)
    time_axis(below)
    if not tiny:
        panels[FRAMES[0]].plot([], [], label="clearance", **CLEARANCE_LINE)
    entries = panels[FRAMES[0]].get_legend_handles_labels()
    figure.legend(*entries, loc="outside lower center", ncols=3)
    head(figure, orbit, *([f"clearance {handy(clearance, 'm', 3)}"] if tiny else []))
    return figure


def last_turns(orbit: xr.Dataset) -> xr.Dataset:
    """Return the records of the last two turns of the shaft in the frame with the faster whirl.

    Without whirl these are the last two periods of the reference frequency. In any case at most the
    last third of the time is returned.
    """
    late = late_part(orbit)
    rates = [abs(turn.rate) for frame in FRAMES if (turn := whirl(late, frame)).goes_round]
    length = DRAWN_TURNS * 2 * np.pi / max(rates, default=orbit.attrs["reference_frequency"])
    return late.sel(time=slice(late["time"].values[-1] - length, None))
