"""Bladed disks of beams for modal analysis: full finite element models."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray, IntArray
from bladewhirl.models.elements.bladed_disk import BladedDiskModel
from bladewhirl.models.elements.build import numbers_within_reach, tip_in_sector
from bladewhirl.models.elements.cyclic import nodal_diameters
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.modal.describe import stage_arrays
from bladewhirl.models.modal.labels import LabelledModes, labelled_modes, with_families
from bladewhirl.models.modal.modal_disk import UNEQUAL_SECTORS, ModalDisk
from bladewhirl.models.modal.modes import ListedModes
from bladewhirl.models.modal.stage_arrays import StageArrays
from bladewhirl.models.modal.touching import Tips
from bladewhirl.models.modal.whirl_modes import DENSE_SIZE, whirl_modes
from bladewhirl.models.rotation.at_speed import speed_of_growth
from bladewhirl.models.rotation.critical_speeds import centre_in_waves
from bladewhirl.models.structure.waves import Waves

WHIRL_FAMILIES = 6
"""Number of families of whirling modes computed for a large bladed disk without symmetry."""


@dataclass(frozen=True, kw_only=True)
class BeamDisk(ModalDisk):
    """Finite elements of a bladed disk of beams."""

    of_lines: ClassVar[bool] = True

    at_rest: BladedDiskModel
    turning: BladedDiskModel
    """The bladed disk at the speed of the case; at rest without rotation effects."""

    @property
    def beams(self) -> BladedDiskModel:
        return self.turning if self.effects == "centrifugal" else self.at_rest

    @cached_property
    def labelled(self) -> LabelledModes:
        disk = self.beams
        with numbers_within_reach(self.case):
            return labelled_modes(disk.structure, tip_in_sector(disk), "bladed-disk")

    @cached_property
    def listed(self) -> ListedModes:
        """All modes; for a large bladed disk with unequal sectors and Coriolis forces only those of
        the lowest families."""
        if self.effects != "full":
            return self.labelled
        structure = self.turning.structure
        layout, count = structure.layout, None
        if layout is not None and not structure.is_cyclic and structure.size > DENSE_SIZE:
            count = WHIRL_FAMILIES * layout.sectors
        return with_families(whirl_modes(structure, count), self.labelled, structure.mass)

    @cached_property
    def waves(self) -> Mapping[int, Waves]:
        structure = self.turning.structure
        return {k: structure.wave(k).under(self.effects) for k in self._nodal_diameters()}

    @property
    def centre(self) -> ComplexArray:
        return centre_in_waves(self.turning)

    @property
    def tips(self) -> Mapping[int, Tips]:
        disk = self.beams
        tip = np.array([disk.tip_radial[0], disk.tip_tangential[0]])
        radius, found = disk.model.tip_radius - disk.model.tip_recess[:1], {}
        for k in self._nodal_diameters():
            assert disk.structure.layout is not None  # it has nodal diameters
            in_plane = np.asarray(disk.structure.layout.basis(k)[tip].toarray())
            contact = np.vstack([in_plane, np.zeros_like(in_plane[:1])])
            found[k] = Tips(contact=contact, radius=radius, flexibility=None)
        return found

    def _nodal_diameters(self) -> range:
        """Return the nodal diameters of the waves.

        Raises:
            UserError: the sectors of the bladed disk differ.
        """
        structure = self.turning.structure
        if not structure.still.is_cyclic or structure.layout is None:
            raise UserError(UNEQUAL_SECTORS)
        return nodal_diameters(structure.layout.sectors)

    def arrays(self, modes: ListedModes, numbers: IntArray, wall: Mapping[str, Any]) -> StageArrays:
        family = tuple(modes.family[i] for i in np.repeat(numbers, modes.REAL_FIELDS))
        return stage_arrays(self.case, self.turning, modes.expand(numbers), family, **wall)

    def growth(self, omegas: FloatArray) -> FloatArray | None:
        if not self.turning.rotates:
            return None
        return np.array([self.turning.growth(omega).max() if omega else 0.0 for omega in omegas])

    @property
    def clearance_gone(self) -> float:
        smallest = self.case.casing.clearance_profile.smallest
        return speed_of_growth(self.turning, smallest + self.turning.model.tip_recess)
