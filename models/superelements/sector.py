"""Modes and static displacements of a sector for all nodal diameters.

Only the coordinates on the two faces of a sector depend on the nodal diameter, through the tie
u_right = exp(i k alpha) R u_left of `cyclic`. With small faces the real matrix of all other
coordinates is therefore factorised once. What is left on the faces is a dense Schur complement S,
and the stiffness of nodal diameter k on the left face is T^H S T, with the tie T from the left face
to both faces, which is

    A + cos(k alpha) (B + B^T) + i sin(k alpha) (B - B^T),

where B is between the left face and the right face.

With large faces the dense matrices would take most of the time and memory. The tied sparse matrix
of each nodal diameter, of the same form, is then factorised by itself, in one order of elimination
for all.
"""

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from contextvars import copy_context
from typing import Any, TypeVar

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp
from threadpoolctl import threadpool_limits  # type: ignore[import-untyped]  # has no types

from bladewhirl.meshes.line_mesh import BoolArray, FloatArray
from bladewhirl.models.inputs.errors import Fault
from bladewhirl.models.inputs.machine import cores
from bladewhirl.models.superelements.cholesky import Cholesky, Elimination
from bladewhirl.models.superelements.cyclic import transformation
from bladewhirl.models.superelements.reduction import small_shift
from bladewhirl.models.superelements.solver import LARGE, Pencil, announce
from bladewhirl.models.superelements.superelement import (
    FIXED,
    IndefiniteError,
    Superelement,
)

Found = TypeVar("Found")

LARGE_FACE = 2500
"""Number of coordinates of a face from which the matrix of each nodal diameter is factorised by
itself (measured: for sectors of 20,000 coordinates both ways then take the same time)."""

AT_ONCE = 2  #: number of nodal diameters with large faces that are computed at the same time


@contextmanager
def sector_errors(stiffness: Fault) -> Iterator[None]:
    """Raise errors of linear algebra in this context as a fault of the stiffness of a sector."""
    try:
        yield
    except la.LinAlgError:
        raise IndefiniteError(stiffness) from None


