"""A structure with massless contact nodes in a wall, and its responses on a grid of instants.

The displacements u of the contact nodes and the forces f on them satisfy u = P q + C f and
q'' + D q' + W^2 q = P^T f + loads. All that drives the motion, the wall and the loads, has the
period T = 2 pi / (p Omega), and each harmonic h with the frequency w = h p Omega responds by

    u_h = H(w) f_h,   H(w) = C + P (W^2 - w^2 + i w D)^-1 P^T.

On a grid of n instants in a period, responses to forces are cyclic convolutions. In a step the mean
of the forces at both ends acts, and the modes respond exactly, see `steps`. In contact this is the
average acceleration method of Newmark, which is stable for any step; with forces that are linear in
a step (linear acceleration) small deviations would grow in contacts of several steps that are
longer than 3.46 / w, with the frequency w of the modes with closed contacts.
In contrast to a trigonometric interpolation, forces have no effect on instants before them, and a
Newton method finds motions with many contact nodes more often.

The wall is rigid, or a uniform ring, whose response to the same forces is added, see `ring`.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import gcd
from typing import Any

import numpy as np

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.models.coupling.equations import Matrix
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.modal_loads import NEVER, Load
from bladewhirl.models.stage.wall import SEEN, around_wall, harmonics_around
from bladewhirl.solvers.periodic.ring import Ring
from bladewhirl.solvers.periodic.steps import Steps

DIRECTIONS = 3  #: radial, tangential, axial
WHOLE = 1e-9  #: largest distance of the order of a load from a whole number
ALIKE = 1e-6  #: largest relative difference of properties of equal blades
RIGID = 1e-6  #: frequency below which a mode of the casing is rigid, relative to the highest


@dataclass(frozen=True, kw_only=True)
class Blade:
    """A structure in a wall, both driven with the period of a turn divided by `lobes`."""

    stiffness: FloatArray  #: squared frequencies W^2 [rad2/s2], (modes,)
    damping: FloatArray  #: matrix D of the forces due to velocities [1/s], (modes, modes)
    contact: FloatArray  #: rows P of the contact nodes [kg^-1/2], (3 * nodes, modes)
    compliance: FloatArray  #: residual flexibility C [m/N], (3 * nodes, 3 * nodes)
    angle: FloatArray  #: angle of each contact node from +x at t = 0 [rad], (nodes,)
    radius: FloatArray  #: radius of each contact node [m], (nodes,)
    recess: FloatArray  #: see `ReducedRotor.tip_recess` [m], (nodes,)
    normal_part: FloatArray  #: see `ReducedRotor.normal_part`, (nodes,)
    clearance: FloatArray  #: clearance and its derivative by the arc length [m, 1], (angles, 2)
    wall_step: float  #: arc length between two of these angles [m]
    loads: Mapping[int, ComplexArray]
    """Complex modal forces of each engine order r for the time factor exp(i r |Omega| t)
    [kg^1/2 m/s2], (modes,)."""
    speed: float  #: speed of rotation Omega [rad/s]
    friction: float  #: Coulomb friction coefficient
    turns: bool  #: True if the direction of friction is unknown; otherwise it opposes the rotation
    lobes: int  #: number of periods of the wall and the loads in a turn
    ring: Ring | None = None  #: the wall if it is flexible
    copies: int = 1  #: number of equal blades in the ring, at equal angles
    periods: int = 1  #: number of periods of the wall and the loads in a period of the motion

    @classmethod
    def of_problem(
        cls, problem: ContactProblem, copy: int = 0, others: Sequence[ContactProblem] = ()
    ) -> "Blade":
        """Return a copy of the structure of a contact problem. Ramps of loads, loads that end, and
        the course of the closure are over; the closure has its final value.

        Args:
            problem: the contact problem.
            copy: number of the copy.
            others: further problems of a branch: period, engine orders and unknowns suit them all,
                although friction, lobes of the wall or loads of some are zero.

        Raises:
            ValueError: the method does not apply; the message names the reason.
        """
        rotor = problem.rotor
        for reason in _obstacles(problem):
            raise ValueError(reason)
        assert rotor.compliance is not None
        loads, every = _loads(problem), [problem, *others]
        orders = {
            order: np.zeros(rotor.by_copy(rotor.frequency).shape)
            for each in every
            for order in _loads(each)
        }
        walls = [_wall(each)[:, 0] for each in every]
        lobes = gcd(*(n for wall in walls for n in harmonics_around(wall)), *orders)
        if not lobes:
            raise ValueError(
                "the wall is round and no load varies with time, so that the motion has no period"
            )
        return cls(
            stiffness=rotor.by_copy(rotor.stiffness)[copy],
            damping=rotor.velocity_forces[copy],
            contact=rotor.contact,
            compliance=rotor.compliance[copy],
            angle=rotor.by_copy(rotor.tip_angle)[copy],
            radius=rotor.contact_radius,
            recess=rotor.by_copy(rotor.tip_recess)[copy],
            normal_part=rotor.by_copy(rotor.normal_part)[copy],
            clearance=_wall(problem),
            wall_step=problem.casing.element_length,
            loads={order: force[copy] for order, force in {**orders, **loads}.items()},
            speed=problem.speed,
            friction=problem.friction,
            turns=any(each.sliding == "full" and each.friction > 0.0 for each in every),
            lobes=lobes,
            ring=Ring.of_casing(problem.casing) if problem.casing.is_flexible else None,
            copies=rotor.copies if problem.casing.is_flexible else 1,
        )

    @property
    def nodes(self) -> int:
        """Number of contact nodes."""
        return len(self.angle)

    @property
    def period(self) -> float:
        """Period of the motion [s]."""
        return self.periods * 2.0 * np.pi / (self.lobes * abs(self.speed))

    @property
    def first_order(self) -> float:
        """Engine order of the first harmonic of the motion: periods of the motion in a turn."""
        return self.lobes / self.periods

    @property
    def stiffness_scale(self) -> float:
        """A stiffness of the contact nodes, with which gaps and forces are compared [N/m]."""
        return float(1.0 / np.diag(self.compliance)[::DIRECTIONS].mean())

    def admittance(self, w: float) -> ComplexArray:
        """Return (W^2 - w^2 + i w D)^-1 for a frequency w [rad/s], (modes, modes)."""
        return np.asarray(np.linalg.inv(np.diag(self.stiffness - w**2) + 1j * w * self.damping))


def obstacles_over_time(problem: ContactProblem) -> Iterable[str]:
    """Yield reasons why a problem changes with time and has no periodic motion."""
    if problem.change is not None:
        yield "the speed varies; expected march.speed alone"
    if problem.loss is not None:
        yield "blades are lost; remove [blade_loss]"
    if problem.fuse is not None:
        yield "the support can fuse; remove shaft.fuse_force"


def _obstacles(problem: ContactProblem) -> Iterable[str]:
    """Yield reasons why the method does not apply to a problem."""
    rotor = problem.rotor
    if problem.speed == 0.0:
        yield "the speed is 0, so that the motion has no period"
    if rotor.compliance is None:
        yield 'contact nodes have mass; expected reduction.boundary = "massless"'
    if problem.casing.is_flexible:
        yield from _obstacles_in_ring(problem)
    yield from obstacles_over_time(problem)
    if problem.coating is not None:
        yield "the coating wears, so that no motion is periodic; remove casing.coating"
    if problem.tip_rotation:
        yield "contact.tip_rotation = true is not included"
    if problem.foreshortening is not None:
        yield "contact.foreshortening = true is not included"
    if problem.springs is not None or rotor.anisotropy or rotor.circulation:
        yield "springs or dampers in the static frame couple harmonics"


def _obstacles_in_ring(problem: ContactProblem) -> Iterable[str]:
    """Yield reasons why the blades of a problem in a flexible casing do not follow one another."""
    rotor, casing = problem.rotor, problem.casing
    if np.any(casing.column < 0) or len(casing.dampers):
        yield "the flexible casing is not uniform; expected no struts, stiffeners and dampers"
    if casing.frequency.min() <= RIGID * casing.frequency.max():
        yield "a mode of the flexible casing has no stiffness; expected casing.support"
    if any(load.frequency != 0.0 and load.casing.any() for load in problem.loads if lasts(load)):
        yield "a load on the flexible casing varies with time"
    turn = 2.0 * np.pi * np.arange(rotor.copies)[:, None] / rotor.copies
    apart = rotor.by_copy(rotor.tip_angle) - rotor.tip_angle[: len(rotor.tip_radial)] - turn
    if np.abs(np.sin(0.5 * apart)).max() > ALIKE:
        yield "the blades in a flexible casing are not at equal angles"
    own = [rotor.by_copy(rotor.frequency), rotor.by_copy(rotor.damping_ratio)]
    if rotor.compliance is not None:
        own.append(rotor.compliance)
    if any(np.abs(each - each[0]).max() > ALIKE * np.abs(each).max() for each in own):
        yield "the blades in a flexible casing differ; expected no mistuning"
    for order, each in _loads(problem).items():
        following = each[0] * np.exp(1j * order * turn * np.sign(problem.speed))
        if np.abs(each - following).max() > ALIKE * np.abs(each).max():
            yield "a load on the blades in a flexible casing is not fixed in space"


def lasts(load: Load) -> bool:
    """Return whether a load has no end."""
    return load.end == NEVER


def _wall(problem: ContactProblem) -> FloatArray:
    """Return the clearance at the end of the closure and its slope, with the displacement of the
    casing under constant loads, (nodes, 2)."""
    casing, clearance = problem.casing, problem.clearance(NEVER)
    pushed = [
        load.casing * np.cos(load.phase)
        for load in problem.loads
        if lasts(load) and load.casing.any()
    ]
    if not pushed:
        return clearance
    modal = np.sum(pushed, axis=0) / casing.frequency**2
    return np.asarray(clearance + casing.nodal[:, :2] @ modal)


def _loads(problem: ContactProblem) -> dict[int, ComplexArray]:
    """Return the complex modal forces of all loads of each engine order, (copies, modes): those of
    a cosine and a sine belong together. Sums that are rounding errors are left out."""
    each: dict[int, list[ComplexArray]] = {}
    for load in problem.loads:
        if lasts(load) and load.rotor.any():
            order, force = _of_order(load, problem.speed)
            each.setdefault(order, []).append(force.reshape(problem.rotor.copies, -1))
    sums = {order: np.sum(forces, axis=0) for order, forces in each.items()}
    return {
        order: force
        for order, force in sums.items()
        if np.abs(force).max() > SEEN * np.abs(each[order]).max()
    }


def _of_order(load: Load, speed: float) -> tuple[int, ComplexArray]:
    """Return the engine order of a load and its complex modal forces on all copies."""
    order = load.frequency / abs(speed)
    whole = round(abs(order))
    if abs(abs(order) - whole) > WHOLE:
        raise ValueError(
            f"a load has {abs(order):.6g} times the frequency of rotation; expected a whole number"
        )
    force = load.rotor * (np.exp(1j * load.phase) if whole else np.cos(load.phase))
    return whole, np.asarray(force if order >= 0.0 else force.conj())


FIXED = ("turns", "lobes", "wall_step", "copies", "periods")
"""Fields of a blade that do not depend on a parameter, without the ring."""
ARRAYS = tuple(name for name in Blade.__annotations__ if name not in (*FIXED, "loads", "ring"))
"""Fields of a blade that can depend linearly on a parameter, without the loads."""


def between(one: Blade, other: Blade, share: float) -> Blade:
    """Return the blade whose properties are between those of two blades: `share` 0 gives the first,
    1 the second. Equal properties are kept as they are."""

    def mixed(a: Any, b: Any) -> Any:
        return a if a is b or np.array_equal(a, b) else (1.0 - share) * a + share * b

    loads = {order: mixed(force, other.loads[order]) for order, force in one.loads.items()}
    fields = {name: mixed(getattr(one, name), getattr(other, name)) for name in ARRAYS}
    return replace(one, loads=loads, **fields)


def comparable(one: Blade, other: Blade) -> bool:
    """Return whether two blades differ in no other properties than those that `between` mixes."""
    return (
        all(getattr(one, name) == getattr(other, name) for name in FIXED)
        and (one.ring is other.ring or (one.ring is not None and one.ring.equals(other.ring)))
        and all(np.shape(getattr(one, name)) == np.shape(getattr(other, name)) for name in ARRAYS)
        and one.loads.keys() == other.loads.keys()
    )


def alike(one: Blade, other: Blade, tolerance: float) -> bool:
    """Return whether two comparable blades are equal, relative to the largest of each property."""
    pairs = [(getattr(one, name), getattr(other, name)) for name in ARRAYS]
    pairs += [(force, other.loads[order]) for order, force in one.loads.items()]
    return all(
        np.abs(np.subtract(a, b)).max(initial=0.0) <= tolerance * np.abs(a).max(initial=0.0)
        for a, b in pairs
    )


@dataclass(frozen=True)
class Grid:
    """A blade with its responses at equally spaced instants of a period.

    Forces and displacements of the contact nodes have the shape (instants, 3 * nodes).
    """

    blade: Blade
    instants: int  #: number of instants, a power of two

    @property
    def step(self) -> float:
        """Time between two instants [s]."""
        return self.blade.period / self.instants

    @cached_property
    def time(self) -> FloatArray:
        """Instants [s], (instants,)."""
        return self.step * np.arange(float(self.instants))

    @cached_property
    def _steps(self) -> Steps:
        return Steps(self.blade.stiffness, self.blade.damping, self.step)

    @property
    def unit(self) -> float:
        """Frequency that multiplies modal coordinates in the state (unit q, q') [rad/s]."""
        return self._steps.unit

    @cached_property
    def transition(self) -> tuple[FloatArray, FloatArray]:
        """Matrices E and G of a step of the state (unit q, q'), (2 * modes, 2 * modes) and
        (2 * modes, 3 * nodes)."""
        return self._steps.transition(self.blade.contact)

    @cached_property
    def _answers(self) -> ComplexArray:
        """See `Steps.answers`."""
        return self._steps.answers(self.instants)

    @cached_property
    def to_nodes(self) -> tuple[FloatArray, FloatArray]:
        """Matrices from the state (unit q, q') to displacements and velocities of the contact nodes
        by the modes, (3 * nodes, 2 * modes) each."""
        rest = np.zeros_like(self.blade.contact)
        return np.hstack([self.blade.contact / self.unit, rest]), np.hstack(
            [rest, self.blade.contact]
        )

    @cached_property
    def _ring(self) -> ComplexArray:
        """Displacements and velocities of the nodes relative to a flexible wall that move away from
        it by forces on the nodes, by harmonic, (2, instants / 2 + 1, 3n, 3n)."""
        blade = self.blade
        assert blade.ring is not None
        found = blade.ring.answers(
            blade.lobes, blade.speed, blade.copies, blade.angle, self.instants
        )
        wide = np.zeros((*found.shape[:2], *blade.compliance.shape), dtype=np.complex128)
        inside = np.flatnonzero(np.arange(len(blade.compliance)) % DIRECTIONS < 2)
        wide[:, :, inside[:, None], inside] = found
        return wide

    def against_ring(self, force: FloatArray) -> FloatArray:
        """Return displacements and velocities of the nodes relative to a flexible wall that follow
        from the motion of the wall under contact forces, (2, instants, 3 * nodes); zeros for a
        rigid wall."""
        if self.blade.ring is None or not force.any():
            return np.zeros((2, *force.shape))
        spectrum = self._ring @ np.fft.rfft(force, axis=0)[..., None]
        return np.fft.irfft(spectrum[..., 0], self.instants, axis=1)

    @cached_property
    def lagged(self) -> tuple[FloatArray, FloatArray]:
        """Radial displacements [m/N] and tangential and axial velocities [m/(N s)], relative to the
        wall, at each lag after a unit force at one instant of each period, (directions of the
        motion, 3, nodes * nodes * instants). C f is differentiated by backward differences, as in
        the march."""
        flexible = self.blade.compliance
        moved, rate = self._pulse(0, [0]), self._pulse(1, [1, 2])
        moved[..., 0] += by_component(flexible)[:1]
        within = by_component(flexible / self.step)[1:]
        rate[..., 0] += within
        rate[..., 1] -= within
        return moved.reshape(1, DIRECTIONS, -1), rate.reshape(2, DIRECTIONS, -1)

    def _pulse(self, which: int, directions: list[int]) -> FloatArray:
        """Return displacements (0) or velocities (1) in some directions relative to the wall,
        without those by the compliance, after a unit force at the first instant, (directions, 3,
        nodes, nodes, instants)."""
        answers, contact = self._answers[which], self.blade.contact
        sets, own, _, harmonics = answers.shape
        rows = contact.reshape(-1, DIRECTIONS, sets, own)
        products = np.einsum("ndso,mesp->denmsop", rows[:, directions], rows)
        answers = answers.reshape(-1, harmonics)
        each = products.reshape(-1, len(answers))
        spectrum = np.empty((len(each), harmonics), dtype=np.complex128)
        spectrum.real, spectrum.imag = each @ answers.real, each @ answers.imag
        if self.blade.ring is not None:
            ring = by_component(self._ring[which])[directions]
            spectrum += ring.reshape(-1, harmonics)
        nodes = self.blade.nodes
        shape = len(directions), DIRECTIONS, nodes, nodes, self.instants
        return np.fft.irfft(spectrum, self.instants, axis=-1).reshape(shape)

    @cached_property
    def _free(self) -> FloatArray:
        """Modal coordinates and velocities without contact forces, (2, instants, modes)."""
        blade = self.blade
        moved = np.zeros((2, self.instants, len(blade.stiffness)))
        for order, force in blade.loads.items():
            w = order * abs(blade.speed)
            turning = np.exp(1j * w * self.time)[:, None] * (blade.admittance(w) @ force)
            moved += np.stack([turning.real, (1j * w * turning).real])
        return moved

    def modes(self, force: FloatArray | None) -> FloatArray:
        """Return modal coordinates [kg^1/2 m] and velocities [kg^1/2 m/s] under contact forces,
        (2, instants, modes); None: without contact forces."""
        if force is None or not force.any():
            return self._free
        _, sets, own, _, harmonics = self._answers.shape
        spectrum = np.fft.rfft(self.blade.contact.T @ force.T).reshape(sets, 1, own, harmonics)
        moved = (self._answers * spectrum).sum(axis=-2).reshape(2, sets * own, harmonics)
        return np.asarray(self._free + np.fft.irfft(moved, self.instants).swapaxes(1, 2))

    def displacement(self, force: FloatArray, modes: FloatArray) -> FloatArray:
        """Return the displacements of the contact nodes under forces, with the motion of the modes
        of `modes` [m], (instants, 3 * nodes)."""
        blade = self.blade
        return np.asarray(modes[0] @ blade.contact.T + force @ blade.compliance.T)

    @cached_property
    def wall(self) -> FloatArray:
        """Gaps of the contact nodes at rest [m], (instants, nodes)."""
        blade = self.blade
        angle = blade.angle + blade.speed * self.time[:, None]
        wall = around_wall(blade.clearance, blade.wall_step, angle)
        return np.asarray(blade.normal_part * wall + blade.recess)

    @cached_property
    def free_gap(self) -> FloatArray:
        """Gaps without contact forces [m], (instants, nodes)."""
        return np.asarray(self.wall - self._free[0] @ self.blade.contact[::DIRECTIONS].T)

    def slip(self, force: FloatArray, modes: FloatArray) -> FloatArray:
        """Return tangential and axial slip velocities on the wall under contact forces, with the
        motion of the modes of `modes` [m/s], (instants, nodes, 2)."""
        blade = self.blade
        change = (force - np.roll(force, 1, axis=0)) / self.step
        velocity = modes[1] @ blade.contact.T + change @ blade.compliance.T
        velocity = velocity + self.against_ring(force)[1]
        slip = velocity.reshape(self.instants, -1, DIRECTIONS)[..., 1:].copy()
        slip[..., 0] += blade.speed * blade.radius
        return np.asarray(slip)

    def finer(self) -> "Grid":
        """Return the grid of twice as many instants."""
        return replace(self, instants=2 * self.instants)


def by_component(matrices: Matrix) -> Matrix:
    """Return matrices by component and then by node, (..., 3n, 3n) as (3, 3, n, n, ...)."""
    *_, size = matrices.shape
    nodes = size // DIRECTIONS
    apart = matrices.reshape(-1, nodes, DIRECTIONS, nodes, DIRECTIONS).transpose(2, 4, 1, 3, 0)
    return apart.reshape(*apart.shape[:4], *matrices.shape[:-2])
