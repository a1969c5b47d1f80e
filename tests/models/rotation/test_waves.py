"""Speeds at which waves on a turning disk meet others, by the frequencies that they have there."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from stages import bladed_disk

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.models.modal.whirl_modes import whirl_modes
from bladewhirl.models.rotation.matrices import rotation_matrices
from bladewhirl.models.structure.rotating import Effects
from bladewhirl.models.structure.waves import Waves


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
        gyroscopic=np.asarray(0.2 * (coriolis - coriolis.conj().T)),
        stiffness_speed=hermitian(0.05),
        springs=np.diag([1.0, 0.0, 0.0]).astype(np.complex128),
    )


def distance(waves: Waves, speed: float, frequency: float) -> float:
    return float(np.abs(waves.frequencies(speed) - frequency).min())


def crossings(waves: Waves, line: FloatArray, speeds: FloatArray) -> FloatArray:
    """Speeds near which branches cross a line of frequencies over the speed, ascending."""
    above = np.array([waves.frequencies(speed).real for speed in speeds]) > line[:, None]
    return np.repeat(speeds[1:], np.abs(np.diff(above, axis=0)).sum(axis=1))


def test_the_fourth_power_of_the_speed_stiffens_a_wave() -> None:
    one = np.ones((1, 1), dtype=np.complex128)
    parts: Any = {
        "mass": one,
        "stiffness": 4e4 * one,
        "gyroscopic": 0.0 * one,
        "stiffness_speed": 0.5 * one,
    }
    wave = Waves(nodal_diameter=0, springs=0.0 * one, stiffness_speed4=1e-5 * one, **parts)
    exact = np.sqrt(4e4 + 0.5 * 200.0**2 + 1e-5 * 200.0**4)
    assert wave.frequencies(200.0).real == pytest.approx([exact, -exact])


@pytest.mark.parametrize("order", [0, 1, 3])
def test_at_a_synchronous_speed_a_wave_has_that_multiple_of_it(waves: Waves, order: int) -> None:
    speeds, _ = waves.synchronous(order)
    assert len(speeds) > 0 or order == 0
    for speed in speeds:
        assert distance(waves, speed, order * speed) < 1e-9


def test_a_speed_follows_the_springs_by_their_share_of_the_energy(waves: Waves) -> None:
    """Its square, in proportion: the derivative of a Rayleigh quotient."""
    speeds, shares = waves.synchronous(3)
    stiffer = replace(waves, stiffness=waves.stiffness + 1e-6 * waves.springs)
    gained = (stiffer.synchronous(3)[0] / speeds) ** 2 - 1.0
    np.testing.assert_allclose(gained, 1e-6 * shares, rtol=1e-4)
    assert shares.max() < 1.0


@pytest.mark.parametrize("casing", [0.5, 2.0])
def test_where_waves_meet_one_keeps_pace_with_the_casing_s(waves: Waves, casing: float) -> None:
    speeds = waves.meeting(casing, 10.0)
    assert len(speeds) > 0
    for speed in speeds:
        assert distance(waves, speed, waves.nodal_diameter * speed - casing) < 1e-9


@pytest.mark.slow
def test_no_speed_is_left_out(waves: Waves) -> None:
    speeds = np.linspace(1e-3, 5.0, 1601)
    for casing in (0.5, 2.0):
        seen = crossings(waves, 3 * speeds - casing, speeds)
        seen = seen[3 * seen > casing]
        np.testing.assert_allclose(waves.meeting(casing, 5.0), seen, atol=5e-3)
        np.testing.assert_array_equal(waves.meeting(casing, seen[0] - 5e-3), [])
    actual, _ = waves.synchronous(3)
    np.testing.assert_allclose(actual, crossings(waves, 3 * speeds, speeds), atol=5e-3)


def test_branches_are_ranked_from_the_lowest_both_ways(waves: Waves) -> None:
    actual = [waves.rank(0.3, w) for w in waves.frequencies(0.3).real]
    assert actual == [(rank, True) for rank in (2, 1, 0)] + [(rank, False) for rank in (0, 1, 2)]


@pytest.mark.parametrize("effects", ["none", "centrifugal", "full"])
def test_waves_of_a_bladed_disk_have_the_frequencies_of_its_modes(effects: Effects) -> None:
    matrices = rotation_matrices(bladed_disk())
    modes = whirl_modes(matrices.at(300.0, effects))
    signs = {"backward": 1.0, "forward": -1.0}
    own = modes.take(np.flatnonzero(modes.nodal_diameter == 2))
    signed = [signs[way] * w for way, w in zip(own.direction, own.frequency, strict=True)]
    of_two = matrices.wave(2).under(effects).frequencies(300.0)
    np.testing.assert_allclose(np.sort(signed), of_two.real[::-1], rtol=1e-8)
