"""Verification of a speed of rotation that varies: rotors of masses on springs in the plane.

In static axes a rotor of masses z = x + i y with unbalances m e follows

    M z'' + C z' + K z = m e (Omega^2 - i Omega') exp(i psi),

which is known in closed form for one mass at constant acceleration, and otherwise integrated here.
"""

from dataclasses import replace

import numpy as np
import scipy.linalg as la
from scipy.integrate import solve_ivp
from scipy.special import erf

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import with_values
from bladewhirl.models.case.speed_course import SpeedCourse
from bladewhirl.models.stage.build import contact_problem
from bladewhirl.models.stage.build_beams import build_beams
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.fused_support import with_fuse
from bladewhirl.models.stage.modal_loads import Load
from bladewhirl.models.stage.varying_speed import FreeSpeed, SpeedChange
from bladewhirl.models.structure.rotating import Rotating
from bladewhirl.studies.verification.bodies import (
    marched,
    point_mass,
    problem,
    small_rotor,
    wall,
)
from bladewhirl.studies.verification.case import Pair, verifies

AXES = np.array([[0.0, -1.0], [1.0, 0.0]])
"""Matrix of z x u in the plane."""


def masses_on_springs(
    mass: FloatArray,
    stiffness: FloatArray,
    unbalance: FloatArray,
    course: SpeedCourse,
    *,
    damping: float = 0.0,
) -> ContactProblem:
    """Return masses in the plane on isotropic springs, in axes that turn with the rotor.

    Args:
        mass: masses [kg], (masses,).
        stiffness: stiffness matrix in each direction [N/m], (masses, masses).
        unbalance: unbalance of each mass along +x [kg m], (masses,).
        course: speed over time.
        damping: damping of the first mass in static axes [N s/m].
    """
    square, shapes = la.eigh(stiffness, np.diag(mass))
    base = max(course.range, key=abs)
    modes, identity = 2 * len(mass), np.eye(len(mass))
    softened = np.repeat(square, 2) - base**2
    coriolis = np.kron(identity, AXES)
    centre = np.kron(shapes[:1], np.eye(2))
    force = np.kron(unbalance @ shapes, np.eye(2))
    rotor = small_rotor(
        np.sign(softened) * np.sqrt(np.abs(softened)),
        tip_radial=centre[:1],
        centre=centre,
        dampers=np.sqrt(damping) * centre,
        by_velocity=2.0 * base * coriolis,
        circulation=damping * base,
    )
    loads = (
        Load(rotor=base**2 * force[0], casing=np.zeros(1), by_square=base**-2.0),
        Load(rotor=force[1], casing=np.zeros(1), constant=0.0, by_acceleration=-1.0),
    )
    one = np.eye(modes)
    turning = Rotating(
        mass=one,
        stiffness=np.diag(rotor.stiffness),
        gyroscopic=2.0 * coriolis,
        stiffness_speed=-one,
        speed=base,
    )
    change = SpeedChange(course=course, rotor=turning)
    given = problem(rotor, wall(1e3), loads=loads, speed=base)
    return replace(given, change=change)


def inertial(
    mass: FloatArray,
    stiffness: FloatArray,
    unbalance: FloatArray,
    course: SpeedCourse,
    time: FloatArray,
    *,
    damping: float = 0.0,
) -> ComplexArray:
    """Return the motion of the first mass of `masses_on_springs` in static axes [m], (times,)."""
    count = len(mass)
    first = np.arange(count) == 0

    def rate(t: float, state: ComplexArray) -> ComplexArray:
        place, velocity = state[:count], state[count:]
        speed, change = course.speed(t), course.acceleration(t)
        force = unbalance * (speed**2 - 1j * change) * np.exp(1j * course.angle(t))
        force = force - stiffness @ place - damping * first * velocity
        return np.concatenate([velocity, force / mass])

    start = np.zeros(2 * count, dtype=complex)
    solved = solve_ivp(
        rate, (0.0, time[-1]), start, "DOP853", time, rtol=1e-12, atol=1e-16, max_step=0.01
    )
    return np.asarray(solved.y[0])


