"""A constant gap: the two-degree-of-freedom oscillator with a unilateral spring of NLvib."""

import numpy as np
import pytest
from places import DATA

from bladewhirl.solvers.periodic.blade import Blade, Grid
from bladewhirl.solvers.periodic.contact import Motion
from bladewhirl.solvers.periodic.search import prolonged

SQUARES, SHAPES = np.linalg.eigh(np.array([[1.0, -1.0], [-1.0, 2.0]]))
SPRING, FORCE, DAMPING = 100.0, 0.1, 0.03
INSTANTS = 1024
POINTS = np.loadtxt(DATA / "nlvib_example_03.csv", delimiter=",", skiprows=1)


def oscillator(frequency: float) -> Grid:
    """The first mass meets the spring behind a gap of 1, and a force drives the second one."""
    blade = Blade(
        stiffness=SQUARES,
        damping=np.diag(DAMPING * SQUARES),
        contact=np.vstack([SHAPES[0], np.zeros((2, 2))]),
        compliance=np.eye(3) / SPRING,
        angle=np.zeros(1),
        radius=np.ones(1),
        recess=np.zeros(1),
        normal_part=np.ones(1),
        clearance=np.tile([1.0, 0.0], (8, 1)),
        wall_step=1.0,
        loads={1: FORCE * SHAPES[1] + 0j},
        speed=frequency,
        friction=0.0,
        turns=False,
        lobes=1,
    )
    return Grid(blade, INSTANTS)


@pytest.mark.parametrize("number", range(len(POINTS)))
def test_amplitudes_are_those_of_harmonic_balance(number: int) -> None:
    """On all parts of a branch with two folds, to 1e-4; see nlvib_example_03.m."""
    frequency, second, first, mean, *harmonics = POINTS[number].tolist()
    turn = 2.0 * np.pi * np.arange(INSTANTS) / INSTANTS
    order = np.arange(1, 1 + len(harmonics) // 2)[:, None] * turn
    cosine, sine = np.array(harmonics[0::2]), np.array(harmonics[1::2])
    moved = mean + cosine @ np.cos(order) + sine @ np.sin(order)
    normal = SPRING * np.maximum(0.0, moved - 1.0)[:, None]
    motion = prolonged(Motion(oscillator(frequency), normal, np.zeros_like(normal)))
    assert motion.touches == bool(normal.any())
    own = 2.0 * np.abs(np.fft.rfft(motion.modes[0] @ SHAPES.T, axis=0)[1]) / INSTANTS
    assert own == pytest.approx([first, second], rel=1e-4)
