"""Compiled evaluation of fields: tips, casing nodes, gaps, sliding.

Modal coordinates are first summed over rows with weights, giving one number a column, and the
columns are then spread over tips or casing nodes by a shape; see `step`.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit

from bladewhirl.solvers.kernel.arrays import (
    CasingArrays,
    FieldScratch,
    NodalField,
    RotorArrays,
    Slots,
)
from bladewhirl.solvers.kernel.compilation import APART, COMPILE, Array
from bladewhirl.solvers.kernel.vectors import (
    LANES,
    add,
    fma,
    load,
    load_row,
    plain,
    reverse,
    splat,
    store,
    store_row,
    sub,
)


@njit(**COMPILE)
def partner_columns(h: int, half: int) -> int:
    """Place of a register's partner columns."""
    return h + half if h < half else h - half


@njit(**COMPILE)
def column_sums(weight: Array, slots: Array, slot: int, half: int, out: Array) -> None:
    """Sum modal coordinates over rows with weights; each sum goes to its column's partner.

    With ``half`` zero it stays in its column.
    """
    rows, columns = weight.shape
    for h in range(0, columns, LANES):
        even, odd = splat(0.0), splat(0.0)  # two chains of additions run side by side
        for m in range(0, rows - 1, 2):
            x = m * columns + h
            even = fma(load_row(weight, m, h), load_row(slots, slot, x), even)
            odd = fma(load_row(weight, m + 1, h), load_row(slots, slot, x + columns), odd)
        if rows % 2 == 1:
            x = (rows - 1) * columns + h
            even = fma(load_row(weight, rows - 1, h), load_row(slots, slot, x), even)
        store(out, partner_columns(h, half), add(even, odd))


@njit(**COMPILE)
def combine_rows(rows: Array, factor: Array, out: Array) -> None:
    """Linear combination of all rows of a matrix."""
    count, width = rows.shape
    wide = width - width % (3 * LANES)
    for i in range(0, wide, 3 * LANES):
        first, second, third = splat(0.0), splat(0.0), splat(0.0)
        for n in range(count):
            f = splat(factor[n])
            first = fma(load_row(rows, n, i), f, first)
            second = fma(load_row(rows, n, i + LANES), f, second)
            third = fma(load_row(rows, n, i + 2 * LANES), f, third)
        store(out, i, first)
        store(out, i + LANES, second)
        store(out, i + 2 * LANES, third)
    for i in range(wide, width, LANES):
        first = splat(0.0)
        for n in range(count):
            first = fma(load_row(rows, n, i), splat(factor[n]), first)
        store(out, i, first)


@njit(**COMPILE)
def _folded_fields(casing: CasingArrays, start: Array, f: FieldScratch) -> None:
    """`_nodal_field` of an even number of nodes, four nodes at a time.

    The nodes n, N/2 - n, N/2 + n and N - n share their cosines and sines but for signs, which
    the parity of the harmonic decides. Rows of ``fold``: cosines of even harmonics, of odd ones,
    sines of even, of odd, and the cosine of N/2, which stands in the place of a sine.
    """
    fold, values, slopes, half = casing.fold, f.value, f.slope, casing.half
    used, middle = len(fold) // 4, casing.nodes // 2
    for i in range(0, fold.shape[1], LANES):
        ce, co, se, so = splat(0.0), splat(0.0), splat(0.0), splat(0.0)
        de, do, te, to = splat(0.0), splat(0.0), splat(0.0), splat(0.0)
        for h in range(used):
            even, odd = load_row(fold, h, i), load_row(fold, used + h, i)
            ce, de = fma(even, splat(values[h]), ce), fma(even, splat(slopes[h]), de)
            co, do = fma(odd, splat(values[used + h]), co), fma(odd, splat(slopes[used + h]), do)
            even, odd = load_row(fold, 2 * used + h, i), load_row(fold, 3 * used + h, i)
            x, y = half + h, half + used + h
            se, te = fma(even, splat(values[x]), se), fma(even, splat(slopes[x]), te)
            so, to = fma(odd, splat(values[y]), so), fma(odd, splat(slopes[y]), to)
        last, x = load_row(fold, 4 * used, i), half + used - 1
        ce, de = fma(last, splat(values[x]), ce), fma(last, splat(slopes[x]), de)
        _unfold(ce, co, se, so, i, middle, start, plain(0), f.nodal)
        _unfold(de, do, te, to, i, middle, start, plain(1), f.nodal_slope)


