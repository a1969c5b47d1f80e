"""Compiled motion of a body between contacts: recurrence, loads, coupling springs, energy ledger.

See `kernel` for the scheme.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from bladewhirl.solvers.kernel.arrays import LOAD_END, LOAD_FREQUENCY, LOAD_PHASE, LOAD_RAMP
from bladewhirl.solvers.kernel.compilation import COMPILE, Array
from bladewhirl.solvers.kernel.vectors import (
    LANES,
    fma,
    load,
    load_row,
    mul,
    splat,
    store_row,
    sub,
    total,
)


@njit(**COMPILE)
def predict(a: Array, b: Array, slots: Array, old: int, now: int, new: int) -> None:
    """x_{n+1} of the free motion from x_n and x_{n-1}, by the recurrence's a and b."""
    for i in range(0, len(a), LANES):
        x = fma(load(a, i), load_row(slots, now, i), mul(load(b, i), load_row(slots, old, i)))
        store_row(slots, new, i, x)


@njit(**COMPILE)
def load_factors(loads: Array, time: float, out: Array) -> bool:
    """Amplitude of each load pattern; whether any is nonzero."""
    loaded = False
    for p in range(len(loads)):
        factor = 0.0
        if time < loads[p, LOAD_END]:
            factor = np.cos(loads[p, LOAD_FREQUENCY] * time + loads[p, LOAD_PHASE])
            if time < loads[p, LOAD_RAMP]:
                factor *= 0.5 - 0.5 * np.cos(np.pi * time / loads[p, LOAD_RAMP])
        out[p] = factor
        loaded = loaded or factor != 0.0
    return loaded


@njit(**COMPILE)
def add_load(
    pattern: Array, loaded: Array, factors: Array, c: Array, slots: Array, new: int
) -> None:
    """Add what the load patterns move, in the registers that they load."""
    for p in range(len(factors)):
        factor = splat(factors[p])
        for k in range(loaded.shape[1]):
            i = loaded[p, k]
            if i < 0:
                break
            force = mul(factor, load_row(pattern, p, i))
            store_row(slots, new, i, fma(force, load(c, i), load_row(slots, new, i)))


@njit(**COMPILE)
def spring_waves(
    place: Array, wave: Array, amplitude: Array, slots: Array, slot: int, out: Array, row: int
) -> None:
    """Waves of one body's radial displacement at the springs."""
    for i in range(out.shape[1]):
        out[row, i] = 0.0
    for i in range(len(place)):
        out[row, wave[i]] += amplitude[i] * slots[slot, place[i]]


@njit(**COMPILE)
def spring_stretches(
    nodal_diameter: Array, angle: float, last_angle: float, rotor: Array, casing: Array,
    earlier: int, later: int, out: Array,
) -> None:  # fmt: skip
    """Stretch of the springs, casing less rotor: rows 0 and 1 at the last angle for the last
    displacement and this one, rows 2 and 3 the same at this angle.
    """
    for turned in range(2):
        for h in range(len(nodal_diameter)):
            phase = nodal_diameter[h] * (angle if turned == 1 else last_angle)
            cos, sin = np.cos(phase), np.sin(phase)
            for moved in range(2):
                row = later if moved == 1 else earlier
                u_c, u_s = rotor[row, 2 * h], rotor[row, 2 * h + 1]
                at = 2 * turned + moved
                out[at, 2 * h] = casing[row, 2 * h] - (u_c * cos - u_s * sin)
                out[at, 2 * h + 1] = casing[row, 2 * h + 1] - (u_c * sin + u_s * cos)


@njit(**COMPILE)
def energy_of_springs(factor: Array, stretch: Array, first: int) -> float:
    """x_{n-1}^T K* x_n / 2 from the stretches of both displacements at one angle."""
    energy = 0.0
    for i in range(len(factor)):
        energy += factor[i] * stretch[first, i] * stretch[first + 1, i]
    return 0.5 * energy


@njit(**COMPILE)
def spring_forces(
    nodal_diameter: Array, factor: Array, angle: float, stretch: Array, force: Array
) -> None:
    """Forces -C^T f kappa C x_n of the springs, on the waves of rotor (row 0) and casing (1)."""
    for h in range(len(nodal_diameter)):
        cos, sin = np.cos(nodal_diameter[h] * angle), np.sin(nodal_diameter[h] * angle)
        i = 2 * h
        pull_c, pull_s = factor[i] * stretch[3, i], factor[i + 1] * stretch[3, i + 1]
        force[0, 2 * h] = cos * pull_c + sin * pull_s
        force[0, 2 * h + 1] = cos * pull_s - sin * pull_c
        force[1, 2 * h], force[1, 2 * h + 1] = -pull_c, -pull_s


