"""Compiled contact of a step: the matrix W of the active tips and its multipliers."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit

from bladewhirl.solvers.kernel.arrays import (
    LCP_FAILURES,
    LCP_PIVOTS,
    CasingArrays,
    ContactScratch,
    FieldScratch,
    RotorArrays,
    State,
)
from bladewhirl.solvers.kernel.compilation import APART, COMPILE, Array
from bladewhirl.solvers.kernel.vectors import (
    HALF,
    LANES,
    add,
    fma,
    load_half,
    load_half_row,
    load_row,
    mul,
    plain,
    splat,
    splat_half,
    store_row,
    totals,
)

LAST_TRIAL = 1_000_000  # marks a complementarity problem solved for all tips at once
SINGULAR = 1e-11  # a pivot below this share of the diagonal calls a submatrix of W singular
MENDED_TOGETHER = 6  # trials of the active set before faults are mended one at a time


@njit(**COMPILE)
def _sense(sign: float) -> int:
    """Row of what depends on the sense of sliding: backward, none, forward."""
    return 2 if sign > 0.0 else 0 if sign < 0.0 else 1


@njit(**COMPILE)
def _take_rotor(rotor_w: Array, c: ContactScratch, size: int) -> None:
    """The rotor's part of W of the active tips; mostly it is there already from the last step."""
    tips = c.known.shape[1]
    same = c.known[0, size] < 0 if size < tips else True
    for n in range(size):
        j = c.active[n]
        same = same and c.known[0, n] == j and c.known[1, n] == _sense(c.sign[j])
    if same:
        return
    for n in range(tips):
        c.known[0, n] = -1
    for n in range(size):
        j = c.active[n]
        sense = _sense(c.sign[j])
        c.known[0, n], c.known[1, n] = j, sense
        for m in range(c.on_rotor.shape[1]):
            c.on_rotor[n, m] = rotor_w[sense * tips + j, c.active[m]] if m < size else 0.0


@njit(**COMPILE)
def _moved(compliance: Array, r: int, n0: Any, n1: Any, n2: Any, n3: Any, end: Any) -> Any:
    """Four products that sum up to the gap under one tip per multiplier of another."""
    one = mul(load_half(compliance, r), n0)
    one = fma(load_half(compliance, r + HALF), n1, one)
    two = mul(load_half(compliance, r + 2 * HALF), n2)
    two = fma(load_half(compliance, r + 3 * HALF), n3, two)
    return mul(add(one, two), end)


