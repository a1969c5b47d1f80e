"""Central differences with forward-increment Lagrange multipliers, as a scheme of the march."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bladewhirl.meshes.hermite import cubic_weights
from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.solvers.kernel import arrays as kernel_arrays
from bladewhirl.solvers.kernel.binding import march, number, struct
from bladewhirl.solvers.march.march import Chunk, EndReason, Statistics, check_time_step
from bladewhirl.solvers.packing.arrangement import aligned_copy
from bladewhirl.solvers.packing.casing import pack_casing
from bladewhirl.solvers.packing.rotor import pack_rotor
from bladewhirl.solvers.packing.scratch import make_scratch
from bladewhirl.solvers.packing.supports import pack_dampers, pack_springs
from bladewhirl.solvers.packing.turning import pack_gyroscopic


@dataclass(frozen=True, kw_only=True)
class CentralDifferenceState:
    """State between two steps: x_{n-1}, x_n and what has been summed up since the last record."""

    step: int  #: n
    arrays: kernel_arrays.State

    @property
    def statistics(self) -> Statistics:
        """Quality so far."""
        count = self.arrays.counts
        return Statistics(
            steps=self.step,
            contact_steps=int(count[kernel_arrays.CONTACT_STEPS]),
            complementarity_residual=float(self.arrays.residual[0]),
            pivots=int(count[kernel_arrays.LCP_PIVOTS]),
            lcp_failures=int(count[kernel_arrays.LCP_FAILURES]),
        )


class CentralDifference:
    """The scheme of Carpenter, Taylor and Katona (1991) with damping and sliding friction.

    Second order without contact; contact holds at the end of each step. The complementarity
    residual of a step is max_j |min(g_j, W_jj lambda_j)| / max(clearance, max_j |g_p,j|), with the
    gaps g computed anew from the corrected displacements.

    Args:
        problem: what to march.
        time_step: [s]
        record_every: steps between records.
        cyclic: use the harmonics of a cyclic stage where it has them; False marches any stage by
            dense products.

    Raises:
        ValueError: a time step at or above the critical one.
    """

    def __init__(
        self, problem: ContactProblem, time_step: float, record_every: int, *, cyclic: bool = True
    ) -> None:
        check_time_step(problem, time_step)
        self._problem, self._time_step, self._record_every = problem, time_step, record_every
        self.cyclic = (
            cyclic and problem.rotor.by_harmonics,
            cyclic and problem.casing.by_harmonics,
        )
        rotor, self._rotor = pack_rotor(problem, time_step, cyclic=self.cyclic[0])
        casing, self._casing = pack_casing(problem, time_step, cyclic=self.cyclic[1])
        self._arrangements = rotor, casing
        bodies = self._rotor.body, self._casing.body
        self._dampers = pack_dampers(problem, bodies, self._arrangements, time_step)
        self._springs = pack_springs(problem, self._arrangements, time_step)
        gyroscopic = pack_gyroscopic(problem, self._rotor, rotor, time_step)
        signed = problem.sliding == "signed"
        wheel_speed = problem.rotor.tip_radius * problem.speed if signed else None
        self._stage = (
            *map(struct, (self._rotor, self._casing)),
            *map(struct, (self._springs, self._dampers, gyroscopic)),
            number(wheel_speed),
            struct(_numbers(problem, time_step)),
        )

    def init(self) -> CentralDifferenceState:
        """State at t = 0; x_{-1} is consistent with initial velocity and acceleration."""
        problem, start, dt = self._problem, self._problem.start, self._time_step
        amplitudes = np.array(
            [np.cos(load.phase) * (load.ramp <= 0.0) * (load.end > 0.0) for load in problem.loads]
        )
        pulls = initial_spring_forces(problem)
        turning = problem.rotor.turning_force(start.rotor, start.rotor_velocity)
        slots = []
        for body, loads, arrangement, x, v, pull in (
            (
                problem.rotor,
                [load.rotor for load in problem.loads],
                self._arrangements[0],
                start.rotor,
                start.rotor_velocity,
                pulls[0] + turning,
            ),
            (
                problem.casing,
                [load.casing for load in problem.loads],
                self._arrangements[1],
                start.casing,
                start.casing_velocity,
                pulls[1],
            ),
        ):
            force = amplitudes @ np.reshape(loads, (len(loads), len(x))) + pull
            frequency = np.abs(body.frequency)
            drag = 2.0 * body.damping_ratio * frequency * v + body.dampers.T @ (body.dampers @ v)
            acceleration = force - body.frequency * frequency * x - drag
            before = x - dt * v + 0.5 * dt**2 * acceleration
            slots.append(arrangement.pack(np.array([before, x, np.zeros_like(x)])))
        tips = len(problem.rotor.tip_angle)
        return CentralDifferenceState(
            step=0,
            arrays=kernel_arrays.State(
                rotor=slots[0],
                casing=slots[1],
                gap=initial_gap(problem),
                impulse=np.zeros(tips),
                drag=np.zeros(tips),
                touched=np.zeros(tips),
                held=np.zeros(tips),
                work=np.zeros(kernel_arrays.WORKS),
                residual=np.zeros(1),
                counts=np.zeros(4),
            ),
        )

    def advance(
        self, state: CentralDifferenceState, steps: int, record_every: int | None = None
    ) -> tuple[CentralDifferenceState, Chunk, EndReason | None]:
        """Advance by a number of steps, recording at multiples of ``record_every`` (its own if
        None).

        The state given stays as it was.
        """
        every = self._record_every if record_every is None else record_every
        arrays = kernel_arrays.State(*(aligned_copy(array) for array in state.arrays))
        records = self._make_records(steps // every + 2)
        scratch = make_scratch(
            self._rotor, self._casing, self._arrangements, self._springs, self._dampers
        )
        status, reached, written = march(
            self._stage,
            struct(arrays),
            struct(records),
            struct(scratch),
            state.step,
            steps,
            every,
        )
        end = EndReason.DIVERGENT if status == kernel_arrays.DIVERGED else None
        after = CentralDifferenceState(step=reached, arrays=arrays)
        return after, self._chunk(records, written), end

    def _make_records(self, count: int) -> kernel_arrays.Records:
        tips = len(self._problem.rotor.tip_angle)
        rotor, casing = self._arrangements
        return kernel_arrays.Records(
            step=np.zeros(count, dtype=np.int64),
            rotor=np.zeros((count, rotor.entries)),
            rotor_velocity=np.zeros((count, rotor.entries)),
            casing=np.zeros((count, casing.entries)),
            casing_velocity=np.zeros((count, casing.entries)),
            gap=np.zeros((count, tips)),
            impulse=np.zeros((count, tips)),
            drag=np.zeros((count, tips)),
            touched=np.zeros((count, tips)),
            contacts=np.zeros(count),
            energy=np.zeros(count),
            work=np.zeros((count, kernel_arrays.WORKS)),
        )

    def _chunk(self, records: kernel_arrays.Records, written: int) -> Chunk:
        kept = kernel_arrays.Records(*(array[:written] for array in records))
        rotor, casing = self._arrangements
        return Chunk(
            step=kept.step,
            time=kept.step * self._time_step,
            rotor_displacement=rotor.unpack(kept.rotor),
            rotor_velocity=rotor.unpack(kept.rotor_velocity),
            casing_displacement=casing.unpack(kept.casing),
            casing_velocity=casing.unpack(kept.casing_velocity),
            gap=kept.gap,
            contact_impulse=kept.impulse,
            friction_impulse=kept.drag,
            contact_steps=kept.touched.astype(np.int64),
            contacts=kept.contacts.astype(np.int64),
            energy=kept.energy,
            external_work=kept.work[:, kernel_arrays.EXTERNAL],
            normal_work=kept.work[:, kernel_arrays.NORMAL],
            friction_work=kept.work[:, kernel_arrays.FRICTION],
            damping_work=kept.work[:, kernel_arrays.DAMPING],
            coupling_work=kept.work[:, kernel_arrays.PARAMETRIC],
        )


def initial_gap(problem: ContactProblem) -> FloatArray:
    """Gap of each tip at t = 0 [m], (tips,), by the casing's Hermite interpolation."""
    casing, rotor, start = problem.casing, problem.rotor, problem.start
    nodes = len(casing.nodal)
    position = np.mod(rotor.tip_angle * nodes / (2.0 * np.pi), nodes)
    if problem.tip_rotation:
        turn = rotor.tip_tangential @ start.rotor / rotor.tip_radius
        position = np.mod(position + turn * nodes / (2.0 * np.pi), nodes)
    element = position.astype(np.int64) % nodes
    xi = position - np.floor(position)
    field = casing.nodal[:, :2] @ start.casing + casing.clearance
    first, second = field[element], field[(element + 1) % nodes]
    at = cubic_weights(xi, casing.element_length)
    surface = (
        at[0] * first[:, 0] + at[1] * first[:, 1] + at[2] * second[:, 0] + at[3] * second[:, 1]
    )
    return np.asarray(surface + rotor.tip_recess - rotor.tip_radial @ start.rotor)


