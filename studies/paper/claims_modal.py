"""Claims of Section 3: uncoupled modes (1 to 9), modes coupled by frame and bearings (10 to 15)."""

from __future__ import annotations

import numpy as np

from bladewhirl.solvers.stability.growth import (
    UNSTABLE_GROWTH,
    eigenvalues,
    growth_rate,
    is_unstable,
)
from bladewhirl.solvers.stability.zones import UnstableZones, unstable_zones
from bladewhirl.studies.modal.coupled_mode import divergent_motion
from bladewhirl.studies.paper.claim import (
    Check,
    Finding,
    at_least,
    at_most,
    between,
    equal,
    evaluates,
    near,
)
from bladewhirl.studies.paper.trials import Evidence

EXAMPLE = {"kappa": 500.0, "speed": 1.17}
"""The paper's example point: spring stiffness [N/m] and normalised speed."""

RANGE, KAPPAS = (0.6, 3.0), np.linspace(50.0, 1000.0, 20)
"""Speeds and spring stiffnesses [N/m] of Fig. 11."""

BESIDE = np.linspace(-0.02, 0.02, 81)
"""Normalised speeds examined around a coincidence."""

NOTHING = 1e-6
"""Relative motion or change below which it counts as zero."""


@evaluates(1)
def centre_moves_with_one_nodal_diameter(evidence: Evidence) -> Finding:
    motion = evidence.modal.centre_motion
    others = max(value for k, value in motion.items() if k != 1)
    return Finding(
        ours=f"k = 1: {motion[1]:.3g} of the mode's largest motion; others: {others:.1g}",
        checks=(
            at_least("motion of the centre with k = 1", motion[1], 0.1),
            at_most("with any other k", others, NOTHING),
        ),
    )


@evaluates(2)
def clamping_shifts_one_nodal_diameter(evidence: Evidence) -> Finding:
    shift = evidence.modal.clamping_shift
    others = max(value for k, value in shift.items() if k != 1)
    return Finding(
        ours=f"k = 1: up to {100 * shift[1]:.3g} %; others: {100 * others:.1g} %",
        checks=(
            at_least("largest change with k = 1", 100 * shift[1], 1.0, " %"),
            at_most("with any other k", others, NOTHING),
        ),
    )


@evaluates(3)
def suspension_between_families(evidence: Evidence) -> Finding:
    pair, second = evidence.modal.suspension, evidence.modal.second_family
    return Finding(
        ours=f"{pair:.3f}, 2F from {second:.3g}",
        checks=(
            near("suspension pair", pair, 2.5, 0.1),
            at_most("suspension pair below 2F:", pair, second),
        ),
    )


@evaluates(4)
def shaft_over_blade(evidence: Evidence) -> Finding:
    ratio = evidence.modal.shaft_over_blade
    return Finding(ours=f"{ratio:.4g}", checks=(near("ratio", ratio, 500.0, 125.0),))


@evaluates(5)
def reduction_error(evidence: Evidence) -> Finding:
    error = {family: 100 * value for family, value in evidence.modal.reduction_error.items()}
    families = [f"{rank}F" for rank in range(1, 6)]
    worst = max(families, key=lambda family: error[family])
    return Finding(
        ours=f"{evidence.modal.reduced_size} unknowns, at most {error[worst]:.3g} % ({worst})",
        checks=(
            near("unknowns", evidence.modal.reduced_size, 156, 0),
            *(at_most(f"error in {family}", error[family], 0.75, " %") for family in families),
        ),
    )


@evaluates(6)
def first_coincidence(evidence: Evidence) -> Finding:
    speed = evidence.modal.first_coincidence
    return Finding(ours=f"{speed:.4g}", checks=(near("coincidence", speed, 1.05, 0.02),))


@evaluates(7)
def suspension_coincidence(evidence: Evidence) -> Finding:
    speed = evidence.modal.suspension_coincidence
    return Finding(ours=f"{speed:.4g}", checks=(near("coincidence", speed, 2.6, 0.05),))