@njit(**COMPILE)
def _unfold(
    cos_even: Any,
    cos_odd: Any,
    sin_even: Any,
    sin_odd: Any,
    i: int,
    middle: int,
    start: Array,
    row: int,
    out: Array,
) -> None:
    """Write what the sums of `_folded_fields` give at the nodes n, N/2 - n, N/2 + n, N - n."""
    near, far = add(cos_even, cos_odd), sub(cos_even, cos_odd)
    turned, back = add(sin_even, sin_odd), sub(sin_even, sin_odd)
    x = middle - i - LANES + 1
    store(out, i, add(add(near, turned), load_row(start, row, i)))
    store(out, middle + i, add(add(far, back), load_row(start, row, middle + i)))
    store(out, x, add(reverse(sub(far, back)), load_row(start, row, x)))
    x += middle
    store(out, x, add(reverse(sub(near, turned)), load_row(start, row, x)))


@njit(**APART)
def _nodal_field(casing: CasingArrays, field: NodalField, f: FieldScratch) -> None:
    """Values and slopes of a field at the casing's nodes from its columns; node 0 comes again."""
    if len(casing.fold) > 0:
        _folded_fields(casing, field.start, f)
        return
    combine_rows(field.shape, f.value, f.nodal)
    combine_rows(field.slope_shape, f.slope, f.nodal_slope)
    value, slope, start = f.nodal, f.nodal_slope, field.start
    value[casing.nodes], slope[casing.nodes] = value[0], slope[0]
    for i in range(0, start.shape[1], LANES):
        store(value, i, add(load(value, i), load_row(start, 0, i)))
        store(slope, i, add(load(slope, i), load_row(start, 1, i)))


@njit(**COMPILE)
def place_tips(
    rotor: RotorArrays,
    casing: CasingArrays,
    elements_per_metre: float,
    turned: float,
    x: Array,
    slots: Slots,
    f: FieldScratch,
) -> None:
    """Find the element under each tip and its Hermite weights.

    Args:
        rotor: evaluation of the tips.
        casing: number and length of elements.
        elements_per_metre: that a tip moves on by its tangential displacement; 0 if it doesn't.
        turned: turn of the rotor in elements.
        x: slots of the rotor.
        slots: of x_{n+1}.
        f: gets place, element and weights.
    """
    for j in range(0, len(f.at), LANES):
        store(f.at, j, load(rotor.position, j))
    if elements_per_metre != 0.0:
        tip_tangential(rotor, x, slots.new, f)
        for j in range(len(f.element)):
            f.at[j] += elements_per_metre * f.tangential[j]
    nodes, length = casing.nodes, casing.element_length
    turn = 1.0 / nodes
    for j in range(len(f.element)):
        at = f.at[j] + turned
        at -= nodes * np.floor(at * turn)
        if at < 0.0:  # a turn is whole by rounding of the product, not by the place: node 0
            at = 0.0
        start = np.floor(at)
        xi = at - start
        rest = 1.0 - xi
        # Rounding may put a tip on node `nodes`, which is node 0 again; a displacement beyond all
        # bounds, which ends the march, puts it anywhere.
        f.element[j] = int(start) if 0.0 <= start < nodes else 0
        f.hermite[0, j] = rest * rest * (1.0 + 2.0 * xi)
        f.hermite[1, j] = length * xi * rest * rest
        f.hermite[2, j] = xi * xi * (3.0 - 2.0 * xi)
        f.hermite[3, j] = -length * xi * xi * rest


