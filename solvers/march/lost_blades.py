"""Time integration with the loss of blades: one scheme before the loss, another one after it.

At the time step of the loss the displacements and velocities of what remains are those before the
loss; x_{n-1} of the other scheme follows from them and from the forces on what remains. The energy
of the lost part leaves as negative work of the loads, or, from a rotor whose speed is free, as
negative work on the rotation.
"""

from dataclasses import dataclass, replace

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.stage.contact_problem import (
    ContactProblem,
    Rotation,
    Start,
)
from bladewhirl.solvers.kernel.structs import lib
from bladewhirl.solvers.march.central_difference import CentralDifference
from bladewhirl.solvers.march.march import Chunk, EndReason, KernelState, Statistics, joined

TRIALS = 4
"""Number of corrections of the velocity at the loss: forces due to velocities depend on it."""

RESTARTED = ("rotor", "drive", "until")
"""Arrays of the state that do not continue as they were before the loss."""


@dataclass(frozen=True, kw_only=True)
class LossState:
    """State of a march with a loss of blades."""

    step: int  #: number of steps n
    before: dict[str, FloatArray]  #: arrays of the scheme before the loss
    after: dict[str, FloatArray]  #: arrays of the scheme after it; without meaning before it
    lost: int  #: 1 after the loss, otherwise 0

    @property
    def statistics(self) -> Statistics:
        """Quality measures since the start."""
        return KernelState(
            step=self.step, arrays=self.after if self.lost else self.before
        ).statistics


class LossOfBlades:
    """Scheme of `CentralDifference` for a contact problem with a loss of blades.

    Args:
        problem: contact problem with the loss.
        time_step: time step [s].
        record_every: number of steps between records.

    Raises:
        ValueError: the time step is not below the critical time step before or after the loss.
    """

    def __init__(self, problem: ContactProblem, time_step: float, record_every: int) -> None:
        assert problem.loss is not None
        self._problem, self._loss, self._time_step = problem, problem.loss, time_step
        self._before = CentralDifference(problem, time_step, record_every)
        self._after = CentralDifference(self._loss.after, time_step, record_every)
        self._step = round(self._loss.time / time_step)
        self.cyclic = self._before.cyclic

    @property
    def records_casing(self) -> bool:
        """Whether records contain the motion of the casing."""
        return self._before.records_casing

    @records_casing.setter
    def records_casing(self, value: bool) -> None:
        self._before.records_casing = self._after.records_casing = value

    def init(self) -> LossState:
        """Return the state at t = 0."""
        before, after = self._before.init(), self._after.init()
        return LossState(step=0, before=before.arrays, after=after.arrays, lost=0)

    def advance(
        self, state: LossState, steps: int, record_every: int | None = None
    ) -> tuple[LossState, Chunk, EndReason | None]:
        """Advance by a number of steps; see `Scheme.advance`."""
        chunks, goal, end = list[Chunk](), state.step + steps, None
        if not state.lost:
            first = min(goal, self._step) - state.step
            now, chunk, end = self._before.advance(
                KernelState(step=state.step, arrays=state.before), first, record_every
            )
            chunks.append(chunk)
            state = replace(state, step=now.step, before=now.arrays)
            if end is None and now.step == self._step:
                state = replace(state, after=self.after_loss(now).arrays, lost=1)
        if state.lost and end is None and state.step < goal:
            now, chunk, end = self._after.advance(
                KernelState(step=state.step, arrays=state.after), goal - state.step, record_every
            )
            chunks.append(self._shown(chunk))
            state = replace(state, step=now.step, after=now.arrays)
        return state, joined(chunks), end

    def after_loss(self, state: KernelState) -> KernelState:
        """Return the state of what remains at the step of the loss."""
        start, turned = self._motion(state)
        loss = self._loss
        remaining = replace(
            start,
            rotor=loss.restriction @ start.rotor,
            rotor_velocity=loss.restriction @ start.rotor_velocity,
        )
        after = self._after.begin(state.step, remaining, turned)
        arrays = {
            name: after.arrays[name] if name in RESTARTED else values.copy()
            for name, values in state.arrays.items()
        }
        arrays["until"] -= 1.0
        arrays["held"][loss.tips] = 0.0
        for name in ("gap", "gaps"):
            arrays[name][..., loss.tips] = loss.reach
        if self._problem.drive is not None:
            self._continue_drive(arrays["drive"], state.arrays["drive"])
        after = replace(after, arrays=arrays)
        energy = [
            _energy(scheme.advance(each, 1, 1)[1])
            for scheme, each in ((self._before, state), (self._after, after))
        ]
        place = arrays["work"], lib.EXTERNAL
        if self._problem.drive is not None:  # its balance contains no work of loads
            place = arrays["drive"], lib.DRIVE_CONTACT
        place[0][place[1]] += energy[1] - energy[0]
        return after

    def _motion(self, state: KernelState) -> tuple[Start, Rotation]:
        """Return displacements, velocities and rotation at a step, whose state contains the
        displacements one step before."""
        dt, time = self._time_step, state.step * self._time_step
        turned, drive = self._problem.rotation_at(time), state.arrays["drive"]
        if self._problem.drive is not None:
            rate = drive[lib.DRIVE_ACCELERATION]
            speed = drive[lib.DRIVE_SPEED] + 0.5 * dt * rate
            turned = Rotation(*map(float, (drive[lib.DRIVE_ANGLE], speed, rate)))
        (rotor, casing), (before, wall) = (self._before.displacements(state, row) for row in (1, 0))
        rate_of = {"rotor": (rotor - before) / dt, "casing": (casing - wall) / dt}
        start = Start(
            rotor=rotor,
            rotor_velocity=rate_of["rotor"],
            casing=casing,
            casing_velocity=rate_of["casing"],
        )
        for _ in range(TRIALS):
            pushed = self._before.accelerations(time, start, turned)
            start = replace(
                start,
                rotor_velocity=rate_of["rotor"] + 0.5 * dt * pushed[0],
                casing_velocity=rate_of["casing"] + 0.5 * dt * pushed[1],
            )
        return start, turned

    def _continue_drive(self, now: FloatArray, before: FloatArray) -> None:
        """Keep the works of a free speed, and the impulse of contact that acts in the next step."""
        kept = [lib.DRIVE_WORK, lib.DRIVE_LOSS, lib.DRIVE_CONTACT, lib.DRIVE_IMPULSE]
        now[kept] = before[kept]
        now[lib.DRIVE_MOMENTUM] += before[lib.DRIVE_IMPULSE]

    def _shown(self, chunk: Chunk) -> Chunk:
        """Return records of what remains in the coordinates before the loss."""
        loss, gap = self._loss, chunk.gap.copy()
        gap[:, loss.tips] = loss.reach
        return replace(
            chunk,
            rotor_displacement=chunk.rotor_displacement @ loss.extension.T,
            rotor_velocity=chunk.rotor_velocity @ loss.extension.T,
            gap=gap,
        )


def _energy(chunk: Chunk) -> float:
    """Return the energy of the first record of a chunk [J]."""
    turning = chunk.rotor_energy[0] if chunk.rotor_energy.size else 0.0
    return float(chunk.energy[0] + turning)
