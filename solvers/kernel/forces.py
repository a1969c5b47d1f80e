"""Compiled contact forces: on tips and casing nodes, by column, and the correction they give."""

from __future__ import annotations

from numba import njit

from bladewhirl.solvers.kernel.arrays import (
    CONTACT_STEPS,
    DRAG,
    PUSH,
    STEP_CONTACTS,
    U_KIND,
    U_SLOPE,
    W_KIND,
    W_SLOPE,
)
from bladewhirl.solvers.kernel.compilation import COMPILE, Array
from bladewhirl.solvers.kernel.fields import partner_columns
from bladewhirl.solvers.kernel.vectors import (
    LANES,
    add,
    fma,
    load,
    load_row,
    mul,
    plain,
    splat,
    store,
    store_row,
    sub,
    total,
)


@njit(**COMPILE)
def tip_forces(
    active: Array,
    size: int,
    multiplier: Array,
    sign: Array,
    friction: float,
    nodes: int,
    hermite: Array,
    element: Array,
    index: Array,
    factor: Array,
) -> tuple[bool, float]:
    """Forces of the active tips and on the casing's nodes next to them, two for each tip.

    ``factor`` gets push and drag of each tip, then what loads w, w', u, u' of each node.

    Returns:
        whether tips slide in different senses, and the ratio of drag to push where they don't.
    """
    mixed, ratio = False, 0.0
    for m in range(size):
        j = active[m]
        push, slides, e = multiplier[j], friction * sign[j], element[j]
        mixed = mixed or (m > 0 and slides != ratio)
        ratio = slides
        factor[PUSH, m], factor[DRAG, m] = -push, -push * slides
        for end in range(2):
            n = 2 * m + end
            index[n] = e + end if e + end < nodes else 0
            value, slope = push * hermite[2 * end, j], push * hermite[2 * end + 1, j]
            factor[W_KIND, n], factor[W_SLOPE, n] = value, slope
            factor[U_KIND, n], factor[U_SLOPE, n] = slides * value, slides * slope
    return mixed, ratio


@njit(**COMPILE)
def _spread(
    rows: Array, index: Array, factor: Array, which: int, count: int, half: int, columns: Array
) -> None:
    """Forces at points by column, and the first half of the columns once more behind."""
    for h in range(0, rows.shape[1], LANES):
        x = splat(0.0)
        for n in range(count):
            x = fma(load_row(rows, index[n], h), splat(factor[which, n]), x)
        store_row(columns, which, h, x)
        if h < half:
            store_row(columns, which, rows.shape[1] + h, x)


@njit(**COMPILE)
def _spread_two(
    rows: Array, index: Array, factor: Array, which: int, count: int, half: int, columns: Array
) -> None:
    """`_spread` of two kinds of forces that have one shape, two registers at a time."""
    for h in range(0, rows.shape[1], 2 * LANES):
        g = h + LANES
        a0, a1, b0, b1 = splat(0.0), splat(0.0), splat(0.0), splat(0.0)
        for n in range(count):
            at, a, b = index[n], splat(factor[which, n]), splat(factor[which + 1, n])
            x0, x1 = load_row(rows, at, h), load_row(rows, at, g)
            a0, a1 = fma(x0, a, a0), fma(x1, a, a1)
            b0, b1 = fma(x0, b, b0), fma(x1, b, b1)
        store_row(columns, which, h, a0)
        store_row(columns, which, g, a1)
        store_row(columns, which + 1, h, b0)
        store_row(columns, which + 1, g, b1)
        if h < half:
            store_row(columns, which, rows.shape[1] + h, a0)
            store_row(columns, which + 1, rows.shape[1] + h, b0)
        if g < half:
            store_row(columns, which, rows.shape[1] + g, a1)
            store_row(columns, which + 1, rows.shape[1] + g, b1)


@njit(**COMPILE)
def rotor_columns(
    spread: Array,
    drag_spread: Array,
    shared: bool,
    mixed: bool,
    ratio: float,
    active: Array,
    factor: Array,
    size: int,
    half: int,
    columns: Array,
) -> tuple[int, float]:
    """Forces on the tips by column.

    Returns:
        row of ``columns`` that friction is a multiple of, and the multiple: where all tips slide
        in one sense it is the normal force's.
    """
    _spread(spread, active, factor, plain(PUSH), size, half, columns)
    if shared and not mixed:
        return PUSH, ratio
    _spread(drag_spread, active, factor, plain(DRAG), size, half, columns)
    return DRAG, 1.0


