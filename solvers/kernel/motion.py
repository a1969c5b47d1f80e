"""Compiled motion of a body between contacts: recurrence, loads, springs, dampers, energy, records.

See `step` for the scheme.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from bladewhirl.solvers.kernel.arrays import (
    LOAD_END,
    LOAD_FREQUENCY,
    LOAD_PHASE,
    LOAD_RAMP,
    STEP_CONTACTS,
    BodyArrays,
    DamperEnds,
    Records,
    Slots,
    SpringArrays,
    SpringEnds,
    SpringScratch,
    State,
)
from bladewhirl.solvers.kernel.compilation import APART, COMPILE, Array
from bladewhirl.solvers.kernel.vectors import (
    LANES,
    fma,
    load,
    load_row,
    mul,
    plain,
    splat,
    store_row,
    sub,
    total,
)


@njit(**COMPILE)
def predict(body: BodyArrays, x: Array, slots: Slots) -> None:
    """x_{n+1} of the free motion from x_n and x_{n-1}, by the recurrence's a and b."""
    for i in range(0, len(body.a), LANES):
        a, now = load(body.a, i), load_row(x, slots.now, i)
        b, old = load(body.b, i), load_row(x, slots.old, i)
        store_row(x, slots.new, i, fma(a, now, mul(b, old)))


@njit(**COMPILE)
def load_amplitudes(loads: Array, time: float, out: Array) -> bool:
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
def add_loads(body: BodyArrays, amplitude: Array, x: Array, slots: Slots) -> None:
    """Add what the load patterns move, in the registers that they load."""
    for p in range(len(amplitude)):
        factor = splat(amplitude[p])
        for k in range(body.loaded.shape[1]):
            i = body.loaded[p, k]
            if i < 0:
                break
            force = mul(factor, load_row(body.load, p, i))
            moved = fma(force, load(body.c, i), load_row(x, slots.new, i))
            store_row(x, slots.new, i, moved)


@njit(**COMPILE)
def spring_waves(ends: SpringEnds, x: Array, slot: int, out: Array, row: int) -> None:
    """Waves of one body's radial displacement at the springs."""
    for i in range(out.shape[1]):
        out[row, i] = 0.0
    for i in range(len(ends.place)):
        out[row, ends.wave[i]] += ends.amplitude[i] * x[slot, ends.place[i]]


@njit(**APART)
def _stretch(springs: SpringArrays, s: SpringScratch, step: int) -> None:
    """Stretch of the springs, casing less rotor: rows 0 and 1 at the last angle for the last
    displacement and this one, rows 2 and 3 the same at this angle.
    """
    for turned in range(2):
        for h in range(len(springs.nodal_diameter)):
            phase = springs.nodal_diameter[h] * (springs.angle_per_step * (step - 1 + turned))
            cos, sin = np.cos(phase), np.sin(phase)
            for moved in range(2):
                row = (step + 1 + moved) % 2
                u_c, u_s = s.rotor[row, 2 * h], s.rotor[row, 2 * h + 1]
                at = 2 * turned + moved
                s.stretch[at, 2 * h] = s.casing[row, 2 * h] - (u_c * cos - u_s * sin)
                s.stretch[at, 2 * h + 1] = s.casing[row, 2 * h + 1] - (u_c * sin + u_s * cos)


@njit(**COMPILE)
def _spring_energy(factor: Array, stretch: Array, first: int) -> float:
    """x_{n-1}^T K* x_n / 2 from the stretches of both displacements at one angle."""
    energy = 0.0
    for i in range(len(factor)):
        energy += factor[i] * stretch[first, i] * stretch[first + 1, i]
    return 0.5 * energy


@njit(**COMPILE)
def turn_springs(
    springs: SpringArrays, x: Array, y: Array, now: int, s: SpringScratch, step: int
) -> tuple[float, float]:
    """Find the springs' forces -C^T f kappa C x_n on the waves of rotor and casing.

    Returns:
        energy of the springs at step n - 1/2, and the work of turning them on to step n.
    """
    spring_waves(springs.rotor, x, now, s.rotor, step % 2)
    spring_waves(springs.casing, y, now, s.casing, step % 2)
    _stretch(springs, s, step)
    for h in range(len(springs.nodal_diameter)):
        phase = springs.nodal_diameter[h] * (springs.angle_per_step * step)
        cos, sin = np.cos(phase), np.sin(phase)
        i = 2 * h
        pull_c = springs.factor[i] * s.stretch[3, i]
        pull_s = springs.factor[i + 1] * s.stretch[3, i + 1]
        s.force[0, i] = cos * pull_c + sin * pull_s
        s.force[0, i + 1] = cos * pull_s - sin * pull_c
        s.force[1, i], s.force[1, i + 1] = -pull_c, -pull_s
    energy = _spring_energy(springs.factor, s.stretch, plain(0))
    return energy, _spring_energy(springs.factor, s.stretch, plain(2)) - energy


@njit(**COMPILE)
def add_springs(ends: SpringEnds, force: Array, row: int, c: Array, x: Array, slots: Slots) -> None:
    """Add what the springs move, by the amplitude of each mode in its wave."""
    for i in range(len(ends.place)):
        at = ends.place[i]
        x[slots.new, at] += c[at] * ends.amplitude[i] * force[row, ends.wave[i]]


