"""Bladed disk and casing in their modes, built from a case: from beams or from a superelement."""

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from bladewhirl.models.case.case import Case
from bladewhirl.models.elements.build import (
    case_bladed_disk,
    case_casing,
    lowest_frequency,
    numbers_within_reach,
)
from bladewhirl.models.elements.cost import modal_cost, tell_cost
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.modal.beam_disk import BeamDisk
from bladewhirl.models.modal.frequencies import lowest_frequencies
from bladewhirl.models.modal.modal_model import FAMILIES, ModalModel
from bladewhirl.models.modal.suspension import with_sized_shaft
from bladewhirl.models.rotation.at_speed import turning_disk
from bladewhirl.models.shaft_line.line import refuse_line
from bladewhirl.models.stage.ring import stage_casing

if TYPE_CHECKING:
    from bladewhirl.models.stage.build import Buildable

Modelled: TypeAlias = "Buildable | ModalModel"  #: what `modal_model` accepts


def modal_model(
    given: Modelled, *, families: int = FAMILIES, count: int | None = None
) -> ModalModel:
    """Return bladed disk and casing of a case, or of a model, in their modes.

    Args:
        given: a case, its stage or its modes.
        families: number of modes of each nodal diameter of a superelement; all of beams.
        count: number of modes to list of a superelement, in place of `families`; all of beams.

    Raises:
        CaseError: the modes cannot be computed with the numbers of the case, the stage is too large
            for the memory, or no springs give the suspension frequency.
    """
    if isinstance(given, ModalModel):
        return given
    case = given if isinstance(given, Case) else given.case
    refuse_line(case)
    if case.bladed_disk.superelement is None:
        return _of_beams(case)
    return _of_matrices(case, families, count)


def full_models(given: Modelled, study: str, reason: str) -> ModalModel:
    """Return the model of a stage of beams for a study that needs their finite elements.

    Args:
        given: a case, its stage or its modes.
        study: name of the study.
        reason: reason why the study has no result for a superelement.

    Raises:
        UserError: the bladed disk is a superelement.
    """
    case = given if isinstance(given, Case) else given.case
    if case.bladed_disk.superelement is not None:
        raise UserError(f"{study}: not for a superelement: {reason}")
    return modal_model(given)


def _of_beams(case: Case) -> ModalModel:
    """Return the model of a case with beams, with all modes without Coriolis forces."""
    case, effects = with_sized_shaft(case), case.rotation.effects
    with numbers_within_reach(case):
        disks = {
            name: BeamDisk(case=case, effects=effects, at_rest=disk, turning=disk)
            for name, clamped in (("free", False), ("clamped", True))
            for disk in (case_bladed_disk(case, clamped=clamped),)
        }
        free = disks["free"]
        tell_cost(modal_cost(free.at_rest.structure))
        tell_cost(modal_cost(case_casing(case).structure))
        ring = stage_casing(case)
        if effects == "none":
            reference = lowest_frequency(free.at_rest, free.labelled.frequency)
        else:
            lowest = lowest_frequencies(free.at_rest.structure, 1)
            reference = lowest_frequency(free.at_rest, (each[0] for each in lowest.values()))
            disks = {
                name: replace(disk, turning=turning_disk(case, disk.at_rest, reference))
                for name, disk in disks.items()
            }
    return ModalModel(
        case=case,
        reference_frequency=reference,
        casing=ring.casing,
        casing_modes=ring.casing_modes,
        wall_arrays=ring.wall_arrays,
        disks_up_to=lambda _: disks,
        highest=np.inf,
    )


def _of_matrices(case: Case, families: int, count: int | None) -> ModalModel:
    """Return the model of a case with a superelement, of which the bladed disk is computed at first
    use; see `modal_model`."""
    from bladewhirl.models.stage.matrix_disk import matrix_disks, still_stage  # long to load

    stage, highest = still_stage(case, count), 0.0
    if case.rotation.effects != "none":
        highest = abs(case.march.speed.rad_per_s(stage.reference_frequency))
    return ModalModel(
        case=case,
        reference_frequency=stage.reference_frequency,
        casing=stage.casing,
        casing_modes=stage.casing_modes,
        wall_arrays=stage.wall_arrays,
        disks_up_to=partial(matrix_disks, case, stage, families, count),
        highest=highest,
    )
