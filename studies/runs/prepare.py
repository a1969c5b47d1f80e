"""Preparation of a case for time integration."""

import os
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Generic, TypeAlias, TypeVar

from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import case_fault
from bladewhirl.models.elements.build import numbers_within_reach
from bladewhirl.models.inputs.errors import CaseError, UserError
from bladewhirl.models.inputs.timing import Timing
from bladewhirl.models.stage.boundary_problem import BoundaryProblem
from bladewhirl.models.stage.build import contact_problem, march_faults
from bladewhirl.models.stage.coating import node_coating_faults
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.mass_scaling import screening_problem
from bladewhirl.models.stage.stage import Stage, build_stage
from bladewhirl.models.stage.superelement_stage import SuperelementStage, superelement_stage
from bladewhirl.solvers.march.boundary import BoundaryMarch
from bladewhirl.solvers.march.free_motion import FreeMotion
from bladewhirl.solvers.march.march import Scheme
from bladewhirl.solvers.march.scheme import KERNEL, make_scheme

AnyProblem = ContactProblem | BoundaryProblem
"""A contact problem of beams, or of a superelement."""

Change = Callable[[Any, Timing], tuple[Any, Timing]]
"""Function that changes a contact problem and its timing."""

AnyStage = Stage | SuperelementStage
"""A stage of beams, or of a superelement."""

StageT = TypeVar("StageT", bound=AnyStage)
ProblemT = TypeVar("ProblemT", bound=ContactProblem | BoundaryProblem)


@dataclass(frozen=True, kw_only=True)
class Prepared(Generic[StageT, ProblemT]):
    """A case that is ready to march, with all checks passed."""

    stage: StageT
    problem: ProblemT
    timing: Timing
    scheme: Scheme[Any]
    stop: FreeMotion | None = None  #: rule by which the march ends early; None: no early end


AnyPrepared: TypeAlias = Prepared[Any, Any]
"""A case that is ready to march, of beams or with a superelement."""


def prepare(case: Case) -> AnyPrepared:
    """Build the stage of a case and prepare its time integration.

    Raises:
        CaseError: all errors that prevent time integration.
    """
    return prepare_any(any_stage(case))


def prepare_any(stage: AnyStage, change: Change | None = None) -> AnyPrepared:
    """Prepare the time integration of a stage, see `prepare_stage` and `prepare_superelement`."""
    if isinstance(stage, SuperelementStage):
        return prepare_superelement(stage, change)
    return prepare_stage(stage, change)


def any_stage(case: Case) -> AnyStage:
    """Return the stage of a case of beams, or of a case with a superelement.

    Raises:
        CaseError: the stage cannot be built.
    """
    if case.bladed_disk.superelement is not None:
        return superelement_stage(case)
    return build_stage(case)


def prepare_stage(stage: Stage, change: Change | None = None) -> Prepared[Stage, ContactProblem]:
    """Prepare the time integration of a stage: check it, and factorise the matrices.

    Args:
        stage: the stage.
        change: function that returns another contact problem and another timing.

    Raises:
        CaseError: all errors that prevent time integration.
        UserError: raised by `change`.
    """
    problem, case = contact_problem(stage), stage.case
    timing = case.march.timing
    if change is not None:
        problem, timing = change(problem, timing)
    with numbers_within_reach(case):
        try:
            scheme = make_scheme(problem, timing.time_step, timing.record_every, case.march.scheme)
        except ValueError as error:  # due to the penalty; the time step was checked before
            if case.march.scheme != "penalty":
                raise
            raise CaseError(
                [case_fault(case, "contact.penalty_stiffness", f"less ({error})")]
            ) from None
        scheme.init()
    return Prepared(stage=stage, problem=problem, timing=timing, scheme=scheme)


def screened(case: Case, problem: ContactProblem, timing: Timing) -> tuple[ContactProblem, Timing]:
    """Return contact problem and timing of a screening march, see `screening_problem`.

    Raises:
        UserError: the case cannot be screened.
    """
    try:
        if case.march.scheme != "central-difference":
            raise ValueError('march.scheme = "central-difference"')
        return screening_problem(problem, timing)
    except ValueError as error:
        raise UserError(f"--screen: expected {error}") from None


def check_march(stage: AnyStage) -> None:
    """Check that a stage can be marched.

    Raises:
        CaseError: all errors that prevent time integration.
        UserError: as for `prepare_superelement`.
    """
    if isinstance(stage, SuperelementStage):
        checked_problem(stage)
    elif faults := list(march_faults(stage)):
        raise CaseError(faults)


def problem_of(stage: AnyStage) -> AnyProblem:
    """Return the contact problem of a stage.

    Raises:
        CaseError: all errors that prevent time integration.
    """
    return stage.problem if isinstance(stage, SuperelementStage) else contact_problem(stage)


def prepare_superelement(
    stage: SuperelementStage, change: Change | None = None
) -> Prepared[SuperelementStage, BoundaryProblem]:
    """Prepare the time integration of a superelement, see `prepare_stage`.

    Raises:
        CaseError: a contact node starts inside the wall, or the time step is too long for the
            modes or the coating.
        UserError: the environment asks for the reference in NumPy.
    """
    problem, timing = checked_problem(stage), stage.case.march.timing
    if change is not None:
        problem, timing = change(problem, timing)
    scheme: Any = BoundaryMarch(problem, timing.time_step, timing.record_every)
    return Prepared(stage=stage, problem=problem, timing=timing, scheme=scheme)


def checked_problem(stage: SuperelementStage) -> BoundaryProblem:
    """Return the contact problem of a superelement, checked as for `prepare_superelement`."""
    if os.environ.get(KERNEL, "compiled") != "compiled":
        raise UserError(f'{KERNEL}: expected "compiled"; superelements have no reference in NumPy')
    problem, timing = stage.problem, stage.case.march.timing
    limit = problem.critical_time_step
    if not timing.time_step < limit:
        expected = (
            f"less than the critical step {limit:.6g} s (or fewer reduction.free_interface_modes,"
            ' or reduction.boundary = "massless")'
        )
        raise CaseError([case_fault(stage.case, "march.time_step", expected)])
    faults = list(node_coating_faults(stage.case, problem.coating, stage.speed))
    if faults:
        raise CaseError(faults)
    return problem
