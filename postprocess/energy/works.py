"""Energy balance of a run: works of loads, contact forces, springs, damping and drive."""

from typing import TypedDict

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from bladewhirl.models.case.casing import Casing
from bladewhirl.postprocess.fields import rotation
from bladewhirl.postprocess.fields.kinematics import Array, table_of_result
from bladewhirl.postprocess.fields.labelled import labelled
from bladewhirl.postprocess.fields.netcdf import has
from bladewhirl.postprocess.fields.windows import late_part
from bladewhirl.postprocess.plotting.style import COLOURS, new_figure, styled, time_axis
from bladewhirl.postprocess.plotting.titles import head

SOURCES = {
    "load": "the load",
    "normal": "normal contact forces (the wall turns past the tips)",
    "friction": "friction",
    "springs": "turning the rotor against stationary springs",
}
"""Energy sources of a motion."""


class Works(TypedDict):
    """Works since the start [J]; work that adds energy to the motion is positive.

    The sum of load, normal, friction, springs, joints and damping is the rise of the energy of the
    motion.
    The drive keeps the speed constant against the torque of the contact forces, see `drive_work`.
    """

    load: float
    normal: float  #: work of the normal contact forces
    closing: float | None  #: part of `normal` that stops tips as gaps close; None if unknown
    friction: float
    springs: float  #: work of turning the rotor against stationary springs
    joints: float | None  #: work of friction joints between blades; None without joints
    damping: float
    drive: float | None  #: None if unknown
    heat: float  #: energy lost as heat of rubbing


def works(dataset: xr.Dataset) -> Works:
    """Return the works of a run up to its last record."""

    def last(name: str) -> float:
        return float(dataset.variables[f"{name}_work"][-1].values)

    normal, friction = last("normal"), last("friction")
    drive, heat = float(drive_work(dataset)[-1]), float(friction_supply(dataset)[-1]) - friction
    closing = last("closing")
    return Works(
        load=last("external"),
        normal=normal,
        closing=None if np.isnan(closing) else closing,
        friction=friction,
        springs=last("coupling"),
        joints=float(_joint_work(dataset)[-1]) if has(dataset, "joints") else None,
        damping=-last("damping"),
        drive=None if np.isnan(drive) else drive,
        heat=heat,
    )


def _joint_work(dataset: xr.Dataset) -> Array:
    """Return the work of friction joints on the blades since the start [J], (time,)."""
    return np.asarray(-dataset["joint_work"].values.sum(axis=1))


LEDGER = {
    "load": ("load", COLOURS["suspension"]),
    "closing": ("normal forces, closing tips", COLOURS["k = 0"]),
    "passing": ("normal forces, passing wall", COLOURS["contact"]),
    "normal": ("normal forces", COLOURS["contact"]),
    "friction": ("friction", COLOURS["total"]),
    "springs": ("stationary springs", COLOURS["other k"]),
    "joints": ("friction joints", COLOURS["k = 1"]),
    "damping": ("damping", COLOURS["casing"]),
}
"""Works of the energy balance, with their names and colours. `normal`, the sum of `closing` and
`passing`, is used if a result does not contain these two parts."""


def work_histories(dataset: xr.Dataset) -> xr.Dataset:
    """Return the works since the start of a run; work that adds energy to the motion is positive.

    Returns:
        works [J] over time, named as in `LEDGER`, and `energy`, the sum of all works. The work of
        normal forces is split into `closing` and `passing`, or is `normal` if a part is unknown.
    """
    terms = {
        "load": dataset["external_work"],
        "normal": dataset["normal_work"],
        "friction": dataset["friction_work"],
        "springs": dataset["coupling_work"],
        "damping": -dataset["damping_work"],
        "energy": dataset["energy"],
    }
    if has(dataset, "joints"):
        terms["joints"] = xr.DataArray(_joint_work(dataset), dims="time")
    if not dataset["closing_work"].isnull().any():
        terms["closing"] = dataset["closing_work"]
        terms["passing"] = terms.pop("normal") - dataset["closing_work"]
    described = {name: ("time", term.values, "J") for name, term in terms.items()}
    return labelled(dataset, "works since the start", described, {"time": dataset["time"].values})


@styled
def plot_work(histories: xr.Dataset) -> Figure:
    """Draw works and energy over time, from `work_histories`; works that are zero are left out."""
    figure = new_figure(height=0.062)
    axes = figure.add_subplot()
    time = histories["time"].values
    for name, (label, colour) in LEDGER.items():
        if name in histories and histories[name].any():
            axes.plot(time, histories[name].values, color=colour, label=label)
    energy = histories["energy"].values
    axes.plot(time, energy, color="0.75", linewidth=2.5, zorder=1, label="energy, their sum")
    axes.set_ylabel("work since the start [J]")
    figure.legend(loc="outside lower center", ncols=2)
    time_axis(axes)
    head(figure, histories)
    return figure


