"""Speeds at which waves on a turning disk meet others, by the frequencies that they have there."""

from __future__ import annotations

import numpy as np
import pytest

from bladewhirl.meshes.line_mesh import ComplexArray
from bladewhirl.models.rotation.waves import Waves


@pytest.fixture
def waves() -> Waves:
    """Hermitian matrices of three waves that soften little, with Coriolis forces."""
    chance = np.random.default_rng(4)

    def drawn() -> ComplexArray:
        return np.asarray(chance.normal(size=(3, 3)) + 1j * chance.normal(size=(3, 3)))

    def hermitian(size: float) -> ComplexArray:
        made = drawn()
        return np.asarray(size * (made + made.conj().T))

    coriolis = drawn()
    return Waves(
        nodal_diameter=3,
        mass=2.0 * np.eye(3) + hermitian(0.1),
        stiffness=np.diag([4.0, 9.0, 16.0]) + hermitian(0.1),
        coriolis=np.asarray(0.1 * (coriolis - coriolis.conj().T)),
        softening=hermitian(0.05),
    )


def distance(waves: Waves, speed: float, frequency: float) -> float:
    return float(np.abs(waves.frequencies(speed) - frequency).min())


@pytest.mark.parametrize("order", [0, 1, 3])
def test_at_a_synchronous_speed_a_wave_has_that_multiple_of_it(waves: Waves, order: int) -> None:
    speeds = waves.synchronous(order)
    assert len(speeds) > 0 or order == 0
    for speed in speeds:
        assert distance(waves, speed, order * speed) < 1e-9


@pytest.mark.parametrize("casing", [0.5, 2.0])
def test_where_waves_meet_one_keeps_pace_with_the_casing_s(waves: Waves, casing: float) -> None:
    speeds = waves.meeting(casing, 10.0)
    assert len(speeds) > 0
    for speed in speeds:
        assert distance(waves, speed, waves.nodal_diameter * speed - casing) < 1e-9
