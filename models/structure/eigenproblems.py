"""Eigenproblems of rotating structures with Coriolis forces or damping, and for critical speeds."""

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp
import scipy.sparse.linalg as spla
from numpy.typing import NDArray

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray, IntArray

Matrix = NDArray[np.inexact]  #: dense matrix, real or complex, (n, n)


def gyroscopic_eigen(
    mass: Matrix, stiffness: Matrix, gyroscopic: Matrix
) -> tuple[ComplexArray, ComplexArray]:
    """Solve (-w^2 M + i w G + K) p = 0 for all w and p.

    If K is positive definite, the problem is Hermitian in (w p, p), so all w are real.

    Args:
        mass: M, Hermitian and positive definite.
        stiffness: K, Hermitian.
        gyroscopic: G, skew-Hermitian matrix of the Coriolis forces.

    Returns:
        w in descending order of the real part, (2 n,), and vectors with p^H M p = 1, (n, 2 n).
    """
    matrix, momenta, hermitian = _linearised(mass, stiffness, gyroscopic)
    w, fields = la.eigh(matrix) if hermitian else la.eig(matrix)
    first, second = np.split(fields, 2)
    at_rest = ~first.any(axis=0)  # modes of an exactly singular stiffness
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
        a matrix with the eigenvalues w; the map from the first half of each eigenvector to a field;
        and true if the matrix is Hermitian, that is, if the stiffness is positive definite. The
        eigenvector of w consists of p and root(K) p / w, both in the eigenbasis of the stiffness.
    """
    size, inverse = len(mass), inverse_root(mass)
    turned = 1j * inverse @ gyroscopic @ inverse.conj().T
    square, axes = la.eigh(_hermitian(inverse @ stiffness @ inverse.conj().T))
    root = np.diag(np.sqrt(np.abs(square)))
    upper = np.hstack([axes.conj().T @ turned @ axes, root * np.sign(square)])
    matrix = np.vstack([upper, np.hstack([root, np.zeros((size, size))])])
    return matrix, inverse.conj().T @ axes, bool(square[0] > 0.0)


def _descending(w: ComplexArray) -> IntArray:
    return np.lexsort([w.imag, -w.real])


def modal_damping(mass: Matrix, stiffness: Matrix, ratio: float) -> Matrix:
    """Return the damping matrix that gives every mode the same damping ratio, (n, n).

    Args:
        mass: mass matrix, Hermitian and positive definite.
        stiffness: elastic stiffness, Hermitian; negative eigenvalues count as zero, because they
            are rounding errors.
        ratio: damping ratio of each mode.
    """
    squares, modes = la.eigh(stiffness, mass)
    weighted = mass @ modes
    return np.asarray(
        (weighted * (2.0 * ratio * np.sqrt(np.maximum(squares, 0.0)))) @ weighted.conj().T
    )


def damped_eigenvalues(
    mass: Matrix, damping: Matrix, stiffness: Matrix
) -> tuple[ComplexArray, ComplexArray]:
    """Solve (s^2 M + s D + K) p = 0 for all s and p.

    The real part of s is the growth rate, the imaginary part is the frequency.

    Args:
        mass: M, Hermitian and positive definite.
        damping: D, matrix of all forces due to velocities, including Coriolis forces.
        stiffness: K, any matrix; a damper fixed in space makes it unsymmetric.

    Returns:
        s (2 n,), and vectors (n, 2 n).
    """
    inverse = inverse_root(mass)
    damped, elastic = (inverse @ each @ inverse.conj().T for each in (damping, stiffness))
    scale = np.sqrt(la.norm(elastic, 2))  # s / scale is of order one
    top = np.hstack([-damped / scale, -elastic / scale**2])
    s, states = la.eig(np.vstack([top, np.eye(len(mass), 2 * len(mass))]))
    return scale * s, inverse.conj().T @ states[len(mass) :]


def lowest_gyroscopic_eigen(
    mass: sp.csr_array, stiffness: sp.csr_array, gyroscopic: sp.csr_array, count: int
) -> tuple[ComplexArray, ComplexArray]:
    """Return the eigenvalues w of `gyroscopic_eigen` that are nearest to zero, and their vectors,
    for large sparse matrices.

    Args:
        mass: mass matrix, symmetric and positive definite.
        stiffness: stiffness matrix, symmetric and not singular.
        gyroscopic: skew matrix of the Coriolis forces.
        count: number of eigenvalues w.
    """
    size = mass.shape[0]
    solve = spla.splu(stiffness.tocsc()).solve

    def inverse(state: ComplexArray) -> ComplexArray:
        momentum, field = state[:size], state[size:]
        force = mass @ momentum - 1j * (gyroscopic @ field)
        return np.concatenate([field, solve(force.real) + 1j * solve(force.imag)])

    operator = spla.LinearOperator((2 * size, 2 * size), matvec=inverse, dtype=np.complex128)
    start = np.random.default_rng(0).standard_normal(2 * size)  # a symmetric start hides modes
    inverted, states = spla.eigs(operator, k=count, v0=start.astype(np.complex128))
    w, vectors = 1.0 / inverted, states[size:]
    vectors = vectors / np.sqrt(np.einsum("im,im->m", vectors.conj(), mass @ vectors).real)
    order = _descending(w)
    return w[order], vectors[:, order]


def positive_speeds(stiffness: Matrix, pulled: Matrix) -> tuple[FloatArray, ComplexArray]:
    """Solve K x = Omega^2 P x for all Omega > 0 and x.

    Args:
        stiffness: stiffness K at rest, Hermitian and positive definite.
        pulled: P, Hermitian.

    Returns:
        Omega in ascending order [rad/s] (m,), and vectors (n, m).
    """
    share, vectors = la.eigh(_hermitian(pulled), stiffness)
    positions = np.flatnonzero(share > share[-1] * len(share) * np.finfo(np.float64).eps)[::-1]
    return 1.0 / np.sqrt(share[positions]), vectors[:, positions]


def inverse_root(mass: Matrix) -> Matrix:
    """Return the inverse of the lower Cholesky factor of a matrix."""
    root = la.cholesky(mass, lower=True)
    return np.asarray(la.solve_triangular(root, np.eye(len(mass)), lower=True))


def _hermitian(matrix: Matrix) -> Matrix:
    return np.asarray((matrix + matrix.conj().T) / 2.0)
