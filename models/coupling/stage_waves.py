"""Coupled modes of a stage whose modes have several nodal diameters each.

See `equations` for the equations, `stage_modes` for modes with one nodal diameter each.
"""

from collections.abc import Callable

import numpy as np
import scipy.linalg as la

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.meshes.ring_mesh import U, W
from bladewhirl.models.case.file import case_fault
from bladewhirl.models.coupling.equations import CoupledEquations
from bladewhirl.models.coupling.stage_modes import FAMILIES, SMALLEST_AMPLITUDE, is_radial
from bladewhirl.models.elements.cyclic import evenly_spaced, wave_parts
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.inputs.mode_names import ALL, SIX, chosen_modes
from bladewhirl.models.modal.labels import LabelledModes
from bladewhirl.models.modal.modal_model import ModalModel
from bladewhirl.models.structure.rotating import Rotating


def standing_obstacles(modal: ModalModel, *, damped: bool) -> tuple[str, ...]:
    """Return the reasons why no frame makes a coupled stage autonomous; no reasons if a frame does.

    The casing must be axisymmetric, stationary shaft springs must be equal, and all damping must
    be modal. If `damped`, the equations include the dampers at points.
    """
    shaft, casing = modal.case.shaft, modal.casing
    obstacles = []
    if not casing.structure.is_cyclic:
        obstacles.append("the casing is not axisymmetric")
    if shaft.anisotropy != 0.0 and not shaft.clamped:
        obstacles.append("the stationary shaft springs are unequal")
    if damped and (casing.dampers.shape[0] or (any(shaft.dampings) and not shaft.clamped)):
        obstacles.append("--damped includes dampers at points")
    return tuple(obstacles)


