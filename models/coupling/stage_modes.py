"""Modes of rotor and casing that springs couple, and the amplitudes of the modes at the springs."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from bladewhirl.meshes.line_mesh import BoolArray, FloatArray, IntArray
from bladewhirl.meshes.ring_mesh import U, W
from bladewhirl.models.coupling.springs import CoupledEntries, CouplingModes
from bladewhirl.models.elements.bladed_disk import BladedDiskModel
from bladewhirl.models.elements.casing import CasingModel
from bladewhirl.models.elements.cyclic import wave_parts
from bladewhirl.models.elements.structure import Structure
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.modal.labels import LabelledModes
from bladewhirl.models.modal.modal_model import ModalModel
from bladewhirl.models.modal.modes import ModeTable

FAMILIES = tuple(f"{rank}F" for rank in range(1, 6))
"""Families of the bladed disk that are coupled, besides the suspension pair."""

RADIAL_SHARE = 1.0 / 3.0
"""Least share of radial motion in a radial mode. The share is k^2 / (1 + k^2) in bending modes of a
ring with k nodal diameters, so 1/2 for k = 1; in extensional modes it is 1 / (1 + k^2)."""

SMALLEST_AMPLITUDE = 1e-9
"""A mode is coupled if its amplitude exceeds this fraction of the largest amplitude on the same
body."""

ROUNDING = 1e-9
"""Entries up to this fraction of the largest entry count as zero by mirror symmetry."""

Fields = Callable[[IntArray], FloatArray]


@dataclass(frozen=True, kw_only=True)
class StageModes(CoupledEntries):
    """Coupled modes of a full stage."""

    modal: ModalModel  #: finite elements and all modes of bladed disk and casing


def stage_modes(modal: ModalModel, *, damping_ratio: float) -> StageModes:
    """Collect the modes of a full stage that are coupled by the springs; see `coupled_entries`.

    Args:
        modal: finite element models with all their modes.
        damping_ratio: modal damping ratio of all modes.

    Raises:
        ValueError: the stage has no cyclic symmetry, so its modes have no nodal diameter.
        UserError: the wall is rigid.
    """
    disk, wall = modal.disk_modes, modal.casing_modes
    if not wall.count:
        raise UserError('expected casing.type = "ring": springs couple waves of both bodies')
    coupled = coupled_entries(
        tip_motion(modal.beams, disk, disk.family, disk.fields),
        wall_motion(modal.casing, wall),
        damping_ratio=damping_ratio,
    )
    return StageModes(modes=coupled.modes, number=coupled.number, modal=modal)


def at_speed(stage: StageModes, structure: Structure) -> StageModes:
    """Add the change of the stiffness by rotation and any Coriolis forces to the coupled modes.

    Args:
        stage: coupled modes at rest.
        structure: structure of the bladed disk.
    """
    modes = stage.modes
    coordinates, numbers = stage.coordinates(on_casing=False)
    fields = stage.modal.disk_modes.fields(numbers)
    among = np.ix_(coordinates, coordinates)
    mirrored = modes.is_sine[:, None] == modes.is_sine
    found: dict[str, Any] = {}
    for name, small in structure.projected(fields, ("gyroscopic", "stiffness_speed")).items():
        matrix = np.zeros((modes.size, modes.size))
        matrix[among] = small
        forbidden = mirrored if name == "gyroscopic" else ~mirrored
        if np.abs(matrix[forbidden]).max() <= ROUNDING * np.abs(matrix).max():
            matrix[forbidden] = 0.0  # the disk has mirror symmetry
        found[name] = matrix
    return replace(stage, modes=replace(modes, **found))


@dataclass(frozen=True, kw_only=True)
class RadialModes:
    """Radial motion, at the springs, in the modes of the bladed disk or of the casing."""

    frequency: FloatArray  #: natural frequency [rad/s], (modes,)
    nodal_diameter: IntArray  #: nodal diameter of each mode, (modes,)
    column: IntArray  #: column in the real Fourier basis, (modes,); -1 without symmetry
    family: tuple[str, ...]  #: family of each mode, (modes,)
    angles: FloatArray  #: angles of tips or casing nodes, equally spaced [rad], (points,)
    motion: Callable[[IntArray], tuple[FloatArray, FloatArray]]
    """Function that takes numbers of modes and returns their radial and tangential displacement at
    these points [kg^-1/2], (points, chosen) each."""

    @property
    def is_cyclic(self) -> bool:
        """True if each mode has one nodal diameter."""
        return bool(np.all(self.column >= 0))

    def amplitudes(
        self, selected: BoolArray, *, radial_only: bool = False
    ) -> tuple[IntArray, FloatArray]:
        """Return the numbers and amplitudes of the selected modes that move radially.

        Of each cosine and sine pair only the cosine mode is returned.

        Args:
            selected: mask of modes, (modes,).
            radial_only: leave out modes that are not radial, see `is_radial`.

        Returns:
            Numbers, ascending, and coefficients of cos k theta in the radial motion [kg^-1/2].
        """
        one_a_pair = (self.column % 2 != 0) | (self.column == 0)
        numbers = np.flatnonzero(one_a_pair & selected)
        outward, along = self.motion(numbers)
        k, place = np.unique(self.nodal_diameter[numbers], return_inverse=True)
        values = wave_parts(outward, self.angles, k)[place, 0, np.arange(len(numbers))]
        moving = np.abs(values) > SMALLEST_AMPLITUDE * np.abs(values).max(initial=0.0)
        if radial_only:
            moving &= is_radial(outward, along)
        return numbers[moving], values[moving]


def coupled_entries(
    rotor: RadialModes, casing: RadialModes, *, damping_ratio: float
) -> CoupledEntries:
    """Select the modes that are coupled by the springs: modes with radial motion at the springs.

    From the bladed disk, these are the suspension pair and the modes of `FAMILIES`. From the
    casing, they are the lowest radial mode of each nodal diameter below half the number of
    elements, if the bladed disk has modes with this nodal diameter. The amplitude of a mode is the
    coefficient of cos k theta in its radial displacement at the tips or casing nodes.

    Args:
        rotor: modes of the bladed disk, ascending.
        casing: modes of the casing, ascending.
        damping_ratio: modal damping ratio of all modes.

    Raises:
        ValueError: the stage has no cyclic symmetry, so its modes have no nodal diameter.
    """
    if not (rotor.is_cyclic and casing.is_cyclic):
        raise ValueError("coupling by nodal diameter needs a stage with cyclic symmetry")
    blades, elements = len(rotor.angles), len(casing.angles)
    tips, tip_amplitude = rotor.amplitudes(np.isin(rotor.family, ("suspension", *FAMILIES)))
    wall, wall_amplitude = lowest_radial(casing, rotor.nodal_diameter[tips])
    on_casing = np.arange(len(wall) + len(tips)) < len(wall)
    k = np.append(casing.nodal_diameter[wall], rotor.nodal_diameter[tips])
    families = ["casing"] * len(wall) + [rotor.family[i] for i in tips]
    order = np.lexsort((~on_casing, k))
    modes = CouplingModes(
        name=tuple(
            families[i] if families[i] == "suspension" else f"{families[i]} k={k[i]}" for i in order
        ),
        on_casing=on_casing[order],
        nodal_diameter=k[order],
        frequency=np.append(casing.frequency[wall], rotor.frequency[tips])[order],
        amplitude=np.append(wall_amplitude, tip_amplitude)[order],
        damping_ratio=np.full(len(order), damping_ratio),
        paired=((k > 0) & (2 * k < np.where(on_casing, elements, blades)))[order],
    )
    return CoupledEntries(modes=modes, number=np.append(wall, tips)[order])


def lowest_radial(casing: RadialModes, diameters: ArrayLike) -> tuple[IntArray, FloatArray]:
    """Return numbers and amplitudes of the lowest radial mode of the casing of each of the given
    nodal diameters below half the number of elements; see `RadialModes.amplitudes`."""
    elements = len(casing.angles)
    wall, amplitude = casing.amplitudes(2 * casing.nodal_diameter < elements, radial_only=True)
    present, lowest = np.unique(casing.nodal_diameter[wall], return_index=True)
    lowest = lowest[np.isin(present, diameters)]
    return wall[lowest], amplitude[lowest]


def tip_motion(
    disk: BladedDiskModel, modes: ModeTable, family: tuple[str, ...], fields: Fields
) -> RadialModes:
    """Return the radial motion of the tips in the modes of a full or reduced bladed disk.

    Args:
        disk: the finite element model.
        modes: table of the modes.
        family: family of each mode, (modes,).
        fields: function that takes numbers of modes and returns their displacements at the free
            degrees of freedom, (size, chosen).
    """

    def motion(chosen: IntArray) -> tuple[FloatArray, FloatArray]:
        field = fields(chosen)
        return field[disk.tip_radial], field[disk.tip_tangential]

    return RadialModes(
        frequency=modes.frequency,
        nodal_diameter=modes.nodal_diameter,
        column=disk.blade_columns(modes.column),
        family=family,
        angles=disk.tip_angles - disk.tip_angles[0],
        motion=motion,
    )


def wall_motion(casing: CasingModel, modes: LabelledModes) -> RadialModes:
    """Return the radial motion of the wall in modes of a casing; see `tip_motion`."""

    def motion(chosen: IntArray) -> tuple[FloatArray, FloatArray]:
        nodal = casing.nodal(modes.fields(chosen))
        return nodal[:, W], nodal[:, U]

    return RadialModes(
        frequency=modes.frequency,
        nodal_diameter=modes.nodal_diameter,
        column=modes.column,
        family=modes.family,
        angles=casing.mesh.angles,
        motion=motion,
    )


def is_radial(outward: FloatArray, along: FloatArray) -> BoolArray:
    """Return a mask of the radial casing modes, on which springs and casing distortions act.

    Args:
        outward: w at the nodes, (nodes, modes).
        along: u at the nodes, (nodes, modes).
    """
    radial, tangential = np.sum(outward**2, axis=0), np.sum(along**2, axis=0)
    return np.asarray(radial >= RADIAL_SHARE * (radial + tangential))
