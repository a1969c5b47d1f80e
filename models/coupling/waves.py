"""Coupled modes that mix nodal diameters: uneven bodies, unequal bearings, dampers.

The springs of Eq. (8) see the radial displacement of both bodies at every angle. Where each mode
has one nodal diameter, they couple it with its likes (`springs`). A mode of an uneven body holds
waves of several; with the cosine and sine part of each, A_k on the casing and B_k on the bladed
disk as rows over all modes,

    K*(t) = sum_k f_k kappa C_k^T C_k,    C_k = A_k - R(k Omega t) B_k,

R a rotation of the two parts. Nothing decouples, and the stiffness has the period of a turn. Shaft
springs that stand still and differ add anisotropy (X^T X - Y^T Y), X and Y the centre's
displacement along the static axes.

Where the casing is the same all round and nothing else stands still, rotating axes hold the stage
still: with x = exp(Omega t J) y, J turning the casing's pairs by k,

    y'' + (D + 2 Omega J) y' + (K(0) + Omega^2 J^2 + Omega D J) y = 0.

On an even stage all this gives what `springs` gives.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.coupling.springs import spring_factor


@dataclass(frozen=True, kw_only=True)
class CoupledWaves:
    """Modes of both bodies, the bladed disk first, and their radial waves at the springs."""

    name: tuple[str, ...]  #: for tables, fewer where modes share one
    frequency: FloatArray  #: without the springs between the bodies [rad/s], (modes,)
    damping: FloatArray  #: D [1/s], (modes, modes)
    harmonics: IntArray  #: nodal diameters k of the waves, (harmonics,)
    casing: FloatArray  #: A_k: cosine and sine part of w [kg^-1/2], (harmonics, 2, modes)
    rotor: FloatArray  #: B_k: the same at the tips, rotating axes
    centre: FloatArray  #: x and y of the centre, rotating axes [kg^-1/2], (2, modes)
    anisotropy: float  #: of the shaft springs that stand still [N/m]
    turning: FloatArray | None = None
    """J, (modes, modes); None where no frame holds the stage still."""

    def stiffness(self, angle: FloatArray, kappa: float, *, with_pi: bool = True) -> FloatArray:
        """Stiffness at angles Omega t [rad] (m,), as (m, modes, modes) [1/s^2].

        Args:
            angle: [rad], (m,).
            kappa: stiffness of the springs between the bodies [N/m] per radian.
            with_pi: keep the factor pi of the integral.
        """
        total = np.zeros((len(angle), len(self.frequency), len(self.frequency)))
        total += np.diag(self.frequency**2)
        for k, on_casing, on_rotor in zip(self.harmonics, self.casing, self.rotor, strict=True):
            stretch = on_casing - _turned(k * angle) @ on_rotor
            factor = kappa * spring_factor(int(k), with_pi=with_pi)
            total += factor * np.swapaxes(stretch, -1, -2) @ stretch
        moved = _turned(angle) @ self.centre
        squares = moved[:, :, :, None] * moved[:, :, None, :]
        return total + self.anisotropy * (squares[:, 0] - squares[:, 1])

    def state_matrix(self, speed: float, kappa: float, *, with_pi: bool = True) -> FloatArray:
        """Return S of dz/dt = S z with z = (y, dy/dt), (2 modes, 2 modes); at rest for any stage.

        Args:
            speed: Omega [rad/s].
            kappa: stiffness of the springs between the bodies [N/m] per radian.
            with_pi: keep the factor pi of the integral.

        Raises:
            ValueError: a stage in rotation that no frame holds still.
        """
        if self.turning is None and speed != 0.0:
            raise ValueError("no frame holds this stage still: it is periodic")
        size = len(self.frequency)
        turn = np.zeros((size, size)) if self.turning is None else speed * self.turning
        stiffness = self.stiffness(np.zeros(1), kappa, with_pi=with_pi)[0]
        stiffness += turn @ turn + self.damping @ turn
        drag = self.damping + 2.0 * turn
        return np.block([[np.zeros((size, size)), np.eye(size)], [-stiffness, -drag]])


def _turned(angle: FloatArray) -> FloatArray:
    """Rotation matrices, (m, 2, 2)."""
    cos, sin = np.cos(angle), np.sin(angle)
    return np.stack([np.stack([cos, -sin], axis=-1), np.stack([sin, cos], axis=-1)], axis=-2)
