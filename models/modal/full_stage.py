"""The full finite element models of a case and their modes: what modal analysis looks at."""

from __future__ import annotations

from dataclasses import dataclass

from bladewhirl.meshes.line_mesh import IntArray
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
from bladewhirl.models.modal.describe import stage_arrays
from bladewhirl.models.modal.frequencies import lowest_frequencies
from bladewhirl.models.modal.labels import LabelledModes, labelled_modes
from bladewhirl.models.modal.stage_arrays import StageArrays
from bladewhirl.models.rotation.at_speed import turning_disk


@dataclass(frozen=True, kw_only=True)
class ModalStage:
    """Bladed disk, with a free and with a clamped centre, and casing; nothing is reduced."""

    case: Case
    free_disk: BladedDiskModel
    clamped_disk: BladedDiskModel
    casing: CasingModel
    reference_frequency: float  #: lowest of the bladed disk with a free centre, at rest [rad/s]
    free_modes: LabelledModes
    clamped_modes: LabelledModes
    casing_modes: LabelledModes

    @property
    def disk(self) -> BladedDiskModel:
        """The bladed disk as the case has it."""
        return self.clamped_disk if self.case.shaft.clamped else self.free_disk

    @property
    def disk_modes(self) -> LabelledModes:
        """Modes of the bladed disk as the case has it."""
        return self.clamped_modes if self.case.shaft.clamped else self.free_modes

    def arrays(self, disk_modes: IntArray, casing_modes: IntArray) -> StageArrays:
        """Describe the stage by some of its modes.

        Args:
            disk_modes: numbers among `disk_modes`.
            casing_modes: numbers among `casing_modes`.
        """
        return stage_arrays(
            self.disk,
            self.disk_modes.expand(disk_modes),
            tuple(self.disk_modes.family[i] for i in disk_modes),
            self.casing,
            self.casing_modes.expand(casing_modes),
            tuple(self.casing_modes.family[i] for i in casing_modes),
            shaft=self.case.shaft,
            clearance=case_clearance(self.case)[:, 0],
        )


def modal_stage(case: Case, count: int | None = None) -> ModalStage:
    """Find the modes of a case's full bladed disk and casing.

    Args:
        case: the case.
        count: how many of the lowest of each; all when None.

    Raises:
        CaseError: numbers that finite elements can't be made of.
    """
    with numbers_within_reach(case):
        free, clamped = case_bladed_disk(case, clamped=False), case_bladed_disk(case, clamped=True)
        casing = case_casing(case)
        tip = tip_in_sector(free)
        reference = None
        if case.rotation.effects != "none":
            lowest = lowest_frequencies(free.structure, 1)
            reference = lowest_frequency(free, (found[0] for found in lowest.values()))
            free, clamped = _at_speed(case, free, reference), _at_speed(case, clamped, reference)
        free_modes = labelled_modes(free.structure, tip, "bladed-disk", count)
        return ModalStage(
            case=case,
            free_disk=free,
            clamped_disk=clamped,
            casing=casing,
            reference_frequency=reference or lowest_frequency(free, free_modes.frequency),
            free_modes=free_modes,
            clamped_modes=labelled_modes(clamped.structure, tip, "bladed-disk", count),
            casing_modes=labelled_modes(casing.structure, (RADIAL, TANGENTIAL), "casing", count),
        )


def _at_speed(case: Case, at_rest: BladedDiskModel, reference: float) -> BladedDiskModel:
    """A bladed disk with its rotation effects."""
    turning = turning_disk(case, at_rest, reference, stiff=True)
    assert turning is not None  # the case has effects
    return turning.disk
