"""Impact and rubbing problems with exact solutions: bars, an oscillator on a stop, a Coulomb pad.

The time integration of stages solves all problems, with one tip as the rotor, and a rigid wall or a
second bar as the casing.
"""

from dataclasses import replace
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.modal_loads import Load
from bladewhirl.solvers.march.march import Chunk
from bladewhirl.studies.verification.bodies import (
    Bar,
    ledger_residual,
    marched,
    point_mass,
    problem,
    small_rotor,
    wall,
)
from bladewhirl.studies.verification.case import Pair, Pairs, reference, verifies

ELEMENTS = 100
BARS = (*reference("contact")["bars"], *reference("published")["bars"])


class Approach(NamedTuple):
    """Two bars, or a bar and a rigid wall, that approach each other."""

    known: dict[str, Any]
    bars: list[Bar]
    given: ContactProblem
    dt: float  #: time step [s]
    steps: int  #: number of steps until well after the contact


def bars_in_impact(name: str) -> Approach:
    """Return two bars, or a bar and a wall, before their contact."""
    contact = reference("contact")
    known = (contact["bars"] | reference("published")["bars"])[name]
    bar = known.get("bar", contact["bar"])
    shape = {key: bar[key] for key in ("length", "young_modulus", "density")}
    areas = [area for area in known["area"] if area is not None]
    bars = [Bar(area=area, elements=ELEMENTS, **shape) for area in areas]
    speeds = [
        body.rigid * velocity for body, velocity in zip(bars, known["velocity"], strict=False)
    ]
    rotor = bars[0].as_rotor()
    casing = bars[1].as_casing(bar["gap"]) if len(bars) > 1 else wall(bar["gap"])
    start = dict(zip(("rotor_velocity", "casing_velocity"), speeds, strict=False))
    dt = bars[0].time_step
    steps = round((known["start"] + 2.0 * known["duration"]) / dt)
    return Approach(known, bars, problem(rotor, casing, start=start), dt, steps)


@cache
def march_of_bars(name: str) -> Chunk:
    """March two bars from before their contact to well after it, with a record at every step."""
    bars = bars_in_impact(name)
    return marched(bars.given, bars.dt, bars.steps)


@verifies(*BARS)
def bars_that_meet(name: str) -> Pairs:
    """Compare the impact of bars with exact solutions; the force is a mean in the middle of the
    contact, because peaks depend on the time step."""
    known, bars, _, dt, _ = bars_in_impact(name)
    chunk = march_of_bars(name)
    touching = chunk.time[chunk.contact_impulse[:, 0] > 0.0]
    since_middle = np.abs(chunk.time - known["start"] - 0.5 * known["duration"])
    middle = chunk.contact_impulse[since_middle < 0.3 * known["duration"], 0]
    before, after = (
        np.array([v for v in known[key] if v is not None]) for key in ("velocity", "velocity_after")
    )
    last = (chunk.rotor_velocity[-1], chunk.casing_velocity[-1])
    computed = [body.rigid @ v / body.mass for body, v in zip(bars, last, strict=False)]
    return {
        "impulse_of_bars": (known["impulse"], chunk.contact_impulse.sum()),
        "beginning_for_bars": (known["start"] / dt, touching[0] / dt),
        "duration_of_bars": (known["duration"], touching[-1] - touching[0]),
        "force_of_bars": (known["force"], middle.mean() / dt),
        "velocity_of_bars": (after - before, np.array(computed) - before),
    }


@verifies()
def bouncing_bar() -> Pairs:
    """Compare a bar that falls on a rigid wall and bounces with a published solution.

    The first contact begins after the time of free fall; the end of this contact has a tolerance of
    1 % of the duration of the contact. The force rises linearly in the first contact, and falls
    linearly in the second.
    """
    known = reference("published")["bouncing_bar"]
    shape = {key: known[key] for key in ("length", "young_modulus", "density")}
    bar = Bar(area=1.0, elements=2 * ELEMENTS, **shape)
    gravity = Load(rotor=known["gravity"] * bar.rigid, casing=np.zeros(1))
    given = problem(bar.as_rotor(), wall(known["height"]), loads=(gravity,))
    chunk = marched(given, bar.time_step, round(5.0 / bar.time_step))
    impulse, dt = chunk.contact_impulse[:, 0], chunk.time[1]
    touching = chunk.time[(impulse > 0.0) & (chunk.time < 2.0)]
    first = chunk.time < 8.0 / 3.0
    begin, end = known["first_contact"]
    centroids = [
        float(np.average(chunk.time[part], weights=impulse[part])) for part in (first, ~first)
    ]
    return {
        "impulse_of_a_bouncing_bar": (
            [known["impulse"], known["impulse"]],
            [impulse[first].sum(), impulse[~first].sum()],
        ),
        "beginning_of_a_bounce": (begin / dt, touching[0] / dt),
        "end_of_a_bounce": (end, touching[-1]),
        "first_bounce": (49.0 / 36.0, centroids[0]),
        "second_bounce": (143.0 / 36.0, centroids[1]),
    }


