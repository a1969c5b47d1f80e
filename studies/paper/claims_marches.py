"""Measures of claims on marches: convergence (claims 16, 17), distortion, imbalance (20 to 46)."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from bladewhirl.models.case.file import loads
from bladewhirl.postprocess.run.measures import Motion, motion_distance
from bladewhirl.studies.paper.claim import Measures, measures
from bladewhirl.studies.paper.trials import NotTestableError

MILLI, MICRO = 1e3, 1e6

EARLY = 0.5  #: end of the transient in the paper [s]

STEADY_FROM = 1.1  #: time after which the paper's orbit is steady [s]


def descending(values: Mapping[str, float]) -> list[str]:
    """Return the names of values, the largest first."""
    return sorted(values, key=lambda name: -values[name])


def late_leaders(motion: Motion) -> tuple[list[str], dict[str, float]]:
    """Return groups of modes sorted by strain energy late in the march, the largest first, and
    these energies [J]."""
    energy = motion.energy(*motion.late)
    return descending({name: value for name, value in energy.items() if name != "total"}), energy


def _percent(motion: Motion, start: float, end: float) -> dict[str, float]:
    return {name: 100 * value for name, value in motion.share(start, end).items()}


@measures(16)
def time_steps(coarse: Motion, chosen: Motion, fine: Motion) -> Measures:
    """Return relative differences of orbits and impulses from the march with the finest step."""
    impulses = [float(m.result["contact_impulse"].sum()) for m in (chosen, fine)]
    if not impulses[1]:
        raise NotTestableError("no contact with the finest time step")
    distance, before = motion_distance(chosen, fine), motion_distance(coarse, fine)
    change = abs(impulses[0] / impulses[1] - 1.0)
    return {
        "distance": distance,
        "distance_percent": 100 * distance,
        "change": change,
        "change_percent": 100 * change,
        "ratio": distance / (before or 1.0),
    }


@measures(17)
def numbers_of_modes(*motions: Motion) -> Measures:
    """Return regimes, and distances of the orbits from the orbit with the most modes."""
    regimes = sorted({motion.regime.name for motion in motions})
    apart = [motion_distance(motion, motions[-1]) for motion in motions[:-1]]
    return {
        "kinds": len(regimes),
        "regimes": ", ".join(regimes),
        "distance": apart[-1],
        "distances": ", ".join(f"{100 * distance:.2g}" for distance in apart),
    }


@measures(20, 21, 22, 42)
def divergence_under_distortion(motion: Motion) -> Measures:
    """Return regime, end, whirl and energy shares [%] of a march."""
    planned = loads(motion.result.attrs["case"]).march.duration
    whirl = motion.late_whirl("rotating")
    share = _percent(motion, *motion.late)
    return {
        "regime": motion.regime.name,
        "end": motion.end,
        "completed": motion.end / planned,
        "radius": MILLI * float(motion.radius[-1]),
        "whirl": whirl.text,
        "direction": whirl.direction,
        "rate": abs(motion.late_whirl("static").rate) / motion.reference,
        "leader": descending(share)[0],
        **share,
    }


@measures(23, 24)
def course_of_energy(motion: Motion) -> Measures:
    """Return the onset of fast growth [s], and the energy shares of the suspension during and after
    the transient [%].

    At the onset the energy is ten times the energy at the end of the transient.
    """
    if motion.end <= 2 * EARLY:
        raise NotTestableError(f"the march ended after {motion.end:.3g} s, in the transient")
    onset = motion.onset(10.0, EARLY)
    early = _percent(motion, 0.0, EARLY)["suspension"]
    late = _percent(motion, EARLY, motion.end)["suspension"]
    return {
        "regime": motion.regime.name,
        "onset": onset,
        "when": f"from {onset:.3g} s" if np.isfinite(onset) else "never",
        "early": early,
        "late": late,
        "ratio": late / (early or 1.0),
    }


@measures(25, 32, 33)
def contact_side(motion: Motion) -> Measures:
    """Return whirl, scenario, phase shift [°] and numbers of blades by contact class."""
    return {
        "regime": motion.regime.name,
        "touches": motion.blades["free"] < motion.result.sizes["contact_node"],
        "direction": motion.late_whirl("static").direction,
        "scenario": motion.scenario,
        "lead": motion.lead,
        "shift": abs(motion.lead),
        **motion.blades,
    }


@measures(26)
def whirl_in_time(motion: Motion) -> Measures:
    """Return the whirl frequency in both halves of the last third of a march [Hz]."""
    rates = np.abs(motion.late_whirl_rates)
    if not motion.diverges or len(rates) < 4:
        raise NotTestableError(f"{motion.regime.name} after {motion.end:.3g} s: too little growth")
    half = len(rates) // 2
    before, after = (float(part.mean() / 2 / np.pi) for part in (rates[:half], rates[-half:]))
    return {"before": before, "after": after, "ratio": after / before}


@measures(28)
def clamped_centre(first: Motion, second: Motion) -> Measures:
    """Return the regimes of two marches with a clamped centre."""
    return {"first": first.regime.name, "second": second.regime.name}


@measures(30)
def limit_cycle(motion: Motion) -> Measures:
    """Return mean and range of the orbit's radius late in a march [mm], and its steadiness."""
    mean, size = motion.radius_between(*motion.late)
    growth = motion.regime.ripple
    values: dict[str, Any] = {
        "regime": motion.regime.name,
        "radius": MILLI * mean,
        "ripple": MILLI * size,
        "growing": "" if growth is None else f", growing by {growth.text} 1/s",
        "scatter": motion.section_scatter(),
    }
    if growth is not None:
        values["growth"] = growth.rate
    if motion.end > STEADY_FROM:
        middle = 0.5 * (STEADY_FROM + motion.end)
        before = motion.ripple_between(STEADY_FROM, middle)
        values["decay"] = before / motion.ripple_between(middle, motion.end)
    return values


