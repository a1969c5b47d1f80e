"""Friction joints and tips at a wall: oscillators with a Jenkins damper, a spring that slides, or
with an elastic stop that moves."""

import numpy as np

from bladewhirl.models.joints.wheel import JointedWheel
from bladewhirl.solvers.periodic.joint_search import joint_motion
from bladewhirl.studies.verification.case import Pair, verifies

SOFT = 10.0  #: flexibility of each side of a damper with a fifth of the stiffness
RATIO = 1e-3  #: damping ratio
STIFF = 1e-5  #: flexibility of each side of a damper that is hardly elastic
SLIDING_AT = 1.05  #: frequency at which the damper slides
STOP, DAMPED = 0.2, 0.1  #: flexibility of a stop, and damping ratio of an oscillator with it
STEPS, PERIODS = 2000, 60  #: steps of a period and periods of a time integration


def oscillator(speed: float, limit: float, soft: float, ratio: float = 0.0) -> JointedWheel:
    """Return two oscillators of unit mass and stiffness that move against each other under forces
    of unit amplitude: a joint on both sides of each slides at half the `limit` of the friction on
    it, and each side has the flexibility `soft`."""
    contact = np.zeros((1, 6, 1))
    contact[0, [1, 4], 0] = 1.0, -1.0
    compliance = np.zeros((1, 6, 1, 6))
    own = np.arange(6)
    compliance[0, own, 0, own] = np.where(own % 3 == 0, 0.5, soft)
    return JointedWheel(
        names=("friction",),
        joint=np.zeros(1, dtype=np.int64),
        friction=np.array([0.5 * limit]),
        gap=np.array([-1.0]),
        speed=speed,
        blades=2,
        stiffness=np.ones((2, 1)),
        damping=np.full((2, 1, 1), 2.0 * ratio),
        contact=contact,
        compliance=compliance,
        loads={1: np.ones(1, dtype=np.complex128)},
        static={1: np.zeros(6, dtype=np.complex128)},
        points=np.array([[0.0], [1.0], [0.0]]),
        loaded=(0,),
        points_by_force=np.zeros((3, 1, 6)),
    )


def amplitude(given: JointedWheel) -> float:
    """Return the amplitude of the first harmonic of an oscillator."""
    found = joint_motion(given)
    return float(np.abs(given.at_points(1, found.of_order(1))[0, 1]))


@verifies("0.9", "1.2")
def stuck_damper(speed: str) -> Pair:
    """Compare the amplitude with a damper that does not slide with that of two springs."""
    r = float(speed)
    exact = 1.0 / abs(1.0 + 2.0 / SOFT - r**2 + 2j * RATIO * r)
    return exact, amplitude(oscillator(r, 1e3, SOFT, RATIO))


@verifies("0.8:0.5", "0.9:0.5", "1.2:0.3", "1.5:0.5")
def dry_friction(point: str) -> Pair:
    """Compare the largest displacement with dry friction of a ratio of the force at a frequency
    with the closed form of motions without rest (Den Hartog 1931)."""
    r, f = (float(each) for each in point.split(":"))
    elastic = 1.0 / (1.0 - r**2)
    rubbed = np.sin(np.pi / r) / (r * (1.0 + np.cos(np.pi / r)))
    exact = float(np.sqrt(elastic**2 - (f * rubbed) ** 2))
    found = joint_motion(oscillator(r, f, STIFF)).of_points
    return exact, float(np.abs(found[:, 0, 1]).max())


@verifies("1.2", "1.5")
def sliding_damper(limit: str) -> Pair:
    """Compare the amplitude with a damper that slides with that of a time integration in which the
    slider moves as soon as its limit is reached."""
    force, r = float(limit), SLIDING_AT
    period, stiff = 2.0 * np.pi / r, 2.0 / SOFT
    step = period / STEPS
    wave = np.exp(1j * r * step * np.arange(STEPS))
    place = rate = slider = 0.0
    for _ in range(PERIODS):
        seen = 0.0j
        for now in wave.tolist():
            held = stiff * (place - slider)
            if abs(held) > force:
                held = force if held > 0.0 else -force
                slider = place - held / stiff
            rate += step * (now.real - place - held - 2.0 * RATIO * rate)
            place += step * rate
            seen += place * now.conjugate()
    return 2.0 * abs(seen) / STEPS, amplitude(oscillator(r, force, SOFT, RATIO))


@verifies("0.8:0.2", "1.5:0.8")
def moving_stop(point: str) -> Pair:
    """Compare the amplitude of an oscillator that a wavy wall pushes, at a frequency and with a
    mean gap relative to the wave, with that of a time integration."""
    r, gap = (float(each) for each in point.split(":"))
    compliance = np.zeros((1, 6, 1, 6))
    compliance[0, range(3, 6), 0, range(3, 6)] = STOP
    contact = np.zeros((1, 6, 1))
    contact[0, 3, 0] = -1.0
    given = JointedWheel(
        names=("wall",),
        joint=np.zeros(1, dtype=np.int64),
        friction=np.zeros(1),
        gap=np.array([gap]),
        speed=r,
        blades=1,
        stiffness=np.ones((1, 1)),
        damping=np.full((1, 1, 1), 2.0 * DAMPED),
        contact=contact,
        compliance=compliance,
        loads={},
        static={},
        points=np.array([[1.0], [0.0], [0.0]]),
        loaded=(0,),
        points_by_force=np.zeros((3, 1, 6)),
        wall={1: np.ones(1, dtype=np.complex128)},
        radius=np.ones(1),
    )
    found = given.at_points(1, joint_motion(given).of_order(1))[0, 0]
    step = 2.0 * np.pi / r / STEPS
    wave = np.exp(1j * r * step * np.arange(STEPS))
    place, seen = 0.0, 0.0j
    rate = 0.0
    for _ in range(PERIODS):
        seen = 0.0j
        for now in wave.tolist():
            pushed = max(0.0, place - gap - now.real) / STOP
            rate += step * (-place - pushed - 2.0 * DAMPED * rate)
            place += step * rate
            seen += place * now.conjugate()
    return 2.0 * abs(seen) / STEPS, float(abs(found))
