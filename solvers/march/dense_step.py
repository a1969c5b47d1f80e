"""One step of the dense schemes, compiled: velocities first, impulses at the tips.

With theta = 1/2 and unit masses, A = 1 + h C / 2 + h^2 K / 4, velocities without contact are

    A v_f = v_n - h C v_n / 2 - h K (x_n + h v_n / 4) + h f

where K is the bodies' own stiffness, C all damping and Coriolis forces, and f, at half the step,
holds loads, springs that turn and dampers that stand still. Impulses P at the tips complete it,

    v_{n+1} = v_f + A^-1 (B_N P_N + B_T P_T),     x_{n+1} = x_n + h (v_n + v_{n+1}) / 2,

so that energy changes by exactly the work of all forces. Both laws find P tip by tip, again and
again until none changes (projected Gauss-Seidel): see `solvers.march.dense`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from bladewhirl.meshes.line_mesh import FloatArray, IntArray

EXTERNAL, NORMAL, FRICTION, DAMPING, TURNING = range(5)
"""Places of the works."""

RESIDUAL, CONTACT_STEPS, UNSOLVED, CONTACTS = range(4)
"""Places of what a march counts."""

GAP, IMPULSE, DRAG, TOUCHED = range(4)
"""Rows of what is summed up since the last record."""

MOST_ROUNDS, CLOSE = 2000, 1e-12
"""Rounds of Gauss-Seidel at most, and the share of the largest velocity that ends them."""

ENTRY = {"cache": True, "error_model": "numpy", "no_cfunc_wrapper": True}
PART = ENTRY | {"cache": False, "no_cpython_wrapper": True}
"""Options of functions called from Python, and of functions called from compiled code only."""

LOOK_EVERY = 100
"""Steps between checks of displacements other than the radial ones of the tips."""


class Stage(NamedTuple):
    """Constants of a march; the modes of the rotor precede those of the casing."""

    stiffness: FloatArray  #: squared frequencies, (modes,)
    damping: FloatArray  #: diagonal part of C, (modes,)
    dampers: FloatArray  #: rows G of its part G^T G, (dampers, modes)
    by_velocity: FloatArray  #: Coriolis forces and the rest of C, (rotor modes, same) or empty
    inverse: FloatArray  #: of A, (modes, modes)
    centre: FloatArray  #: x and y of the rotor's centre, (2, modes)
    circulation: float  #: of fixed dampers under it [N/m]
    coupled: IntArray  #: modes that turning springs join, (coupled,)
    turning_cos: FloatArray  #: their stiffness by harmonics of the rotor's angle, (n, c, c)
    turning_sin: FloatArray
    loads: FloatArray  #: (loads, modes)
    load_times: FloatArray  #: end, ramp, frequency, phase, (loads, 4)
    tip_radial: FloatArray  #: (tips, rotor modes)
    tip_tangential: FloatArray
    tip_angle: FloatArray  #: (tips,)
    tip_recess: FloatArray
    nodal: FloatArray  #: (casing nodes, 4, casing modes)
    clearance: FloatArray  #: (casing nodes, 2)
    tip_radius: float
    element_length: float
    speed: float
    follows: float  #: 1 where a tip's angle follows its displacement, else 0
    limit: float  #: of displacements


class Law(NamedTuple):
    """The contact law."""

    friction: float
    restitution: float
    penalty: float  #: [N/m]; 0 for impulses that keep tips from closing in
    stick_speed: float  #: below which friction grows with the speed [m/s]; 0 where tips stick


@njit(**PART)
def velocity_force(stage: Stage, v: FloatArray) -> FloatArray:
    """C v; Coriolis forces in it do no work."""
    force = stage.damping * v + stage.dampers.T @ (stage.dampers @ v)
    modes = len(stage.by_velocity)
    force[:modes] += stage.by_velocity @ v[:modes]
    return force


@njit(**PART)
def turning_force(stage: Stage, angle: float, x: FloatArray) -> FloatArray:
    """Force of springs that turn."""
    out, size = np.zeros(len(x)), len(stage.coupled)
    for n in range(len(stage.turning_cos)):
        cos, sin = np.cos(n * angle), np.sin(n * angle)
        for i in range(size):
            for j in range(size):
                k = cos * stage.turning_cos[n, i, j] + sin * stage.turning_sin[n, i, j]
                out[stage.coupled[i]] -= k * x[stage.coupled[j]]
    return out


@njit(**PART)
def load_force(stage: Stage, time: float, out: FloatArray) -> None:
    """Force of the loads."""
    out[:] = 0.0
    for n in range(len(stage.loads)):
        end, ramp, frequency, phase = stage.load_times[n]
        if time < end:
            rise = 0.5 - 0.5 * np.cos(np.pi * time / ramp) if time < ramp else 1.0
            out += rise * np.cos(frequency * time + phase) * stage.loads[n]


@njit(**PART)
def tip_place(stage: Stage, tip: int, turn: float, x: FloatArray) -> tuple[int, float]:
    """Return the casing element under a tip, and the position along it, 0 to 1."""
    angle = stage.tip_angle[tip] + turn
    if stage.follows:
        moved = np.dot(stage.tip_tangential[tip], x[: stage.tip_radial.shape[1]])
        angle += moved / stage.tip_radius
    nodes = len(stage.nodal)
    at = (angle * nodes / (2.0 * np.pi)) % nodes
    return int(at) % nodes, at - int(at)


@njit(**PART)
def under_tip(
    stage: Stage,
    element: int,
    weights: tuple[float, float, float, float],
    first: int,
    row: FloatArray,
) -> float:
    """Fill a row of the casing's modes from their values and slopes; the clearance by the same."""
    after = (element + 1) % len(stage.nodal)
    here, there = stage.nodal[element], stage.nodal[after]
    for mode in range(len(row)):
        row[mode] = (
            weights[0] * here[first, mode]
            + weights[1] * here[first + 1, mode]
            + weights[2] * there[first, mode]
            + weights[3] * there[first + 1, mode]
        )
    near, far = stage.clearance[element], stage.clearance[after]
    return weights[0] * near[0] + weights[1] * near[1] + weights[2] * far[0] + weights[3] * far[1]


