"""Springs between a bladed disk without cyclic symmetry and a casing with it, in rotating axes.

Every mode of such a bladed disk moves its tips in many nodal diameters at once. In rotating axes
the coupled system is still autonomous, since the casing looks the same from everywhere: with
z = v_c + i v_s of a casing pair, w = Re(z exp(-i k theta)) and theta = alpha + Omega t, the
coordinate y = z exp(-i k Omega t) obeys

    y'' + (D + 2 i k Omega) y' + (omega^2 - k^2 Omega^2 + i k Omega D) y = 0

apart from the springs, whose stretch of nodal diameter k is a_k y minus what the rotor's modes
have of cos k alpha and sin k alpha (Eq. 8; see `coupling` for the cyclic case).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from bladewhirl.meshes.line_mesh import BoolArray, FloatArray, IntArray
from bladewhirl.models.coupling.springs import spring_factor
from bladewhirl.models.coupling.stage_modes import (
    FAMILIES,
    SMALLEST_AMPLITUDE,
    casing_motion,
    lowest_radial,
)
from bladewhirl.models.elements.cyclic import evenly_spaced, wave_parts
from bladewhirl.models.modal.full_stage import ModalStage


@dataclass(frozen=True, kw_only=True)
class DenseModes:
    """Coupled modes: coordinates are those of the rotor, then cosine and sine of each casing k."""

    family: tuple[str, ...]  #: of each rotor mode, (rotor modes,)
    nodal_diameter: IntArray  #: that holds most of each; -1 where none is known, (rotor modes,)
    rotor_frequency: FloatArray  #: [rad/s], (rotor modes,)
    waves: FloatArray
    """Part of cos k alpha and of sin k alpha at the tips [kg^-1/2], (casing ks, 2, rotor modes)."""
    casing_diameter: IntArray  #: k of each casing mode, (casing ks,)
    casing_frequency: FloatArray  #: [rad/s], (casing ks,)
    casing_amplitude: FloatArray  #: of w [kg^-1/2], (casing ks,)
    damping_ratio: float  #: of every mode

    @property
    def name(self) -> tuple[str, ...]:
        """What to call each mode, the casing's first."""
        casing = (f"casing k={k}" for k in self.casing_diameter)
        return (*casing, *dict.fromkeys(self.family))

    @property
    def size(self) -> int:
        """Number of real coordinates."""
        return len(self.family) + int(np.sum(1 + (self.casing_diameter > 0)))

    def take(self, rotor: BoolArray, casing: BoolArray) -> DenseModes:
        """Keep some modes, by masks."""
        return replace(
            self,
            family=tuple(self.family[i] for i in np.flatnonzero(rotor)),
            nodal_diameter=self.nodal_diameter[rotor],
            rotor_frequency=self.rotor_frequency[rotor],
            waves=self.waves[casing][:, :, rotor],
            casing_diameter=self.casing_diameter[casing],
            casing_frequency=self.casing_frequency[casing],
            casing_amplitude=self.casing_amplitude[casing],
        )

    def state_matrix(self, speed: float, kappa: float, *, with_pi: bool = True) -> FloatArray:
        """S of dz/dt = S z with z = (x, dx/dt), (2 size, 2 size).

        Args:
            speed: Omega [rad/s].
            kappa: spring stiffness [N/m] per radian.
            with_pi: keep the factor pi of Eq. (8).
        """
        rotor, size = len(self.family), self.size
        stiffness, damping = np.zeros((size, size)), np.zeros((size, size))
        own = np.arange(rotor)
        stiffness[own, own] = self.rotor_frequency**2
        damping[own, own] = 2.0 * self.damping_ratio * self.rotor_frequency
        first = rotor
        for i, k in enumerate(self.casing_diameter.tolist()):
            count = 2 if k else 1
            here = slice(first, first + count)
            turn = k * speed * np.array([[0.0, -1.0], [1.0, 0.0]])[:count, :count]
            frequency = self.casing_frequency[i]
            rate = 2.0 * self.damping_ratio * frequency
            damping[here, here] = rate * np.eye(count) + 2.0 * turn
            stiffness[here, here] = (frequency**2 - (k * speed) ** 2) * np.eye(count) + rate * turn
            stretch = np.zeros((count, size))
            stretch[:, here] = self.casing_amplitude[i] * np.eye(count)
            stretch[:, :rotor] = -self.waves[i, :count]
            stiffness += spring_factor(k, with_pi=with_pi) * kappa * stretch.T @ stretch
            first += count
        return np.block([[np.zeros((size, size)), np.eye(size)], [-stiffness, -damping]])


def dense_modes(modal: ModalStage, *, damping_ratio: float) -> DenseModes:
    """Collect the modes that the springs couple, without use of the bladed disk's symmetry.

    Of the bladed disk these are the suspension pair and `FAMILIES`, or, where it has no sectors
    that name them, as many of the lowest; of the casing the lowest radial one of each nodal
    diameter that the tips can have.

    Args:
        modal: finite element models with all their modes.
        damping_ratio: of every mode.

    Raises:
        ValueError: a casing without cyclic symmetry, or tips at unequal angles.
    """
    disk, modes, wall = modal.disk, modal.disk_modes, modal.casing_modes
    if np.any(wall.column < 0):
        raise ValueError("expected a casing with cyclic symmetry, or a bladed disk with it")
    if not evenly_spaced(disk.tip_angles):
        raise ValueError("expected tips at equal angles on a stage without cyclic symmetry")
    blades = len(disk.tip_angles)
    named = np.isin(np.array(modes.family), ["suspension", *FAMILIES])
    if disk.structure.layout is None:
        named = np.arange(modes.count) < (len(FAMILIES) + 1) * blades
    numbers = np.flatnonzero(named)
    field = modes.fields(numbers)[disk.tip_radial]
    angle = disk.tip_angles - disk.tip_angles[0]
    lowest = lowest_radial(casing_motion(modal.casing, wall))
    diameters = np.array(sorted(k for k in lowest if 2 * k <= blades), dtype=np.int64)
    chosen = [lowest[k] for k in diameters.tolist()]
    waves = wave_parts(field, angle, diameters)
    size = np.linalg.norm(waves, axis=(0, 1))
    moving = size > SMALLEST_AMPLITUDE * size.max(initial=0.0)
    numbers = numbers[moving]
    return DenseModes(
        family=tuple(modes.family[i] for i in numbers),
        nodal_diameter=modes.nodal_diameter[numbers],
        rotor_frequency=modes.frequency[numbers],
        waves=waves[:, :, moving],
        casing_diameter=diameters,
        casing_frequency=np.array([wall.frequency[number] for number, _ in chosen]),
        casing_amplitude=np.array([amplitude for _, amplitude in chosen]),
        damping_ratio=damping_ratio,
    )
