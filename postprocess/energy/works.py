"""Energy balance of a run: works of loads, contact forces, springs, damping and drive."""

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
    "springs": "turning the rotor against stationary springs",
}
"""Energy sources of a motion."""


class Works(TypedDict):
    """Works since the start [J]; what feeds the motion is positive.

    Load, normal, friction and springs less damping is what the energy has risen by. The drive,
    which keeps the speed, gives what its torque against both contact forces does at that speed: all
    of the normal work, the friction work, and the heat of rubbing.
    """

    load: float
    normal: float
    closing: float | None  #: part of `normal` that stops tips; None where the result has it not
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
    closing = float(dataset["closing_work"][-1])
    return Works(
        load=float(dataset["external_work"][-1]),
        normal=normal,
        closing=None if np.isnan(closing) else closing,
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
    """Return the largest energy source in words; empty if there is none.

    Above a critical speed squares of frequencies are negative, and whirl grows as it loses energy.
    """
    balance = works(dataset)
    supplied = {name: float(balance[name]) for name in SOURCES}  # type: ignore[literal-required]
    name = max(supplied, key=lambda source: supplied[source])
    energy, lost, most = float(dataset["energy"][-1]), balance["damping"], supplied[name]
    if dataset["rotor_frequency"].values.min() < 0.0 and energy < 0.0 and lost > 2.0 * most:
        return (
            "damping of the bladed disk feeds whirl above its critical speed and takes"
            f" {lost:.3g} J in rotating axes"
        )
    return f"most energy came from {SOURCES[name]}, {most:.3g} J" if most > 0.0 else ""
