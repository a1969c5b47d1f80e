"""Matrices of a rotating structure at a speed and on a basis."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp

from bladewhirl.models.structure.eigenproblems import damped_eigenvalues
from bladewhirl.models.structure.rotating import Effects, Rotating

AXES = np.array([[0.0, -1.0], [1.0, 0.0]])


def mass_on_a_spring(mass: float, stiffness: float) -> Rotating[np.ndarray]:
    one = np.eye(2)
    return Rotating(
        mass=mass * one,
        stiffness=stiffness * one,
        stiffness_speed=-mass * one,
        gyroscopic=2.0 * mass * AXES,
    )


@pytest.mark.parametrize("omega", [30.0, 70.0, -30.0])
def test_rotating_axes_shift_the_frequencies_of_a_mass_on_a_spring(omega: float) -> None:
    """In axes at rest it swings at 50 rad/s in any direction."""
    turning = mass_on_a_spring(2.0, 2.0 * 50.0**2).at(omega)
    exponents, _ = damped_eigenvalues(turning.mass, turning.drag(omega), turning.stiffness)
    assert np.sort(np.abs(exponents.imag))[::2] == pytest.approx(
        np.sort([abs(50.0 - omega), abs(50.0 + omega)])
    )


@pytest.mark.parametrize("sparse", [True, False])
def test_a_structure_at_a_speed_knows_that_at_others(sparse: bool) -> None:
    first, second, fourth = (np.diag(row) for row in np.arange(1.0, 10.0).reshape(3, 3))
    kind = sp.csr_array if sparse else np.asarray
    rest = Rotating(
        mass=kind(np.eye(3)),
        stiffness=kind(1e4 * first),
        stiffness_speed=kind(second),
        stiffness_speed4=kind(1e-4 * fourth),
    )
    at_speed = rest.at(40.0)
    exact = 1e4 * first + 60.0**2 * second + 1e-4 * 60.0**4 * fourth
    for given in (rest, at_speed):
        stiffness = given.stiffness_at(60.0)
        assert (stiffness.toarray() if sparse else stiffness) == pytest.approx(exact, rel=1e-14)
    steps = rest.stiffness_at(60.001) - rest.stiffness_at(59.999)
    slope = rest.slope(60.0) - steps / (60.001**2 - 59.999**2)
    assert abs(slope).max() < 1e-6


@pytest.mark.parametrize(
    ("effects", "kept"),
    [
        ("none", set()),
        ("centrifugal", {"stiffness_speed"}),
        ("full", {"stiffness_speed", "gyroscopic"}),
    ],
)
def test_effects_of_the_rotation_leave_matrices_out(effects: Effects, kept: set[str]) -> None:
    given = mass_on_a_spring(1.0, 1.0).under(effects)
    assert set(given.given(("gyroscopic", "stiffness_speed"))) == kept
    assert not given.known("gyroscopic").any() or "gyroscopic" in kept


def test_energies_and_works_are_the_same_on_a_complex_basis() -> None:
    chance = np.random.default_rng(3)
    basis = chance.normal(size=(2, 3)) + 1j * chance.normal(size=(2, 3))
    whole = replace(mass_on_a_spring(1.5, 7.0), centrifugal_load=np.array([2.0, -1.0]))
    small, q = whole.on(basis), chance.normal(size=3)
    x = basis @ q
    for name in ("mass", "stiffness", "stiffness_speed", "gyroscopic"):
        energy = x.conj() @ getattr(whole, name) @ x
        assert q @ getattr(small, name) @ q == pytest.approx(energy)
    assert small.loads[:, 0].conj() @ q == pytest.approx(whole.loads[:, 0] @ x)
    skew = small.drag(1.0)
    np.testing.assert_array_equal(skew, -skew.conj().T)
