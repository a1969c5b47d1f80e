"""Early end of a march whose remaining energy is too small for further contact."""

import math
from dataclasses import dataclass
from typing import Literal, Self, get_args

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.stage.boundary_problem import BoundaryProblem
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.solvers.march.march import CHUNK_STEPS, Chunk

StopWhen = Literal["damped"]
"""Reasons for an early end of a march."""

STOPS: tuple[StopWhen, ...] = get_args(StopWhen)

CLOSING = 0.8
"""A march ends only if the remaining energy cannot close this fraction of the smallest gap at
rest."""

FREE_TURNS = 10.0
"""Smallest number of revolutions of free motion before a march ends early."""

ROUNDING = 1e-9
"""A negative damping rate up to this fraction of the largest one is a rounding error."""

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
    displacement sum_m phi_m q_m is at most sqrt(2 E sum_m (phi_m / omega_m)^2).
    """

    enough: float  #: energy below which no tip can touch the casing [J]
    free_time: float  #: required duration of free motion [s]
    since: float  #: time at which free motion began [s]

    @classmethod
    def of(cls, problem: ContactProblem | BoundaryProblem, time_step: float) -> Self:
        """Return the detector for a contact problem.

        Raises:
            ValueError: the energy of free motion need not decay; the message states the reason.
        """
        since = max((load.end for load in problem.loads), default=0.0)
        if math.isinf(since):
            raise ValueError("a load never ends")
        if isinstance(problem, BoundaryProblem):
            clearance, bodies = _nodes(problem)
        else:
            clearance, bodies = _tips(problem)
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
        turn = 2.0 * np.pi / abs(problem.speed) if problem.speed else np.inf
        return cls(
            enough=0.5 * share * gap**2 / compliance, free_time=FREE_TURNS * turn, since=since
        )

    def is_over(self, chunk: Chunk) -> bool:
        """Return whether the march can end after a chunk; all chunks must be passed in order."""
        touched = np.flatnonzero(chunk.contact_steps.any(axis=1))
        if touched.size:
            self.since = max(self.since, float(chunk.time[touched[-1]]))
        if not chunk.records or chunk.energy[-1] >= self.enough:
            return False
        now = float(chunk.time[-1])
        return now - self.since >= max(self.free_time, self.since)


Bodies = list[tuple[FloatArray, FloatArray]]
"""Radial displacements of the surface of each body for unit modal coordinates, and frequencies of
the modes."""


def _tips(problem: ContactProblem) -> tuple[float, Bodies]:
    """Return the smallest clearance of the tips of beams [m], and the bodies."""
    rotor, casing = problem.rotor, problem.casing
    if problem.springs is not None or rotor.anisotropy or rotor.circulation:
        raise ValueError("springs or dampers in the static frame can feed energy to the rotor")
    clearance = float(casing.clearance[:, 0].min() + rotor.tip_recess.min())
    bodies = [(rotor.tip_radial, rotor.frequency), (casing.nodal[:, 0], casing.frequency)]
    return clearance, bodies


def _nodes(problem: BoundaryProblem) -> tuple[float, Bodies]:
    """Return the smallest clearance of contact nodes [m], and the bodies."""
    damping = np.diag((2.0 * problem.damping_ratio * problem.frequency).min(axis=0))
    if problem.by_velocity is not None:
        damping = damping + 0.5 * (problem.by_velocity + problem.by_velocity.T)
    rates = np.linalg.eigvalsh(damping)
    if rates[0] < -ROUNDING * max(rates[-1], 0.0):
        raise ValueError("the damping matrix of the superelement feeds energy to some motion")
    covered = 0.0 if problem.coating is None else problem.coating.removable
    clearance = float(problem.wall[:, 0].min() + problem.recess.min() - covered)
    bodies = [(problem.contact[::3], frequency) for frequency in problem.frequency]
    if problem.casing is not None:
        bodies.append((problem.casing.nodal[:, 0], problem.casing.frequency))
    return clearance, bodies


def _compliance(rows: FloatArray, frequency: FloatArray) -> float:
    """Return the largest ratio of the square of a displacement, given by a row, to twice the energy
    [m/N]."""
    return float(((rows / frequency) ** 2).sum(axis=1).max())
