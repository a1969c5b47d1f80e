"""Preparation of a case for time integration."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, cast

import numpy as np

from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import case_fault
from bladewhirl.models.case.plausibility import probable_cause
from bladewhirl.models.elements.build import numbers_within_reach
from bladewhirl.models.inputs.errors import CaseError, UserError
from bladewhirl.models.inputs.timing import Timing
from bladewhirl.models.stage.boundary_problem import BoundaryProblem
from bladewhirl.models.stage.build import contact_problem
from bladewhirl.models.stage.coating import node_coating_faults
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.mass_scaling import screening_problem
from bladewhirl.models.stage.stage import Stage, build_stage
from bladewhirl.models.stage.superelement_stage import SuperelementStage, superelement_stage
from bladewhirl.solvers.march.boundary import BoundaryMarch
from bladewhirl.solvers.march.checkpoint import state_arrays
from bladewhirl.solvers.march.free_motion import FreeMotion
from bladewhirl.solvers.march.march import Scheme
from bladewhirl.solvers.march.scheme import make_scheme

AnyProblem = ContactProblem | BoundaryProblem
"""A contact problem of beams, or of a superelement."""

Change = Callable[[Any, Timing], tuple[Any, Timing]]
"""Function that changes a contact problem and its timing."""

AnyStage = Stage | SuperelementStage
"""A stage of beams, or of a superelement."""


@dataclass(frozen=True, kw_only=True)
class Prepared:
    """A case, of beams or with a superelement, that is ready to march, with all checks passed."""

    stage: Any  #: `AnyStage`
    problem: Any  #: `AnyProblem`
    timing: Timing
    scheme: Scheme[Any]
    stop: FreeMotion | None = None  #: rule by which the march ends early; None: no early end


def any_stage(case: Case) -> AnyStage:
    """Return the stage of a case of beams, or of a case with a superelement.

    Raises:
        CaseError: the stage cannot be built.
    """
    if case.bladed_disk.superelement is not None:
        return superelement_stage(case)
    return build_stage(case)


def prepare(given: Case | AnyStage, change: Change | None = None) -> Prepared:
    """Prepare the time integration of a case or its stage: check it, and factorise the matrices.

    Args:
        given: a case, or its stage.
        change: function that returns another contact problem and another timing.

    Raises:
        CaseError: all errors that prevent time integration, see `problem_of`.
        UserError: raised by `change` or `problem_of`.
    """
    stage = any_stage(given) if isinstance(given, Case) else given
    case, problem, timing = stage.case, problem_of(stage), stage.case.march.timing
    if change is not None:
        problem, timing = change(problem, timing)
    scheme: Any
    if isinstance(problem, BoundaryProblem):
        scheme = BoundaryMarch(problem, timing.time_step, timing.record_every)
        return Prepared(stage=stage, problem=problem, timing=timing, scheme=scheme)
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


def _finite(data: Any) -> Any:
    """Return a dataclass, all of whose arrays are finite.

    Raises:
        UserError: an array is not.
    """
    for name, value in state_arrays(data).items():
        if np.ndim(value) and np.asarray(value).dtype.kind in "fc" and not np.isfinite(value).all():
            raise UserError(f"{name} of the stage: expected finite numbers; check files and units")
    return data


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


def problem_of(stage: AnyStage) -> AnyProblem:
    """Return the contact problem of a stage that can be marched.

    Raises:
        CaseError: all errors that prevent time integration; with a superelement also: a contact
            node would start beyond the wall, or the time step is too long for the modes or the
            coating.
    """
    _finite(stage.arrays)
    if isinstance(stage, Stage):
        return cast(ContactProblem, _finite(contact_problem(stage)))
    problem, timing = cast(BoundaryProblem, _finite(stage.problem)), stage.case.march.timing
    limit = problem.critical_time_step
    if not timing.time_step < limit:
        expected = (
            f"less than the critical step {limit:.6g} s (or fewer reduction.free_interface_modes,"
            f' or reduction.boundary = "massless"){probable_cause(stage.case)}'
        )
        raise CaseError([case_fault(stage.case, "march.time_step", expected)])
    faults = list(node_coating_faults(stage.case, problem.coating, stage.speed))
    if faults:
        raise CaseError(faults)
    return problem
