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
from functools import cached_property

import numpy as np
import scipy.linalg as la

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.models.coupling.equations import companion
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.modal_loads import NEVER
from bladewhirl.models.stage.reduced_rotor import ReducedRotor
from bladewhirl.solvers.periodic.blade import obstacles_over_time
from bladewhirl.solvers.periodic.complementarity import Complementarity
from bladewhirl.solvers.periodic.contact import NotConverged
from bladewhirl.solvers.periodic.ring import Ring

ROUND = 1e-6  #: largest variation of a clearance that counts as round


@dataclass(frozen=True)
class CorotatingContact:
    """Constant contact of a stage in rotating axes."""

    normal: FloatArray  #: normal force on each tip [N], (tips,)
    gap: FloatArray  #: gap of each tip [m], (tips,)
    tip: FloatArray  #: displacements of each tip in the axes of the wall [m], (tips, 3)
    rotor: FloatArray  #: modal displacements of the rotor [kg^1/2 m], (modes,)
    supports: FloatArray
    """Displacements of supports of bearings along x and y in rotating axes, times the root of their
    mass [kg^1/2 m], (2 * supports,)."""
    centre: FloatArray  #: x and y of the centre in rotating axes [m], (2,)
    rates: ComplexArray
    """Eigenvalues of small deviations [1/s], that with the largest real part first, (rates,)."""

    @property
    def stable(self) -> bool:
        """True if all small deviations decay."""
        return bool(self.rates[0].real < 0.0)

    def supports_velocity(self, speed: float) -> FloatArray:
        """Return the velocity of the supports in static axes at t = 0, when these are the rotating
        axes, at a speed of rotation [rad/s], (2 * supports,)."""
        x, y = self.supports.reshape(-1, 2).T
        return np.stack([-speed * y, speed * x], axis=1).ravel()


def obstacles(problem: ContactProblem) -> Iterable[str]:
    """Yield reasons why contact is not constant in rotating axes."""
    yield from obstacles_over_time(problem)
    if not len(problem.rotor.tip_angle):
        yield "there are no blades"
    clearance = problem.clearance(NEVER)[:, 0]
    if problem.casing.walls > 1:
        yield "several wheels have a flexible ring each"
    elif np.ptp(clearance) > ROUND * np.abs(clearance).max():
        yield "the clearance is not round"
    fixed = (
        np.any(each.casing) or (each.frequency and np.any(each.rotor)) for each in problem.loads
    )
    if any(fixed):
        yield "a load is not constant in rotating axes"
    if any(load.end != NEVER for load in problem.loads):
        yield "a load ends"
    if problem.springs is not None or problem.rotor.anisotropy:
        yield "springs in the static frame are not the same in all directions"
    if problem.bearings is not None and not problem.bearings.equal:
        yield "bearings or supports are not the same in all directions"
    wall = problem.casing.wall
    if wall.walls == 1 and wall.is_flexible and (np.any(wall.column < 0) or len(wall.dampers)):
        yield "the casing is not uniform"
    if problem.coating is not None or problem.tip_rotation or problem.foreshortening is not None:
        yield "coating, contact.tip_rotation and contact.foreshortening are not included"


@dataclass(frozen=True)
class Structure:
    """Bladed disk and supports of its bearings in rotating axes, in which equal bearings are
    constant. Its coordinates are the modes of the disk, then x and y of each support times the root
    of its mass."""

    shapes: FloatArray  #: displacements of all tips in their directions, (3, tips, coordinates)
    stiffness: FloatArray  #: [rad2/s2], (coordinates, coordinates)
    damping: FloatArray  #: [1/s], with the Coriolis forces, (coordinates, coordinates)

    @classmethod
    def of_problem(cls, problem: ContactProblem) -> "Structure":
        """Return the structure of a contact problem."""
        rotor, speed = problem.rotor, problem.speed
        stiffness = np.diag(rotor.stiffness) + rotor.circulation_stiffness
        damping = la.block_diag(*rotor.velocity_forces)
        if problem.bearings is None:
            return cls(_rows(rotor), stiffness, damping)
        supports = problem.casing.supports
        spin = np.kron(np.eye(supports), [[0.0, -1.0], [1.0, 0.0]])
        held = problem.bearings.in_rotating_axes(speed, supports)
        return cls(
            shapes=np.pad(_rows(rotor), [(0, 0), (0, 0), (0, 2 * supports)]),
            stiffness=la.block_diag(stiffness, -(speed**2) * np.eye(2 * supports)) + held[0],
            damping=la.block_diag(damping, 2.0 * speed * spin) + held[1],
        )


