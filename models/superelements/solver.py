"""Lowest modes and static displacements with one sparse factorisation; its cost and progress.

Both follow from one factor, that of the shifted stiffness A = K + s M:

The lowest modes are found by the block Lanczos method with the operator A^-1 M and full
orthogonalisation (Grimes, Lewis and Simon 1994, SIAM J. Matrix Anal. Appl. 15(1)). A block has
several vectors because a factor that is read from memory once solves for eight vectors in the time
of two; ARPACK asks for one vector at a time.

Static displacements without the modes phi, of which some may be rigid, follow from the iteration
x <- x + A^-1 (f - M phi phi^T f - K x). Its error decreases by the factor s / (s + w^2) with the
lowest frequency w of the other modes.
"""

import logging
from abc import ABC, abstractmethod
from typing import Any

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.inputs import progress
from bladewhirl.models.inputs.errors import Fault
from bladewhirl.models.inputs.machine import memory
from bladewhirl.models.superelements.cholesky import Cholesky
from bladewhirl.models.superelements.superelement import Matrix, SuperelementError

logger = logging.getLogger(__name__)

LARGE = 20_000
"""Number of coordinates from which the cost of a reduction is reported."""

FILL = 36.0
"""Number of entries of the factor of a solid with n coordinates, divided by n^(4/3) (measured for
blades and sectors of 6,000 to 65,000 coordinates)."""

FACTOR_SECONDS, SOLVE_SECONDS = 4e-9, 1e-9
"""Time of a factorisation divided by n^2, and time of a solution divided by the number of entries
of the factor [s]; accurate to a factor of three."""

COMPLEX = 2.8  #: time of a complex factorisation divided by that of a real one (measured)

BLOCK = 8  #: number of vectors of a block


CONVERGED = 1e-10
"""Largest residual of a mode, as a fraction of its eigenvalue."""

ROUNDING = 1e-14
"""Residual of all modes that is a rounding error, as a fraction of the largest eigenvalue."""

LOST, DEPENDENT = 1e-28, 1e-15
"""A direction of a block is a rounding error if the square of its norm is at most this fraction of
that before orthogonalisation, or of the largest one in the block."""

INDEFINITE = 1e-8
"""The mass is indefinite if the square of a norm is below minus this fraction of the largest one.
"""

STEPS = 200  #: largest number of steps of the iteration for static displacements

SETTLED, STAGNANT = 1e-13, 1e-8
"""Static displacements have converged if a step changes them by at most the first fraction, or by
at most the second one and no less than the step before, which is then a rounding error."""

EQUAL = 1e-6
"""Frequencies are equal if their squares with the shift differ by at most this fraction."""

TINY = np.finfo(np.float64).tiny

ACTIVITY, NOUN = "reducing the superelement", "solutions of the reduction"
"""Activity whose progress is reported, and its items."""


def lanczos_vectors(modes: int) -> int:
    """Return about how many vectors the lowest modes take (measured for 2 to 100 modes)."""
    return 3 * modes + 4 * BLOCK


def announce(
    coordinates: int,
    modes: int,
    loads: int,
    *,
    waves: int = 1,
    faces: int = 0,
    workers: int = 1,
    tied: bool = False,
) -> None:
    """Log the cost of a large reduction before it starts.

    Args:
        coordinates: number of coordinates.
        modes: number of modes.
        loads: number of static solutions.
        waves: number of nodal diameters of a sector, whose vectors are complex; 1 for other
            structures, whose vectors are real.
        faces: number of coordinates on both faces of a sector.
        workers: number of nodal diameters that are computed at the same time.
        tied: whether each nodal diameter has a complex factor of its own.

    Raises:
        SuperelementError: the reduction needs more memory than this computer has.
    """
    numbers = 1 if waves == 1 else 2
    vectors = lanczos_vectors(modes)
    solves, entries = (vectors + loads) * waves, FILL * coordinates ** (4.0 / 3.0)
    progress.count(ACTIVITY, expected=solves, noun=NOUN)
    # Factor and fronts; then for each worker a Schur complement with its factor and the vectors.
    of_worker = numbers * (2 * coordinates * vectors + faces**2)
    of_factors = 1.3 * entries * (2 * workers if tied else 1)
    needed = 8.0 * (of_factors + 2.0 * faces**2 + workers * of_worker)
    factors = COMPLEX * waves / workers if tied else 1.0
    time = FACTOR_SECONDS * factors * coordinates**2
    time += SOLVE_SECONDS * numbers * entries * solves / workers
    cost = f"{needed / 1e9:.2g} GB of memory"
    if needed > (most := memory()):
        expected = (
            f"a smaller superelement: {coordinates} coordinates take about {cost}, and this"
            f" computer has {most / 1e9:.3g} GB"
        )
        raise SuperelementError(Fault(expected=expected))
    if coordinates >= LARGE:
        logger.warning(
            "Large superelement: %s coordinates take about %s and some %.2g s.",
            *(coordinates, cost, time),
        )


