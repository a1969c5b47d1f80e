"""Measures of claims on modes: uncoupled (claims 1 to 9), and coupled by springs (10 to 15)."""

from typing import Any

import numpy as np

from bladewhirl.solvers.stability.growth import UNSTABLE_GROWTH, is_unstable
from bladewhirl.solvers.stability.zones import UnstableZones, unstable_zones
from bladewhirl.studies.modal.stability import divergent_motion
from bladewhirl.studies.paper.claim import Measures, measures
from bladewhirl.studies.paper.trials import Evidence, NotTestableError

EXAMPLE = {"kappa": 500.0, "speed": 1.17}
"""The paper's example point: spring stiffness [N/m] and normalised speed."""

RANGE, KAPPAS = (0.6, 3.0), np.linspace(50.0, 1000.0, 20)
"""Speeds and spring stiffnesses [N/m] of Fig. 11."""

BESIDE = np.linspace(-0.02, 0.02, 81)
"""Differences from a coincidence speed at which stability is examined, normalised."""


@measures(*range(1, 10))
def uncoupled_modes(evidence: Evidence) -> Measures:
    """Return the measures of uncoupled modes, see `modal_measures`."""
    return evidence.modal


def _zones(evidence: Evidence) -> dict[str, UnstableZones]:
    """Return the paper's zones A and B, by their rotor mode: "1F" and "suspension"."""
    system = evidence.system
    unstable = unstable_zones(
        system.modes,
        kappas=KAPPAS,
        low=RANGE[0] * system.reference,
        high=RANGE[1] * system.reference,
    )
    zones = {}
    for name in ("1F", "suspension"):
        of_mode = [system.modes.name[rotor].startswith(name) for rotor in unstable.rotor]
        rows = {field: values[of_mode] for field, values in vars(unstable).items()}
        zones[name] = UnstableZones(**rows)
    return zones


@measures(10, 13)
def unstable_zones_over_stiffness(evidence: Evidence) -> Measures:
    """Return start and width of zones A and B, and whether the lower border of zone A rises."""
    coincidences = [evidence.modal[f"{name}_coincidence"] for name in ("first", "suspension")]
    reference, listed = evidence.system.reference, []
    values: dict[str, Any] = {"borders": "no zone", "rises": False}
    for zone, letter, coincidence in zip(
        _zones(evidence).values(), "AB", coincidences, strict=True
    ):
        if len(zone.kappa) < 2:
            values[f"present_{letter}"] = False
            continue
        lower, width = zone.lower / reference, (zone.upper - zone.lower) / reference
        listed.append(
            f"{letter} from {lower[0]:.4g}, {width[-1]:.3g} wide at {zone.kappa[-1]:g} N/m"
        )
        values[f"offset_{letter}"] = lower[0] - coincidence
        values[f"widens_{letter}"] = np.all(np.diff(width) > 0)
        if letter == "A":
            values["rises"] = np.all(np.diff(lower) > 0)
            values["borders"] = (
                f"from {lower[0]:.4g} at {zone.kappa[0]:g} to {lower[-1]:.4g} at"
                f" {zone.kappa[-1]:g} N/m"
            )
    return values | {"zones": "; ".join(listed) or "no zone"}


@measures(11, 12)
def example_point(evidence: Evidence) -> Measures:
    """Return growth rate [1/s], stability and the number of eigenvalues of each kind at the example
    point."""
    omega = EXAMPLE["speed"] * evidence.system.reference
    growth = _example_growth(evidence)
    real = evidence.system.spectrum(omega, EXAMPLE["kappa"]).real
    limit = UNSTABLE_GROWTH * omega
    return {
        "growth": growth,
        "stability": "unstable" if is_unstable(growth, omega) else "stable",
        "divergent": np.count_nonzero(real > limit),
        "damped": np.count_nonzero(real < -limit),
        "oscillatory": np.count_nonzero(np.abs(real) <= limit),
    }


def _example_growth(evidence: Evidence) -> float:
    system = evidence.system
    omega = np.array([EXAMPLE["speed"] * system.reference])
    return float(system.growth(omega, np.array([EXAMPLE["kappa"]]))[0, 0])


@measures(14)
def no_instability_beside_the_zones(evidence: Evidence) -> Measures:
    """Count the unstable points outside the zones and those near coincidences of backward waves.

    Backward waves on both bodies coincide in static axes at Ω = (ω_r - ω_c) / k.
    """
    system, zones = evidence.system, _zones(evidence)
    speeds = np.linspace(*RANGE, 600) * system.reference
    unstable = is_unstable(system.growth(speeds, KAPPAS), speeds)
    inside = np.zeros(unstable.shape, dtype=bool)
    for zone in zones.values():
        for kappa, lower, upper in zip(zone.kappa, zone.lower, zone.upper, strict=True):
            row = int(np.argmin(np.abs(KAPPAS - kappa)))
            inside[row] |= (speeds >= lower) & (speeds <= upper)
    modes = system.modes
    casing = float(modes.frequency[modes.on_casing].min())
    alike = (modes.frequency - casing)[~modes.on_casing] / modes.nodal_diameter[~modes.on_casing]
    around = np.concatenate([BESIDE * system.reference + speed for speed in alike])
    close = is_unstable(system.growth(around, KAPPAS), around)
    return {
        "outside": np.count_nonzero(unstable & ~inside),
        "points": unstable.size,
        "alike": np.count_nonzero(close),
        "alike_points": close.size,
        "speeds": " and ".join(f"{speed / system.reference:.3g}" for speed in alike),
    }


@measures(15)
def divergent_mode(evidence: Evidence) -> Measures:
    """Return directions of waves and whirl in the divergent mode, and the lead of the shaft [°].

    Raises:
        NotTestableError: no mode grows at the example point.
    """
    omega = EXAMPLE["speed"] * evidence.system.reference
    if not is_unstable(_example_growth(evidence), omega):
        raise NotTestableError("the paper's example point is stable")
    motion = divergent_motion(evidence.system, omega, EXAMPLE["kappa"])
    rates = {
        "rotor_wave": motion.rotor_wave_speed,
        "casing_wave": motion.casing_wave_speed,
        "rotating": motion.whirl_speed,
        "static": motion.whirl_speed_static,
    }
    directions = {name: "forward" if rate > 0 else "backward" for name, rate in rates.items()}
    return directions | {"lead": abs(float(np.degrees(motion.shaft_lead[-1])))}
