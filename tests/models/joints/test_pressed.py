"""Static normal forces of joints."""

import numpy as np
import pytest

from bladewhirl.models.joints.pressed import NoStaticForces, pressed


def test_forces_close_gaps_or_are_zero() -> None:
    random = np.random.default_rng(3)
    for _ in range(50):
        half = random.normal(size=(6, 6))
        flexible, gap = half @ half.T + 0.5 * np.eye(6), random.normal(size=6)
        force = pressed(flexible, gap)
        after = gap + flexible @ force
        assert (force >= 0.0).all()
        assert (after > -1e-12).all()
        assert abs(force * after).max() < 1e-12


def test_forces_that_do_not_exist_are_an_error() -> None:
    with pytest.raises(NoStaticForces):
        pressed(np.array([[1.0, -2.0], [-2.0, 1.0]]), np.array([-1.0, -1.0]))
