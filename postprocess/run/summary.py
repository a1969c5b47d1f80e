"""Summary of a run: `summary.json`."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any, TypedDict

import numpy as np
import xarray as xr

from bladewhirl.files import json_text
from bladewhirl.postprocess.energy import strain
from bladewhirl.postprocess.energy.regimes import RegimeName
from bladewhirl.postprocess.energy.works import (
    Works,
    drive_work,
    friction_supply,
    friction_torque_impulse,
    late_rate,
    works,
)
from bladewhirl.postprocess.fields.by_blade import largest_contact_motion, of_blades
from bladewhirl.postprocess.fields.netcdf import has
from bladewhirl.postprocess.fields.nodes import DIRECTIONS
from bladewhirl.postprocess.fields.windows import late_part
from bladewhirl.postprocess.run import extremes
from bladewhirl.postprocess.run.joint_contact import JointFigures, joint_figures
from bladewhirl.postprocess.run.measures import MARCH_REPORT, MEASURES, Motion
from bladewhirl.postprocess.run.stresses import known_peaks
from bladewhirl.postprocess.run.wear import wear_summary
from bladewhirl.postprocess.shaft.bearing_forces import bearing_forces
from bladewhirl.postprocess.shaft.crossings import crossings
from bladewhirl.postprocess.shaft.transforms import strongest_lines
from bladewhirl.postprocess.shaft.whirl import FRAMES, ripple, whirl
from bladewhirl.postprocess.shaft_line.motion import line_bearing_forces
from bladewhirl.solvers.march.schema import SUMMARY

EnergyHolders = TypedDict(
    "EnergyHolders", {"suspension": float, "1F": dict[str, float], "rest": float}
)
"""Strain energies of groups of modes [J]. The energies of the first family, "1F", are given by
nodal diameter, which is a text ("0", "1", ...) as in JSON."""


class LineOfWhirl(TypedDict):
    """Line of a spectrum: its frequency in both frames [Hz], forward positive, and its share of the
    mean square displacement."""

    rotating: float
    static: float
    share: float


class CriticalCrossing(TypedDict):
    """Crossing of a critical speed: its instant [s], the critical speed [rad/s] with its whirl,
    whether the speed rises, and the largest displacement of the shaft over the turns of the rotor
    around the instant [m]."""

    time: float
    speed: float
    whirl: str
    rising: bool
    amplitude: float


ROUNDING = 1e-9
"""Displacements of the shaft below this fraction of those of the tips are rounding errors."""


@dataclass(frozen=True, kw_only=True)
class Summary:
    """Key figures of a run; the fields are the keys of `summary.json`, with the units and meanings
    of `solvers.march.schema.SUMMARY`. Figures of quantities that the stage does not have are None,
    lists are then empty."""

    regime: RegimeName
    regime_criterion: str
    growth_rate: float | None
    growth_rate_error: float | None
    growth_rate_end: float | None
    growth_residual: float | None
    ripple_growth_rate: float | None
    ripple_growth_rate_error: float | None
    end_reason: str
    end_time: float
    revolutions: float
    shaft_radius_max: float | None
    shaft_radius_final: float | None
    bearing_force_max: float | None
    bearing_force_time: float | None
    whirl_frequency_rotating: float | None
    whirl_frequency_static: float | None
    whirl_frequency_error: float | None
    whirl_lines: list[LineOfWhirl]
    ripple_rms: float | None
    ripple_frequency: float | None
    ripple_lines: list[LineOfWhirl]
    critical_crossings: list[CriticalCrossing]
    tip_displacement_max: float
    contact_displacement_max: dict[str, float]
    strain_energy_max: float
    strain_energy_final: EnergyHolders | None
    strain_energy_rest: dict[str, float] | None
    strain_energy_casing_final: float | None
    energy_final: float
    work: Works
    drive_power: float | None
    drive_torque: float | None
    friction_power: float | None
    friction_torque: float | None
    casing_displacement_max: dict[str, extremes.WallPeak] | None
    contact_force_max: extremes.ForcePeak
    contact_impulse: float
    contact_impulse_by_blade: list[float]
    impulse_per_revolution: float | None
    stress_max: dict[str, extremes.StressPeak] | None
    stress_split: extremes.StressSplit | None
    blade_loss: str | None
    fuse_time: float | None
    yield_strength: float | None
    contact_share: list[float]
    gap_violation_max: float
    energy_residual: float
    complementarity_residual: float
    unsolved_steps: int
    unsolved_time: float | None
    unsolved_impulse_share: float
    unsolved_wear_share: float
    record_step: float
    dt_over_critical: float
    steps: int
    wall_time: float
    us_per_step: float
    joints: dict[str, JointFigures] = field(default_factory=dict)
    wear: dict[str, Any] = field(default_factory=dict)

    def to_json(self) -> str:
        """Return the summary as a JSON document with full precision."""
        entries = asdict(self)
        return json_text(entries | entries.pop("wear"))


def summarise(
    dataset: xr.Dataset,
    march_report: Mapping[str, float],
    stresses: xr.Dataset | None = None,
    *,
    orbit: xr.Dataset | None = None,
    energies: xr.Dataset | None = None,
) -> Summary:
    """Compute the summary of a result, which is read portion by portion.

    Args:
        dataset: a result.
        march_report: `complementarity_residual`, `unsolved_steps`, `dt_over_critical`, `steps`,
            `wall_time` [s] and `us_per_step` [µs], which the histories do not contain; other
            entries are ignored.
        stresses: from `stresses.stress_history`; computed when None.
        orbit: from `orbits.shaft_orbit`; computed when None.
        energies: from `strain_energies`; computed when None.

    Raises:
        ValueError: an entry of the report is missing.
    """
    missing = [key for key in MARCH_REPORT if key not in march_report]
    if missing:
        raise ValueError(f"march report: expected {', '.join(MARCH_REPORT)}; lacks {missing}")
    energies = strain.strain_energies(dataset) if energies is None else energies
    run = Motion(dataset, march_report, orbit=orbit)
    power, speed = late_rate(dataset, drive_work(dataset)), float(dataset.attrs["speed"])
    peaks = known_peaks(dataset) if stresses is None else stresses
    grouped, impulse = energies.sizes["nodal_diameter"] > 0, dataset["contact_impulse"].values
    largest_motion = largest_contact_motion(dataset).max(0, initial=0.0).tolist()
    wear = wear_summary(dataset)
    contact_steps = dataset["contact_steps"].sum("time").values
    measured = {name: MEASURES[name](run) for name in SUMMARY if name in MEASURES}
    return Summary(
        **measured,
        **_shaft_figures(run, measured["tip_displacement_max"]),
        contact_displacement_max=dict(zip(DIRECTIONS, largest_motion, strict=True)),
        strain_energy_final=_holders(energies.isel(time=-1)) if grouped else None,
        strain_energy_rest=_rest(dataset) if grouped else None,
        **_casing_figures(dataset),
        work=works(dataset),
        drive_power=_finite(power),
        drive_torque=_finite(power / speed) if speed else None,
        friction_power=_finite(late_rate(dataset, friction_supply(dataset))),
        friction_torque=_finite(late_rate(dataset, friction_torque_impulse(dataset))),
        contact_force_max=extremes.largest_force(dataset),
        contact_impulse_by_blade=of_blades(dataset, impulse.sum(axis=0)).tolist(),
        stress_max=None if peaks is None else extremes.stress_peaks(peaks),
        stress_split=None if peaks is None else extremes.stress_split(peaks),
        contact_share=(contact_steps / max(measured["steps"], 1)).tolist(),
        joints=joint_figures(dataset),
        wear=wear,
        unsolved_impulse_share=_unsolved(dataset, "impulse", float(impulse.sum())),
        unsolved_wear_share=_unsolved(dataset, "wear", wear.get("wear_volume", 0.0)),
    )


def _unsolved(dataset: xr.Dataset, of_what: str, total: float) -> float:
    """Return the share of a total that the unsolved steps have."""
    return float(dataset.attrs.get(f"unsolved_{of_what}", 0.0)) / total if total else 0.0


def _shaft_figures(run: Motion, tips: float) -> dict[str, Any]:
    """Return the figures of the shaft: forces on its bearings, and whirl and ripple in the last
    third. If the shaft moves less than a rounding error of the motion of the tips [m],
    frequencies and lines are left out; without a moving centre all are."""
    numbers = (
        *("whirl_frequency_rotating", "whirl_frequency_static", "whirl_frequency_error"),
        *("ripple_rms", "ripple_frequency", "bearing_force_max", "bearing_force_time"),
    )
    figures: dict[str, Any] = {**dict.fromkeys(numbers), "whirl_lines": [], "ripple_lines": []}
    figures["critical_crossings"] = []
    if has(run.result, "line"):
        figures |= _largest_bearing_force(line_bearing_forces(run.result))
    if not run.has_shaft:
        return figures
    dataset, orbit, late = run.result, run.orbit, late_part(run.orbit)
    names = CriticalCrossing.__annotations__
    figures["critical_crossings"] = [
        {name: getattr(each, name) for name in names} for each in crossings(dataset, orbit)
    ]
    figures["ripple_rms"], about = ripple(late, "rotating")
    if not run.radius.max() > ROUNDING * tips:
        return figures
    if not has(dataset, "line"):
        figures |= _largest_bearing_force(bearing_forces(dataset, orbit))
    rotating, static = (whirl(late, frame) for frame in FRAMES)
    return figures | {
        "whirl_frequency_rotating": rotating.frequency,
        "whirl_frequency_static": static.frequency,
        "whirl_frequency_error": _finite(rotating.error / (2 * np.pi)),
        "whirl_lines": _lines(late),
        "ripple_frequency": whirl(about, "rotating").frequency,
        "ripple_lines": _lines(about),
    }


def _largest_bearing_force(forces: xr.Dataset) -> dict[str, float]:
    """Return the largest force on any bearing, and its instant."""
    largest = forces["force"].values.reshape(forces.sizes["time"], -1).max(axis=1)
    first = int(largest.argmax())
    return {
        "bearing_force_max": float(largest[first]),
        "bearing_force_time": float(forces["time"][first]),
    }


def _casing_figures(dataset: xr.Dataset) -> dict[str, Any]:
    """Return energy and displacement of the casing, None for a rigid wall."""
    names = ("strain_energy_casing_final", "casing_displacement_max")
    if not has(dataset, "casing"):
        return dict.fromkeys(names)
    moved = dataset["casing_frequency"].values * dataset["casing_displacement"][-1].values
    return dict(
        zip(names, (float(0.5 * np.sum(moved**2)), extremes.casing_peaks(dataset)), strict=True)
    )


def _lines(orbit: xr.Dataset) -> list[LineOfWhirl]:
    carried = abs(float(orbit.attrs["speed"])) / (2 * np.pi)
    return [
        {"rotating": line.frequency, "static": line.frequency + carried, "share": line.share}
        for line in strongest_lines(orbit, "rotating")
    ]


def _finite(value: float) -> float | None:
    """Return a number for JSON; None for nan and infinity, which JSON cannot represent."""
    return float(value) if np.isfinite(value) else None


def _rest(dataset: xr.Dataset) -> dict[str, float] | None:
    """Return the strain energy of the bladed disk at the last record by family, without the
    suspension and the first family; None if families are not defined, after a loss of blades."""
    last = (
        strain.family_energies(dataset.isel(time=[-1]))["energy"]
        .isel(time=0)
        .sum("nodal_diameter", skipna=False)
    )
    if np.isnan(last).any():
        return None
    named = zip(last["family"].values, last.values, strict=True)
    return {str(k): float(e) for k, e in named if k not in (strain.SUSPENSION, strain.FIRST_FAMILY)}


def _holders(energies: xr.Dataset) -> EnergyHolders:
    """Return the strain energies of the groups of modes at one record."""
    family = energies["first_family"]
    return {
        "suspension": float(energies["suspension"]),
        "1F": {
            str(k): float(family.sel(nodal_diameter=k)) for k in family["nodal_diameter"].values
        },
        "rest": float(energies["rest"]),
    }
