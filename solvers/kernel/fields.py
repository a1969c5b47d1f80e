"""Compiled evaluation of fields: tips, casing nodes, gaps, sliding.

Modal coordinates are first summed over rows with weights, giving one number a column, and the
columns are then spread over tips or casing nodes by a shape; see `kernel`.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit

from bladewhirl.solvers.kernel.compilation import COMPILE, Array
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
def _folded_fields(
    fold: Array,
    values: Array,
    slopes: Array,
    half: int,
    nodes: int,
    start: Array,
    value: Array,
    slope: Array,
) -> None:
    """`nodal_fields` of an even number of nodes, four nodes at a time.

    The nodes n, N/2 - n, N/2 + n and N - n share their cosines and sines but for signs, which
    the parity of the harmonic decides. Rows of ``fold``: cosines of even harmonics, of odd ones,
    sines of even, of odd, and the cosine of N/2, which stands in the place of a sine.
    """
    used, middle = len(fold) // 4, nodes // 2
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
        _unfold(ce, co, se, so, i, middle, start, plain(0), value)
        _unfold(de, do, te, to, i, middle, start, plain(1), slope)


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


@njit(**COMPILE)
def nodal_fields(
    fold: Array,
    value_shape: Array,
    slope_shape: Array,
    values: Array,
    slopes: Array,
    half: int,
    nodes: int,
    start: Array,
    value: Array,
    slope: Array,
) -> None:
    """Values and slopes of a field at the casing's nodes, plus ``start``; node 0 comes again."""
    if len(fold) > 0:
        _folded_fields(fold, values, slopes, half, nodes, start, value, slope)
        return
    combine_rows(value_shape, values, value)
    combine_rows(slope_shape, slopes, slope)
    value[nodes], slope[nodes] = value[0], slope[0]
    for i in range(0, start.shape[1], LANES):
        store(value, i, add(load(value, i), load_row(start, 0, i)))
        store(slope, i, add(load(slope, i), load_row(start, 1, i)))


@njit(**COMPILE)
def place_tips(
    position: Array,
    shift: float,
    nodes: int,
    length: float,
    hermite: Array,
    element: Array,
) -> None:
    """Find the element under each tip and its Hermite weights."""
    turn = 1.0 / nodes
    for j in range(len(element)):
        at = position[j] + shift
        at -= nodes * np.floor(at * turn)
        start = np.floor(at)
        xi = at - start
        rest = 1.0 - xi
        # Rounding may put a tip on node `nodes`, which is node 0 again; a displacement beyond all
        # bounds, which ends the march, puts it anywhere.
        element[j] = int(start) if 0.0 <= start < nodes else 0
        hermite[0, j] = rest * rest * (1.0 + 2.0 * xi)
        hermite[1, j] = length * xi * rest * rest
        hermite[2, j] = xi * xi * (3.0 - 2.0 * xi)
        hermite[3, j] = -length * xi * xi * rest


@njit(**COMPILE)
def _on_tips(value: Array, slope: Array, hermite: Array, element: Array, out: Array) -> bool:
    """Value of a nodal Hermite field under each tip; False, and no further, at a NaN.

    Leaving the loop early also keeps the compiler from vector gathers, which are slower here.
    """
    for j in range(len(element)):
        e = element[j]
        at_tip = (hermite[0, j] * value[e] + hermite[1, j] * slope[e]) + (
            hermite[2, j] * value[e + 1] + hermite[3, j] * slope[e + 1]
        )
        out[j] = at_tip
        if at_tip != at_tip:
            return False
    return True


@njit(**COMPILE)
def close_gaps(
    value: Array,
    slope: Array,
    hermite: Array,
    element: Array,
    radial: Array,
    recess: Array,
    limit: float,
    gap: Array,
) -> bool:
    """Gap of each tip from nodal gaps and its u_r; whether all |u_r| keep the limit."""
    if not _on_tips(value, slope, hermite, element, gap):
        return False
    within, tips = 0, len(element)
    for j in range(tips):
        gap[j] += recess[j] - radial[j]
        within += abs(radial[j]) <= limit  # False for NaN
    return within == tips


@njit(**COMPILE)
def tip_tangential(
    tangential: Array,
    crossed: Array,
    shape: Array,
    cross_shape: Array,
    slots: Array,
    slot: int,
    columns: Array,
    out: Array,
    scratch: Array,
) -> None:
    """Tangential displacement of each tip."""
    column_sums(tangential, slots, slot, plain(0), columns)
    combine_rows(shape, columns, out)
    column_sums(crossed, slots, slot, plain(0), columns)
    combine_rows(cross_shape, columns, scratch)
    for j in range(0, len(out), LANES):
        store(out, j, add(load(out, j), load(scratch, j)))


@njit(**COMPILE)
def step_difference(slots: Array, later: int, earlier: int, out: Array, row: int) -> None:
    """Modal coordinates of a slot less those of an earlier one, into a row."""
    for i in range(0, slots.shape[1], LANES):
        store_row(out, row, i, sub(load_row(slots, later, i), load_row(slots, earlier, i)))


@njit(**COMPILE)
def casing_tangential(
    weight: Array,
    slope_weight: Array,
    fold: Array,
    shape: Array,
    slope_shape: Array,
    half: int,
    slots: Array,
    slot: int,
    values: Array,
    slopes: Array,
    nodes: int,
    start: Array,
    value: Array,
    slope: Array,
    hermite: Array,
    element: Array,
    out: Array,
) -> None:
    """Tangential displacement of the casing under each tip."""
    column_sums(weight, slots, slot, half, values)
    column_sums(slope_weight, slots, slot, plain(0), slopes)
    nodal_fields(fold, shape, slope_shape, values, slopes, half, nodes, start, value, slope)
    _on_tips(value, slope, hermite, element, out)


@njit(**COMPILE)
def sliding_signs(
    blade: Array, casing: Array, wheel_speed: float, time_step: float, sign: Array
) -> None:
    """Direction of sliding at each tip, from the tangential displacements over the last step."""
    for j in range(len(sign)):
        sign[j] = np.sign(wheel_speed + (blade[j] - casing[j]) / time_step)


@njit(**COMPILE)
def keeps_limit(
    tangential: Array, tips: int, nodal_gap: Array, clearance: Array, nodes: int, limit: float
) -> bool:
    """Whether tips tangentially, and the casing radially, keep the displacement limit."""
    within = True
    for j in range(tips):
        within = within and abs(tangential[j]) <= limit
    for i in range(nodes):
        within = within and abs(nodal_gap[i] - clearance[0, i]) <= limit
    return within
