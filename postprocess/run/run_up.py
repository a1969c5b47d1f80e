"""Amplitude of the shaft over the speed of rotation, for a speed that varies."""

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.postprocess.fields import rotation
from bladewhirl.postprocess.fields.kinematics import smallest_clearance
from bladewhirl.postprocess.fields.labelled import labelled
from bladewhirl.postprocess.plotting.style import COLOURS, new_figure, styled, time_axis
from bladewhirl.postprocess.plotting.titles import head

RPM = 30.0 / np.pi

SENSES = {
    1: ("rotor", "rising speed"),
    -1: ("contact", "falling speed"),
    0: ("rest", "constant speed"),
}
"""Colours and labels by the sense in which the speed changes."""

ROUNDING = 1e-9
"""A change of the speed between two records up to this fraction of the fastest speed is none."""


def amplitude_over_speed(orbit: xr.Dataset, result: xr.Dataset) -> xr.Dataset:
    """Return the displacement of the shaft with the speed of rotation and its sense of change.

    Args:
        orbit: from `orbits.shaft_orbit`, of a run whose speed varies.
        result: the result of this run.

    Returns:
        Dataset over time: `radius` [m]; `speed` [rad/s]; `rising`, 1 while the magnitude of the
        speed rises, -1 while it falls, and 0 at constant speed; `touches`, 1 where a blade touched
        the casing since the last record. `clearance` is the smallest one [m]; `critical_speed`
        [rad/s] are the speeds at which the shaft whirls forward or in an ellipse, if known.
    """
    speed = rotation.speeds(orbit)
    change = np.gradient(np.abs(speed)) if len(speed) > 1 else np.zeros(len(speed))
    change = np.sign(np.where(np.abs(change) > ROUNDING * np.abs(speed).max(), change, 0.0))
    touches = (result.variables["contact_steps"].values > 0).any(axis=1)
    forward = result["critical_speed"].values if "critical_speed" in result else np.zeros(0)
    if "critical_whirl" in result:
        forward = forward[result["critical_whirl"].values != "backward"]
    return labelled(
        orbit,
        "displacement of the shaft over the speed",
        {
            "radius": ("time", orbit["radius"].values, "m"),
            "speed": ("time", speed, "rad/s"),
            "rising": ("time", change, "1"),
            "touches": ("time", touches.astype(float), "1"),
            "clearance": ((), smallest_clearance(result), "m"),
            "critical_speed": ("critical", forward, "rad/s"),
        },
        {"time": orbit["time"].values},
    )


@styled
def plot_amplitude_over_speed(data: xr.Dataset) -> Figure:
    """Draw the speed over time, and the displacement of the shaft over the speed, from
    `amplitude_over_speed`: rising and falling speed in different colours, with arrows, the first
    contact, the clearance and critical speeds if they lie in the range of the figure."""
    figure = new_figure(height=0.1)
    upper, lower = figure.subplots(2)
    time, rpm = data["time"].values, RPM * data["speed"].values
    upper.set_ylabel("speed [rpm]")
    time_axis(upper)
    radius, sense = 1e3 * data["radius"].values, data["rising"].values
    for value, (colour, label) in SENSES.items():
        here = sense == value
        if here.any():
            upper.plot(time, np.where(here, rpm, np.nan), color=COLOURS[colour])
            drawn = np.where(here, radius, np.nan)
            lower.plot(rpm, drawn, color=COLOURS[colour], label=label)
            if value:
                _arrow(lower, rpm, radius, np.flatnonzero(here), COLOURS[colour])
    _events(upper, lower, data)
    lower.set(xlabel="speed [rpm]", ylabel="displacement\nof the shaft [mm]")
    figure.legend(loc="outside lower center", ncols=3)
    head(figure, data)
    return figure


def _arrow(axes: Axes, rpm: FloatArray, radius: FloatArray, rows: IntArray, colour: str) -> None:
    """Draw an arrow in the direction of time at the middle of a part of the curve."""
    middle = rows[len(rows) // 2]
    later = min(middle + max(1, len(rows) // 20), rows[-1])
    if later > middle:
        look = {"arrowstyle": "-|>", "color": colour, "shrinkA": 0.0, "shrinkB": 0.0}
        start, end = (rpm[middle], radius[middle]), (rpm[later], radius[later])
        axes.annotate("", end, start, arrowprops=look)


def _events(upper: Axes, lower: Axes, data: xr.Dataset) -> None:
    """Mark the first contact, and the clearance and critical speeds in the range of the axes."""
    rpm, radius = RPM * data["speed"].values, 1e3 * data["radius"].values
    touching = np.flatnonzero(data["touches"].values > 0)
    clearance = 1e3 * float(data["clearance"])
    if clearance < lower.get_ylim()[1]:
        lower.axhline(clearance, color=COLOURS["casing"], linestyle="--", label="clearance")
    low, high = np.abs(rpm).min(), np.abs(rpm).max()
    sign = -1.0 if rpm[np.abs(rpm).argmax()] < 0.0 else 1.0
    critical = RPM * data["critical_speed"].values
    for number, speed in enumerate(critical[(critical >= low) & (critical <= high)]):
        label = None if number else "critical speed"
        lower.axvline(sign * speed, color=COLOURS["suspension"], linewidth=0.8, label=label)
    if len(touching):
        first = touching[0]
        mark: dict[str, Any] = {"marker": "o", "mfc": "white", "markersize": 4.5, "zorder": 5}
        mark |= {"color": COLOURS["k = 1"], "linestyle": "none"}
        upper.plot(data["time"].values[first], rpm[first], **mark)
        lower.plot(rpm[first], radius[first], label="first contact", **mark)