@njit(**PART)
def value_weights(xi: float, length: float) -> tuple[float, float, float, float]:
    """Cubic Hermite functions."""
    rest = 1.0 - xi
    return (
        rest**2 * (1.0 + 2.0 * xi),
        length * xi * rest**2,
        xi**2 * (3.0 - 2.0 * xi),
        -length * xi**2 * rest,
    )


@njit(**PART)
def slope_weights(xi: float, length: float) -> tuple[float, float, float, float]:
    """Their slopes along the element."""
    rest = 1.0 - xi
    steep = 6.0 * xi * rest / length
    return -steep, rest * (1.0 - 3.0 * xi), steep, xi * (3.0 * xi - 2.0)


@njit(**PART)
def look(stage: Stage, tip: int, turn: float, x: FloatArray, row: FloatArray) -> float:
    """Gap of a tip, and its row of B_N."""
    modes = stage.tip_radial.shape[1]
    element, xi = tip_place(stage, tip, turn, x)
    weights = value_weights(xi, stage.element_length)
    row[:modes] = -stage.tip_radial[tip]
    clearance = under_tip(stage, element, weights, 0, row[modes:])
    return clearance + stage.tip_recess[tip] + np.dot(row, x)


@njit(**PART)
def sliding(
    stage: Stage, tip: int, turn: float, x: FloatArray, v: FloatArray, row: FloatArray
) -> float:
    """Rate at which the casing's shape closes in as the tip runs along it, and row of B_T."""
    modes = stage.tip_radial.shape[1]
    element, xi = tip_place(stage, tip, turn, x)
    slopes = slope_weights(xi, stage.element_length)
    rate = stage.speed
    if stage.follows:
        rate += np.dot(stage.tip_tangential[tip], v[:modes]) / stage.tip_radius
    slope = under_tip(stage, element, slopes, 0, row[modes:])
    slope += np.dot(row[modes:], x[modes:])
    row[:modes] = -stage.tip_tangential[tip]
    under_tip(stage, element, value_weights(xi, stage.element_length), 2, row[modes:])
    per_radian = len(stage.nodal) * stage.element_length / (2.0 * np.pi)
    return rate * per_radian * slope


