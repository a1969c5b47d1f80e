"""Signals of the sensors of a rig, from the records of a run.

Between two records each displacement is interpolated by the cubic that has the displacements and
velocities of both records. For a vibration with the angular frequency w and the record step h, the
largest errors, divided by the amplitude of the same quantity, are (w h)^4 / 384 for a displacement,
(w h)^3 / (72 sqrt(3)) for a velocity and (w h)^2 / 12 for an acceleration. Displacements and
velocities are exact at the records. A contact changes the velocity between two records; the cubic
spreads this change over the record step. What contact forces strain besides the motion of the modes
is linear between the records.
"""

import tomllib
import warnings
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Any, Literal, NamedTuple

import numpy as np
import xarray as xr
from scipy.linalg import block_diag

from bladewhirl.meshes.hermite import cubic_weights, curvature_weights, slope_weights
from bladewhirl.models.case.check import sensors_from
from bladewhirl.models.case.sensors import (
    MOTION_UNITS,
    CentreSensor,
    Sensor,
    StrainGauge,
    TipTiming,
    WallSensor,
)
from bladewhirl.models.inputs.errors import CaseError, Fault, Hint
from bladewhirl.postprocess.fields import rotation
from bladewhirl.postprocess.fields.blades import blade_chain
from bladewhirl.postprocess.fields.by_blade import blade_angles, blade_count, blade_radii
from bladewhirl.postprocess.fields.kinematics import Array, IntArray, ViewError, casing_rows
from bladewhirl.postprocess.fields.labelled import labelled
from bladewhirl.postprocess.fields.netcdf import has
from bladewhirl.postprocess.fields.point_stresses import gauge_row, on_sectors
from bladewhirl.postprocess.fields.points import points_of
from bladewhirl.postprocess.fields.result import portions, reduce_modes
from bladewhirl.postprocess.fields.strains import surface_strain_rows
from bladewhirl.postprocess.fields.wheels import of_first_wheel
from bladewhirl.postprocess.fields.windows import in_window
from bladewhirl.postprocess.run.histories import COMPONENTS
from bladewhirl.postprocess.run.tip_timing import tip_timing, too_slow

WEIGHTS = (cubic_weights, slope_weights, curvature_weights)
"""Functions that return the weights of a cubic: for its value, its first and its second
derivative."""

ON_SAMPLE = 1e-6  #: a sample up to this fraction of a sampling step outside the records is included

NEEDED = {
    "wall": ("casing", "another type for a rigid wall, which does not move"),
    "centre": ("centre", "another type for blades without a common centre that moves"),
}
"""Part of the stage that a sensor of this type needs, and what is expected without it."""

MOST_PER_RECORD = 100  #: largest number of samples between two records

SHOWN: dict[str, tuple[str, float]] = {
    "m/m": ("µm/m", 1e6),
    "m": ("µm", 1e6),
    "m/s": ("mm/s", 1e3),
    "m/s2": ("g", 1.0 / 9.80665),
}
"""Unit in tables and figures, and its factor, by the SI unit of a signal."""


def sensors(
    result: xr.Dataset,
    tables: Iterable[Any] | None = None,
    *,
    start: float | None = None,
    end: float | None = None,
) -> xr.Dataset:
    """Return the signals of sensors: strain gauges, tip timing, and probes of wall and shaft.

    Args:
        result: result of a run; it is read portion by portion.
        tables: sensors, with the keys of the tables [[sensor]] of a case file; the sensors of the
            case of the run when None.
        start, end: limits of the time window [s]; start and end of the run when None.

    Returns:
        Dataset with a variable for each sensor, named after it. A signal has the
        dimension `time` [s] or, with a sampling rate, one such as `time_20000_Hz` [s]; a strain
        [m/m] of all blades also has the dimension `blade`. Tip timing has the deflection [m] and,
        in `NAME_arrival`, the arrival times [s] over (NAME_probe [rad], blade, NAME_revolution),
        nan after the end of the window. Attributes of each signal: units, and type, position, noise
        and seed of the sensor.

    Warns:
        Hint: a sensor samples more often than the run has records.

    Raises:
        CaseError: a sensor is invalid; the error lists all faults.
        ViewError: there is no sensor, or tip timing is impossible, see `tip_timing`.

    Example:
        ``sensors(result, [{"type": "strain", "span": 0.1}])["strain-0.1"].sel(blade=3).plot()``
    """
    chosen = sensors_of(result, tables)
    for hint in sampling_hints(chosen, float(result.attrs["record_step"])):
        warnings.warn(hint, Hint, stacklevel=2)
    return signals(result, chosen, start=start, end=end)