def coupled_waves(
    modal: ModalModel, *, modes: str, damped: bool, physical: bool
) -> CoupledEquations:
    """Return the equations of coupled modes of any full stage, cyclic or not.

    If a frame makes the equations autonomous, only nodal diameters of the casing modes are kept.

    Args:
        modal: finite element models with their modes.
        modes: "all" (families 1F to 5F, the suspension and the lowest radial casing modes; without
            sectors, the six lowest modes per blade replace the families), names as in
            `reduction.modes`, or "six" (the modes of the paper; if blades differ, all modes of
            their families).
        damped: add the modal damping and the dampers of shaft and supports.
        physical: use the computed amplitudes of the modes; if false, every amplitude is 1.

    Raises:
        ValueError: the stage does not have the modes, or the blades are not evenly spaced.
        CaseError: `damped` is true, and the dampers of the shaft are stationary.
    """
    case, disk, casing = modal.case, modal.beams, modal.casing
    if damped and case.shaft.damping_frame == "static":
        expected = '"rotating" for the stability of damped modes'
        raise CaseError([case_fault(case, "shaft.damping_frame", expected)])
    if not evenly_spaced(disk.tip_angles):
        raise ValueError("springs between the bodies need blades at equal angles")
    still = not standing_obstacles(modal, damped=damped)
    most = min(len(disk.tip_angles) // 2, (len(casing.mesh.angles) - 1) // 2)
    harmonics: IntArray = np.arange(most + 1)
    disk_modes, casing_modes = modal.disk_modes, modal.casing_modes
    by_family = still and bool(np.any(disk.blade_columns(disk_modes.column) < 0))
    on_rotor, on_casing = _chosen(modal, modes, harmonics, by_family=by_family)
    on_rotor, disk_fields, rotor_waves = _with_waves(
        disk_modes, on_rotor, lambda fields: fields[disk.tip_radial], disk.tip_angles, harmonics
    )
    on_casing, casing_fields, casing_waves = _with_waves(
        casing_modes,
        on_casing,
        lambda fields: casing.nodal(fields)[:, W],
        casing.mesh.angles,
        harmonics,
    )
    if still:
        kept = np.isin(harmonics, casing_modes.nodal_diameter[on_casing])
        harmonics = harmonics[kept]
        rotor_waves, casing_waves = rotor_waves[kept], casing_waves[kept]
    if not (rotor_waves.any() and casing_waves.any()):
        raise ValueError(f"{modes}: expected modes of both bodies that can be coupled by springs")
    if not physical:
        rotor_waves = rotor_waves / np.linalg.norm(rotor_waves, axis=(0, 1))
        casing_waves = casing_waves / np.linalg.norm(casing_waves, axis=(0, 1))
    frequency = np.concatenate([disk_modes.frequency[on_rotor], casing_modes.frequency[on_casing]])
    rotor, size = len(on_rotor), len(frequency)
    waves, turning = np.zeros((2, len(harmonics), 2, size)), np.zeros((size, size))
    waves[0, ..., :rotor], waves[1, ..., rotor:] = rotor_waves, casing_waves
    cosine = rotor + np.flatnonzero(casing_modes.column[on_casing] % 2 == 1)
    k = casing_modes.nodal_diameter[on_casing[cosine - rotor]]
    if still:
        turning[cosine + 1, cosine], turning[cosine, cosine + 1] = k, -k
    centre, damping = np.zeros((2, size)), np.zeros((size, size))
    if not case.shaft.clamped:
        centre[:, :rotor] = disk_fields[disk.centre]
    if damped:
        strength = np.sqrt(case.shaft.dampings)[:, None]
        dampers = la.block_diag(strength * centre[:, :rotor], casing.dampers @ casing_fields)
        damping = np.diag(2.0 * case.damping.ratio * frequency) + dampers.T @ dampers
    return CoupledEquations(
        name=_names(modal, on_rotor, on_casing, by_family=by_family),
        structure=Rotating(
            mass=np.eye(size), stiffness=np.diag(frequency * np.abs(frequency)), damping=damping
        ),
        harmonics=harmonics,
        casing=waves[1],
        rotor=waves[0],
        centre=centre,
        anisotropy=0.0 if case.shaft.clamped else case.shaft.anisotropy,
        turning=turning if still else None,
    )


def _chosen(
    modal: ModalModel, modes: str, harmonics: IntArray, *, by_family: bool
) -> tuple[IntArray, IntArray]:
    """Return the numbers of the selected modes of bladed disk and casing."""
    disk, casing = modal.disk_modes, modal.casing_modes
    fields = modal.casing.nodal(casing.fields(np.arange(casing.count)))
    radial = is_radial(fields[:, W], fields[:, U])
    lowest = {
        int(k): np.flatnonzero(radial & (casing.nodal_diameter == k))[: 2 if k else 1]
        for k in harmonics
    }
    lowest = {k: numbers for k, numbers in lowest.items() if numbers.size}
    if modes == ALL and disk.layout is None:
        count = min((len(FAMILIES) + 1) * len(modal.beams.tip_angles), disk.count)
        return np.arange(count), np.sort(np.concatenate([*lowest.values()]))
    if modes == ALL or (modes == SIX and by_family):
        names = ("suspension", *FAMILIES) if modes == ALL else ("suspension", "1F")
        families = [name for name in names if name in disk.family]
        modes = ",".join([*families, "casing" if modes == ALL else "casing:1"])
    return chosen_modes(modes, disk.named, casing.named, lowest)


def _with_waves(
    modes: LabelledModes,
    chosen: IntArray,
    radial: Callable[[FloatArray], FloatArray],
    angle: FloatArray,
    harmonics: IntArray,
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return numbers, fields and wave parts (see `wave_parts`) of the modes that move radially."""
    fields = modes.fields(chosen)
    waves = wave_parts(radial(fields), angle, harmonics)
    size = np.linalg.norm(waves, axis=(0, 1))
    moving = size > SMALLEST_AMPLITUDE * size.max(initial=0.0)
    return chosen[moving], fields[:, moving], waves[..., moving]


def _names(
    modal: ModalModel, on_rotor: IntArray, on_casing: IntArray, *, by_family: bool
) -> tuple[str, ...]:
    disk, casing = modal.disk_modes, modal.casing_modes
    if by_family:
        wall = [f"casing k={k}" for k in np.unique(casing.nodal_diameter[on_casing])]
        names = [*wall, *(disk.family[i] for i in on_rotor)]
    else:
        names = [f"{disk.family[i]} k={disk.nodal_diameter[i]}" for i in on_rotor]
        names += [f"casing {casing.family[i]} k={casing.nodal_diameter[i]}" for i in on_casing]
    return tuple(dict.fromkeys(names))