class Pencil(ABC):
    """Stiffness K and mass M, real symmetric or complex Hermitian, with a factor of K + s M."""

    size: int  #: number of coordinates, n
    kind: type  #: type of the vectors, float or complex
    shift: float  #: shift s [rad2/s2]

    @abstractmethod
    def stiffness(self, x: Any) -> Any:
        """Return K x, (n, m)."""

    @abstractmethod
    def mass(self, x: Any) -> Any:
        """Return M x, (n, m)."""

    @abstractmethod
    def shifted_solution(self, loads: Any) -> Any:
        """Return (K + s M)^-1 f for columns of loads, (n, m)."""

    def solve(self, loads: Any) -> Any:
        """Return (K + s M)^-1 f for columns of loads, (n, m), and count the solutions."""
        found = self.shifted_solution(loads)
        progress.count(ACTIVITY, finished=loads.shape[1], noun=NOUN)
        return found

    def lowest(self, count: int) -> tuple[FloatArray, Any]:
        """Return the lowest modes: squared frequencies [rad2/s2], (count,), ascending, and
        mass-normalised shapes [kg^-1/2], (n, count); fewer if the other motions have no mass.

        Raises:
            SuperelementError: the mass is indefinite.
        """
        start = np.random.default_rng(0).standard_normal((self.size, min(BLOCK, self.size)))
        block = self.solve(self.mass(start.astype(self.kind)))
        basis, inertia = _Columns(self.size, self.kind), _Columns(self.size, self.kind)
        projected: Any = np.zeros((0, 0), dtype=self.kind)
        while True:
            block, weights, outside = self._orthonormal(block, basis.all, inertia.all)
            known = len(projected)
            count = count if block.shape[1] else min(count, known)
            if known >= count:
                inverse, vectors = la.eigh(projected)
                residual = la.norm(outside @ vectors[-outside.shape[1] :, -count:], axis=0)
                limit = CONVERGED * inverse[-count:] + ROUNDING * inverse[-1]
                if not block.shape[1] or np.all(residual <= limit):
                    squares = 1.0 / inverse[-count:][::-1] - self.shift
                    return squares, basis.all @ vectors[:, -count:][:, ::-1]
            basis.append(block)
            inertia.append(weights)
            block = self.solve(weights)
            row = block.conj().T @ inertia.all
            own = 0.5 * (row[:, known:] + row[:, known:].conj().T)
            projected = np.block([[projected, row[:, :known].conj().T], [row[:, :known], own]])

    def lowest_groups(self, count: int) -> tuple[FloatArray, Any]:
        """Return the lowest modes as `lowest` does, and all further ones of the frequency of the
        last, in groups of up to `BLOCK`. Which part of a group a count would keep is arbitrary."""
        asked = count
        while True:
            asked = min(asked + BLOCK, self.size)
            squares, shapes = self.lowest(asked)
            apart = np.diff(squares[count - 1 :]) > EQUAL * (squares[count:] + self.shift)
            if apart.any() or len(squares) < asked or asked == self.size:
                end = count + int(apart.argmax()) if apart.any() else len(squares)
                return squares[:end], shapes[:, :end]

    def _orthonormal(self, block: Any, basis: Any, inertia: Any) -> tuple[Any, Any, Any]:
        """Return a block made orthonormal to a basis and in itself with respect to the mass, its
        product with the mass, and the coefficients of the given block on the new one."""
        outside, weights = np.eye(block.shape[1]), None
        for _ in range(2):  # twice is enough for rounding errors
            inside = (block.conj().T @ inertia).conj().T
            block = block - basis @ inside
            weights = self.mass(block) if weights is None else weights - inertia @ inside
            gram = block.conj().T @ weights
            squares, vectors = la.eigh(0.5 * (gram + gram.conj().T))
            before = max((abs(inside) ** 2).sum(axis=0).max(), squares[-1])
            if squares[0] < -INDEFINITE * before:
                raise SuperelementError(Fault(key="mass", expected="a positive definite matrix"))
            kept = (squares > LOST * before) & (squares > DEPENDENT * squares[-1])
            scale, vectors = np.sqrt(squares[kept]), vectors[:, kept]
            block, weights = block @ (vectors / scale), weights @ (vectors / scale)
            outside = (scale[:, None] * vectors.conj().T) @ outside
            if not block.shape[1]:
                break
        return block, weights, outside

    def static(self, loads: Any, shapes: Any, *, exact: bool = True) -> Any:
        """Return static displacements under loads without their part in some modes, (n, m).

        Args:
            loads: columns of loads [N], (n, m).
            shapes: mass-normalised shapes of these modes, among them all rigid ones, (n, modes).
            exact: false if the first step of the iteration is enough.

        Raises:
            LinAlgError: other motions have no stiffness.
        """
        if not loads.shape[1]:
            return loads
        weights = self.mass(shapes)
        rest = loads - weights @ (shapes.conj().T @ loads)
        rest[:, abs(rest).max(axis=0) <= SETTLED * abs(loads).max(axis=0)] = 0.0  # rounding errors
        moved, before = np.zeros_like(rest), np.inf
        for _ in range(STEPS):
            step = self.solve(rest - self.stiffness(moved))
            step = step - shapes @ (weights.conj().T @ step)
            moved = moved + step
            change = float(abs(step).max() / max(abs(moved).max(), TINY))
            if not (self.shift and exact) or change <= SETTLED or before <= change <= STAGNANT:
                return moved
            before = change
        raise la.LinAlgError("motions without stiffness")


