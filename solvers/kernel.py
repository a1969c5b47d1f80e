"""The compiled contact step: central differences with forward-increment Lagrange multipliers.

One module on purpose: numba does not notice a changed helper in another file when it caches (what
`lanes` offers are single instructions, which do not change).
The scheme is that of Carpenter, Taylor and Katona (1991) with damping and sliding friction:

    x_p = a x_n + b x_{n-1} + c f_n          a, b, c diagonal in modal coordinates
    0 <= lambda  perp  g_p + W lambda >= 0   W = B_N^T c (B_N + mu B_T S)
    x_{n+1} = x_p + c (B_N + mu B_T S) lambda

Springs between the bodies, and those under the shaft that stand still and differ, have a stiffness
K*(t) that turns with the rotor; they add -K*_n x_n to f_n.

Dampers at points make the damping matrix a full one, G^T G beside the diagonal. They take part in
the prediction by what it gives them, phi = -G (x_p - x_{n-1}) / (2 dt), which without contact is
the scheme itself; what a contact force changes they feel from the next step on.

Fields are evaluated in two stages so that one code serves cyclic and general stages: modal
coordinates, laid out as (rows, columns), are first summed over rows with weights, giving one
number a column, and the columns are then spread over tips or casing nodes by a shape matrix. On a
cyclic stage a column is a Fourier harmonic and both stages are small; on any other stage there is
one row, a column is a mode, and the shape matrix is dense.

`advance` takes its arrays in named tuples and makes bare addresses of them once; every other
function gets the few that it works on, because a tuple handed on costs a copy for each of its
arrays, which at this step length is more than the work itself. Slots of the state are addressed by
number for the same reason.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from bladewhirl.solvers.lanes import (
    HALF,
    LANES,
    add,
    bare,
    fma,
    load,
    load_half,
    load_half_row,
    load_row,
    mul,
    reverse,
    splat,
    splat_half,
    store,
    store_half_row,
    store_row,
    sub,
    total,
    totals,
)

Array = NDArray[Any]
FAST = {"reassoc", "contract", "nsz", "arcp"}  # NaN and infinity keep their meaning
ENTRY = {
    "cache": True, "nogil": True, "fastmath": FAST, "error_model": "numpy",
    "no_cfunc_wrapper": True,
}  # fmt: skip
# Only the entry is called from Python, so only it needs, and compiles, what unpacks arguments.
COMPILE = {k: v for k, v in ENTRY.items() if k != "cache"} | {"no_cpython_wrapper": True}

RUNNING, DIVERGED = 0, 1
W_KIND, W_SLOPE, U_KIND, U_SLOPE = 0, 1, 2, 3
PUSH, DRAG = 4, 5  # of the tips, behind the nodal forces
EXTERNAL, NORMAL, FRICTION, DAMPING, PARAMETRIC = 0, 1, 2, 3, 4
WORKS = 5
STEP_CONTACTS, LCP_FAILURES, LCP_PIVOTS, CONTACT_STEPS = 0, 1, 2, 3
CHECK_EVERY = 100  # steps between looks at displacements other than the tips' radial ones
LAST_TRIAL = 1_000_000  # marks a complementarity problem solved for all tips at once
SINGULAR = 1e-11  # a pivot below this share of the diagonal calls a submatrix of W singular
MENDED_TOGETHER = 6  # trials of the active set before faults are mended one at a time
LOAD_END, LOAD_RAMP, LOAD_FREQUENCY, LOAD_PHASE = 0, 1, 2, 3


class Body(NamedTuple):
    """Modal recurrence of one body; flat arrays of rows * columns entries, zero where padded."""

    a: Array  #: multiplies x_n
    b: Array  #: multiplies x_{n-1}
    c: Array  #: inverse of the scheme's diagonal [s2]
    stiffness: Array  #: omega^2 [rad2/s2]
    damping: Array  #: 2 xi omega [rad/s]
    load: Array  #: load patterns, (patterns, entries)
    loaded: Array  #: registers of each pattern that are not zero, then -1, (patterns, most + 1)
    damper: Array  #: G, motion of each damper times the root of its strength, (dampers, entries)
    damper_solve: Array  #: (2 dt + G c G^T)^-1, (dampers, dampers)


class KindArrays(NamedTuple):
    """One array for each kind of nodal value: w, w', u, u'."""

    w: Array
    w_slope: Array
    u: Array
    u_slope: Array


class Rotor(NamedTuple):
    """Evaluation of the blade tips, and the constant parts of W that the rotor gives."""

    radial: Array  #: weights, (rows, columns)
    tangential: Array  #: weights with the radial shape, (rows, columns)
    crossed: Array  #: weights with the tangential shape, (rows, columns)
    shape: Array  #: (columns, padded tips)
    cross_shape: Array  #: the same for the tangential direction
    spread: Array  #: shape by tip, (tips, columns)
    drag_spread: Array  #: what friction is spread with: the same, or cross_shape by tip
    half: int  #: columns from one to its partner, see `Layout`
    shared: bool  #: whether friction is spread as the normal force is
    w: Array  #: r c (r + mu s t)^T for s = -1, 0, 1, by column, (3 tips, tips)
    position: Array  #: angle of each tip in elements of the casing, (padded tips,)
    recess: Array  #: of each tip at rest, on top of the clearance, (padded tips,)


class Casing(NamedTuple):
    """Evaluation of the casing's nodal values w, w', u, u'."""

    weight: Array  #: (4, rows, columns)
    shape: KindArrays  #: (columns, padded nodes) each
    fold: Array  #: shape on a quarter of the circle, see `_folded_fields`; without rows if unused
    spread: KindArrays  #: shape by node, (nodes, columns) each
    half: int  #: columns from one to its partner, see `Layout`
    shared: bool  #: whether all kinds have one shape
    compliance: Array  #: blocks of 4 x 4 for s = -1, 0, 1, see `_delassus`, flat
    spacing: int  #: blocks from one element to the next
    clearance: Array  #: nodal clearance and its slope, node 0 again, (2, padded nodes)
    no_clearance: Array  #: zeros of the same shape
    nodes: int
    element_length: float  #: [m]


