"""Eight speeds marched together, one a lane of a register, as far as runs have a step in common.

That is a step without contact: recurrence, sums by column, fields, gaps. What contact adds is each
run's own, since at each speed other tips touch. The stage is the kernel's cyclic arrangement.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.solvers.kernel.vectors import (
    LANES,
    add,
    bare,
    fma,
    load_row,
    mul,
    splat,
    store_row,
    sub,
)
from bladewhirl.solvers.march.packing import (
    aligned,
    pack_body,
    pack_casing,
    pack_rotor,
    scheme_inverse,
)

# mypy: disable-error-code="no-untyped-def, untyped-decorator"


@njit(fastmath=True, error_model="numpy")
def _predict(a, b, slots, old, now, new, entries):
    for i in range(entries):
        x = mul(load_row(slots, old * entries + i, 0), splat(b[i]))
        x = fma(load_row(slots, now * entries + i, 0), splat(a[i]), x)
        store_row(slots, new * entries + i, 0, x)


@njit(fastmath=True, error_model="numpy")
def _column_sums(weight, slots, new, half, out):
    rows, columns = weight.shape
    for h in range(columns):
        x = splat(0.0)
        for m in range(rows):
            i = new * rows * columns + m * columns + h
            x = fma(load_row(slots, i, 0), splat(weight[m, h]), x)
        store_row(out, h + half if h < half else h - half, 0, x)


@njit(fastmath=True, error_model="numpy")
def _nodal_field(fold, columns, half, nodes, clearance, row, out):
    used, middle = len(fold) // 4, nodes // 2
    for n in range(nodes // 4 + 1):
        ce, co, se, so = splat(0.0), splat(0.0), splat(0.0), splat(0.0)
        for h in range(used):
            ce = fma(load_row(columns, h, 0), splat(fold[h, n]), ce)
            co = fma(load_row(columns, used + h, 0), splat(fold[used + h, n]), co)
            se = fma(load_row(columns, half + h, 0), splat(fold[2 * used + h, n]), se)
            so = fma(load_row(columns, half + used + h, 0), splat(fold[3 * used + h, n]), so)
        ce = fma(load_row(columns, half + used - 1, 0), splat(fold[4 * used, n]), ce)
        near, far, turned, back = add(ce, co), sub(ce, co), add(se, so), sub(se, so)
        store_row(out, n, 0, add(add(near, turned), splat(clearance[row, n])))
        store_row(out, nodes - n, 0, add(sub(near, turned), splat(clearance[row, nodes - n])))
        store_row(out, middle + n, 0, add(add(far, back), splat(clearance[row, middle + n])))
        store_row(out, middle - n, 0, add(sub(far, back), splat(clearance[row, middle - n])))


@njit(fastmath=True, error_model="numpy")
def _gaps(position, turned, nodes, length, w, w_s, u, tips, gap):
    for j in range(tips):
        for r in range(LANES):
            at = position[j] + turned[r]
            at -= nodes * np.floor(at / nodes)
            start = np.floor(at)
            xi, e = at - start, int(start)
            rest = 1.0 - xi
            wall = rest * rest * (1.0 + 2.0 * xi) * w[e, r] + length * xi * rest * rest * w_s[e, r]
            wall += xi * xi * (3.0 - 2.0 * xi) * w[e + 1, r]
            gap[j, r] = wall - length * xi * xi * rest * w_s[e + 1, r] - u[j, r]


@njit(fastmath=True, error_model="numpy")
def _advance(
    bodies, radial, shape, weights, fold, half, clearance, position, per_step, nodes, length,
    state, work, first, steps,
):  # fmt: skip
    ra, rb, ca, cb = bare(bodies[0]), bare(bodies[1]), bare(bodies[2]), bare(bodies[3])
    xs, ys, gap = bare(state[0]), bare(state[1]), bare(state[2])
    r_columns, values, slopes, u = bare(work[0]), bare(work[1]), bare(work[2]), bare(work[3])
    w, w_s, turned = bare(work[4]), bare(work[5]), np.empty(LANES)
    rotor_weight, w_weight, w_s_weight = bare(radial), bare(weights[0]), bare(weights[1])
    on_tips, quarter, offset = bare(shape), bare(fold), bare(clearance)
    old, now, new, tips = 0, 1, 2, len(gap)
    for step in range(first, first + steps):
        _predict(ra, rb, xs, old, now, new, len(ra))
        _predict(ca, cb, ys, old, now, new, len(ca))
        _column_sums(rotor_weight, xs, new, 0, r_columns)
        _column_sums(w_weight, ys, new, 0, values)
        _column_sums(w_s_weight, ys, new, half, slopes)
        for j in range(tips):
            x = splat(0.0)
            for h in range(len(on_tips)):
                x = fma(load_row(r_columns, h, 0), splat(on_tips[h, j]), x)
            store_row(u, j, 0, x)
        _nodal_field(quarter, values, half, nodes, offset, 0, w)
        _nodal_field(quarter, slopes, half, nodes, offset, 1, w_s)
        for r in range(LANES):
            turned[r] = per_step[r] * (step + 1)
        _gaps(position, turned, nodes, length, w, w_s, u, tips, gap)
        old, now, new = now, new, old
    return now


class BatchedMarch:
    """Eight marches without contact or load, from one start at several speeds.

    Args:
        problem: stage and start; its own speed is not used.
        speeds: eight angular velocities [rad/s].
        time_step: [s]
        slots: x_{n-1} and x_n of rotor and casing as the kernel's state holds them.
    """

    def __init__(
        self, problem: ContactProblem, speeds: FloatArray, time_step: float,
        slots: tuple[FloatArray, FloatArray],
    ) -> None:  # fmt: skip
        nodes = len(problem.casing.nodal)
        rotor_inverse, casing_inverse = (
            scheme_inverse(body.frequency, body.damping_ratio, time_step)
            for body in (problem.rotor, problem.casing)
        )
        rotor_layout, rotor = pack_rotor(problem.rotor, rotor_inverse, nodes, 0.0, cyclic=True)
        casing_layout, casing = pack_casing(problem.casing, casing_inverse, 0.0, cyclic=True)
        bodies = [
            pack_body(
                body.frequency,
                body.damping_ratio,
                np.zeros((0, len(body.frequency))),
                layout,
                time_step,
            )
            for body, layout in ((problem.rotor, rotor_layout), (problem.casing, casing_layout))
        ]
        states = [aligned((start.size, LANES)) for start in slots]
        for state, start in zip(states, slots, strict=True):
            state[...] = start.reshape(-1, 1)
        tips = len(problem.rotor.tip_angle)
        self.gap = aligned((tips, LANES))  #: at the last step [m], (tips, speeds)
        columns = casing_layout.columns
        sizes = (rotor_layout.columns, columns, columns, tips, nodes + 1, nodes + 1)
        self._arguments = (
            tuple(array for body in bodies for array in (body.a, body.b)), rotor.radial,
            rotor.shape, (casing.weight[0], casing.weight[1]),
            casing.fold, casing.half, casing.clearance, rotor.position,
            speeds * time_step * nodes / (2.0 * np.pi), nodes, casing.element_length,
            (*states, self.gap), tuple(aligned((size, LANES)) for size in sizes),
        )  # fmt: skip

    def advance(self, first: int, steps: int) -> None:
        """March from a step on. Once: slots are not put back in order for another time."""
        _advance(*self._arguments, first, steps)
