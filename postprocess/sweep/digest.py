"""Reduction of a run to the data of a sweep: spectrum, energies, regime, thinned histories."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import xarray as xr
from scipy.interpolate import CubicHermiteSpline

from bladewhirl.postprocess.fields.by_blade import natural_modes, of_blades
from bladewhirl.postprocess.fields.kinematics import Array, IntArray, ViewError
from bladewhirl.postprocess.fields.netcdf import has
from bladewhirl.postprocess.fields.windows import late_part
from bladewhirl.postprocess.run.blade_contact import contact_share
from bladewhirl.postprocess.run.contact_side import contact_scenario
from bladewhirl.postprocess.run.extremes import casing_peaks, largest_force
from bladewhirl.postprocess.run.joint_contact import joint_figures
from bladewhirl.postprocess.run.measures import MEASURES, Motion
from bladewhirl.postprocess.run.stresses import known_peaks
from bladewhirl.postprocess.run.wear import wear_summary
from bladewhirl.postprocess.shaft.orbits import centre_displacement, shaft_orbit
from bladewhirl.postprocess.shaft.poincare import section_places
from bladewhirl.postprocess.shaft.transforms import FEWEST_RECORDS, Complex, spectrum
from bladewhirl.postprocess.shaft.whirl import whirls
from bladewhirl.postprocess.shaft.whirl_history import rotating_rates
from bladewhirl.postprocess.sweep.dataset import (
    MODE_LINES,
    NATURAL,
    SECTIONS,
    WINDOW_SHARE,
    Layout,
    flag,
)

Digest = dict[str, np.ndarray]
"""Arrays by name; `Layout` determines their shapes and `SWEEP` their dtypes."""


def digest(dataset: xr.Dataset, report: Mapping[str, float], layout: Layout) -> Digest:
    """Reduce a result to the data of a sweep.

    Args:
        dataset: a result.
        report: `complementarity_residual`, `dt_over_critical`, `steps` and `unsolved_steps` of the
            march.
        layout: sizes of the arrays; elements without a value are NaN.
    """
    time, run = dataset.variables["time"].values, Motion(dataset, report)
    energies, diameters = run.groups
    groups, steps = _groups(energies, diameters, layout), int(report["steps"])
    step = float(dataset.attrs["record_step"])
    first = len(time) - max(1, round(min(layout.window, WINDOW_SHARE * np.ptp(time)) / step))
    starts = span_starts(len(time), layout.samples)
    counts = np.diff(starts, append=len(time))
    late, share = late_part(dataset), np.full(layout.blades, np.nan)
    if late.sizes["time"] > 1:
        share = padded(of_blades(late, contact_share(late), np.maximum), layout.blades)
    touched = dataset.variables["contact_steps"].values.sum(axis=0) / max(steps, 1)
    measured = {name: MEASURES[name](run) for name in layout.variables if name in MEASURES}
    values = {
        **{name: np.nan if value is None else value for name, value in measured.items()},
        "contact_share": padded(of_blades(dataset, touched, np.maximum), layout.blades),
        "late_contact_share": share,
        "contact_force_max": largest_force(dataset)["force"],
        "stress_max": _blade_stress(dataset),
        **wear_numbers(dataset),
        **_natural_modes(dataset),
        "window_start": time[first],
        "energy_mean": groups[first:].mean(axis=0),
        "energy_max": groups.max(axis=0),
        "history_time": padded(time[starts], layout.samples),
        "energy_history": padded(np.add.reduceat(groups, starts) / counts[:, None], layout.samples),
    }
    for part, measure in PARTS.items():
        if part in layout.parts:
            values |= measure(dataset, layout, first, starts)
    return coded({name: values[name] for name in layout.variables if name in values}, layout)


def _blade_stress(dataset: xr.Dataset) -> float:
    """Return the largest magnitude of the stress of a blade [Pa]; NaN without stresses."""
    stresses = known_peaks(dataset, casing=False)
    if stresses is None:
        return np.nan
    peaks = stresses["peak_stress"]
    return float(np.abs(peaks[peaks["member"].str.startswith("blade ")]).max())


def _natural_modes(dataset: xr.Dataset) -> dict[str, Array]:
    """Return the lowest natural frequencies [Hz] and their nodal diameters."""
    frequency, diameter = natural_modes(dataset)
    return {
        "natural_frequency": padded(frequency[:NATURAL], NATURAL),
        "natural_diameter": padded(diameter[:NATURAL].astype(np.float64), NATURAL),
    }


def _shaft(dataset: xr.Dataset, layout: Layout, first: int, starts: IntArray) -> dict[str, Any]:
    """Return the motion of the shaft's centre: its extent, its spectrum from the record `first` on,
    its history, and its late motion."""
    step = float(dataset.attrs["record_step"])
    motion = centre_displacement(dataset) @ np.array([1.0, 1.0j])
    sense = -1.0 if dataset.attrs["speed"] < 0.0 else 1.0
    samples = layout.samples
    late = late_part(dataset)
    moved = late_motion(late, shaft_orbit(late))
    section = moved.pop("section")[-SECTIONS:]
    return {
        "spectrum": magnitudes(
            motion.real[first:] + sense * 1j * motion.imag[first:], step, layout.frequency
        ),
        "orbit_x": padded(motion.real[starts], samples),
        "orbit_y": padded(motion.imag[starts], samples),
        "radius_history": padded(np.maximum.reduceat(np.abs(motion), starts), samples),
        **moved,
        "section_x": padded(section[:, 0], SECTIONS),
        "section_y": padded(section[:, 1], SECTIONS),
        "radius_peak": padded(moved["radius_peak"][-SECTIONS:], SECTIONS),
    }


def _joints(dataset: xr.Dataset, layout: Layout, first: int, starts: IntArray) -> dict[str, Any]:
    """Return forces, states and work of friction joints, and the amplitudes of the blades."""
    joints = joint_figures(dataset).values()
    moved = late_part(dataset)["contact_displacement"].values
    swing = 0.5 * np.ptp(moved, axis=0).max(axis=1)
    return {
        "joint_force_max": max(each["largest_normal_force"] for each in joints),
        "joint_open": np.mean([each["share_open"] for each in joints]),
        "joint_slipping": np.mean([each["share_slipping"] for each in joints]),
        "joint_work": sum(each["work"] for each in joints),
        "joint_wear": sum(each["wear_energy"] for each in joints),
        "blade_amplitude": padded(of_blades(dataset, swing, np.maximum), layout.blades),
    }


def _modes(dataset: xr.Dataset, layout: Layout, first: int, starts: IntArray) -> dict[str, Any]:
    """Return the frequencies of modes that move with the shaft."""
    return {
        "mode_frequency": _mode_frequencies(dataset, "backward"),
        "mode_forward_frequency": _mode_frequencies(dataset, "forward"),
    }


def _nodes(dataset: xr.Dataset, layout: Layout, first: int, starts: IntArray) -> dict[str, Any]:
    """Return the recorded motion of contact nodes and casing: extremes, the spectrum of the
    tangential displacement of the node that moves most from the record `first` on, and the
    history of the radial displacement."""
    moved = dataset["contact_displacement"].values
    late = moved[len(moved) - late_part(dataset).sizes["time"] :]
    radial = np.abs(moved[:, :, 0]).max(axis=1)
    swing = moved[first:, :, 1]
    swing = swing[:, int(np.abs(swing).max(axis=0).argmax())]
    spectrum = 2.0 * magnitudes(
        swing.astype(complex), float(dataset.attrs["record_step"]), layout.frequency
    )
    casing = np.nan
    if has(dataset, "casing"):
        casing = abs(casing_peaks(dataset)["radial"]["displacement"])
    return {
        "displacement_max": np.abs(moved).max(),
        "late_displacement": np.abs(late).max(axis=(0, 1)),
        "casing_displacement_max": casing,
        "contact_spectrum": np.where(layout.frequency == 0.0, 0.5 * spectrum, spectrum),
        "radial_history": padded(np.maximum.reduceat(radial, starts), layout.samples),
    }


PARTS: Mapping[str, Callable[[xr.Dataset, Layout, int, IntArray], dict[str, Any]]] = {
    "centre": _shaft,
    "joints": _joints,
    "families": _modes,
    "nodes": _nodes,
}
"""Functions that measure what not every stage has, by the part of the stage in the schema."""


def coded(values: Mapping[str, object], layout: Layout) -> Digest:
    """Return values as arrays of the variables of a sweep, with codes in place of words."""
    variables = layout.variables
    numbers = {
        name: flag(name, str(value)) if variables[name].labels else value
        for name, value in values.items()
    }
    return {name: np.asarray(value, dtype=variables[name].kind) for name, value in numbers.items()}


def magnitudes(motion: Complex, step: float, frequency: Array) -> Array:
    """Return the magnitude of the spectrum of a motion x + i y under a Hann window, at given
    frequencies, which need not fit the length of the motion.

    Args:
        motion: equally spaced samples, (samples,).
        step: time between samples [s].
        frequency: equally spaced frequencies, ascending [Hz], (frequencies,).

    Returns:
        magnitudes (frequencies,), in the unit of the motion; NaN if there are too few samples.
    """
    count = len(motion)
    if count < FEWEST_RECORDS:
        return np.full(len(frequency), np.nan)
    window = np.hanning(2 * count + 1)[1::2]  # samples in the middle of their intervals
    return np.abs(spectrum(motion, step, window, frequency=frequency)[1])


def wear_numbers(dataset: xr.Dataset) -> dict[str, float]:
    """Return the wear of the coating; NaN without a coating."""
    wear = wear_summary(dataset)
    names = ("wear_volume", "wear_strain_max", "wear_dissipated")
    values = {name: wear.get(name, np.nan) for name in names}
    return values | {"wear_lobes": wear.get("lobes", np.nan)}


def _groups(energies: Array, diameters: IntArray, layout: Layout) -> Array:
    """Return the energies [J], (time, groups), with a column for each group of modes in `layout`;
    columns of nodal diameters without a mode are NaN. `energies` and `diameters` are from
    `group_energies`."""
    if len(layout.groups) == 1:
        return np.asarray(energies.sum(axis=1, keepdims=True))
    groups = np.full((len(energies), len(layout.groups)), np.nan)
    groups[:, [0, *(1 + diameters), -1]] = energies
    return groups


def _mode_frequencies(dataset: xr.Dataset, way: str) -> Array:
    """Return the lowest frequency of the modes of each entry of `MODE_LINES` [Hz]; NaN if there is
    no such mode. `way` selects the "backward" or the "forward" wave on the rotor, whose frequencies
    differ with Coriolis forces."""
    frequencies = []
    for body, family in MODE_LINES.values():
        if body == "casing" and not has(dataset, "casing"):
            frequencies.append(np.nan)
            continue
        candidates = dataset.variables[f"{body}_nodal_diameter"].values == 1
        if family is not None:
            candidates &= dataset.variables[f"{body}_family"].values == family
        wave = f"_{way}" if body == "rotor" else ""
        frequency = dataset.variables[f"{body}{wave}_frequency"].values[candidates]
        frequencies.append(frequency.min() / (2.0 * np.pi) if frequency.size else np.nan)
    return np.array(frequencies)


def span_starts(records: int, samples: int) -> IntArray:
    """Return the first record of each of at most `samples` equal spans."""
    spans = min(samples, records)
    return np.asarray(np.arange(spans) * records // spans, dtype=np.int64)


def padded(values: Array, length: int) -> Array:
    """Return values padded with NaN to `length` along the first axis."""
    out = np.full((length, *values.shape[1:]), np.nan)
    out[: len(values)] = values
    return out


def late_motion(late: xr.Dataset, orbit: xr.Dataset) -> dict[str, Any]:
    """Measure the motion in the last third of a run.

    Args:
        late: result, from `windows.late_part`.
        orbit: from `orbits.shaft_orbit`, for the same time window.

    Returns:
        values of variables of a sweep, by name; `solvers.march.schema` describes the variables.
        `whirl_scatter` is nan if `whirl_history` has a single span. `radius_peak` (peak,) [m]
        contains all maxima of the displacement, `section` (revolution, 2) [m] all positions of the
        Poincaré map, which are the same in both frames.
    """
    scenario, lead, steadiness = contact_scenario(late, orbit)
    turning, rates = whirls(orbit), rotating_rates(orbit)
    rates = rates[~np.isnan(rates)]
    try:
        section = section_places(orbit)[1]
    except ViewError:  # less than a revolution
        section = np.empty((0, 2))
    return {
        "late_radius": float(np.sqrt(np.mean(orbit.variables["radius"].values ** 2))),
        "whirl_rotating": turning["rotating"].direction,
        "whirl_static": turning["static"].direction,
        "whirl_frequency": turning["rotating"].rate / (2 * np.pi),
        "whirl_scatter": float(rates.std() / (2 * np.pi)) if len(rates) > 1 else np.nan,
        "scenario": scenario.replace(" ", "-"),
        "shaft_lead": lead,
        "lead_steadiness": steadiness,
        "section": section,
        "radius_peak": radius_peaks(orbit),
    }


def radius_peaks(orbit: xr.Dataset) -> Array:
    """Return the local maxima of the displacement of the shaft, also between records, (peaks,) [m].

    The square of the displacement is interpolated by cubics through the values and rates at the
    records. A maximum is where the rate, interpolated linearly between records, falls through zero.
    """
    time, place, velocity = (
        orbit.variables[name].values for name in ("time", "rotating", "rotating_velocity")
    )
    square, rate = np.sum(place**2, axis=1), 2.0 * np.sum(place * velocity, axis=1)
    before = np.flatnonzero((rate[:-1] > 0) & (rate[1:] <= 0))
    if not before.size:
        return np.empty(0)
    share = rate[before] / (rate[before] - rate[before + 1])
    instants = time[before] + share * (time[before + 1] - time[before])
    return np.asarray(np.sqrt(CubicHermiteSpline(time, square, rate)(instants)))
