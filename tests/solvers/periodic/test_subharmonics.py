"""Motions whose period is several periods of the drive, against time integration."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from bladewhirl.solvers.periodic.blade import Grid
from bladewhirl.solvers.periodic.contact import Motion
from bladewhirl.solvers.periodic.search import periodic_motion, refined
from bladewhirl.solvers.periodic.stability import monodromy
from bladewhirl.studies.verification.periodic import STOP, oscillator

FORCE, SPEED, DAMPING = 5.0, 2.8, 0.1
INSTANTS = 512


def integrated() -> tuple[np.ndarray, np.ndarray]:
    """Displacement and contact force of the oscillator at the instants of two periods, a hundred
    periods after it was released from rest."""
    period = 2.0 * np.pi / SPEED

    def rate(time: float, state: np.ndarray) -> list[float]:
        q, v = state
        push = FORCE * np.cos(SPEED * time) - STOP * max(0.0, q - 1.0)
        return [v, push - DAMPING * v - q]

    instants = period * (100.0 + np.arange(INSTANTS) * 2.0 / INSTANTS)
    done = solve_ivp(
        rate,
        (0.0, 102.0 * period),
        [0.0, 0.0],
        t_eval=instants,
        rtol=1e-8,
        atol=1e-10,
        max_step=0.05,
    )
    return done.y[0], STOP * np.maximum(0.0, done.y[0] - 1.0)


@pytest.mark.slow
def test_a_subharmonic_is_that_of_time_integration() -> None:
    """Two motions exist: one with the period of the force, without contact, and one with twice this
    period, to which the oscillator comes from rest."""
    blade = replace(oscillator(SPEED, FORCE, DAMPING), periods=2)
    q, force = integrated()
    start = Motion(Grid(blade, INSTANTS), force[:, None], np.zeros((INSTANTS, 1)))
    motion = periodic_motion(blade, start)
    assert motion.touches
    assert not motion.repeats
    every = motion.grid.instants // INSTANTS
    assert motion.modes[0][::every, 0] == pytest.approx(q, abs=2e-3 * np.abs(q).max())
    assert motion.impulse == pytest.approx(force.sum() * 2.0 * np.pi / SPEED / INSTANTS, rel=1e-3)
    multipliers = monodromy(motion).multipliers
    assert np.abs(multipliers).max() < 1.0
    # two periods of the decay of volumes in phase space
    assert np.prod(multipliers).real == pytest.approx(
        np.exp(-DAMPING * 4.0 * np.pi / SPEED), rel=1e-3
    )
    assert not periodic_motion(blade).touches


def test_a_motion_of_one_period_repeats_in_two() -> None:
    one = oscillator(2.2, FORCE, DAMPING)
    found = periodic_motion(one)
    assert found.touches
    assert not found.repeats
    twice = replace(one, periods=2)
    normal = np.tile(found.normal, (2, 1))
    start = Motion(Grid(twice, len(normal)), normal, np.zeros_like(normal))
    again = refined(start)
    assert again.repeats
    assert again.impulse == pytest.approx(found.impulse, rel=1e-4)
