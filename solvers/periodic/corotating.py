"""Contact that is constant in rotating axes: an imbalance presses a bladed disk into a round wall.

Forces and displacements of the bladed disk are constant. In the static frame the forces move around
the casing with the speed Omega, so that its harmonic n has the frequency -n Omega. With the
harmonics s_n of the radial and tangential displacements of each mode of a uniform ring, a force at
the angle alpha + Omega t displaces the place beta + Omega t by

    G(beta - alpha) = sum_n e^{i n (beta - alpha)} sum_modes s_n s_n^* / (w^2 - (n Omega)^2 -
                      2 i zeta w n Omega).

Modes in pairs of a cosine and a sine cancel what varies with time. Gaps g and normal forces lambda
solve the complementarity problem 0 <= lambda, g = g_0 + A lambda >= 0, lambda g = 0, where
friction, along the rotation, is part of A. Above critical speeds and with dampers in the static
frame it can have several solutions.

Small deviations y of the modes of bladed disk and ring, both in rotating axes, satisfy

    y'' + D y' + K y = -B lambda,    H y = C lambda on the tips in contact,

with the closing H y of the gaps, the directions B of the contact forces and the residual
flexibility C. With this flexibility lambda follows from y. Without it y and the equations are
projected to the motions H z = 0 and to the directions w with w^H B = 0. Across the rotation
friction is a damper mu lambda / (|Omega| r) of the axial slip velocity.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import scipy.linalg as la

from bladewhirl.meshes.line_mesh import BoolArray, ComplexArray, FloatArray
from bladewhirl.models.coupling.equations import companion
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.modal_loads import NEVER
from bladewhirl.models.stage.reduced_rotor import ReducedRotor
from bladewhirl.solvers.periodic.blade import obstacles_over_time
from bladewhirl.solvers.periodic.contact import NotConverged
from bladewhirl.solvers.periodic.ring import Ring

CHANGES = 200  #: largest number of changes of the set of tips in contact
ROUND = 1e-6  #: largest variation of a clearance that counts as round


@dataclass(frozen=True)
class CorotatingContact:
    """Constant contact of a stage in rotating axes."""

    normal: FloatArray  #: normal force on each tip [N], (tips,)
    gap: FloatArray  #: gap of each tip [m], (tips,)
    rotor: FloatArray  #: modal displacements of the rotor [kg^1/2 m], (modes,)
    centre: FloatArray  #: x and y of the centre in rotating axes [m], (2,)
    rates: ComplexArray
    """Eigenvalues of small deviations [1/s], that with the largest real part first, (rates,)."""

    @property
    def stable(self) -> bool:
        """True if all small deviations decay."""
        return bool(self.rates[0].real < 0.0)


def obstacles(problem: ContactProblem) -> Iterable[str]:
    """Yield reasons why contact is not constant in rotating axes."""
    yield from obstacles_over_time(problem)
    clearance = problem.clearance(NEVER)[:, 0]
    if np.ptp(clearance) > ROUND * np.abs(clearance).max():
        yield "the clearance is not round"
    if any(load.frequency != 0.0 or np.any(load.casing) for load in problem.loads):
        yield "a load is not constant in rotating axes"
    if any(load.end != NEVER for load in problem.loads):
        yield "a load ends"
    if problem.springs is not None or problem.rotor.anisotropy:
        yield "springs in the static frame are not the same in all directions"
    if problem.casing.is_flexible and (
        np.any(problem.casing.column < 0) or len(problem.casing.dampers)
    ):
        yield "the casing is not uniform"
    if problem.coating is not None or problem.tip_rotation or problem.foreshortening is not None:
        yield "coating, contact.tip_rotation and contact.foreshortening are not included"


def corotating_contact(problem: ContactProblem) -> CorotatingContact:
    """Return the constant contact of a stage, at the end of the ramps of its loads; of several with
    contact a stable one, if some are stable. The search begins with the tips that the motion
    without contact presses into the wall, and then with each tip alone.

    Raises:
        ValueError: contact is not constant in rotating axes; the message has the reason.
        NotConverged: no solution was found.
    """
    for reason in obstacles(problem):
        raise ValueError(reason)
    rotor, casing = problem.rotor, problem.casing
    shapes, way = _rows(rotor), float(np.sign(problem.speed)) * problem.friction
    along = shapes[0] + way * shapes[1]
    pushed = sum(
        (load.rotor * np.cos(load.phase) for load in problem.loads), np.zeros(len(rotor.frequency))
    )
    stiffness = np.diag(rotor.stiffness) + rotor.circulation_stiffness
    try:
        moved = np.linalg.solve(stiffness, np.column_stack([pushed, -along.T]))
    except np.linalg.LinAlgError:
        raise NotConverged("a mode of the bladed disk has no stiffness") from None
    clearance = float(problem.clearance(NEVER)[:, 0].mean())
    start = clearance * rotor.normal_part + rotor.tip_recess - shapes[0] @ moved[:, 0]
    matrix = _elastic(rotor, 0, (1.0, way)) - shapes[0] @ moved[:, 1:]
    if casing.is_flexible:
        apart = rotor.tip_angle[:, None] - rotor.tip_angle
        answer = Ring.of_casing(casing).between(problem.speed, apart)
        matrix = matrix + answer[..., 0, 0] + way * answer[..., 0, 1]

    def contact(normal: FloatArray) -> CorotatingContact:
        rotated = moved @ np.append(1.0, normal)
        still, fading = _deviations(problem, shapes, stiffness, normal)
        unit = float(np.sqrt(np.abs(still).max(initial=0.0))) or 1.0
        values = np.linalg.eigvals(companion(-still, -fading, unit))
        rates = np.asarray(values[np.argsort(-values.real)], dtype=np.complex128)
        gap = start + matrix @ normal
        return CorotatingContact(normal, gap, rotated, rotor.centre @ rotated, rates)

    tolerance = ROUND * clearance
    normal = _solved(start, matrix, start < 0.0, tolerance)
    if normal is not None and normal.any():
        return contact(normal)
    others: dict[bytes, FloatArray] = {}
    for each in np.eye(len(start), dtype=np.bool_)[start * np.diag(matrix) < 0.0]:
        found = _solved(start, matrix, each, tolerance)
        if found is not None and found.any():
            others.setdefault((found > 0.0).tobytes(), found)
    solutions = map(contact, others.values() if others or normal is None else [normal])
    for solution in sorted(solutions, key=lambda each: not each.stable):
        return solution
    raise NotConverged("the tips in contact keep changing")


def _solved(
    start: FloatArray, matrix: FloatArray, chosen: BoolArray, tolerance: float
) -> FloatArray | None:
    """Return normal forces of the complementarity problem, from a set of tips in contact; None if
    the set keeps changing."""
    seen = set[bytes]()
    for _ in range(CHANGES):
        normal = np.zeros(len(start))
        try:
            normal[chosen] = np.linalg.solve(matrix[np.ix_(chosen, chosen)], -start[chosen])
        except np.linalg.LinAlgError:
            return None
        wrong = np.where(chosen, normal < 0.0, start + matrix @ normal < -tolerance)
        if not wrong.any():
            return normal
        if chosen.tobytes() in seen:  # change one tip only
            wrong[np.flatnonzero(wrong)[:-1]] = False
        seen.add(chosen.tobytes())
        chosen = chosen ^ wrong
    return None


def _deviations(
    problem: ContactProblem, shapes: FloatArray, stiffness: FloatArray, normal: FloatArray
) -> tuple[ComplexArray, ComplexArray]:
    """Return stiffness [rad2/s2] and damping [1/s] of small deviations from constant contact.

    Args:
        problem: contact problem.
        shapes: displacements of all tips in their directions, (3, tips, modes).
        stiffness: stiffness of the modes of the bladed disk [rad2/s2], (modes, modes).
        normal: normal forces [N], (tips,).
    """
    rotor, speed = problem.rotor, problem.speed
    way, touching = float(np.sign(speed)) * problem.friction, normal > 0.0
    damping = la.block_diag(*rotor.velocity_forces).astype(np.complex128)
    stiffness = stiffness.astype(np.complex128)
    closing, axial = shapes[0, touching].astype(np.complex128), shapes[2, touching]
    pushing = (shapes[0] + way * shapes[1])[touching].T.astype(np.complex128)
    if problem.casing.is_flexible:
        ring = Ring.of_casing(problem.casing)
        order, shape, mode = ring.both_ways
        own, turning = ring.frequency[mode], order * speed
        rate = 2.0 * ring.damping_ratio[mode] * own
        damping = la.block_diag(damping, np.diag(rate - 2j * turning))
        stiffness = la.block_diag(stiffness, np.diag(own**2 - turning**2 - 1j * rate * turning))
        around = np.exp(1j * order * rotor.tip_angle[touching, None])
        closing = np.hstack([closing, -around * shape[:, 0]])
        pushing = np.vstack([pushing, -(around * (shape[:, 0] + way * shape[:, 1])).conj().T])
        axial = np.hstack([axial, np.zeros_like(around, dtype=np.float64)])
    if problem.sliding == "full":
        radius = np.tile(rotor.contact_radius, rotor.copies)[: len(normal)]
        drag = (problem.friction * normal / np.abs(speed * radius))[touching, None]
    else:
        drag = np.zeros((len(axial), 1))
    both = np.ix_(touching, touching)
    flexible = _elastic(rotor, 0, (1.0, way))[both]
    if flexible.any():
        across = axial - _elastic(rotor, 2, (1.0, way))[both] @ la.solve(flexible, closing)
        leaned = axial.T - pushing @ la.solve(flexible, _elastic(rotor, 0, (0.0, 0.0, 1.0))[both])
        damping = damping + leaned @ (drag * across)
        stiffness = stiffness + pushing @ la.solve(flexible, closing)
    else:
        damping = damping + axial.T @ (drag * axial)
        if touching.any():
            right, left = la.null_space(closing), la.null_space(pushing.conj().T).conj().T
            left = la.solve(left @ right, left)
            stiffness, damping = left @ stiffness @ right, left @ damping @ right
    return np.asarray(stiffness), np.asarray(damping)


def _rows(rotor: ReducedRotor) -> FloatArray:
    """Return radial, tangential and axial displacements of all tips, (3, tips, modes)."""
    every = (rotor.tip_radial, rotor.tip_tangential, rotor.tip_axial)
    return np.stack([np.kron(np.eye(rotor.copies), rows) for rows in every])


def _elastic(rotor: ReducedRotor, row: int, forces: tuple[float, ...]) -> FloatArray:
    """Return displacements of tips in a direction by the residual flexibility of contact nodes, for
    forces on tips with components in the first directions [m/N], (tips, tips)."""
    tips = len(rotor.tip_angle)
    if rotor.compliance is None:
        return np.zeros((tips, tips))
    each = [sum(f * own[row::3, k::3] for k, f in enumerate(forces)) for own in rotor.compliance]
    return np.asarray(la.block_diag(*each))