def sensors_of(result: xr.Dataset, tables: Iterable[Any] | None = None) -> tuple[Sensor, ...]:
    """Return sensors from tables, or those of the case of a run when None; see `sensors`."""
    if tables is None:
        text = str(result.attrs.get("case", ""))
        tables = tomllib.loads(text).get("sensor", []) if "[[sensor]]" in text else []
    chosen = sensors_from(list(tables), blade_count(result))
    if not chosen:
        raise ViewError("sensors: expected tables [[sensor]] in the case of the run")
    speed = float(result.attrs["speed"])
    check_sensors(result, chosen, speed, float(result.attrs["record_step"]))
    return chosen


def check_sensors(
    stage: xr.Dataset, sensors: Sequence[Sensor], speed: float, record_step: float
) -> None:
    """Check that sensors fit the mesh of a stage, its speed [rad/s] and the record step [s].

    Raises:
        CaseError: the stage does not have what a sensor records, a gauge is not on a blade, or tip
            timing lacks records; all faults are listed.
    """
    faults = []
    for number, sensor in enumerate(sensors):
        needed, expected = NEEDED.get(sensor.type, ("", ""))
        if needed and not has(stage, needed):
            faults.append(Fault(key=f"sensor[{number}].type", value=sensor.type, expected=expected))
        if isinstance(sensor, TipTiming) and (expected := too_slow(speed, record_step)):
            faults.append(Fault(key=f"sensor[{number}].type", value=sensor.type, expected=expected))
        most = MOST_PER_RECORD / record_step
        if (sensor.sampling_rate or 0.0) > most and not isinstance(sensor, TipTiming):
            expected = f"at most {most:.6g} Hz, {MOST_PER_RECORD} times the rate of the records"
            key = f"sensor[{number}].sampling_rate"
            faults.append(Fault(key=key, value=sensor.sampling_rate, expected=expected))
        if isinstance(sensor, StrainGauge):
            try:
                gauge_rows(stage, sensor)
            except ViewError as error:
                keys = ("span", "element", "gauge", "point")
                key = next(k for k in keys if getattr(sensor, k) is not None)
                at, value = f"sensor[{number}].{key}", getattr(sensor, key)
                faults += [replace(each, key=at, value=value) for each in error.faults]
    if faults:
        raise CaseError(faults)


def sampling_hints(sensors: Iterable[Sensor], record_step: float) -> Iterator[str]:
    """Yield a hint for each sensor that samples more often than once in `record_step` [s], the time
    between records."""
    for sensor in sensors:
        rate = sensor.sampling_rate or 0.0
        if rate * record_step > 1.0 + ON_SAMPLE and not isinstance(sensor, TipTiming):
            yield (
                f"sensor {sensor.label} samples {rate:g} times a second, but the run has only"
                f" {1.0 / record_step:g} records a second; between records the signal is a cubic"
            )


def signals(
    result: xr.Dataset,
    sensors: Sequence[Sensor],
    *,
    start: float | None = None,
    end: float | None = None,
) -> xr.Dataset:
    """Return the signals of sensors from `sensors_of`, see `sensors`."""
    result = in_window(result, start, end)
    parts = [
        _timing(result, sensor, number)
        if isinstance(sensor, TipTiming)
        else _signal(result, sensor, number)
        for number, sensor in enumerate(sensors)
    ]
    return xr.merge(parts, compat="equals", join="exact", combine_attrs="drop_conflicts")


