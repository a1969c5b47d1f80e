"""Choice of the time integration scheme by its name."""

from importlib import import_module
from typing import Any

from bladewhirl.models.case.analysis import SCHEMES, SchemeName
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.solvers.march.march import Scheme
from bladewhirl.solvers.march.sudden_changes import SuddenChanges


def make_scheme(
    problem: ContactProblem,
    time_step: float,
    record_every: int,
    name: SchemeName = "central-difference",
) -> Scheme[Any]:
    """Return a time integration scheme for a contact problem.

    Args:
        problem: contact problem.
        time_step: time step [s].
        record_every: number of steps between records.
        name: name of the scheme.

    Raises:
        ValueError: the time step is too long.
    """
    if problem.loss is not None or problem.fuse is not None:
        return SuddenChanges(problem, time_step, record_every)
    module, _, scheme = SCHEMES[name].partition(":")
    made: Scheme[Any] = getattr(import_module(module), scheme)(problem, time_step, record_every)
    return made
