"""Where the energy of a run came from and went: works of loads, contact forces, damping, drive."""

from __future__ import annotations

from typing import TypedDict

import numpy as np
import xarray as xr

from bladewhirl.postprocess.fields.kinematics import Array
from bladewhirl.postprocess.fields.windows import late_part

SOURCES = {
    "load": "the load",
    "normal": "normal contact forces (the wall turns past the tips)",
    "friction": "friction",
    "springs": "turning the rotor against springs that stand still",
}
"""What can feed a motion, in words."""


class Works(TypedDict):
    """Works since the start [J]; what feeds the motion is positive.

    Load, normal, friction and springs less damping is what the energy has risen by. The drive,
    which keeps the speed, gives what its torque against both contact forces does at that speed: all
    of the normal work, the friction work, and the heat of rubbing.
    """

    load: float
    normal: float
    friction: float
    springs: float
    damping: float  #: lost to it, positive
    drive: float
    heat: float  #: of rubbing, lost


def works(dataset: xr.Dataset) -> Works:
    """Works of a run up to its last record.

    Args:
        dataset: a result.
    """
    normal, friction = (float(dataset[f"{name}_work"][-1]) for name in ("normal", "friction"))
    drive = float(drive_work(dataset)[-1])
    return Works(
        load=float(dataset["external_work"][-1]),
        normal=normal,
        friction=friction,
        springs=float(dataset["coupling_work"][-1]),
        damping=float(dataset["damping_work"][-1]),
        drive=drive,
        heat=drive - normal - friction,
    )


def drive_work(dataset: xr.Dataset) -> Array:
    """Work of the drive against the contact forces since the start [J], (time,).

    The torque of friction is that at the tip radius. Normal forces, which rub nothing away, take
    from the drive what they do on both bodies as the wall turns past the tips.
    """
    dragged = np.cumsum(dataset["friction_impulse"].values.sum(axis=1))
    reach = float(dataset.attrs["speed"]) * float(dataset.attrs["tip_radius"])
    return np.asarray(dataset["normal_work"].values + reach * dragged)


def late_drive_power(dataset: xr.Dataset) -> float:
    """Mean power of the drive over the last third of the time [W]; nan for a single record."""
    work, time = drive_work(dataset), dataset["time"].values
    first = len(time) - late_part(dataset).sizes["time"]
    if time[-1] <= time[first]:
        return float("nan")
    return float((work[-1] - work[first]) / (time[-1] - time[first]))


def leading_source(dataset: xr.Dataset) -> str:
    """What gave most energy, in words; empty where nothing gave any.

    Past a critical speed squares of frequencies are negative, and whirl grows as it loses energy.
    """
    found = works(dataset)
    given = {
        "load": found["load"],
        "normal": found["normal"],
        "friction": found["friction"],
        "springs": found["springs"],
    }
    name = max(given, key=lambda each: given[each])
    energy, lost = float(dataset["energy"][-1]), found["damping"]
    if dataset["rotor_frequency"].values.min() < 0.0 and energy < 0.0 and lost > 2.0 * given[name]:
        return (
            "damping that turns with the bladed disk feeds whirl past its critical speed, taking"
            f" {lost:.3g} J in rotating axes"
        )
    if not given[name] > 0.0:
        return ""
    return f"most energy came from {SOURCES[name]}, {given[name]:.3g} J"
