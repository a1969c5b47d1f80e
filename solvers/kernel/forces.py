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
    CasingArrays,
    ContactScratch,
    FieldScratch,
    MarchNumbers,
    RotorArrays,
    Slots,
    State,
)
from bladewhirl.solvers.kernel.compilation import APART, COMPILE, Array
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
    size: int, friction: float, nodes: int, f: FieldScratch, c: ContactScratch
) -> tuple[bool, float]:
    """Forces of the active tips and on the casing's nodes next to them, two for each tip.

    ``factor`` gets push and drag of each tip, then what loads w, w', u, u' of each node.

    Returns:
        whether tips slide in different senses, and the ratio of drag to push where they don't.
    """
    mixed, ratio, factor = False, 0.0, c.factor
    for m in range(size):
        j = c.active[m]
        push, slides, e = c.multiplier[j], friction * c.sign[j], f.element[j]
        mixed = mixed or (m > 0 and slides != ratio)
        ratio = slides
        factor[PUSH, m], factor[DRAG, m] = -push, -push * slides
        for end in range(2):
            n = 2 * m + end
            c.rows[n] = e + end if e + end < nodes else 0
            value, slope = push * f.hermite[2 * end, j], push * f.hermite[2 * end + 1, j]
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
    rotor: RotorArrays, size: int, mixed: bool, ratio: float, c: ContactScratch
) -> tuple[int, float]:
    """Forces on the tips by column.

    Returns:
        row of ``columns`` that friction is a multiple of, and the multiple: where all tips slide
        in one sense it is the normal force's.
    """
    _spread(rotor.spread, c.active, c.factor, plain(PUSH), size, rotor.half, c.columns)
    if rotor.shared and not mixed:
        return PUSH, ratio
    _spread(rotor.drag_spread, c.active, c.factor, plain(DRAG), size, rotor.half, c.columns)
    return DRAG, 1.0


@njit(**COMPILE)
def _casing_columns(
    casing: CasingArrays, size: int, mixed: bool, ratio: float, c: ContactScratch
) -> tuple[int, float]:
    """The same on the casing's nodes; friction is a multiple of two rows, the first given."""
    radial, tangential, half, count = casing.radial, casing.tangential, casing.half, 2 * size
    rows, factor, columns = c.rows, c.factor, c.columns
    if casing.shared:
        _spread_two(radial.spread, rows, factor, plain(W_KIND), count, half, columns)
        if not mixed:
            return W_KIND, ratio
        _spread_two(tangential.spread, rows, factor, plain(U_KIND), count, half, columns)
    else:
        _spread(radial.spread, rows, factor, plain(W_KIND), count, half, columns)
        _spread(radial.slope_spread, rows, factor, plain(W_SLOPE), count, half, columns)
        _spread(tangential.spread, rows, factor, plain(U_KIND), count, half, columns)
        _spread(tangential.slope_spread, rows, factor, plain(U_SLOPE), count, half, columns)
    return U_KIND, 1.0


@njit(**APART)
def correct_rotor(
    rotor: RotorArrays,
    size: int,
    mixed: bool,
    ratio: float,
    x: Array,
    slots: Slots,
    f: FieldScratch,
    c: ContactScratch,
) -> None:
    """Add contact forces to x_{n+1}; their work, and the new columns of u_r.

    Args:
        rotor: what is corrected.
        size: number of active tips.
        mixed: whether they slide in different senses.
        ratio: of drag to push where they don't.
        x: slots of the rotor.
        slots: of x_{n-1} and x_{n+1}.
        f: gets the columns.
        c: has the forces, gets their work.
    """
    dragging, slide = rotor_columns(rotor, size, mixed, ratio, c)
    rows, columns = rotor.radial.shape
    on_normal, on_shear, slides = splat(0.0), splat(0.0), splat(slide)
    for h in range(0, columns, LANES):
        push, drag = load_row(c.columns, PUSH, h), mul(slides, load_row(c.columns, dragging, h))
        cross = mul(slides, load_row(c.columns, dragging, rotor.half + h))
        column = splat(0.0)
        for m in range(rows):
            i = m * columns + h
            weight = load_row(rotor.radial, m, h)
            normal = mul(push, weight)
            tangential, crossed = load_row(rotor.tangential, m, h), load_row(rotor.crossed, m, h)
            shear = fma(drag, tangential, mul(cross, crossed))
            moved = fma(load(rotor.body.c, i), add(normal, shear), load_row(x, slots.new, i))
            store_row(x, slots.new, i, moved)
            change = sub(moved, load_row(x, slots.old, i))
            on_normal = fma(change, normal, on_normal)
            on_shear = fma(change, shear, on_shear)
            column = fma(weight, moved, column)
        store(f.rotor, h, column)
    c.work[0] = 0.5 * total(on_normal)
    c.work[1] = 0.5 * total(on_shear)


@njit(**APART)
def correct_casing(
    casing: CasingArrays,
    size: int,
    mixed: bool,
    ratio: float,
    y: Array,
    slots: Slots,
    f: FieldScratch,
    c: ContactScratch,
) -> None:
    """The same for the casing, and the columns of w and w'; work is added to the rotor's."""
    dragging, slide = _casing_columns(casing, size, mixed, ratio, c)
    radial, tangential, half, force = casing.radial, casing.tangential, casing.half, c.columns
    rows, columns = radial.weight.shape
    on_normal, on_shear, slides = splat(0.0), splat(0.0), splat(slide)
    for h in range(0, columns, LANES):
        on_w, on_w_s = load_row(force, W_KIND, h), load_row(force, W_SLOPE, half + h)
        on_u = mul(slides, load_row(force, dragging, half + h))
        on_u_s = mul(slides, load_row(force, dragging + 1, h))
        value, slope = splat(0.0), splat(0.0)
        for m in range(rows):
            i = m * columns + h
            w, w_s = load_row(radial.weight, m, h), load_row(radial.slope_weight, m, h)
            u, u_s = load_row(tangential.weight, m, h), load_row(tangential.slope_weight, m, h)
            normal, shear = fma(on_w, w, mul(on_w_s, w_s)), fma(on_u, u, mul(on_u_s, u_s))
            moved = fma(load(casing.body.c, i), add(normal, shear), load_row(y, slots.new, i))
            store_row(y, slots.new, i, moved)
            change = sub(moved, load_row(y, slots.old, i))
            on_normal = fma(change, normal, on_normal)
            on_shear = fma(change, shear, on_shear)
            value, slope = fma(w, moved, value), fma(w_s, moved, slope)
        store(f.value, h, value)
        store(f.slope, partner_columns(h, half), slope)
    c.work[0] += 0.5 * total(on_normal)
    c.work[1] += 0.5 * total(on_shear)


@njit(**COMPILE)
def account_contact(march: MarchNumbers, state: State, c: ContactScratch) -> None:
    """Book the impulses of an accepted step with contact."""
    contacts = 0
    for j in range(len(c.multiplier)):
        state.held[j] = 0.0
        if c.multiplier[j] > 0.0:
            state.held[j] = 1.0
            contacts += 1
            pressed = c.multiplier[j] * march.time_step
            state.impulse[j] += pressed
            state.drag[j] += march.friction * c.sign[j] * pressed
            state.touched[j] += 1.0
    state.counts[STEP_CONTACTS] = contacts
    state.counts[CONTACT_STEPS] += 1