@njit(**COMPILE)
def add_springs(
    place: Array, wave: Array, amplitude: Array, force: Array, row: int, c: Array, slots: Array,
    new: int,
) -> None:  # fmt: skip
    """Add what the coupling springs move, by the amplitude of each mode in its wave."""
    for i in range(len(place)):
        at = place[i]
        slots[new, at] += c[at] * amplitude[i] * force[row, wave[i]]


@njit(**COMPILE)
def external_work(
    pattern: Array, loaded: Array, factors: Array, slots: Array, old: int, new: int
) -> float:
    """d^T f with d = (x_{n+1} - x_{n-1}) / 2."""
    done = 0.0
    for p in range(len(factors)):
        part = splat(0.0)
        for k in range(loaded.shape[1]):
            i = loaded[p, k]
            if i < 0:
                break
            moved = sub(load_row(slots, new, i), load_row(slots, old, i))
            part = fma(moved, load_row(pattern, p, i), part)
        done += 0.5 * factors[p] * total(part)
    return done


@njit(**COMPILE)
def damping_loss(damping: Array, slots: Array, old: int, new: int) -> float:
    """d^T D d with d = (x_{n+1} - x_{n-1}) / 2."""
    loss = splat(0.0)
    for i in range(0, len(damping), LANES):
        moved = sub(load_row(slots, new, i), load_row(slots, old, i))
        loss = fma(mul(load(damping, i), moved), moved, loss)
    return 0.25 * float(total(loss))


@njit(**COMPILE)
def damp(
    damper: Array, solve: Array, c: Array, slots: Array, old: int, new: int, stroke: Array,
    force: Array, row: int,
) -> None:  # fmt: skip
    """Add the dampers' forces to the predicted x_{n+1}."""
    _strokes(damper, slots, old, new, stroke)
    count, width = damper.shape
    for m in range(count):
        phi = 0.0
        for k in range(count):
            phi -= solve[m, k] * stroke[k]
        force[row, m] = phi
    for i in range(0, width, LANES):
        pull = splat(0.0)
        for m in range(count):
            pull = fma(load_row(damper, m, i), splat(force[row, m]), pull)
        store_row(slots, new, i, fma(load(c, i), pull, load_row(slots, new, i)))


@njit(**COMPILE)
def _strokes(damper: Array, slots: Array, old: int, new: int, out: Array) -> None:
    """G (x_{n+1} - x_{n-1})."""
    for m in range(len(damper)):
        part = splat(0.0)
        for i in range(0, damper.shape[1], LANES):
            moved = sub(load_row(slots, new, i), load_row(slots, old, i))
            part = fma(load_row(damper, m, i), moved, part)
        out[m] = total(part)


@njit(**COMPILE)
def damper_loss(
    damper: Array, slots: Array, old: int, new: int, stroke: Array, force: Array, row: int
) -> float:
    """-d^T G^T phi with d = (x_{n+1} - x_{n-1}) / 2."""
    _strokes(damper, slots, old, new, stroke)
    loss = 0.0
    for m in range(len(damper)):
        loss -= 0.5 * force[row, m] * stroke[m]
    return loss


@njit(**COMPILE)
def half_step_energy(stiffness: Array, slots: Array, old: int, now: int, time_step: float) -> float:
    """E_{n-1/2} = v^T v / 2 + x_{n-1}^T K x_n / 2 with v = (x_n - x_{n-1}) / dt."""
    energy = 0.0
    for i in range(len(stiffness)):
        v = (slots[now, i] - slots[old, i]) / time_step
        energy += v * v + stiffness[i] * slots[now, i] * slots[old, i]
    return 0.5 * energy


@njit(**COMPILE)
def settle(slots: Array, old: int, now: int, new: int) -> None:
    """Put x_{n-1} and x_n back into slots 0 and 1."""
    for i in range(slots.shape[1]):
        before, current, scratch = slots[old, i], slots[now, i], slots[new, i]
        slots[0, i], slots[1, i], slots[2, i] = before, current, scratch
