"""Exact steps of modes under forces that are constant in a step, and their periodic responses.

With the mean of the forces at both ends of each step, see `blade`, the state y of the modes
satisfies y_{i+1} = E y_i + G (f_i + f_{i+1}) / 2, and the harmonic k of y at n instants is
(z - E)^-1 G (1 + z) / 2 times that of f with z = exp(2 i pi k / n).
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.models.coupling.equations import companion


@dataclass(frozen=True)
class Steps:
    """Modes q'' + D q' + W^2 q = f in equal steps."""

    stiffness: FloatArray  #: squared frequencies W^2 [rad2/s2], (modes,)
    damping: FloatArray  #: matrix D [1/s], (modes, modes)
    step: float  #: length of a step [s]

    @cached_property
    def unit(self) -> float:
        """Frequency that multiplies modal coordinates in the state (unit q, q') [rad/s]."""
        return float(np.sqrt(np.abs(self.stiffness).max()))

    @cached_property
    def _poles(self) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
        """Eigenvalues z of a step of independent sets of modes, (sets, size), their vectors in the
        state (unit q, q') and the inverse of these, (sets, size, size). Modes are independent if
        the matrix D is diagonal; otherwise there is one set."""
        rates = np.diag(self.damping)
        if np.count_nonzero(self.damping - np.diag(rates)):
            state = companion(-np.diag(self.stiffness), -self.damping, self.unit)[None]
        else:
            alone = -self.stiffness[:, None, None], -rates[:, None, None]
            state = companion(*alone, self.unit)
        values, vectors = np.linalg.eig(self.step * state)
        vectors = vectors.astype(np.complex128)
        return values.astype(np.complex128), vectors, np.linalg.inv(vectors)

    def transition(self, rows: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the matrices E and G of a step of the state (unit q, q') for forces along rows
        (forces, modes), (2 * modes, 2 * modes) and (2 * modes, forces)."""
        modes = len(self.stiffness)
        values, vectors, inverse = self._poles
        sets, own = len(values), values.shape[1] // 2

        def moved(factors: ComplexArray, into: ComplexArray) -> FloatArray:
            """Return the matrix of a factor for each eigenvalue."""
            parts = ((vectors * factors[:, None]) @ into).real
            columns = parts.shape[-1] // own
            parts = parts.reshape(sets, 2, own, columns, own)
            full = np.zeros((2, sets, own, columns, sets, own))
            for n in range(sets):
                full[:, n, :, :, n] = parts[n]
            return full.reshape(2 * modes, columns * modes)

        by_force = self.step * moved(_held(values), inverse[:, :, own:]) @ rows.T
        return moved(np.exp(values), inverse), by_force

    def answers(self, instants: int) -> ComplexArray:
        """Return the harmonics 0 to instants / 2 of q and q' for those of modal forces, q in the
        rows and the forces in the columns of each set of independent modes, (2, sets, size / 2,
        size / 2, harmonics)."""
        values, vectors, inverse = self._poles
        sets, own = len(values), values.shape[1] // 2
        turn = np.exp(2j * np.pi / instants * np.arange(instants // 2 + 1))
        held = self.step * _held(values)[:, :, None]
        each = 0.5 * held * (1.0 + turn) / (turn - np.exp(values)[:, :, None])
        parts = vectors[:, :, None] * inverse[:, None, :, own:].swapaxes(2, 3)
        moved = parts.reshape(sets, -1, 2 * own) @ each
        moved = moved.reshape(sets, 2, own, own, -1).swapaxes(0, 1)
        return np.asarray(moved / np.array([self.unit, 1.0])[:, None, None, None, None])


def _held(values: ComplexArray) -> ComplexArray:
    """Return the integral of exp((1 - s) z) over s from 0 to 1, the response to a constant force in
    a step, for each eigenvalue z."""
    still = values == 0.0
    return np.where(still, 1.0, np.expm1(values) / np.where(still, 1.0, values))
