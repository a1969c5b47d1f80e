"""Amplitude of the shaft over the speed of rotation, for a speed that varies."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from bladewhirl.postprocess.fields import rotation
from bladewhirl.postprocess.fields.labelled import labelled
from bladewhirl.postprocess.plotting.style import COLOURS, new_figure, styled, time_axis
from bladewhirl.postprocess.plotting.titles import head

RPM = 30.0 / np.pi

ROUNDING = 1e-9
"""A change of the speed between two records up to this fraction of the fastest speed is none."""


def amplitude_over_speed(orbit: xr.Dataset) -> xr.Dataset:
    """Return the displacement of the shaft with the speed of rotation and its sense of change.

    Args:
        orbit: from `orbits.shaft_orbit`, of a run whose speed varies.

    Returns:
        Dataset over time: `radius` [m]; `speed` [rad/s]; `rising`, 1 while the magnitude of the
        speed rises, -1 while it falls, and 0 at constant speed.
    """
    speed = rotation.speeds(orbit)
    change = np.gradient(np.abs(speed)) if len(speed) > 1 else np.zeros(len(speed))
    change = np.sign(np.where(np.abs(change) > ROUNDING * np.abs(speed).max(), change, 0.0))
    return labelled(
        orbit,
        "displacement of the shaft over the speed",
        {
            "radius": ("time", orbit["radius"].values, "m"),
            "speed": ("time", speed, "rad/s"),
            "rising": ("time", change, "1"),
        },
        {"time": orbit["time"].values},
    )


@styled
def plot_amplitude_over_speed(data: xr.Dataset) -> Figure:
    """Draw the speed over time, and the displacement of the shaft over the speed, from
    `amplitude_over_speed`: rising and falling speed in different colours."""
    figure = new_figure(height=0.1)
    upper, lower = figure.subplots(2)
    time, rpm = data["time"].values, RPM * data["speed"].values
    upper.set_ylabel("speed [rpm]")
    time_axis(upper)
    radius = 1e3 * data["radius"].values
    for sense, colour, label in (
        (1, "rotor", "rising speed"),
        (-1, "contact", "falling speed"),
        (0, "rest", "constant speed"),
    ):
        here = data["rising"].values == sense
        if here.any():
            upper.plot(time, np.where(here, rpm, np.nan), color=COLOURS[colour])
            drawn = np.where(here, radius, np.nan)
            lower.plot(rpm, drawn, color=COLOURS[colour], label=label)
    lower.set(xlabel="speed [rpm]", ylabel="displacement\nof the shaft [mm]")
    figure.legend(loc="outside lower center", ncols=3)
    head(figure, data)
    return figure
