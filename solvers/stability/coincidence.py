"""Modal coincidence: speeds at which waves of bladed disk and casing meet, Eq. (14).

A wave with nodal diameter k that travels forward on the casing at omega_c, exp(i (k theta -
omega_c t)), is seen from the rotor, alpha = theta - Omega t, as exp(i (k alpha + (k Omega -
omega_c) t)): in rotor axes the wave travels backward with the frequency k Omega - omega_c. If this
is a natural frequency omega_bd of the bladed disk, both waves rotate together and contact excites
both.

Blades slide forward over the casing, so friction excites backward waves on the rotor and forward
waves on the casing. Only this combination is computed. Two waves that travel in the same direction,
each relative to its own body, also meet, at (omega_c - omega_bd) / k or (omega_bd - omega_c) / k,
but contact does not excite them. Waves with k = 0 do not travel and never meet. For Omega < 0
forward and backward are exchanged, with equal speeds; therefore speeds are magnitudes.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from bladewhirl.meshes.line_mesh import FloatArray, IntArray


@dataclass(frozen=True, kw_only=True)
class Coincidences:
    """Coincidence speeds of pairs of modes with the same nodal diameter, ascending."""

    rotor: IntArray  #: number of the mode of the bladed disk, (pairs,)
    casing: IntArray  #: number of the mode of the casing, (pairs,)
    nodal_diameter: IntArray  #: nodal diameter k of both modes, 1 or more, (pairs,)
    speed: FloatArray  #: Omega_k^cr [rad/s], (pairs,)


def coincidences(
    *,
    rotor_frequency: ArrayLike,
    rotor_nodal_diameter: ArrayLike,
    casing_frequency: ArrayLike,
    casing_nodal_diameter: ArrayLike,
) -> Coincidences:
    """Return coincidence speeds (omega_c + omega_bd) / k of all pairs of modes with equal k > 0.

    Args:
        rotor_frequency: natural frequencies of the bladed disk, one for each pair [rad/s],
            (modes,).
        rotor_nodal_diameter: nodal diameters of these modes, (modes,).
        casing_frequency: natural frequencies of the casing, one for each pair [rad/s], (modes,).
        casing_nodal_diameter: nodal diameters of these modes, (modes,).
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