@cache
def oscillator(name: str) -> tuple[dict[str, Any], Chunk]:
    """March a driven mass on a spring against a stop without restitution for 1.2 s."""
    known = reference("contact")["oscillator"]
    case, dt = known[name], 2e-5
    rotor = point_mass(1.0, np.sqrt(known["stiffness"]))
    start = {"rotor": np.array([case.get("start", 0.0)])}
    force = np.array([case.get("force", 0.0)])
    load = Load(rotor=force, casing=np.zeros(1), frequency=case.get("frequency", 0.0))
    given = problem(rotor, wall(case["gap"]), start=start, loads=(load,))
    return case, marched(given, dt, round(1.2 / dt))


OSCILLATORS = ("C1", "C2", "C3", "C4")


@verifies(*OSCILLATORS)
def impacts_of_an_oscillator(name: str) -> Pairs:
    """Compare times and impulses of the impacts of a mass on a stop with closed-form solutions.

    Tiny impulses due to rounding, when the mass is at rest on the stop, do not count as contact.
    """
    case, chunk = oscillator(name)
    exact = [e for e in case["events"] if e["event"] == "impact" and e["time"] < 1.2]
    impulse = chunk.contact_impulse[:, 0]
    touching = np.r_[False, impulse > 1e-12 * impulse.max()]
    begins = np.flatnonzero(touching[1:] & ~touching[:-1])
    stopped = np.array([impulse[i : i + 2].sum() for i in begins])  # impulse of two steps
    return {
        "times_of_impacts": ([event["time"] for event in exact], chunk.time[begins]),
        "impulses_of_impacts": ([event["impulse"] for event in exact], stopped),
    }


@verifies()
def oscillator_at_rest() -> Pairs:
    """Compare the work of contact with the exact energy loss. The contact force at rest equals the
    load minus the spring force."""
    case, chunk = oscillator("C1")
    return {
        "energy_of_an_impact": (-case["energy_lost"], chunk.normal_work[-1]),
        "resting_force": (case["resting_force"], chunk.contact_impulse[-1, 0] / chunk.time[1]),
    }


@verifies("C2", "C3")
def times_of_releases(name: str) -> Pair:
    """Compare times of release from lasting contacts with closed-form solutions."""
    case, chunk = oscillator(name)
    exact = [e["time"] for e in case["events"] if e["event"] == "release" and e["time"] < 1.2]
    touching = np.flatnonzero(chunk.contact_impulse[:, 0] > 1e-12 * chunk.contact_impulse.max())
    contacts = np.split(touching, np.flatnonzero(np.diff(touching) > 1) + 1)
    ends = [steps[-1] + 1 for steps in contacts if len(steps) > 10]
    return exact, chunk.time[[end for end in ends if end < chunk.records]]


def pad_on_a_wall() -> ContactProblem:
    """Return a pad with friction: m = 1 kg on k = 1e4 N/m, mu m g = 1 N, released at 0.85 mm."""
    rotor = small_rotor(
        np.array([50.0, 100.0]),
        tip_radial=np.array([[1.0, 0.0]]),
        tip_tangential=np.array([[0.0, 1.0]]),
    )
    clearance = 1e-3
    weight = Load(rotor=np.array([10.0 + 50.0**2 * clearance, 0.0]), casing=np.zeros(1))
    start = {"rotor": np.array([clearance, 0.85e-3])}
    return problem(
        rotor, wall(clearance), start=start, loads=(weight,), friction=0.1, sliding="signed"
    )


@cache
def march_of_a_pad() -> Chunk:
    """March the pad for 0.2 s, in which it comes to rest, with steps of 1e-5 s."""
    return marched(pad_on_a_wall(), 1e-5, 20_000)


