"""Growth rate due to internal damping beyond a critical speed, and the bearing damping against it.

Damping of the turning structure resists velocities relative to it. Where K_Omega is indefinite, a
forward wave turns slower than the disk and is drawn along: it grows. A damper of a bearing that
stands still resists c (v + Omega z x u) at the centre and takes energy from any whirl.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bladewhirl.meshes.line_mesh import ComplexArray
from bladewhirl.models.case.shaft import Effects
from bladewhirl.models.elements.bladed_disk import BladedDiskModel
from bladewhirl.models.elements.cyclic import nodal_diameters
from bladewhirl.models.rotation.eigenproblems import damped_eigenvalues, modal_damping
from bladewhirl.models.rotation.matrices import RotationMatrices
from bladewhirl.models.rotation.waves import Waves, waves

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
