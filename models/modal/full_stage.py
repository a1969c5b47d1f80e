"""Full finite element models of a case with their modes, for modal analysis."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar

import numpy as np
import scipy.sparse.linalg as spla

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.elements.bladed_disk import BladedDiskModel
from bladewhirl.models.elements.build import (
    case_bladed_disk,
    case_casing,
    case_clearance,
    lowest_frequency,
    numbers_within_reach,
    tip_in_sector,
)
from bladewhirl.models.elements.casing import RADIAL, TANGENTIAL, CasingModel
from bladewhirl.models.elements.cost import modal_cost, tell_cost
from bladewhirl.models.elements.cyclic import NO_COLUMN, nodal_diameters
from bladewhirl.models.elements.structure import Structure
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.modal.describe import casing_arrays, stage_arrays
from bladewhirl.models.modal.labels import LabelledModes, labelled_modes, no_modes, whirl_families
from bladewhirl.models.modal.modal_model import (
    UNEQUAL_SECTORS,
    ModalModel,
)
from bladewhirl.models.modal.modes import (
    DENSE_LIMIT,
    ListedModes,
    Modes,
    lowest_pairs,
    natural_frequencies,
)
from bladewhirl.models.modal.stage_arrays import StageArrays
from bladewhirl.models.modal.suspension import with_sized_shaft
from bladewhirl.models.modal.touching import Tips
from bladewhirl.models.modal.whirl_modes import DENSE_SIZE, WhirlModes, whirl_modes
from bladewhirl.models.rotation.at_speed import speed_of_growth, turning_disk
from bladewhirl.models.rotation.critical_speeds import shaft_waves
from bladewhirl.models.structure.dft import nodal_diameter_of
from bladewhirl.models.structure.rotating import Effects
from bladewhirl.models.structure.waves import Waves

Frequencies = Mapping[int, FloatArray]
"""Frequencies by nodal diameter in ascending order [rad/s]; a pair has one entry. The key -1 has
all frequencies of a structure without symmetry."""


def lowest_frequencies(structure: Structure, count: int) -> Frequencies:
    """Return the lowest frequencies of a supported structure.

    Args:
        structure: full structure without constraints.
        count: number of frequencies of each nodal diameter. Without symmetry, the number of
            frequencies is `count` times the number of sectors.
    """
    layout = structure.layout
    if layout is not None and structure.is_cyclic:
        return {
            k: natural_frequencies(structure, lowest_pairs(stiffness, mass, count)[0])
            for k, (mass, stiffness) in layout.blocks(structure.mass, structure.stiffness)
        }
    total = count * (layout.sectors if layout else 1)
    if structure.size > DENSE_LIMIT:
        squares = spla.eigsh(
            structure.stiffness.tocsc(),
            k=min(total, structure.size - 1),
            M=structure.mass.tocsc(),
            sigma=0.0,
            return_eigenvectors=False,
        )
    else:
        squares = lowest_pairs(structure.stiffness.toarray(), structure.mass.toarray(), total)[0]
    return {NO_COLUMN: natural_frequencies(structure, np.sort(squares))}


def family_errors(modes: Modes, family: list[str], full: Frequencies) -> dict[str, float]:
    """Return for each family the largest relative error of its frequencies; frequencies that
    ``full`` lacks are left out.

    Args:
        modes: modes of a reduced model.
        family: family of each mode, (modes,).
        full: frequencies of the full model.
    """
    errors: dict[str, float] = {}
    rank: dict[int, int] = {}
    for mode in range(modes.count):
        column = int(modes.column[mode])
        position = rank.get(column, 0)
        rank[column] = position + 1
        exact = full[NO_COLUMN if column == NO_COLUMN else nodal_diameter_of(column)]
        if position < len(exact) and exact[position] != 0.0:
            error = abs(modes.frequency[mode] / exact[position] - 1.0)
            errors[family[mode]] = max(errors.get(family[mode], 0.0), float(error))
    return errors


WHIRL_FAMILIES = 6
"""Number of families of whirling modes computed for a large bladed disk without symmetry."""


@dataclass(frozen=True, kw_only=True)
class ModalStage(ModalModel):
    """Full models of the casing and of the bladed disk, with a free and with a clamped centre.

    With rotation.effects = "centrifugal", the modes are computed at the speed of the case. With
    "full", the modes are computed at rest, and the whirling modes at the speed of the case.
    """

    of_lines: ClassVar[bool] = True

    free_disk: BladedDiskModel
    clamped_disk: BladedDiskModel
    casing: CasingModel
    free_modes: LabelledModes
    clamped_modes: LabelledModes
    at_speed: tuple[BladedDiskModel, BladedDiskModel]
    """Bladed disk at the speed of the case with a free and with a clamped centre; at rest without
    rotation effects."""

    @property
    def turning(self) -> BladedDiskModel:
        """Bladed disk at the speed of the case, with a free or clamped centre as it requires."""
        return self.at_speed[int(self.case.shaft.clamped)]

    @cached_property
    def free_whirl(self) -> WhirlModes | None:
        """Whirling modes of the bladed disk with a free centre; None without Coriolis forces."""
        return self._whirl(0)

    @cached_property
    def clamped_whirl(self) -> WhirlModes | None:
        """Whirling modes of the bladed disk with a clamped centre; None without Coriolis forces."""
        return self._whirl(1)

    @property
    def disk_whirl(self) -> WhirlModes | None:
        """Whirling modes of the bladed disk with a free or clamped centre, as the case requires;
        None without Coriolis forces."""
        return self.clamped_whirl if self.case.shaft.clamped else self.free_whirl

    def _whirl(self, centre: int) -> WhirlModes | None:
        """Compute all whirling modes; for a large bladed disk with unequal sectors only the modes
        of the lowest families."""
        if self.case.rotation.effects != "full":
            return None
        structure = self.at_speed[centre].structure
        layout, count = structure.layout, None
        if layout is not None and not structure.is_cyclic and structure.size > DENSE_SIZE:
            count = WHIRL_FAMILIES * layout.sectors
        modes = whirl_modes(structure, count)
        family, at_rest = whirl_families(structure, modes, tip_in_sector(self.free_disk))
        return replace(modes, family=family, at_rest=at_rest)

    @property
    def effects(self) -> Effects:
        return self.case.rotation.effects

    @property
    def centre(self) -> str:
        return "clamped" if self.case.shaft.clamped else "free"

    @property
    def by_centre(self) -> dict[str, ListedModes]:
        return {
            "free": self.free_whirl or self.free_modes,
            "clamped": self.clamped_whirl or self.clamped_modes,
        }

    @property
    def listed_modes(self) -> ListedModes:
        return self.disk_whirl or self.disk_modes

    @property
    def waves(self) -> dict[int, Waves]:
        return _disk_waves(self.case, self.turning)

    @property
    def tips(self) -> dict[int, Tips]:
        disk, layout = self.disk, self.disk.structure.layout
        if layout is None or not disk.structure.is_cyclic:
            raise UserError(UNEQUAL_SECTORS)
        tip = np.array([disk.tip_radial[0], disk.tip_tangential[0]])
        radius, found = disk.model.tip_radius - disk.model.tip_recess[:1], {}
        for k in nodal_diameters(layout.sectors):
            in_plane = np.asarray(layout.basis(k)[tip].toarray())
            contact = np.vstack([in_plane, np.zeros_like(in_plane[:1])])
            found[k] = Tips(contact=contact, radius=radius, flexibility=None)
        return found

    @property
    def shaft_waves(self) -> Waves:
        if self.case.rotation.effects != "full":
            raise UserError(
                'critical speeds: expected rotation.effects = "full" (--set rotation.effects=full),'
                f" got {self.case.rotation.effects}"
            )
        return _disk_waves(self.case, self.at_speed[0])[1]

    @property
    def shaft_block(self) -> Waves:
        structure = self.at_speed[0].structure
        if not structure.is_cyclic:
            symmetry = structure.symmetry.partition(":")[0]
            raise UserError(
                f"veering: expected equal sectors on equal shaft springs, not {symmetry}: only then"
                " has each mode a single nodal diameter. Use bladewhirl modes for the frequencies"
                " of this stage"
            )
        return structure.wave(1).under(self.effects).on_springs(0.0)

    def growth(self, omegas: FloatArray) -> FloatArray | None:
        turning = self.turning
        if not turning.rotates:
            return None
        return np.array([turning.growth(omega).max() if omega else 0.0 for omega in omegas])

    @property
    def clearance_gone(self) -> float:
        disk = self.turning
        smallest_gap = self.case.casing.clearance_profile.smallest + disk.model.tip_recess
        return speed_of_growth(disk, smallest_gap)

    @property
    def disk(self) -> BladedDiskModel:
        """Bladed disk with a free or a clamped centre, as the case requires."""
        return self.clamped_disk if self.case.shaft.clamped else self.free_disk

    @property
    def disk_modes(self) -> LabelledModes:
        """Modes of the bladed disk with a free or a clamped centre, as the case requires."""
        return self.clamped_modes if self.case.shaft.clamped else self.free_modes

    def arrays(self, disk_modes: IntArray, casing_modes: IntArray) -> StageArrays:
        """Return the arrays of the stage with the chosen modes.

        Args:
            disk_modes: numbers of modes in the attribute `disk_modes`.
            casing_modes: numbers of modes in the attribute `casing_modes`.
        """
        modes = self.disk_modes
        return self._arrays(modes.expand(disk_modes), modes.family, disk_modes, casing_modes)

    def shown_arrays(self, disk_modes: IntArray, casing_modes: IntArray) -> StageArrays:
        whirl = self.disk_whirl
        if whirl is None:
            return self.arrays(disk_modes, casing_modes)
        twice = np.repeat(disk_modes, 2)
        return self._arrays(whirl.real_parts(disk_modes), whirl.family, twice, casing_modes)

    def _arrays(
        self, modes: Modes, family: tuple[str, ...], disk_modes: IntArray, casing_modes: IntArray
    ) -> StageArrays:
        return stage_arrays(
            self.case,
            self.turning,
            modes,
            tuple(family[i] for i in disk_modes),
            **casing_arrays(self.casing, self.casing_modes.take(casing_modes)),
            wall_angle=self.casing.mesh.angles,
            clearance=case_clearance(self.case)[:, 0],
        )


def _disk_waves(case: Case, disk: BladedDiskModel) -> dict[int, Waves]:
    """Return the waves of each nodal diameter of the bladed disk of a case.

    Raises:
        UserError: the sectors of the bladed disk differ.
    """
    structure, effects = disk.structure, case.rotation.effects
    if not structure.still.is_cyclic or structure.layout is None:
        raise UserError(UNEQUAL_SECTORS)
    return {
        k: shaft_waves(case, disk) if k == 1 else structure.wave(k).under(effects)
        for k in nodal_diameters(structure.layout.sectors)
    }


def modal_stage(case: Case, count: int | None = None) -> ModalStage:
    """Compute the modes of the full bladed disk and casing of a case.

    Args:
        case: the case.
        count: number of the lowest modes of bladed disk and of casing; all if None.

    Raises:
        CaseError: the stage is too large for the memory, no springs give the suspension frequency,
            or values are too extreme for finite elements in double precision.
    """
    case = with_sized_shaft(case)
    with numbers_within_reach(case):
        free, clamped = case_bladed_disk(case, clamped=False), case_bladed_disk(case, clamped=True)
        tell_cost(modal_cost(free.structure))
        casing = case_casing(case)
        tell_cost(modal_cost(casing.structure))
        tip = tip_in_sector(free)
        reference, at_speed = None, (free, clamped)
        if case.rotation.effects != "none":
            lowest = lowest_frequencies(free.structure, 1)
            reference = lowest_frequency(free, (frequencies[0] for frequencies in lowest.values()))
            at_speed = turning_disk(case, free, reference), turning_disk(case, clamped, reference)
            if case.rotation.effects == "centrifugal":
                free, clamped = at_speed
        free_modes = labelled_modes(free.structure, tip, "bladed-disk", count)
        return ModalStage(
            case=case,
            free_disk=free,
            clamped_disk=clamped,
            casing=casing,
            reference_frequency=reference or lowest_frequency(free, free_modes.frequency),
            free_modes=free_modes,
            clamped_modes=labelled_modes(clamped.structure, tip, "bladed-disk", count),
            casing_modes=(
                labelled_modes(casing.structure, (RADIAL, TANGENTIAL), "casing", count)
                if case.casing.type == "ring"
                else no_modes()
            ),
            at_speed=at_speed,
        )
