"""Modes and static displacements of a sector for all nodal diameters, from one factorisation.

Only the coordinates on the two faces of a sector depend on the nodal diameter, through the tie
u_right = exp(i k alpha) R u_left of `cyclic`. The real matrix of all other coordinates is therefore
factorised once. What is left on the faces is a dense Schur complement S, and the stiffness of
nodal diameter k on the left face is T^H S T, with the tie T from the left face to both faces.
"""

from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from contextvars import copy_context
from typing import Any, TypeVar

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp
from threadpoolctl import threadpool_limits  # type: ignore[import-untyped]  # has no types

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.inputs.errors import Fault
from bladewhirl.models.inputs.machine import cores
from bladewhirl.models.superelements.cholesky import Cholesky
from bladewhirl.models.superelements.cyclic import transformation
from bladewhirl.models.superelements.reduction import small_shift
from bladewhirl.models.superelements.solver import LARGE, Pencil, announce
from bladewhirl.models.superelements.superelement import (
    FIXED,
    IndefiniteError,
    Superelement,
)

Found = TypeVar("Found")


@contextmanager
def sector_errors(stiffness: Fault) -> Iterator[None]:
    """Raise errors of linear algebra in this context as a fault of the stiffness of a sector."""
    try:
        yield
    except la.LinAlgError:
        raise IndefiniteError(stiffness) from None


class Sector:
    """A sector with its factor, for the waves of all nodal diameters."""

    def __init__(
        self, part: Superelement, sectors: int, *, modes: int, loads: int, rigid: bool
    ) -> None:
        """Factorise the shifted stiffness.

        Args:
            part: sector with left_dofs and right_dofs.
            sectors: number of sectors of the wheel.
            modes: number of modes of each nodal diameter that will be computed.
            loads: number of static solutions of each nodal diameter that will be computed.
            rigid: whether the wheel may have rigid modes.

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
        waves = sectors // 2 + 1
        self._workers = min(cores(), waves)
        announce(
            *(part.size, modes, loads),
            waves=waves,
            faces=len(self.faces),
            workers=self._workers,
        )
        self.stiffness, self.mass = sp.csr_array(part.stiffness), sp.csr_array(part.mass)
        self.shift = small_shift(part) if rigid else 0.0
        shifted = self.stiffness + self.shift * self.mass if rigid else self.stiffness
        threads = self._workers if part.size >= LARGE else 1  # more would slow small fronts
        with threadpool_limits(threads, user_api="blas"):
            self.factor = Cholesky(sp.csr_array(shifted), self.faces)

    def each_wave(self, compute: Callable[["Wave"], Found]) -> Iterator[Found]:
        """Yield what a function returns for the waves of nodal diameters 0, 1, ..., sectors / 2,
        which are computed in parallel."""
        diameters = range(self.sectors // 2 + 1)
        with (
            threadpool_limits(1, user_api="blas"),
            ThreadPoolExecutor(self._workers) as pool,
        ):
            jobs = [
                pool.submit(copy_context().run, lambda k: compute(Wave(self, k)), k)
                for k in diameters
            ]
            try:
                for job in jobs:
                    yield job.result()
            finally:
                for job in jobs:
                    job.cancel()


class Wave(Pencil):
    """Matrices of a sector for one nodal diameter, without the coordinates on its right face."""

    def __init__(self, sector: Sector, k: int) -> None:
        """Factorise the stiffness on the left face.

        Raises:
            LinAlgError: the stiffness is not positive definite.
        """
        self.diameter = k
        self.tie = transformation(sector.part, sector.sectors, k)
        """Matrix from the coordinates of the wave to those of the sector, (sector, n)."""
        self.size, self.kind = self.tie.shape[1], complex if self.tie.dtype.kind == "c" else float
        self.shift, self._sector = sector.shift, sector
        self._back = sp.csr_array(self.tie.conj().T)
        on_faces = self.tie[sector.faces]
        self._left = np.unique(on_faces.indices)
        self._faces = sp.csr_array(on_faces[:, self._left])
        half = sector.factor.schur @ self._faces
        schur = (half.conj().T @ self._faces).conj().T
        self._schur = la.cho_factor(schur, lower=True, overwrite_a=True)

    def stiffness(self, x: Any) -> Any:
        return self.on_wave(self._sector.stiffness, x)

    def mass(self, x: Any) -> Any:
        return self.on_wave(self._sector.mass, x)

    def shifted_solution(self, loads: Any) -> Any:
        sector = self._sector
        whole = np.zeros((self.tie.shape[0], loads.shape[1]), dtype=self.kind)
        whole[sector.kept] = loads
        whole[sector.faces] = 0.0
        inner, from_inner = sector.factor.forward(_real(whole))
        onto = loads[self._left] + self._faces.conj().T @ self._typed(from_inner)
        faces = self._faces @ la.cho_solve(self._schur, onto)
        return self._typed(sector.factor.backward(inner, _real(faces)))[sector.kept]

    def on_wave(self, matrix: sp.csr_array, x: Any) -> Any:
        """Return the product of a matrix of the sector with columns on the wave, (n, m)."""
        return self._back @ self._typed(matrix @ _real(self.tie @ x))

    def _typed(self, columns: FloatArray) -> Any:
        return np.ascontiguousarray(columns).view(self.kind)


def _real(columns: Any) -> FloatArray:
    """Return real and imaginary parts of columns side by side; real columns as they are."""
    return np.asarray(np.ascontiguousarray(columns).view(np.float64))
