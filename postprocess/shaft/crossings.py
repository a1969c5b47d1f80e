"""Orbits of the shaft while the speed of rotation passes critical speeds."""

from dataclasses import dataclass

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from bladewhirl.models.inputs.units import handy, handy_unit
from bladewhirl.postprocess.fields import rotation
from bladewhirl.postprocess.fields.kinematics import ViewError
from bladewhirl.postprocess.fields.labelled import labelled
from bladewhirl.postprocess.fields.netcdf import has
from bladewhirl.postprocess.plotting.style import COLOURS, FULL_WIDTH, new_figure, styled
from bladewhirl.postprocess.plotting.titles import head

TURNS = 3.0  #: turns of the rotor around the crossing that are drawn
MOST_PANELS = 8  #: largest number of crossings in a figure
PER_ROW = 4  #: number of crossings in a row of the figure
RPM = 30.0 / np.pi


@dataclass(frozen=True, kw_only=True)
class Crossing:
    """Instant at which the magnitude of the speed passes a critical speed."""

    time: float  #: [s]
    speed: float  #: critical speed [rad/s]
    whirl: str  #: whirl at this speed, "forward", "backward" or "elliptic"
    rising: bool  #: true if the magnitude of the speed rises
    amplitude: float  #: largest displacement of the shaft over the turns around the instant [m]
    start: int  #: first record of these turns
    stop: int  #: record after the last one


def crossings(result: xr.Dataset, orbit: xr.Dataset) -> list[Crossing]:
    """Return the crossings of critical speeds in the order of time; none at constant speed or if
    critical speeds are not known.

    Args:
        result: result of a run.
        orbit: from `orbits.shaft_orbit` of the same records.
    """
    if not has(result, "critical") or orbit.sizes["time"] < 2:
        return []
    time, speed = orbit.variables["time"].values, np.abs(rotation.speeds(orbit))
    turns, radius = rotation.turns(orbit), orbit.variables["radius"].values
    found = []
    for critical, whirl in zip(
        result.variables["critical_speed"].values,
        result.variables["critical_whirl"].values,
        strict=True,
    ):
        beyond = speed >= critical
        for before in np.flatnonzero(beyond[1:] != beyond[:-1]).tolist():
            share = (critical - speed[before]) / (speed[before + 1] - speed[before])
            middle = turns[before] + share * (turns[before + 1] - turns[before])
            start, stop = np.searchsorted(turns, middle + np.array([-0.5, 0.5]) * TURNS)
            found.append(
                Crossing(
                    time=float(time[before] + share * (time[before + 1] - time[before])),
                    speed=float(critical),
                    whirl=str(whirl),
                    rising=bool(beyond[before + 1]),
                    amplitude=float(radius[start:stop].max()),
                    start=int(start),
                    stop=int(stop),
                )
            )
    return sorted(found, key=lambda each: each.time)


def critical_orbits(result: xr.Dataset, orbit: xr.Dataset) -> xr.Dataset:
    """Return the orbits of the shaft in static axes over `TURNS` turns of the rotor around each
    crossing of a critical speed.

    Returns:
        Dataset over `crossing`: `path` (crossing, record, axis) [m], nan beyond the turns of a
        crossing; `time_of_crossing` [s]; `critical_speed` [rad/s]; `amplitude` [m], the largest
        displacement over these turns; `rising`, 1 or 0; and the coordinate `whirl`.

    Raises:
        ViewError: no critical speed is known or passed.
    """
    if not has(result, "critical"):
        raise ViewError(
            'critical speeds: expected a speed that varies, rotation.effects = "full", a shaft on'
            " springs and equal sectors"
        )
    found = crossings(result, orbit)
    if not found:
        lowest = RPM * float(result.variables["critical_speed"].values.min())
        raise ViewError(f"the speed passes no critical speed; the lowest one is {lowest:.5g} rpm")
    static = orbit.variables["static"].values
    path = np.full((len(found), max(each.stop - each.start for each in found), 2), np.nan)
    for row, each in zip(path, found, strict=True):
        row[: each.stop - each.start] = static[each.start : each.stop]
    return labelled(
        orbit,
        "orbits of the shaft at critical speeds",
        {
            "path": (("crossing", "record", "axis"), path, "m"),
            "time_of_crossing": ("crossing", [each.time for each in found], "s"),
            "critical_speed": ("crossing", [each.speed for each in found], "rad/s"),
            "amplitude": ("crossing", [each.amplitude for each in found], "m"),
            "rising": ("crossing", [int(each.rising) for each in found], "1"),
        },
        {"crossing": np.arange(len(found)), "axis": ["x", "y"]},
        smallest_clearance=orbit.attrs["smallest_clearance"],
    ).assign_coords(whirl=("crossing", [each.whirl for each in found]))


@styled
def plot_critical_orbits(data: xr.Dataset) -> Figure:
    """Draw the orbits from `critical_orbits`, each in a panel of its own, all to one scale."""
    shown = data.isel(crossing=slice(0, MOST_PANELS))
    count = shown.sizes["crossing"]
    rows, columns = -(-count // PER_ROW), min(max(count, 2), PER_ROW)
    figure = new_figure(width=FULL_WIDTH, height=0.02 + 0.055 * rows)
    panels = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
    reach = float(shown["amplitude"].max())
    unit, scale = handy_unit(reach, "m")
    edge = 1.1 * scale * reach or 1.0
    for number, axes in enumerate(panels.ravel()):
        if number >= count:
            axes.set_axis_off()
            continue
        each = shown.isel(crossing=number)
        sense = "rising" if int(each["rising"]) else "falling"
        axes.plot(*(scale * each["path"].values.T), color=COLOURS["rotor"], linewidth=0.8)
        axes.plot(0.0, 0.0, marker="+", color=COLOURS["rest"])
        axes.set(aspect="equal", xlim=(-edge, edge), ylim=(-edge, edge))
        axes.locator_params(nbins=5)
        moment = handy(float(each["time_of_crossing"]), "s", 4)
        axes.set_title(
            f"{RPM * float(each['critical_speed']):.5g} rpm, {each['whirl'].item()}\n"
            f"{sense}, {moment}\n{handy(float(each['amplitude']), 'm', 3)}"
        )
    for axes in panels[-1]:
        axes.set_xlabel(f"x [{unit}]")
    for axes in panels[:, 0]:
        axes.set_ylabel(f"y [{unit}]")
    left_out = data.sizes["crossing"] - count
    head(figure, data, "static frame", *([f"the first {count} crossings"] if left_out else []))
    return figure
