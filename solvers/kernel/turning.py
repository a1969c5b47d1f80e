"""Compiled motion of a rotor that feels Coriolis forces: A couples its modes.

The recurrence gives A (x_{n+1} - x_{n-1}), without velocities: with A = M / dt^2 + C / (2 dt) the
scheme's (C / (2 dt) - M / dt^2) x_{n-1} is (A - 2 M / dt^2) x_{n-1}. One product by A^-1 does the
rest. Forces are added before it, so the functions of `motion` serve with a unit ``c``.
"""

from __future__ import annotations

from typing import Any

from numba import njit

from bladewhirl.solvers.kernel.arrays import (
    PUSH,
    ROWS,
    ContactScratch,
    FieldScratch,
    GyroscopicArrays,
    RotorArrays,
    Slots,
)
from bladewhirl.solvers.kernel.compilation import APART, COMPILE, Array
from bladewhirl.solvers.kernel.forces import rotor_columns
from bladewhirl.solvers.kernel.vectors import (
    HALF,
    LANES,
    add,
    fma,
    load,
    load_half,
    load_half_row,
    load_row,
    mul,
    splat,
    splat_half,
    store,
    store_row,
    sub,
    total,
)


@njit(**COMPILE)
def add_circulation(gyroscopic: GyroscopicArrays, x: Array, slots: Slots) -> None:
    """Add the force of dampers that stand still, by x_n, to what slot ``new`` holds."""
    for m in range(len(gyroscopic.centre)):
        moved = splat(_product(gyroscopic.centre, m, x, slots.now))
        for i in range(0, x.shape[1], LANES):
            force = fma(load_row(gyroscopic.circulation, m, i), moved, load_row(x, slots.new, i))
            store_row(x, slots.new, i, force)


@njit(**COMPILE)
def _product(rows: Array, row: int, x: Array, slot: int) -> float:
    """Scalar product of a row with a slot."""
    part = splat(0.0)
    for i in range(0, x.shape[1], LANES):
        part = fma(load_row(rows, row, i), load_row(x, slot, i), part)
    return total(part)  # type: ignore[no-any-return]


@njit(**COMPILE)
def circulation_work(gyroscopic: GyroscopicArrays, x: Array, slots: Slots) -> float:
    """d^T f of dampers that stand still with d = (x_{n+1} - x_{n-1}) / 2."""
    work = 0.0
    for m in range(len(gyroscopic.centre)):
        moved = _product(gyroscopic.circulation, m, x, slots.new)
        moved -= _product(gyroscopic.circulation, m, x, slots.old)
        work += 0.5 * moved * _product(gyroscopic.centre, m, x, slots.now)
    return work


@njit(**COMPILE)
def turning_loss(
    rotor: RotorArrays, gyroscopic: GyroscopicArrays, x: Array, slots: Slots, moved: Array
) -> float:
    """d^T D d with d = (x_{n+1} - x_{n-1}) / 2; ``moved`` is scratch."""
    rows, columns = rotor.radial.shape
    for i in range(0, x.shape[1], LANES):
        store(moved, i, sub(load_row(x, slots.new, i), load_row(x, slots.old, i)))
    loss = splat(0.0)
    for n in range(len(gyroscopic.full_loss)):
        by = splat(moved[n])
        for i in range(n - n % LANES, x.shape[1], LANES):
            loss = fma(mul(by, load_row(gyroscopic.full_loss, n, i)), load(moved, i), loss)
    if len(gyroscopic.loss) == 0:
        return 0.25 * float(total(loss))
    half, at = rotor.half, 0
    lost = splat_half(0.0)
    for h in range(0, half, HALF):
        for m in range(0, rows, ROWS):
            a, b, c, d = splat_half(0.0), splat_half(0.0), splat_half(0.0), splat_half(0.0)
            aa, bb, cc, dd = splat_half(0.0), splat_half(0.0), splat_half(0.0), splat_half(0.0)
            for n in range(m, rows):
                cosine = load_half(moved, n * columns + h)
                sine = load_half(moved, n * columns + half + h)
                p, q = load_half(gyroscopic.loss, at), load_half(gyroscopic.loss, at + HALF)
                a, b = fma(p, cosine, a), fma(q, cosine, b)
                aa, bb = fma(p, sine, aa), fma(q, sine, bb)
                at += 2 * HALF
                p, q = load_half(gyroscopic.loss, at), load_half(gyroscopic.loss, at + HALF)
                c, d = fma(p, cosine, c), fma(q, cosine, d)
                cc, dd = fma(p, sine, cc), fma(q, sine, dd)
                at += 2 * HALF
            i = m * columns + h
            lost = _lost(moved, i, half, a, aa, lost)
            if m + 1 < rows:
                lost = _lost(moved, i + columns, half, b, bb, lost)
            if m + 2 < rows:
                lost = _lost(moved, i + 2 * columns, half, c, cc, lost)
            if m + 3 < rows:
                lost = _lost(moved, i + 3 * columns, half, d, dd, lost)
    return 0.25 * float(total(lost))


@njit(**COMPILE)
def _lost(moved: Array, i: int, half: int, cosine: Any, sine: Any, lost: Any) -> Any:
    """Add products with a row of cosines and sines to a sum."""
    return fma(cosine, load_half(moved, i), fma(sine, load_half(moved, i + half), lost))


@njit(**COMPILE)
def turn(
    rotor: RotorArrays, gyroscopic: GyroscopicArrays, x: Array, slots: Slots, f: Array
) -> None:
    """Make x_{n+1} of the force that slot ``new`` holds: x_{n-1} + A^-1 f."""
    for i in range(0, x.shape[1], LANES):
        store(f, i, load_row(x, slots.new, i))
    if rotor.half == 0:
        _add_full(gyroscopic.full, f, x, slots.old, slots.new)
    else:
        _add_blocks(rotor, gyroscopic, f, x, slots)


