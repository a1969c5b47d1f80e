"""Impacts and rubs with exact answers: bars, an oscillator on a stop, a Coulomb pad.

All go through the march of stages: one tip, a rigid wall or a second bar as the casing.
"""

from __future__ import annotations

from functools import cache
from typing import Any, NamedTuple

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.stage.contact_problem import ContactProblem, Load
from bladewhirl.solvers.march.march import Chunk
from bladewhirl.studies.verification.bodies import (
    Bar,
    ledger_residual,
    marched,
    problem,
    small_rotor,
    wall,
)
from bladewhirl.studies.verification.case import Pair, verifies
from bladewhirl.studies.verification.references import reference

ELEMENTS = 100
BARS = (*reference("contact")["bars"], *reference("published")["bars"])


class Collision(NamedTuple):
    """Two bars, or one and a rigid wall, that have met."""

    known: dict[str, Any]
    chunk: Chunk  #: a record a step
    dt: float  #: [s]
    velocity: FloatArray  #: of the centre of mass of each bar at the end [m/s], (bars,)


class Approach(NamedTuple):
    """Two bars, or one and a rigid wall, that will meet."""

    known: dict[str, Any]
    bars: list[Bar]
    given: ContactProblem
    dt: float  #: [s]
    steps: int  #: to well after the contact


def bars_in_impact(name: str, elements: int = ELEMENTS) -> Approach:
    """Return two bars before their contact."""
    contact = reference("contact")
    known = (contact["bars"] | reference("published")["bars"])[name]
    bar = known.get("bar", contact["bar"])
    shape = {key: bar[key] for key in ("length", "young_modulus", "density")}
    areas = [area for area in known["area"] if area is not None]
    bars = [Bar(area=area, elements=elements, **shape) for area in areas]
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
def collision(name: str) -> Collision:
    """March two bars from before their contact to well after it."""
    known, bars, given, dt, steps = bars_in_impact(name)
    chunk = marched(given, dt, steps)
    last = (chunk.rotor_velocity[-1], chunk.casing_velocity[-1])
    computed = [body.rigid @ v / body.mass for body, v in zip(bars, last, strict=False)]
    return Collision(known, chunk, dt, np.array(computed))


@verifies(*BARS)
def impulse_of_bars(name: str) -> Pair:
    """Compare the impulse of the whole contact."""
    met = collision(name)
    return met.known["impulse"], met.chunk.contact_impulse.sum()


@verifies(*BARS)
def beginning_for_bars(name: str) -> Pair:
    """Compare the first step with contact."""
    met = collision(name)
    first = met.chunk.time[np.argmax(met.chunk.contact_impulse[:, 0] > 0.0)]
    return met.known["start"] / met.dt, first / met.dt


@verifies(*BARS)
def duration_of_bars(name: str) -> Pair:
    """Compare the duration from the first step with contact to the last."""
    met = collision(name)
    touching = met.chunk.time[met.chunk.contact_impulse[:, 0] > 0.0]
    return met.known["duration"], touching[-1] - touching[0]


@verifies(*BARS)
def force_of_bars(name: str) -> Pair:
    """Compare the mean force over the middle of the contact; peaks depend on the step."""
    met = collision(name)
    known, chunk = met.known, met.chunk
    since_middle = np.abs(chunk.time - known["start"] - 0.5 * known["duration"])
    force = chunk.contact_impulse[since_middle < 0.3 * known["duration"], 0].mean() / met.dt
    return known["force"], force


@verifies(*BARS)
def velocity_of_bars(name: str) -> Pair:
    """Compare the change of the velocities of the centres of mass."""
    met = collision(name)
    before, after = (
        np.array([v for v in met.known[key] if v is not None])
        for key in ("velocity", "velocity_after")
    )
    return after - before, met.velocity - before


@cache
def bouncing_bar() -> Chunk:
    """March a bar dropped on a rigid wall, which touches it twice."""
    known = reference("published")["bouncing_bar"]
    shape = {key: known[key] for key in ("length", "young_modulus", "density")}
    bar = Bar(area=1.0, elements=2 * ELEMENTS, **shape)
    gravity = Load(rotor=known["gravity"] * bar.rigid, casing=np.zeros(1))
    given = problem(bar.as_rotor(), wall(known["height"]), loads=(gravity,))
    return marched(given, bar.time_step, round(5.0 / bar.time_step))


