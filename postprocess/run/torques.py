"""Torques and powers on a rotor whose speed varies."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from bladewhirl.models.inputs.units import handy_unit
from bladewhirl.postprocess.energy.works import friction_supply, friction_torque_impulse
from bladewhirl.postprocess.fields import rotation
from bladewhirl.postprocess.fields.kinematics import Array, ViewError
from bladewhirl.postprocess.fields.labelled import labelled
from bladewhirl.postprocess.fields.netcdf import has
from bladewhirl.postprocess.fields.windows import span_edges, span_starts
from bladewhirl.postprocess.plotting.legends import entries_of
from bladewhirl.postprocess.plotting.style import COLOURS, FULL_WIDTH, new_figure, styled, time_axis
from bladewhirl.postprocess.plotting.titles import head

SPANS = 400  #: largest number of spans of time whose means are drawn

KINDS = {
    "drive": ("drive", COLOURS["suspension"]),
    "loss": ("losses", COLOURS["casing"]),
    "friction": ("friction", COLOURS["contact"]),
    "other": ("normal forces, static dampers", COLOURS["other k"]),
}
"""Names and colours of torques and powers."""

RPM = 30.0 / np.pi


def torques(result: xr.Dataset) -> xr.Dataset:
    """Compute torques and powers on the rotation, as means over spans of time; positive values
    accelerate a rotor of positive speed.

    With a free speed they follow from its records. The drive of a speed that is prescribed supplies
    the torque J Omega' and that against friction, where J is the moment of inertia of the bladed
    disk; the change of the angular momentum by vibration is left out. Without a known J only
    friction is given.

    Args:
        result: result of a run whose speed varies.

    Returns:
        Dataset over the middle of each span, `time` [s]: `speed` [rad/s]; `torque_friction` [N m]
        and `power_friction` [W]; `torque_drive` and `power_drive` if they are known; with a free
        speed `torque_loss`, `power_loss`, and those of normal forces and static dampers,
        `torque_other` and `power_other`, in which the momentum of lost blades is a peak.

    Raises:
        ViewError: the result has a single record, or no torque of it is known.
    """
    time = result.variables["time"].values
    if len(time) < 2:
        raise ViewError("torques: expected at least two records")
    starts = span_starts(time[1:], SPANS)
    edges = span_edges(time[1:], starts, float(time[0]))
    length, at = np.diff(edges), np.searchsorted(time, edges)

    def rate(values: Array) -> Array:
        return np.asarray(np.diff(values[at]) / length)

    speeds = rotation.speeds(result)
    friction = -rate(friction_torque_impulse(result))
    rubbed = -rate(friction_supply(result))
    found = {"friction": (friction, rubbed)}
    if has(result, "drive"):
        turned = rotation.angles(result)
        torque, loss = (float(result[f"drive_{name}"]) for name in ("torque", "loss"))
        names = ("drive_work", "loss_work", "braking_work", "angular_momentum")
        driven, lost, braked, gained = (rate(result.variables[name].values) for name in names)
        drag = -loss * rate(turned)
        found["drive"] = np.full(len(length), torque), driven
        found["loss"] = drag, -lost
        found["other"] = gained - torque - drag - friction, braked - rubbed
    elif has(result, "inertia"):
        inertia = float(result["rotor_inertia"])
        found["drive"] = (
            inertia * rate(speeds) - friction,
            0.5 * inertia * rate(speeds**2) - rubbed,
        )
    if not any(part.any() for values in found.values() for part in values):
        raise ViewError("torques: no torque of this run is known")
    variables = {
        f"{quantity}_{name}": ("time", values[place], unit)
        for name, values in found.items()
        for place, (quantity, unit) in enumerate((("torque", "N m"), ("power", "W")))
    }
    variables["speed"] = ("time", rate(rotation.angles(result)), "rad/s")
    return labelled(
        result,
        "torques and powers on the rotation",
        variables,
        {"time": 0.5 * (edges[1:] + edges[:-1])},
    )


@styled
def plot_torques(data: xr.Dataset) -> Figure:
    """Draw speed, torques and powers over time from `torques`; those that are zero are left out."""
    figure = new_figure(width=FULL_WIDTH, height=0.12)
    panels = figure.subplots(3, sharex=True)
    time = data["time"].values
    panels[0].plot(time, RPM * data["speed"].values, color=COLOURS["rotor"])
    panels[0].set_ylabel("speed [rpm]")
    for axes, quantity, si in ((panels[1], "torque", "N m"), (panels[2], "power", "W")):
        given = {name: data.get(f"{quantity}_{name}") for name in KINDS}
        drawn = {name: each.values for name, each in given.items() if each is not None}
        largest = max((float(np.abs(each).max()) for each in drawn.values()), default=0.0)
        unit, scale = handy_unit(largest, si)
        axes.set_ylabel(f"{quantity} [{unit}]")
        for name, values in drawn.items():
            if values.any():
                words, colour = KINDS[name]
                axes.plot(time, scale * values, color=colour, label=words)
    if entries := entries_of(*panels[1:]):
        figure.legend(*zip(*entries, strict=True), loc="outside lower center", ncols=4)
    time_axis(*panels)
    head(figure, data)
    return figure
