"""Marches with Coriolis forces, compared with closed-form solutions and with independent
elements."""

from dataclasses import replace

import numpy as np

from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.modal_loads import Load
from bladewhirl.studies.verification.bodies import (
    default_stage,
    marched,
    problem,
    small_rotor,
    wall,
)
from bladewhirl.studies.verification.case import Pair, reference, verifies


@verifies("0.01", "0.03")
def step_of_force(thickness: str) -> Pair:
    """Compare the response to a step force, about 1e-4 m, with independent elements; half of the
    error is due to the reduction."""
    changes = {
        "bladed_disk.disk.thickness": float(thickness),
        "shaft.stiffness": 3.4e7,
        "rotation.effects": "full",
        "march.time_step": 1e-6,
    }
    given, dt = default_stage(changes | {"march.speed": 1.05, "damping.ratio": 0.0}), 4e-6
    rotor, still = given.rotor, np.zeros(len(given.casing.frequency))
    given = replace(given, loads=(Load(rotor=1e3 * rotor.centre[0], casing=still),))
    known = reference("rotation")["stages"][thickness]["step_1000N_at_1p05"]
    rows = np.vstack([rotor.centre, rotor.tip_radial[:1], rotor.tip_tangential[:1]])
    steps = [round(row[0] / dt) for row in known]
    moved = marched(given, dt, steps[-1]).rotor_displacement
    return [row[1:] for row in known], [rows @ moved[step] for step in steps]


def jeffcott(
    omega: float, *, internal: float = 0.0, external: float = 0.0, anisotropy: float = 0.0
) -> ContactProblem:
    """Return a rigid rotor on two springs with unbalance and spin softening.

    Args:
        omega: speed of rotation [rad/s].
        internal: damping in the rotating frame [N s/m].
        external: damping in the static frame [N s/m].
        anisotropy: half the difference of the spring stiffnesses in the static frame [N/m].
    """
    rotor = reference("jeffcott")["rotor"]
    square = rotor["stiffness"] / rotor["mass"] - omega**2
    centre = np.eye(2) / np.sqrt(rotor["mass"])
    body = small_rotor(
        np.full(2, np.sign(square) * np.sqrt(abs(square))),
        centre=centre,
        dampers=np.sqrt(internal + external) * centre,
        by_velocity=2.0 * omega * np.array([[0.0, -1.0], [1.0, 0.0]]),
        circulation=external * omega,
        anisotropy=anisotropy,
    )
    load = Load(rotor=rotor["unbalance"] * omega**2 * centre[0], casing=np.zeros(1), ramp=0.5)
    return problem(body, wall(1.0), loads=(load,), speed=omega)


@verifies()
def unbalance_through_resonance() -> Pair:
    """Compare amplitude and phase of the unbalance response after 4 s, at speeds below and above
    resonance, with the closed-form solution."""
    known = reference("jeffcott")
    rotor, expected, computed = known["rotor"], [], []
    damping = 2.0 * rotor["damping_ratio"] * np.sqrt(rotor["stiffness"] * rotor["mass"])
    for row in known["response"]:
        given = jeffcott(2.0 * np.pi * row["frequency_hz"], external=damping)
        chunk = marched(given, 1e-4, 40_000, every=40_000)
        x, y = given.rotor.centre @ chunk.rotor_displacement[-1]
        expected.append([row["amplitude"], -row["phase_lag"]])
        computed.append([np.hypot(x, y), np.arctan2(y, x)])
    return expected, computed


@verifies(0.8, 0.95, 1.2)
def unequal_bearings(share: float) -> Pair:
    """Compare forward and backward parts of the orbit with the closed-form solution."""
    rotor = reference("jeffcott")["rotor"]
    omega = share * np.sqrt(rotor["stiffness"] / rotor["mass"])
    damping, half = 5e3, 0.15 * rotor["stiffness"]
    stiffness = rotor["stiffness"] + half * np.array([1.0, -1.0])
    dynamic = stiffness - rotor["mass"] * omega**2 + 1j * damping * omega
    along, across = rotor["unbalance"] * omega**2 / dynamic
    given = jeffcott(omega, external=damping, anisotropy=half)
    chunk = marched(given, 1e-5, 200_000, every=500)
    late = chunk.time > 1.5
    x, y = given.rotor.centre @ chunk.rotor_displacement[late].T
    turning = np.exp(2j * omega * chunk.time[late])
    parts = np.column_stack([np.ones_like(turning), turning.conj()])
    computed = np.linalg.lstsq(parts, x + 1j * y, rcond=None)[0]
    expected = np.array([(along + across) / 2.0, (along - across).conj() / 2.0])
    return expected.view(float), computed.view(float)


@verifies(0.9, 1.3)
def internal_damping(share: float) -> Pair:
    """Compare the growth rate by internal damping with the closed-form solution, which is negative
    below the critical speed and positive above it."""
    rotor, damping, steps = reference("jeffcott")["rotor"], 2e3, 10_000
    natural = np.sqrt(rotor["stiffness"] / rotor["mass"])
    omega = share * natural
    roots = np.roots([1.0, 2j * omega + damping / rotor["mass"], natural**2 - omega**2])
    slow = roots[np.abs(roots.imag).argmin()]
    given = replace(jeffcott(omega, internal=damping), loads=())
    velocity = 1e-3 * np.array([slow.real, slow.imag])
    start = replace(given.start, rotor=np.array([1e-3, 0.0]), rotor_velocity=velocity)
    chunk = marched(replace(given, start=start), 2e-5, steps, every=steps)
    size = np.linalg.norm(chunk.rotor_displacement, axis=1)
    return slow.real, np.log(size[-1] / size[0]) / chunk.time[-1]
