"""Waves of one nodal diameter on a turning bladed disk: over the speed, with others, with damping.

A wave exp(i (k theta + w t)) at Omega has -w^2 M + 2 i w Omega G + K + Omega^2 (K_G1 - M_t)
singular. Branches w(Omega) of one nodal diameter do not cross, so a branch is known by its rank: of
those that travel backward at rest 0 for the lowest, and likewise of those that travel forward.

Damping of the turning structure resists velocities relative to it. Where K_Omega is indefinite, a
forward wave turns slower than the disk and is drawn along: it grows. A damper of a bearing that
stands still resists c (v + Omega z x u) at the centre and takes energy from any whirl.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.models.case.shaft import Effects
from bladewhirl.models.elements.bladed_disk import BladedDiskModel
from bladewhirl.models.elements.cyclic import nodal_diameters
from bladewhirl.models.rotation.eigenproblems import (
    damped_eigenvalues,
    gyroscopic_frequencies,
    modal_damping,
    positive_speeds,
)
from bladewhirl.models.rotation.matrices import RotationMatrices

REAL = 1e-6
"""Share of a speed up to which an imaginary part is rounding."""


@dataclass(frozen=True, kw_only=True)
class Waves:
    """Matrices of one nodal diameter, (n, n)."""

    nodal_diameter: int
    mass: ComplexArray  #: M
    stiffness: ComplexArray  #: K at rest
    coriolis: ComplexArray  #: G, zero without Coriolis forces
    softening: ComplexArray  #: K_G1 - M_t
    springs: ComplexArray  #: the shaft springs' part of K

    def frequencies(self, omega: float) -> ComplexArray:
        """Return w at a speed [rad/s], descending: n backward at rest, then n forward, (2 n,)."""
        stiffness = self.stiffness + omega**2 * self.softening
        return gyroscopic_frequencies(self.mass, stiffness, 2.0 * omega * self.coriolis)

    def rank(self, omega: float, frequency: float) -> tuple[int, bool]:
        """Rank of the branch nearest to a frequency at a speed, and whether it is a backward one.

        Args:
            omega: speed of rotation [rad/s].
            frequency: w, positive backward [rad/s].
        """
        nearest = int(np.abs(self.frequencies(omega) - frequency).argmin())
        size = len(self.mass)
        return (size - 1 - nearest, True) if nearest < size else (nearest - size, False)

    def synchronous(self, order: int) -> tuple[FloatArray, FloatArray]:
        """Return the speeds with w = order Omega and the share of strain energy in the shaft
        springs.

        K p = Omega^2 (m^2 M + M_t - 2 i m G - K_G1) p, a Hermitian eigenproblem. Order 0 gives
        the critical speeds of a load that turns with the disk, as an imbalance does: there the
        branches that travel forward at rest end, in their order. Order k gives the backward waves
        that stand still on the casing.

        Returns:
            speeds ascending [rad/s] (waves,), share of the strain energy in the springs (waves,).
        """
        pulled = order**2 * self.mass - 2j * order * self.coriolis - self.softening
        speeds, fields = positive_speeds(self.stiffness, pulled)
        spring_energy, strain = (
            np.einsum("im,ij,jm->m", fields.conj(), each, fields).real
            for each in (self.springs, self.stiffness)
        )
        return speeds, spring_energy / strain

    def meeting(self, casing_frequency: float, highest: float) -> FloatArray:
        """Speeds at which a backward wave has w = k Omega - omega_c, ascending [rad/s], (waves,).

        There a wave that travels forward on the casing keeps pace with it, Eq. (14) at speed. With
        w put in, the eigenproblem is quadratic in Omega.

        Args:
            casing_frequency: omega_c of the wave on the casing [rad/s].
            highest: speed that is looked at [rad/s].
        """
        k, size = self.nodal_diameter, len(self.mass)
        twice = 2j * self.coriolis
        second = k * twice - k**2 * self.mass + self.softening
        first = casing_frequency * (2.0 * k * self.mass - twice)
        zeroth = self.stiffness - casing_frequency**2 * self.mass
        root = la.cholesky(self.stiffness, lower=True)
        inverse = la.solve_triangular(root, np.eye(size), lower=True)
        second, first, zeroth = (
            inverse @ each @ inverse.conj().T
            for each in (highest**2 * second, highest * first, zeroth)
        )
        # For highest / Omega, the largest of those examined.
        left = np.vstack([np.hstack([-first, -second]), np.eye(size, 2 * size)])
        over, under = la.eigvals(
            left, la.block_diag(zeroth, np.eye(size)), homogeneous_eigvals=True
        )
        sure = np.abs(over) > np.finfo(np.float64).eps * np.abs(under)
        meetings = highest * under[sure] / over[sure]
        speeds = np.sort(meetings[np.abs(meetings.imag) <= REAL * np.abs(meetings)].real)
        met = (speeds > 0.0) & (speeds <= highest) & (k * speeds > casing_frequency)
        return np.asarray(speeds[met])


def waves(matrices: RotationMatrices, nodal_diameter: int, effects: Effects) -> Waves:
    """Matrices of one nodal diameter of a bladed disk of equal sectors.

    Raises:
        ValueError: its sectors are not equal.
    """
    structure = matrices.structure
    if not structure.is_cyclic or structure.layout is None:
        raise ValueError("waves of one nodal diameter need equal sectors")
    basis = structure.layout.basis(nodal_diameter)
    turning, full = effects != "none", effects == "full"

    def block(matrix: sp.csr_array) -> ComplexArray:
        return np.asarray((basis.conj().T @ matrix @ basis).toarray())

    softening, coriolis = block(matrices.geometric - matrices.mass), block(matrices.coriolis)
    return Waves(
        nodal_diameter=nodal_diameter,
        mass=block(structure.mass),
        stiffness=block(structure.stiffness),
        coriolis=coriolis if full else np.zeros_like(coriolis),
        softening=softening if turning else np.zeros_like(softening),
        springs=block(structure.springs),
    )


WEAKEST, STRONGEST = 1e-9, 1e3
"""Bearing damping that is tried, in shares of the centre's mass times speed over a period."""