class Springs(NamedTuple):
    """Springs between the bodies, by nodal diameter (harmonic); without any, arrays are empty.

    A wave is the cosine or sine part of a body's radial displacement in one harmonic. Springs under
    the shaft are a harmonic of their own, with one nodal diameter and no mode of the casing.
    """

    nodal_diameter: Array  #: of each harmonic, (harmonics,)
    factor: Array  #: stiffness f_k kappa of each wave [N/m], (waves,)
    rotor_place: Array  #: coupled modes among the flat entries of the rotor, (modes,)
    rotor_wave: Array  #: wave of each: twice its harmonic, and one more for a sine
    rotor_amplitude: Array  #: of each at the springs [kg^-1/2]
    casing_place: Array
    casing_wave: Array
    casing_amplitude: Array
    angle_per_step: float  #: turn of the rotor a step [rad]


class March(NamedTuple):
    """Scalars of a march."""

    time_step: float  #: [s]
    elements_per_step: float  #: turn of the rotor a step, in casing elements
    friction: float
    signed: bool  #: whether the direction of sliding follows the relative velocity
    sliding: float  #: sign of permanent sliding
    wheel_speed: float  #: R Omega [m/s], for the true sign
    elements_per_metre: float  #: tip rotation: casing elements a metre of u_t; 0 when neglected
    displacement_limit: float  #: of a tip, or of the casing radially [m]
    gap_scale: float  #: smallest scale of the complementarity residual [m]
    loads: Array  #: end, ramp, frequency, phase of each pattern, (patterns, 4)


class State(NamedTuple):
    """Everything a march needs to go on; arrays are advanced in place."""

    rotor: Array  #: x_{n-1}, x_n and scratch, (3, entries)
    casing: Array  #: the same for the casing
    gap: Array  #: smallest gap of each tip since the last record [m], (tips,)
    impulse: Array  #: normal impulse since the last record [N s], (tips,)
    drag: Array  #: friction impulse since the last record [N s], (tips,)
    touched: Array  #: steps with contact since the last record, (tips,)
    held: Array  #: 1 for tips in contact at the last step, (tips,)
    work: Array  #: external, normal, friction work, damping loss, parametric work [J], (WORKS,)
    residual: Array  #: largest complementarity residual, (1,)
    counts: Array  #: contacts at the last step, LCP failures, LCP pivots, steps with contact, (4,)


class Records(NamedTuple):
    """Rows written at record steps."""

    step: Array  #: (records,)
    rotor: Array  #: (records, 2, entries): displacement, velocity
    casing: Array
    gap: Array  #: (records, tips)
    impulse: Array
    drag: Array
    touched: Array
    contacts: Array  #: (records,)
    energy: Array  #: half-step energy [J], (records,)
    work: Array  #: (records, WORKS)


class Scratch(NamedTuple):
    """Working arrays of one march."""

    columns: Array  #: sums by column, see `advance`, (4, columns)
    forces: Array  #: contact forces by column: rotor normal, friction, casing w, w', u, u'
    nodal: Array  #: values and slopes of a nodal field, (2, padded nodes)
    tip: Array  #: radial, tangential, scratch, place in elements, (4, padded tips)
    gap: Array  #: free gap, gap after the correction [m], (2, padded tips)
    hermite: Array  #: weights of each tip on its element: w, w', w, w', (4, padded tips)
    element: Array  #: element under each tip, (tips,)
    difference: Array  #: displacement over a step, rotor and casing, (2, entries)
    load: Array  #: amplitude of each load pattern, (patterns,)
    rows: Array  #: rows that a product takes, (2 tips,)
    factor: Array  #: and with what factors, (6, 2 tips)
    active: Array  #: tips of the active set, (tips,)
    known: Array  #: tips and senses that ``on_rotor`` stands for, (2, tips)
    on_rotor: Array  #: the rotor's part of W of the active tips, by column, (tips, padded tips)
    ends: Array  #: Hermite weights by active tip, (4 padded tips,)
    solve: Array  #: W by column, then a right-hand side, (tips + 1, padded tips)
    others: Array  #: 1 off the diagonal, 0 on it, (tips, padded tips)
    diagonal: Array  #: W_jj of the active tips, (tips,)
    solution: Array  #: (tips,)
    multiplier: Array  #: [N], (tips,)
    sign: Array  #: direction of sliding, (tips,)
    work: Array  #: of the contact forces over this step [J], (2,)
    tableau: Array  #: of Lemke's method, (tips, 2 tips + 2)
    basis: Array  #: of Lemke's method, (tips,)
    rotor_waves: Array  #: at the last step and at this, (2, waves)
    casing_waves: Array
    stretch: Array  #: of the springs, by angle and displacement as in `_stretches`, (4, waves)
    spring_force: Array  #: on the waves of rotor and casing, (2, waves)
    stroke: Array  #: of each damper over two steps, (most dampers,)
    damper_force: Array  #: phi on rotor and casing, (2, most dampers)


