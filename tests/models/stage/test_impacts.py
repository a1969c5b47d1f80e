"""Impacts and rubs with exact answers: bars, an oscillator on a stop, a Coulomb pad.

All go through the kernel that marches stages: one tip, a rigid wall or a second bar as casing.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from contact_cases import Bar, ledger_residual, problem, run, small_rotor, wall
from stages import oracle

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.stage.contact_problem import ContactProblem, Load
from bladewhirl.solvers.march.march import Chunk, Statistics

ELEMENTS = 100


def runs_of_contact(chunk: Chunk) -> tuple[FloatArray, FloatArray]:
    """Times at which contact begins and at which it has ended; a record a step.

    A mass left at rest on the stop touches it again with impulses of rounding: no contact.
    """
    impulse = chunk.contact_impulse[:, 0]
    touching = np.r_[False, impulse > 1e-12 * impulse.max(), False]
    edges = np.flatnonzero(touching[1:] != touching[:-1])
    times = np.append(chunk.time, np.inf)
    return times[edges[::2]], times[edges[1::2]]


def collision(
    case: dict[str, Any], bar: dict[str, float]
) -> tuple[ContactProblem, Bar, Bar | None]:
    """Two bars, or one and a rigid wall."""
    bars = [
        Bar(
            length=bar["length"],
            area=area,
            young_modulus=bar["young_modulus"],
            density=bar["density"],
            elements=ELEMENTS,
        )
        for area in case["area"]
        if area is not None
    ]
    speeds = [body.rigid * velocity for body, velocity in zip(bars, case["velocity"], strict=False)]
    rotor = bars[0].as_rotor()
    casing = bars[1].as_casing(bar["gap"]) if len(bars) > 1 else wall(bar["gap"])
    start = dict(zip(("rotor_velocity", "casing_velocity"), speeds, strict=False))
    return problem(rotor, casing, start=start), bars[0], bars[1] if len(bars) > 1 else None


BARS = oracle("contact")["bars"] | {
    # Carpenter, Taylor, Katona 1991: steel bars of a square inch, head-on.
    "Carpenter": {
        "bar": {"length": 0.254, "young_modulus": 206.8e9, "density": 7844.07, "gap": 5.08e-4},
        "area": [0.0254**2, 0.0254**2],
        "velocity": [5.13588, -5.13588],
        "start": 49.46e-6,
        "duration": 98.9e-6,
        "force": 133.45e3,
        "impulse": 13.20,
        "velocity_after": [-5.13588, 5.13588],
    },
    # Example ImpactingBar of Siconos, exact values; its time-stepping gives 0.4814 N s.
    "Siconos": {
        "bar": {"length": 1.0, "young_modulus": 210e9, "density": 7800.0, "gap": 5e-5},
        "area": [3.14e-4, None],
        "velocity": [0.1, None],
        "start": 5.0e-4,
        "duration": 3.854e-4,
        "force": 1270.8,
        "impulse": 1270.8 * 3.854e-4,
        "velocity_after": [-0.1, None],
    },
}


@pytest.mark.parametrize("name", list(BARS))
def test_collision_of_bars(name: str) -> None:
    case = BARS[name]
    given, first, second = collision(case, case.get("bar", oracle("contact")["bar"]))
    dt = first.time_step
    steps = round((case["start"] + 2.0 * case["duration"]) / dt)
    state, chunk, _ = run(given, dt, steps)

    touching = chunk.time[chunk.contact_impulse[:, 0] > 0.0]
    assert touching[0] == pytest.approx(case["start"], abs=2.0 * dt)
    assert touching[-1] - touching[0] == pytest.approx(case["duration"], rel=0.02)
    assert chunk.contact_impulse.sum() == pytest.approx(case["impulse"], rel=0.01)
    # Peaks depend on the step; the mean over the middle of the contact does not.
    middle = np.abs(chunk.time - case["start"] - 0.5 * case["duration"]) < 0.3 * case["duration"]
    mean_force = chunk.contact_impulse[middle, 0].mean() / dt
    assert mean_force == pytest.approx(case["force"], rel=0.01)
    for bar, velocity, v0, after in (
        (first, chunk.rotor_velocity, case["velocity"][0], case["velocity_after"][0]),
        (second, chunk.casing_velocity, case["velocity"][1], case["velocity_after"][1]),
    ):
        if bar is not None:
            found = bar.rigid @ velocity[-1] / bar.mass
            assert found == pytest.approx(after, abs=0.01 * abs(after - v0))
    assert state.statistics.complementarity_residual < 1e-12
    assert ledger_residual(chunk) < 1e-10


def test_bouncing_bar() -> None:
    """Doyen, Ern and Piperno 2011: dropped from 5 m, g = 10, L = 10, c = 30; period 16/3 s.

    It touches from t = 1 to 5/3, the force being rho A c g t, and in mirror image from 11/3 to
    13/3: the second time after a flight in which it rings, so that errors show there.
    """
    bar = Bar(length=10.0, area=1.0, young_modulus=900.0, density=1.0, elements=2 * ELEMENTS)
    gravity = Load(rotor=10.0 * bar.rigid, casing=np.zeros(1))
    given = problem(bar.as_rotor(), wall(5.0), loads=(gravity,))
    dt = bar.time_step
    _, chunk, _ = run(given, dt, round(5.0 / dt))
    time, impulse = chunk.time, chunk.contact_impulse[:, 0]
    first, second = time < 8.0 / 3.0, time > 8.0 / 3.0
    touching = time[impulse > 0.0]
    assert touching[0] == pytest.approx(1.0, abs=2.0 * dt)
    assert touching[touching < 2.0][-1] == pytest.approx(5.0 / 3.0, abs=0.02 * 2.0 / 3.0)
    for part, middle, tolerance in ((first, 49.0 / 36.0, 1e-3), (second, 143.0 / 36.0, 0.02)):
        assert impulse[part].sum() == pytest.approx(800.0 / 3.0, rel=0.012)
        centre = (time * impulse)[part].sum() / impulse[part].sum()
        assert centre == pytest.approx(middle, abs=tolerance)


def oscillator(case: dict[str, Any], dt: float, end: float) -> tuple[Chunk, Statistics]:
    """Mass on a spring driven against a stop."""
    rotor = small_rotor(
        np.sqrt(np.array([oracle("contact")["oscillator"]["stiffness"]])),
        tip_radial=np.ones((1, 1)),
    )
    start = {"rotor": np.array([case.get("start", 0.0)])}
    force = np.array([case.get("force", 0.0)])
    load = Load(rotor=force, casing=np.zeros(1), frequency=case.get("frequency", 0.0))
    given = problem(rotor, wall(case["gap"]), start=start, loads=(load,))
    state, chunk, _ = run(given, dt, round(end / dt))
    return chunk, state.statistics


@pytest.mark.parametrize("name", ["C1", "C2", "C3", "C4"])
def test_events_of_an_oscillator_on_a_stop(name: str) -> None:
    """Impacts without restitution and releases, each within two steps of its exact time."""
    case, dt, end = oracle("contact")["oscillator"][name], 2e-5, 1.2
    chunk, statistics = oscillator(case, dt, end)
    begins, ends = runs_of_contact(chunk)
    events = [event for event in case["events"] if event["time"] < end]
    impacts = [event for event in events if event["event"] == "impact"]
    np.testing.assert_allclose(begins, [event["time"] for event in impacts], atol=2.0 * dt)
    # A contact that the impact ends has no release of its own: the mass leaves at once.
    releases = [event["time"] for event in events if event["event"] == "release"]
    lasting = np.isfinite(ends) & (ends - begins > 10.0 * dt)
    np.testing.assert_allclose(ends[lasting], releases, atol=2.0 * dt)
    for begin, event in zip(begins, impacts, strict=True):
        first = np.searchsorted(chunk.time, begin)
        # The mass is stopped within two steps.
        impulse = chunk.contact_impulse[first : first + 2].sum()
        assert impulse == pytest.approx(event["impulse"], rel=2e-3, abs=2e-4)
    assert statistics.complementarity_residual < 1e-12
    assert ledger_residual(chunk) < 1e-8


def test_oscillator_at_rest_on_its_stop() -> None:
    case, dt = oracle("contact")["oscillator"]["C1"], 1e-5
    chunk, _ = oscillator(case, dt, 0.05)
    assert chunk.contact_impulse[-1, 0] / dt == pytest.approx(case["resting_force"], rel=1e-6)
    assert chunk.normal_work[-1] == pytest.approx(-case["energy_lost"], rel=1e-6)
    assert chunk.rotor_displacement[-1, 0] == pytest.approx(case["gap"], rel=1e-12)
    assert chunk.contacts[-1] == 1


def test_coulomb_pad() -> None:
    """Code_Aster SDND100: m = 1 kg, k = 1e4 N/m, mu m g = 1 N, let go at 0.85 mm.

    Each half swing loses 2 mu m g / k; it sticks at 0.05 mm after two periods.
    """
    pressed, sliding = np.array([[1.0, 0.0]]), np.array([[0.0, 1.0]])
    rotor = small_rotor(np.array([50.0, 100.0]), tip_radial=pressed, tip_tangential=sliding)
    clearance = 1e-3
    weight = Load(rotor=np.array([10.0 + 50.0**2 * clearance, 0.0]), casing=np.zeros(1))
    start = {"rotor": np.array([clearance, 0.85e-3])}
    given = problem(
        rotor, wall(clearance), start=start, loads=(weight,), friction=0.1, sliding="signed"
    )
    dt = 1e-5
    _, chunk, _ = run(given, dt, 20_000)
    position = chunk.rotor_displacement[:, 1]
    half = np.pi / 100.0
    extremes = [position[round(n * half / dt)] for n in range(5)]
    np.testing.assert_allclose(extremes, [0.85e-3, -0.65e-3, 0.45e-3, -0.25e-3, 0.05e-3], atol=1e-6)
    stuck = position[chunk.time > 0.12566 + dt]
    np.testing.assert_allclose(stuck, 0.05e-3, atol=1e-6)
    # It slid 3.6 mm against 1 N: that is what friction took.
    assert chunk.friction_work[-1] == pytest.approx(-3.6e-3, rel=2e-3)
    np.testing.assert_allclose(chunk.contact_impulse[2:-1], 10.0 * dt, rtol=1e-9)
    assert ledger_residual(chunk) < 1e-9


@pytest.mark.parametrize("case", oracle("jeffcott")["response"], ids=lambda c: c["frequency_hz"])
def test_a_rigid_rotor_stays_on_its_unbalance_orbit(case: dict[str, float]) -> None:
    """Harmonic loads in x and y, a quarter period apart; started on the closed-form orbit."""
    rotor = oracle("jeffcott")["rotor"]
    natural = np.sqrt(rotor["stiffness"] / rotor["mass"])
    mass_root = np.sqrt(rotor["mass"])
    body = small_rotor(
        np.full(2, natural),
        damping_ratio=np.full(2, rotor["damping_ratio"]),
        centre=np.eye(2) / mass_root,
    )
    omega = 2.0 * np.pi * case["frequency_hz"]
    size = rotor["unbalance"] * omega**2 / mass_root
    loads = tuple(
        Load(rotor=size * np.eye(2)[axis], casing=np.zeros(1), frequency=omega, phase=phase)
        for axis, phase in ((0, 0.0), (1, -np.pi / 2.0))
    )
    orbit = mass_root * case["amplitude"] * np.exp(-1j * case["phase_lag"])
    start = {
        "rotor": np.array([orbit.real, orbit.imag]),
        "rotor_velocity": omega * np.array([-orbit.imag, orbit.real]),
    }
    given = problem(body, wall(1.0), start=start, loads=loads)
    _, chunk, _ = run(given, 5e-6, 20_000, every=10)
    found = chunk.rotor_displacement @ body.centre.T @ [1.0, 1.0j]
    exact = orbit / mass_root * np.exp(1j * omega * chunk.time)
    np.testing.assert_allclose(found, exact, atol=1e-4 * case["amplitude"])
