"""Choice of the time integration scheme: the scheme of the case, or the reference.

`BLADEWHIRL_KERNEL=reference bladewhirl run ...` uses the reference in plain NumPy, which is several
hundred times slower than the compiled code. A comparison of both shows whether an error is in the
compiled code or in the model.
"""

import os
from importlib import import_module
from typing import Any

from bladewhirl.models.case.schemes import SCHEMES, SchemeName
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.solvers.march.march import Scheme
from bladewhirl.solvers.march.reference import Reference

KERNEL = "BLADEWHIRL_KERNEL"
"""Name of the environment variable with the values ``compiled`` (default) or ``reference``."""


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
        name: name of the scheme. ``BLADEWHIRL_KERNEL=reference`` replaces "central-difference" by
            the reference.

    Raises:
        UserError: ``BLADEWHIRL_KERNEL`` has an invalid value.
        ValueError: the time step is too long.
    """
    kernel = os.environ.get(KERNEL, "compiled")
    if kernel not in ("compiled", "reference"):
        raise UserError(f"{KERNEL}: expected compiled or reference, got {kernel!r}")
    if name == "central-difference" and kernel == "reference":
        return Reference(problem, time_step, record_every)
    module, _, scheme = SCHEMES[name].partition(":")
    made: Scheme[Any] = getattr(import_module(module), scheme)(problem, time_step, record_every)
    return made