def accelerated(frequency: float, ratio: float, rate: float, time: FloatArray) -> ComplexArray:
    """Return the motion of one mass at constant acceleration from rest, divided by its
    eccentricity, in static axes, (times,).

    Args:
        frequency: natural frequency [Hz].
        ratio: damping ratio.
        rate: acceleration [Hz/s].
        time: times [s].
    """
    w, alpha = 2.0 * np.pi * frequency, 2.0 * np.pi * rate
    root = np.sqrt(-0.5j * alpha)
    roots = w * (-ratio + np.array([1j, -1j]) * np.sqrt(1.0 - ratio**2))
    turned = np.exp(0.5j * alpha * time**2)
    parts = []
    for own in roots:
        shift = own / (2.0 * root)
        plain = np.exp(own * time + shift**2) * np.sqrt(np.pi) / (2.0 * root)
        plain = plain * (erf(root * time + shift) - erf(shift))
        weighted = (np.exp(own * time) - turned - own * plain) / (2.0 * root**2)
        begun = (own + 2.0 * ratio * w) * np.exp(own * time)  # the mass starts off the axis
        parts.append(begun + w**2 * plain + 2j * ratio * w * alpha * weighted)
    return np.asarray((parts[0] - parts[1]) / (roots[0] - roots[1]) - turned)


def peak_of(time: FloatArray, amplitude: FloatArray) -> tuple[float, float]:
    """Return the time and the value of the largest amplitude, of the parabola through the three
    largest values around it."""
    top = int(np.argmax(amplitude))
    (a, b, c), step = amplitude[top - 1 : top + 2], time[1] - time[0]
    shift = 0.5 * (a - c) / (a - 2.0 * b + c)
    return float(time[top] + shift * step), float(b - 0.25 * (a - c) * shift)


@verifies((40.0, 0.01, 20.0), (40.0, 0.02, 50.0), (25.0, 0.005, 8.0), (60.0, 0.03, 100.0))
def peak_at_acceleration(given: tuple[float, float, float]) -> Pair:
    """Compare the peak of one mass for a natural frequency [Hz], a damping ratio and an
    acceleration [Hz/s]."""
    return marched_peak(*given, 2e-5)


def marched_peak(frequency: float, ratio: float, rate: float, time_step: float) -> Pair:
    """Return the largest displacement of one mass at constant acceleration from rest divided by its
    eccentricity, and the speed at which it occurs divided by the natural frequency: closed form and
    march."""
    w, end = 2.0 * np.pi * frequency, 1.6 * frequency / rate
    course = SpeedCourse.through([0.0, end], [0.0, 2.0 * np.pi * rate * end], 0.0)
    one = np.ones(1)
    given = masses_on_springs(one, w**2 * np.eye(1), one, course, damping=2.0 * ratio * w)
    steps = round(end / time_step)
    every = max(1, round(1.0 / (60.0 * frequency) / time_step))
    chunk = marched(given, time_step, steps, every=every)
    moved = np.hypot(*(chunk.rotor_displacement @ given.rotor.centre.T).T)
    exact = np.abs(accelerated(frequency, ratio, rate, chunk.time))
    scale = np.array([rate / frequency, 1.0])
    return tuple(scale * peak_of(chunk.time, each) for each in (exact, moved))  # type: ignore[return-value]


FIVE = np.array([3.0, 2.0, 4.0, 2.0, 3.0])  #: masses [kg]


