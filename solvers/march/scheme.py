"""Choice of the time integration scheme: the one of the case, or the reference.

`BLADEWHIRL_KERNEL=reference bladewhirl run ...` marches in plain NumPy, several hundred times
slower and without anything compiled: to tell a fault of the compiled march from one of the model.
"""

from __future__ import annotations

import os
from importlib import import_module
from typing import Any

from bladewhirl.models.case.schemes import SCHEMES, SchemeName
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.solvers.march.march import Scheme
from bladewhirl.solvers.march.reference import Reference

KERNEL = "BLADEWHIRL_KERNEL"
"""Environment variable: ``compiled`` (also where it is not set) or ``reference``."""


def make_scheme(
    problem: ContactProblem,
    time_step: float,
    record_every: int,
    name: SchemeName = "central-difference",
) -> Scheme[Any]:
    """Return the scheme of that name; the environment may replace the central differences.

    Raises:
        UserError: ``BLADEWHIRL_KERNEL`` is neither of its values.
        ValueError: a time step that is too long.
    """
    kernel = os.environ.get(KERNEL, "compiled")
    if kernel not in ("compiled", "reference"):
        raise UserError(f"{KERNEL}: expected compiled or reference, got {kernel!r}")
    if name == "central-difference" and kernel == "reference":
        return Reference(problem, time_step, record_every)
    module, _, scheme = SCHEMES[name].partition(":")
    made: Scheme[Any] = getattr(import_module(module), scheme)(problem, time_step, record_every)
    return made