class GaugeRows(NamedTuple):
    """Strain under a gauge on all blades, or on the blade with the gauge."""

    modal: Array  #: for unit modal coordinates [kg^-1/2/m], (blade, rotor_mode)
    by_force: Array | None = None
    """By unit contact forces, without their part in the modes [1/N], (blade, 3 * contact nodes);
    None if the modes have all of the strain."""


def gauge_rows(dataset: xr.Dataset, gauge: StrainGauge) -> GaugeRows:
    """Return the strain under a gauge.

    Raises:
        ViewError: the stage has no such gauges, the blade is not a chain of beams, or it does not
            have the element of the gauge.
    """
    blades = range(blade_count(dataset)) if gauge.blade == "all" else [gauge.blade]
    if gauge.gauge is not None:
        return _recovered_rows(dataset, gauge.gauge, [*blades])
    if gauge.point is not None:
        return _point_rows(dataset, gauge)
    if not has(dataset, "lines"):
        expected = "gauge in place of span and element, as the blades are no beams"
        raise ViewError(Fault(expected=expected))
    ends = dataset["rotor_point"].values[dataset["rotor_line"].values]
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    lines, places, outwards = [], [], []
    for blade in blades:
        chain = blade_chain(dataset, blade)
        if gauge.element is not None and gauge.element >= len(chain.lines):
            last = len(chain.lines) - 1
            expected = f"an element from 0 to {last} of blade {blade}"
            raise ViewError(Fault(expected=expected))
        number, x = gauge.element, 0.5
        if number is None:
            number, x = chain.place(float(gauge.span or 0.0), length)
        lines.append(chain.lines[number])
        places.append(x)
        outwards.append(chain.outward[number])
    left = np.array(outwards) == (gauge.side == "+theta")
    return GaugeRows(surface_strain_rows(dataset, np.array(lines), np.array(places), left))


def _recovered_rows(dataset: xr.Dataset, number: int, chosen: list[int]) -> GaugeRows:
    """Return the strain of a gauge on some blades from the recovery of strain of a superelement."""
    if not has(dataset, "gauges"):
        raise ViewError(Fault(expected="span or element, as no file gives strain_recovery"))
    shape, copies = dataset["gauge_shape"].values, dataset.sizes["copy"]
    blades = blade_count(dataset) // copies
    if len(shape) % blades or not number < len(shape) // blades:
        expected = (
            f"a gauge from 0 to {len(shape) // blades - 1} of each blade, with the same number of"
            " gauges on all blades"
        )
        raise ViewError(Fault(expected=expected))
    own = shape.reshape(blades, -1, shape.shape[1])[:, number]
    modal = np.kron(np.eye(copies), own)[chosen]
    if "gauge_by_force" not in dataset:  # of an older format
        return GaugeRows(modal)
    gauges = number + len(shape) // blades * np.arange(blades)
    every = dataset["gauge_by_force"].values
    by_force = block_diag(*(on_sectors(each, gauges).reshape(blades, -1) for each in every))
    return GaugeRows(modal, np.asarray(by_force[chosen]))


def _point_rows(dataset: xr.Dataset, gauge: StrainGauge) -> GaugeRows:
    """Return the strain of a gauge at a point, on every blade or on that of the gauge."""
    assert gauge.point is not None
    assert gauge.direction is not None
    places, rows, pushed = gauge_row(dataset, gauge.point, np.array(gauge.direction))
    points, copies = dataset.sizes["point"], dataset.sizes["copy"]
    modal = np.kron(np.eye(copies), rows)  # a mistuned blade has the modes of the file
    by_force = np.kron(np.diag(1.0 / dataset["copy_stiffness"].values), pushed)
    of_blades = points_of(dataset, 1).blade[(places + points * np.arange(copies)[:, None]).ravel()]
    wanted = np.arange(blade_count(dataset)) if gauge.blade == "all" else np.array([gauge.blade])
    if not np.isin(wanted, of_blades).all():
        expected = (
            f"a point of each blade with a gauge; point {gauge.point} is on blade"
            f" {', '.join(map(str, of_blades))} of a whole wheel: give blade"
        )
        raise ViewError(Fault(expected=expected))
    chosen = [int(np.flatnonzero(of_blades == blade)[0]) for blade in wanted]
    return GaugeRows(np.asarray(modal[chosen]), np.asarray(by_force[chosen]))


