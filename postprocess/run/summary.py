"""Summary of a run: `summary.json`."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from typing import Any, TypedDict

import numpy as np
import xarray as xr

from bladewhirl.files import json_text
from bladewhirl.postprocess.energy import strain
from bladewhirl.postprocess.energy.regimes import CRITERION_TEXT, Regime, RegimeName, classify
from bladewhirl.postprocess.energy.works import Works, late_drive_power, works
from bladewhirl.postprocess.fields.kinematics import Array
from bladewhirl.postprocess.fields.result import reduce_modes
from bladewhirl.postprocess.fields.windows import late_part
from bladewhirl.postprocess.run import extremes
from bladewhirl.postprocess.run.stresses import peak_stresses
from bladewhirl.postprocess.run.wear import wear_summary
from bladewhirl.postprocess.shaft.orbits import shaft_orbit
from bladewhirl.postprocess.shaft.transforms import strongest_lines
from bladewhirl.postprocess.shaft.whirl import FRAMES, ripple, whirl

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


MARCH_REPORT: Mapping[str, type[float]] = {
    "complementarity_residual": float,
    "unsolved_steps": int,
    "dt_over_critical": float,
    "steps": int,
    "wall_time": float,
    "us_per_step": float,
}
"""Key figures of the march that the histories in a result do not contain, with their types."""

ROUNDING = 1e-9
"""Displacements of the shaft below this fraction of those of the tips are rounding errors."""


@dataclass(frozen=True, kw_only=True)
class MarchQuality:
    """Quality and cost of a march and the wear of a coating: the last entries of a summary."""

    energy_residual: float  #: error of the energy balance, relative to its largest term
    complementarity_residual: float  #: largest residual of any step, relative to the gap's scale
    unsolved_steps: int
    """Number of steps whose contact problem no exact method solved; for a superelement, steps whose
    forces or sliding directions did not converge."""
    record_step: float  #: time between the records, of which largest values are [s]
    dt_over_critical: float  #: ratio of the time step to the critical time step
    steps: int
    wall_time: float  #: [s]
    us_per_step: float  #: [µs]
    wear: dict[str, Any] = field(default_factory=dict)
    """Wear of the coating, see `wear_summary`; its entries are keys of `summary.json`."""

    def to_json(self) -> str:
        """Return the summary as a JSON document with full precision."""
        entries = asdict(self)
        last = {each.name: entries.pop(each.name) for each in fields(MarchQuality)}
        wear = last.pop("wear")
        return json_text(entries | last | wear)


@dataclass(frozen=True, kw_only=True)
class Summary(MarchQuality):
    """Key figures of a run; the fields are the keys of `summary.json`."""

    regime: RegimeName
    regime_criterion: str  #: criterion of the regimes, and the reason for the regime of this run
    growth_rate: float | None  #: growth rate of the amplitude [1/s]; None if it cannot be judged
    growth_rate_error: float | None  #: standard error of `growth_rate` [1/s]
    growth_rate_end: float | None  #: growth rate fitted to the last five windows only [1/s]
    growth_residual: float | None  #: root mean square misfit of the logarithm of the amplitude
    ripple_growth_rate: float | None  #: growth rate of the motion about its mean position [1/s]
    ripple_growth_rate_error: float | None  #: standard error of `ripple_growth_rate` [1/s]
    end_reason: str  #: "completed", "divergent" or "interrupted"
    end_time: float  #: time of the last record [s]
    shaft_radius_max: float  #: largest displacement of the shaft over the records [m]
    shaft_radius_final: float  #: displacement of the shaft at the last record [m]
    whirl_frequency_rotating: float | None
    """Net turns per second [Hz] about the bearing's centre in rotating axes over the last third,
    forward positive; None if there is no single whirl frequency, see `whirl.whirl`."""
    whirl_frequency_static: float | None  #: whirl frequency in static axes [Hz]
    #: standard error of the whirl frequency in either frame [Hz]
    whirl_frequency_error: float | None
    whirl_lines: list[LineOfWhirl]  #: strongest lines of the two-sided spectrum over the last third
    ripple_rms: float  #: motion of the shaft about its mean position, rotating axes, last third [m]
    ripple_frequency: float | None  #: net turns per second about the mean position [Hz]
    ripple_lines: list[LineOfWhirl]  #: strongest lines of the two-sided spectrum of the ripple
    tip_displacement_max: float  #: largest displacement of a blade tip over the records [m]
    strain_energy_max: float  #: largest strain energy of bladed disk and shaft springs [J]
    strain_energy_final: EnergyHolders  #: strain energies of groups of modes, last record [J]
    strain_energy_rest: dict[str, float]  #: strain energy `rest` of the last record by family [J]
    strain_energy_casing_final: float  #: strain energy of casing and its support, last record [J]
    work: Works  #: works of load, contact forces, damping and drive [J]
    drive_power: float | None  #: mean power against contact forces over the last third [W]
    drive_torque: float | None  #: `drive_power` divided by the speed [N m]; None at rest
    casing_displacement_max: dict[str, extremes.WallPeak]  #: "radial" and "tangential"
    contact_force_max: extremes.ForcePeak
    contact_impulse: float  #: sum of the normal impulses on all blades [N s]
    stress_max: dict[str, extremes.StressPeak]  #: largest stress of "bladed_disk" and "casing"
    yield_strength: float | None  #: lowest of the yield strengths given in the case [Pa]
    contact_share: list[float]  #: share of the time steps in contact, for each blade
    gap_violation_max: float  #: deepest penetration at any step [m]


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
    energies = strain.strain_energies(dataset) if energies is None else energies
    orbit = shaft_orbit(dataset) if orbit is None else orbit
    radius = orbit["radius"].values
    regime = classify(dataset, energies["total"].values)
    power, speed = late_drive_power(dataset), float(dataset.attrs["speed"])
    casing = dataset["casing_frequency"].values * dataset["casing_displacement"][-1].values
    tips = _largest_tip_displacement(dataset)
    return Summary(
        **common_figures(dataset, regime, march_report),
        growth_rate_end=regime.growth.end_rate if regime.growth else None,
        growth_residual=regime.growth.residual if regime.growth else None,
        ripple_growth_rate=regime.ripple.rate if regime.ripple else None,
        ripple_growth_rate_error=regime.ripple.error if regime.ripple else None,
        shaft_radius_max=float(radius.max()),
        shaft_radius_final=float(radius[-1]),
        **_whirl_figures(orbit, moves=bool(radius.max() > ROUNDING * tips)),
        tip_displacement_max=tips,
        strain_energy_max=float(energies["total"].max()),
        strain_energy_final=_holders(energies.isel(time=-1)),
        strain_energy_rest=_rest(dataset),
        strain_energy_casing_final=float(0.5 * np.sum(casing**2)),
        work=works(dataset),
        drive_power=_finite(power),
        drive_torque=_finite(power / speed) if speed else None,
        casing_displacement_max=extremes.casing_peaks(dataset),
        contact_force_max=extremes.largest_force(dataset),
        stress_max=extremes.stress_peaks(peak_stresses(dataset) if stresses is None else stresses),
        yield_strength=dataset.attrs.get("yield_strength"),
        gap_violation_max=max(0.0, -float(dataset["gap"].min())),
    )


def common_figures(
    dataset: xr.Dataset, regime: Regime, march_report: Mapping[str, float]
) -> dict[str, Any]:
    """Return the fields that summaries of beams and of superelements have in common, by name.

    Raises:
        ValueError: an entry of the report is missing.
    """
    missing = [key for key in MARCH_REPORT if key not in march_report]
    if missing:
        raise ValueError(f"march report: expected {', '.join(MARCH_REPORT)}; lacks {missing}")
    report = {key: kind(march_report[key]) for key, kind in MARCH_REPORT.items()}
    contact_steps = dataset["contact_steps"].sum("time").values
    return {
        "regime": regime.name,
        "regime_criterion": f"{CRITERION_TEXT}. Here: {regime.reason}.",
        "growth_rate": regime.growth.rate if regime.growth else None,
        "growth_rate_error": regime.growth.error if regime.growth else None,
        "end_reason": str(dataset.attrs["end_reason"]),
        "end_time": float(dataset["time"][-1]),
        "contact_impulse": float(dataset["contact_impulse"].sum()),
        "contact_share": (contact_steps / max(report["steps"], 1)).tolist(),
        "record_step": float(dataset.attrs["record_step"]),
        "energy_residual": energy_residual(dataset),
        "wear": wear_summary(dataset),
        **report,
    }


def energy_residual(dataset: xr.Dataset) -> float:
    """Return the largest error of the energy balance relative to its largest term; 0 at rest.

    At every record, energy - energy_0 = external + normal + friction + coupling work - damping
    work. Works are since the first record, energy_0 is the energy at the first record, and the
    damping work is positive.
    """
    works = {
        name: dataset.variables[f"{name}_work"].values
        for name in ("external", "normal", "friction", "coupling", "damping")
        if f"{name}_work" in dataset  # a superelement has no coupling
    }
    energy = dataset.variables["energy"].values
    since: dict[str, Array] = {name: work - work[0] for name, work in works.items()}
    taken = since.pop("damping")
    gained = sum(since.values()) - taken
    error = np.abs(energy - energy[0] - gained).max()
    largest = max(np.abs(term).max() for term in (energy, *works.values()))
    return float(error / largest) if largest > 0 else 0.0


def _whirl_figures(orbit: xr.Dataset, *, moves: bool) -> dict[str, Any]:
    """Return the whirl and the ripple of the shaft in the last third; if `moves` is false, the
    motion is only rounding, and frequencies and lines are left out."""
    late = late_part(orbit)
    rotating, static = (whirl(late, frame) for frame in FRAMES)
    size, about = ripple(late, "rotating")
    return {
        "whirl_frequency_rotating": rotating.frequency if moves else None,
        "whirl_frequency_static": static.frequency if moves else None,
        "whirl_frequency_error": _finite(rotating.error / (2 * np.pi)) if moves else None,
        "whirl_lines": _lines(late) if moves else [],
        "ripple_rms": size,
        "ripple_frequency": whirl(about, "rotating").frequency if moves else None,
        "ripple_lines": _lines(about) if moves else [],
    }


def _lines(orbit: xr.Dataset) -> list[LineOfWhirl]:
    carried = abs(float(orbit.attrs["speed"])) / (2 * np.pi)
    return [
        {"rotating": line.frequency, "static": line.frequency + carried, "share": line.share}
        for line in strongest_lines(orbit, "rotating")
    ]


def _finite(value: float) -> float | None:
    """Return a number for JSON; None for nan and infinity, which JSON cannot represent."""
    return float(value) if np.isfinite(value) else None


def _rest(dataset: xr.Dataset) -> dict[str, float]:
    """Return the strain energy of the bladed disk at the last record by family, without the
    suspension and the first family."""
    last = (
        strain.family_energies(dataset.isel(time=[-1]))["energy"].isel(time=0).sum("nodal_diameter")
    )
    named = zip(last["family"].values, last.values, strict=True)
    return {str(k): float(e) for k, e in named if k not in (strain.SUSPENSION, strain.FIRST_FAMILY)}


def _largest_tip_displacement(dataset: xr.Dataset) -> float:
    """Return the largest displacement of a tip at any record [m]."""
    blades = dataset.sizes["blade"]
    shapes = dataset["rotor_shape"].values[dataset["tip_node"].values, :2]
    moved = reduce_modes(dataset, "rotor_displacement", shapes.reshape(2 * blades, -1))
    square = (moved.reshape(-1, blades, 2) ** 2).sum(axis=2)
    return float(np.sqrt(square.max()))


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