@njit(**PART)
def impulses(
    law: Law, compliance: FloatArray, free: FloatArray, before: FloatArray, impulse: FloatArray
) -> tuple[float, bool]:
    """Normal and tangential impulses by projected Gauss-Seidel: residual, and whether it ended.

    Args:
        law: of contact; normal impulses stay as they are found with a penalty.
        compliance: velocities by impulses, normal then tangential, (2 tips, 2 tips).
        free: velocities without impulses, (2 tips,).
        before: normal velocities at the start of the step, (tips,).
        impulse: impulses to start from and to be filled, (2 tips,).
    """
    tips = len(before)
    scale = max(np.abs(free).max(), np.abs(before).max(), 1e-300)
    rounds, change = 0, np.inf
    while change > CLOSE * scale and rounds < MOST_ROUNDS:
        rounds, change = rounds + 1, 0.0
        for tip in range(tips):
            if law.penalty == 0.0 and compliance[tip, tip] > 0.0:
                rebound = -law.restitution * min(before[tip], 0.0)
                speed = free[tip] + np.dot(compliance[tip], impulse) - rebound
                after = max(0.0, impulse[tip] - speed / compliance[tip, tip])
                change = max(change, compliance[tip, tip] * abs(after - impulse[tip]))
                impulse[tip] = after
            most, row = law.friction * impulse[tip], tips + tip
            if most == 0.0 or compliance[row, row] <= 0.0:
                after = -most * np.sign(free[row])
            else:
                speed = free[row] + np.dot(compliance[row], impulse)
                yielding = law.stick_speed / most
                after = impulse[row] - (speed + yielding * impulse[row]) / (
                    compliance[row, row] + yielding
                )
                after = min(max(after, -most), most)
            change = max(change, compliance[row, row] * abs(after - impulse[row]))
            impulse[row] = after
    residual = 0.0
    if law.penalty == 0.0:
        for tip in range(tips):
            left = free[tip] + np.dot(compliance[tip], impulse)
            left += law.restitution * min(before[tip], 0.0)
            residual = max(residual, abs(min(left, compliance[tip, tip] * impulse[tip])) / scale)
    return residual, change <= CLOSE * scale


@njit(**PART)
def keeps_limit(stage: Stage, step: int, x: FloatArray) -> bool:
    """Return whether all displacements are within the limit."""
    modes = stage.tip_radial.shape[1]
    for tip in range(len(stage.tip_angle)):
        if not abs(np.dot(stage.tip_radial[tip], x[:modes])) <= stage.limit:
            return False
        if step % LOOK_EVERY == 0:
            if not abs(np.dot(stage.tip_tangential[tip], x[:modes])) <= stage.limit:
                return False
    if step % LOOK_EVERY == 0:
        for node in range(len(stage.nodal)):
            if not abs(np.dot(stage.nodal[node, 0], x[modes:])) <= stage.limit:
                return False
    return True


@njit(**PART)
def turning_energy(stage: Stage, angle: float, x: FloatArray) -> float:
    """Energy of the springs that turn."""
    return -0.5 * np.dot(x, turning_force(stage, angle, x))


