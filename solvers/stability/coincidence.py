"""Modal coincidence of bladed disk and casing: where waves meet in the Campbell diagram, Eq. (14).

A wave with nodal diameter k that travels forward on the casing at omega_c, exp(i (k theta -
omega_c t)), is seen from the rotor, alpha = theta - Omega t, as exp(i (k alpha + (k Omega -
omega_c) t)): at k Omega - omega_c it travels backward. Where that is a frequency of the bladed
disk, omega_c = k Omega - omega_bd, both waves keep pace and contact feeds them both.

Blades slide forward over the casing, so friction drags waves backward on the rotor and forward on
the casing. Only this combination counts: two waves that travel in the same sense in their own
frames also meet, at (omega_c - omega_bd) / k or (omega_bd - omega_c) / k, but are not fed. Waves
with k = 0 do not travel and never meet. Mirror images are the same for Omega < 0, with forward and
backward exchanged, so speeds are given as magnitudes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from bladewhirl.meshes.line_mesh import FloatArray, IntArray


@dataclass(frozen=True, kw_only=True)
class Coincidences:
    """Coincidence speeds of pairs of modes with the same nodal diameter, ascending."""

    rotor: IntArray  #: number of the bladed disk's mode, (pairs,)
    casing: IntArray  #: number of the casing's mode, (pairs,)
    nodal_diameter: IntArray  #: k of both, 1 or more, (pairs,)
    speed: FloatArray  #: Omega_k^cr [rad/s], (pairs,)

    @property
    def count(self) -> int:
        """Number of pairs."""
        return len(self.speed)

    def between(self, lowest: float, highest: float) -> Coincidences:
        """Return the coincidences from ``lowest`` to ``highest`` [rad/s], limits included."""
        return self.take(np.flatnonzero((self.speed >= lowest) & (self.speed <= highest)))

    def take(self, chosen: IntArray) -> Coincidences:
        """Keep some pairs, by positions."""
        return Coincidences(
            rotor=self.rotor[chosen],
            casing=self.casing[chosen],
            nodal_diameter=self.nodal_diameter[chosen],
            speed=self.speed[chosen],
        )


def coincidences(
    *,
    rotor_frequency: ArrayLike,
    rotor_nodal_diameter: ArrayLike,
    casing_frequency: ArrayLike,
    casing_nodal_diameter: ArrayLike,
) -> Coincidences:
    """Coincidence speeds Omega = (omega_c + omega_bd) / k of every pair of modes with one k > 0.

    Args:
        rotor_frequency: of the bladed disk, a degenerate pair given once [rad/s], (modes,).
        rotor_nodal_diameter: of each, (modes,).
        casing_frequency: of the casing, a degenerate pair given once [rad/s], (modes,).
        casing_nodal_diameter: of each, (modes,).
    """
    rotor, casing = np.asarray(rotor_frequency, float), np.asarray(casing_frequency, float)
    rotor_k = np.asarray(rotor_nodal_diameter, np.int64)
    casing_k = np.asarray(casing_nodal_diameter, np.int64)
    on_rotor, on_casing = np.nonzero(
        (rotor_k[:, None] == casing_k[None, :]) & (rotor_k[:, None] > 0)
    )
    k = rotor_k[on_rotor]
    speed = (casing[on_casing] + rotor[on_rotor]) / k
    order = np.argsort(speed, kind="stable")
    return Coincidences(
        rotor=on_rotor[order], casing=on_casing[order], nodal_diameter=k[order], speed=speed[order]
    )