@dataclass(frozen=True)
class Equations:
    """Equations of constant contact.

    Raises:
        ValueError: contact is not constant in rotating axes; the message has the reason.
    """

    problem: ContactProblem

    def __post_init__(self) -> None:
        for reason in obstacles(self.problem):
            raise ValueError(reason)

    @cached_property
    def structure(self) -> Structure:
        """Bladed disk and supports."""
        return Structure.of_problem(self.problem)

    @cached_property
    def _moved(self) -> FloatArray:
        """Displacements by the loads at the end of their ramps, and by a unit normal force on each
        tip with its friction, (coordinates, 1 + tips)."""
        problem, (normal, tangential, _) = self.problem, self.structure.shapes
        pushed = np.zeros(len(self.structure.stiffness))
        for load in problem.loads:
            pushed[: len(load.rotor)] += load.rotor * np.cos(load.phase)
        along = normal + _way(problem) * tangential
        try:
            return np.linalg.solve(self.structure.stiffness, np.column_stack([pushed, -along.T]))
        except np.linalg.LinAlgError:
            raise NotConverged("a mode of the bladed disk has no stiffness") from None

    @cached_property
    def tips(self) -> Complementarity:
        """Gaps and normal forces of the tips.

        Raises:
            NotConverged: a mode has no stiffness.
        """
        problem, shapes, moved = self.problem, self.structure.shapes, self._moved
        rotor, casing, way = problem.rotor, problem.casing, _way(problem)
        clearance = float(problem.clearance(NEVER)[:, 0].mean())
        start = clearance * rotor.normal_part + rotor.tip_recess - shapes[0] @ moved[:, 0]
        matrix = _elastic(rotor, 0, (1.0, way)) - shapes[0] @ moved[:, 1:]
        if casing.is_flexible:
            apart = rotor.tip_angle[:, None] - rotor.tip_angle
            answer = Ring.of_casing(casing.wall).between(problem.speed, apart)
            matrix = matrix + answer[..., 0, 0] + way * answer[..., 0, 1]
        return Complementarity(start, matrix, ROUND * clearance, rotor.tip_angle)

    def contact(self, normal: FloatArray) -> CorotatingContact:
        """Return the motion with normal forces on the tips, (tips,)."""
        rotor, shapes = self.problem.rotor, self.structure.shapes
        moved = self._moved @ np.append(1.0, normal)
        own, elastic = len(rotor.frequency), (1.0, _way(self.problem))
        tip = [shapes[n] @ moved - _elastic(rotor, n, elastic) @ normal for n in range(3)]
        still, fading = _deviations(self.problem, self.structure, normal)
        unit = float(np.sqrt(np.abs(still).max(initial=0.0))) or 1.0
        values = np.linalg.eigvals(companion(-still, -fading, unit))
        return CorotatingContact(
            normal=normal,
            gap=self.tips.gap(normal),
            tip=np.stack(tip, axis=1),
            rotor=moved[:own],
            supports=moved[own:],
            centre=rotor.centre @ moved[:own],
            rates=np.asarray(values[np.argsort(-values.real)], dtype=np.complex128),
        )


def corotating_contact(problem: ContactProblem) -> CorotatingContact:
    """Return the constant contact of a stage, at the end of the ramps of its loads; of several with
    contact a stable one, if the search of `Complementarity.with_contact` finds one.

    Raises:
        ValueError: contact is not constant in rotating axes; the message has the reason.
        NotConverged: no solution was found.
    """
    equations = Equations(problem)
    found = list[CorotatingContact]()
    for normal in equations.tips.with_contact():
        found.append(equations.contact(normal))
        if found[-1].stable:
            return found[-1]
    return _some([*found, *_free(equations)])[0]


def contact_states(problem: ContactProblem) -> list[CorotatingContact]:
    """Return all constant contacts of a stage that the search of `Complementarity.with_contact`
    finds, stable ones first; at last the motion without contact, if it is one of them.

    Raises:
        ValueError: contact is not constant in rotating axes; the message has the reason.
        NotConverged: no solution was found.
    """
    equations = Equations(problem)
    found = [equations.contact(normal) for normal in equations.tips.with_contact()]
    return _some([*sorted(found, key=lambda each: not each.stable), *_free(equations)])


def _free(equations: Equations) -> list[CorotatingContact]:
    """Return the motion without contact, if it does not penetrate the wall."""
    still = np.zeros(len(equations.tips.start))
    return [equations.contact(still)] if equations.tips.free else []


def _some(found: list[CorotatingContact]) -> list[CorotatingContact]:
    """Return solutions if there are any.

    Raises:
        NotConverged: there are none.
    """
    if not found:
        raise NotConverged("the tips in contact keep changing")
    return found


def _way(problem: ContactProblem) -> float:
    """Return the friction coefficient with the sign of the rotation."""
    return float(np.sign(problem.speed)) * problem.friction


def _deviations(
    problem: ContactProblem, structure: Structure, normal: FloatArray
) -> tuple[ComplexArray, ComplexArray]:
    """Return stiffness [rad2/s2] and damping [1/s] of small deviations from constant contact.

    Args:
        problem: contact problem.
        structure: its bladed disk and supports.
        normal: normal forces [N], (tips,).
    """
    rotor, speed, shapes = problem.rotor, problem.speed, structure.shapes
    way, touching = _way(problem), normal > 0.0
    damping = structure.damping.astype(np.complex128)
    stiffness = structure.stiffness.astype(np.complex128)
    closing, axial = shapes[0, touching].astype(np.complex128), shapes[2, touching]
    pushing = (shapes[0] + way * shapes[1])[touching].T.astype(np.complex128)
    if problem.casing.is_flexible:
        ring = Ring.of_casing(problem.casing.wall)
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
