"""Arrays of the dense schemes, and the call of their compiled steps.

`kernel.h` has what each array holds, with its shape and unit; `dense.c` has the step.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.solvers.kernel.binding import Struct, dense_march, struct

EXTERNAL, NORMAL, FRICTION, DAMPING, TURNING = range(5)
"""Places of the works."""

RESIDUAL, CONTACT_STEPS, UNSOLVED, CONTACTS = range(4)
"""Places of what a march counts."""

GAP, IMPULSE, DRAG, TOUCHED = range(4)
"""Rows of the sums since the last record."""


class DenseStage(NamedTuple):
    """Constants of a march."""

    stiffness: FloatArray
    damping: FloatArray
    dampers: FloatArray
    by_velocity: FloatArray
    inverse: FloatArray
    centre: FloatArray
    circulation: float
    coupled: IntArray
    turning_cos: FloatArray
    turning_sin: FloatArray
    loads: FloatArray
    load_times: FloatArray
    tip_radial: FloatArray
    tip_tangential: FloatArray
    tip_angle: FloatArray
    tip_recess: FloatArray
    nodal: FloatArray
    clearance: FloatArray
    tip_radius: float
    element_length: float
    speed: float
    follows: float
    limit: float


class DenseLaw(NamedTuple):
    """The contact law."""

    friction: float
    restitution: float
    penalty: float
    stick_speed: float


class DenseArrays(NamedTuple):
    """State, advanced in place: the struct DenseState."""

    displacement: FloatArray
    velocity: FloatArray
    sums: FloatArray
    works: FloatArray
    counts: FloatArray


class DenseScratch(NamedTuple):
    """Working arrays."""

    load: FloatArray
    turned: FloatArray
    middle: FloatArray
    seen: FloatArray
    v_free: FloatArray
    v_after: FloatArray
    moved: FloatArray
    force: FloatArray
    row: FloatArray
    rows: FloatArray
    answers: FloatArray
    compliance: FloatArray
    active: IntArray
    free: FloatArray
    before: FloatArray
    impulse: FloatArray


def make_scratch(stage: DenseStage) -> Struct:
    """Working arrays of a march."""
    modes, tips = len(stage.stiffness), len(stage.tip_angle)
    return struct(
        DenseScratch(
            load=np.zeros(modes),
            turned=np.zeros(modes),
            middle=np.zeros(modes),
            seen=np.zeros(modes),
            v_free=np.zeros(modes),
            v_after=np.zeros(modes),
            moved=np.zeros(modes),
            force=np.zeros(modes),
            row=np.zeros(modes),
            rows=np.zeros((2 * tips, modes)),
            answers=np.zeros((2 * tips, modes)),
            compliance=np.zeros((2 * tips, 2 * tips)),
            active=np.zeros(tips, dtype=np.int64),
            free=np.zeros(2 * tips),
            before=np.zeros(tips),
            impulse=np.zeros(2 * tips),
        )
    )


def advance(
    stage: Struct,
    law: Struct,
    scratch: Struct,
    time_step: float,
    first: int,
    steps: int,
    state: DenseArrays,
) -> int:
    """Do steps in place, until displacements leave their limit; the number done."""
    return dense_march(stage, law, struct(state, "DenseState"), scratch, time_step, first, steps)
