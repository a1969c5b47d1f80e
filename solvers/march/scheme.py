"""Choice of the time integration scheme for a contact problem."""

from typing import Any

from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.solvers.march.central_difference import CentralDifference
from bladewhirl.solvers.march.march import Scheme
from bladewhirl.solvers.march.sudden_changes import SuddenChanges


def make_scheme(problem: ContactProblem, time_step: float, record_every: int) -> Scheme[Any]:
    """Return the time integration scheme for a contact problem.

    Args:
        problem: contact problem.
        time_step: time step [s].
        record_every: number of steps between records.

    Raises:
        ValueError: the time step is too long.
    """
    changes = problem.loss is not None or problem.fuse is not None
    return (SuddenChanges if changes else CentralDifference)(problem, time_step, record_every)
