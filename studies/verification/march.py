"""Time integration compared with a simple dense program, and checks of symmetries and orders."""

from collections.abc import Mapping
from itertools import combinations
from typing import Any

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.modal_loads import Load
from bladewhirl.solvers.march.march import Chunk
from bladewhirl.studies.verification.bodies import (
    default_stage,
    ledger_residual,
    marched,
    point_mass,
    problem,
    wall,
)
from bladewhirl.studies.verification.case import Pair, Pairs, verifies
from bladewhirl.studies.verification.stages import observed_order

COARSE: Mapping[str, Any] = {
    "reduction.fixed_interface_modes": 22,
    "casing.elements": 22,
    "casing.support": 7.975e6,
}
"""Changes of the default case: with as many casing elements as blades, a turn by one pitch is a
symmetry of both bodies."""

PUSH: dict[str, Any] = {"initial.centre_velocity": [1.5, 0.7], "contact.friction": 0.0}
STRIKE: dict[str, Any] = {"excitation": {"type": "casing-distortion"}}
DT, STEPS = 4e-6, 2500

RUBBING: Mapping[str, Mapping[str, Any]] = {
    "free centre, no friction": PUSH,
    "clamped, friction 0.1": STRIKE | {"shaft.clamped": True, "contact.friction": 0.1},
    "six coupled modes, friction 0.3": PUSH
    | {"reduction.modes": "six", "coupling.stiffness": 2e6, "contact.friction": 0.3},
    "backward, signed sliding, tips that turn": PUSH
    | {
        "march.speed": -1.05,
        "contact.friction": 0.2,
        "contact.sliding": "signed",
        "contact.tip_rotation": True,
    },
    "oval casing that closes, friction 0.1": {
        "casing.clearance_lobes": [{"lobes": 2, "amplitude": 2e-4}],
        "casing.closure": {
            "amount": 2e-2,
            "time_constant": 0.1,
            "lobes": [{"lobes": 3, "amplitude": 5e-3, "phase": 0.2}],
        },
        "contact.friction": 0.1,
        "excitation": {"type": "none"},
    },
}
"""Further changes of the default case, by name of the problem."""


def coarse(changes: Mapping[str, Any]) -> ContactProblem:
    """Return the contact problem of the coarse default stage, with changes of the case."""
    return default_stage({**COARSE, **changes})