def drive_work(dataset: xr.Dataset) -> Array:
    """Return the work of the drive against the contact forces since the start [J], (time,); nan if
    it is unknown.

    The torque of friction is the friction force times the tip radius. The torque of normal forces
    is due to the slope of the wall: its work is the part of the work of normal forces that neither
    stops closing tips nor comes from the closure of the wall. It is unknown for results without
    the work of closing tips, and with a coating, whose rods lose energy when a tip leaves them.
    """
    histories = dataset.variables
    if float(dataset.attrs["speed"]) == 0.0:
        return np.zeros(dataset.sizes["time"])
    if has(dataset, "coating"):
        return np.full(dataset.sizes["time"], np.nan)
    passing = histories["normal_work"].values - histories["closing_work"].values
    return np.asarray(passing - _closure_work(dataset) + friction_supply(dataset))


def friction_supply(dataset: xr.Dataset) -> Array:
    """Return the work of the drive against the torque of friction since the start [J], (time,): it
    moves the bodies or becomes heat."""
    dragged = dataset.variables["friction_impulse"].values.sum(axis=1)
    if not rotation.varies(dataset):
        rim = float(dataset.attrs["speed"]) * float(dataset.attrs["tip_radius"])
        return np.asarray(rim * np.cumsum(dragged))
    turning = rotation.speeds(dataset).copy()
    turning[1:] = 0.5 * (turning[1:] + turning[:-1])  # impulses are since the last record
    return np.asarray(float(dataset.attrs["tip_radius"]) * np.cumsum(turning * dragged))


def _closure_work(dataset: xr.Dataset) -> Array:
    """Return the work that the closure of the wall does through normal forces [J], (time,)."""
    closure = table_of_result(dataset, "casing", Casing).closure
    work = np.zeros(dataset.sizes["time"])
    if closure is not None:
        time, impulse = dataset["time"].values, dataset["contact_impulse"].values[1:]
        middle = 0.5 * (time[1:] + time[:-1])
        angle = dataset["tip_angle"].values + rotation.angle_at(dataset, middle)[:, None]
        rate = np.diff(closure.value(time)) / np.diff(time)
        work[1:] = np.cumsum(rate * np.sum(impulse * closure.around.value(angle), axis=1))
    return work


def friction_torque_impulse(dataset: xr.Dataset) -> Array:
    """Return the impulse of the torque of friction that a drive resists, since the start [N m s],
    (time,)."""
    dragged = dataset.variables["friction_impulse"].values.sum(axis=1)
    return np.asarray(float(dataset.attrs["tip_radius"]) * np.cumsum(dragged))


def late_rate(dataset: xr.Dataset, since_start: Array) -> float:
    """Return the mean rate of a quantity, (time,), over the whole revolutions in the last third of
    the time, or over this third if it has none or the speed varies; nan for a single record. The
    rate of `drive_work` is the power of the drive [W]."""
    time = dataset["time"].values
    begin = float(time[-late_part(dataset).sizes["time"]])
    if time[-1] <= begin:
        return float("nan")
    speed = abs(float(dataset.attrs["speed"])) if "rotation_speed" not in dataset else 0.0
    if (whole := int(speed * (time[-1] - begin) / (2.0 * np.pi) + 1e-9)) > 0:
        begin = float(time[-1]) - 2.0 * np.pi * whole / speed
    return float((since_start[-1] - np.interp(begin, time, since_start)) / (time[-1] - begin))


def leading_source(dataset: xr.Dataset) -> str:
    """Return the largest energy source of a run in words; an empty text if no source supplied
    energy.

    Above a critical speed some modes have negative stiffness. Their whirl grows by losing energy,
    so damping drives it.
    """
    balance = works(dataset)
    supplied = {name: float(balance[name] or 0.0) for name in SOURCES}  # type: ignore[literal-required]
    name = max(supplied, key=lambda source: supplied[source])
    energy = float(dataset.variables["energy"][-1].values)
    lost, most = -balance["damping"], supplied[name]
    softest = dataset.variables["rotor_frequency"].values.min()
    if softest < 0.0 and energy < 0.0 and lost > 2.0 * most:
        return (
            "damping of the bladed disk drives its whirl above the critical speed; in rotating axes"
            f" it removes {lost:.3g} J"
        )
    return f"most energy came from {SOURCES[name]}, {most:.3g} J" if most > 0.0 else ""
