"""Choice of the time integration scheme: the one of the case, or the reference.

`BLADEWHIRL_KERNEL=reference bladewhirl run ...` marches in plain NumPy, several hundred times
slower and without anything compiled: to tell a fault of the compiled march from one of the model.
"""

from __future__ import annotations

import os
from typing import Any, Literal

from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.solvers.march.march import Scheme
from bladewhirl.solvers.march.reference import Reference

KERNEL = "BLADEWHIRL_KERNEL"
"""Environment variable: ``compiled`` (also where it is not set) or ``reference``."""


SchemeName = Literal["central-difference", "moreau-jean", "penalty"]
"""Names as in cases."""


def make_scheme(
    problem: ContactProblem,
    time_step: float,
    record_every: int,
    name: SchemeName = "central-difference",
) -> Scheme[Any]:
    """Scheme of that name; of the central differences the kernel that the environment names.

    Raises:
        UserError: it names another.
        ValueError: a time step that is too long.
    """
    kernel = os.environ.get(KERNEL, "compiled")
    if kernel not in ("compiled", "reference"):
        raise UserError(f"{KERNEL}: expected compiled or reference, got {kernel!r}")
    # The reference needs nothing compiled.
    if name != "central-difference":
        from bladewhirl.solvers.march.dense import Dense

        return Dense(problem, time_step, record_every, name)
    if kernel == "reference":
        return Reference(problem, time_step, record_every)
    from bladewhirl.solvers.march.central_difference import CentralDifference

    return CentralDifference(problem, time_step, record_every)