@verifies()
def impulse_of_a_bouncing_bar() -> Pair:
    """Compare the impulses of both contacts; the bar vibrates between them."""
    chunk = bouncing_bar()
    impulse, first = chunk.contact_impulse[:, 0], chunk.time < 8.0 / 3.0
    expected = reference("published")["bouncing_bar"]["impulse"]
    return [expected, expected], [impulse[first].sum(), impulse[~first].sum()]


def first_touch() -> FloatArray:
    """Return the times of the steps in the first contact of a bouncing bar [s]."""
    chunk = bouncing_bar()
    return chunk.time[(chunk.contact_impulse[:, 0] > 0.0) & (chunk.time < 2.0)]


@verifies()
def beginning_of_a_bounce() -> Pair:
    """Compare the beginning with the time of free fall."""
    first, _ = reference("published")["bouncing_bar"]["first_contact"]
    dt = bouncing_bar().time[1]
    return first / dt, first_touch()[0] / dt


@verifies()
def end_of_a_bounce() -> Pair:
    """Compare the end of the first contact; the tolerance is 1 % of its duration."""
    return reference("published")["bouncing_bar"]["first_contact"][1], first_touch()[-1]


def bounce(*, first: bool) -> float:
    """Return the centroid in time of an impulse [s]."""
    chunk = bouncing_bar()
    part = (chunk.time < 8.0 / 3.0) == first
    return float(np.average(chunk.time[part], weights=chunk.contact_impulse[part, 0]))


@verifies()
def first_bounce() -> Pair:
    """Compare the centroid of the first contact, in which the force rises linearly."""
    return 49.0 / 36.0, bounce(first=True)


@verifies()
def second_bounce() -> Pair:
    """Compare the centroid of the second contact, the mirror image of the first."""
    return 143.0 / 36.0, bounce(first=False)


@cache
def oscillator(name: str) -> tuple[dict[str, Any], Chunk]:
    """March a driven mass on a spring against a stop without restitution for 1.2 s."""
    known = reference("contact")["oscillator"]
    case, dt = known[name], 2e-5
    rotor = small_rotor(np.sqrt([known["stiffness"]]), tip_radial=np.ones((1, 1)))
    start = {"rotor": np.array([case.get("start", 0.0)])}
    force = np.array([case.get("force", 0.0)])
    load = Load(rotor=force, casing=np.zeros(1), frequency=case.get("frequency", 0.0))
    given = problem(rotor, wall(case["gap"]), start=start, loads=(load,))
    return case, marched(given, dt, round(1.2 / dt))


