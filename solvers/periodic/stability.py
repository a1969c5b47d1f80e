"""Stability of a periodic motion in contact: the monodromy matrix and its eigenvalues.

Small deviations of the state of the modes and of the contact forces satisfy the derivatives of the
equations of the motion, with the same nodes in contact at each instant. The force of a massless
contact node is continuous where the node opens and closes, so that deviations do not jump there.
Deviations of equal blades in a flexible ring differ from each other, and the ring has a state.
There the motion repeats itself in the next blade as soon as it is at the place of this one, N times
in a turn; if the grid has instants at these times, the matrix of one such passage, with the numbers
of the next blades, leads to that of the period.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy.linalg as la

from bladewhirl.meshes.line_mesh import BoolArray, ComplexArray, FloatArray, IntArray
from bladewhirl.solvers.periodic.blade import DIRECTIONS
from bladewhirl.solvers.periodic.contact import Motion


@dataclass(frozen=True)
class Monodromy:
    """Change of small deviations over one period."""

    matrix: FloatArray
    """Matrix of the state (unit q, q') of the modes, with f if there is always contact,
    (states, states)."""
    modes: int  #: number of modes of a blade

    @property
    def multipliers(self) -> ComplexArray:
        """The largest eigenvalues, the largest first, (2 * modes,). The contact forces follow from
        the modes, and have eigenvalues of zero."""
        values = np.linalg.eigvals(self.matrix)
        values = values[np.argsort(-np.abs(values), kind="stable")]
        return np.asarray(values[: 2 * self.modes], dtype=np.complex128)

    @property
    def stable(self) -> bool:
        """True if all deviations decay."""
        return bool(np.abs(self.multipliers[0]) < 1.0)


class _Blocks(NamedTuple):
    """Equally large parts of the state that do not influence each other without contact."""

    carried: FloatArray  #: matrices of a step, (blocks, size, size)
    by_force: FloatArray  #: responses to constant forces in a step, (blocks * size, forces)
    place: FloatArray  #: displacements relative to the wall, (forces, blocks * size)
    velocity: FloatArray  #: velocities relative to the wall, (forces, blocks * size)
    passed: FloatArray  #: the next blade has the place of this one, (blocks * size, blocks * size)


@dataclass(frozen=True)
class _Structure:
    """A blade, or all blades and their ring in rotating axes, with their contact."""

    blocks: list[_Blocks]
    compliance: FloatArray  #: residual flexibility, (forces, forces)
    passed: FloatArray  #: as that of blocks, for the forces, (forces, forces)
    normal: FloatArray  #: normal forces, (instants, nodes)
    angle: FloatArray  #: directions of sliding, (instants, nodes)
    ways: FloatArray  #: see `Motion.ways`, (instants, nodes, 3)
    slip: FloatArray  #: slip velocities, (instants, nodes, 2)
    step: float  #: length of a step [s]
    friction: float  #: friction coefficient
    turns: bool  #: see `Blade.turns`

    @classmethod
    def of_motion(cls, motion: Motion) -> "_Structure":
        """Return the structure of a motion."""
        grid, blade = motion.grid, motion.grid.blade
        copies = blade.copies
        carried, by_force = grid.transition
        every = np.eye(copies)
        ahead = np.roll(every, int(np.sign(blade.speed)), axis=0)
        place, velocity = grid.to_nodes
        blocks = [
            _Blocks(
                np.repeat(carried[None], copies, axis=0),
                _kron(every, by_force),
                _kron(every, place),
                _kron(every, velocity),
                _kron(ahead, np.eye(len(carried))),
            )
        ]
        if blade.ring is not None:
            blocks += _of_ring(motion)
        behind = np.round(np.arange(copies) * grid.instants * blade.lobes / copies).astype(int)
        if blade.speed < 0.0:
            behind = -behind

        def everywhere(values: FloatArray) -> FloatArray:
            return np.concatenate([np.roll(values, -k, axis=0) for k in behind], axis=1)

        return cls(
            blocks=blocks,
            compliance=_kron(every, blade.compliance),
            passed=_kron(ahead, np.eye(len(blade.compliance))),
            normal=everywhere(motion.normal),
            angle=everywhere(motion.angle),
            ways=everywhere(motion.ways),
            slip=everywhere(motion.slip),
            step=grid.step,
            friction=blade.friction,
            turns=blade.turns,
        )

    @property
    def held(self) -> BoolArray:
        """Nodes in contact, (instants, nodes)."""
        return self.normal > 0.0

    def joined(self, name: str, axis: int) -> FloatArray:
        """Return a matrix of all blocks."""
        return np.concatenate([getattr(each, name) for each in self.blocks], axis=axis)

    def carry(self, states: FloatArray, steps: int) -> FloatArray:
        """Return states (states, columns) after steps without forces."""
        moved, first = [], 0
        for carried, *_ in self.blocks:
            count, size = carried.shape[:2]
            part = states[first : first + count * size].reshape(count, size, -1)
            moved.append((np.linalg.matrix_power(carried, steps) @ part).reshape(count * size, -1))
            first += count * size
        return np.concatenate(moved)


def _kron(one: FloatArray, other: FloatArray) -> FloatArray:
    """Return the Kronecker product."""
    return np.asarray(np.kron(one, other), dtype=np.float64)


def _of_ring(motion: Motion) -> list[_Blocks]:
    """Return the blocks of the ring, whose forces are those on the blades with the opposite sign,
    in real and imaginary parts; the harmonic 0 is real."""
    grid, blade = motion.grid, motion.grid.blade
    ring = blade.ring
    assert ring is not None
    turn = 2.0 * np.pi * np.arange(blade.copies)[:, None] / blade.copies
    angle = (blade.angle + turn).ravel()
    rows = np.zeros((len(ring.order), len(angle), DIRECTIONS), dtype=np.complex128)
    rows[..., :2] = np.exp(1j * ring.order[:, None, None] * angle[:, None]) * ring.shape[:, None]
    wide = rows.reshape(len(rows), 1, -1)
    carried, held = ring.transition(blade.speed, grid.unit, grid.step)
    passage = np.exp(-2j * np.pi * np.sign(blade.speed) / blade.copies * ring.order)
    found = []
    for chosen, real, factor in (
        (ring.order == 0, _real_part, 1.0),
        (ring.order > 0, _both_parts, 2.0),
    ):
        own = wide[chosen]
        count, forces = own.shape[0], own.shape[2]
        if not count:
            continue
        by_force = real(held[chosen][:, :, None] * own.conj())[:, :, :forces].reshape(-1, forces)
        matrix = real(carried[chosen])
        place = np.zeros((count, matrix.shape[1] // 2, 2, forces))
        # u - w with w = factor Re(rows q), which is the first row of a matrix of both parts
        place[:, :, 0] = -factor * real(own)[:, 0].reshape(count, -1, forces)
        velocity = np.roll(place, 1, axis=2)
        found.append(
            _Blocks(
                matrix,
                -by_force,
                place.reshape(-1, forces).T / grid.unit,
                velocity.reshape(-1, forces).T,
                la.block_diag(*real(passage[chosen][:, None, None] * np.eye(2))),
            )
        )
    return found


def _real_part(matrices: ComplexArray) -> FloatArray:
    """Return the real parts of matrices."""
    return np.asarray(matrices.real)


def _both_parts(matrices: ComplexArray) -> FloatArray:
    """Return matrices as those of real, then imaginary parts, (..., 2 * rows, 2 * columns)."""
    return np.asarray(
        np.concatenate(
            [
                np.concatenate([matrices.real, -matrices.imag], axis=-1),
                np.concatenate([matrices.imag, matrices.real], axis=-1),
            ],
            axis=-2,
        )
    )


def monodromy(motion: Motion) -> Monodromy:
    """Return the monodromy matrix of a periodic motion.

    The period begins at an instant without contact, if there is one, so that the forces follow from
    the modes. Without contact, powers of the matrix of a step carry the state to the next contact.
    The motion of other blades in a ring is that of this blade at the nearest instants.
    """
    grid, blade = motion.grid, motion.grid.blade
    whole, steps, times = _Structure.of_motion(motion), grid.instants, 1
    if steps * blade.lobes % blade.copies == 0 and blade.copies % blade.lobes == 0:
        times = blade.copies // blade.lobes
        steps //= times
    half = 0.5 * whole.joined("by_force", 0)  # in a step the mean of both forces acts
    place, velocity = whole.joined("place", 1), whole.joined("velocity", 1)
    answers = _Answers(
        whole,
        place,
        velocity,
        place @ half + whole.compliance,
        velocity @ half + whole.compliance / whole.step,
    )
    split, held = len(half), whole.held
    first = int(np.argmin(held.any(axis=1)))
    matrix = np.eye(split + (half.shape[1] if held[first].any() else 0))
    state, force = matrix[:split], np.zeros((half.shape[1], len(matrix)))
    force[: len(matrix) - split] = matrix[split:]
    waiting, pushed = 0, bool(held[first].any())
    for step in range(1, steps + 1):
        i = (first + step) % grid.instants
        nodes = np.flatnonzero(held[i])
        waiting += 1
        if not len(nodes) and not pushed:
            continue
        state, waiting = whole.carry(state, waiting), 0
        if pushed:
            acting = np.flatnonzero(force.any(axis=1))
            state = state + half[:, acting] @ force[acting]
        before, force, pushed = force, np.zeros_like(force), bool(len(nodes))
        if len(nodes):
            acting = (DIRECTIONS * nodes[:, None] + np.arange(DIRECTIONS)).ravel()
            force[acting] = answers.forces(i, nodes, state, before)
            state = state + half[:, acting] @ force[acting]
    state = whole.carry(state, waiting)
    matrix = np.concatenate([state, force[: len(matrix) - split]])
    if times > 1:
        forces = [whole.passed] if len(matrix) > split else []
        passed = la.block_diag(*(each.passed for each in whole.blocks), *forces)
        matrix = np.linalg.matrix_power(passed @ matrix, times)
        matrix = np.linalg.matrix_power(passed.T, times) @ matrix
    return Monodromy(matrix, len(blade.stiffness))


@dataclass(frozen=True)
class _Answers:
    """Deviations of contact forces that follow from those of the state."""

    whole: _Structure
    place: FloatArray  #: displacements by the state, (forces, states)
    velocity: FloatArray  #: velocities by the state, (forces, states)
    flexible: FloatArray  #: displacements by forces within the step, (forces, forces)
    rate: FloatArray  #: velocities by forces within the step, (forces, forces)

    def forces(self, i: int, nodes: IntArray, state: FloatArray, before: FloatArray) -> FloatArray:
        """Return the deviations of the forces on nodes in contact, (3 * nodes, columns).

        Args:
            i: number of the instant.
            nodes: numbers of the nodes in contact.
            state: deviations of the state without these forces, (states, columns).
            before: deviations of all forces at the instant before, (forces, columns).
        """
        whole, count = self.whole, len(nodes)
        place, own = DIRECTIONS * nodes, np.arange(count)
        acting = (place[:, None] + np.arange(DIRECTIONS)).ravel()
        ways = np.zeros((DIRECTIONS * count, count))
        for direction in range(DIRECTIONS):
            ways[DIRECTIONS * own + direction, own] = -whole.ways[i, nodes, direction]
        rows, free = self.flexible[np.ix_(place, acting)], self.place[place] @ state
        if not whole.turns:
            return np.asarray(-ways @ np.linalg.solve(rows @ ways, free))
        cosine, sine = np.cos(whole.angle[i, nodes]), np.sin(whole.angle[i, nodes])
        turned, pressed = np.zeros_like(ways), whole.friction * whole.normal[i, nodes]
        turned[DIRECTIONS * own + 1, own] = pressed * sine
        turned[DIRECTIONS * own + 2, own] = -pressed * cosine
        axial, tangential = place + 2, place + 1
        across = cosine[:, None] * self.rate[np.ix_(axial, acting)]
        across -= sine[:, None] * self.rate[np.ix_(tangential, acting)]
        lost = whole.compliance / whole.step
        free_across = cosine[:, None] * (self.velocity[axial] @ state - lost[axial] @ before)
        free_across -= sine[:, None] * (
            self.velocity[tangential] @ state - lost[tangential] @ before
        )
        slip = whole.slip[i, nodes]
        along = slip[:, 1] * sine + slip[:, 0] * cosine
        both = np.hstack([ways, turned])
        matrix = np.vstack([rows, across]) @ both
        matrix[count:, count:] -= np.diag(along)
        return np.asarray(-both @ np.linalg.solve(matrix, np.vstack([free, free_across])))