@njit(**COMPILE)
def _delassus(casing: CasingArrays, f: FieldScratch, c: ContactScratch, size: int) -> None:
    """W of the active tips by column: [n, m] is the gap of the m-th per multiplier of the n-th.

    The casing's part is n_i^T C (n_j + mu s t_j), four nodal values n at either end: four rows of
    four in ``compliance`` for each sense of sliding s and each pair of elements or, where only
    their distance counts (``spacing`` is one), for each distance.
    """
    block = HALF * HALF
    compliance, w, ends = casing.compliance, c.system, c.ends
    padded = -(-size // HALF) * HALF
    for m in range(padded):
        j = c.active[m] if m < size else 0
        c.rows[m] = block * casing.spacing * f.element[j]
        for k in range(HALF):
            ends[HALF * m + k] = f.hermite[k, j] if m < size else 0.0
    senses = len(compliance) // 3
    for n in range(size):
        j = c.active[n]
        first = block * (casing.nodes - f.element[j] if casing.spacing == 1 else f.element[j])
        first += senses * _sense(c.sign[j])
        n0, n1 = splat_half(f.hermite[0, j]), splat_half(f.hermite[1, j])
        n2, n3 = splat_half(f.hermite[2, j]), splat_half(f.hermite[3, j])
        for m in range(0, padded, HALF):
            e = HALF * m
            one = _moved(compliance, first + c.rows[m], n0, n1, n2, n3, load_half(ends, e))
            e += HALF
            two = _moved(compliance, first + c.rows[m + 1], n0, n1, n2, n3, load_half(ends, e))
            e += HALF
            three = _moved(compliance, first + c.rows[m + 2], n0, n1, n2, n3, load_half(ends, e))
            e += HALF
            four = _moved(compliance, first + c.rows[m + 3], n0, n1, n2, n3, load_half(ends, e))
            on_casing = totals(one, two, three, four)
            store_row(w, n, m, add(on_casing, load_half_row(c.on_rotor, n, m)))
        if padded % LANES != 0:
            store_row(w, n, padded, splat_half(0.0))
        c.diagonal[j] = w[n, n]


@njit(**COMPILE)
def _eliminate(c: ContactScratch, size: int) -> bool:
    """Solve a system given by columns, the right-hand side last; destroys it.

    By Gauss and Jordan: a column's registers are taken whole, so that the rows above the pivot
    come free and nothing is left to substitute. W is positive definite but for friction, so
    pivots stay on the diagonal; where one nearly vanishes the answer is False and the caller has
    another method.
    """
    w, largest = c.system, 0.0
    for k in range(size):
        largest = max(largest, abs(w[k, k]))
    for k in range(size):
        if not abs(w[k, k]) > SINGULAR * largest:
            return False
        c.solution[k] = 1.0 / w[k, k]
        inverse = splat(-c.solution[k])
        for i in range(0, size, LANES):
            ratio = mul(mul(load_row(w, k, i), load_row(c.others, k, i)), inverse)
            for j in range(k + 1, size + 1):
                store_row(w, j, i, fma(ratio, splat(w[j, k]), load_row(w, j, i)))
    for k in range(size):
        c.solution[k] *= w[size, k]
    return True


@njit(**COMPILE)
def _active_multipliers(
    gap: Array, held: Array, c: ContactScratch, size: int, one_by_one: bool
) -> int:
    """Multipliers that close the gaps of the active tips, negative ones let go.

    Returns:
        number of tips let go (they leave ``held``; none means done), or -1 for a singular W.
    """
    for i in range(0, size, LANES):
        store_row(c.system, size, i, splat(0.0))
    for i in range(size):
        c.system[size, i] = -gap[c.active[i]]
    if not _eliminate(c, size):
        return -1
    for j in range(len(c.multiplier)):
        c.multiplier[j] = 0.0
    released = 0
    for i in range(size):
        if c.solution[i] < 0.0:
            if released == 0 or not one_by_one:
                held[c.active[i]] = 0.0
            released += 1
        else:
            c.multiplier[c.active[i]] = c.solution[i]
    return released


@njit(**APART)
def _lemke(gap: Array, c: ContactScratch) -> bool:
    """Solve the complementarity problem by Lemke's method; singular W is no obstacle.

    The tableau holds w - M z - z0 = q, scaled, one row a basic variable. Variables are numbered
    0..n-1 for w (gaps), n..2n-1 for z (multipliers), 2n for the covering variable z0.
    """
    w, t, basis, multiplier = c.system, c.tableau, c.basis, c.multiplier
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


@njit(**APART)
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
def complementarity_residual(scale: float, f: FieldScratch, c: ContactScratch) -> float:
    """max |min(g_j, W_jj lambda_j)| / max(clearance, max |g_p|), g recomputed."""
    worst = 0.0
    for j in range(len(c.multiplier)):
        scale = max(scale, abs(f.free_gap[j]))
        if c.multiplier[j] > 0.0:
            worst = max(worst, abs(min(f.gap[j], c.diagonal[j] * c.multiplier[j])))
        else:
            worst = max(worst, -f.gap[j])
    return worst / scale if scale > 0.0 else worst


@njit(**APART)
def contact_multipliers(
    trial: int,
    rotor: RotorArrays,
    casing: CasingArrays,
    state: State,
    f: FieldScratch,
    c: ContactScratch,
) -> tuple[int, int]:
    """Multipliers of the active set; tips they would hold back are let go.

    Where W is singular, or the set goes round in circles, the problem of all tips is solved.

    Returns:
        number of this trial (LAST_TRIAL when it was all tips) and of the active tips.
    """
    tips, together, released, size = len(c.multiplier), False, 1, plain(0)
    while released > 0 or together:
        size = plain(0)
        for j in range(tips):
            if together or state.held[j] > 0.0:
                c.active[size] = j
                size += 1
        _take_rotor(rotor.w, c, size)
        _delassus(casing, f, c, size)
        if together:
            if not _lemke(f.free_gap, c):
                state.counts[LCP_FAILURES] += 1
                _gauss_seidel(f.free_gap, c.system, c.multiplier)
            return LAST_TRIAL, size
        released = _active_multipliers(f.free_gap, state.held, c, size, trial > MENDED_TOGETHER)
        trial += released > 0
        state.counts[LCP_PIVOTS] += released > 0
        together = released < 0 or (released == 0 and trial > MENDED_TOGETHER + 4 * tips)
    return trial, size


@njit(**COMPILE)
def propose_contacts(gap: Array, held: Array) -> int:
    """Let the active set be what it was and the tips that penetrate; their number.

    Tips in contact at the last step mostly stay, even if others keep them clear.
    """
    penetrating = 0
    for j in range(len(held)):
        penetrating += gap[j] < 0.0
    for j in range(len(held)):
        if penetrating == 0:
            held[j] = 0.0
        elif gap[j] < 0.0:
            held[j] = 1.0
    return penetrating


@njit(**COMPILE)
def join_contacts(gap: Array, held: Array, one_by_one: bool) -> int:
    """Add tips that a correction pushed into the casing to the active set; their number."""
    joined = 0
    for j in range(len(held)):
        if held[j] == 0.0 and gap[j] < 0.0:
            if joined == 0 or not one_by_one:
                held[j] = 1.0
            joined += 1
    return joined
