"""Periodic motions: an oscillator with an elastic stop without mass."""

import numpy as np
from scipy.optimize import brentq

from bladewhirl.solvers.periodic.blade import Blade, Grid
from bladewhirl.solvers.periodic.contact import Motion, solve
from bladewhirl.solvers.periodic.stability import monodromy
from bladewhirl.studies.verification.case import Pair, verifies

STOP = 25.0  #: stiffness of the stop divided by that of the oscillator
INSTANTS = 1024  #: instants in a period
PUSH = 1e-3  #: small force that moves the frequency to both sides by the same amount
DAMPING = 0.1  #: damping of the damped oscillator [1/s]


def oscillator(speed: float, force: float, damping: float = 0.0) -> Blade:
    """Return a mass of unit frequency with an elastic stop at the distance 1."""
    return Blade(
        stiffness=np.ones(1),
        damping=np.full((1, 1), damping),
        contact=np.array([[1.0], [0.0], [0.0]]),
        compliance=np.eye(3) / STOP,
        angle=np.zeros(1),
        radius=np.ones(1),
        recess=np.zeros(1),
        normal_part=np.ones(1),
        clearance=np.tile([1.0, 0.0], (8, 1)),
        wall_step=1.0,
        loads={1: np.array([force + 0j])},
        speed=speed,
        friction=0.0,
        turns=False,
        lobes=1,
    )


def pressed(speed: float, force: float, ratio: float, damping: float = 0.0) -> Motion:
    """Return the periodic motion near a free vibration of an amplitude `ratio`."""
    stiff = 1.0 + STOP
    rest = STOP / stiff  # of the mass in contact
    farthest = rest + np.sqrt((ratio**2 - 1.0) / stiff + (1.0 - rest) ** 2)
    grid = Grid(oscillator(speed, force, damping), INSTANTS)
    half = 0.5 * grid.blade.period
    phase = np.clip(np.sqrt(stiff) * ((grid.time + half) % (2.0 * half) - half), -np.pi, np.pi)
    normal = np.maximum(0.0, STOP * (rest + (farthest - rest) * np.cos(phase) - 1.0))
    return solve(Motion(grid, normal[:, None], np.zeros((INSTANTS, 1))))


@verifies("1.2", "2", "5")
def backbone(ratio: str) -> Pair:
    """Compare the frequency of free vibration with the times of its two parts."""
    a, stiff = float(ratio), 1.0 + STOP
    beyond = np.arctan(1.0 / np.sqrt(stiff * (a**2 - 1.0)))
    parts = np.pi - np.arccos(1.0 / a) + (0.5 * np.pi - beyond) / np.sqrt(stiff)
    exact = np.pi / parts

    def excess(speed: float, force: float) -> float:
        return float(-pressed(speed, force, a).modes[0].min()) - a

    near = exact * (1.0 - 4e-3), exact * (1.0 + 4e-3)
    found = [brentq(excess, *near, args=(force,), xtol=1e-12) for force in (PUSH, -PUSH)]
    return float(exact), float(np.mean(found))


@verifies()
def volume_of_deviations() -> Pair:
    """Compare the product of the multipliers in contact with the decay of volumes in phase space,
    which depends on the damping only."""
    motion = pressed(1.25, 0.3, 2.0, DAMPING)
    product = np.prod(monodromy(motion).multipliers)
    return float(np.exp(-DAMPING * motion.grid.blade.period)), float(product.real)