@njit(**PART)
def free_velocity(
    stage: Stage, h: float, x: FloatArray, v: FloatArray, force: FloatArray
) -> FloatArray:
    """v_f: velocities after a step without contact, under a force."""
    momentum = v - 0.5 * h * velocity_force(stage, v)
    momentum += h * (force - stage.stiffness * (x + 0.25 * h * v))
    return stage.inverse @ momentum


@njit(**ENTRY)
def advance(
    stage: Stage,
    law: Law,
    h: float,
    first: int,
    steps: int,
    x: FloatArray,
    v: FloatArray,
    sums: FloatArray,
    works: FloatArray,
    counts: FloatArray,
) -> int:
    """Do steps in place, until displacements leave their limit; the number done."""
    size, tips = len(x), len(stage.tip_angle)
    load, rows = np.zeros(size), np.zeros((2 * tips, size))
    row, active = np.zeros(size), np.zeros(tips, dtype=np.int64)
    free, before, impulse = np.zeros(2 * tips), np.zeros(tips), np.zeros(2 * tips)
    for step in range(first, first + steps):
        middle = x + 0.5 * h * v
        load_force(stage, (step + 0.5) * h, load)
        turned = turning_force(stage, stage.speed * (step + 0.5) * h, middle)
        swing = stage.circulation * (stage.centre @ middle)
        turned += swing[1] * stage.centre[0] - swing[0] * stage.centre[1]
        v_free = free_velocity(stage, h, x, v, load + turned)
        if law.penalty > 0.0:
            seen, turn = middle, stage.speed * (step + 0.5) * h
        else:
            seen, turn = x + 0.5 * h * (v + v_free), stage.speed * (step + 1) * h
        touching = 0
        for tip in range(tips):
            gap = look(stage, tip, turn, seen, rows[touching])
            if gap < 0.0:
                active[touching], impulse[touching] = tip, -gap
                touching += 1
        n = touching
        v_after = v_free.copy()
        if n:
            for i in range(n):
                drift = sliding(stage, active[i], turn, seen, v, rows[n + i])
                before[i] = np.dot(rows[i], v) + drift
                free[i] = np.dot(rows[i], v_free) + drift
                free[n + i] = np.dot(rows[n + i], v_free) - stage.tip_radius * stage.speed
            answers = rows[: 2 * n] @ stage.inverse.T
            compliance = rows[: 2 * n] @ answers.T
            impulse[:n] = h * law.penalty * impulse[:n]
            impulse[n : 2 * n] = 0.0
            residual, ended = impulses(law, compliance, free[: 2 * n], before[:n], impulse[: 2 * n])
            v_after += impulse[: 2 * n] @ answers
            counts[RESIDUAL] = max(counts[RESIDUAL], residual)
            counts[UNSOLVED] += not ended
        moved = 0.5 * h * (v + v_after)
        x_after = x + moved
        if not keeps_limit(stage, step + 1, x_after):
            return step - first
        counts[CONTACTS] = 0.0
        for i in range(n):
            tip = active[i]
            if impulse[i] > 0.0:
                counts[CONTACTS] += 1
                sums[IMPULSE, tip] += impulse[i]
                sums[DRAG, tip] += impulse[n + i]
                sums[TOUCHED, tip] += 1
                works[NORMAL] += impulse[i] / h * np.dot(rows[i], moved)
                works[FRICTION] += impulse[n + i] / h * np.dot(rows[n + i], moved)
        counts[CONTACT_STEPS] += counts[CONTACTS] > 0
        at, after = stage.speed * step * h, stage.speed * (step + 1) * h
        works[EXTERNAL] += np.dot(moved, load)
        works[DAMPING] += np.dot(moved, velocity_force(stage, moved)) / h
        works[TURNING] += np.dot(moved, turned) + turning_energy(stage, after, x_after)
        works[TURNING] -= turning_energy(stage, at, x)
        x[:] = x_after
        v[:] = v_after
        for tip in range(tips):
            sums[GAP, tip] = min(sums[GAP, tip], look(stage, tip, after, x, row))
    return steps
