"""Early end of a march whose remaining energy is too small for further contact."""

import math
from dataclasses import dataclass, replace
from typing import Literal, Self, get_args

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.stage.contact_problem import Aftermath, ContactProblem, LostBlades
from bladewhirl.solvers.march.march import CHUNK_STEPS, Chunk

StopWhen = Literal["damped"]
"""Reasons for an early end of a march."""

STOPS: tuple[StopWhen, ...] = get_args(StopWhen)

CLOSING = 0.8
"""A march ends only if the remaining energy cannot close this fraction of the smallest gap at
rest."""

ROUNDING = 1e-9
"""An increase of the stiffness up to this fraction of the largest is a rounding error."""

FREE_TURNS = 10.0
"""Smallest number of revolutions of free motion before a march ends early."""

RULE = (
    "damped: the loads have ended, no tip has touched for at least half of the time marched and"
    f" {FREE_TURNS:g} revolutions, and the remaining energy, which only damping changes, cannot"
    f" close more than {CLOSING:.0%} of the smallest gap at rest; this is checked about every"
    f" {CHUNK_STEPS} steps; such a march has the end_reason damped and ends at end_time"
)
"""Text of the rule for the end, which every sweep that applies the rule contains."""


@dataclass(kw_only=True)
class FreeMotion:
    """Detects when no tip can touch the casing any more.

    The energy of free motion, that is, of motion without loads and contact, can only decrease if no
    springs or dampers in the static frame act on the rotor. With the remaining energy E, a
    displacement sum_m phi_m q_m is at most sqrt(2 E sum_m (phi_m / omega_m)^2). The loss of a blade
    and a support that fuses take energy away. A march does not end before the loss; the energy has
    to be too small for contact before and after such changes.
    """

    enough: float  #: energy below which no tip can touch the casing [J]
    free_time: float  #: required duration of free motion [s]
    since: float  #: time at which free motion began [s]
    earliest: float = 0.0  #: earliest time of the end [s]

    @classmethod
    def of(cls, problem: ContactProblem, time_step: float) -> Self:
        """Return the detector for a contact problem.

        Raises:
            ValueError: the energy of free motion need not decay; the message states the reason.
        """
        since = max((load.end for load in problem.loads), default=0.0)
        if math.isinf(since):
            raise ValueError("a load never ends")
        speed, course = problem.speed, problem.change
        if course is not None:
            if problem.drive is not None:
                raise ValueError("the speed is free")
            if course.rotor is not None:
                raise ValueError("the speed varies, which does work on the bladed disk")
            speed = min(map(abs, course.course.range))
        clearance, bodies = problem.free_bodies()
        lost = 0.0 if problem.closure is None else problem.closure.course.largest_loss
        gap = CLOSING * (clearance - lost)
        if problem.closure is not None and not gap > 0.0:
            raise ValueError("the casing closes on the tips")
        if min(frequency.min() for _, frequency in bodies) <= 0.0:
            raise ValueError("a mode has no stiffness")
        compliance = sum(_compliance(rows, frequency) for rows, frequency in bodies)
        # The energy of the scheme is at least this share of the true energy (at the highest
        # frequency).
        share = 1.0 - (time_step / problem.critical_time_step) ** 2
        turn = 2.0 * np.pi / abs(speed) if speed else np.inf
        own = cls(
            enough=0.5 * share * gap**2 / compliance, free_time=FREE_TURNS * turn, since=since
        )
        if problem.fuse is not None:
            ways, stiffness = problem.fuse.extension, problem.fuse.after.rotor.stiffness
            gained = (ways * stiffness) @ ways.T - np.diag(problem.rotor.stiffness)
            if np.linalg.eigvalsh(gained)[-1] > ROUNDING * problem.rotor.stiffness.max():
                raise ValueError("a support can fuse and become stiffer, which adds energy")
        for change in (problem.loss, problem.fuse):
            if change is not None:
                own = own._until(change, time_step)
        return own

    def _until(self, change: Aftermath, time_step: float) -> Self:
        """Return the detector that also holds after a sudden change.

        Raises:
            ValueError: see `of`.
        """
        lost = isinstance(change, LostBlades)
        try:
            after = type(self).of(change.after, time_step)
        except ValueError as error:
            what = "the loss of a blade" if lost else "the support fuses"
            raise ValueError(f"after {what} {error}") from None
        begins = change.time if isinstance(change, LostBlades) else 0.0
        return replace(
            self,
            enough=min(self.enough, after.enough),
            free_time=max(self.free_time, after.free_time),
            since=max(self.since, after.since),
            earliest=max(self.earliest, after.earliest, begins),
        )

    def is_over(self, chunk: Chunk) -> bool:
        """Return whether the march can end after a chunk; all chunks must be passed in order."""
        touched = np.flatnonzero(chunk.contact_steps.any(axis=1))
        if touched.size:
            self.since = max(self.since, float(chunk.time[touched[-1]]))
        if not chunk.records or chunk.energy[-1] >= self.enough:
            return False
        now = float(chunk.time[-1])
        return now > self.earliest and now - self.since >= max(self.free_time, self.since)


def _compliance(rows: FloatArray, frequency: FloatArray) -> float:
    """Return the largest ratio of the square of a displacement, given by a row, to twice the energy
    [m/N]."""
    return float(((rows / frequency) ** 2).sum(axis=1).max())
