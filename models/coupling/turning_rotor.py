"""Rotation matrices on the coupled modes of a bladed disk.

The modes are those at rest; the matrices of a disk that turns are projected on them,

    u'' + (D + 2 Omega G) u' + (diag(omega^2) + Omega^2 S + K*(t)) u = 0,

with G the Coriolis matrix and S = K_G1 - M_t. On a disk of equal sectors both commute with a turn
of cosine into sine, so with z = u_c + i u_s they are complex matrices over the entries: G skew-
Hermitian, S Hermitian. Where the disk is its own mirror image G is imaginary and S real.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from bladewhirl.meshes.line_mesh import BoolArray, ComplexArray, FloatArray, IntArray

ROUNDING = 1e-9
"""Share of a matrix below which the part that a mirror symmetry forbids is rounding."""


@dataclass(frozen=True, kw_only=True)
class TurningRotor:
    """Matrices over the coupled entries for Omega = 1 rad/s, zero for those of the casing."""

    coriolis: ComplexArray  #: G, (entries, entries)
    softening: ComplexArray  #: S, (entries, entries)

    @property
    def mirrored(self) -> bool:
        """Whether G is imaginary and S real."""
        return not (self.coriolis.real.any() or self.softening.imag.any())

    def take(self, chosen: IntArray) -> Self:
        """Keep some entries, by positions."""
        among = np.ix_(chosen, chosen)
        return type(self)(coriolis=self.coriolis[among], softening=self.softening[among])


def matrices_of_entries(
    coriolis: FloatArray,
    softening: FloatArray,
    coordinates: IntArray,
    *,
    paired: BoolArray,
    nodal_diameter: IntArray,
    cosine: IntArray,
) -> TurningRotor:
    """Complex matrices of the entries from real ones of the rotor's coordinates.

    Args:
        coriolis: G of modes at rest, mass-normalised, (coordinates, coordinates).
        softening: S of them.
        coordinates: places of these among all real coordinates, (coordinates,).
        paired: whether each entry is a pair, (entries,).
        nodal_diameter: of each entry.
        cosine: place of each entry's cosine among all real coordinates.
    """
    same = nodal_diameter[:, None] == nodal_diameter[None, :]
    sines = np.where(paired, cosine + 1, cosine)
    size = sines[-1] + 1

    def over_entries(part: FloatArray) -> ComplexArray:
        whole = np.zeros((size, size))
        whole[np.ix_(coordinates, coordinates)] = part
        crossed = whole[np.ix_(sines, cosine)] * paired[:, None]
        return np.where(same, whole[np.ix_(cosine, cosine)] + 1j * crossed, 0.0)

    turned, pulled = over_entries(coriolis), over_entries(softening)
    return TurningRotor(
        coriolis=_clean(turned.real, turned) + 1j * turned.imag,
        softening=pulled.real + 1j * _clean(pulled.imag, pulled),
    )


def _clean(part: FloatArray, whole: ComplexArray) -> FloatArray:
    """Part of a matrix, zero where it is rounding."""
    limit = ROUNDING * np.abs(whole).max(initial=0.0)
    return part if np.abs(part).max(initial=0.0) > limit else np.zeros_like(part)