def dense_march(
    given: ContactProblem, dt: float, steps: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """March with dense matrices, from the definitions and without the kernel.

        A x_{n+1} = f_n - K_n x_n + 2 x_n / dt^2 + (D / (2 dt) - 1 / dt^2) x_{n-1}
                    + (B_N + mu B_T S) l
        A = 1 / dt^2 + D / (2 dt),     0 <= l  perp  clearance + B_N x_{n+1} >= 0

    for the mass-normalised modes of rotor and casing, in this order, with the normal contact forces
    l and the signs of sliding S. Between nodes, displacement of the casing, clearance and closure
    are SciPy's cubic splines through values and slopes; dampers at points are left out.

    Returns:
        gaps [m], normal impulses and friction impulses [N s] at every step.
    """
    rotor, casing, speed = given.rotor, given.casing, given.speed
    m, tips = len(rotor.frequency), len(rotor.tip_angle)
    omega = np.r_[rotor.frequency, casing.frequency]
    damping = 2.0 * np.r_[rotor.damping_ratio, casing.damping_ratio] * omega
    compliance = 1.0 / (1.0 / dt**2 + damping / (2.0 * dt))
    around = [*range(len(casing.nodal)), 0]
    angles = np.linspace(0.0, 2.0 * np.pi, len(around))
    share = np.zeros((len(casing.nodal), 2)) if given.closure is None else given.closure.share
    radial, along, clearance, closing = (
        CubicHermiteSpline(angles, value[around], casing.radius * slope[around])
        for value, slope in (
            (casing.nodal[:, 0], casing.nodal[:, 1]),
            (casing.nodal[:, 2], casing.nodal[:, 3]),
            (casing.clearance[:, 0], casing.clearance[:, 1]),
            (share[:, 0], share[:, 1]),
        )
    )

    def room(n: int, angle: FloatArray) -> FloatArray:
        """Return the gaps of tips at given angles at step n, without displacements."""
        lost = 0.0 if given.closure is None else given.closure.course.value(n * dt)
        return np.asarray(clearance(angle) + rotor.tip_recess - lost * closing(angle))

    def pull(n: int, x: FloatArray) -> FloatArray:
        """Return loads minus restoring forces at step n."""
        force, time = -(omega**2) * x, n * dt
        for load in given.loads:
            force = force + load_factor(load, time) * np.r_[load.rotor, load.casing]
        if given.springs is not None:
            place = given.springs.places
            force[place] -= given.springs.stiffness(angle=speed * time) @ x[place]
        return np.asarray(force)

    start = given.start
    x, v = np.r_[start.rotor, start.casing], np.r_[start.rotor_velocity, start.casing_velocity]
    before = x - dt * v + 0.5 * dt**2 * (pull(0, x) - damping * v)
    computed = np.zeros((3, steps + 1, tips))
    computed[0, 0] = room(0, np.mod(rotor.tip_angle, 2 * np.pi))
    for n in range(steps):
        inertia = 2.0 * x / dt**2 + (damping / (2.0 * dt) - 1.0 / dt**2) * before
        free = compliance * (pull(n, x) + inertia)
        angle = rotor.tip_angle + speed * dt * (n + 1)
        if given.tip_rotation:
            angle = angle + rotor.tip_tangential @ free[:m] / rotor.tip_radius
        angle = np.mod(angle, 2.0 * np.pi)
        normal = np.hstack([-rotor.tip_radial, radial(angle)])
        tangential = np.hstack([-rotor.tip_tangential, along(angle)])
        slides = np.full(tips, speed)
        if given.sliding == "signed":
            slides = rotor.tip_radius * speed - tangential @ (x - before) / dt
        drag = given.friction * np.sign(slides)
        rows = compliance[:, None] * (normal + drag[:, None] * tangential).T
        gap = room(n + 1, angle) + normal @ free
        force = complementary(gap, normal @ rows)
        before, x = x, free + rows @ force
        left = room(n + 1, angle) + normal @ x
        computed[:, n + 1] = left, dt * force, dt * drag * force
    return computed[0], computed[1], computed[2]


@verifies(*RUBBING)
def rubbing_stages(kind: str) -> Pairs:
    """Compare gaps and impulses over 10 ms with `dense_march`; later, chaotic motions separate.

    Raises:
        ArithmeticError: no blade touches.
    """
    given = coarse(RUBBING[kind])
    chunk = marched(given, DT, STEPS)
    if chunk.contact_impulse.max() <= 0.0:
        raise ArithmeticError(f"{kind}: expected contact")
    gaps, *impulses = dense_march(given, DT, STEPS)
    return {
        "gaps_of_rubbing_stages": (gaps, chunk.gap),
        "impulses_of_rubbing_stages": (impulses, [chunk.contact_impulse, chunk.friction_impulse]),
    }


@verifies("oval casing that closes, friction 0.1")
def closing_wall_ledger(kind: str) -> Pair:
    """Compare with zero the error of the energy balance of a stage whose casing closes."""
    return 0.0, ledger_residual(marched(coarse(RUBBING[kind]), DT, STEPS))


@verifies()
def gaps_of_the_papers_stage() -> Pair:
    """Compare the gaps of the paper's stage in the kernel with the gaps in `dense_march`."""
    strike = {"casing.support": 7.975e6, **STRIKE}
    given = default_stage(strike)
    return dense_march(given, 1e-6, 30_000)[0], marched(given, 1e-6, 30_000).gap


def turned(angle: float = 0.0, speed: float = 1.05) -> Chunk:
    """March a stage with an initial shaft velocity in the direction `angle`, until blades rub."""
    push = [1.5 * np.cos(angle), 1.5 * np.sin(angle)]
    changes = {"initial.centre_velocity": push, "march.speed": speed, "contact.friction": 0.1}
    return marched(coarse(changes), DT, STEPS)


@verifies()
def symmetries() -> Pairs:
    """Compare a march with its mirror image, and with a march turned by one blade pitch.

    In the mirror image speed, order of blades, initial velocity and sign of friction are reversed.
    There are 22 casing elements for 22 blades.
    """
    chunk, image, reverse = turned(), turned(speed=-1.05), -np.arange(22) % 22
    return {
        "mirror": (chunk.gap, image.gap[:, reverse]),
        "mirrored_friction": (chunk.friction_impulse, -image.friction_impulse[:, reverse]),
        "one_pitch": (chunk.gap, np.roll(turned(2.0 * np.pi / 22).gap, -1, axis=1)),
    }


@verifies()
def standstill() -> Pairs:
    """Compare the gaps on both sides of the initial direction at zero speed with each other.
    Friction is zero."""
    chunk = turned(speed=0.0)
    if not chunk.contact_impulse.any():
        raise ArithmeticError("expected contact at standstill")
    return {
        "friction_at_standstill": (np.zeros_like(chunk.friction_impulse), chunk.friction_impulse),
        "symmetry_at_standstill": (chunk.gap, chunk.gap[:, -np.arange(22) % 22]),
    }


def oscillations(given: ContactProblem, time: float) -> FloatArray:
    """Return modal displacements of the rotor after a time [s] without contact and loads, in closed
    form."""
    start, ratio, omega = given.start, given.rotor.damping_ratio, given.rotor.frequency
    rate, damped = ratio * omega, omega * np.sqrt(1.0 - ratio**2)
    sine = (start.rotor_velocity + rate * start.rotor) / damped
    swing = start.rotor * np.cos(damped * time) + sine * np.sin(damped * time)
    return np.asarray(np.exp(-rate * time) * swing)


@verifies()
def order_of_free_motion() -> Pair:
    """Compare with 2 the order of convergence of damped free motion from random initial conditions;
    the errors after 2 ms with three time steps give two orders."""
    random = np.random.default_rng(1)
    body = coarse({"damping.ratio": 0.01}).rotor
    size = len(body.frequency)
    start = {
        "rotor": random.normal(size=size) / body.frequency,
        "rotor_velocity": random.normal(size=size),
    }
    given, errors = problem(body, wall(1e3), start=start), []
    for steps in (4000, 8000, 16_000):
        chunk = marched(given, 2e-3 / steps, steps, every=steps)
        errors.append(np.linalg.norm(chunk.rotor_displacement[-1] - oscillations(given, 2e-3)))
    return np.full(2, 2.0), observed_order(np.array(errors))


@verifies()
def free_motion() -> Pair:
    """Compare the free motion that follows an initial velocity of the shaft with its modal
    superposition."""
    given = coarse({"initial.centre_velocity": [0.1, 0.05]})
    chunk = marched(given, 1.25e-7, 16_000, every=16_000)
    return oscillations(given, 2e-3), chunk.rotor_displacement[-1]


def after_a_hit(steps: int) -> float:
    """Return the position of a mass on a spring shortly after its impact on a stop [m]."""
    load = Load(rotor=np.array([20.0]), casing=np.zeros(1), frequency=10.0)
    given = problem(point_mass(1.0, 1000.0**0.5), wall(0.01), loads=(load,))
    return float(marched(given, 0.53 / steps, steps, every=steps).rotor_displacement[-1, 0])


@verifies()
def order_of_contact() -> Pair:
    """Compare with 1 the order of convergence in contact, from two numbers of steps.

    Each error is a mean over similar numbers of steps, because the error of a single march depends
    on the time of impact within a step.
    """
    exact = after_a_hit(4_000_000)
    near = 1.0 + np.arange(40) / 40.0
    errors = [
        np.mean([abs(after_a_hit(round(count)) - exact) for count in steps * near])
        for steps in (2000, 32_000)
    ]
    return 1.0, observed_order(np.array(errors), ratio=16.0)[0]


def load_factor(load: Load, time: float) -> float:
    """Return the factor of a load pattern at a time [s]."""
    if time >= load.end:
        return 0.0
    rise = 0.5 - 0.5 * np.cos(np.pi * time / load.ramp) if time < load.ramp else 1.0
    return float(rise * np.cos(load.frequency * time + load.phase))


def complementary(gap: FloatArray, delassus: FloatArray) -> FloatArray:
    """Return the normal contact forces lambda, with 0 <= lambda perp gap + W lambda >= 0.

    The first active set contains all tips that penetrate. Tips with a tensile force are then
    removed from the set, and tips that penetrate are added. If these changes do not converge
    because W is singular, all sets are tried, beginning with the smallest.

    Raises:
        ArithmeticError: no active set gives a solution.
    """
    tips, tolerance = len(gap), 1e-12 * np.abs(gap).max(initial=0.0)
    active = gap < 0.0
    for _ in range(2 * tips):
        multiplier, after, complete = _closed(gap, delassus, np.flatnonzero(active), tolerance)
        if complete:
            return multiplier
        active = np.where(active, multiplier >= 0.0, after < -tolerance)
    for size in range(tips + 1):
        for subset in combinations(range(tips), size):
            chosen = np.array(subset, dtype=np.int64)
            multiplier, _, complete = _closed(gap, delassus, chosen, tolerance)
            if complete:
                return multiplier
    raise ArithmeticError("no active set is complementary")


def _closed(
    gap: FloatArray, delassus: FloatArray, chosen: IntArray, tolerance: float
) -> tuple[FloatArray, FloatArray, bool]:
    """Return the multipliers that close the gaps of the chosen tips, the resulting gaps of all
    tips, and true if the multipliers solve the complementarity problem."""
    multiplier = np.zeros(len(gap))
    if chosen.size:
        part = delassus[np.ix_(chosen, chosen)]
        multiplier[chosen] = np.linalg.lstsq(part, -gap[chosen], rcond=None)[0]
    after = gap + delassus @ multiplier
    complete = (multiplier >= 0.0).all() and (after >= -tolerance).all()
    return multiplier, after, bool(complete and np.abs(after[chosen]).max(initial=0.0) <= tolerance)
