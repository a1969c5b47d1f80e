"""Stability of periodic motions with joints: multipliers of small deviations of all blades.

Deviations of the blades differ from each other, also where the motion is tuned. They satisfy the
derivatives of the law of `joint_law` at the ends of equal steps, as those of an implicit march: in
a step the force at its end acts on the modes, which move exactly, and the slip is the change of the
displacement. In the time T / K, K = N / gcd(N, p), the pattern of the motion moves on to other
blades; the multipliers of a period T are the K-th powers of the eigenvalues of such a passage. The
blades of a wheel without cyclic copies are one body, and its passage is a period. In gcd(N, p)
groups of K neighbours the motions are the same. Deviations are then waves over the groups, with
the phase 2 pi k / gcd(N, p) from a group to the next one, and the first group gives the passage of
each wave.

The largest multiplier follows from a power of the matrix of a passage by Arnoldi's method: in the
power, multipliers of almost the same magnitude are farther apart.

Modes that turn by more than `FAST` in a step respond statically. Nodes that are stuck all the time
keep their static force, which is not unique, see `joints`: deviations of it, with a multiplier of
one, are left out.
"""

from collections.abc import Iterator
from functools import cached_property
from math import gcd
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import ArpackNoConvergence, eigs

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
SLOW = 1e-4
"""Angle in a step of dampers, which have no stiffness: their eigenvectors would not be independent
[rad]."""
ENTRIES, THIN = 1_000_000, 0.06
"""Entries of matrices of several steps that are in memory at a time, and the share of entries that
are not zero below which a matrix is a sparse one."""
DOUBLINGS, VECTORS, RESTARTS = 4, 40, 4
"""Number of times that the matrix of a passage is squared for its largest eigenvalue, and the
numbers of vectors and of restarts of Arnoldi's method, without which all eigenvalues are computed.
"""


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
        self.step = self.grid.period / self.instants
        wave = series(self.grid.harmonics, self.instants)
        trial = (wave @ motion.trial()).reshape(self.instants, -1, DIRECTIONS)
        friction = self.wheel.friction
        self.slope = joint_law.projected(trial, friction, 0.0).slope
        self.held = (joint_law.states(trial, friction) == joint_law.STUCK).all(axis=0)
        self.shift = self.instants // passages * (order // shared)
        self.shift *= 1 if self.wheel.speed > 0.0 else -1
        turned = pow(order // shared, -1, passages) if passages > 1 and self.alike else 0
        self.moved = turned if self.wheel.speed > 0.0 else -turned

    @property
    def blades(self) -> int:
        """Number of blades of a group."""
        return self.wheel.blades // self.groups

    @cached_property
    def _kept(self) -> IntArray:
        """Numbers of the modes of a copy that move in time."""
        return np.flatnonzero(np.sqrt(np.abs(self.wheel.stiffness[0])) * self.step <= FAST)

    @cached_property
    def _copy(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Displacements of the joint nodes of a copy by its state (unit q, q'), and by forces on
        them without their part in the modes, and the states after a step by those before and by
        forces in it; the nodes are those of all blades of the copy, value by value."""
        wheel, kept = self.wheel, self._kept
        rows = wheel.contact.swapaxes(0, 1).reshape(-1, wheel.stiffness.shape[1])
        fast = np.setdiff1d(np.arange(rows.shape[1]), kept)
        static = wheel.compliance.transpose(1, 0, 3, 2).reshape(len(rows), len(rows))
        static = static + rows[:, fast] / wheel.stiffness[0, fast] @ rows[:, fast].T
        damping = wheel.damping[0][np.ix_(kept, kept)]
        stiffness = wheel.stiffness[0, kept]
        stiffness = np.where(stiffness == 0.0, (SLOW / self.step) ** 2, stiffness)
        steps = Steps(stiffness, damping, self.step)
        carried, push = steps.transition(rows[:, kept])
        return np.pad(rows[:, kept] / steps.unit, ((0, 0), (0, len(kept)))), static, carried, push

    def passage(self, k: int) -> Any:
        """Return the matrix of a passage in a wave of the groups with the phase 2 pi k / groups,
        real or complex, for the states of the first group: modes (unit q, q') and the displacements
        from which joints slip, of all copies and blades value by value, (states, states)."""
        wave = _Wave(k, self.groups, self.blades)
        place, static, carried, push = self._copy
        joined = wave.joined(self.wheel.values)
        joints, nodes = joined.shape
        copies = len(self.wheel.stiffness) // self.groups
        within = joined @ np.kron(static + place @ push, np.eye(copies)) @ joined.conj().T
        step, joined, spread = map(_thinned, (carried, joined, joined.conj().T))
        size = copies * len(carried)
        columns = size + joints
        state = np.eye(size, columns, dtype=joined.dtype).reshape(len(carried), copies, columns)
        moved = np.eye(joints, columns, size, dtype=joined.dtype)
        for answer in self._answers(within):
            state = _times(step, state)
            free = joined @ _times(place, state).reshape(nodes, columns)
            force = answer @ np.vstack([free, moved])
            moved = free + within @ force
            state += _times(push, (spread @ force).reshape(push.shape[1], copies, columns))
        both = state, moved.reshape(-1, self.blades, columns)
        return np.vstack([wave.turned(each, self.moved).reshape(-1, columns) for each in both])

    def _answers(self, within: Any) -> Iterator[Any]:
        """Yield the matrices to the forces of the joints at the ends of steps from their
        displacements without the forces in the step, and those before it, (joints, 2 * joints);
        `within` has the displacements by forces in a step."""
        tangential = np.arange(self.wheel.values) % DIRECTIONS > 0
        turn = 2.0 * np.pi / self.instants
        scale = (self.grid.soft * np.where(tangential, turn, 1.0)).repeat(self.blades)
        before = tangential & ~self.held.repeat(DIRECTIONS)  # slips are changes of displacements
        unit, steps = np.eye(len(scale)), 1 + np.arange(self.instants // self.passages)
        for part in np.array_split(steps, -(-len(steps) * len(scale) ** 2 // ENTRIES)):
            slope = self._slopes(part)
            trial = unit - slope + slope @ (within / scale[:, None])
            now = -np.linalg.solve(trial, slope) / scale
            yield from np.concatenate([now, -now * before.repeat(self.blades)], axis=2)

    def _slopes(self, steps: IntArray) -> FloatArray:
        """Return the derivatives of the law of the joints of a group at the ends of steps, (steps,
        joints, joints)."""
        at = steps[:, None] + self.shift * np.arange(self.blades)
        every = self.slope[at % self.instants]  # (steps, blades, nodes, directions, directions)
        count, blades, nodes = every.shape[:3]
        slope = np.zeros((count, nodes, DIRECTIONS, blades, nodes, DIRECTIONS, blades))
        for node, blade in np.ndindex(nodes, blades):
            slope[:, node, :, blade, node, :, blade] = every[:, blade, node]
        size = self.wheel.values * blades
        return slope.reshape(count, size, size)


class _Wave:
    """Values of the blades of a group in a wave of the groups, (values, blades, ...)."""

    def __init__(self, k: int, groups: int, blades: int) -> None:
        phase = np.exp(2j * np.pi * k / groups)
        self._phase = phase.real.round() if 2 * k % groups == 0 else phase
        self._blades = blades

    def turned(self, values: Any, blades: int) -> Any:
        """Return values of blades that are those of others, a number of blades before them."""
        if not blades:
            return values
        group, blade = np.divmod(np.arange(self._blades) - blades, self._blades)
        return self._phase ** group[:, None] * values[:, blade]

    def joined(self, values: int) -> Any:
        """Return the matrix from the left and right nodes of the blades to the joints after them,
        (values * blades, 2 * values * blades)."""
        unit = np.eye(2 * values * self._blades)
        left, right = np.split(unit.reshape(2 * values, self._blades, -1), 2)
        return (self.turned(left, -1) + right).reshape(-1, len(unit))


def _thinned(matrix: Any) -> Any:
    """Return a matrix as a sparse one if few of its entries are not zero."""
    return sp.csr_array(matrix) if np.count_nonzero(matrix) < THIN * matrix.size else matrix


def _times(matrix: Any, values: Any) -> Any:
    """Return the product of a real matrix and real or complex values, (rows, ..., columns)."""
    flat = np.ascontiguousarray(values).reshape(matrix.shape[1], -1)
    found = np.ascontiguousarray(matrix @ flat.view(np.float64)).view(values.dtype)
    return found.reshape(-1, *values.shape[1:])


def multipliers(motion: JointMotion) -> ComplexArray:
    """Return the multipliers of all deviations of the blades in a period, the largest first; those
    of displacements without modes are zero or small."""
    deviations = Deviations(motion)
    groups = deviations.groups
    of_waves = [np.linalg.eigvals(deviations.passage(k)) for k in range(groups // 2 + 1)]
    for k in range(1, (groups + 1) // 2):  # waves in the other direction
        of_waves.append(of_waves[k].conj())
    values = np.concatenate(of_waves) ** deviations.passages
    return np.asarray(values[np.argsort(-np.abs(values), kind="stable")], dtype=np.complex128)


def largest_multiplier(motion: JointMotion) -> float:
    """Return the largest magnitude of the multipliers of all deviations in a period."""
    deviations = Deviations(motion)
    waves = range(deviations.groups // 2 + 1)
    return max(map(_radius, map(deviations.passage, waves))) ** deviations.passages


def _radius(matrix: Any) -> float:
    """Return the largest magnitude of the eigenvalues of a matrix."""
    if len(matrix) > 2 * VECTORS:
        power = np.linalg.matrix_power(matrix, 2**DOUBLINGS)
        start = np.random.default_rng(0).standard_normal(len(matrix)).astype(matrix.dtype)
        try:
            found = eigs(
                power, 1, v0=start, ncv=VECTORS, maxiter=RESTARTS, return_eigenvectors=False
            )
            return float(np.abs(found).max() ** (0.5**DOUBLINGS))
        except ArpackNoConvergence:  # many of almost the same magnitude
            pass
    return float(np.abs(np.linalg.eigvals(matrix)).max())
