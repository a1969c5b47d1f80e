"""Contact schemes with restitution, sticking friction, or a stop of finite stiffness."""

from dataclasses import replace
from functools import cache

import numpy as np
from scipy.integrate import solve_ivp

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.analysis import Contact
from bladewhirl.models.stage.contact_problem import ContactProblem, Load
from bladewhirl.solvers.march.march import Chunk
from bladewhirl.studies.verification.bodies import (
    ledger_residual,
    marched,
    point_mass,
    problem,
    small_rotor,
    wall,
)
from bladewhirl.studies.verification.case import Pair, Pairs, reference, verifies
from bladewhirl.studies.verification.contact import bars_in_impact, march_of_a_pad

MASS, SPEED, DEPTH = 2.0, 3.0, 1e-4


def thrown_mass(**law: float) -> ContactProblem:
    """Return a free mass of 2 kg that moves at 3 m/s towards a wall at a distance of 1 mm, with
    numbers of a contact law."""
    start = {"rotor_velocity": np.array([SPEED * MASS**0.5])}
    return replace(problem(point_mass(MASS), wall(1e-3), start=start), law=Contact(**law).law)


@verifies(0.0, 0.5, 1.0)
def rebound(restitution: float) -> Pair:
    """Compare the rebound velocity with initial speed times restitution coefficient."""
    given = thrown_mass(restitution=restitution)
    chunk = marched(given, 1e-6, 600, scheme="moreau-jean")
    return -restitution * SPEED, chunk.rotor_velocity[-1, 0] / MASS**0.5


@cache
def march_on_a_penalty() -> Chunk:
    """March the thrown mass against a penalty stiffness that allows 0.1 mm of penetration."""
    stiffness = MASS * (SPEED / DEPTH) ** 2
    return marched(thrown_mass(penalty_stiffness=stiffness), 1e-7, 6000, scheme="penalty")


@verifies()
def mass_on_a_penalty() -> Pairs:
    """Compare impulse, depth and time of contact with exact values: the contact lasts half a period
    of a mass on a spring, and the depth is speed divided by frequency."""
    chunk = march_on_a_penalty()
    return {
        "penalty_impulse": (2.0 * MASS * SPEED, chunk.contact_impulse.sum()),
        "penalty_depth": (-DEPTH, chunk.gap.min()),
        "penalty_time": (np.pi * DEPTH / SPEED, chunk.contact_steps.sum() * 1e-7),
    }


@verifies("Carpenter", "Siconos")
def impulse_of_bars(name: str) -> Pair:
    """Compare the contact impulse of bars without restitution with exact solutions."""
    known, _, given, dt, steps = bars_in_impact(name)
    return known["impulse"], marched(given, dt, steps, scheme="moreau-jean").contact_impulse.sum()


@verifies()
def pad_that_sticks() -> Pairs:
    """Compare a pad with Code_Aster SDND100: time after which it sticks, and extreme positions.

    The friction force at rest is k x, which is half of mu m g.
    """
    chunk, known = march_of_a_pad("moreau-jean"), reference("published")["coulomb_pad"]
    moving = chunk.time[np.abs(chunk.rotor_velocity[:, 1]) > 1e-12]
    at = [round(n * np.pi / 100.0 / 1e-5) for n in range(4)]
    extremes = [*chunk.rotor_displacement[at, 1], chunk.rotor_displacement[-1, 1]]
    force = chunk.friction_impulse[-1, 0] / (0.1 * chunk.contact_impulse[-1, 0])
    return {
        "time_of_sticking": (known["stuck_from"], moving[-1]),
        "extremes_of_a_pad": (known["extremes"], extremes),
        "force_of_sticking": (-0.5, force),
    }


@verifies(0.6, 0.7)
def two_masses_on_a_stop(frequency: float) -> Pair:
    """Compare the motion of two masses that the penalty scheme computes, from rest through several
    impacts and releases, with the motion that an ODE solver computes."""
    steps = 20_000
    stiffness = np.array([[1.0, -1.0], [-1.0, 2.0]])
    square, shapes = np.linalg.eigh(stiffness)
    period = 2.0 * np.pi / frequency
    dt = 10.0 * period / steps

    def rates(time: float, state: FloatArray) -> FloatArray:
        x, v = state[:2], state[2:]
        force = np.array([-100.0 * max(x[0] - 1.0, 0.0), 0.1 * np.cos(frequency * time)])
        return np.concatenate([v, force - stiffness @ (x + 0.03 * v)])

    at = np.arange(steps + 1) * dt
    exact = solve_ivp(
        rates, (0.0, at[-1]), np.zeros(4), "DOP853", at, rtol=1e-10, atol=1e-12, max_step=0.02
    ).y[0]
    omega = np.sqrt(square)
    rotor = small_rotor(omega, tip_radial=shapes[:1], damping_ratio=0.015 * omega)
    load = Load(rotor=0.1 * shapes[1], casing=np.zeros(1), frequency=frequency)
    given = replace(
        problem(rotor, wall(1.0), loads=(load,)), law=Contact(penalty_stiffness=100.0).law
    )
    return exact, marched(given, dt, steps, scheme="penalty").rotor_displacement @ shapes[0]


@verifies()
def ledgers() -> Pair:
    """Compare with zero the energy residual of a march with impacts and that of a march with
    penalty contact."""
    chunks = [march_of_a_pad("moreau-jean"), march_on_a_penalty()]
    return np.zeros(2), [ledger_residual(chunk) for chunk in chunks]