@evaluates(8)
def first_family_crossings(evidence: Evidence) -> Finding:
    crossings = evidence.modal.first_family_crossings
    listed = ", ".join(f"k = {k} at {speed:.3g}" for k, speed in crossings.items())
    return Finding(ours=listed or "none", checks=(at_least("crossings", len(crossings), 3),))


@evaluates(9)
def two_contact_scenarios(evidence: Evidence) -> Finding:
    scenarios = evidence.modal.scenarios
    lead = {name: abs(float(np.degrees(scenario.lead))) for name, scenario in scenarios.items()}
    return Finding(
        ours=", ".join(f"{scenarios[name].kind}: {lead[name]:.3g}°" for name in scenarios)
        + ", with the casing's share of the motion chosen",
        checks=(
            near("phase where the casing moves less", lead["standard"], 0.0, 1.0, "°"),
            near("phase where it moves more", lead["inverted"], 180.0, 1.0, "°"),
        ),
    )


def _zones(evidence: Evidence) -> dict[str, UnstableZones]:
    """Return zones A and B by the participating rotor mode: "1F" and "suspension"."""
    system = evidence.system
    unstable = unstable_zones(
        system.modes,
        kappas=KAPPAS,
        low=RANGE[0] * system.reference,
        high=RANGE[1] * system.reference,
        with_pi=system.with_pi,
    )
    zones = {}
    for name in ("1F", "suspension"):
        of_mode = [system.modes.name[rotor].startswith(name) for rotor in unstable.rotor]
        zones[name] = UnstableZones(
            **{
                part: getattr(unstable, part)[of_mode]
                for part in UnstableZones.__dataclass_fields__
            }
        )
    return zones


@evaluates(10)
def zones_widen(evidence: Evidence) -> Finding:
    starts = {
        "1F": evidence.modal.first_coincidence,
        "suspension": evidence.modal.suspension_coincidence,
    }
    reference, checks, ours = evidence.system.reference, [], []
    for (name, zone), letter in zip(_zones(evidence).items(), "AB", strict=True):
        if len(zone.kappa) < 2:
            checks.append(Check(text=f"zone {letter} is missing", met=False))
            continue
        width = (zone.upper - zone.lower) / reference
        start = float(zone.lower[0] / reference)
        ours.append(f"{letter} from {start:.4g}, {width[-1]:.3g} wide at {zone.kappa[-1]:g} N/m")
        checks += [
            near(f"zone {letter} at {zone.kappa[0]:g} N/m starts at", start, starts[name], 0.02),
            Check(
                text=f"zone {letter} widens at every step of the stiffness",
                met=bool(np.all(np.diff(width) > 0)),
            ),
        ]
    return Finding(ours="; ".join(ours) or "no zone", checks=tuple(checks))


@evaluates(11)
def example_point_is_unstable(evidence: Evidence) -> Finding:
    growth = _example_growth(evidence)
    unstable = bool(is_unstable(growth, EXAMPLE["speed"] * evidence.system.reference))
    return Finding(
        ours=f"growth rate {growth:.4g} 1/s",
        checks=(equal("point", "unstable" if unstable else "stable", "unstable"),),
    )


@evaluates(12)
def three_kinds_of_modes(evidence: Evidence) -> Finding:
    real, limit = _example_spectrum(evidence).real, UNSTABLE_GROWTH * _example_speed(evidence)
    counts = {
        "divergent": int(np.count_nonzero(real > limit)),
        "damped": int(np.count_nonzero(real < -limit)),
        "oscillatory": int(np.count_nonzero(np.abs(real) <= limit)),
    }
    return Finding(
        ours=", ".join(f"{count} {kind}" for kind, count in counts.items()),
        checks=tuple(at_least(f"{kind} eigenvalues", n, 1) for kind, n in counts.items()),
    )


