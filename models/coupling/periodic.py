"""Coupled modes of a stage that no frame holds still: uneven bodies, unequal bearings, dampers.

The springs of Eq. (8) see the radial displacement of both bodies at every angle. Where a mode has
one nodal diameter only, they couple it with its likes (`coupling`). A mode of an uneven body holds
waves of several; with the cosine and sine part of each, A_k on the casing and B_k on the bladed
disk as rows over all modes,

    K*(t) = sum_k f_k kappa C_k^T C_k,    C_k = A_k - R(k Omega t) B_k,

R a rotation of the two parts. Nothing decouples, and the stiffness has the period of a turn. Shaft
springs that stand still and differ add anisotropy (X^T X - Y^T Y), X and Y the centre's
displacement along the static axes. On an even stage all this gives what `coupling` gives.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.meshes.ring_mesh import U, W
from bladewhirl.models.coupling.springs import spring_factor
from bladewhirl.models.coupling.stage_modes import FAMILIES, SMALLEST_AMPLITUDE, is_radial
from bladewhirl.models.elements.cyclic import evenly_spaced, wave_parts
from bladewhirl.models.inputs.mode_names import NamedModes, chosen_modes
from bladewhirl.models.modal.full_stage import ModalStage
from bladewhirl.models.modal.labels import LabelledModes


@dataclass(frozen=True, kw_only=True)
class UnevenSystem:
    """Modes of both bodies, those of the bladed disk first, and how the springs see them."""

    name: tuple[str, ...]  #: of each mode, (modes,)
    frequency: FloatArray  #: without the springs between the bodies [rad/s], (modes,)
    damping: FloatArray  #: D [1/s], (modes, modes)
    harmonics: IntArray  #: nodal diameters k of the waves, (harmonics,)
    casing: FloatArray  #: A_k: cosine and sine part of w [kg^-1/2], (harmonics, 2, modes)
    rotor: FloatArray  #: B_k: the same at the tips, rotating axes
    centre: FloatArray  #: x and y of the centre, rotating axes [kg^-1/2], (2, modes)
    anisotropy: float  #: of the shaft springs that stand still [N/m]

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


def uneven_system(modal: ModalStage, *, modes: str, damped: bool, physical: bool) -> UnevenSystem:
    """Couple modes of a full stage, whatever its symmetry.

    Args:
        modal: finite element models with their modes.
        modes: "six", "all" (of 1F to 5F, the suspension and the lowest radial casing modes), or
            names as in `reduction.modes`.
        damped: with the case's modal damping and the dampers of shaft and supports.
        physical: with the modes' own amplitudes, not one for the wave of each one's label.

    Raises:
        ValueError: modes that the stage does not have, or blades at uneven angles.
    """
    case, disk, casing = modal.case, modal.disk, modal.casing
    if not evenly_spaced(disk.tip_angles):
        raise ValueError("springs between the bodies need blades at equal angles")
    harmonics = np.arange(min(len(disk.tip_angles) // 2, (len(casing.mesh.angles) - 1) // 2) + 1)
    disk_modes, casing_modes = modal.disk_modes, modal.casing_modes
    on_rotor, on_casing = _chosen(modal, modes, harmonics)
    on_rotor, tips, rotor_waves = _with_waves(
        disk_modes, on_rotor, lambda fields: fields[disk.tip_radial], disk.tip_angles, harmonics
    )
    on_casing, wall, casing_waves = _with_waves(
        casing_modes,
        on_casing,
        lambda fields: casing.nodal(fields)[:, W],
        casing.mesh.angles,
        harmonics,
    )
    if not physical:
        rotor_waves = rotor_waves / _own(rotor_waves, disk_modes.nodal_diameter[on_rotor])
        casing_waves = casing_waves / _own(casing_waves, casing_modes.nodal_diameter[on_casing])
    frequency = np.concatenate([disk_modes.frequency[on_rotor], casing_modes.frequency[on_casing]])
    none = np.zeros((len(harmonics), 2, len(on_rotor) + len(on_casing)))
    rotor, ring, centre = none.copy(), none.copy(), none[0].copy()
    rotor[..., : len(on_rotor)], ring[..., len(on_rotor) :] = rotor_waves, casing_waves
    damping = np.zeros((len(frequency), len(frequency)))
    if not case.shaft.clamped:
        centre[:, : len(on_rotor)] = tips[disk.centre]
    if damped:
        held = np.zeros((casing.dampers.shape[0], len(frequency)))
        held[:, len(on_rotor) :] = casing.dampers @ wall
        rows = np.vstack([np.sqrt(case.shaft.dampings)[:, None] * centre, held])
        damping = np.diag(2.0 * case.damping.ratio * frequency) + rows.T @ rows
    return UnevenSystem(
        name=_names(disk_modes, on_rotor, "") + _names(casing_modes, on_casing, "casing "),
        frequency=frequency,
        damping=damping,
        harmonics=harmonics,
        casing=ring,
        rotor=rotor,
        centre=centre,
        anisotropy=0.0 if case.shaft.clamped else case.shaft.anisotropy,
    )


def _chosen(modal: ModalStage, modes: str, harmonics: IntArray) -> tuple[IntArray, IntArray]:
    disk, casing = modal.disk_modes, modal.casing_modes
    fields = modal.casing.nodal(casing.fields(np.arange(casing.count)))
    radial = is_radial(fields[:, W], fields[:, U])
    lowest = {
        int(k): np.flatnonzero(radial & (casing.nodal_diameter == k))[: 2 if k else 1]
        for k in harmonics
    }
    lowest = {k: found for k, found in lowest.items() if found.size}
    if modes == "all":
        families = [name for name in ("suspension", *FAMILIES) if name in disk.family]
        modes = ",".join([*families, "casing"])
    return chosen_modes(
        modes,
        NamedModes(family=disk.family, nodal_diameter=disk.nodal_diameter),
        NamedModes(family=casing.family, nodal_diameter=casing.nodal_diameter),
        lowest,
    )


def _own(waves: FloatArray, label: IntArray) -> FloatArray:
    """Amplitude of each mode's wave of its own nodal diameter, (modes,)."""
    return np.asarray(np.linalg.norm(waves[label, :, np.arange(len(label))], axis=1))


def _with_waves(
    modes: LabelledModes,
    chosen: IntArray,
    radial: Callable[[FloatArray], FloatArray],
    angle: FloatArray,
    harmonics: IntArray,
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Modes that move radially, their fields and waves; the others feel no spring."""
    fields = modes.fields(chosen)
    waves = wave_parts(radial(fields), angle, harmonics)
    size = _own(waves, modes.nodal_diameter[chosen])
    moving = size > SMALLEST_AMPLITUDE * size.max(initial=0.0)
    return chosen[moving], fields[:, moving], waves[..., moving]


def _names(modes: LabelledModes, chosen: IntArray, prefix: str) -> tuple[str, ...]:
    return tuple(f"{prefix}{modes.family[i]} k={modes.nodal_diameter[i]}" for i in chosen)


def _turned(angle: FloatArray) -> FloatArray:
    """Rotation matrices, (m, 2, 2)."""
    cos, sin = np.cos(angle), np.sin(angle)
    return np.stack([np.stack([cos, -sin], axis=-1), np.stack([sin, cos], axis=-1)], axis=-2)