@njit(**COMPILE)
def add_dampers(
    ends: DamperEnds, c: Array, x: Array, slots: Slots, stroke: Array, force: Array, row: int
) -> None:
    """Add the dampers' forces to the predicted x_{n+1}."""
    damper_forces(ends, x, slots, stroke, force, row)
    count, width = ends.rows.shape
    for i in range(0, width, LANES):
        pull = splat(0.0)
        for m in range(count):
            pull = fma(load_row(ends.rows, m, i), splat(force[row, m]), pull)
        store_row(x, slots.new, i, fma(load(c, i), pull, load_row(x, slots.new, i)))


@njit(**COMPILE)
def damper_forces(
    ends: DamperEnds, x: Array, slots: Slots, stroke: Array, force: Array, row: int
) -> None:
    """phi of each damper, by its stroke to x_{n+1}."""
    _strokes(ends.rows, x, slots, stroke)
    for m in range(len(ends.rows)):
        phi = 0.0
        for k in range(len(ends.rows)):
            phi -= ends.solve[m, k] * stroke[k]
        force[row, m] = phi


@njit(**COMPILE)
def _strokes(rows: Array, x: Array, slots: Slots, out: Array) -> None:
    """G (x_{n+1} - x_{n-1})."""
    for m in range(len(rows)):
        part = splat(0.0)
        for i in range(0, rows.shape[1], LANES):
            moved = sub(load_row(x, slots.new, i), load_row(x, slots.old, i))
            part = fma(load_row(rows, m, i), moved, part)
        out[m] = total(part)


@njit(**COMPILE)
def damper_loss(
    ends: DamperEnds, x: Array, slots: Slots, stroke: Array, force: Array, row: int
) -> float:
    """-d^T G^T phi with d = (x_{n+1} - x_{n-1}) / 2."""
    _strokes(ends.rows, x, slots, stroke)
    loss = 0.0
    for m in range(len(ends.rows)):
        loss -= 0.5 * force[row, m] * stroke[m]
    return loss


@njit(**COMPILE)
def external_work(body: BodyArrays, amplitude: Array, x: Array, slots: Slots) -> float:
    """d^T f with d = (x_{n+1} - x_{n-1}) / 2."""
    done = 0.0
    for p in range(len(amplitude)):
        part = splat(0.0)
        for k in range(body.loaded.shape[1]):
            i = body.loaded[p, k]
            if i < 0:
                break
            moved = sub(load_row(x, slots.new, i), load_row(x, slots.old, i))
            part = fma(moved, load_row(body.load, p, i), part)
        done += 0.5 * amplitude[p] * total(part)
    return done


@njit(**COMPILE)
def damping_loss(body: BodyArrays, x: Array, slots: Slots) -> float:
    """d^T D d with d = (x_{n+1} - x_{n-1}) / 2."""
    loss = splat(0.0)
    for i in range(0, len(body.damping), LANES):
        moved = sub(load_row(x, slots.new, i), load_row(x, slots.old, i))
        loss = fma(mul(load(body.damping, i), moved), moved, loss)
    return 0.25 * float(total(loss))


@njit(**COMPILE)
def _half_step_energy(stiffness: Array, x: Array, slots: Slots, time_step: float) -> float:
    """E_{n-1/2} = v^T v / 2 + x_{n-1}^T K x_n / 2 with v = (x_n - x_{n-1}) / dt."""
    energy = 0.0
    for i in range(len(stiffness)):
        v = (x[slots.now, i] - x[slots.old, i]) / time_step
        energy += v * v + stiffness[i] * x[slots.now, i] * x[slots.old, i]
    return 0.5 * energy


@njit(**COMPILE)
def _record_motion(
    x: Array, slots: Slots, later: int, interval: float, row: int, place: Array, velocity: Array
) -> None:
    """Displacement and velocity of one body."""
    for i in range(x.shape[1]):
        place[row, i] = x[slots.now, i]
        velocity[row, i] = (x[later, i] - x[slots.old, i]) / interval


@njit(**APART)
def write_record(
    records: Records,
    row: int,
    state: State,
    rotor: BodyArrays,
    casing: BodyArrays,
    slots: Slots,
    time_step: float,
    spring_energy: float,
    step: int,
    within: bool,
) -> None:
    """What is known at step n, before x_{n+1}; what counts between records starts anew.

    The velocity is a central difference or, where x_{n+1} left the limit, a backward one.
    """
    later, interval = (slots.new, 2.0 * time_step) if within else (slots.now, time_step)
    records.step[row], records.contacts[row] = step, state.counts[STEP_CONTACTS]
    records.energy[row] = (
        _half_step_energy(rotor.stiffness, state.rotor, slots, time_step)
        + _half_step_energy(casing.stiffness, state.casing, slots, time_step)
        + spring_energy
    )
    _record_motion(state.rotor, slots, later, interval, row, records.rotor, records.rotor_velocity)
    _record_motion(
        state.casing, slots, later, interval, row, records.casing, records.casing_velocity
    )
    for i in range(len(state.work)):
        records.work[row, i] = state.work[i]
    for j in range(len(state.gap)):
        records.gap[row, j], state.gap[j] = state.gap[j], np.inf
        records.impulse[row, j], state.impulse[j] = state.impulse[j], 0.0
        records.drag[row, j], state.drag[j] = state.drag[j], 0.0
        records.touched[row, j], state.touched[j] = state.touched[j], 0.0


@njit(**COMPILE)
def settle(x: Array, slots: Slots) -> None:
    """Put x_{n-1} and x_n back into slots 0 and 1."""
    for i in range(x.shape[1]):
        before, current, scratch = x[slots.old, i], x[slots.now, i], x[slots.new, i]
        x[0, i], x[1, i], x[2, i] = before, current, scratch
