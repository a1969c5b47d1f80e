"""Lowest modes and static displacements of small dense matrices, such as condensed structures."""

import numpy as np
import scipy.linalg as la

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.inputs.errors import Fault
from bladewhirl.models.superelements.solver import INDEFINITE, Pencil
from bladewhirl.models.superelements.superelement import SuperelementError

SMALL = 400  #: largest number of coordinates for which all modes at once take less time
MASSLESS = 1e-14
"""A motion has no mass if its eigenvalue of the inverse is at most this fraction of the largest."""


class DensePencil(Pencil):
    """Dense real matrices, of which all modes are computed."""

    kind = float

    def __init__(self, stiffness: FloatArray, mass: FloatArray, shift: float = 0.0) -> None:
        """Factorise the shifted stiffness; for arguments and errors see `solver.MatrixPencil`."""
        self._stiffness, self._mass = np.asarray(stiffness), np.asarray(mass)
        self.size, self.shift = len(self._mass), shift
        self._shifted = self._stiffness + shift * self._mass
        self._factor = la.cho_factor(self._shifted)

    def stiffness(self, x: FloatArray) -> FloatArray:
        return np.asarray(self._stiffness @ x)

    def mass(self, x: FloatArray) -> FloatArray:
        return np.asarray(self._mass @ x)

    def shifted_solution(self, loads: FloatArray) -> FloatArray:
        return np.asarray(la.cho_solve(self._factor, loads))

    def lowest(self, count: int) -> tuple[FloatArray, FloatArray]:
        inverse, shapes = la.eigh(self._mass, self._shifted)
        if inverse[0] < -INDEFINITE * inverse[-1]:
            raise SuperelementError(Fault(key="mass", expected="a positive definite matrix"))
        count = min(count, int((inverse > MASSLESS * inverse[-1]).sum()))
        inverse, shapes = inverse[::-1][:count], shapes[:, ::-1][:, :count]
        return 1.0 / inverse - self.shift, shapes / np.sqrt(inverse)
