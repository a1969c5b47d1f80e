"""The contact march in plain NumPy, one step at a time: a second opinion on the compiled one.

Everything is dense, contact rows are built from the definitions, and the complementarity problem
is solved by trying active sets, all of them if need be.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import chain, combinations

import numpy as np
import scipy.linalg as la

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.stage.contact_problem import ContactProblem, Load, ReducedCasing


@dataclass(frozen=True, kw_only=True)
class PlainRun:
    """What happened, step by step."""

    rotor: FloatArray  #: x_0 .. x_steps, (steps + 1, rotor modes)
    casing: FloatArray  #: (steps + 1, casing modes)
    gap: FloatArray  #: at x_1 .. x_steps, (steps, tips)
    multiplier: FloatArray  #: that lead to them [N], (steps, tips)
    sign: FloatArray  #: of sliding, (steps, tips)
    energy: FloatArray  #: E_{n-1/2} for n = 0 .. steps, (steps + 1,)
    work: FloatArray  #: external, normal, friction, damping, parametric up to x_n, (steps + 1, 5)


def surface_rows(casing: ReducedCasing, angle: float) -> tuple[FloatArray, FloatArray, float]:
    """Rows of w and u at an angle, (casing modes,) each, and the clearance there."""
    nodes = len(casing.nodal)
    pitch = 2.0 * np.pi / nodes
    element = int(np.floor(angle / pitch)) % nodes
    x = (angle / pitch) % 1.0
    length = pitch * casing.radius
    values = np.array([1 - 3 * x**2 + 2 * x**3, 3 * x**2 - 2 * x**3])
    slopes = length * np.array([x - 2 * x**2 + x**3, x**3 - x**2])
    ends = [element, (element + 1) % nodes]
    w = values @ casing.nodal[ends, 0] + slopes @ casing.nodal[ends, 1]
    u = values @ casing.nodal[ends, 2] + slopes @ casing.nodal[ends, 3]
    clearance = values @ casing.clearance[ends, 0] + slopes @ casing.clearance[ends, 1]
    return w, u, float(clearance)


def load_factor(load: Load, time: float) -> float:
    """What a load pattern is multiplied with."""
    if time >= load.end:
        return 0.0
    rise = 0.5 - 0.5 * np.cos(np.pi * time / load.ramp) if time < load.ramp else 1.0
    return float(rise * np.cos(load.frequency * time + load.phase))


def complementary(gap: FloatArray, W: FloatArray) -> FloatArray:
    """lambda with 0 <= lambda perp gap + W lambda >= 0, trying the likeliest active sets first."""
    tips = len(gap)
    likely = [np.flatnonzero(gap < 0.0)]
    every = (
        np.array(c, dtype=int) for size in range(tips + 1) for c in combinations(range(tips), size)
    )
    tolerance = 1e-12 * np.abs(gap).max()
    for chosen in chain(likely, every):
        multiplier = np.zeros(tips)
        if chosen.size:
            part = W[np.ix_(chosen, chosen)]
            multiplier[chosen] = np.linalg.lstsq(part, -gap[chosen], rcond=None)[0]
        after = gap + W @ multiplier
        if (multiplier >= 0.0).all() and (after >= -tolerance).all():
            if np.abs(after[chosen]).max(initial=0.0) <= tolerance:
                return multiplier
    raise AssertionError("no active set is complementary")


def spring_stiffness(problem: ContactProblem, time: float) -> FloatArray:
    """K* of the springs over all modes of both bodies: Eq. (8), angle by angle."""
    m = len(problem.rotor.frequency)
    stiffness = np.zeros((m + len(problem.casing.frequency),) * 2)
    turn = problem.speed * time
    to_static = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    moved = to_static @ problem.rotor.centre  # of the centre along the static axes
    stiffness[:m, :m] = problem.rotor.anisotropy * (
        np.outer(moved[0], moved[0]) - np.outer(moved[1], moved[1])
    )
    springs = problem.springs
    if springs is None:
        return stiffness
    angles = np.linspace(0.0, 2.0 * np.pi, 101)[:-1]
    per_radian = springs.kappa * (1.0 if springs.with_pi else 1.0 / np.pi)
    for theta in angles:
        row = np.zeros(len(stiffness))
        for entry, number in enumerate(springs.number):
            on_casing = bool(springs.modes.on_casing[entry])
            at = theta if on_casing else theta - problem.speed * time
            amplitude, k = springs.modes.amplitude[entry], springs.modes.nodal_diameter[entry]
            place, way = (m + number, 1.0) if on_casing else (number, -1.0)
            row[place] += way * amplitude * np.cos(k * at)
            if springs.modes.paired[entry]:
                row[place + 1] += way * amplitude * np.sin(k * at)
        stiffness += per_radian * 2.0 * np.pi / len(angles) * np.outer(row, row)
    return stiffness


def plain_march(
    problem: ContactProblem, dt: float, steps: int, *, dampers_feel_contact: bool = False
) -> PlainRun:
    """March a problem from its start.

    Dampers feel what a contact force changes in the same step, or, as in the compiled march, from
    the next one on.
    """
    rotor, casing = problem.rotor, problem.casing
    m = len(rotor.frequency)
    omega = np.concatenate([rotor.frequency, casing.frequency])
    damping = 2.0 * np.concatenate([rotor.damping_ratio, casing.damping_ratio]) * omega
    own = np.diag(omega**2)
    stiffness, past = own + spring_stiffness(problem, 0.0), own + spring_stiffness(problem, -dt)
    A = 1.0 / dt**2 + damping / (2.0 * dt)
    dampers = la.block_diag(rotor.dampers.T @ rotor.dampers, casing.dampers.T @ casing.dampers)
    whole = np.diag(A) + dampers / (2.0 * dt)
    compliance = np.linalg.inv(whole) if dampers_feel_contact else np.diag(1.0 / A)
    patterns = [np.concatenate([load.rotor, load.casing]) for load in problem.loads]

    def force(time: float) -> FloatArray:
        total = np.zeros(len(omega))
        for load, pattern in zip(problem.loads, patterns, strict=True):
            total += load_factor(load, time) * pattern
        return total

    start = problem.start
    x = np.concatenate([start.rotor, start.casing])
    v = np.concatenate([start.rotor_velocity, start.casing_velocity])
    still = force(0.0) - damping * v - dampers @ v - stiffness @ x
    before = x - dt * v + 0.5 * dt**2 * still
    tips = len(rotor.tip_angle)
    history, gaps, multipliers, signs = [x], [], [], []
    works = [np.zeros(5)]
    energies = [0.5 * np.sum(((x - before) / dt) ** 2) + 0.5 * before @ past @ x]
    for n in range(steps):
        f = force(n * dt)
        stiffness = own + spring_stiffness(problem, n * dt)
        kept = 2.0 / dt**2 * x - stiffness @ x + (damping / (2 * dt) - 1 / dt**2) * before
        free = np.linalg.solve(whole, f + kept + dampers @ before / (2.0 * dt))
        drag = dampers @ (free - before) / (2.0 * dt)
        # Rows B_N and B_T of the gaps at the end of the step, and the sense of sliding.
        normal, tangential = np.zeros((tips, len(omega))), np.zeros((tips, len(omega)))
        clearance, sign = np.zeros(tips), np.zeros(tips)
        for j in range(tips):
            angle = rotor.tip_angle[j] + problem.speed * (n + 1) * dt
            if problem.tip_rotation:
                angle += rotor.tip_tangential[j] @ free[:m] / rotor.tip_radius
            w, u, clearance[j] = surface_rows(casing, angle)
            normal[j] = np.concatenate([-rotor.tip_radial[j], w])
            tangential[j] = np.concatenate([-rotor.tip_tangential[j], u])
            sliding = problem.speed
            if problem.sliding == "signed":
                # A blade that moves forward makes the tangential row's motion negative.
                moved = -tangential[j] @ (x - before) / dt
                sliding = rotor.tip_radius * problem.speed + moved
            sign[j] = np.sign(sliding)
        direction = normal + problem.friction * sign[:, None] * tangential
        clearance += rotor.tip_recess
        gap = clearance + normal @ free
        multiplier = complementary(gap, normal @ compliance @ direction.T)
        after = free + compliance @ direction.T @ multiplier
        moved = 0.5 * (after - before)
        works.append(
            works[-1]
            + [
                moved @ f,
                moved @ (normal.T @ multiplier),
                moved @ (tangential.T @ (problem.friction * sign * multiplier)),
                moved @ (damping * moved) / dt + moved @ drag,
                0.5 * before @ (stiffness - past) @ x,
            ]
        )
        energies.append(0.5 * np.sum(((after - x) / dt) ** 2) + 0.5 * x @ stiffness @ after)
        gaps.append(clearance + normal @ after)
        multipliers.append(multiplier)
        signs.append(sign)
        history.append(after)
        before, x, past = x, after, stiffness
    all_x = np.array(history)
    return PlainRun(
        rotor=all_x[:, :m],
        casing=all_x[:, m:],
        gap=np.array(gaps),
        multiplier=np.array(multipliers),
        sign=np.array(signs),
        energy=np.array(energies),
        work=np.array(works),
    )