@njit(**COMPILE)
def sum_radial(
    rotor: RotorArrays, casing: CasingArrays, x: Array, y: Array, slots: Slots, f: FieldScratch
) -> None:
    """Columns of u_r of the tips and of w and w' of the casing, at x_{n+1}."""
    column_sums(rotor.radial, x, slots.new, plain(0), f.rotor)
    field = casing.radial
    column_sums(field.weight, y, slots.new, field.half, f.value)
    column_sums(field.slope_weight, y, slots.new, field.slope_half, f.slope)


@njit(**COMPILE)
def _on_tips(f: FieldScratch, out: Array) -> bool:
    """Value of a nodal Hermite field under each tip; False, and no further, at a NaN.

    Leaving the loop early also keeps the compiler from vector gathers, which are slower here.
    """
    hermite, value, slope = f.hermite, f.nodal, f.nodal_slope
    for j in range(len(f.element)):
        e = f.element[j]
        at_tip = (hermite[0, j] * value[e] + hermite[1, j] * slope[e]) + (
            hermite[2, j] * value[e + 1] + hermite[3, j] * slope[e + 1]
        )
        out[j] = at_tip
        if at_tip != at_tip:
            return False
    return True


@njit(**COMPILE)
def close_gaps(
    rotor: RotorArrays, casing: CasingArrays, limit: float, f: FieldScratch, gap: Array
) -> bool:
    """Gap of each tip from the columns of u_r, w and w'; whether all |u_r| keep the limit."""
    combine_rows(rotor.shape, f.rotor, f.radial)
    _nodal_field(casing, casing.radial, f)
    if not _on_tips(f, gap):
        return False
    within, tips = 0, len(f.element)
    for j in range(tips):
        gap[j] += rotor.recess[j] - f.radial[j]
        within += abs(f.radial[j]) <= limit  # False for NaN
    return within == tips


@njit(**APART)
def tip_tangential(rotor: RotorArrays, x: Array, slot: int, f: FieldScratch) -> None:
    """Tangential displacement of each tip."""
    column_sums(rotor.tangential, x, slot, plain(0), f.rotor)
    combine_rows(rotor.shape, f.rotor, f.tangential)
    column_sums(rotor.crossed, x, slot, plain(0), f.rotor)
    combine_rows(rotor.cross_shape, f.rotor, f.other)
    for j in range(0, len(f.tangential), LANES):
        store(f.tangential, j, add(load(f.tangential, j), load(f.other, j)))


@njit(**COMPILE)
def _step_difference(x: Array, slots: Slots, out: Array, row: int) -> None:
    """x_n - x_{n-1} of a body, into a row."""
    for i in range(0, x.shape[1], LANES):
        store_row(out, row, i, sub(load_row(x, slots.now, i), load_row(x, slots.old, i)))


@njit(**COMPILE)
def sliding_signs(
    rotor: RotorArrays,
    casing: CasingArrays,
    wheel_speed: float,
    time_step: float,
    x: Array,
    y: Array,
    slots: Slots,
    f: FieldScratch,
    sign: Array,
) -> None:
    """Direction of sliding at each tip, from the tangential displacements over the last step."""
    field = casing.tangential
    _step_difference(x, slots, f.moved, plain(0))
    _step_difference(y, slots, f.moved, plain(1))
    tip_tangential(rotor, f.moved, plain(0), f)
    column_sums(field.weight, f.moved, plain(1), field.half, f.value)
    column_sums(field.slope_weight, f.moved, plain(1), field.slope_half, f.slope)
    _nodal_field(casing, field, f)
    _on_tips(f, f.other)
    for j in range(len(sign)):
        sign[j] = np.sign(wheel_speed + (f.tangential[j] - f.other[j]) / time_step)


@njit(**COMPILE)
def keeps_limit(
    rotor: RotorArrays, casing: CasingArrays, limit: float, x: Array, slots: Slots, f: FieldScratch
) -> bool:
    """Whether tips tangentially, and the casing radially, keep the displacement limit."""
    tip_tangential(rotor, x, slots.new, f)
    within = True
    for j in range(len(f.element)):
        within = within and abs(f.tangential[j]) <= limit
    for i in range(casing.nodes):
        within = within and abs(f.nodal[i] - casing.radial.start[0, i]) <= limit
    return within
