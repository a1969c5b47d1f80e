"""Signals of sensors, compared with closed-form solutions of statics and of motions of a single
mode."""

from functools import cache
from typing import Any

import numpy as np
import xarray as xr
from scipy.optimize import brentq

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.case import case_from
from bladewhirl.models.stage.beams import Beams
from bladewhirl.models.stage.build_beams import build_beams
from bladewhirl.postprocess.fields.result import stage_dataset
from bladewhirl.postprocess.run.sensors import sensors_of, signals
from bladewhirl.studies.verification.case import Pair, verifies
from bladewhirl.studies.verification.stages import observed_order

FORCE, PULL = 40.0, 5e3  #: tangential and radial force on a blade tip [N]
LENGTH, WIDTH, THICKNESS = 0.45, 0.1, 0.01  #: dimensions of a blade [m]
YOUNG = 2e11  #: Young's modulus [Pa]
BLADE = 2  #: number of the loaded blade
DURATION, RECORDS = 0.2, (201, 401)  #: length of a motion [s], and its numbers of records
FREQUENCY, AMPLITUDE = 200.0, 2e-3  #: frequency [rad/s], amplitude at a tip [m]
ANGLE = 0.7  #: angle of the wall sensor [rad]


@cache
def stage() -> Beams:
    """Return a stage with few blades."""
    tables: dict[str, Any] = {
        "bladed_disk": {
            "blades": 6,
            "elements_per_blade": 3,
            "tip_radius": 0.05 + LENGTH,
            "disk_radius": 0.05,
            "blade": {"width": WIDTH, "thickness": THICKNESS},
        },
        "material": {"young_modulus": YOUNG},
        "casing": {"elements": 16},
        "reduction": {"fixed_interface_modes": 20},
    }
    return build_beams(case_from(tables))


def motion(time: FloatArray, body: str, moved: FloatArray, rate: FloatArray) -> xr.Dataset:
    """Return a result in which one body moves.

    Args:
        time: times of the records [s], (time,).
        body: "rotor" or "casing"; the other body is at rest.
        moved, rate: modal coordinates of the body and their rates, (time, mode).
    """
    arrays = stage().arrays
    histories = {"time": time, f"{body}_displacement": moved, f"{body}_velocity": rate}
    return stage_dataset(arrays, histories).assign_attrs(
        speed=stage().speed,
        reference_frequency=stage().reference_frequency,
        record_step=float(time[1]),
        tip_radius=stage().case.tip_radius,
        casing_radius=stage().reduced_casing.radius,
    )


def vibration(records: int, body: str, mode: int, amplitude: float) -> xr.Dataset:
    """Return a result in which one mode of a body vibrates with a modal amplitude."""
    time = np.linspace(0.0, DURATION, records)
    modes = len(getattr(stage().arrays, f"{body}_frequency"))
    moved, rate = np.zeros((2, records, modes))
    moved[:, mode] = amplitude * np.cos(FREQUENCY * time)
    rate[:, mode] = -amplitude * FREQUENCY * np.sin(FREQUENCY * time)
    return motion(time, body, moved, rate)


def recorded(result: xr.Dataset, *tables: dict[str, Any]) -> xr.Dataset:
    """Return the signals of sensors."""
    return signals(result, sensors_of(result, tables))


@verifies("+theta", "-theta")
def strain_of_a_tip_load(side: str) -> Pair:
    """Compare strains at four positions of a blade with P / EA -+ (h / 2) F (L - x) / EI, for a
    radial force P and a tangential force F on the tip, and a blade of the thickness h."""
    rotor, spans = stage().rotor, np.array([0.0, 0.45, 0.9, 1.0])
    force = FORCE * rotor.tip_tangential[BLADE] + PULL * rotor.tip_radial[BLADE]
    bent = np.tile(force / rotor.frequency**2, (2, 1))
    rest = motion(np.array([0.0, 1e-3]), "rotor", bent, np.zeros_like(bent))
    gauge = {"type": "strain", "side": side, "blade": BLADE}
    strains = recorded(rest, *(gauge | {"span": span} for span in spans.tolist()))
    axial = PULL / (YOUNG * WIDTH * THICKNESS)
    bending = 6.0 * FORCE * LENGTH * (1.0 - spans) / (YOUNG * WIDTH * THICKNESS**2)
    expected = axial + (bending if side == "-theta" else -bending)
    return expected, [float(signal[0]) for signal in strains.values()]


@verifies()
def order_of_tip_timing() -> Pair:
    """Check that arrival times converge with order four as the record step decreases.

    The error is the root mean square of all arrivals of a blade at 40 probes."""
    rotor = stage().rotor
    mode = int(np.argmax(np.abs(rotor.tip_tangential[BLADE])))
    probes, errors = np.linspace(0.0, 6.2, 40), []
    for records in RECORDS:
        result = vibration(records, "rotor", mode, AMPLITUDE / rotor.tip_tangential[BLADE, mode])
        table = {"type": "tip-timing", "probes": probes.tolist(), "name": "tip"}
        arrivals = recorded(result, table)["tip_arrival"].sel(blade=BLADE).values
        each = np.concatenate(
            [
                times[np.isfinite(times)] - _arrivals(result, probe, np.isfinite(times).sum())
                for probe, times in zip(probes, arrivals, strict=True)
            ]
        )
        errors.append(np.sqrt(np.mean(each**2)))
    return 4.0, observed_order(np.array(errors))[0]


def _arrivals(result: xr.Dataset, probe: float, count: int) -> list[float]:
    """Return the first arrivals of the vibrating tip at a probe [s]; angles are in rad."""
    angle, speed = float(result["tip_angle"][BLADE]), stage().speed

    def ahead(time: float, turn: int) -> float:
        moved = AMPLITUDE * np.cos(FREQUENCY * time) / stage().case.tip_radius
        return float(angle + speed * time + moved - probe - 2.0 * np.pi * turn)

    first = int(np.ceil(ahead(0.0, 0) / (2.0 * np.pi)))
    return [brentq(ahead, 0.0, 1.0, args=(first + m,), xtol=1e-16) for m in range(count)]


@verifies("displacement", "acceleration")
def order_of_wall_sensors(quantity: str) -> Pair:
    """Compare the order of convergence of the motion of the wall between records with four for the
    displacement and two for the acceleration."""
    errors = []
    sensor = {"type": "wall", "angle": ANGLE, "name": "wall"}
    for records in RECORDS:
        result = vibration(records, "casing", 0, 1e-3)
        amplitude = float(recorded(result, sensor)["wall"][0])
        rate = 3.0 * (records - 1) / DURATION
        signal = recorded(result, sensor | {"quantity": quantity, "sampling_rate": rate})["wall"]
        exact = amplitude * np.cos(FREQUENCY * signal[signal.dims[0]].values)
        exact *= -(FREQUENCY**2) if quantity == "acceleration" else 1.0
        errors.append(np.abs(signal.values - exact).max())
    return (4.0 if quantity == "displacement" else 2.0), observed_order(np.array(errors))[0]
