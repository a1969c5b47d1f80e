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
rotor includes Coriolis forces and point dampers. At a speed that varies K and the loads are those
of the speed at n. A is kept for `REFRESH` steps; the Coriolis forces of the rest of the speed have
the velocity of the last step. A free speed follows from the angular momentum; energies and works
are then not those of the kernel.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import scipy.linalg as la

from bladewhirl.meshes.hermite import cubic_weights, slope_weights
from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.varying_speed import Rotation
from bladewhirl.models.stage.wall_coating import rod_angles
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

REFRESH = 256
"""Number of steps in which A is that of one speed: a prescribed one in their middle, or a free one
half a step before the first."""


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


class Driven(NamedTuple):
    """Free speed before step n."""

    turned: tuple[Rotation, Rotation]  #: rotation at n - 1 and as expected at n
    half: float  #: speed at n - 1/2 [rad/s]
    centre: float  #: speed of A [rad/s]
    momentum: float  #: angular momentum at n - 1/2, with the impulse of contact up to n [N m s]


class Step(NamedTuple):
    """Results of a step: displacements, contact forces and modal forces, (modes,)."""

    after: FloatArray  #: displacements x_{n+1}, (modes,)
    gap: FloatArray  #: gap of each tip at x_{n+1} [m], (tips,)
    multiplier: FloatArray  #: normal contact force lambda [N], (tips,)
    friction: FloatArray  #: friction force mu s (lambda + F) [N], (tips,)
    force: FloatArray  #: modal loads f_n
    pressed: FloatArray  #: modal normal forces
    dragged: FloatArray  #: modal friction forces
    circulated: FloatArray
    """Modal forces of dampers in the static frame due to x_n, and of a change of the speed."""
    damped: FloatArray  #: modal forces of point dampers and Coriolis forces
    coating: Coated  #: forces and state of the coating
    bent: Bent  #: foreshortening
    driven: Driven | None  #: free speed
    held: ComplexArray  #: forces of the bearings on the rotor, static axes [N], (bearings,)
    dragging: ComplexArray  #: part of their dampers
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
    driven: Driven | None  #: free speed
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
        self._at_base, self._coriolis = self._felt, np.zeros_like(self._felt)
        change, modes = problem.change, slice(self._rotor_modes)
        if change is not None and change.rotor is not None:
            self._coriolis[modes, modes] = change.rotor.coriolis
        self._turned = dict[float, Rotation]()
        self._set_speed(problem.speed)
        self._near = near_gap(problem)
        self._held, self._unchecked = held_steps(problem, dt)

    def _turn(self, n: int, driven: Driven | None) -> None:
        """Set what depends on the speed at step n."""
        if driven is not None:
            self._turned = dict(zip((n - 1.0, float(n)), driven.turned, strict=True))
            self._set_speed(driven.centre)
        elif self._problem.change is not None:
            middle = n // REFRESH * REFRESH + 0.5 * REFRESH
            self._set_speed(self._problem.speed_at(middle * self._dt))

    def _set_speed(self, centre: float) -> None:
        """Set A at a speed [rad/s]."""
        dt, self._centre = self._dt, centre
        self._felt = self._at_base + 2.0 * (centre - self._problem.speed) * self._coriolis
        self._by_velocity = self._felt + self._late
        inertia = np.diag(1.0 / dt**2 + self._damping / (2.0 * dt))
        self._inverse = np.linalg.inv(inertia + self._by_velocity / (2.0 * dt))
        self._compliance = np.linalg.inv(inertia + self._felt / (2.0 * dt))

    def _rotation(self, n: float) -> Rotation:
        """Return the rotation at step n."""
        return self._turned.get(n) or self._problem.rotation_at(n * self._dt)

    def init(self) -> ReferenceState:
        """Return the state at t = 0; x_{-1} follows from the initial velocity and acceleration."""
        start, dt = self._problem.start, self._dt
        x = np.concatenate([start.rotor, start.casing])
        v = np.concatenate([start.rotor_velocity, start.casing_velocity])
        lost = self._damping * v + self._by_velocity @ v
        drive, change, modes = self._problem.drive, self._problem.change, self._rotor_modes
        turned, driven = self._problem.rotation_at(0.0), None
        if drive is not None:
            turned = turned._replace(acceleration=0.0)
            self._turned = {0.0: turned}
        force = self._force(0) + self._turning(0, x, dt * v)
        acceleration = force - lost - self._stiffness * x - self._spring_force(0, x)
        spun, bearings = 0.0, self._problem.bearings
        if bearings is not None:
            bodies = (start.rotor, start.rotor_velocity), (start.casing, start.casing_velocity)
            held = bearings.force(turned.angle, turned.speed, *bodies)
            acceleration = acceleration + np.concatenate(bearings.pulls(turned.angle, held))
            spun = bearings.torque(turned.angle, start.rotor, held)
        if drive is not None:
            assert change is not None
            centre, motion = self._problem.rotor.centre, (x[:modes], v[:modes])
            torque, rate, further = drive.acceleration(
                turned.speed, change, centre, (*motion, acceleration[:modes]), spun
            )
            acceleration[:modes] += further
            angle = turned.angle - dt * turned.speed + 0.5 * dt**2 * rate
            earlier = Rotation(angle, turned.speed - dt * rate, rate)
            half = turned.speed - 0.5 * dt * rate
            momentum = drive.momentum(turned.speed, change, *motion) - 0.5 * dt * torque
            turned = turned._replace(acceleration=rate)
            driven = Driven((earlier, turned), half, half, momentum)
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
            driven=driven,
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
            if self._fuses(state.now):
                return state, self._chunk(records, state), EndReason.FUSED
        return state, self._chunk(records, state), None

    def _step(self, state: ReferenceState) -> Step:
        """Return the results of one step: predict, look, solve, correct."""
        dt, n, x, before = self._dt, state.step, state.now, state.before
        self._turn(n, state.driven)
        force, circulated = self._force(n), self._turning(n, x, x - before)
        restoring = self._stiffness * x + self._spring_force(n, x)
        inertia = 2.0 / dt**2 * x + (self._damping / (2.0 * dt) - 1.0 / dt**2) * before
        drag = self._by_velocity @ before / (2.0 * dt)
        free = self._inverse @ (force + circulated - restoring + inertia + drag)
        predicted = free
        free, held, done = self._bearings(state, free)
        free, driven = self._drive(state, free, held)
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
        late = self._late @ (predicted - before)
        damped = (self._felt @ (after - before) + late) / (2.0 * dt)
        if driven is not None:
            torque = force_on_tips @ self._wall_slope(after, free, n + 1)
            torque -= self._problem.rotor.tip_radius * (force_on_tips @ slides)
            driven = driven._replace(momentum=driven.momentum + dt * float(torque))
        gap = clearance + normal @ after
        smaller = np.minimum(gap, np.diag(delassus) * multiplier)
        violated = np.where(multiplier > 0.0, np.abs(smaller), np.maximum(-gap, 0.0))
        scale = max(self._problem.casing.clearance[:, 0].min(), np.abs(free_gap).max(initial=0.0))
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
            driven=driven,
            held=held,
            dragging=done,
            residual=float(violated.max() / scale) if force_on_tips.any() and scale > 0.0 else 0.0,
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
        if self._problem.bearings is not None:
            rate = self._moves(n, x, step.after - before)
            dragged = -dt * float((step.dragging.conj() * rate).real.sum())
            rows = self._ends(n)
            turning += float((step.held.conj() * (rows @ moved)).real.sum()) + dragged
            turning += self._stored(n + 1, x, step.after) - self._stored(n, before, x)
            done[3] += dragged
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
            driven=step.driven,
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
        stored = self._stored(state.step, state.before, state.now)
        return float(0.5 * v @ v + 0.5 * state.before @ restoring) + stored

    def _ends(self, n: float) -> ComplexArray:
        """Return the displacement of the rotor relative to its supports, static axes, as rows on
        all modes at step n, (bearings, modes)."""
        bearings = self._problem.bearings
        assert bearings is not None
        return np.hstack([bearings.rotor * np.exp(1j * self._rotation(n).angle), -bearings.support])

    def _stored(self, n: int, before: FloatArray, x: FloatArray) -> float:
        """Return the energy of the springs of the bearings half a step before n [J]."""
        bearings = self._problem.bearings
        if bearings is None:
            return 0.0
        first, second = self._ends(n - 1) @ before, self._ends(n) @ x
        pull = bearings.stiffness[:, 0].real * second + bearings.stiffness[:, 1] * second.conj()
        return float(0.5 * (first.conj() * pull).real.sum())

    def _moves(self, n: int, x: FloatArray, change: FloatArray) -> ComplexArray:
        """Return the velocity of the rotor relative to its supports at step n, for the change of
        the displacements in two steps, static axes [m/s], (bearings,)."""
        rows, modes = self._ends(n), self._rotor_modes
        speed = self._rotation(n).speed
        carried = 1j * speed * rows[:, :modes] @ x[:modes]
        return np.asarray(rows @ change / (2.0 * self._dt) + carried)

    def _bearings(
        self, state: ReferenceState, free: FloatArray
    ) -> tuple[FloatArray, ComplexArray, ComplexArray]:
        """Return the displacements x_{n+1} with the forces of the bearings, from those without,
        these forces on the rotor in static axes and the part of their dampers, (bearings,)."""
        bearings, n, x, before = self._problem.bearings, state.step, state.now, state.before
        if bearings is None:
            none = np.zeros(0, dtype=np.complex128)
            return free, none, none
        rows = self._ends(n)
        answer = self._compliance @ np.hstack([rows.real.T, rows.imag.T])
        size = len(rows)

        def drag(after: FloatArray) -> ComplexArray:
            rate = self._moves(n, x, after - before)
            c0, c2 = bearings.damping.T
            return np.asarray(-(c0 * rate + c2 * rate.conj()))

        def forces(after: FloatArray) -> FloatArray:
            moved = rows @ x
            k0, k2 = bearings.stiffness.T
            whole = drag(after) - (k0 * moved + k2 * moved.conj())
            return np.concatenate([whole.real, whole.imag])

        known = forces(free)
        changes = np.array([forces(free + answer[:, k]) - known for k in range(2 * size)]).T
        found = np.linalg.solve(np.eye(2 * size) - changes, known)
        after = free + answer @ found
        return after, found[:size] + 1j * found[size:], drag(after)

    def _force(self, n: float) -> FloatArray:
        """Return the modal forces of the loads at step n, (modes,)."""
        total, problem = np.zeros(len(self._stiffness)), self._problem
        turned = self._rotation(n)
        for load in problem.loads:
            factor = load_factor(load, n * self._dt)
            if problem.change is not None:
                factor = load.amplitude(n * self._dt, turned, problem.speed)
            total += factor * np.concatenate([load.rotor, load.casing])
        return total

    def _turning(self, n: float, x: FloatArray, moved: FloatArray) -> FloatArray:
        """Return the modal forces of dampers in the static frame due to displacements x, and of a
        change of the speed, for the last change of the displacements, (modes,)."""
        rotor, turned = self._problem.rotor, self._rotation(n)
        share = 1.0 if self._problem.change is None else turned.speed / (self._problem.speed or 1.0)
        skew = share * rotor.circulation * np.array([[0.0, 1.0], [-1.0, 0.0]])
        force = rotor.centre.T @ (skew @ (rotor.centre @ x[: self._rotor_modes]))
        late = 2.0 * (turned.speed - self._centre) / self._dt
        further = self._coriolis @ (turned.acceleration * x + late * moved)
        still = np.zeros(len(x) - self._rotor_modes)
        return np.asarray(np.concatenate([force, still]) - further)

    def _spring_force(self, n: float, x: FloatArray) -> FloatArray:
        """Return K*_n x of the coupling springs, of unequal static shaft springs and of the change
        of the speed, (modes,)."""
        problem, modes = self._problem, self._rotor_modes
        turned, force = self._rotation(n), np.zeros_like(x)
        if problem.change is not None and problem.change.rotor is not None:
            force[:modes] = problem.change.rotor.change(turned.speed) @ x[:modes]
        if problem.springs is None and problem.rotor.anisotropy == 0.0:
            return force
        return np.asarray(force + problem.spring_stiffness(turned.angle) @ x)

    def _drive(
        self, state: ReferenceState, predicted: FloatArray, held: ComplexArray
    ) -> tuple[FloatArray, Driven | None]:
        """Return the displacements x_{n+1} without contact with the acceleration of a free speed,
        from the predicted ones with the last acceleration, and the speed that follows.

        The angular momentum at n + 1/2 is that of `solvers/kernel/drive.h`.
        """
        drive, change, old = self._problem.drive, self._problem.change, state.driven
        if drive is None or change is None or old is None:
            return predicted, None
        dt, modes, x = self._dt, self._rotor_modes, state.now
        pull, coupled, along, across = (np.zeros_like(x) for _ in range(4))
        if change.rotor is not None:
            along[:modes], across[:modes] = drive.along, drive.across
            pull[:modes] = drive.along - change.rotor.known("stiffness_speed") @ x[:modes]
            coupled = across + self._coriolis @ x
        now = old.turned[1]
        rows = self._problem.rotor.centre
        place, later, before = (rows @ each[:modes] for each in (x, predicted, state.before))
        velocity = (later - before) / (2.0 * dt)
        swept = place[0] * velocity[1] - place[1] * velocity[0] + now.speed * place @ place
        torque = drive.torque - drive.loss * now.speed - drive.damping * swept
        if self._problem.bearings is not None:
            torque += self._problem.bearings.torque(now.angle, x[:modes], held)
        momentum = old.momentum + dt * torque

        # The momentum is quadratic in the change of the acceleration, on which x_{n+1} depends
        # linearly.
        half, by_change = old.half + dt * now.acceleration, dt**2 * (dt * old.half * pull - coupled)
        free = predicted + dt**2 * (old.half * half - now.speed**2) * pull
        inertia, more = drive.inertia + along @ x + pull @ free, pull @ by_change
        lacking = momentum - half * inertia - (coupled @ free - across @ x) / dt
        rise = dt * inertia + half * more + coupled @ by_change / dt
        change_of_rate = 2.0 * lacking / (rise + np.sqrt(rise**2 + 4.0 * dt * more * lacking))
        rate = float(now.acceleration + change_of_rate)
        half = old.half + dt * rate
        after = Rotation(now.angle + dt * half, half + 0.5 * dt * rate, rate)
        self._turned[state.step + 1.0] = after
        centre = half if (state.step + 1) % REFRESH == 0 else old.centre
        return free + change_of_rate * by_change, Driven((now, after), half, centre, momentum)

    def _rows(self, x: FloatArray, n: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return B_N and B_T of the tips at step n, (tips, modes), and clearance plus
        `metal_recess`, (tips,).

        With `tip_rotation`, the angles of the tips include their tangential displacements in ``x``.
        """
        problem, rotor = self._problem, self._problem.rotor
        radial, along, clearance = self._wall_rows(self._angle(x, n), n)
        normal = np.hstack([-rotor.tip_radial, radial])
        tangential = np.hstack([-rotor.tip_tangential, along])
        return normal, tangential, clearance + problem.metal_recess

    def _angle(self, x: FloatArray, n: float) -> FloatArray:
        """Return the angles of the tips at step n, (tips,)."""
        rotor = self._problem.rotor
        angle = rotor.tip_angle + self._rotation(n).angle
        if self._problem.tip_rotation:
            angle = angle + rotor.tip_tangential @ x[: self._rotor_modes] / rotor.tip_radius
        return angle

    def _wall_slope(self, x: FloatArray, seen: FloatArray, n: int) -> FloatArray:
        """Return the change of the radius of the wall by the angle at the tips [m], (tips,)."""
        radial, _, clearance = self._wall_rows(self._angle(seen, n), n, slope_weights)
        slope = clearance + radial @ x[self._rotor_modes :]
        return np.asarray(self._problem.casing.radius * slope)

    def _wall_rows(
        self, angle: FloatArray, n: float, cubics: Callable[..., FloatArray] = cubic_weights
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return w and u of the casing modes at angles, (angles, modes), and the clearance at step
        n, (angles,)."""
        casing, wall = self._problem.casing, self._problem.rotor.wall
        nodes, length = casing.elements, casing.element_length
        at = np.mod(angle * nodes / (2.0 * np.pi), nodes)
        element = np.floor(at).astype(np.int64) % nodes
        start = nodes * (wall if wall.size else 0)
        first, second = start + element, start + (element + 1) % nodes
        weights = cubics(at - np.floor(at), length)

        def under(values: FloatArray) -> FloatArray:
            ends = np.concatenate([values[first], values[second]], axis=1)
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
        coating = self._problem.coating
        assert coating is not None
        angle = self._angle(x, n)
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
        """Press the tips at gaps to the metal into the rods under them, see `_rods`.

        Raises:
            ArithmeticError: two tips press the same rod, and the first one wears it.
        """
        coating = self._problem.coating
        assert coating is not None
        before, strain, stored = strain, strain.copy(), 0.0
        young, hardening, area = (
            coating.young_modulus,
            coating.hardening,
            coating.arc * coating.width[0],
        )
        force, slope = np.zeros_like(gap), np.zeros_like(gap)
        for tip, (rods, offset) in enumerate(under):
            worn = strain[0, rods]
            if (worn != before[0, rods]).any():
                raise ArithmeticError("two tips wear the same rod")
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
        turning = self._rotation(n).speed
        speed = np.full(len(tangential), turning)
        if problem.sliding == "signed":
            # The product of the tangential rows and a forward motion of a blade is negative.
            speed = problem.rotor.tip_radius * turning - tangential @ moved / self._dt
        return np.asarray(np.sign(speed))

    def _fuses(self, x: FloatArray) -> bool:
        """Return whether the force in the springs at the centre is above its limit."""
        fuse = self._problem.fuse
        if fuse is None:
            return False
        return bool(np.hypot(*(fuse.constant + fuse.force @ x[: self._rotor_modes])) > fuse.limit)

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
            **self._rotations(states),
            energy=np.array([energy for _, _, energy in records]),
            external_work=work[:, 0],
            normal_work=work[:, 1],
            friction_work=work[:, 2],
            damping_work=work[:, 3],
            coupling_work=work[:, 4],
            closing_work=work[:, 5],
            coating=self._coating_records(states, after),
        )

    def _rotations(self, states: list[ReferenceState]) -> dict[str, FloatArray]:
        """Return angle, speed and angular momentum at recorded steps as far as they vary."""
        if self._problem.change is None:
            return {}
        free = [state.driven for state in states if state.driven is not None]
        if self._problem.drive is not None:
            turned = [each.turned[1] for each in free]
        else:
            turned = [self._rotation(state.step) for state in states]
        angle, speed, _ = np.reshape(turned, (-1, 3)).T
        momentum = np.array([each.momentum for each in free])
        return {"rotation_angle": angle, "rotation_speed": speed, "angular_momentum": momentum}

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
