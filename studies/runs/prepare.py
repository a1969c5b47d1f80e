"""Preparation of a case for time integration."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import case_fault
from bladewhirl.models.elements.build import numbers_within_reach
from bladewhirl.models.inputs.errors import CaseError, UserError
from bladewhirl.models.inputs.timing import Timing
from bladewhirl.models.stage.build import contact_problem
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.mass_scaling import screening_problem
from bladewhirl.models.stage.stage import Stage, build_stage
from bladewhirl.solvers.march.free_motion import FreeMotion
from bladewhirl.solvers.march.march import Scheme
from bladewhirl.solvers.march.scheme import make_scheme

Change = Callable[[ContactProblem, Timing], tuple[ContactProblem, Timing]]
"""Function that changes a contact problem and its timing."""


@dataclass(frozen=True, kw_only=True)
class Prepared:
    """A case that is ready to march, with all checks passed."""

    stage: Stage
    problem: ContactProblem
    timing: Timing
    scheme: Scheme[Any]
    stop: FreeMotion | None = None  #: rule by which the march ends early; None: no early end


def prepare(case: Case) -> Prepared:
    """Build the stage of a case and prepare its time integration.

    Raises:
        CaseError: all errors that prevent time integration.
    """
    return prepare_stage(build_stage(case))


def prepare_stage(stage: Stage, change: Change | None = None) -> Prepared:
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
