"""Preparation of a case for time integration."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np

from bladewhirl.models.elements.build import numbers_within_reach
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.inputs.timing import Timing
from bladewhirl.models.joints.contacts import with_joint_arrays, with_joints
from bladewhirl.models.modal.stage_arrays import StageArrays
from bladewhirl.models.stage.build import Buildable, build_stage, contact_problem
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.mass_scaling import screening_problem
from bladewhirl.models.stage.stage import Stage
from bladewhirl.solvers.march.checkpoint import state_arrays
from bladewhirl.solvers.march.free_motion import FreeMotion
from bladewhirl.solvers.march.march import Scheme
from bladewhirl.solvers.march.sudden_changes import make_scheme

Change = Callable[[ContactProblem, Timing], tuple[ContactProblem, Timing]]
"""Function that changes a contact problem and its timing."""

DataT = TypeVar("DataT")


@dataclass(frozen=True, kw_only=True)
class Prepared:
    """A case that is ready to march, with all checks passed."""

    stage: Stage
    problem: ContactProblem
    timing: Timing
    scheme: Scheme[Any]
    stop: FreeMotion | None = None  #: rule by which the march ends early; None: no early end

    @property
    def arrays(self) -> StageArrays:
        """Arrays of the stage in a result, with its joints."""
        return with_joint_arrays(self.stage, self.problem)


def prepare(given: Buildable, change: Change | None = None) -> Prepared:
    """Prepare the time integration of a case or its stage: check it, and factorise the matrices.

    Args:
        given: a case, or its stage.
        change: function that returns another contact problem and another timing.

    Raises:
        CaseError: all errors that prevent time integration, see `problem_of`.
        UserError: raised by `change` or `problem_of`.
    """
    stage = build_stage(given)
    case, problem, timing = stage.case, problem_of(stage), stage.case.march.timing
    if change is not None:
        problem, timing = change(problem, timing)
    with numbers_within_reach(case):
        scheme = make_scheme(problem, timing.time_step, timing.record_every)
        scheme.init()
    return Prepared(stage=stage, problem=problem, timing=timing, scheme=scheme)


def _finite(data: DataT) -> DataT:
    """Return a dataclass, all of whose arrays are finite.

    Raises:
        UserError: an array is not.
    """
    for name, value in state_arrays(data).items():
        if np.ndim(value) and np.asarray(value).dtype.kind in "fc" and not np.isfinite(value).all():
            raise UserError(f"{name} of the stage: expected finite numbers; check files and units")
    return data


def screened(problem: ContactProblem, timing: Timing) -> tuple[ContactProblem, Timing]:
    """Return contact problem and timing of a screening march, see `screening_problem`.

    Raises:
        UserError: the case cannot be screened.
    """
    try:
        return screening_problem(problem, timing)
    except ValueError as error:
        raise UserError(f"--screen: expected {error}") from None


def problem_of(stage: Stage) -> ContactProblem:
    """Return the contact problem of a stage with its joints, see `build.contact_problem`.

    Raises:
        CaseError: all errors that prevent time integration.
        UserError: a number is not finite.
    """
    _finite(stage.arrays)
    return _finite(with_joints(stage, contact_problem(stage)))