@njit(**APART)
def _add_full(full: Array, f: Array, x: Array, slot: int, out: int) -> None:
    """Slot ``out`` gets another slot and A^-1 f, on any rotor."""
    for i in range(0, x.shape[1], 2 * LANES):
        first, second = load_row(x, slot, i), load_row(x, slot, i + LANES)
        for n in range(len(full)):
            force = splat(f[n])
            first = fma(load_row(full, n, i), force, first)
            second = fma(load_row(full, n, i + LANES), force, second)
        store_row(x, out, i, first)
        store_row(x, out, i + LANES, second)


@njit(**APART)
def _add_blocks(
    rotor: RotorArrays, gyroscopic: GyroscopicArrays, f: Array, x: Array, slots: Slots
) -> None:
    """x_{n-1} + A^-1 f on a cyclic rotor, `ROWS` rows of cosines and sines at a time."""
    rows, columns = rotor.radial.shape
    blocks, half, at = gyroscopic.blocks, rotor.half, 0
    for h in range(0, half, HALF):
        for m in range(0, rows, ROWS):
            a, b, c, d = splat_half(0.0), splat_half(0.0), splat_half(0.0), splat_half(0.0)
            aa, bb, cc, dd = splat_half(0.0), splat_half(0.0), splat_half(0.0), splat_half(0.0)
            for n in range(rows):
                cosine, sine = load_half(f, n * columns + h), load_half(f, n * columns + half + h)
                minus = sub(splat_half(0.0), cosine)
                p, q = load_half(blocks, at), load_half(blocks, at + HALF)
                a, b = fma(p, cosine, a), fma(q, cosine, b)
                aa, bb = fma(p, sine, aa), fma(q, sine, bb)
                p, q = load_half(blocks, at + 2 * HALF), load_half(blocks, at + 3 * HALF)
                c, d = fma(p, cosine, c), fma(q, cosine, d)
                cc, dd = fma(p, sine, cc), fma(q, sine, dd)
                p, q = load_half(blocks, at + 4 * HALF), load_half(blocks, at + 5 * HALF)
                a, b = fma(p, sine, a), fma(q, sine, b)
                aa, bb = fma(p, minus, aa), fma(q, minus, bb)
                p, q = load_half(blocks, at + 6 * HALF), load_half(blocks, at + 7 * HALF)
                c, d = fma(p, sine, c), fma(q, sine, d)
                cc, dd = fma(p, minus, cc), fma(q, minus, dd)
                at += 2 * ROWS * HALF
            i = m * columns + h
            _move(x, slots, i, half, a, aa)
            if m + 1 < rows:
                _move(x, slots, i + columns, half, b, bb)
            if m + 2 < rows:
                _move(x, slots, i + 2 * columns, half, c, cc)
            if m + 3 < rows:
                _move(x, slots, i + 3 * columns, half, d, dd)
    for k in range(len(gyroscopic.rest)):
        x[slots.new, gyroscopic.to[k]] += gyroscopic.rest[k] * f[gyroscopic.by[k]]


@njit(**COMPILE)
def _move(x: Array, slots: Slots, i: int, half: int, cosine: Any, sine: Any) -> None:
    """x_{n-1} and a change over two steps, of a half register of cosines and of sines."""
    store_row(x, slots.new, i, add(load_half_row(x, slots.old, i), cosine))
    store_row(x, slots.new, i + half, add(load_half_row(x, slots.old, i + half), sine))


@njit(**APART)
def correct_turning_rotor(
    rotor: RotorArrays,
    gyroscopic: GyroscopicArrays,
    size: int,
    mixed: bool,
    ratio: float,
    x: Array,
    slots: Slots,
    f: FieldScratch,
    c: ContactScratch,
    forces: Array,
) -> None:
    """`correct_rotor` where a force moves more modes than its own; ``forces`` is scratch."""
    dragging, slide = rotor_columns(rotor, size, mixed, ratio, c)
    rows, columns = rotor.radial.shape
    half, slides = rotor.half, splat(slide)
    if half == 0:
        for i in range(0, columns, LANES):
            drag = mul(slides, load_row(c.columns, dragging, i))
            store(forces, i, add(load_row(c.columns, PUSH, i), drag))
        _add_full(gyroscopic.full, forces, x, slots.new, slots.new)
    on_normal, on_shear = splat(0.0), splat(0.0)
    for h in range(0, columns, LANES):
        push, pull = load_row(c.columns, PUSH, h), load_row(c.columns, PUSH, half + h)
        drag = mul(slides, load_row(c.columns, dragging, h))
        cross = mul(slides, load_row(c.columns, dragging, half + h))
        column = splat(0.0)
        for m in range(rows):
            i = m * columns + h
            moved, weight = load_row(x, slots.new, i), load_row(rotor.radial, m, h)
            if half > 0:
                moved = fma(push, load_row(gyroscopic.normal, m, h), moved)
                moved = fma(pull, load_row(gyroscopic.normal_across, m, h), moved)
                moved = fma(drag, load_row(gyroscopic.shear, m, h), moved)
                moved = fma(cross, load_row(gyroscopic.shear_across, m, h), moved)
                store_row(x, slots.new, i, moved)
            change = sub(moved, load_row(x, slots.old, i))
            shear = mul(cross, load_row(rotor.crossed, m, h))
            shear = fma(drag, load_row(rotor.tangential, m, h), shear)
            on_normal = fma(change, mul(push, weight), on_normal)
            on_shear = fma(change, shear, on_shear)
            column = fma(weight, moved, column)
        store(f.rotor, h, column)
    c.work[0] = 0.5 * total(on_normal)
    c.work[1] = 0.5 * total(on_shear)