def impacts(name: str) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return the exact times and impulses of the impacts of an oscillator, then the computed ones.

    A mass left at rest on the stop touches it again with impulses of rounding: no contact.
    """
    case, chunk = oscillator(name)
    exact = [e for e in case["events"] if e["event"] == "impact" and e["time"] < 1.2]
    impulse = chunk.contact_impulse[:, 0]
    touching = np.r_[False, impulse > 1e-12 * impulse.max()]
    begins = np.flatnonzero(touching[1:] & ~touching[:-1])
    stopped = np.array([impulse[i : i + 2].sum() for i in begins])  # within two steps
    times, expected = (np.array([event[key] for event in exact]) for key in ("time", "impulse"))
    return times, expected, chunk.time[begins], stopped


OSCILLATORS = ("C1", "C2", "C3", "C4")


@verifies(*OSCILLATORS)
def times_of_impacts(name: str) -> Pair:
    """Compare the times of the impacts; the tolerance is two steps."""
    exact, _, computed, _ = impacts(name)
    return exact, computed


@verifies(*OSCILLATORS)
def impulses_of_impacts(name: str) -> Pair:
    """Compare the impulses: the stop absorbs all the momentum."""
    _, exact, _, computed = impacts(name)
    return exact, computed


@verifies()
def energy_of_an_impact() -> Pair:
    """Compare the energy lost at impacts with the work of the contact forces."""
    case, chunk = oscillator("C1")
    return -case["energy_lost"], chunk.normal_work[-1]


@verifies("C2", "C3")
def times_of_releases(name: str) -> Pair:
    """Compare the times of release from lasting contacts."""
    case, chunk = oscillator(name)
    exact = [e["time"] for e in case["events"] if e["event"] == "release" and e["time"] < 1.2]
    touching = np.flatnonzero(chunk.contact_impulse[:, 0] > 1e-12 * chunk.contact_impulse.max())
    contacts = np.split(touching, np.flatnonzero(np.diff(touching) > 1) + 1)
    ends = [steps[-1] + 1 for steps in contacts if len(steps) > 10]
    return exact, chunk.time[[end for end in ends if end < chunk.records]]


@verifies()
def resting_force() -> Pair:
    """Compare the contact force at rest, the load less the spring force."""
    case, chunk = oscillator("C1")
    return case["resting_force"], chunk.contact_impulse[-1, 0] / chunk.time[1]


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
def coulomb_pad() -> tuple[Chunk, float]:
    """March the pad; return the records and the time step."""
    return marched(pad_on_a_wall(), 1e-5, 20_000), 1e-5


@verifies()
def extremes_of_a_pad() -> Pair:
    """Compare the extremes: each half cycle loses 2 mu m g / k."""
    chunk, dt = coulomb_pad()
    at = [round(n * np.pi / 100.0 / dt) for n in range(5)]
    return reference("published")["coulomb_pad"]["extremes"], chunk.rotor_displacement[at, 1]


@verifies()
def pad_that_sticks() -> Pair:
    """Compare the final position with all positions after the second period."""
    chunk, dt = coulomb_pad()
    known = reference("published")["coulomb_pad"]
    stuck = chunk.rotor_displacement[chunk.time > known["stuck_from"] + dt, 1]
    return np.full_like(stuck, known["extremes"][-1]), stuck


@verifies()
def work_on_a_pad() -> Pair:
    """Compare the work of friction: 1 N over 3.6 mm of sliding."""
    return reference("published")["coulomb_pad"]["friction_work"], coulomb_pad()[0].friction_work[
        -1
    ]


@verifies()
def force_on_a_pad() -> Pair:
    """Compare the normal force with the weight, without the first and last step."""
    chunk, dt = coulomb_pad()
    force = chunk.contact_impulse[2:-1] / dt
    return np.full_like(force, 10.0), force


def small_marches() -> list[Chunk]:
    """March all bars, oscillators and the pad."""
    bars = [collision(name).chunk for name in BARS]
    return [*bars, *(oscillator(name)[1] for name in OSCILLATORS), coulomb_pad()[0]]


@verifies()
def ledgers() -> Pair:
    """Compare the energy residual of each march with zero, at its worst step."""
    computed = [ledger_residual(chunk) for chunk in small_marches()]
    return np.zeros(len(computed)), computed


@verifies()
def gaps_in_contact() -> Pair:
    """Compare gaps of closed contacts and penetrations with zero, the largest of each march."""
    computed = [
        value
        for chunk in small_marches()
        for value in (chunk.gap[chunk.contact_impulse > 0.0].max(), min(0.0, chunk.gap.min()))
    ]
    return np.zeros(len(computed)), computed


@verifies()
def unbalance_orbit() -> Pair:
    """Compare the orbit through the resonance, started on the exact orbit under harmonic loads."""
    known = reference("jeffcott")
    computed = [_departure(known["rotor"], row) for row in known["response"]]
    return np.zeros(len(computed)), computed


def _departure(rotor: dict[str, float], row: dict[str, float]) -> float:
    """Return the largest deviation over 0.1 s relative to the radius."""
    root = np.sqrt(rotor["mass"])
    body = small_rotor(
        np.full(2, np.sqrt(rotor["stiffness"]) / root),
        damping_ratio=np.full(2, rotor["damping_ratio"]),
        centre=np.eye(2) / root,
    )
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
    chunk = marched(problem(body, wall(1.0), start=start, loads=loads), 5e-6, 20_000, every=10)
    computed = chunk.rotor_displacement @ body.centre.T @ [1.0, 1.0j]
    off = np.abs(computed - orbit * np.exp(1j * omega * chunk.time)).max()
    return float(off / row["amplitude"])
