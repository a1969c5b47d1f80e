"""Bladed disk and casing in their modes: what modal studies need, whatever the disk was built
from."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from bladewhirl.meshes.line_mesh import IntArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.superelement import SOURCE
from bladewhirl.models.elements.bladed_disk import BladedDiskModel
from bladewhirl.models.elements.casing import CasingModel
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.modal.labels import LabelledModes
from bladewhirl.models.modal.modal_disk import ModalDisk
from bladewhirl.models.modal.modes import ListedModes
from bladewhirl.models.modal.stage_arrays import StageArrays
from bladewhirl.models.rotation.unequal_bearings import on_bearings
from bladewhirl.models.structure.rotating import Effects
from bladewhirl.models.structure.waves import Waves

FAMILIES = 12  #: default number of modes of each nodal diameter of a superelement


@dataclass(frozen=True, kw_only=True)
class ModalModel:
    """Bladed disk and casing in their modes, at any speed of rotation."""

    case: Case
    reference_frequency: float
    """Lowest natural frequency of the bladed disk at rest, with a free centre [rad/s]."""
    casing: CasingModel  #: finite element model of the casing; of a rigid wall only a circle
    casing_modes: LabelledModes  #: modes of the casing; none for a rigid wall
    wall_arrays: Callable[[IntArray], Mapping[str, Any]]
    """Function that returns the arrays of the wall by name, with modes of the casing by number."""
    disks_up_to: Callable[[float], Mapping[str, ModalDisk]]
    """Function that returns the bladed disk by the state of its centre, "free" or "clamped", for
    speeds up to one [rad/s]; without "free" if its centre cannot move."""
    highest: float  #: highest speed for which `disks` are made [rad/s]; infinite for any

    @cached_property
    def disks(self) -> Mapping[str, ModalDisk]:
        """Bladed disk by the state of its centre, "free" or "clamped".

        Raises:
            CaseError: the superelement cannot be reduced as the case demands.
        """
        return self.disks_up_to(self.highest)

    def covering(self, highest: float) -> "ModalModel":
        """Return the model for speeds up to the highest one [rad/s], on which a basis of modes may
        depend; what takes long is computed."""
        model = self
        if self.case.rotation.effects != "none" and highest > self.highest:
            model = replace(self, highest=highest)
        assert model.disk_modes.count
        return model

    @property
    def centre(self) -> str:
        """State of the centre as the case requires it, "free" or "clamped"."""
        return "clamped" if self.case.shaft.clamped or "free" not in self.disks else "free"

    @property
    def disk(self) -> ModalDisk:
        """Bladed disk with a free or a clamped centre, as the case requires."""
        return self.disks[self.centre]

    @property
    def speed(self) -> float:
        """Speed of rotation of the case [rad/s], counter-clockwise."""
        return self.case.march.speed.rad_per_s(self.reference_frequency)

    @property
    def effects(self) -> Effects:
        """Effects of the rotation that act on the bladed disk."""
        return self.disk.effects

    @property
    def turns(self) -> bool:
        """True if the frequencies depend on the speed of rotation."""
        return self.effects != "none"

    @property
    def listed_modes(self) -> ListedModes:
        """Modes of the bladed disk at the speed of the case, with a free or a clamped centre as the
        case requires."""
        return self.disk.listed

    @property
    def disk_modes(self) -> LabelledModes:
        """Modes of the bladed disk without Coriolis forces, with a free or a clamped centre as the
        case requires."""
        return self.disk.labelled

    @property
    def beams(self) -> BladedDiskModel:
        """Finite elements of a bladed disk of beams, see `ModalDisk.beams`."""
        return self.disk.beams

    def arrays(self, modes: ListedModes, numbers: IntArray, on_casing: IntArray) -> StageArrays:
        """Return the arrays of the stage with some modes of both bodies, see `ModalDisk.arrays`.

        Args:
            modes: `listed_modes` or `disk_modes`.
            numbers: numbers of modes among them.
            on_casing: numbers of modes among `casing_modes`; ignored with a rigid wall.
        """
        return self.disk.arrays(modes, numbers, self.wall_arrays(on_casing))

    @property
    def waves(self) -> Mapping[int, Waves]:
        """Waves of each nodal diameter, with a free or a clamped centre as the case requires.

        Raises:
            UserError: the sectors of the bladed disk differ.
        """
        return self._on_bearings(self.disk)

    @property
    def shaft_waves(self) -> Waves:
        """Waves of nodal diameter 1 with a free centre on the springs of the shaft.

        Raises:
            UserError: the sectors differ, or the bladed disk has no centre that moves, or its
                critical speeds do not follow from its matrices.
        """
        free = self._free("critical speeds", "whirls on the springs of the shaft")
        if self.case.rotation.effects != "full":
            raise UserError(
                'critical speeds: expected rotation.effects = "full" (--set rotation.effects=full),'
                f" got {self.case.rotation.effects}: without spin softening no whirl is stationary"
                " in rotating axes"
            )
        return self._on_bearings(free)[1]

    @property
    def shaft_block(self) -> Waves:
        """Waves of nodal diameter 1 with a free centre without the springs of the shaft. The last
        coordinate is the whirl of the centre along (1, i)/sqrt(2), which the others leave at rest.

        Raises:
            UserError: the sectors differ, or the bladed disk has no centre that moves.
        """
        free = self._free("veering", "can be free or clamped")
        try:
            wave = free.waves[1]
        except UserError as error:
            hint = "use bladewhirl modes for the frequencies of this stage"
            raise UserError(f"veering: {error}; {hint}") from None
        whirl = np.sqrt(0.5) * (free.centre[0] - 1j * free.centre[1])
        most = int(np.abs(whirl).argmax())
        turn = np.eye(len(whirl), dtype=np.complex128)
        turn[most] = -whirl / whirl[most]
        turn[most, most] = 1.0 / whirl[most]
        last = np.append(np.delete(np.arange(len(whirl)), most), most)
        return wave.on(turn[:, last]).on_springs(0.0)

    def _free(self, study: str, does: str) -> ModalDisk:
        """Return the bladed disk with a free centre.

        Raises:
            UserError: its centre cannot move.
        """
        if "free" not in self.disks:
            raise UserError(
                f'{study}: expected {SOURCE}.kind = "wheel" with centre_dofs: this bladed disk has'
                f" no centre that {does}"
            )
        return self.disks["free"]

    def _on_bearings(self, disk: ModalDisk) -> Mapping[int, Waves]:
        waves, difference = dict(disk.waves), self.case.shaft.anisotropy
        if 1 in waves and len(disk.centre):
            waves[1] = on_bearings(waves[1], disk.centre, difference)
        return waves