@njit(**COMPILE)
def _predict(a: Array, b: Array, slots: Array, old: int, now: int, new: int) -> None:
    for i in range(0, len(a), LANES):
        x = fma(load(a, i), load_row(slots, now, i), mul(load(b, i), load_row(slots, old, i)))
        store_row(slots, new, i, x)


@njit(**COMPILE)
def _turned(h: int, half: int) -> int:
    """Place of a register's partner columns."""
    return h + half if h < half else h - half


@njit(**COMPILE)
def _column_sums(weight: Array, slots: Array, slot: int, half: int, out: Array) -> None:
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
        store(out, _turned(h, half), add(even, odd))


@njit(**COMPILE)
def _combine(rows: Array, factor: Array, out: Array) -> None:
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
    """`_nodal_fields` of an even number of nodes, four nodes at a time.

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
        _unfold(ce, co, se, so, i, middle, start, 0, value)
        _unfold(de, do, te, to, i, middle, start, 1, slope)


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
def _nodal_fields(
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
    _combine(value_shape, values, value)
    _combine(slope_shape, slopes, slope)
    value[nodes], slope[nodes] = value[0], slope[0]
    for i in range(0, start.shape[1], LANES):
        store(value, i, add(load(value, i), load_row(start, 0, i)))
        store(slope, i, add(load(slope, i), load_row(start, 1, i)))


@njit(**COMPILE)
def _load_factors(loads: Array, time: float, out: Array) -> bool:
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
def _add_load(
    pattern: Array, loaded: Array, factors: Array, c: Array, slots: Array, new: int
) -> None:
    for p in range(len(factors)):
        factor = splat(factors[p])
        for k in range(loaded.shape[1]):
            i = loaded[p, k]
            if i < 0:
                break
            force = mul(factor, load_row(pattern, p, i))
            store_row(slots, new, i, fma(force, load(c, i), load_row(slots, new, i)))


@njit(**COMPILE)
def _waves(
    place: Array, wave: Array, amplitude: Array, slots: Array, slot: int, out: Array, row: int
) -> None:
    """Waves of one body's radial displacement at the springs."""
    for i in range(out.shape[1]):
        out[row, i] = 0.0
    for i in range(len(place)):
        out[row, wave[i]] += amplitude[i] * slots[slot, place[i]]


