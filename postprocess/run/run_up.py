"""Amplitude of the shaft, or of the tips, and contact force over a speed that varies."""

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.case.shaft import Rotation
from bladewhirl.models.inputs.units import handy_unit
from bladewhirl.postprocess.fields import rotation
from bladewhirl.postprocess.fields.by_blade import contact_motion
from bladewhirl.postprocess.fields.kinematics import Array, smallest_clearance, table_of_result
from bladewhirl.postprocess.fields.labelled import labelled
from bladewhirl.postprocess.fields.netcdf import has
from bladewhirl.postprocess.plotting.style import COLOURS, new_figure, styled, time_axis
from bladewhirl.postprocess.plotting.titles import head
from bladewhirl.postprocess.run.extremes import mean_forces

RPM = 30.0 / np.pi

SENSES = {
    1: ("rotor", "rising speed"),
    -1: ("contact", "falling speed"),
    0: ("rest", "constant speed"),
}
"""Colours and labels by the sense in which the speed changes."""

ROUNDING = 1e-9
"""A change of the speed between two records up to this fraction of the fastest speed is none."""


def amplitude_over_speed(result: xr.Dataset, orbit: xr.Dataset | None = None) -> xr.Dataset:
    """Return the displacement of the shaft, or of the tips if there is none, and the contact force,
    with the speed of rotation and its sense of change.

    Args:
        result: result of a run whose speed varies.
        orbit: from `orbits.shaft_orbit`; None without a shaft.

    Returns:
        Dataset over time: `displacement` [m] of the shaft, of a shaft line that of the node that
        moves most, or of the contact node that moves most
        in the plane of rotation; `force` [N], the largest mean force on a contact node, see
        `extremes.mean_forces`; `speed` [rad/s]; `rising`, 1 while the magnitude of the speed rises,
        -1 while it falls, and 0 at constant speed; `touches`, 1 where a blade touched the casing
        since the last record. `clearance` is the smallest one [m], which tips close
        with the square of the speed if the case gives it at rest; `critical_speed` [rad/s] are the
        speeds at which the shaft whirls forward or in an ellipse, if known. The attribute `moves`
        is "shaft" or "tips".
    """
    nodes = result.sizes.get("contact_node", 0)
    of_line = has(result, "line")
    if of_line:
        moved = result["shaft_displacement"].values[..., :2]
        displacement = np.hypot(moved[..., 0], moved[..., 1]).max(axis=1)
    elif orbit is None:
        ways = (contact_motion(result, direction) for direction in (0, 1))
        displacement = np.fmax.reduce(np.hypot(*ways), axis=1)  # nan for lost blades
    else:
        displacement = orbit["radius"].values
    speed = rotation.speeds(result)
    change = np.gradient(np.abs(speed)) if len(speed) > 1 else np.zeros(len(speed))
    change = np.sign(np.where(np.abs(change) > ROUNDING * np.abs(speed).max(), change, 0.0))
    force, touches = np.zeros((2, len(speed)))
    if nodes:
        force = mean_forces(result).values.max(axis=1)
        touches = (result.variables["contact_steps"].values > 0).any(axis=1).astype(float)
    clearance = np.full(len(speed), smallest_clearance(result) if nodes else np.inf)
    if table_of_result(result, "rotation", Rotation).clearance == "cold":
        share = (speed / float(result.attrs["speed"])) ** 2  # of the growth that is stored
        clearance += float(result["tip_growth"].max()) * (1.0 - share)
    return labelled(
        result,
        "displacement and contact force over the speed",
        {
            "displacement": ("time", displacement, "m"),
            "force": ("time", force, "N"),
            "speed": ("time", speed, "rad/s"),
            "rising": ("time", change, "1"),
            "touches": ("time", touches, "1"),
            "clearance": ("time", clearance, "m"),
            "critical_speed": ("critical", excited_critical_speeds(result), "rad/s"),
        },
        {"time": result["time"].values},
        moves="tips" if orbit is None and not of_line else "shaft",
    )


def excited_critical_speeds(result: xr.Dataset) -> Array:
    """Return the critical speeds at which the shaft whirls forward or in an ellipse [rad/s], none
    if they are not known."""
    if not has(result, "critical"):
        return np.zeros(0)
    speeds, whirl = (result[f"critical_{name}"].values for name in ("speed", "whirl"))
    return np.asarray(speeds[whirl != "backward"])


@styled
def plot_amplitude_over_speed(data: xr.Dataset) -> Figure:
    """Draw the speed over time, and displacement and contact force over the speed, from
    `amplitude_over_speed`: rising and falling speed in different colours, with arrows, the first
    contact, and for the shaft the clearance and critical speeds if they lie in the range of the
    figure."""
    force = data["force"].values
    figure = new_figure(height=0.14 if force.any() else 0.1)
    upper, lower, *more = figure.subplots(2 + bool(force.any()))
    time, rpm = data["time"].values, RPM * data["speed"].values
    upper.set_ylabel("speed [rpm]")
    time_axis(upper)
    moved, sense = 1e3 * data["displacement"].values, data["rising"].values
    unit, scale = handy_unit(float(force.max()), "N")
    for value, (colour, label) in SENSES.items():
        here = sense == value
        if here.any():
            upper.plot(time, np.where(here, rpm, np.nan), color=COLOURS[colour])
            lower.plot(rpm, np.where(here, moved, np.nan), color=COLOURS[colour], label=label)
            for axes in more:
                axes.plot(rpm, np.where(here, scale * force, np.nan), color=COLOURS[colour])
            if value:
                _arrow(lower, rpm, moved, np.flatnonzero(here), COLOURS[colour])
    _events(upper, lower, data)
    of = {"shaft": "of the shaft", "tips": "of a contact node"}[data.attrs["moves"]]
    lower.set(xlabel="speed [rpm]", ylabel=f"displacement\n{of} [mm]")
    for axes in more:
        axes.set(xlabel="speed [rpm]", ylabel=f"contact force\non a node [{unit}]")
    figure.legend(loc="outside lower center", ncols=3)
    head(figure, data)
    return figure


def _arrow(axes: Axes, rpm: FloatArray, moved: FloatArray, rows: IntArray, colour: str) -> None:
    """Draw an arrow in the direction of time at the middle of a part of the curve."""
    middle = rows[len(rows) // 2]
    later = min(middle + max(1, len(rows) // 20), rows[-1])
    if later > middle:
        look = {"arrowstyle": "-|>", "color": colour, "shrinkA": 0.0, "shrinkB": 0.0}
        start, end = (rpm[middle], moved[middle]), (rpm[later], moved[later])
        axes.annotate("", end, start, arrowprops=look)


def _events(upper: Axes, lower: Axes, data: xr.Dataset) -> None:
    """Mark the first contact, and the clearance and critical speeds in the range of the axes."""
    rpm, moved = RPM * data["speed"].values, 1e3 * data["displacement"].values
    touching = np.flatnonzero(data["touches"].values > 0)
    clearance = 1e3 * data["clearance"].values
    if data.attrs["moves"] == "shaft" and clearance.min() < lower.get_ylim()[1]:
        lower.plot(rpm, clearance, color=COLOURS["casing"], linestyle="--", label="clearance")
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
        lower.plot(rpm[first], moved[first], label="first contact", **mark)