def shown_unit(signal: xr.DataArray) -> tuple[str, float]:
    """Return the unit in which rigs show a signal, and the factor from the SI unit: microstrain,
    micrometres, mm/s, g, and mm for the deflection of a tip."""
    if signal.attrs["type"] == "tip-timing":
        return "mm", 1e3
    return SHOWN[signal.attrs["units"]]


def _signal(
    result: xr.Dataset, sensor: StrainGauge | WallSensor | CentreSensor, number: int
) -> xr.Dataset:
    """Return the signal of a sensor that samples in time; the number of the sensor is part of the
    key of its noise."""
    numbers, at = _samples(result, sensor.sampling_rate)
    over = "time" if sensor.sampling_rate is None else f"time_{sensor.sampling_rate:g}_Hz"
    coordinates: dict[str, Any] = {over: at}
    match sensor:
        case StrainGauge():
            unit, rows = "m/m", gauge_rows(result, sensor)
            values = _between(result, "rotor", rows.modal, at)
            if rows.by_force is not None:
                values = values + _by_contact(result, rows.by_force, at)
        case WallSensor():
            unit, derivative = _motion(sensor.quantity)
            every = casing_rows(of_first_wheel(result), np.array([sensor.angle]))
            row = every[:, COMPONENTS.index(sensor.direction)]
            values = _between(result, "casing", row, at, derivative)
        case CentreSensor():
            unit, derivative = _motion(sensor.quantity)
            values = _centre(result, sensor.angle, at, derivative)[:, None]
    noise = _stream(sensor, number).standard_normal((numbers[-1] + 1, values.shape[1]))
    values = values + sensor.noise * noise[numbers]
    dimensions: tuple[str, ...] = (over,)
    if isinstance(sensor, StrainGauge) and sensor.blade == "all":
        dimensions, coordinates["blade"] = (over, "blade"), np.arange(values.shape[1])
    else:
        values = values[:, 0]
    signal = labelled(
        result, "signals of sensors", {sensor.label: (dimensions, values, unit)}, coordinates
    )
    signal[over].attrs["units"] = "s"
    signal[sensor.label].attrs |= _about(sensor)
    return signal


def _timing(result: xr.Dataset, sensor: TipTiming, number: int) -> xr.Dataset:
    """Return arrivals and deflections from tip timing, with noise and with the sampling of the
    clock."""
    exact = tip_timing(result, np.array(sensor.probes))
    name = sensor.label
    radius = blade_radii(result)[:, None]
    angle = blade_angles(result)[:, None] - exact["probe"].values[:, None, None]
    arrival = exact["arrival"].values
    speed = rotation.speed_at(result, arrival)
    turned = angle + rotation.angle_at(result, arrival) + exact["deflection"].values / radius
    turn = np.nan_to_num(np.sign(speed) * np.round(turned / (2.0 * np.pi))).astype(np.int64) + 2
    shape = (int(turn.max(initial=0)) + 1, len(sensor.probes), len(radius))
    probe, blade = np.ogrid[: shape[1], : shape[2]]
    # Noise belongs to the revolution since the start of the run, also in a time window.
    noise = _stream(sensor, number).standard_normal(shape)[turn, probe[..., None], blade[..., None]]
    measured = arrival + sensor.noise * noise
    if sensor.sampling_rate is not None:
        measured = np.round(measured * sensor.sampling_rate) / sensor.sampling_rate
    exact["deflection"].values -= radius * speed * (measured - arrival)
    exact["arrival"].values[:] = measured
    names = {"deflection": name, "arrival": f"{name}_arrival"}
    names |= {each: f"{name}_{each}" for each in ("probe", "revolution")}
    signal = exact.rename(names).assign_attrs(title="signals of sensors")
    signal[f"{name}_probe"].attrs["units"] = "rad"
    signal[name].attrs |= _about(sensor)
    return signal