@njit(**COMPILE)
def _stretches(
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
def _spring_energy(factor: Array, stretch: Array, first: int) -> float:
    """x_{n-1}^T K* x_n / 2 from the stretches of both displacements at one angle."""
    energy = 0.0
    for i in range(len(factor)):
        energy += factor[i] * stretch[first, i] * stretch[first + 1, i]
    return 0.5 * energy


@njit(**COMPILE)
def _spring_forces(
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
def _add_springs(
    place: Array, wave: Array, amplitude: Array, force: Array, row: int, c: Array, slots: Array,
    new: int,
) -> None:  # fmt: skip
    for i in range(len(place)):
        at = place[i]
        slots[new, at] += c[at] * amplitude[i] * force[row, wave[i]]


@njit(**COMPILE)
def _external_work(
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
def _damping_loss(damping: Array, slots: Array, old: int, new: int) -> float:
    """d^T D d with d = (x_{n+1} - x_{n-1}) / 2."""
    loss = splat(0.0)
    for i in range(0, len(damping), LANES):
        moved = sub(load_row(slots, new, i), load_row(slots, old, i))
        loss = fma(mul(load(damping, i), moved), moved, loss)
    return 0.25 * float(total(loss))


@njit(**COMPILE)
def _damp(
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
def _damper_loss(
    damper: Array, slots: Array, old: int, new: int, stroke: Array, force: Array, row: int
) -> float:
    """-d^T G^T phi with d = (x_{n+1} - x_{n-1}) / 2."""
    _strokes(damper, slots, old, new, stroke)
    loss = 0.0
    for m in range(len(damper)):
        loss -= 0.5 * force[row, m] * stroke[m]
    return loss


@njit(**COMPILE)
def _half_step_energy(
    stiffness: Array, slots: Array, old: int, now: int, time_step: float
) -> float:
    """E_{n-1/2} = v^T v / 2 + x_{n-1}^T K x_n / 2 with v = (x_n - x_{n-1}) / dt."""
    energy = 0.0
    for i in range(len(stiffness)):
        v = (slots[now, i] - slots[old, i]) / time_step
        energy += v * v + stiffness[i] * slots[now, i] * slots[old, i]
    return 0.5 * energy


@njit(**COMPILE)
def _place_tips(
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
def _close_gaps(
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
def _sense(sign: float) -> int:
    """Row of what depends on the sense of sliding: backward, none, forward."""
    return 2 if sign > 0.0 else 0 if sign < 0.0 else 1


@njit(**COMPILE)
def _take_rotor(
    active: Array, size: int, rotor_w: Array, sign: Array, known: Array, on_rotor: Array
) -> None:
    """The rotor's part of W of the active tips; mostly it is there already from the last step."""
    tips = known.shape[1]
    same = known[0, size] < 0 if size < tips else True
    for n in range(size):
        j = active[n]
        same = same and known[0, n] == j and known[1, n] == _sense(sign[j])
    if same:
        return
    for n in range(tips):
        known[0, n] = -1
    for n in range(size):
        j = active[n]
        sense = _sense(sign[j])
        known[0, n], known[1, n] = j, sense
        for m in range(on_rotor.shape[1]):
            on_rotor[n, m] = rotor_w[sense * tips + j, active[m]] if m < size else 0.0


@njit(**COMPILE)
def _moved(compliance: Array, r: int, n0: Any, n1: Any, n2: Any, n3: Any, end: Any) -> Any:
    """Four products that sum up to the gap under one tip per multiplier of another."""
    one = mul(load_half(compliance, r), n0)
    one = fma(load_half(compliance, r + HALF), n1, one)
    two = mul(load_half(compliance, r + 2 * HALF), n2)
    two = fma(load_half(compliance, r + 3 * HALF), n3, two)
    return mul(add(one, two), end)


@njit(**COMPILE)
def _delassus(
    active: Array,
    size: int,
    compliance: Array,
    spacing: int,
    on_rotor: Array,
    sign: Array,
    nodes: int,
    hermite: Array,
    element: Array,
    ends: Array,
    under: Array,
    w: Array,
    diagonal: Array,
) -> None:
    """W of the active tips by column: w[n, m] is the gap of the m-th per multiplier of the n-th.

    The casing's part is n_i^T C (n_j + mu s t_j), four nodal values n at either end: four rows of
    four in ``compliance`` for each sense of sliding s and each pair of elements or, where only
    their distance counts (``spacing`` is one), for each distance.
    """
    block = HALF * HALF
    padded = -(-size // HALF) * HALF
    for m in range(padded):
        j = active[m] if m < size else 0
        under[m] = block * spacing * element[j]
        for k in range(HALF):
            ends[HALF * m + k] = hermite[k, j] if m < size else 0.0
    senses = len(compliance) // 3
    for n in range(size):
        j = active[n]
        first = block * (nodes - element[j] if spacing == 1 else element[j])
        first += senses * _sense(sign[j])
        n0, n1 = splat_half(hermite[0, j]), splat_half(hermite[1, j])
        n2, n3 = splat_half(hermite[2, j]), splat_half(hermite[3, j])
        for m in range(0, padded, HALF):
            e = HALF * m
            a = _moved(compliance, first + under[m], n0, n1, n2, n3, load_half(ends, e))
            e += HALF
            b = _moved(compliance, first + under[m + 1], n0, n1, n2, n3, load_half(ends, e))
            e += HALF
            c = _moved(compliance, first + under[m + 2], n0, n1, n2, n3, load_half(ends, e))
            e += HALF
            d = _moved(compliance, first + under[m + 3], n0, n1, n2, n3, load_half(ends, e))
            store_half_row(w, n, m, add(totals(a, b, c, d), load_half_row(on_rotor, n, m)))
        if padded % LANES != 0:
            store_half_row(w, n, padded, splat_half(0.0))
        diagonal[j] = w[n, n]


@njit(**COMPILE)
def _eliminate(size: int, w: Array, others: Array, solution: Array) -> bool:
    """Solve a system given by columns, the right-hand side last; destroys them.

    By Gauss and Jordan: a column's registers are taken whole, so that the rows above the pivot
    come free and nothing is left to substitute. W is positive definite but for friction, so
    pivots stay on the diagonal; where one nearly vanishes the answer is False and the caller has
    another method.
    """
    largest = 0.0
    for k in range(size):
        largest = max(largest, abs(w[k, k]))
    for k in range(size):
        if not abs(w[k, k]) > SINGULAR * largest:
            return False
        solution[k] = 1.0 / w[k, k]
        inverse = splat(-solution[k])
        for i in range(0, size, LANES):
            ratio = mul(mul(load_row(w, k, i), load_row(others, k, i)), inverse)
            for j in range(k + 1, size + 1):
                store_row(w, j, i, fma(ratio, splat(w[j, k]), load_row(w, j, i)))
    for k in range(size):
        solution[k] *= w[size, k]
    return True


@njit(**COMPILE)
def _active_multipliers(
    gap: Array,
    size: int,
    active: Array,
    held: Array,
    w: Array,
    others: Array,
    solution: Array,
    multiplier: Array,
    one_by_one: bool,
) -> int:
    """Multipliers that close the gaps of the active tips, negative ones let go.

    ``w`` holds W of the active tips by column and is destroyed.

    Returns:
        number of tips let go (they leave ``held``; none means done), or -1 for a singular W.
    """
    for i in range(0, size, LANES):
        store_row(w, size, i, splat(0.0))
    for i in range(size):
        w[size, i] = -gap[active[i]]
    if not _eliminate(size, w, others, solution):
        return -1
    for j in range(len(multiplier)):
        multiplier[j] = 0.0
    released = 0
    for i in range(size):
        if solution[i] < 0.0:
            if released == 0 or not one_by_one:
                held[active[i]] = 0.0
            released += 1
        else:
            multiplier[active[i]] = solution[i]
    return released


@njit(**COMPILE)
def _lemke(gap: Array, w: Array, t: Array, basis: Array, multiplier: Array) -> bool:
    """Solve the complementarity problem by Lemke's method; singular W is no obstacle.

    The tableau holds w - M z - z0 = q, scaled, one row a basic variable. Variables are numbered
    0..n-1 for w (gaps), n..2n-1 for z (multipliers), 2n for the covering variable z0.
    """
    tips = len(multiplier)
    cover = 2 * tips
    gap_scale, w_scale = 0.0, 0.0
    for i in range(tips):
        gap_scale = max(gap_scale, abs(gap[i]))
        w_scale = max(w_scale, abs(w[i, i]))
    row = 0
    for i in range(tips):
        multiplier[i] = 0.0
        for j in range(tips):
            t[i, j] = 1.0 if i == j else 0.0
            t[i, tips + j] = -w[j, i] / w_scale
        t[i, cover], t[i, cover + 1] = -1.0, gap[i] / gap_scale
        basis[i] = i
        if gap[i] < gap[row]:
            row = i
    entering = cover
    for _ in range(50 * tips):
        leaving = int(basis[row])
        pivot = t[row, entering]
        for j in range(cover + 2):
            t[row, j] /= pivot
        for i in range(tips):
            if i != row and t[i, entering] != 0.0:
                ratio = t[i, entering]
                for j in range(cover + 2):
                    t[i, j] -= ratio * t[row, j]
        basis[row] = entering
        if leaving == cover:
            for i in range(tips):
                if tips <= basis[i] < cover:
                    value = t[i, cover + 1] * gap_scale / w_scale
                    multiplier[int(basis[i]) - tips] = max(0.0, value)
            return True
        entering = leaving + tips if leaving < tips else leaving - tips
        row, best = -1, np.inf
        for i in range(tips):
            if t[i, entering] > 1e-10:
                ratio = t[i, cover + 1] / t[i, entering]
                tied = row >= 0 and abs(ratio - best) <= 1e-14 * (1.0 + abs(best))
                if (tied and basis[i] == cover) or (not tied and ratio < best):
                    row, best = i, ratio
        if row < 0:
            return False
    return False


@njit(**COMPILE)
def _gauss_seidel(gap: Array, w: Array, multiplier: Array) -> None:
    """Projected Gauss-Seidel from the multipliers at hand, for what Lemke's method gave up."""
    tips = len(multiplier)
    for _ in range(2000):
        change, largest = 0.0, 0.0
        for i in range(tips):
            closing = gap[i]
            for j in range(tips):
                closing += w[j, i] * multiplier[j]
            value = max(0.0, multiplier[i] - closing / w[i, i])
            change = max(change, abs(value - multiplier[i]))
            largest = max(largest, value)
            multiplier[i] = value
        if change <= 1e-14 * largest:
            return


@njit(**COMPILE)
def _tip_forces(
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
def _correct_rotor(
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
def _correct_casing(
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
        store(slopes, _turned(h, half), slope)
    work[0] += 0.5 * total(on_normal)
    work[1] += 0.5 * total(on_shear)


@njit(**COMPILE)
def _residual(
    scale: float, free_gap: Array, gap: Array, diagonal: Array, multiplier: Array
) -> float:
    """max |min(g_j, W_jj lambda_j)| / max(clearance, max |g_p|), g recomputed."""
    worst = 0.0
    for j in range(len(multiplier)):
        scale = max(scale, abs(free_gap[j]))
        if multiplier[j] > 0.0:
            worst = max(worst, abs(min(gap[j], diagonal[j] * multiplier[j])))
        else:
            worst = max(worst, -gap[j])
    return worst / scale if scale > 0.0 else worst


@njit(**COMPILE)
def _account_contact(
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


@njit(**COMPILE)
def _tip_tangential(
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
    _column_sums(tangential, slots, slot, 0, columns)
    _combine(shape, columns, out)
    _column_sums(crossed, slots, slot, 0, columns)
    _combine(cross_shape, columns, scratch)
    for j in range(0, len(out), LANES):
        store(out, j, add(load(out, j), load(scratch, j)))


@njit(**COMPILE)
def _difference(slots: Array, later: int, earlier: int, out: Array, row: int) -> None:
    for i in range(0, slots.shape[1], LANES):
        store_row(out, row, i, sub(load_row(slots, later, i), load_row(slots, earlier, i)))


@njit(**COMPILE)
def _casing_tangential(
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
    _column_sums(weight, slots, slot, half, values)
    _column_sums(slope_weight, slots, slot, 0, slopes)
    _nodal_fields(fold, shape, slope_shape, values, slopes, half, nodes, start, value, slope)
    _on_tips(value, slope, hermite, element, out)


@njit(**COMPILE)
def _sliding_signs(
    blade: Array, casing: Array, wheel_speed: float, time_step: float, sign: Array
) -> None:
    """Direction of sliding at each tip, from the tangential displacements over the last step."""
    for j in range(len(sign)):
        sign[j] = np.sign(wheel_speed + (blade[j] - casing[j]) / time_step)


@njit(**COMPILE)
def _copy(source: Array, target: Array, row: int) -> None:
    for i in range(len(source)):
        target[row, i] = source[i]


@njit(**COMPILE)
def _record_position(slots: Array, now: int, target: Array, row: int) -> None:
    for i in range(slots.shape[1]):
        target[row, 0, i] = slots[now, i]


@njit(**COMPILE)
def _record_velocity(
    slots: Array, later: int, earlier: int, interval: float, target: Array, row: int
) -> None:
    for i in range(slots.shape[1]):
        target[row, 1, i] = (slots[later, i] - slots[earlier, i]) / interval


@njit(**COMPILE)
def _settle(slots: Array, old: int, now: int, new: int) -> None:
    """Put x_{n-1} and x_n back into slots 0 and 1."""
    for i in range(slots.shape[1]):
        before, current, scratch = slots[old, i], slots[now, i], slots[new, i]
        slots[0, i], slots[1, i], slots[2, i] = before, current, scratch


@njit(**ENTRY)
def advance(
    rotor: Rotor,
    casing: Casing,
    rotor_body: Body,
    casing_body: Body,
    springs: Springs,
    march: March,
    state: State,
    records: Records,
    s: Scratch,
    step: int,
    steps: int,
    record_every: int,
) -> tuple[int, int, int]:
    """March from ``step`` to ``step + steps``, recording at multiples of ``record_every``.

    A record at step n is written once x_{n+1} is known, its velocity being
    (x_{n+1} - x_{n-1}) / (2 dt). Before the first step, slot 0 of the state holds x_{n-1} and
    slot 1 x_n; the same holds on return.

    Returns:
        status (RUNNING or DIVERGED), the step reached, and the number of records written. On
        divergence the last state within the displacement limit is recorded, its velocity a
        backward difference.
    """
    dt, friction, limit = march.time_step, march.friction, march.displacement_limit
    per_step, per_metre = march.elements_per_step, march.elements_per_metre
    signed, wheel_speed, gap_scale = march.signed, march.wheel_speed, march.gap_scale
    spacing, nodes, length = casing.spacing, casing.nodes, casing.element_length
    loads, factors = bare(march.loads), bare(s.load)
    xs, ys = bare(state.rotor), bare(state.casing)
    ra, rb, rc = bare(rotor_body.a), bare(rotor_body.b), bare(rotor_body.c)
    ca, cb, cc = bare(casing_body.a), bare(casing_body.b), bare(casing_body.c)
    r_load, c_load = bare(rotor_body.load), bare(casing_body.load)
    r_loaded, c_loaded = bare(rotor_body.loaded), bare(casing_body.loaded)
    r_damping, c_damping = bare(rotor_body.damping), bare(casing_body.damping)
    r_stiffness, c_stiffness = bare(rotor_body.stiffness), bare(casing_body.stiffness)
    radial, tangential = bare(rotor.radial), bare(rotor.tangential)
    crossed, position, recess = bare(rotor.crossed), bare(rotor.position), bare(rotor.recess)
    shape, cross_shape = bare(rotor.shape), bare(rotor.cross_shape)
    spread, drag_spread = bare(rotor.spread), bare(rotor.drag_spread)
    rotor_w, r_half, r_shared = bare(rotor.w), rotor.half, rotor.shared
    w_weight, w_s_weight = bare(casing.weight[W_KIND]), bare(casing.weight[W_SLOPE])
    u_weight, u_s_weight = bare(casing.weight[U_KIND]), bare(casing.weight[U_SLOPE])
    w_shape, w_s_shape = bare(casing.shape.w), bare(casing.shape.w_slope)
    u_shape, u_s_shape = bare(casing.shape.u), bare(casing.shape.u_slope)
    w_spread, w_s_spread = bare(casing.spread.w), bare(casing.spread.w_slope)
    u_spread, u_s_spread = bare(casing.spread.u), bare(casing.spread.u_slope)
    fold, c_half, shared = bare(casing.fold), casing.half, casing.shared
    compliance, clearance = bare(casing.compliance), bare(casing.clearance)
    no_clearance = bare(casing.no_clearance)
    column, values, slopes = bare(s.columns[0]), bare(s.columns[1]), bare(s.columns[2])
    forces, factor = bare(s.forces), bare(s.factor)
    w, w_s = bare(s.nodal[0]), bare(s.nodal[1])
    free_gap, gap = bare(s.gap[0]), bare(s.gap[1])
    u_r, u_t, tip_scratch, at = bare(s.tip[0]), bare(s.tip[1]), bare(s.tip[2]), bare(s.tip[3])
    hermite, element, moved = bare(s.hermite), bare(s.element), bare(s.difference)
    sign, multiplier, diagonal = bare(s.sign), bare(s.multiplier), bare(s.diagonal)
    held, active, ends = bare(state.held), bare(s.active), bare(s.ends)
    known, on_rotor, others = bare(s.known), bare(s.on_rotor), bare(s.others)
    solve, solution, tableau = bare(s.solve), bare(s.solution), bare(s.tableau)
    basis, index, step_work = bare(s.basis), bare(s.rows), bare(s.work)
    work, count, residual = bare(state.work), bare(state.counts), bare(state.residual)
    smallest, impulse = bare(state.gap), bare(state.impulse)
    drag, touched = bare(state.drag), bare(state.touched)
    diameter, spring = bare(springs.nodal_diameter), bare(springs.factor)
    r_place, c_place = bare(springs.rotor_place), bare(springs.casing_place)
    r_wave, c_wave = bare(springs.rotor_wave), bare(springs.casing_wave)
    r_amplitude, c_amplitude = bare(springs.rotor_amplitude), bare(springs.casing_amplitude)
    r_waves, c_waves = bare(s.rotor_waves), bare(s.casing_waves)
    stretch, pull, turn = bare(s.stretch), bare(s.spring_force), springs.angle_per_step
    r_damper, r_solve = bare(rotor_body.damper), bare(rotor_body.damper_solve)
    c_damper, c_solve = bare(casing_body.damper), bare(casing_body.damper_solve)
    stroke, damper_force = bare(s.stroke), bare(s.damper_force)
    rec_step, rec_energy, rec_work = records.step, records.energy, records.work
    rec_gap, rec_impulse, rec_drag = records.gap, records.impulse, records.drag
    rec_touched, rec_contacts = records.touched, records.contacts
    rec_rotor, rec_casing = records.rotor, records.casing

    for j in range(len(sign)):
        sign[j], known[0, j] = march.sliding, -1
    # As plain literals these would have every function that takes them compiled twice.
    zero, one, two = int(np.int64(0)), int(np.int64(1)), int(np.int64(2))
    tips, written, status = len(element), zero, RUNNING
    old, now, new = zero, one, two
    end, coupled = step + steps, len(spring) > 0
    earlier, later_waves, spring_energy, parametric = zero, one, 0.0, 0.0
    if coupled:
        _waves(r_place, r_wave, r_amplitude, xs, old, r_waves, earlier)
        _waves(c_place, c_wave, c_amplitude, ys, old, c_waves, earlier)
    while step < end:
        recording = step % record_every == 0
        loaded = _load_factors(loads, step * dt, factors)
        if coupled:
            angle, last_angle = turn * step, turn * (step - 1)
            _waves(r_place, r_wave, r_amplitude, xs, now, r_waves, later_waves)
            _waves(c_place, c_wave, c_amplitude, ys, now, c_waves, later_waves)
            _stretches(diameter, angle, last_angle, r_waves, c_waves, earlier, later_waves, stretch)
            spring_energy = _spring_energy(spring, stretch, zero)
            parametric = _spring_energy(spring, stretch, two) - spring_energy
            _spring_forces(diameter, spring, angle, stretch, pull)
            earlier, later_waves = later_waves, earlier
        contacts = count[STEP_CONTACTS]
        count[STEP_CONTACTS] = 0
        trial, size, penetrating, within = zero, zero, zero, True
        while True:
            if trial != 1:
                # Predict without contact.
                _predict(ra, rb, xs, old, now, new)
                _predict(ca, cb, ys, old, now, new)
                if loaded:
                    _add_load(r_load, r_loaded, factors, rc, xs, new)
                    _add_load(c_load, c_loaded, factors, cc, ys, new)
                if coupled:
                    _add_springs(r_place, r_wave, r_amplitude, pull, zero, rc, xs, new)
                    _add_springs(c_place, c_wave, c_amplitude, pull, one, cc, ys, new)
                if len(r_damper) > 0:
                    _damp(r_damper, r_solve, rc, xs, old, new, stroke, damper_force, zero)
                if len(c_damper) > 0:
                    _damp(c_damper, c_solve, cc, ys, old, new, stroke, damper_force, one)

            if trial == 0:
                # Where the tips stand at the end of the step.
                for j in range(0, len(at), LANES):
                    store(at, j, load(position, j))
                if per_metre != 0.0:
                    _tip_tangential(
                        tangential, crossed, shape, cross_shape, xs, new, column, u_t, tip_scratch
                    )
                    for j in range(tips):
                        at[j] += per_metre * u_t[j]
                _place_tips(at, per_step * (step + 1), nodes, length, hermite, element)
                _column_sums(radial, xs, new, zero, column)
                _column_sums(w_weight, ys, new, zero, values)
                _column_sums(w_s_weight, ys, new, c_half, slopes)
            else:
                # Multipliers of the active set; tips they would hold back are let go.
                released = 1
                while released > 0:
                    size = zero
                    for j in range(tips):
                        if held[j] > 0.0:
                            active[size] = j
                            size += 1
                    _take_rotor(active, size, rotor_w, sign, known, on_rotor)
                    _delassus(
                        active, size, compliance, spacing, on_rotor, sign, nodes, hermite,
                        element, ends, index, solve, diagonal,
                    )  # fmt: skip
                    released = _active_multipliers(
                        free_gap, size, active, held, solve, others, solution, multiplier,
                        trial > MENDED_TOGETHER,
                    )  # fmt: skip
                    trial += released > 0
                    count[LCP_PIVOTS] += released > 0
                if released < 0 or trial > MENDED_TOGETHER + 4 * tips:
                    # Singular, or going round in circles: all tips at once.
                    trial = LAST_TRIAL
                    for j in range(tips):
                        active[j] = j
                    size = tips
                    _take_rotor(active, size, rotor_w, sign, known, on_rotor)
                    _delassus(
                        active, size, compliance, spacing, on_rotor, sign, nodes, hermite,
                        element, ends, index, solve, diagonal,
                    )  # fmt: skip
                    if not _lemke(free_gap, solve, tableau, basis, multiplier):
                        count[LCP_FAILURES] += 1
                        _gauss_seidel(free_gap, solve, multiplier)
                # Correct.
                mixed, ratio = _tip_forces(
                    active, size, multiplier, sign, friction, nodes, hermite, element, index, factor
                )
                _spread(spread, active, factor, PUSH, size, r_half, forces)
                dragging, slides = PUSH, ratio
                if mixed or not r_shared:
                    dragging, slides = DRAG, 1.0
                    _spread(drag_spread, active, factor, DRAG, size, r_half, forces)
                _correct_rotor(
                    rc, forces, dragging, slides, r_half, radial, tangential, crossed, xs, old,
                    new, step_work, column,
                )  # fmt: skip
                dragging, slides = W_KIND, ratio
                if shared:
                    _spread_two(w_spread, index, factor, W_KIND, 2 * size, c_half, forces)
                    if mixed:
                        dragging, slides = U_KIND, 1.0
                        _spread_two(u_spread, index, factor, U_KIND, 2 * size, c_half, forces)
                else:
                    dragging, slides = U_KIND, 1.0
                    _spread(w_spread, index, factor, W_KIND, 2 * size, c_half, forces)
                    _spread(w_s_spread, index, factor, W_SLOPE, 2 * size, c_half, forces)
                    _spread(u_spread, index, factor, U_KIND, 2 * size, c_half, forces)
                    _spread(u_s_spread, index, factor, U_SLOPE, 2 * size, c_half, forces)
                _correct_casing(
                    cc, forces, dragging, slides, c_half, w_weight, w_s_weight, u_weight,
                    u_s_weight, ys, old, new, step_work, values, slopes,
                )  # fmt: skip

            _combine(shape, column, u_r)
            _nodal_fields(
                fold, w_shape, w_s_shape, values, slopes, c_half, nodes, clearance, w, w_s
            )
            found = free_gap if trial == 0 else gap
            within = _close_gaps(w, w_s, hermite, element, u_r, recess, limit, found)
            if trial == 0:
                for j in range(tips):
                    penetrating += free_gap[j] < 0.0
                if penetrating == 0:
                    for j in range(tips):
                        held[j] = 0.0
                    break
                # Tips in contact at the last step mostly stay, also where others keep them clear.
                for j in range(tips):
                    if free_gap[j] < 0.0:
                        held[j] = 1.0
                if signed:
                    _difference(xs, now, old, moved, zero)
                    _difference(ys, now, old, moved, one)
                    _tip_tangential(
                        tangential, crossed, shape, cross_shape, moved, zero, column, u_t,
                        tip_scratch,
                    )  # fmt: skip
                    _casing_tangential(
                        u_weight, u_s_weight, fold, u_shape, u_s_shape, c_half, moved, one,
                        values, slopes, nodes, no_clearance, w, w_s, hermite, element, tip_scratch,
                    )  # fmt: skip
                    _sliding_signs(u_t, tip_scratch, wheel_speed, dt, sign)
            else:
                if trial >= LAST_TRIAL or not within:
                    break
                # Tips that the correction pushed into the casing join the set.
                joined = 0
                for j in range(tips):
                    if held[j] == 0.0 and gap[j] < 0.0:
                        if joined == 0 or trial <= MENDED_TOGETHER:
                            held[j] = 1.0
                        joined += 1
                if joined == 0:
                    break
                count[LCP_PIVOTS] += 1
            trial += 1

        if within and (step + 1) % CHECK_EVERY == 0:
            _tip_tangential(
                tangential, crossed, shape, cross_shape, xs, new, column, u_t, tip_scratch
            )
            for j in range(tips):
                within = within and abs(u_t[j]) <= limit
            for i in range(nodes):
                within = within and abs(w[i] - clearance[0, i]) <= limit

        if recording or not within:
            # What is known at step n, before x_{n+1}; what counts between records starts anew.
            rec_step[written] = step
            rec_energy[written] = (
                _half_step_energy(r_stiffness, xs, old, now, dt)
                + _half_step_energy(c_stiffness, ys, old, now, dt)
                + spring_energy
            )
            _copy(work, rec_work, written)
            _copy(smallest, rec_gap, written)
            _copy(impulse, rec_impulse, written)
            _copy(drag, rec_drag, written)
            _copy(touched, rec_touched, written)
            rec_contacts[written] = contacts
            _record_position(xs, now, rec_rotor, written)
            _record_position(ys, now, rec_casing, written)
            later, interval = (new, 2.0 * dt) if within else (now, dt)
            _record_velocity(xs, later, old, interval, rec_rotor, written)
            _record_velocity(ys, later, old, interval, rec_casing, written)
            written += 1
            for j in range(tips):
                smallest[j], impulse[j], drag[j], touched[j] = np.inf, 0.0, 0.0, 0.0
        if not within:
            status = DIVERGED
            break

        # Accept the step.
        if penetrating > 0:
            worst = _residual(gap_scale, free_gap, gap, diagonal, multiplier)
            residual[0] = max(residual[0], worst)
            work[NORMAL] += step_work[0]
            work[FRICTION] += step_work[1]
            _account_contact(multiplier, sign, friction, dt, impulse, drag, touched, held, count)
            for j in range(tips):
                smallest[j] = min(smallest[j], gap[j])
        else:
            for j in range(tips):
                smallest[j] = min(smallest[j], free_gap[j])
        if loaded:
            work[EXTERNAL] += _external_work(r_load, r_loaded, factors, xs, old, new)
            work[EXTERNAL] += _external_work(c_load, c_loaded, factors, ys, old, new)
        work[DAMPING] += (
            _damping_loss(r_damping, xs, old, new) + _damping_loss(c_damping, ys, old, new)
        ) / dt
        work[PARAMETRIC] += parametric
        if len(r_damper) > 0:
            work[DAMPING] += _damper_loss(r_damper, xs, old, new, stroke, damper_force, zero)
        if len(c_damper) > 0:
            work[DAMPING] += _damper_loss(c_damper, ys, old, new, stroke, damper_force, one)
        old, now, new = now, new, old
        step += 1
    _settle(xs, old, now, new)
    _settle(ys, old, now, new)
    return status, step, written