@njit(**COMPILE)
def casing_columns(
    w_spread: Array,
    w_s_spread: Array,
    u_spread: Array,
    u_s_spread: Array,
    shared: bool,
    mixed: bool,
    ratio: float,
    index: Array,
    factor: Array,
    count: int,
    half: int,
    columns: Array,
) -> tuple[int, float]:
    """The same on the casing's nodes; friction is a multiple of two rows, the first given."""
    if shared:
        _spread_two(w_spread, index, factor, plain(W_KIND), count, half, columns)
        if not mixed:
            return W_KIND, ratio
        _spread_two(u_spread, index, factor, plain(U_KIND), count, half, columns)
    else:
        _spread(w_spread, index, factor, plain(W_KIND), count, half, columns)
        _spread(w_s_spread, index, factor, plain(W_SLOPE), count, half, columns)
        _spread(u_spread, index, factor, plain(U_KIND), count, half, columns)
        _spread(u_s_spread, index, factor, plain(U_SLOPE), count, half, columns)
    return U_KIND, 1.0


@njit(**COMPILE)
def correct_rotor(
    c: Array,
    force: Array,
    dragging: int,
    ratio: float,
    half: int,
    radial: Array,
    tangential: Array,
    crossed: Array,
    slots: Array,
    old: int,
    new: int,
    work: Array,
    out: Array,
) -> None:
    """Add contact forces, given by column, to x_{n+1}; their work, and the new radial columns.

    Friction is ``ratio`` times row ``dragging`` of ``force``.
    """
    rows, columns = radial.shape
    on_normal, on_shear, slides = splat(0.0), splat(0.0), splat(ratio)
    for h in range(0, columns, LANES):
        push, drag = load_row(force, PUSH, h), mul(slides, load_row(force, dragging, h))
        cross = mul(slides, load_row(force, dragging, half + h))
        column = splat(0.0)
        for m in range(rows):
            i = m * columns + h
            weight = load_row(radial, m, h)
            normal = mul(push, weight)
            shear = fma(drag, load_row(tangential, m, h), mul(cross, load_row(crossed, m, h)))
            x = fma(load(c, i), add(normal, shear), load_row(slots, new, i))
            store_row(slots, new, i, x)
            moved = sub(x, load_row(slots, old, i))
            on_normal = fma(moved, normal, on_normal)
            on_shear = fma(moved, shear, on_shear)
            column = fma(weight, x, column)
        store(out, h, column)
    work[0] = 0.5 * total(on_normal)
    work[1] = 0.5 * total(on_shear)


@njit(**COMPILE)
def correct_casing(
    c: Array,
    force: Array,
    dragging: int,
    ratio: float,
    half: int,
    w_weight: Array,
    w_s_weight: Array,
    u_weight: Array,
    u_s_weight: Array,
    slots: Array,
    old: int,
    new: int,
    work: Array,
    values: Array,
    slopes: Array,
) -> None:
    """Add contact forces, given by column, to x_{n+1}; their work, and the columns of w and w'.

    Friction is ``ratio`` times rows ``dragging`` and the next of ``force``.
    """
    rows, columns = w_weight.shape
    on_normal, on_shear, slides = splat(0.0), splat(0.0), splat(ratio)
    for h in range(0, columns, LANES):
        on_w, on_w_s = load_row(force, W_KIND, h), load_row(force, W_SLOPE, half + h)
        on_u = mul(slides, load_row(force, dragging, half + h))
        on_u_s = mul(slides, load_row(force, dragging + 1, h))
        value, slope = splat(0.0), splat(0.0)
        for m in range(rows):
            i = m * columns + h
            w, w_s = load_row(w_weight, m, h), load_row(w_s_weight, m, h)
            normal = fma(on_w, w, mul(on_w_s, w_s))
            shear = fma(on_u, load_row(u_weight, m, h), mul(on_u_s, load_row(u_s_weight, m, h)))
            x = fma(load(c, i), add(normal, shear), load_row(slots, new, i))
            store_row(slots, new, i, x)
            moved = sub(x, load_row(slots, old, i))
            on_normal = fma(moved, normal, on_normal)
            on_shear = fma(moved, shear, on_shear)
            value, slope = fma(w, x, value), fma(w_s, x, slope)
        store(values, h, value)
        store(slopes, partner_columns(h, half), slope)
    work[0] += 0.5 * total(on_normal)
    work[1] += 0.5 * total(on_shear)


@njit(**COMPILE)
def account_contact(
    multiplier: Array,
    sign: Array,
    friction: float,
    time_step: float,
    impulse: Array,
    drag: Array,
    touched: Array,
    held: Array,
    count: Array,
) -> None:
    """Book the impulses of an accepted step with contact."""
    contacts = 0
    for j in range(len(multiplier)):
        held[j] = 0.0
        if multiplier[j] > 0.0:
            held[j] = 1.0
            contacts += 1
            pressed = multiplier[j] * time_step
            impulse[j] += pressed
            drag[j] += friction * sign[j] * pressed
            touched[j] += 1.0
    count[STEP_CONTACTS] = contacts
    count[CONTACT_STEPS] += 1
