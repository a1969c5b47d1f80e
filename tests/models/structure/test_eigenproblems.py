"""Eigenproblems of random matrices: what is found solves them, is complete and in order."""

import numpy as np
import pytest
import scipy.linalg as la
import scipy.sparse as sp

from bladewhirl.models.structure.eigenproblems import (
    Matrix,
    damped_eigenvalues,
    gyroscopic_eigen,
    gyroscopic_frequencies,
    lowest_gyroscopic_eigen,
    modal_damping,
    positive_speeds,
)

SIZE = 5


def hermitian(squares: list[float], seed: int, *, real: bool = False) -> Matrix:
    """A matrix with given eigenvalues."""
    chance = np.random.default_rng(seed)
    drawn = chance.normal(size=(len(squares), len(squares)))
    axes = la.qr(drawn if real else drawn + 1j * chance.normal(size=drawn.shape))[0]
    return np.asarray(axes * np.array(squares) @ axes.conj().T)


MASS = hermitian([1.0, 1.5, 2.0, 2.5, 3.0], 1)
CORIOLIS = 1j * hermitian([-0.9, -0.2, 0.1, 0.5, 0.7], 2)


@pytest.mark.parametrize("lowest", [4.0, -4.0, -0.01])
def test_waves_of_matrices_that_turn(lowest: float) -> None:
    """Also where one square is negative: then they come in complex pairs, or Coriolis holds."""
    stiffness = hermitian([lowest, 9.0, 16.0, 25.0, 36.0], 3)
    w, p = gyroscopic_eigen(MASS, stiffness, CORIOLIS)
    assert p.shape == (SIZE, 2 * SIZE)
    residual = -(MASS @ p) * w**2 + 1j * (CORIOLIS @ p) * w + stiffness @ p
    assert np.abs(residual).max() < 1e-11
    np.testing.assert_allclose(np.einsum("im,ij,jm->m", p.conj(), MASS, p), 1.0)
    assert np.all(np.diff(w.real) <= 1e-12)
    assert len(np.unique(np.round(w, 9))) == 2 * SIZE
    np.testing.assert_allclose(gyroscopic_frequencies(MASS, stiffness, CORIOLIS), w, atol=1e-11)
    if lowest > 0.0:
        assert not w.imag.any()
        assert np.count_nonzero(w.real > 0.0) == SIZE


@pytest.mark.parametrize("coriolis", [0.0, 0.5, -0.5])
def test_what_nothing_holds_stands_still(coriolis: float) -> None:
    """A stiffness that is exactly singular: w = 0, and with Coriolis forces w = g / m beside it."""
    mass, stiffness = np.diag([2.0, 1.0]), np.diag([0.0, 9.0])
    w, p = gyroscopic_eigen(mass, stiffness, 1j * np.diag([coriolis, 0.0]))
    np.testing.assert_allclose(w, sorted([3.0, -coriolis / 2.0, 0.0, -3.0], reverse=True))
    np.testing.assert_allclose(np.abs(p[0]), [0.0, np.sqrt(0.5), np.sqrt(0.5), 0.0], atol=1e-15)
    np.testing.assert_allclose(np.abs(p[1]), [1.0, 0.0, 0.0, 1.0], atol=1e-15)


def test_every_mode_gets_the_same_share_of_critical_damping() -> None:
    stiffness = hermitian([4.0, 9.0, 16.0, 25.0, 36.0], 3)
    damping = modal_damping(MASS, stiffness, 0.02)
    s, p = damped_eigenvalues(MASS, damping, stiffness)
    np.testing.assert_allclose(-s.real, 0.02 * np.abs(s))
    squares = la.eigvalsh(stiffness, MASS)
    np.testing.assert_allclose(np.sort(np.abs(s))[::2] ** 2, squares)
    np.testing.assert_allclose(
        np.linalg.norm((MASS @ p) * s**2 + damping @ p * s + stiffness @ p), 0.0, atol=1e-11
    )


def test_the_lowest_waves_of_sparse_matrices_are_those_of_full_ones() -> None:
    size = 30
    mass = sp.csr_array(hermitian(list(np.linspace(1.0, 2.0, size)), 4, real=True))
    stiffness = sp.csr_array(hermitian(list(np.linspace(2.0, 20.0, size) ** 2), 5, real=True))
    skew = np.random.default_rng(6).normal(size=(size, size))
    coriolis = sp.csr_array(skew - skew.T)
    w, p = lowest_gyroscopic_eigen(mass, stiffness, coriolis, 6)
    whole = gyroscopic_frequencies(*(each.toarray() for each in (mass, stiffness, coriolis)))
    np.testing.assert_allclose(w, whole[size - 3 : size + 3], atol=1e-9)
    residual = -(mass @ p) * w**2 + 1j * (coriolis @ p) * w + stiffness @ p
    assert np.abs(residual).max() < 1e-8
    np.testing.assert_allclose(np.einsum("im,im->m", p.conj(), mass @ p), 1.0)


@pytest.mark.parametrize("pulled", [[-2.0, -1.0, 0.0, 1.0, 3.0], [0.5, 1.0, 1.5, 2.0, 3.0]])
def test_all_positive_speeds_are_found(pulled: list[float]) -> None:
    stiffness, pull = hermitian([4.0, 9.0, 16.0, 25.0, 36.0], 3), hermitian(pulled, 7)
    omega, x = positive_speeds(stiffness, pull)
    assert len(omega) == sum(value > 0.0 for value in pulled)  # as many, by Sylvester's law
    assert np.all(np.diff(omega) > 0.0)
    assert np.abs(stiffness @ x - (pull @ x) * omega**2).max() < 1e-11