class _Columns:
    """Columns in memory that grows by doubling."""

    def __init__(self, size: int, kind: type) -> None:
        self._memory: Any = np.empty((size, 4 * BLOCK), dtype=kind, order="F")
        self._count = 0

    @property
    def all(self) -> Any:
        """All columns, (size, count)."""
        return self._memory[:, : self._count]

    def append(self, columns: Any) -> None:
        """Add columns, (size, m)."""
        count = self._count + columns.shape[1]
        if count > self._memory.shape[1]:
            before = self.all
            room = (before.shape[0], 2 * count)
            self._memory = np.empty(room, dtype=before.dtype, order="F")
            self._memory[:, : self._count] = before
        self._memory[:, self._count : count] = columns
        self._count = count


class MatrixPencil(Pencil):
    """Real matrices of a structure."""

    kind = float

    def __init__(self, stiffness: Matrix, mass: Matrix, shift: float = 0.0) -> None:
        """Factorise the shifted stiffness.

        Args:
            stiffness: stiffness [N/m], (n, n).
            mass: mass [kg], (n, n).
            shift: shift [rad2/s2].

        Raises:
            LinAlgError: the shifted stiffness is not positive definite.
        """
        self._stiffness, self._mass = sp.csr_array(stiffness), sp.csr_array(mass)
        self.size, self.shift = self._mass.shape[0], shift
        shifted = self._stiffness + shift * self._mass if shift else self._stiffness
        self._factor = Cholesky.of(sp.csr_array(shifted))

    def stiffness(self, x: FloatArray) -> FloatArray:
        return np.asarray(self._stiffness @ x)

    def mass(self, x: FloatArray) -> FloatArray:
        return np.asarray(self._mass @ x)

    def shifted_solution(self, loads: FloatArray) -> FloatArray:
        return np.asarray(self._factor.solve(np.ascontiguousarray(loads)))
