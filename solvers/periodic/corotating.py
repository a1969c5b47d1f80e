"""Contact that is constant in rotating axes: an imbalance presses a bladed disk into a round wall.

Forces and displacements of the bladed disk are constant. In the static frame the forces move around
the casing with the speed Omega, so that its harmonic n has the frequency -n Omega. With the
harmonics s_n of the radial and tangential displacements of each mode of a uniform ring, a force at
the angle alpha + Omega t displaces the place beta + Omega t by

    G(beta - alpha) = sum_n e^{i n (beta - alpha)} sum_modes s_n s_n^* / (w^2 - (n Omega)^2 -
                      2 i zeta w n Omega).

Modes in pairs of a cosine and a sine cancel what varies with time. Gaps g and normal forces lambda
solve the complementarity problem 0 <= lambda, g = g_0 + A lambda >= 0, lambda g = 0, where
friction, along the rotation, is part of A.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.stage.contact_problem import (
    NEVER,
    ContactProblem,
    ReducedCasing,
    ReducedRotor,
)
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
    if problem.springs is not None or problem.rotor.anisotropy or problem.rotor.circulation:
        yield "springs or dampers in the static frame act on the bladed disk"
    if problem.casing.is_flexible and (
        np.any(problem.casing.column < 0) or len(problem.casing.dampers)
    ):
        yield "the casing is not uniform"
    if problem.coating is not None or problem.tip_rotation or problem.foreshortening is not None:
        yield "coating, contact.tip_rotation and contact.foreshortening are not included"
    if np.any(problem.rotor.stiffness <= 0.0):
        yield "a mode of the bladed disk has no positive stiffness"


def corotating_contact(problem: ContactProblem) -> CorotatingContact:
    """Return the constant contact of a stage, at the end of the ramps of its loads.

    Raises:
        ValueError: contact is not constant in rotating axes; the message has the reason.
        NotConverged: no solution was found.
    """
    for reason in obstacles(problem):
        raise ValueError(reason)
    rotor = problem.rotor
    shapes = _rows(rotor)
    way = np.sign(problem.speed) * problem.friction
    pushed = sum(
        (load.rotor * np.cos(load.phase) for load in problem.loads), np.zeros(len(rotor.frequency))
    )
    free = pushed / rotor.stiffness
    clearance = float(problem.clearance(NEVER)[:, 0].mean())
    start = clearance * rotor.normal_part + rotor.tip_recess - shapes[0] @ free
    along = shapes[0] + way * shapes[1]
    matrix = shapes[0] / rotor.stiffness @ along.T
    if rotor.nodes is not None and rotor.nodes.compliance is not None:
        matrix = matrix + _elastic(rotor, way)
    matrix = matrix + _ring(problem.casing, problem.speed, rotor.tip_angle, way)
    normal, chosen = np.zeros(len(start)), start < 0.0
    seen = set[bytes]()
    for _ in range(CHANGES):
        normal = np.zeros(len(start))
        normal[chosen] = np.linalg.solve(matrix[np.ix_(chosen, chosen)], -start[chosen])
        gap = start + matrix @ normal
        wrong = np.where(chosen, normal < 0.0, gap < -ROUND * clearance)
        if not wrong.any():
            moved = free - along.T @ normal / rotor.stiffness
            return CorotatingContact(normal, gap, moved, rotor.centre @ moved)
        if chosen.tobytes() in seen:  # change one tip only
            wrong[np.flatnonzero(wrong)[:-1]] = False
        seen.add(chosen.tobytes())
        chosen = chosen ^ wrong
    raise NotConverged("the tips in contact keep changing")


def _rows(rotor: ReducedRotor) -> tuple[FloatArray, FloatArray]:
    """Return radial and tangential displacements of all tips, (tips, modes) each."""
    if rotor.copies == 1:
        return rotor.tip_radial, rotor.tip_tangential
    one = np.eye(rotor.copies)
    radial, tangential = (
        np.asarray(np.kron(one, rows), dtype=np.float64)
        for rows in (rotor.tip_radial, rotor.tip_tangential)
    )
    return radial, tangential


def _elastic(rotor: ReducedRotor, way: float) -> FloatArray:
    """Return the part of the residual flexibility of contact nodes, (tips, tips)."""
    assert rotor.nodes is not None
    assert rotor.nodes.compliance is not None
    tips = len(rotor.tip_angle) // rotor.copies
    total = np.zeros((len(rotor.tip_angle), len(rotor.tip_angle)))
    for copy, own in enumerate(rotor.nodes.compliance):
        place = slice(copy * tips, (copy + 1) * tips)
        total[place, place] = own[0::3, 0::3] + way * own[0::3, 1::3]
    return total


def _ring(casing: ReducedCasing, speed: float, angle: FloatArray, way: float) -> FloatArray:
    """Return radial displacements of the casing at tips for normal forces on tips, (tips, tips)."""
    if not casing.is_flexible:
        return np.zeros((len(angle), len(angle)))
    answer = Ring.of_casing(casing).between(speed, angle[:, None] - angle)
    return answer[..., 0, 0] + way * answer[..., 0, 1]