@evaluates(13)
def coupling_shifts_upward(evidence: Evidence) -> Finding:
    zone, reference = _zones(evidence)["1F"], evidence.system.reference
    if len(zone.kappa) < 2:
        return Finding(ours="no zone", checks=(Check(text="zone A is missing", met=False),))
    lower = zone.lower / reference
    return Finding(
        ours=f"from {lower[0]:.4g} at {zone.kappa[0]:g} to {lower[-1]:.4g} at"
        f" {zone.kappa[-1]:g} N/m",
        checks=(
            Check(
                text="first unstable speed rises at every step of the stiffness",
                met=bool(np.all(np.diff(lower) > 0)),
            ),
        ),
    )


@evaluates(14)
def no_instability_beside_the_zones(evidence: Evidence) -> Finding:
    """Judge that only waves of opposite direction become unstable.

    Where backward waves on both bodies coincide in static axes, Ω = (ω_r - ω_c) / k, that is
    looked at closely.
    """
    system, zones = evidence.system, _zones(evidence)
    speeds = np.linspace(*RANGE, 600) * system.reference
    unstable = is_unstable(system.growth(speeds, KAPPAS), speeds)
    inside = np.zeros(unstable.shape, dtype=bool)
    for zone in zones.values():
        for kappa, lower, upper in zip(zone.kappa, zone.lower, zone.upper, strict=True):
            row = int(np.argmin(np.abs(KAPPAS - kappa)))
            inside[row] |= (speeds >= lower) & (speeds <= upper)
    outside = int(np.count_nonzero(unstable & ~inside))
    modes = system.modes
    casing = float(modes.frequency[modes.on_casing].min())
    alike = (modes.frequency - casing)[~modes.on_casing] / modes.nodal_diameter[~modes.on_casing]
    around = np.concatenate([BESIDE * system.reference + speed for speed in alike])
    close = is_unstable(system.growth(around, KAPPAS), around)
    listed = " and ".join(f"{speed / system.reference:.3g}" for speed in alike)
    return Finding(
        ours=f"{outside} of {unstable.size} points unstable outside zones A and B,"
        f" {np.count_nonzero(close)} of {close.size} around {listed}, where"
        " backward waves coincide",
        checks=(
            at_most("unstable points outside the zones", outside, 0),
            at_most("where backward waves coincide", int(np.count_nonzero(close)), 0),
        ),
    )


@evaluates(15)
def divergent_mode(evidence: Evidence) -> Finding:
    system = evidence.system
    if not is_unstable(_example_growth(evidence), _example_speed(evidence)):
        return Finding(ours="–", obstacle="the paper's example point is stable")
    motion = divergent_motion(system, _example_speed(evidence), EXAMPLE["kappa"])
    lead = abs(float(np.degrees(motion.shaft_lead[-1])))
    directions = {
        "wave on the bladed disk": (motion.rotor_wave_speed, "backward"),
        "wave on the casing": (motion.casing_wave_speed, "forward"),
        "whirl in rotating axes": (motion.whirl_speed, "backward"),
        "whirl in static axes": (motion.whirl_speed_static, "forward"),
    }
    ways = {name: "forward" if rate > 0 else "backward" for name, (rate, _) in directions.items()}
    return Finding(
        ours=", ".join(f"{name} {way}" for name, way in ways.items()) + f", {lead:.2g}° apart",
        checks=(
            *(equal(name, ways[name], expected) for name, (_, expected) in directions.items()),
            between("shaft and smallest clearance apart by", lead, 0.0, 20.0, "°"),
        ),
    )


def _example_speed(evidence: Evidence) -> float:
    return EXAMPLE["speed"] * evidence.system.reference


def _example_spectrum(evidence: Evidence) -> np.ndarray:
    system = evidence.system
    return eigenvalues(
        system.modes, speed=_example_speed(evidence), kappa=EXAMPLE["kappa"], with_pi=system.with_pi
    )


def _example_growth(evidence: Evidence) -> float:
    system = evidence.system
    return float(
        growth_rate(
            system.modes,
            speed=_example_speed(evidence),
            kappa=EXAMPLE["kappa"],
            with_pi=system.with_pi,
        )
    )
