"""State space and Poincaré map of the shaft (the paper's Figs 20c and d)."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from bladewhirl.models.inputs.units import handy_unit
from bladewhirl.postprocess.fields import rotation
from bladewhirl.postprocess.fields.kinematics import Array, ViewError
from bladewhirl.postprocess.fields.labelled import labelled
from bladewhirl.postprocess.fields.windows import late_part, window_label
from bladewhirl.postprocess.plotting.style import COLOURS, new_figure, styled
from bladewhirl.postprocess.plotting.titles import head
from bladewhirl.postprocess.shaft.orbits import LONG_LINE, PALE, shaft_orbit
from bladewhirl.postprocess.shaft.transforms import Frame


def poincare_map(
    result: xr.Dataset,
    frame: Frame = "static",
    *,
    start: float | None = None,
    end: float | None = None,
) -> xr.Dataset:
    """Compute position and velocity of the shaft once a revolution, whenever blade 0 lies on +x.

    Between records the position is interpolated by cubics through positions and velocities, the
    velocity by a cubic spline. A motion that repeats with every revolution gives a single point.

    Args:
        result: result of a run, or its orbit from `orbits.shaft_orbit`.
        frame: frame of the observer; the paper uses the static frame.
        start, end: limits of the time window [s]; start and end of the run when None.

    Returns:
        Dataset over (time, axis): position `place` [m] and `velocity` [m/s]; `time` contains the
        instants [s] at which blade 0 lies on +x.

    Raises:
        ViewError: the rotor does not turn, or the time window is shorter than a revolution.
    """
    from scipy.interpolate import CubicSpline  # long to load

    orbit = shaft_orbit(result, start=start, end=end)
    instants, place = section_places(orbit, frame)
    velocity = orbit[f"{frame}_velocity"].values
    plane = ("time", "axis")
    return labelled(
        orbit,
        "Poincaré map of the shaft, once a revolution",
        {
            "place": (plane, place, "m"),
            "velocity": (plane, CubicSpline(orbit["time"].values, velocity)(instants), "m/s"),
        },
        {"time": instants, "axis": ["x", "y"]},
        frame=frame,
    )


def section_places(orbit: xr.Dataset, frame: Frame = "static") -> tuple[Array, Array]:
    """Return the instants of `poincare_map` [s], (revolutions,), and the positions of the shaft
    [m], (revolutions, 2).

    Raises:
        ViewError: the rotor does not turn, or the orbit is shorter than a revolution.
    """
    from scipy.interpolate import CubicHermiteSpline  # long to load

    time = orbit.variables["time"].values
    every = np.abs(rotation.angles(orbit)) / (2 * np.pi)
    turned, speed = every[[0, -1]], abs(float(orbit.attrs["speed"]))
    first, last = np.ceil(turned[0] - 1e-9), np.floor(turned[1] + 1e-9)
    if speed == 0 or last < first or len(time) < 2:
        raise ViewError(
            f"a Poincaré map needs one revolution or more; the rotor makes {np.ptp(turned):.3g} "
            f"revolutions in {window_label(orbit)}"
        )
    if rotation.varies(orbit):
        instants = np.interp(np.arange(first, last + 1), every, time)
    else:
        instants = np.clip(2 * np.pi * np.arange(first, last + 1) / speed, time[0], time[-1])
    place, velocity = (orbit.variables[name].values for name in (frame, f"{frame}_velocity"))
    return instants, np.asarray(CubicHermiteSpline(time, place, velocity)(instants))


def state_space(orbit: xr.Dataset) -> xr.Dataset:
    """Compute position and velocity of the shaft in the static frame at all records of an orbit
    from `orbits.shaft_orbit`, and the Poincaré map of the orbit.

    Returns:
        Dataset: position `place` [m] and `velocity` [m/s] over (time, axis); from `poincare_map`,
        `section_place` and `section_velocity` over (revolution, axis), where the coordinate
        `revolution` is a time [s].

    Raises:
        ViewError: the rotor does not turn, or the orbit is shorter than a revolution.
    """
    motion = orbit[["static", "static_velocity"]].rename(static="place", static_velocity="velocity")
    sections = poincare_map(orbit).rename(
        time="revolution", place="section_place", velocity="section_velocity"
    )
    return motion.merge(sections).assign_attrs(title="state space of the shaft", frame="static")


@styled
def plot_state_space(states: xr.Dataset) -> Figure:
    """Draw velocity against position from `state_space`, along x (upper row) and y (lower row): the
    motion in the left column, the Poincaré map in the right column.

    The last third of the time is black, the earlier motion is pale.
    """
    figure = new_figure(height=0.1)
    panels = figure.subplots(2, 2, sharex=True, sharey=True)
    late_from = late_part(states)["time"].values[0]
    length, to_length = handy_unit(float(abs(states["place"]).max()), "m")
    rate, to_rate = handy_unit(float(abs(states["velocity"]).max()), "m/s")
    for row, way in zip(panels, ("x", "y"), strict=True):
        motion = states.sel(axis=way)
        columns = ((row[0], "", "time", "-"), (row[1], "section_", "revolution", "."))
        for axes, prefix, instant, mark in columns:
            late = states[instant].values >= late_from
            for chosen, colour, width in ((~late, PALE, 0.4), (late, COLOURS["rotor"], 0.8)):
                named = chosen.any() and instant == "time"
                axes.plot(
                    to_length * motion[f"{prefix}place"].values[chosen],
                    to_rate * motion[f"{prefix}velocity"].values[chosen],
                    mark,
                    markersize=3,
                    color=colour,
                    linewidth=width,
                    rasterized=np.count_nonzero(chosen) > LONG_LINE,
                    label=window_label(states.isel(time=chosen)) if named else None,
                )
            axes.set_xlabel(f"{way} [{length}]")
        row[0].set_ylabel(f"velocity along {way} [{rate}]")
    for axes, title in zip(panels[0], ("motion", "once a revolution"), strict=True):
        axes.set_title(title)
        axes.tick_params(labelbottom=True)
    figure.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    head(figure, states, f"{states.attrs['frame']} frame")
    return figure