@measures(31)
def energies_of_both_loads(motion: Motion, other: Motion) -> Measures:
    """Return the two groups of modes with the most energy, their energies [J], and the total energy
    under the other load relative to the total energy under this load."""
    (leader, second, *_), energy = late_leaders(motion)
    return {
        "leader": leader,
        "energy": energy[leader],
        "second": second,
        "second_energy": energy[second],
        "ratio": other.energy(*other.late)["total"] / energy["total"],
    }


@measures(35)
def truncated_space(six: Motion, full: Motion) -> Measures:
    """Return the two groups of modes with the most energy in a march of six modes, and the largest
    radii with six modes and with all modes [mm]."""
    (leader, second, *_), _energy = late_leaders(six)
    until = min(six.end, full.end)
    peak, full_peak = (float(m.radius[: m.record_at(until)].max()) for m in (six, full))
    return {
        "regime": six.regime.name,
        "leader": leader,
        "second": second,
        "until": until,
        "radius": MILLI * peak,
        "full_radius": MILLI * full_peak,
        "ratio": peak / full_peak,
    }


@measures(37)
def radii_over_coupling(*motions: Motion) -> Measures:
    """Return regimes, radius and ripple of the first march [mm], and the spread of radii [%]."""
    radii, ripples = np.transpose([motion.radius_between(*motion.late) for motion in motions])
    return {
        "regimes": ", ".join(sorted({motion.regime.name for motion in motions})),
        "radius": MILLI * radii[0],
        "ripple": MILLI * ripples[0],
        "spread": 100 * float(np.ptp(radii) / radii.mean()),
    }


@measures(39, 43, 44)
def small_motions(motion: Motion) -> Measures:
    """Return the motion of the shaft [mm] and of the casing [µm], and the energy share of higher
    modes in the transient [%]."""
    return {
        "radius": MILLI * float(motion.radius.max()),
        "touched": motion.touched,
        "contact": "contact" if motion.touched else "no contact",
        "rest": _percent(motion, 0.0, min(EARLY, motion.end))["rest"],
        "motion": MICRO * motion.casing_motion,
    }


@measures(45)
def course_at_high_speed(motion: Motion, long: Motion, usual: Motion) -> Measures:
    """Return the group of modes with the most energy before 0.2 s, the energy share of nodal
    diameters above 1 [%], and the end of a longer march."""
    return {
        "leader": descending(motion.share(0.0, 0.2))[0],
        "other k": _percent(motion, 0.0, motion.end)["other k"],
        "end": long.end,
        "regime": long.regime.name,
        "ratio": long.energy(*long.late)["total"] / usual.energy(*usual.late)["total"],
    }


@measures(46)
def motion_over_coupling(*motions: Motion) -> Measures:
    """Return the range of whirl frequencies (in multiples of ω₁), the largest change of an energy
    share [percentage points], and the contact scenarios."""
    if not all(motion.touched for motion in motions):
        raise NotTestableError("without contact there is no side of contact")
    rates = [motion.late_whirl("rotating").rate / motion.reference for motion in motions]
    shares = np.array([list(motion.share(*motion.late).values()) for motion in motions])
    sides = [motion.scenario for motion in motions]
    return {
        "rates": ", ".join(f"{rate:.3g}" for rate in rates),
        "spread": float(np.ptp(rates)),
        "moved": 100 * float(np.abs(shares - shares[0]).max()),
        "sides": len(set(sides)),
        "scenarios": ", ".join(sides),
    }