TRIED = 200
"""Values of bearing damping that are tried."""


@dataclass(frozen=True, kw_only=True)
class InternalGrowth:
    """Fastest growth of a bladed disk without casing at a speed."""

    rate: float  #: [1/s]; negative where everything decays
    nodal_diameter: int
    holding: float | None
    """Least damping of each of two fixed bearings, x and y, for stability [N s/m]; zero if stable
    without, None if bearings cannot stabilise it."""


def internal_growth(
    disk: BladedDiskModel,
    matrices: RotationMatrices,
    omega: float,
    effects: Effects,
    *,
    damping_ratio: float,
) -> InternalGrowth:
    """Return the growth of a bladed disk of equal sectors due to the modal damping at rest.

    Args:
        disk: the bladed disk.
        matrices: its.
        omega: speed of rotation [rad/s].
        effects: that count.
        damping_ratio: of every mode at rest.
    """
    layout = matrices.structure.layout
    assert layout is not None  # its sectors are equal
    rates, first = {}, None
    for k in nodal_diameters(layout.sectors):
        block = DampedWaves(
            own=waves(matrices, k, effects), damping_ratio=damping_ratio, omega=omega
        )
        rates[k] = block.growth(None, 0.0)
        if k == 1:
            first = block
    fastest = max(rates, key=lambda k: rates[k])
    others = max((rate for k, rate in rates.items() if k != 1), default=-np.inf)
    holding: float | None = 0.0
    if rates[fastest] > 0.0:
        holding = None
        if others <= 0.0 and first is not None and disk.centre.size:
            basis = layout.basis(1).conj().T[:, disk.centre].toarray()
            holding = _holding(first, np.asarray(basis))
    return InternalGrowth(rate=rates[fastest], nodal_diameter=int(fastest), holding=holding)


@dataclass(frozen=True, kw_only=True)
class DampedWaves:
    """Waves of one nodal diameter with the modal damping at rest."""

    own: Waves
    damping_ratio: float
    omega: float  #: [rad/s]

    def growth(self, centre: ComplexArray | None, bearing: float) -> float:
        """Largest growth rate [1/s].

        Args:
            centre: components of unit forces on the centre along x and y, (n, 2); None without.
            bearing: damping that stands still [N s/m].
        """
        own = self.own
        damping = modal_damping(own.mass, own.stiffness, self.damping_ratio)
        damping = damping + 2.0 * self.omega * own.coriolis
        stiffness = own.stiffness + self.omega**2 * own.softening
        if centre is not None:
            turn = np.array([[0.0, -1.0], [1.0, 0.0]])
            damping = damping + bearing * centre @ centre.conj().T
            stiffness = stiffness + bearing * self.omega * centre @ turn @ centre.conj().T
        return float(damped_eigenvalues(own.mass, damping, stiffness)[0].real.max())


def _holding(first: DampedWaves, centre: ComplexArray) -> float | None:
    """Return the least bearing damping without growth [N s/m]; None if no tried value suffices."""
    mass = float(np.trace(centre.conj().T @ first.own.mass @ centre).real)
    from scipy.optimize import brentq  # long to load

    scale = mass * abs(first.omega)
    tried = scale * np.geomspace(WEAKEST, STRONGEST, TRIED)
    below = 0.0
    for bearing in tried.tolist():
        if first.growth(centre, bearing) <= 0.0:
            return float(brentq(lambda c: first.growth(centre, c), below, bearing, rtol=1e-9))
        below = bearing
    return None