def five_masses() -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return masses, stiffness and unbalances of a shaft with five masses on two bearings."""
    between, bearing = 2e6, 5e5
    ends = np.diag([1.0, 2.0, 2.0, 2.0, 1.0]) - np.eye(5, k=1) - np.eye(5, k=-1)
    stiffness = between * ends + bearing * np.diag([1.0, 0.0, 0.0, 0.0, 1.0])
    return FIVE, stiffness, 1e-5 * np.array([1.0, -2.0, 3.0, 1.0, 0.5])


@verifies()
def two_critical_speeds() -> Pair:
    """Compare the march of five masses through two critical speeds, extrapolated from two time
    steps, with an integration in static axes."""
    (mass, stiffness, unbalance), end, damping, dt = five_masses(), 0.4, 60.0, 5e-6
    critical = np.sqrt(la.eigvalsh(stiffness, np.diag(mass)))
    course = SpeedCourse.smooth_step(0.0, 1.4 * float(critical[1]), 0.0, end)
    given = masses_on_springs(mass, stiffness, unbalance, course, damping=damping)
    coarse, fine = (
        marched(given, share * dt, round(end / dt / share), every=round(2e-3 / dt / share))
        for share in (2, 1)
    )
    exact = inertial(mass, stiffness, unbalance, course, fine.time, damping=damping)
    exact = exact * np.exp(-1j * course.angle(fine.time))
    moved = [chunk.rotor_displacement @ given.rotor.centre.T for chunk in (coarse, fine)]
    better = (4.0 * moved[1] - moved[0]) / 3.0
    return np.column_stack([exact.real, exact.imag]), better


@verifies()
def braked_disk() -> Pair:
    """Compare the speed of a rigid disk that friction brakes with that after the angular impulse of
    friction, the sum of friction coefficient times radius times normal impulse."""
    friction, inertia = 0.2, 0.5
    body = point_mass(2.0, 300.0)
    start = {"rotor": np.zeros(1), "rotor_velocity": np.ones(1)}
    given = problem(body, wall(0.0), start=start, speed=50.0, friction=friction)
    course = SpeedCourse.through([0.0], [50.0], 0.0)
    drive = FreeSpeed(inertia=inertia)
    given = replace(given, change=SpeedChange(course=course), drive=drive)
    chunk = marched(given, 1e-5, 20_000, every=100)
    braked = friction * body.tip_radius / inertia * np.cumsum(chunk.contact_impulse[:, 0])
    return 50.0 - braked, chunk.rotation_speed


@verifies()
def momentum_of_free_masses() -> Pair:
    """Compare the angular momentum of five masses that spin freely with that at the start."""
    mass, stiffness, unbalance = five_masses()
    course = SpeedCourse.through([0.0], [260.0], 0.0)
    given = masses_on_springs(mass, stiffness, unbalance, course)
    still = np.zeros(len(given.rotor.frequency))
    drive = FreeSpeed(
        inertia=0.02,
        along=sum((load.by_square * load.rotor for load in given.loads), still),
        across=sum((-load.by_acceleration * load.rotor for load in given.loads), still),
    )
    chunk = marched(replace(given, drive=drive), 2e-5, 50_000, every=500)
    momentum = chunk.angular_momentum
    return np.full_like(momentum, momentum[0]), momentum


@verifies()
def fused_springs() -> Pair:
    """Compare a mass on springs that fuse with its motion in closed form before and after."""
    mass, before, after, rate, limit, dt = 2.0, 8e5, 1e5, 3.0, 2e3, 1e-6
    fast, slow = np.sqrt(before / mass), np.sqrt(after / mass)
    centre = np.eye(2) / np.sqrt(mass)
    rotor = small_rotor(np.full(2, fast), tip_radial=centre[:1], centre=centre)
    start = {"rotor": np.zeros(2), "rotor_velocity": np.array([np.sqrt(mass) * rate, 0.0])}
    given = problem(rotor, wall(1e3), start=start)
    springs = (np.full(2, before), np.full(2, after), np.zeros(2))
    chunk = marched(with_fuse(given, *springs, limit), dt, 60_000, every=500)
    instant = np.arcsin(limit / before * fast / rate) / fast
    instant = dt * np.ceil(instant / dt)  # the step that follows
    place, velocity = rate / fast * np.sin(fast * instant), rate * np.cos(fast * instant)
    since = chunk.time - instant
    later = place * np.cos(slow * since) + velocity / slow * np.sin(slow * since)
    exact = np.where(since < 0.0, rate / fast * np.sin(fast * chunk.time), later)
    return exact, chunk.rotor_displacement @ given.rotor.centre[0]


@verifies()
def place_after_a_loss() -> Pair:
    """Compare the steady displacement of the shaft after the loss of a blade, far above the
    critical speed, with that of a rigid disk on springs: e Omega^2 / (Omega^2 - omega^2) with the
    eccentricity e of what remains."""
    stiffness, speed = 4e4, 80.0
    blade = {"length": 0.2, "root": 0.3, "area": 1e-3, "density": 7800.0}
    changes = {
        "bladed_disk.blades": 13,
        "bladed_disk.elements_per_blade": 3,
        "bladed_disk.disk_radius": blade["root"],
        "bladed_disk.disk.thickness": 0.1,
        "reduction.fixed_interface_modes": 110,
        "rotation.effects": "full",
        "excitation": {"type": "none"},
        "shaft.stiffness": stiffness,
        "casing.clearance": 0.05,
        "march.speed": f"{speed} rad/s",
        "march.time_step": 2e-7,
        "march.record_step": 1e-5,
        "blade_loss": {"blade": 4, "time": 0.01},
    }
    stage = build_beams(with_values(Case(), changes))
    loss = contact_problem(stage).loss
    assert loss is not None
    rotor = loss.after.rotor
    force = np.sum([load.rotor for load in loss.after.loads], axis=0)
    moved = float(np.hypot(*(rotor.centre @ (force / rotor.stiffness))))
    lost = blade["length"] * blade["area"] * blade["density"]
    mass = stage.disk.model.mass - lost
    arm = blade["root"] + 0.5 * blade["length"]
    return lost * arm * speed**2 / (mass * speed**2 - stiffness), moved
