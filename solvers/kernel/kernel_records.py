"""Compiled records: what a march writes down at record steps."""

from __future__ import annotations

import numpy as np
from numba import njit

from bladewhirl.solvers.kernel.arrays import Records, State
from bladewhirl.solvers.kernel.compilation import COMPILE, Array
from bladewhirl.solvers.kernel.kernel_motion import half_step_energy
from bladewhirl.solvers.kernel.vectors import bare


@njit(**COMPILE)
def _record_motion(
    slots: Array, old: int, now: int, later: int, interval: float, target: Array, row: int
) -> None:
    """Displacement and velocity of one body."""
    for i in range(slots.shape[1]):
        target[row, 0, i] = slots[now, i]
        target[row, 1, i] = (slots[later, i] - slots[old, i]) / interval


@njit(**COMPILE)
def write_record(
    records: Records,
    row: int,
    state: State,
    rotor_stiffness: Array,
    casing_stiffness: Array,
    time_step: float,
    step: int,
    contacts: float,
    spring_energy: float,
    old: int,
    now: int,
    later: int,
    interval: float,
) -> None:
    """What is known at step n, before x_{n+1}; what counts between records starts anew.

    Velocities are differences of slots ``later`` and ``old`` over an interval.
    """
    xs, ys = bare(state.rotor), bare(state.casing)
    records.step[row], records.contacts[row] = step, contacts
    records.energy[row] = (
        half_step_energy(bare(rotor_stiffness), xs, old, now, time_step)
        + half_step_energy(bare(casing_stiffness), ys, old, now, time_step)
        + spring_energy
    )
    _record_motion(xs, old, now, later, interval, records.rotor, row)
    _record_motion(ys, old, now, later, interval, records.casing, row)
    for i in range(len(state.work)):
        records.work[row, i] = state.work[i]
    for j in range(len(state.gap)):
        records.gap[row, j], state.gap[j] = state.gap[j], np.inf
        records.impulse[row, j], state.impulse[j] = state.impulse[j], 0.0
        records.drag[row, j], state.drag[j] = state.drag[j], 0.0
        records.touched[row, j], state.touched[j] = state.touched[j], 0.0
