"""The scheme that a march is made with: the compiled one, or the reference if the environment asks.

`BLADEWHIRL_KERNEL=reference bladewhirl run ...` marches in plain NumPy, several hundred times
slower and without anything compiled: to tell a fault of the compiled march from one of the model.
"""

from __future__ import annotations

import os
from typing import Any

from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.solvers.march.march import Scheme
from bladewhirl.solvers.march.reference import Reference

KERNEL = "BLADEWHIRL_KERNEL"
"""Environment variable: ``compiled`` (also where it is not set) or ``reference``."""


def make_scheme(problem: ContactProblem, time_step: float, record_every: int) -> Scheme[Any]:
    """Scheme of the kernel that the environment names.

    Raises:
        UserError: it names another.
        ValueError: a time step at or above the critical one.
    """
    match os.environ.get(KERNEL, "compiled"):
        case "compiled":
            # What the reference does without: numba takes its time to be loaded.
            from bladewhirl.solvers.march.central_difference import CentralDifference

            return CentralDifference(problem, time_step, record_every)
        case "reference":
            return Reference(problem, time_step, record_every)
        case other:
            raise UserError(f"{KERNEL}: expected compiled or reference, got {other!r}")
