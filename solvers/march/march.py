"""Contact march: schemes behind one contract, and the loop that yields what they record.

A scheme is made once for a problem and a time step (it factorises then) and advances a state:
state in, state out, so that a march can be stopped, stored and resumed bit by bit.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, fields
from enum import Enum
from typing import Protocol, TypeVar

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.inputs.timing import Timing
from bladewhirl.models.stage.contact_problem import ContactProblem


class EndReason(Enum):
    """Why a march ended."""

    COMPLETED = "completed"
    DIVERGENT = "divergent"
    DAMPED = "damped"  #: no further contact is possible, see `FreeMotion`


@dataclass(frozen=True, kw_only=True)
class Chunk:
    """Consecutive records of a march."""

    step: IntArray  #: step of each record, (records,)
    time: FloatArray  #: [s], (records,)
    rotor_displacement: FloatArray  #: modal [kg^1/2 m], (records, rotor modes)
    rotor_velocity: FloatArray  #: modal [kg^1/2 m/s]
    casing_displacement: FloatArray  #: (records, casing modes)
    casing_velocity: FloatArray
    gap: FloatArray  #: smallest gap of each tip since the last record [m], (records, tips)
    contact_impulse: FloatArray  #: normal, since the last record [N s], (records, tips)
    friction_impulse: FloatArray  #: positive when the blade is dragged to -theta [N s]
    contact_steps: IntArray  #: steps with contact since the last record, (records, tips)
    contacts: IntArray  #: tips in contact at the record, (records,)
    energy: FloatArray  #: half-step energy of bodies and springs between them [J], (records,)
    external_work: FloatArray  #: since the start [J], (records,)
    normal_work: FloatArray  #: of the normal contact forces [J]
    closing_work: FloatArray  #: the part of it that stops tips as their gaps close [J]
    friction_work: FloatArray  #: of the friction forces [J]
    damping_work: FloatArray  #: lost to damping [J]
    coupling_work: (
        FloatArray  #: work on the rotor due to its rotation relative to fixed springs [J]
    )

    @property
    def records(self) -> int:
        """Number of records."""
        return len(self.step)


def joined(chunks: Sequence[Chunk]) -> Chunk:
    """Chunks that follow each other as one."""
    if len(chunks) == 1:
        return chunks[0]
    return Chunk(
        **{
            field.name: np.concatenate([getattr(chunk, field.name) for chunk in chunks])
            for field in fields(Chunk)
        }
    )


@dataclass(frozen=True, kw_only=True)
class Statistics:
    """Quality measures of a march."""

    steps: int  #: steps done
    contact_steps: int  #: of these, with contact
    complementarity_residual: float  #: largest of all steps (`CentralDifference`)
    pivots: int  #: changes of the active set after the first guess
    lcp_failures: int  #: steps whose complementarity problem no exact method solved


class MarchState(Protocol):
    """State of a march between two steps; its content belongs to the scheme."""

    @property
    def step(self) -> int:
        """Number of steps done."""

    @property
    def statistics(self) -> Statistics:
        """Quality so far."""


StateT = TypeVar("StateT", bound=MarchState)


class Scheme(Protocol[StateT]):
    """A time-stepping scheme, factorised for one problem and one time step."""

    cyclic: tuple[bool, bool]  #: whether rotor and casing are marched harmonic by harmonic

    def init(self) -> StateT:
        """State at t = 0."""

    def advance(
        self, state: StateT, steps: int, record_every: int | None = None
    ) -> tuple[StateT, Chunk, EndReason | None]:
        """Advance by a number of steps, recording at multiples of ``record_every`` (its own if
        None).

        The state given stays as it was.
        """


CHUNK_STEPS = 50_000
"""Steps between two yields: short enough for a smooth progress bar, long enough to cost nothing."""


def march(
    scheme: Scheme[StateT],
    timing: Timing,
    state: StateT | None = None,
    is_over: Callable[[Chunk], bool] | None = None,
) -> Iterator[tuple[StateT, Chunk, EndReason | None]]:
    """Advance a scheme over a whole march, yielding state and records chunk by chunk.

    The last step is recorded too, whether or not it is a whole number of records from the start.

    Free motion is of the second order in the time step, with dampers too. Contact is of the first:
    it begins and ends at whole steps, and dampers at points feel what a contact force changes from
    the next step on. Halve the step to see what that changes.

    Args:
        scheme: factorised for the problem and ``timing.time_step``.
        timing: steps and records.
        state: to resume from; the scheme's start when None.
        is_over: looks at each chunk; the march ends early when it says so.

    Yields:
        the state reached, the records since the last yield, and why the march ended (None while
        it goes on).
    """
    if state is None:
        state = scheme.init()
    per_chunk = max(1, CHUNK_STEPS // timing.record_every) * timing.record_every
    # A record at step n needs x_{n+1}: the last one takes one more step.
    last, whole = timing.steps + 1, timing.whole_steps + 1
    while state.step < last:
        within_whole = state.step < whole
        steps = (whole if within_whole else last) - state.step
        state, chunk, end = scheme.advance(
            state,
            min(per_chunk - state.step % per_chunk, steps),
            None if within_whole else timing.steps,
        )
        if end is None and state.step >= last:
            end = EndReason.COMPLETED
        if end is None and is_over is not None and is_over(chunk):
            end = EndReason.DAMPED
        yield state, chunk, end
        if end is not None:
            return


def check_time_step(problem: ContactProblem, time_step: float) -> None:
    """Refuse a time step at or above the stability limit.

    Raises:
        ValueError: naming the limit and what to do.
    """
    limit = problem.critical_time_step
    if not time_step < limit:
        raise ValueError(
            f"time step {time_step:.3g} s is at or above the critical step {limit:.3g} s = "
            "2/omega_max; use a smaller step, fewer casing elements or fewer fixed-interface modes"
        )
