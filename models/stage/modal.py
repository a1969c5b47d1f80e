"""Bladed disk and casing in their modes, built from a case: from beams or from a superelement."""

from typing import TYPE_CHECKING, TypeAlias

from bladewhirl.models.case.case import Case
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.modal.full_stage import ModalStage, modal_stage
from bladewhirl.models.modal.modal_model import FAMILIES, ModalModel
from bladewhirl.models.shaft_line.line import refuse_line

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
        CaseError: the modes cannot be computed with the numbers of the case.
    """
    if isinstance(given, ModalModel):
        return given
    case = given if isinstance(given, Case) else given.case
    refuse_line(case)
    if case.bladed_disk.superelement is None:
        return modal_stage(case)
    from bladewhirl.models.stage.modal_superelement import modal_superelement  # long to load

    return modal_superelement(case, families=families, count=count)


def full_models(given: Modelled, study: str, reason: str) -> ModalStage:
    """Return the finite element models of beams and casing for a study that needs them.

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
    return given if isinstance(given, ModalStage) else modal_stage(case)
