"""Stability of periodic motions with joints: multipliers of small deviations of all blades.

Deviations of the blades differ from each other, also where the motion is tuned. They satisfy the
derivatives of the law of `joint_law` at the ends of equal steps, as those of an implicit march: in
a step the force at its end acts on the modes, which move exactly, and the slip is the change of the
displacement. In the time T / K, K = N / gcd(N, p), the pattern of the motion moves on to other
blades; the multipliers of a period T are the K-th powers of the eigenvalues of such a passage. The
blades of a wheel without cyclic copies are one body, and its passage is a period. In gcd(N, p)
groups of K neighbours the motions are the same. The matrix of a passage is then block-circulant in
these groups: deviations of the first group give all blocks, and its eigenvalues are those of the
discrete Fourier transforms of the blocks.

Modes that turn by more than `FAST` in a step respond statically. Nodes that are stuck all the time
keep their static force, which is not unique, see `joints`: deviations of it, with a multiplier of
one, are left out.
"""

from functools import cached_property
from math import gcd

import numpy as np
import scipy.sparse as sp

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray, IntArray
from bladewhirl.models.joints.wheel import DIRECTIONS
from bladewhirl.solvers.periodic import joint_law
from bladewhirl.solvers.periodic.joints import JointMotion, series
from bladewhirl.solvers.periodic.steps import Steps

STEPS, RUBBED = 192, 1024
"""Least number of steps in a period, and that with a wall: contacts at it are short."""
NEUTRAL = 5e-3
"""Growth up to which a motion is stable: static forces of nodes that hardly slip neither grow nor
decay."""
FAST = 0.5 * np.pi  #: largest angle of a mode in a step [rad]


class Deviations:
    """Small deviations of all blades from a motion."""

    def __init__(self, motion: JointMotion) -> None:
        self.grid, self.wheel = motion.grid, motion.grid.wheel
        order, blades = self.grid.order, self.wheel.blades
        shared = gcd(order, blades)
        passages = blades // shared
        self.alike = len(self.wheel.stiffness) == blades
        self.passages = passages if self.alike else 1
        self.groups = shared if self.alike else 1
        least = RUBBED if self.wheel.rubs else STEPS
        self.instants = passages * -(-least // passages)
        wave = series(self.grid.harmonics, self.instants)
        trial = (wave @ motion.trial()).reshape(self.instants, -1, DIRECTIONS)
        friction = self.wheel.friction
        self.slope = joint_law.projected(trial, friction, 0.0).slope
        self.held = (joint_law.states(trial, friction) == joint_law.STUCK).all(axis=0)
        self.shift = self.instants // passages * (order // shared)
        self.shift *= 1 if self.wheel.speed > 0.0 else -1
        turned = pow(order // shared, -1, passages) if passages > 1 else 0
        self.moved = turned if self.wheel.speed > 0.0 else -turned

    @cached_property
    def _kept(self) -> IntArray:
        """Numbers of the modes of a copy that move in time."""
        step = self.grid.period / self.instants
        return np.flatnonzero(np.sqrt(np.abs(self.wheel.stiffness[0])) * step <= FAST)

    def passage(self) -> FloatArray:
        """Return the blocks of the matrix of a passage from the state of the first group to those
        of all: modes (unit q, q') of each copy in turn, and the displacements from which joints
        slip, (groups, states of a group, states of a group)."""
        wheel, step = self.wheel, self.grid.period / self.instants
        copies, modes, kept = *wheel.stiffness.shape, self._kept
        rows, flexible = wheel.all_blades
        of_copies = rows.reshape(len(rows), copies, modes)
        fast = np.setdiff1d(np.arange(modes), kept)
        quick = of_copies[:, :, fast].reshape(len(rows), -1)
        static = flexible + quick / np.tile(wheel.stiffness[0, fast], copies) @ quick.T
        steps = Steps(wheel.stiffness[0, kept], wheel.damping[0][np.ix_(kept, kept)], step)
        place = of_copies[:, :, kept]
        carried, unit = steps.transition(np.eye(len(kept)))
        push = np.einsum("sm,fcm->csf", unit, place).reshape(-1, len(rows))
        place = np.pad(place / steps.unit, ((0, 0), (0, 0), (0, len(kept))))
        place = place.reshape(len(rows), -1)
        angle = 2.0 * np.pi / self.instants
        node = np.arange(len(rows)) // DIRECTIONS % len(wheel.joint)
        tangential = np.arange(len(rows)) % DIRECTIONS > 0
        scale = np.tile(self.grid.soft, wheel.blades) * np.where(tangential, angle, 1.0)
        before = (tangential & ~self.held[node])[:, None]  # slips are changes of displacements
        within = (static + place @ push) / scale[:, None]
        if self.alike:  # a joint has two blades
            place, push = sp.csr_array(place), sp.csr_array(push)
        own = push.shape[0] // self.groups  # states of the modes of a group
        size = own + len(rows) // self.groups
        state, moved = np.zeros((push.shape[0], size)), np.zeros((len(rows), size))
        state[:own, :own], moved[: size - own, own:] = np.eye(own), np.eye(size - own)
        for n in range(1, self.instants // self.passages + 1):
            state = self._carried(carried, state)
            free = (place @ state - np.where(before, moved, 0.0)) / scale[:, None]
            slope = self._slope(n)
            matrix = np.eye(len(rows)) - slope + slope @ within
            force = -np.linalg.solve(matrix, slope @ free)
            state = state + push @ force
            moved = place @ state + static @ force
        if self.alike:
            state, moved = (
                np.roll(each.reshape(wheel.blades, -1, size), self.moved, axis=0).reshape(-1, size)
                for each in (state, moved)
            )
        of_groups = [each.reshape(self.groups, -1, size) for each in (state, moved)]
        return np.concatenate(of_groups, axis=1)

    def _carried(self, carried: FloatArray, state: FloatArray) -> FloatArray:
        of_copies = state.reshape(len(self.wheel.stiffness), len(carried), -1)
        return np.asarray((carried @ of_copies).reshape(state.shape))

    def _slope(self, n: int) -> FloatArray:
        """Return the derivatives of the law of all joints at an instant."""
        at = n + self.shift * np.arange(self.wheel.blades)
        every = self.slope[at % self.instants].reshape(-1, DIRECTIONS, DIRECTIONS)
        node, size = np.arange(len(every)), DIRECTIONS * len(every)
        found = np.zeros((len(every), DIRECTIONS, len(every), DIRECTIONS))
        found[node, :, node] = every
        return found.reshape(size, size)


def multipliers(motion: JointMotion) -> ComplexArray:
    """Return the multipliers of all deviations of the blades in a period, the largest first; those
    of displacements without modes are zero or small."""
    deviations = Deviations(motion)
    waves = np.fft.rfft(deviations.passage(), axis=0)
    of_waves = [np.linalg.eigvals(each) for each in waves]
    for k in range(1, (deviations.groups + 1) // 2):  # waves in the other direction
        of_waves.append(of_waves[k].conj())
    values = np.concatenate(of_waves) ** deviations.passages
    return np.asarray(values[np.argsort(-np.abs(values), kind="stable")], dtype=np.complex128)
