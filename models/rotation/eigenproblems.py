"""Eigenproblems of matrices that turn: with Coriolis forces, with damping, and over the speed."""

from __future__ import annotations

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp
import scipy.sparse.linalg as spla
from numpy.typing import NDArray

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray, IntArray

Matrix = NDArray[np.inexact]
"""Dense, real or complex, (n, n)."""


def gyroscopic_eigen(
    mass: Matrix, stiffness: Matrix, gyroscopic: Matrix
) -> tuple[ComplexArray, ComplexArray]:
    """All w and p of (-w^2 M + i w G + K) p = 0.

    While K is positive definite the problem is Hermitian in (w p, p), so all w are real.

    Args:
        mass: Hermitian, positive definite.
        stiffness: Hermitian.
        gyroscopic: skew-Hermitian, Coriolis forces by velocity.

    Returns:
        w descending by their real part (2 n,), vectors with p^H M p = 1, (n, 2 n).
    """
    matrix, momenta, hermitian = _linearised(mass, stiffness, gyroscopic)
    w, fields = la.eigh(matrix) if hermitian else la.eig(matrix)
    first, second = np.split(fields, 2)
    at_rest = ~first.any(axis=0)  # where the stiffness is exactly singular
    vectors = momenta @ np.where(at_rest, second, first)
    vectors /= np.sqrt(np.einsum("im,ij,jm->m", vectors.conj(), mass, vectors).real)
    order = _descending(w)
    return w[order].astype(np.complex128), vectors[:, order].astype(np.complex128, copy=False)


def gyroscopic_frequencies(mass: Matrix, stiffness: Matrix, gyroscopic: Matrix) -> ComplexArray:
    """Return only the eigenvalues w of `gyroscopic_eigen`, (2 n,)."""
    matrix, _, hermitian = _linearised(mass, stiffness, gyroscopic)
    w = la.eigvalsh(matrix) if hermitian else la.eigvals(matrix)
    return np.asarray(w[_descending(w)].astype(np.complex128))


def _linearised(mass: Matrix, stiffness: Matrix, gyroscopic: Matrix) -> tuple[Matrix, Matrix, bool]:
    """Linearise the quadratic eigenproblem.

    Returns:
        a matrix with the eigenvalues w; the map from the first half of its eigenvectors to fields;
        and whether the matrix is Hermitian, that is, the stiffness is positive definite. The
        eigenvector of w consists of p and root(K) p / w, both in the eigenbasis of the stiffness.
    """
    size, inverse = len(mass), _inverse_root(mass)
    turned = 1j * inverse @ gyroscopic @ inverse.conj().T
    square, axes = la.eigh(_hermitian(inverse @ stiffness @ inverse.conj().T))
    root = np.diag(np.sqrt(np.abs(square)))
    upper = np.hstack([axes.conj().T @ turned @ axes, root * np.sign(square)])
    matrix = np.vstack([upper, np.hstack([root, np.zeros((size, size))])])
    return matrix, inverse.conj().T @ axes, bool(square[0] > 0.0)


def _descending(w: ComplexArray) -> IntArray:
    return np.lexsort([w.imag, -w.real])


def modal_damping(mass: Matrix, stiffness: Matrix, ratio: float) -> Matrix:
    """Damping matrix that gives every mode of a structure the same ratio, (n, n).

    Args:
        mass: Hermitian, positive definite.
        stiffness: of strain alone, Hermitian; squares below zero are rounding.
        ratio: of each mode.
    """
    squares, modes = la.eigh(stiffness, mass)
    weighted = mass @ modes
    return np.asarray(
        (weighted * (2.0 * ratio * np.sqrt(np.maximum(squares, 0.0)))) @ weighted.conj().T
    )


def damped_eigenvalues(
    mass: Matrix, damping: Matrix, stiffness: Matrix
) -> tuple[ComplexArray, ComplexArray]:
    """All s and p of (s^2 M + s D + K) p = 0: growth rates and frequencies.

    Args:
        mass: Hermitian, positive definite.
        damping: forces by velocity, Coriolis forces among them.
        stiffness: any; a damper that does not turn makes it unsymmetric.

    Returns:
        s (2 n,), vectors (n, 2 n).
    """
    inverse = _inverse_root(mass)
    damped, elastic = (inverse @ each @ inverse.conj().T for each in (damping, stiffness))
    scale = np.sqrt(la.norm(elastic, 2))  # s is of order one over it
    top = np.hstack([-damped / scale, -elastic / scale**2])
    s, states = la.eig(np.vstack([top, np.eye(len(mass), 2 * len(mass))]))
    return scale * s, inverse.conj().T @ states[len(mass) :]


def lowest_gyroscopic_eigen(
    mass: sp.csr_array, stiffness: sp.csr_array, gyroscopic: sp.csr_array, count: int
) -> tuple[ComplexArray, ComplexArray]:
    """The w nearest to zero, as `gyroscopic_eigen` finds all, of large sparse matrices.

    Args:
        mass: symmetric, positive definite.
        stiffness: symmetric, not singular.
        gyroscopic: skew.
        count: how many.
    """
    size = mass.shape[0]
    solve = spla.splu(stiffness.tocsc()).solve

    def inverse(state: ComplexArray) -> ComplexArray:
        momentum, field = state[:size], state[size:]
        force = mass @ momentum - 1j * (gyroscopic @ field)
        return np.concatenate([field, solve(force.real) + 1j * solve(force.imag)])

    operator = spla.LinearOperator((2 * size, 2 * size), matvec=inverse, dtype=np.complex128)
    inverted, states = spla.eigs(operator, k=count, v0=np.ones(2 * size, dtype=np.complex128))
    w, vectors = 1.0 / inverted, states[size:]
    vectors = vectors / np.sqrt(np.einsum("im,im->m", vectors.conj(), mass @ vectors).real)
    order = _descending(w)
    return w[order], vectors[:, order]


def positive_speeds(stiffness: Matrix, pulled: Matrix) -> tuple[FloatArray, ComplexArray]:
    """All Omega > 0 and x of K x = Omega^2 P x.

    Args:
        stiffness: K at rest, Hermitian, positive definite.
        pulled: P, Hermitian.

    Returns:
        Omega ascending [rad/s] (m,), vectors (n, m).
    """
    share, vectors = la.eigh(_hermitian(pulled), stiffness)
    positions = np.flatnonzero(share > share[-1] * len(share) * np.finfo(np.float64).eps)[::-1]
    return 1.0 / np.sqrt(share[positions]), vectors[:, positions]


def _inverse_root(mass: Matrix) -> Matrix:
    """Inverse of the lower Cholesky factor of the mass matrix."""
    root = la.cholesky(mass, lower=True)
    return np.asarray(la.solve_triangular(root, np.eye(len(mass)), lower=True))


def _hermitian(matrix: Matrix) -> Matrix:
    return np.asarray((matrix + matrix.conj().T) / 2.0)