def _samples(result: xr.Dataset, rate: float | None) -> tuple[IntArray, Array]:
    """Return the numbers of the samples since the start of the run, and their times [s]. When the
    rate [Hz] is None, the samples are the records."""
    time = result["time"].values
    if rate is None:
        first = round(time[0] / float(result.attrs["record_step"]))
        return np.arange(first, first + len(time)), time
    first, last = np.ceil(time[0] * rate - ON_SAMPLE), np.floor(time[-1] * rate + ON_SAMPLE)
    numbers = np.arange(int(first), int(last) + 1)
    if not len(numbers):
        raise ViewError(f"sensors: the time window has no sample at the sampling rate {rate:g} Hz")
    return numbers, numbers / rate


def _between(
    result: xr.Dataset,
    body: Literal["rotor", "casing"],
    rows: Array,
    at: Array,
    derivative: int = 0,
) -> Array:
    """Return weighted sums of the modal coordinates of a body at times between the records, or
    their derivatives, (at, row).

    Args:
        result: a result.
        body: "rotor" or "casing".
        rows: weights of the modes, (row, mode).
        at: times [s], (at,).
        derivative: 0, 1 or 2.
    """
    time = result["time"].values
    if len(time) == 1:
        raise ViewError("sensors: expected at least two records")
    rotor = body == "rotor"
    values = reduce_modes(result, "rotor_displacement" if rotor else "casing_displacement", rows)
    rates = reduce_modes(result, "rotor_velocity" if rotor else "casing_velocity", rows)
    record = np.clip(np.searchsorted(time, at, side="right") - 1, 0, len(time) - 2)
    length = time[record + 1] - time[record]
    weights = WEIGHTS[derivative]((at - time[record]) / length)[:, :, None]
    step = length[:, None]
    cubic = weights[0] * values[record] + weights[2] * values[record + 1]
    cubic += step * (weights[1] * rates[record] + weights[3] * rates[record + 1])
    return np.asarray(cubic / step**derivative)


def _by_contact(result: xr.Dataset, rows: Array, at: Array) -> Array:
    """Return weighted sums of the contact forces at times, which vary linearly between the records,
    (at, row).

    Args:
        result: a result.
        rows: weights of the forces on the contact nodes, (row, 3 * contact nodes).
        at: times [s], (at,).
    """
    force = result.variables["contact_force"]
    sums = [
        force[portion].values.reshape(-1, rows.shape[1]) @ rows.T for portion in portions(result)
    ]
    time = result["time"].values
    return np.stack([np.interp(at, time, one) for one in np.concatenate(sums).T], axis=1)


def _centre(result: xr.Dataset, angle: float, at: Array, derivative: int) -> Array:
    """Return the displacement of the shaft's centre along a static angle [rad], or its derivatives,
    (at,).

    With z = x + i y in rotating axes, the displacement in static axes is exp(i psi) z; its
    derivative is exp(i psi) (z' + i Omega z).
    """
    rows = result["centre_shape"].values
    turning, rate = 1j * rotation.speed_at(result, at), rotation.acceleration_at(result, at)
    x, y = np.stack([_between(result, "rotor", rows, at, d) for d in range(derivative + 1)]).T
    z = x + 1j * y  # (at, derivative)
    one = np.ones_like(turning)
    binomial = np.stack(
        {
            0: [one],
            1: [turning, one],
            2: [turning**2 + 1j * rate, 2.0 * turning, one],
        }[derivative],
        axis=-1,
    )
    turned = np.exp(1j * (rotation.angle_at(result, at) - angle))
    return np.asarray(np.real(turned * (z * binomial).sum(axis=-1)))


def _motion(quantity: str) -> tuple[str, int]:
    return MOTION_UNITS[quantity], list(MOTION_UNITS).index(quantity)


def _stream(sensor: Sensor, number: int) -> np.random.Generator:
    key = np.array([sensor.seed, number], dtype=np.uint64)
    return np.random.Generator(np.random.Philox(key=key))


def _about(sensor: Sensor) -> dict[str, Any]:
    """Return the keys of a sensor as attributes of its signal."""
    return sensor.model_dump(mode="json", exclude_none=True, exclude={"name"})