def initial_spring_forces(problem: ContactProblem) -> tuple[FloatArray, FloatArray]:
    """Forces at t = 0, on the modes of rotor and casing, of the springs that turn with neither."""
    start, springs = problem.start, problem.springs
    rotor, casing = np.zeros_like(start.rotor), np.zeros_like(start.casing)
    if springs is not None:
        on_rotor, rotor_modes = springs.coordinates(on_casing=False)
        on_casing, casing_modes = springs.coordinates(on_casing=True)
        moved = np.zeros(springs.modes.size)
        moved[on_rotor], moved[on_casing] = start.rotor[rotor_modes], start.casing[casing_modes]
        force = -springs.stiffness(angle=0.0) @ moved
        rotor[rotor_modes], casing[casing_modes] = force[on_rotor], force[on_casing]
    centre = problem.rotor.centre
    swing = problem.rotor.anisotropy * np.array([-1.0, 1.0])
    return rotor + (swing * (centre @ start.rotor)) @ centre, casing


def _numbers(problem: ContactProblem, dt: float) -> kernel_arrays.Numbers:
    rotor, casing = problem.rotor, problem.casing
    per_radian = len(casing.nodal) / (2.0 * np.pi)
    loads = [[load.end, load.ramp, load.frequency, load.phase] for load in problem.loads]
    return kernel_arrays.Numbers(
        time_step=dt,
        elements_per_step=problem.speed * dt * per_radian,
        friction=problem.friction,
        sliding=float(np.sign(problem.speed)),
        elements_per_metre=per_radian / rotor.tip_radius if problem.tip_rotation else 0.0,
        displacement_limit=problem.displacement_limit,
        gap_scale=float(casing.clearance[:, 0].min()),
        loads=np.array(loads, dtype=np.float64).reshape(len(loads), 4),
    )
