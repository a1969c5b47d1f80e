"""Largest casing displacement, contact force and stresses of a run, with position and time."""

from typing import NotRequired, TypedDict

import numpy as np
import xarray as xr

from bladewhirl.postprocess.fields.by_blade import of_blades
from bladewhirl.postprocess.fields.kinematics import Array, casing_rows, ring_angles
from bladewhirl.postprocess.fields.result import portions
from bladewhirl.postprocess.fields.wheels import of_wheel, wheel_numbers
from bladewhirl.postprocess.run.histories import COMPONENTS
from bladewhirl.postprocess.run.stresses import LIMITS, utilisation

FORCE_TIME = 1e-3
"""Time over which contact forces are averaged [s], unless the time between two records is longer.
Forces are averaged because the peak force of a march grows as the time step decreases."""

STATIONS = 4  #: points of each casing element at which its displacement is computed


class WallPeak(TypedDict):
    """Largest displacement of the casing."""

    displacement: float  #: [m], signed
    angle: float  #: position on the wall [degrees]
    time: float  #: [s]
    wheel: NotRequired[int]  #: number of the wheel, if several have a ring


class ForcePeak(TypedDict):
    """Largest contact force on a contact node."""

    force: float  #: normal force, mean over `averaged_over` [N]
    blade: int
    node: int  #: number of the contact node on the blade
    time: float  #: end of the averaging time [s]
    averaged_over: float  #: averaging time [s]
    on_blade: float  #: largest force on all nodes of one blade, mean over the same time [N]


class StressPeak(TypedDict):
    """Largest linear elastic stress of a body."""

    stress: float  #: [Pa], signed
    measure: str  #: "beam theory", or "von Mises stress away from contact nodes"
    centrifugal: bool  #: true if the stress of steady rotation is included
    member: str  #: "blade 3", another part of the rotor, or "casing"
    radius: float  #: radius of the stressed point in the undeformed body [m]
    time: float  #: [s]


class StressSplit(TypedDict):
    """Mean and alternating stress of the blade in which they are most severe."""

    member: str  #: "blade 3"
    radius: float  #: radius of the stressed point in the undeformed body [m]
    mean: float  #: mean stress over all records [Pa]
    alternating: float  #: largest deviation from the mean [Pa]
    margin: float | None
    """Factor on both stresses up to the line between `material.endurance` and `material.strength`;
    None if the case does not give both."""


def casing_peaks(dataset: xr.Dataset) -> dict[str, WallPeak]:
    """Return the largest radial (positive outward) and tangential displacement of the casing over
    all records of a result; of several rings, that of the ring with the largest one."""
    numbers = wheel_numbers(dataset)
    if len(numbers) == 1:
        return _peaks(dataset)
    peaks = [_peaks(of_wheel(dataset, number)) for number in numbers]
    largest = {}
    for way in COMPONENTS:
        each = [abs(one[way]["displacement"]) for one in peaks]
        first = int(np.argmax(each))
        largest[way] = WallPeak(**peaks[first][way], wheel=numbers[first])
    return largest


def _peaks(dataset: xr.Dataset) -> dict[str, WallPeak]:
    """Return the largest displacements of one ring, see `casing_peaks`."""
    around, time = ring_angles(dataset, STATIONS), dataset["time"].values
    rows = casing_rows(dataset, around)
    peaks = {way: WallPeak(displacement=0.0, angle=0.0, time=0.0) for way in COMPONENTS}
    for portion in portions(dataset):
        coordinates = dataset["casing_displacement"].isel(time=portion).values
        for component, way in enumerate(COMPONENTS):
            moved = coordinates @ rows[:, component].T
            record, point = np.unravel_index(np.abs(moved).argmax(), moved.shape)
            if abs(moved[record, point]) > abs(peaks[way]["displacement"]):
                peaks[way] = WallPeak(
                    displacement=float(moved[record, point]),
                    angle=float(np.degrees(around[point])),
                    time=float(time[portion][record]),
                )
    return peaks


def mean_forces(dataset: xr.Dataset) -> xr.DataArray:
    """Return the normal force on each contact node, the mean over `FORCE_TIME` up to each record
    [N], (time, contact_node). The attribute `averaged_over` is this time [s]."""
    step = float(dataset.attrs["record_step"])
    records = max(1, round(FORCE_TIME / step))
    impulse: Array = np.cumsum(dataset["contact_impulse"].values, axis=0)
    summed = impulse.copy()
    summed[records:] -= impulse[:-records]
    about = {"averaged_over": records * step}
    over = ("time", "contact_node")
    return xr.DataArray(summed / (records * step), dims=over, attrs=about)


def largest_force(dataset: xr.Dataset) -> ForcePeak:
    """Return the largest normal force on any contact node, averaged over `FORCE_TIME`."""
    force = mean_forces(dataset)
    if not force.size:  # a shaft line without a wheel
        step = force.attrs["averaged_over"]
        return ForcePeak(force=0.0, blade=0, node=0, time=0.0, averaged_over=step, on_blade=0.0)
    record, place = np.unravel_index(force.values.argmax(), force.shape)
    return ForcePeak(
        force=float(force[record, place]),
        blade=int(dataset["blade"][place]),
        node=int(dataset["node"][place]),
        time=float(dataset["time"][record]),
        averaged_over=force.attrs["averaged_over"],
        on_blade=float(of_blades(dataset, force.values).max()),
    )


def stress_peaks(peaks: xr.Dataset) -> dict[str, StressPeak]:
    """Return the largest stress of the bladed disk and of a flexible casing, from the largest
    stresses of their members (`stresses.peak_stresses` or `stress_history`)."""
    of_casing = peaks["member"].values == "casing"
    largest = {}
    for body, belongs in (("bladed_disk", ~of_casing), ("casing", of_casing)):
        if not belongs.any():  # a rigid wall
            continue
        members = peaks.isel(member=np.flatnonzero(belongs))
        one = members.isel(member=int(np.abs(members["peak_stress"].values).argmax()))
        largest[body] = StressPeak(
            stress=float(one["peak_stress"]),
            measure=str(peaks.attrs["measure"]) if body == "bladed_disk" else "beam theory",
            centrifugal=body == "bladed_disk" and bool(peaks.attrs["steady"]),
            member=str(one["member"].values),
            radius=float(one["peak_radius"]),
            time=float(one["peak_time"]),
        )
    return largest


def stress_split(peaks: xr.Dataset) -> StressSplit | None:
    """Return the split of the stress into mean and alternating stress for the blade with the least
    margin or, without limits of the material, the largest sum of both; None if all blades
    are lost. `peaks` are from `stresses.peak_stresses` or `stress_history`."""
    blades = peaks.isel(member=peaks["member"].str.startswith("blade "))
    mean, alternating = blades["mean_stress"].values, blades["alternating_stress"].values
    used = utilisation(mean, alternating, peaks.attrs)
    if np.isnan(used).all():
        return None
    blade = int(np.nanargmax(used))
    limited = set(LIMITS) <= peaks.attrs.keys() and used[blade] > 0.0
    return StressSplit(
        member=str(blades["member"].values[blade]),
        radius=float(blades["split_radius"][blade]),
        mean=float(mean[blade]),
        alternating=float(alternating[blade]),
        margin=float(1.0 / used[blade]) if limited else None,
    )