class Sector:
    """A sector with what the waves of all nodal diameters share."""

    def __init__(
        self,
        part: Superelement,
        sectors: int,
        *,
        modes: int,
        loads: int,
        rigid: bool,
        waves: int | None = None,
    ) -> None:
        """Factorise the shifted stiffness, or find the order of elimination.

        Args:
            part: sector with left_dofs and right_dofs.
            sectors: number of sectors of the wheel.
            modes: number of modes of each nodal diameter that will be computed.
            loads: number of static solutions of each nodal diameter that will be computed.
            rigid: whether the wheel may have rigid modes.
            waves: number of nodal diameters that will be computed; all by default.

        Raises:
            SuperelementError: the superelement is not a sector, or takes too much memory.
            LinAlgError: the stiffness is indefinite.
        """
        self.part, self.sectors = part, sectors
        transformation(part, sectors, 0)  # checks the faces
        assert part.left_dofs is not None
        assert part.right_dofs is not None
        both = np.concatenate([part.left_dofs, part.right_dofs]).ravel()
        self.faces = np.unique(both[both != FIXED])
        """Coordinates on both faces, (f,)."""
        self.kept = np.setdiff1d(np.arange(part.size), part.right_dofs)
        """Coordinates that are not on the right face, (n,)."""
        waves, large = waves or sectors // 2 + 1, len(self.faces) >= 2 * LARGE_FACE
        # The large fronts of a large face take much memory, and one by one gain little from cores.
        self._workers = min(cores(), waves, AT_ONCE if large else waves)
        self._threads = max(cores() // AT_ONCE, 1) if large and part.size >= LARGE else 1
        announce(
            *(len(self.kept) if large else part.size, modes, loads),
            waves=waves,
            faces=0 if large else len(self.faces),
            workers=self._workers,
            tied=large,
        )
        self.stiffness, self.mass = sp.csr_array(part.stiffness), sp.csr_array(part.mass)
        self.shift = small_shift(part) if rigid else 0.0
        shifted = self.stiffness + self.shift * self.mass if rigid else self.stiffness
        self.tied: _Tied | None = None
        if large:
            self.tied = _Tied(sp.csr_array(shifted), part, sectors)
            return
        threads = self._workers if part.size >= LARGE else 1  # more would slow small fronts
        with threadpool_limits(threads, user_api="blas"):
            self.factor = Cholesky.of(sp.csr_array(shifted), self.faces)
            tie = sp.csr_array(transformation(part, sectors, 0))[self.faces]
            self.left = np.unique(tie.indices)
            """Coordinates of a wave on the left face, (l,)."""
            right = np.isin(self.faces, part.right_dofs)
            self.schur = _tied(self.factor.schur, sp.csr_array(tie[:, self.left]), right)
            """Schur complement of the left face, real matrices A and B of each k, (l, l)."""

    def wave(self, k: int) -> "Wave":
        """Return the wave of a nodal diameter.

        Raises:
            LinAlgError: the stiffness is not positive definite.
        """
        return CondensedWave(self, k) if self.tied is None else TiedWave(self, k)

    def each_wave(
        self, compute: Callable[[int], Found], diameters: Iterable[int] | None = None
    ) -> Iterator[Found]:
        """Yield what a function returns for nodal diameters, which are computed in parallel; by
        default for 0, 1, ..., sectors / 2."""
        if diameters is None:
            diameters = range(self.sectors // 2 + 1)
        with (
            threadpool_limits(self._threads, user_api="blas"),
            ThreadPoolExecutor(self._workers) as pool,
        ):
            jobs = [pool.submit(copy_context().run, compute, k) for k in diameters]
            try:
                for job in jobs:
                    yield job.result()
            finally:
                for job in jobs:
                    job.cancel()


class _Tied:
    """The tied matrices of all nodal diameters of a sector."""

    def __init__(self, matrix: sp.csr_array, part: Superelement, sectors: int) -> None:
        tie = sp.csr_array(transformation(part, sectors, 0))
        assert part.right_dofs is not None
        own, across = _tied(matrix, tie, np.isin(np.arange(part.size), part.right_dofs))
        patterns = (abs(own), abs(across), abs(across.T))
        whole = sp.csr_array(sum(patterns, sp.csr_array(own.shape)))
        self._angle, self._elimination = 2.0 * np.pi / sectors, Elimination.of(whole)
        self._pattern = self._elimination.lower(whole)
        both = own, across + across.T, across - across.T
        self._own, self._even, self._odd = (self._placed(sp.csr_array(one)) for one in both)

    def factor(self, k: int, *, real: bool) -> Cholesky:
        """Return the factor for a nodal diameter; it is real for 0 and for half the sectors."""
        data: Any = self._own + np.cos(k * self._angle) * self._even
        if not real:
            data = data + 1j * np.sin(k * self._angle) * self._odd
        pattern = self._pattern
        entries = data, pattern.indices, pattern.indptr
        return Cholesky(self._elimination, sp.csc_array(entries, shape=pattern.shape))

    def _placed(self, matrix: sp.csr_array) -> FloatArray:
        """Return the entries of a matrix in the places of the pattern."""
        keys = []
        lower = self._elimination.lower(matrix)
        for one in (self._pattern, lower):
            column = np.repeat(np.arange(one.shape[1], dtype=np.int64), np.diff(one.indptr))
            keys.append(column * one.shape[0] + one.indices)
        found = np.zeros(len(keys[0]))
        found[np.searchsorted(*keys)] = lower.data
        return found


def _tied(matrix: Any, tie: sp.csr_array, right: BoolArray) -> tuple[Any, Any]:
    """Return the real matrices A and B of tied matrices, see above, (n, n).

    Args:
        matrix: matrix of the sector, or of its faces, (m, m).
        tie: tie of nodal diameter 0, (m, n).
        right: whether a coordinate is on the right face, (m,).
    """
    on = sp.csr_array(sp.diags_array(right.astype(np.float64)) @ tie)
    rest = sp.csr_array(tie - on)
    return rest.T @ matrix @ rest + on.T @ matrix @ on, rest.T @ matrix @ on


class Wave(Pencil):
    """Matrices of a sector for one nodal diameter, without the coordinates on its right face."""

    def __init__(self, sector: Sector, k: int) -> None:
        self.diameter = k
        self.tie = transformation(sector.part, sector.sectors, k)
        """Matrix from the coordinates of the wave to those of the sector, (sector, n)."""
        self.size, self.kind = self.tie.shape[1], complex if self.tie.dtype.kind == "c" else float
        self.shift, self._sector = sector.shift, sector
        self._back = sp.csr_array(self.tie.conj().T)

    def stiffness(self, x: Any) -> Any:
        return self.on_wave(self._sector.stiffness, x)

    def mass(self, x: Any) -> Any:
        return self.on_wave(self._sector.mass, x)

    def on_wave(self, matrix: sp.csr_array, x: Any) -> Any:
        """Return the product of a matrix of the sector with columns on the wave, (n, m)."""
        return self._back @ self._typed(matrix @ _real(self.tie @ x))

    def _typed(self, columns: FloatArray) -> Any:
        return np.ascontiguousarray(columns).view(self.kind)


class CondensedWave(Wave):
    """A wave from the factor of the coordinates that are not on the faces."""

    def __init__(self, sector: Sector, k: int) -> None:
        super().__init__(sector, k)
        self._left = sector.left
        self._faces = sp.csr_array(self.tie[sector.faces][:, self._left])
        (own, across), angle = sector.schur, 2.0 * np.pi * k / sector.sectors
        schur = own + np.cos(angle) * (across + across.T)
        if self.kind is complex:
            schur = schur + 1j * np.sin(angle) * (across - across.T)
        self._schur = la.cho_factor(schur, lower=True, overwrite_a=True)

    def shifted_solution(self, loads: Any) -> Any:
        sector = self._sector
        whole = np.zeros((self.tie.shape[0], loads.shape[1]), dtype=self.kind)
        whole[sector.kept] = loads
        whole[sector.faces] = 0.0
        inner, from_inner = sector.factor.forward(_real(whole))
        onto = loads[self._left] + self._faces.conj().T @ self._typed(from_inner)
        faces = self._faces @ la.cho_solve(self._schur, onto)
        return self._typed(sector.factor.backward(inner, _real(faces)))[sector.kept]


class TiedWave(Wave):
    """A wave with a factor of its own."""

    def __init__(self, sector: Sector, k: int) -> None:
        super().__init__(sector, k)
        assert sector.tied is not None
        self._factor = sector.tied.factor(k, real=self.kind is float)

    def shifted_solution(self, loads: Any) -> Any:
        return self._factor.solve(np.ascontiguousarray(loads, dtype=self.kind))


def _real(columns: Any) -> FloatArray:
    """Return real and imaginary parts of columns side by side; real columns as they are."""
    return np.asarray(np.ascontiguousarray(columns).view(np.float64))
