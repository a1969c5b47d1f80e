"""Time integration with sudden changes of the rotor: blades that are lost, a support that fuses.

Each phase between two changes has a scheme of its own. At the step of a change the displacements
and velocities of the rotor continue; x_{n-1} of the next scheme follows from them and from the
forces in the next phase. The energy that leaves with lost parts or with springs is negative work of
the loads, or, of a rotor whose speed is free, negative work on the rotation.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.stage.contact_problem import Aftermath, ContactProblem, LostBlades
from bladewhirl.models.stage.modal_loads import Start
from bladewhirl.models.stage.varying_speed import Rotation
from bladewhirl.solvers.kernel.structs import lib
from bladewhirl.solvers.march.central_difference import CentralDifference
from bladewhirl.solvers.march.march import (
    Chunk,
    EndReason,
    KernelState,
    Scheme,
    Statistics,
    joined,
)
from bladewhirl.solvers.packing.rotor import DIRECTIONS

TRIALS = 4
"""Number of corrections of the velocity at a change: forces due to velocities depend on it."""

NEXT = {
    "whole": {"loss": "lost", "fuse": "fused"},
    "lost": {"fuse": "both"},
    "fused": {"loss": "both"},
    "both": {},
}
"""Phases by name, each with the changes that can end it and the phase that then follows."""

RESTARTED = ("rotor", "drive", "until")
"""Arrays of the state that do not continue as they were before a change."""


class Phase:
    """Rotor between two changes, with its scheme.

    Args:
        problem: contact problem of this phase.
        name: name of the phase, a key of `NEXT`.
        time_step: time step [s].
        record_every: number of steps between records.
        before: the phase before; None for the first one.
        change: change that begins this phase; None for the first one.
    """

    def __init__(
        self,
        problem: ContactProblem,
        name: str,
        time_step: float,
        record_every: int,
        before: "Phase | None" = None,
        change: Aftermath | None = None,
    ) -> None:
        self.problem, self.name = problem, name
        self.scheme = CentralDifference(problem, time_step, record_every)
        #: coordinates of the first phase for unit coordinates of this one; None if they are equal
        self.extension: FloatArray | None = None
        self.tips: IntArray = np.zeros(0, dtype=np.int64)
        self.reach: FloatArray = np.zeros(0)
        if before is not None and change is not None:
            self.extension = change.extension
            if before.extension is not None:
                self.extension = before.extension @ change.extension
            lost = isinstance(change, LostBlades)
            self.tips, self.reach = (
                (change.tips, change.reach) if lost else (before.tips, before.reach)
            )

    def change(self, ending: str) -> Aftermath | None:
        """Return a change that can end this phase, "loss" or "fuse"; None if it does not occur."""
        return self.problem.loss if ending == "loss" else self.problem.fuse

    def shown(self, chunk: Chunk) -> Chunk:
        """Return records of this phase in the coordinates of the first phase, with the strain
        energy of the rotor."""
        strained = (self.problem.rotor.frequency * chunk.rotor_displacement) ** 2
        chunk = replace(chunk, strain_energy=0.5 * strained.sum(axis=1))
        if self.extension is None:
            return chunk
        gap = chunk.gap.copy()
        gap[:, self.tips] = self.reach
        return replace(
            chunk,
            rotor_displacement=chunk.rotor_displacement @ self.extension.T,
            rotor_velocity=chunk.rotor_velocity @ self.extension.T,
            gap=gap,
        )


@dataclass(frozen=True, kw_only=True)
class ChangingState:
    """State of a march with sudden changes."""

    step: int  #: number of steps n
    phase: str  #: name of the phase
    arrays: dict[str, dict[str, FloatArray]]
    """Arrays of the state of the scheme of each phase, by its name; only those of the present phase
    have a meaning."""
    fused_step: int = -1  #: step at which the support fused; -1 if it did not

    @property
    def statistics(self) -> Statistics:
        """Quality measures since the start."""
        arrays = self.arrays[self.phase]
        statistics = KernelState(step=self.step, arrays=arrays).statistics
        return replace(statistics, fused_step=self.fused_step)


class SuddenChanges:
    """Scheme of `CentralDifference` for a contact problem with sudden changes.

    Args:
        problem: contact problem with a loss of blades or a support that fuses.
        time_step: time step [s].
        record_every: number of steps between records.

    Raises:
        ValueError: the time step is not below the critical time step of a phase.
    """

    def __init__(self, problem: ContactProblem, time_step: float, record_every: int) -> None:
        self._time_step, self._record_every = time_step, record_every
        self._loss_step = -1 if problem.loss is None else round(problem.loss.time / time_step)
        first = Phase(problem, "whole", time_step, record_every)
        self._phases = {"whole": first}
        self._further(first)
        self.cyclic = first.scheme.cyclic

    def _further(self, phase: Phase) -> None:
        """Add the phases that can follow a phase."""
        for ending, name in NEXT[phase.name].items():
            change = phase.change(ending)
            if change is not None and name not in self._phases:
                following = Phase(
                    change.after, name, self._time_step, self._record_every, phase, change
                )
                self._phases[name] = following
                self._further(following)

    @property
    def records_casing(self) -> bool:
        """Whether records contain the motion of the casing."""
        return self._phases["whole"].scheme.records_casing

    @records_casing.setter
    def records_casing(self, value: bool) -> None:
        for phase in self._phases.values():
            phase.scheme.records_casing = value

    def init(self) -> ChangingState:
        """Return the state at t = 0."""
        arrays = {name: phase.scheme.init().arrays for name, phase in self._phases.items()}
        return ChangingState(step=0, phase="whole", arrays=arrays)

    def advance(
        self, state: ChangingState, steps: int, record_every: int | None = None
    ) -> tuple[ChangingState, Chunk, EndReason | None]:
        """Advance by a number of steps; see `Scheme.advance`."""
        goal, chunks, end = state.step + steps, list[Chunk](), None
        while not chunks or (end is None and state.step < goal):
            phase = self._phases[state.phase]
            loses = phase.problem.loss is not None and state.step < self._loss_step
            stop = min(goal, self._loss_step) if loses else goal
            now, chunk, end = phase.scheme.advance(
                KernelState(step=state.step, arrays=state.arrays[state.phase]),
                stop - state.step,
                record_every,
            )
            chunks.append(phase.shown(chunk))
            arrays = state.arrays | {state.phase: now.arrays}
            state = replace(state, step=now.step, arrays=arrays)
            if end is EndReason.FUSED:
                end = None
                state = self._changed(state, "fuse")
                state = replace(state, fused_step=state.step)
            if end is None and self._phases[state.phase].problem.loss is not None:
                state = self._changed(state, "loss") if state.step == self._loss_step else state
        return state, joined(chunks), end

    def _changed(self, state: ChangingState, ending: str) -> ChangingState:
        """Return the state after a change at its step."""
        phase = self._phases[state.phase]
        name, change = NEXT[state.phase][ending], phase.change(ending)
        assert change is not None
        now = KernelState(step=state.step, arrays=state.arrays[state.phase])
        after = self.after_change(phase, change, self._phases[name], now)
        return replace(state, phase=name, arrays=state.arrays | {name: after.arrays})

    def after_change(
        self, phase: Phase, change: Aftermath, following: Phase, state: KernelState
    ) -> KernelState:
        """Return the state of the phase that follows a change, at its step."""
        start, turned = self.motion(phase, state)
        continued = replace(
            start,
            rotor=change.restriction @ start.rotor,
            rotor_velocity=change.restriction @ start.rotor_velocity,
        )
        after = following.scheme.begin(state.step, continued, turned)
        arrays = {
            name: after.arrays[name] if name in RESTARTED else values.copy()
            for name, values in state.arrays.items()
        }
        arrays["until"] -= 1.0
        arrays["force"].reshape(-1, DIRECTIONS)[change.tips] = 0.0
        for name in ("gap", "gaps"):
            arrays[name][..., change.tips] = change.reach
        place = arrays["work"], lib.EXTERNAL
        if phase.problem.drive is not None:  # its balance contains no work of loads
            _continue_drive(arrays["drive"], state.arrays["drive"])
            place = arrays["drive"], lib.DRIVE_CONTACT
        after = replace(after, arrays=arrays)
        energy = [
            _energy(scheme.advance(each, 1, 1)[1])
            for scheme, each in ((phase.scheme, state), (following.scheme, after))
        ]
        place[0][place[1]] += energy[1] - energy[0]
        return after

    def motion(self, phase: Phase, state: KernelState) -> tuple[Start, Rotation]:
        """Return displacements, velocities and rotation at a step, whose state contains the
        displacements one step before."""
        dt, time = self._time_step, state.step * self._time_step
        turned, drive = phase.problem.rotation_at(time), state.arrays["drive"]
        if phase.problem.drive is not None:
            rate = drive[lib.DRIVE_ACCELERATION]
            speed = drive[lib.DRIVE_SPEED] + 0.5 * dt * rate
            turned = Rotation(*map(float, (drive[lib.DRIVE_ANGLE], speed, rate)))
        (rotor, casing), (before, wall) = (phase.scheme.displacements(state, row) for row in (1, 0))
        half = (rotor - before) / dt, (casing - wall) / dt
        start = Start(rotor=rotor, rotor_velocity=half[0], casing=casing, casing_velocity=half[1])
        for _ in range(TRIALS):
            pushed = phase.scheme.accelerations(time, start, turned)
            start = replace(
                start,
                rotor_velocity=half[0] + 0.5 * dt * pushed[0],
                casing_velocity=half[1] + 0.5 * dt * pushed[1],
            )
        return start, turned


def _continue_drive(now: FloatArray, before: FloatArray) -> None:
    """Keep the works of a free speed, and the impulse of contact that acts in the next step."""
    kept = [lib.DRIVE_WORK, lib.DRIVE_LOSS, lib.DRIVE_CONTACT]
    now[kept] = before[kept]
    now[lib.DRIVE_IMPULSE] = before[lib.DRIVE_IMPULSE] - before[lib.DRIVE_MOVED]
    now[lib.DRIVE_MOMENTUM] += now[lib.DRIVE_IMPULSE]


def _energy(chunk: Chunk) -> float:
    """Return the energy of the first record of a chunk [J]."""
    turning = chunk.rotor_energy[0] if chunk.rotor_energy.size else 0.0
    return float(chunk.energy[0] + turning)


def make_scheme(problem: ContactProblem, time_step: float, record_every: int) -> Scheme[Any]:
    """Return the time integration scheme for a contact problem.

    Args:
        problem: contact problem.
        time_step: time step [s].
        record_every: number of steps between records.

    Raises:
        ValueError: the time step is too long.
    """
    changes = problem.loss is not None or problem.fuse is not None
    return (SuddenChanges if changes else CentralDifference)(problem, time_step, record_every)