@verifies()
def coulomb_pad() -> Pairs:
    """Compare a sliding pad with Code_Aster SDND100.

    The amplitude decreases by 2 mu m g / k in each half cycle, until the pad sticks after the
    second period. The normal force is the weight, except in the first and last step.
    """
    chunk, dt, known = march_of_a_pad(), 1e-5, reference("published")["coulomb_pad"]
    at = [round(n * np.pi / 100.0 / dt) for n in range(5)]
    stuck = chunk.rotor_displacement[chunk.time > known["stuck_from"] + dt, 1]
    force = chunk.contact_impulse[2:-1] / dt
    return {
        "extremes_of_a_pad": (known["extremes"], chunk.rotor_displacement[at, 1]),
        "pad_that_sticks": (np.full_like(stuck, known["extremes"][-1]), stuck),
        "work_on_a_pad": (known["friction_work"], chunk.friction_work[-1]),
        "force_on_a_pad": (np.full_like(force, 10.0), force),
    }


@verifies()
def pad_that_sticks() -> Pairs:
    """Compare the pad with Code_Aster SDND100 if friction opposes the slip velocity at the end of
    each step: time after which it sticks, and extreme positions.

    The friction force at rest is k x, which is half of mu m g.
    """
    base, known = pad_on_a_wall(), reference("published")["coulomb_pad"]
    given = replace(base, sliding="full")
    chunk = marched(given, 1e-5, 20_000)
    moving = chunk.time[np.abs(chunk.rotor_velocity[:, 1]) > 1e-12]
    at = [round(n * np.pi / 100.0 / 1e-5) for n in range(4)]
    extremes = [*chunk.rotor_displacement[at, 1], chunk.rotor_displacement[-1, 1]]
    force = chunk.friction_impulse[-1, 0] / (0.1 * chunk.contact_impulse[-1, 0])
    return {
        "time_of_sticking": (known["stuck_from"], moving[-1]),
        "extremes_with_sticking": (known["extremes"], extremes),
        "force_of_sticking": (-0.5, force),
    }


@verifies()
def energies_and_gaps() -> Pairs:
    """Compare with zero the largest energy residual of each march, the largest gap of a closed
    contact, and the largest penetration."""
    chunks = [march_of_bars(name) for name in BARS]
    chunks += [*(oscillator(name)[1] for name in OSCILLATORS), march_of_a_pad()]
    gaps = [
        (chunk.gap[chunk.contact_impulse > 0.0].max(), min(0.0, chunk.gap.min()))
        for chunk in chunks
    ]
    residuals = [ledger_residual(chunk) for chunk in chunks]
    return {
        "ledgers": (np.zeros(len(chunks)), residuals),
        "gaps_in_contact": (np.zeros(2 * len(chunks)), np.ravel(gaps)),
    }


@verifies()
def unbalance_orbit() -> Pair:
    """Compare orbits under unbalance with the exact orbits, on which they start, at speeds below
    and above the resonance: largest deviation in 0.1 s, divided by the radius."""
    rotor, rows = reference("jeffcott")["rotor"], reference("jeffcott")["response"]
    root, off = np.sqrt(rotor["mass"]), []
    body = small_rotor(
        np.full(2, np.sqrt(rotor["stiffness"]) / root),
        damping_ratio=np.full(2, rotor["damping_ratio"]),
        centre=np.eye(2) / root,
    )
    for row in rows:
        omega = 2.0 * np.pi * row["frequency_hz"]
        size = rotor["unbalance"] * omega**2 / root
        loads = tuple(
            Load(rotor=size * np.eye(2)[axis], casing=np.zeros(1), frequency=omega, phase=phase)
            for axis, phase in ((0, 0.0), (1, -np.pi / 2.0))
        )
        orbit = row["amplitude"] * np.exp(-1j * row["phase_lag"])
        start = {
            "rotor": root * np.array([orbit.real, orbit.imag]),
            "rotor_velocity": root * omega * np.array([-orbit.imag, orbit.real]),
        }
        given = problem(body, wall(1.0), start=start, loads=loads)
        chunk = marched(given, 5e-6, 20_000, every=10)
        computed = chunk.rotor_displacement @ body.centre.T @ [1.0, 1.0j]
        exact = orbit * np.exp(1j * omega * chunk.time)
        off.append(np.abs(computed - exact).max() / row["amplitude"])
    return np.zeros(len(rows)), off
