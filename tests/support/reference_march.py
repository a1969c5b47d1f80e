"""The contact march in plain NumPy, one step at a time, with which the compiled march is compared.

The reference follows the definitions directly. Every product is dense, and the rows of B_N and B_T
are computed in each step from the position of each tip on the casing. The stiffness of coupling
springs is summed over harmonics, and the complementarity problem is solved by trying active sets,
all of them if necessary. A time step has four parts, as in `solvers/kernel/march.c`; with
A = M / dt^2 + D / (2 dt)

    predict   A x_p = f_n - K_n x_n + 2 M / dt^2 x_n + (D / (2 dt) - M / dt^2) x_{n-1}
    look      g_p = clearance + B_N x_p
    solve     0 <= lambda  perp  g = g_p + W (lambda + F(g)) >= 0     W = B_N^T c (B_N + mu B_T S)
    correct   x_{n+1} = x_p + c (B_N + mu B_T S) (lambda + F(g))

S is the diagonal matrix of the signs of sliding, F the force of the rods of a coating. D includes
 point dampers; c is the inverse of A
without point dampers, because point dampers respond to a contact force from the next step on.
Coriolis forces add Omega G / dt to A and to the factor of x_{n-1}. With Coriolis forces, c of the
rotor includes Coriolis forces and point dampers. At a speed that varies A, K and the loads are
those of the speed at n; works and energies are then not those of the kernel.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import scipy.linalg as la

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.stage.contact_problem import ContactProblem, rod_angles
from bladewhirl.solvers.march.march import (
    Chunk,
    CoatingRecords,
    EndReason,
    Statistics,
    check_time_step,
)
from bladewhirl.solvers.packing.foreshortening import held_steps, near_gap
from bladewhirl.studies.verification.march import complementary, load_factor

CHECK_EVERY = 100
"""Number of steps between checks of all displacements except radial tip displacements."""


class Coated(NamedTuple):
    """Coating after a step, and its forces in the step."""

    strain: FloatArray  #: plastic strain of each rod, (tracks, rods)
    force: FloatArray  #: force on each tip [N], (tips,)
    slope: FloatArray  #: decrease of the force with the gap [N/m], (tips,)
    stored: float  #: elastic energy of the rods [J]


class Bent(NamedTuple):
    """Foreshortening in a step: openings of the gaps and their gradients.

    The opening of a tip near the wall is linearised in the displacements for a number of steps, at
    the displacement expected in the middle of these steps. The opening of other tips is
    extrapolated from the last check.
    """

    bend: FloatArray  #: y at the linearisation, (tips, terms)
    until: FloatArray  #: last step of the linearisation of each tip, (tips,)
    checked: FloatArray  #: opening and differences at the last check [m], (3, tips)
    gradient: FloatArray  #: gradient of the opening, zero for other tips, (tips, modes)
    start: FloatArray  #: opening at zero displacement [m], (tips,)


class Step(NamedTuple):
    """Results of a step: displacements, contact forces and modal forces, (modes,)."""

    after: FloatArray  #: displacements x_{n+1}, (modes,)
    gap: FloatArray  #: gap of each tip at x_{n+1} [m], (tips,)
    multiplier: FloatArray  #: normal contact force lambda [N], (tips,)
    friction: FloatArray  #: friction force mu s (lambda + F) [N], (tips,)
    force: FloatArray  #: modal loads f_n
    pressed: FloatArray  #: modal normal forces
    dragged: FloatArray  #: modal friction forces
    circulated: FloatArray  #: modal forces of dampers in the static frame due to x_n
    damped: FloatArray  #: modal forces of point dampers and Coriolis forces
    coating: Coated  #: forces and state of the coating
    bent: Bent  #: foreshortening
    residual: float  #: complementarity residual (`CentralDifference`)


@dataclass(frozen=True, kw_only=True)
class ReferenceState:
    """State between two steps; the modes of the rotor precede those of the casing."""

    step: int  #: number of steps n
    before: FloatArray  #: displacements x_{n-1}, (modes,)
    now: FloatArray  #: displacements x_n, (modes,)
    gaps: tuple[FloatArray, FloatArray]  #: gaps at x_{n-1} and at x_n [m], (tips,)
    gap: FloatArray  #: smallest gap of each tip since the last record [m], (tips,)
    impulse: FloatArray  #: normal impulse since the last record [N s], (tips,)
    drag: FloatArray  #: friction impulse since the last record [N s], (tips,)
    touched: FloatArray  #: number of steps with contact since the last record, (tips,)
    contacts: int  #: number of tips in contact at the last step
    work: FloatArray
    """External, normal, friction, damping, parametric and closing work [J], (6,)."""
    strain: FloatArray  #: plastic strain of each rod of the coating, (tracks, rods)
    coating_impulse: FloatArray  #: normal impulse on the coating since the last record, (tips,)
    stored: float  #: elastic energy of the coating [J]
    bend: FloatArray  #: see `Bent`
    until: FloatArray  #: see `Bent`
    checked: FloatArray  #: see `Bent`
    statistics: Statistics


class Reference:
    """Readable NumPy implementation of `CentralDifference` with equal results, for comparison.

    Args:
        problem: contact problem.
        time_step: time step [s].
        record_every: number of steps between records.
        dampers_feel_contact: let point dampers respond to contact within the step, unlike in the
            kernel.

    Raises:
        ValueError: the time step is not below the critical time step.
    """

    def __init__(
        self,
        problem: ContactProblem,
        time_step: float,
        record_every: int,
        *,
        dampers_feel_contact: bool = False,
    ) -> None:
        check_time_step(problem, time_step)
        self.cyclic = (False, False)
        rotor, casing, dt = problem.rotor, problem.casing, time_step
        self._problem, self._dt, self._record_every = problem, dt, record_every
        self._rotor_modes = len(rotor.frequency)
        frequency = np.concatenate([rotor.frequency, casing.frequency])
        self._stiffness = np.concatenate([rotor.stiffness, casing.frequency**2])
        ratio = np.concatenate([rotor.damping_ratio, casing.damping_ratio])
        self._damping = 2.0 * ratio * np.abs(frequency)
        turning = rotor.by_velocity is not None
        dampers = [body.dampers.T @ body.dampers for body in (rotor, casing)]
        feel = turning or dampers_feel_contact, dampers_feel_contact
        self._felt = la.block_diag(*(d * feels for d, feels in zip(dampers, feel, strict=True)))
        self._late = la.block_diag(*dampers) - self._felt  # dampers that respond one step late
        if rotor.by_velocity is not None:
            self._felt[: self._rotor_modes, : self._rotor_modes] += rotor.by_velocity
        self._at_base = self._felt
        self._turn(0)
        self._near = near_gap(problem)
        self._held, self._unchecked = held_steps(problem, dt)

    def _turn(self, n: int) -> None:
        """Set the matrices that depend on the speed at step n."""
        dt, problem, modes = self._dt, self._problem, self._rotor_modes
        change = problem.change
        if change is not None and change.rotor is not None:
            self._felt = self._at_base.copy()
            further = 2.0 * (problem.speed_at(n * dt) - problem.speed)
            self._felt[:modes, :modes] += further * change.rotor.coriolis
        elif n > 0:
            return
        self._by_velocity = self._felt + self._late
        inertia = np.diag(1.0 / dt**2 + self._damping / (2.0 * dt))
        self._inverse = np.linalg.inv(inertia + self._by_velocity / (2.0 * dt))
        self._compliance = np.linalg.inv(inertia + self._felt / (2.0 * dt))

    def init(self) -> ReferenceState:
        """Return the state at t = 0; x_{-1} follows from the initial velocity and acceleration."""
        start, dt = self._problem.start, self._dt
        x = np.concatenate([start.rotor, start.casing])
        v = np.concatenate([start.rotor_velocity, start.casing_velocity])
        lost = self._damping * v + self._by_velocity @ v
        force = self._force(0) + self._circulation(x)
        acceleration = force - lost - self._stiffness * x - self._spring_force(0, x)
        before = x - dt * v + 0.5 * dt**2 * acceleration
        gaps = [self._gap(before, -1), self._gap(x, 0)]
        none, coating = np.zeros_like(gaps[0]), self._problem.coating
        bending = self._problem.foreshortening
        terms = 0 if bending is None else bending.rows.shape[1]
        return ReferenceState(
            step=0,
            before=before,
            now=x,
            gaps=(gaps[0], gaps[1]),
            gap=gaps[1],
            impulse=none,
            drag=none,
            touched=none,
            contacts=0,
            work=np.zeros(6),
            strain=np.zeros((1, 0)) if coating is None else coating.strain,
            coating_impulse=none,
            stored=0.0,
            bend=np.zeros((len(none), terms)),
            until=none - 1.0,
            checked=np.zeros((3, len(none))),
            statistics=Statistics(),
        )

    def advance(
        self, state: ReferenceState, steps: int, record_every: int | None = None
    ) -> tuple[ReferenceState, Chunk, EndReason | None]:
        """Advance by a number of steps; see `Scheme.advance`."""
        every = self._record_every if record_every is None else record_every
        records: list[tuple[ReferenceState, FloatArray, float]] = []
        for _ in range(steps):
            step = self._step(state)
            within = self._keeps_limit(step.after, state.step + 1)
            if state.step % every == 0 or not within:
                later, interval = (step.after, 2.0) if within else (state.now, 1.0)
                velocity = (later - state.before) / (interval * self._dt)
                records.append((state, velocity, self._energy(state)))
                none = np.zeros_like(state.gap)
                state = replace(
                    state,
                    gap=none + np.inf,
                    impulse=none,
                    drag=none,
                    touched=none,
                    coating_impulse=none,
                )
            if not within:
                return state, self._chunk(records, state), EndReason.DIVERGENT
            state = self._account(state, step)
        return state, self._chunk(records, state), None

    def _step(self, state: ReferenceState) -> Step:
        """Return the results of one step: predict, look, solve, correct."""
        dt, n, x, before = self._dt, state.step, state.now, state.before
        self._turn(n)
        force, circulated = self._force(n), self._circulation(x)
        restoring = self._stiffness * x + self._spring_force(n, x)
        inertia = 2.0 / dt**2 * x + (self._damping / (2.0 * dt) - 1.0 / dt**2) * before
        drag = self._by_velocity @ before / (2.0 * dt)
        free = self._inverse @ (force + circulated - restoring + inertia + drag)
        bent = self._bend(state, free)
        normal, tangential, clearance = self._rows(free, n + 1)
        normal, clearance = normal + bent.gradient, clearance + bent.start
        slides = self._problem.friction * self._sliding(tangential, x - before, n + 1)
        free_gap = clearance + normal @ free
        response = self._compliance @ (normal + slides[:, None] * tangential).T
        delassus = normal @ response
        multiplier, coating = self._solve(free_gap, delassus, free, n + 1, state.strain)
        force_on_tips = multiplier + coating.force
        after = free + response @ force_on_tips
        late = self._late @ (free - before)
        damped = (self._felt @ (after - before) + late) / (2.0 * dt)
        gap = clearance + normal @ after
        smaller = np.minimum(gap, np.diag(delassus) * multiplier)
        violated = np.where(multiplier > 0.0, np.abs(smaller), np.maximum(-gap, 0.0)).max()
        scale = max(self._problem.casing.clearance[:, 0].min(), np.abs(free_gap).max())
        return Step(
            after=after,
            gap=gap,
            multiplier=multiplier,
            friction=slides * force_on_tips,
            force=force,
            pressed=force_on_tips @ normal,
            dragged=(slides * force_on_tips) @ tangential,
            circulated=circulated,
            damped=damped,
            coating=coating,
            bent=bent,
            residual=float(violated / scale) if force_on_tips.any() and scale > 0.0 else 0.0,
        )

    def _account(self, state: ReferenceState, step: Step) -> ReferenceState:
        """Return the state after a step, with works, impulses and statistics. The caller has
        checked that displacements are within `displacement_limit`."""
        dt, n, before, x = self._dt, state.step, state.before, state.now
        coating = step.coating
        moved, force = 0.5 * (step.after - before), step.multiplier + coating.force
        touching = force > 0.0
        turned = self._spring_force(n, x) - self._spring_force(n - 1, x)
        lost = moved @ (self._damping * moved) / dt + moved @ step.damped
        done = [moved @ step.force, moved @ step.pressed, moved @ step.dragged, lost]
        turning = 0.5 * before @ turned + moved @ step.circulated
        closing = 0.5 * step.multiplier @ (step.gap - state.gaps[0])
        before_it = state.statistics
        return ReferenceState(
            step=n + 1,
            before=x,
            now=step.after,
            gaps=(state.gaps[1], step.gap),
            gap=np.minimum(state.gap, step.gap),
            impulse=state.impulse + dt * force,
            drag=state.drag + dt * step.friction,
            touched=state.touched + touching,
            contacts=int(touching.sum()),
            work=state.work + np.array([*done, turning, closing]),
            strain=coating.strain,
            coating_impulse=state.coating_impulse + dt * coating.force,
            stored=coating.stored,
            bend=step.bent.bend,
            until=step.bent.until,
            checked=step.bent.checked,
            statistics=replace(
                before_it,
                steps=n + 1,
                contact_steps=before_it.contact_steps + bool(touching.any()),
                complementarity_residual=max(before_it.complementarity_residual, step.residual),
            ),
        )

    def _energy(self, state: ReferenceState) -> float:
        """Return E_{n-1/2} = v^T v / 2 + x_{n-1}^T K_{n-1} x_n / 2, v = (x_n - x_{n-1}) / dt
        [J]."""
        v = (state.now - state.before) / self._dt
        restoring = self._stiffness * state.now + self._spring_force(state.step - 1, state.now)
        return float(0.5 * v @ v + 0.5 * state.before @ restoring)

    def _force(self, n: float) -> FloatArray:
        """Return the modal forces of the loads at step n, (modes,)."""
        total, problem = np.zeros(len(self._stiffness)), self._problem
        turned = problem.rotation_at(n * self._dt)
        for load in problem.loads:
            factor = load_factor(load, n * self._dt)
            if problem.change is not None:
                factor = load.amplitude(n * self._dt, turned, problem.speed)
            total += factor * np.concatenate([load.rotor, load.casing])
        return total

    def _circulation(self, x: FloatArray) -> FloatArray:
        """Return the modal forces of dampers in the static frame due to displacements, (modes,)."""
        rotor = self._problem.rotor
        skew = rotor.circulation * np.array([[0.0, 1.0], [-1.0, 0.0]])
        force = rotor.centre.T @ (skew @ (rotor.centre @ x[: self._rotor_modes]))
        return np.concatenate([force, np.zeros(len(x) - self._rotor_modes)])

    def _spring_force(self, n: float, x: FloatArray) -> FloatArray:
        """Return K*_n x of the coupling springs, of unequal static shaft springs and of the change
        of the speed, (modes,)."""
        problem, modes = self._problem, self._rotor_modes
        turned, force = problem.rotation_at(n * self._dt), np.zeros_like(x)
        if problem.change is not None:
            still = np.zeros(modes)
            lacking = problem.change.change_of_force(problem.speed, turned, x[:modes], still)
            force[:modes] = -lacking
        if problem.springs is None and problem.rotor.anisotropy == 0.0:
            return force
        return np.asarray(force + problem.spring_stiffness(turned.angle) @ x)

    def _rows(self, x: FloatArray, n: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return B_N and B_T of the tips at step n, (tips, modes), and clearance plus
        `metal_recess`, (tips,).

        With `tip_rotation`, the angles of the tips include their tangential displacements in ``x``.
        """
        problem, rotor = self._problem, self._problem.rotor
        angle = rotor.tip_angle + problem.angle_at(n * self._dt)
        if problem.tip_rotation:
            angle = angle + rotor.tip_tangential @ x[: self._rotor_modes] / rotor.tip_radius
        radial, along, clearance = self._wall_rows(angle, n)
        normal = np.hstack([-rotor.tip_radial, radial])
        tangential = np.hstack([-rotor.tip_tangential, along])
        return normal, tangential, clearance + problem.metal_recess

    def _wall_rows(self, angle: FloatArray, n: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return w and u of the casing modes at angles, (angles, modes), and the clearance at step
        n, (angles,)."""
        casing = self._problem.casing
        nodes, length = len(casing.nodal), casing.element_length
        at = np.mod(angle * nodes / (2.0 * np.pi), nodes)
        first = np.floor(at).astype(np.int64) % nodes
        xi = at - np.floor(at)
        weights = np.array(
            [
                1.0 - 3.0 * xi**2 + 2.0 * xi**3,
                length * (xi - 2.0 * xi**2 + xi**3),
                3.0 * xi**2 - 2.0 * xi**3,
                length * (xi**3 - xi**2),
            ]
        )  # weights of value and slope at the first node of the element, then at the second

        def under(values: FloatArray) -> FloatArray:
            ends = np.concatenate([values[first], values[(first + 1) % nodes]], axis=1)
            return np.asarray(np.einsum("kt,tk...->t...", weights, ends))

        clearance = under(self._problem.clearance(n * self._dt))
        return under(casing.nodal[:, :2]), under(casing.nodal[:, 2:]), clearance

    def _bend(self, state: ReferenceState, x: FloatArray) -> Bent:
        """Return the openings of the gaps by foreshortening, for predicted displacements x."""
        n, m, tips = state.step, state.step + 1, len(state.gap)
        bend, until, checked = state.bend.copy(), state.until.copy(), state.checked
        gradient, bending = np.zeros((tips, len(x))), self._problem.foreshortening
        if bending is None:
            return Bent(bend, until, checked, gradient, np.zeros(tips))
        rows, sign, modes = bending.rows, bending.sign, self._rotor_modes
        moved = state.now - state.before
        check = self._unchecked
        if n % check == 0:
            now, later = bending.opening(state.now[:modes]), check * moved[:modes]
            if n == 0:
                earlier = [bending.opening(state.now[:modes] - each * later) for each in (1, 2)]
                checked = np.array([now, now - earlier[0], now - 2.0 * earlier[0] + earlier[1]])
            else:
                checked = np.array([now, now - checked[0], now - checked[0] - checked[1]])
        part = (m - n // check * check) / check
        start = checked[0] + part * checked[1] + 0.5 * part * (part + 1.0) * checked[2]
        start = np.maximum(start, 0.0)
        normal, _, clearance = self._rows(x, m)
        fresh = (clearance + normal @ x < self._near) & (until < m)
        until[fresh] = (m // self._held + 1) * self._held - 1.0
        for tip in np.flatnonzero(until >= m):
            if fresh[tip]:
                bend[tip] = rows[tip] @ (x + 0.5 * (until[tip] - m) * moved)[:modes]
            gradient[tip, :modes] = (sign[tip] * bend[tip]) @ rows[tip]
            start[tip] = -0.5 * (sign[tip] * bend[tip] ** 2).sum()
        return Bent(bend, until, checked, gradient, start)

    def _solve(
        self,
        free_gap: FloatArray,
        delassus: FloatArray,
        x: FloatArray,
        n: int,
        strain: FloatArray,
    ) -> tuple[FloatArray, Coated]:
        """Return the forces of the metal on the tips, and the coating, at step n.

        The forces of the rods in the complementarity problem are linearised again and again.

        Raises:
            ArithmeticError: the linearisations do not converge.
        """
        none = np.zeros_like(free_gap)
        if self._problem.coating is None:
            return complementary(free_gap, delassus), Coated(strain, none, none, 0.0)
        under = self._rods(x, n)
        gap, last, share = free_gap.copy(), np.inf, 1.0
        scale = max(self._problem.casing.clearance[:, 0].min(), np.abs(free_gap).max())
        for _ in range(400):
            coated = self._press(np.maximum(gap, 0.0), under, strain)
            linear = np.linalg.inv(np.eye(len(gap)) + delassus * coated.slope)
            known = linear @ (
                free_gap + delassus @ (coated.force + coated.slope * np.maximum(gap, 0.0))
            )
            multiplier = complementary(known, linear @ delassus)
            step = known + linear @ delassus @ multiplier - gap
            change = np.abs(step).max()
            if change <= 1e-15 * scale:
                return multiplier, coated
            share = 1.0 if change < 0.5 * last else max(0.5 * share, 0.125)
            gap, last = gap + share * step, change
        raise ArithmeticError("the forces of the coating do not converge")

    def _rods(self, x: FloatArray, n: int) -> list[tuple[FloatArray, FloatArray]]:
        """Return the rods under each tip at displacements x at step n, and the wall at each of them
        less the wall at the tip [m]."""
        problem, rotor, coating = self._problem, self._problem.rotor, self._problem.coating
        assert coating is not None
        angle = rotor.tip_angle + problem.angle_at(n * self._dt)
        if problem.tip_rotation:
            angle = angle + rotor.tip_tangential @ x[: self._rotor_modes] / rotor.tip_radius
        rods, found = coating.strain.shape[1], []
        radial, _, clearance = self._wall_rows(angle, n)
        here = clearance + radial @ x[self._rotor_modes :]
        for tip, place in enumerate(np.mod(angle, 2.0 * np.pi) * rods / (2.0 * np.pi)):
            half = coating.footprint[tip] / coating.arc / 2.0
            first, last = np.ceil(place - half - 0.5), np.floor(place + half - 0.5)
            under = np.arange(int(first), int(last) + 1) % rods
            radial, _, clearance = self._wall_rows(rod_angles(rods)[under], n)
            found.append((under, clearance + radial @ x[self._rotor_modes :] - here[tip]))
        return found

    def _press(
        self, gap: FloatArray, under: list[tuple[FloatArray, FloatArray]], strain: FloatArray
    ) -> Coated:
        """Press the tips at gaps to the metal into the rods under them, see `_rods`."""
        coating = self._problem.coating
        assert coating is not None
        strain, stored = strain.copy(), 0.0
        young, hardening, area = (
            coating.young_modulus,
            coating.hardening,
            coating.arc * coating.width[0],
        )
        force, slope = np.zeros_like(gap), np.zeros_like(gap)
        for tip, (rods, offset) in enumerate(under):
            worn = strain[0, rods]
            depth = coating.removable - gap[tip] - offset
            stress = young * (depth / coating.thickness - worn)
            grown = np.maximum(stress - coating.yield_stress - hardening * worn, 0.0)
            grown = np.where(stress > 0.0, grown / (young + hardening), 0.0)
            most = np.maximum(coating.limit - worn, 0.0)
            yields = (grown > 0.0) & (grown <= most)
            grown = np.minimum(grown, most)
            rate = np.where(yields, young * hardening / (young + hardening), young)
            slope[tip] = area / coating.thickness * (rate * (stress > 0.0)).sum()
            stress = np.maximum(stress - young * grown, 0.0)
            strain[0, rods] = worn + grown
            stored += float(0.5 * area * coating.thickness * (stress**2).sum() / young)
            force[tip] = area * stress.sum()
        return Coated(strain, force, slope, stored)

    def _gap(self, x: FloatArray, n: int) -> FloatArray:
        """Return the gap of each tip at step n [m], (tips,)."""
        normal, _, clearance = self._rows(x, n)
        bending = self._problem.foreshortening
        opened = 0.0 if bending is None else bending.opening(x[: self._rotor_modes])
        return clearance + normal @ x + opened

    def _sliding(self, tangential: FloatArray, moved: FloatArray, n: int) -> FloatArray:
        """Return the sign of the sliding velocity of each tip at step n, from the speed at this
        step and the motion in the last but one, (tips,)."""
        problem = self._problem
        turning = problem.speed_at(n * self._dt)
        speed = np.full(len(tangential), turning)
        if problem.sliding == "signed":
            # The product of the tangential rows and a forward motion of a blade is negative.
            speed = problem.rotor.tip_radius * turning - tangential @ moved / self._dt
        return np.asarray(np.sign(speed))

    def _keeps_limit(self, x: FloatArray, n: int) -> bool:
        """Return whether all displacements at step n are within the limit."""
        rotor, limit = self._problem.rotor, self._problem.displacement_limit
        disk, casing = np.split(x, [self._rotor_modes])
        looked_at = [rotor.tip_radial @ disk]
        if n % CHECK_EVERY == 0:
            looked_at += [rotor.tip_tangential @ disk, self._problem.casing.nodal[:, 0] @ casing]
        return bool(np.all(np.abs(np.concatenate(looked_at)) <= limit))  # NaN gives False

    def _chunk(
        self, records: list[tuple[ReferenceState, FloatArray, float]], after: ReferenceState
    ) -> Chunk:
        states = [state for state, _, _ in records]
        modes, tips = len(self._stiffness), len(self._problem.rotor.tip_angle)
        step = np.array([state.step for state in states], dtype=np.int64)
        x = np.reshape([state.now for state in states], (len(states), modes))
        v = np.reshape([velocity for _, velocity, _ in records], (len(states), modes))
        gap, impulse, drag, touched = (
            np.reshape([getattr(state, name) for state in states], (len(states), tips))
            for name in ("gap", "impulse", "drag", "touched")
        )
        work = np.reshape([state.work for state in states], (len(states), 6))
        return Chunk(
            step=step,
            time=np.asarray(step * self._dt, dtype=np.float64),
            rotor_displacement=x[:, : self._rotor_modes],
            rotor_velocity=v[:, : self._rotor_modes],
            casing_displacement=x[:, self._rotor_modes :],
            casing_velocity=v[:, self._rotor_modes :],
            gap=gap,
            contact_impulse=impulse,
            friction_impulse=drag,
            contact_steps=touched.astype(np.int64),
            contacts=np.array([state.contacts for state in states], dtype=np.int64),
            **self._rotations(step),
            energy=np.array([energy for _, _, energy in records]),
            external_work=work[:, 0],
            normal_work=work[:, 1],
            friction_work=work[:, 2],
            damping_work=work[:, 3],
            coupling_work=work[:, 4],
            closing_work=work[:, 5],
            coating=self._coating_records(states, after),
        )

    def _rotations(self, step: IntArray) -> dict[str, FloatArray]:
        """Return angle and speed at recorded steps if the speed varies."""
        if self._problem.change is None:
            return {}
        course, time = self._problem.change.course, step * self._dt
        return {"rotation_angle": course.angle(time), "rotation_speed": course.speed(time)}

    def _coating_records(
        self, states: list[ReferenceState], after: ReferenceState
    ) -> CoatingRecords | None:
        coating = self._problem.coating
        if coating is None:
            return None
        first = coating.strain[0]
        strain = np.reshape([state.strain[0] for state in states], (len(states), len(first)))
        volume = coating.arc * coating.width[0] * coating.thickness
        plastic = coating.yield_stress * (strain - first)
        plastic += 0.5 * coating.hardening * (strain**2 - first**2)
        impulse = [state.coating_impulse for state in states]
        return CoatingRecords(
            coating_impulse=np.reshape(impulse, (len(states), len(after.gap))),
            wear_volume=volume * (strain - first).sum(axis=1),
            wear_dissipated=volume * plastic.sum(axis=1),
            coating_energy=np.array([state.stored for state in states]),
            wear_time=np.array([after.step * self._dt]),
            coating_strain=after.strain[None],
        )
