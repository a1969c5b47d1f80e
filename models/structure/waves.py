"""Waves of one nodal diameter on a rotating bladed disk, as functions of the speed.

For a wave exp(i (k theta + w t)) at the speed Omega, the matrix -w^2 M + i w Omega G + K_Omega with
the stiffness K_Omega at this speed is singular, see `rotating`. Branches w(Omega) of one nodal
diameter do not cross, so a branch is identified by its direction of travel at rest and its rank
among the branches with this direction; the lowest frequency has rank 0.

Damping of the rotating structure acts on velocities relative to the structure. Where K_Omega is
indefinite, a forward wave rotates more slowly than the disk. The damping then pulls the wave along,
and the wave grows. A damper of a bearing, fixed in space, acts with the force c (v + Omega z x u)
at the centre and takes energy from any whirl.
"""

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
import scipy.linalg as la

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.models.structure.eigenproblems import (
    damped_eigenvalues,
    gyroscopic_eigen,
    gyroscopic_frequencies,
    inverse_root,
    modal_damping,
    positive_speeds,
)
from bladewhirl.models.structure.rotating import Rotating

REAL = 1e-6  #: a speed counts as real if its imaginary part is at most this fraction of its modulus


@dataclass(frozen=True, kw_only=True)
class Waves(Rotating[ComplexArray]):
    """Matrices of one nodal diameter, Hermitian, (n, n), with the stiffness at rest."""

    FORMS: ClassVar[tuple[str, ...]] = (*Rotating.FORMS, "springs")

    nodal_diameter: int
    springs: ComplexArray  #: part of the stiffness due to the shaft springs [N/m], (n, n)
    frame: int = 0
    """Nodal diameter k' of a frame in which frequencies are w - k' Omega: 0 in the rotating frame,
    `nodal_diameter` in the static frame."""

    def on_springs(self, ratio: float) -> "Waves":
        """Return the waves with shaft springs of `ratio` times their stiffness."""
        stiffness = self.stiffness + (ratio - 1.0) * self.springs
        return replace(self, stiffness=stiffness, springs=ratio * self.springs)

    def frequencies(self, omega: float) -> ComplexArray:
        """Return w at a speed omega, in descending order [rad/s], (2 n,).

        The first n are the branches of waves that travel backward when the disk is at rest, the
        last n those of waves that travel forward.
        """
        return gyroscopic_frequencies(
            self.mass, self.stiffness_at(omega), omega * self.known("gyroscopic")
        )

    def spring_shares(self, omega: float) -> FloatArray:
        """Return for each wave at a speed omega [rad/s] the share of its strain energy that is in
        the shaft springs, in the order of `frequencies`, (2 n,)."""
        at_speed = self.stiffness_at(omega), omega * self.known("gyroscopic")
        return self.shares(gyroscopic_eigen(self.mass, *at_speed)[1])

    def shares(self, fields: ComplexArray) -> FloatArray:
        """Return for each field the share of its strain energy that is in the shaft springs,
        (fields,)."""
        return spring_shares(fields, self.springs, self.stiffness)

    def rank(self, omega: float, frequency: float) -> tuple[int, bool]:
        """Return the rank of the branch that is nearest to a frequency at a speed.

        Args:
            omega: speed of rotation [rad/s].
            frequency: w, positive for a backward wave [rad/s].

        Returns:
            the rank, and true if the branch travels backward at rest.
        """
        nearest = int(self._distances(omega, frequency).argmin())
        size = len(self.mass)
        return (size - 1 - nearest, True) if nearest < size else (nearest - size, False)

    def _distances(self, omega: float, frequency: float) -> FloatArray:
        """Return the distance of each branch from a frequency at the speed omega, (2 n,)."""
        return np.abs(self.frequencies(omega) - frequency)

    def synchronous(self, order: int) -> tuple[FloatArray, FloatArray]:
        """Return the speeds at which a wave has w = m Omega, where m is the order.

        The speeds follow from the eigenproblem K p = Omega^2 (m^2 M - i m G - K1) p -
        Omega^4 K2 p, which is Hermitian without the last term. Order 0 gives the critical
        speeds of a load that rotates with the disk, such as an imbalance; at these speeds the
        frequencies w of the branches that travel forward at rest reach zero, in the order of their
        ranks. Order k gives the speeds at which a backward wave is stationary relative to the
        casing.

        Returns:
            speeds in ascending order [rad/s] (waves,), and the share of the strain energy in the
            shaft springs (waves,).
        """
        pulled = (
            order**2 * self.mass
            - 1j * order * self.known("gyroscopic")
            - self.known("stiffness_speed")
        )
        if self.stiffness_speed4 is None:
            speeds, fields = positive_speeds(self.stiffness, pulled)
        else:
            squares, fields = _polynomial_eigen([self.stiffness, -pulled, self.stiffness_speed4])
            real = (np.abs(squares.imag) <= REAL * np.abs(squares)) & (squares.real > 0.0)
            order_of = np.flatnonzero(real)[np.argsort(squares[real].real)]
            speeds, fields = np.sqrt(squares[order_of].real), fields[:, order_of]
        return speeds, self.shares(fields)

    def growth(
        self,
        omega: float,
        damping_ratio: float,
        centre: ComplexArray | None = None,
        bearing: float = 0.0,
    ) -> float:
        """Return the largest growth rate with the modal damping of the structure at rest [1/s].

        Args:
            omega: speed of rotation [rad/s].
            damping_ratio: damping ratio of every mode at rest.
            centre: components of unit forces on the centre along x and y, (n, 2); None without
                bearing damping.
            bearing: bearing damping, fixed in space [N s/m].
        """
        damping = modal_damping(self.mass, self.stiffness, damping_ratio)
        damping = damping + omega * self.known("gyroscopic")
        stiffness = self.stiffness_at(omega)
        if centre is not None:
            turn = np.array([[0.0, -1.0], [1.0, 0.0]])
            damping = damping + bearing * centre @ centre.conj().T
            stiffness = stiffness + bearing * omega * centre @ turn @ centre.conj().T
        return float(damped_eigenvalues(self.mass, damping, stiffness)[0].real.max())

    def meeting(self, casing_frequency: float, highest: float) -> FloatArray:
        """Return the speeds at which a backward wave has w = k Omega - omega_c [rad/s], ascending.

        At such a speed the backward wave rotates together with a forward wave on the casing, as
        in Eq. (14) of the paper, but with the rotor's frequency at speed. The eigenproblem is then
        quadratic in Omega.

        Args:
            casing_frequency: frequency omega_c of the casing [rad/s].
            highest: upper bound of the speeds [rad/s].
        """
        k = self.nodal_diameter - self.frame
        turning = 1j * self.known("gyroscopic")
        second = k * turning - k**2 * self.mass + self.known("stiffness_speed")
        first = casing_frequency * (2.0 * k * self.mass - turning)
        zeroth = self.stiffness - casing_frequency**2 * self.mass
        powers = [zeroth, first, second]
        if self.stiffness_speed4 is not None:
            powers += [np.zeros_like(second), self.stiffness_speed4]
        inverse = inverse_root(self.stiffness)
        scaled = [
            inverse @ (highest**power * each) @ inverse.conj().T
            for power, each in enumerate(powers)
        ]
        meetings = highest * _polynomial_eigen(scaled)[0]
        speeds = np.sort(meetings[np.abs(meetings.imag) <= REAL * np.abs(meetings)].real)
        met = (speeds > 0.0) & (speeds <= highest)
        met &= self.nodal_diameter * speeds > casing_frequency
        return np.asarray(speeds[met])


def spring_shares(fields: ComplexArray, springs: Any, elastic: Any) -> FloatArray:
    """Return the springs' share of the strain energy of each field, (fields,)."""
    in_springs, strain = (
        np.einsum("im,im->m", fields.conj(), matrix @ fields).real for matrix in (springs, elastic)
    )
    strain = np.maximum(strain, np.maximum(in_springs, np.finfo(np.float64).tiny))
    return np.asarray(in_springs / strain)


def _polynomial_eigen(coefficients: list[ComplexArray]) -> tuple[ComplexArray, ComplexArray]:
    """Return the finite x and the vectors p of (C_0 + x C_1 + x^2 C_2 + ...) p = 0, (m,) and
    (n, m)."""
    constant, *others = coefficients
    size, degree = len(constant), len(others)
    # The eigenvalues of this pencil are 1 / x.
    left = np.eye(size * degree, k=-size, dtype=np.complex128)
    left[:size] = -np.hstack(others)
    right = la.block_diag(constant, np.eye(size * (degree - 1)))
    (over, under), vectors = la.eig(left, right, homogeneous_eigvals=True)
    sure = np.abs(over) > np.finfo(np.float64).eps * np.abs(under)
    return under[sure] / over[sure], vectors[-size:, sure]
