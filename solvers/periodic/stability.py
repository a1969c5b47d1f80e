"""Stability of a periodic motion in contact: the monodromy matrix and its eigenvalues.

Small deviations of the state of the modes and of the contact forces satisfy the derivatives of the
equations of the motion, with the same nodes in contact at each instant. The force of a massless
contact node is continuous where the node opens and closes, so that deviations do not jump there.
"""

from dataclasses import dataclass

import numpy as np

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray, IntArray
from bladewhirl.solvers.periodic.blade import DIRECTIONS
from bladewhirl.solvers.periodic.contact import Motion


@dataclass(frozen=True)
class Monodromy:
    """Change of small deviations over one period."""

    matrix: FloatArray
    """Matrix of the state (unit q, q') of the modes, with f if there is always contact,
    (states, states)."""
    modes: int  #: number of modes

    @property
    def multipliers(self) -> ComplexArray:
        """Eigenvalues of the modes, the largest first, (2 * modes,). The contact forces follow from
        the modes, and have eigenvalues of zero."""
        values = np.linalg.eigvals(self.matrix)
        values = values[np.argsort(-np.abs(values), kind="stable")]
        return np.asarray(values[: 2 * self.modes], dtype=np.complex128)

    @property
    def stable(self) -> bool:
        """True if all deviations decay."""
        return bool(np.abs(self.multipliers[0]) < 1.0)


def monodromy(motion: Motion) -> Monodromy:
    """Return the monodromy matrix of a periodic motion.

    The period begins at an instant without contact, if there is one, so that the forces follow from
    the modes. Without contact, powers of the matrix of a step carry the state to the next contact.
    """
    grid, modes = motion.grid, len(motion.grid.blade.stiffness)
    carried, early, late = grid.transition
    split, held = len(carried), motion.normal > 0.0
    first = int(np.argmin(held.any(axis=1)))
    matrix = np.eye(split + (early.shape[1] if held[first].any() else 0))
    state, force = matrix[:split], np.zeros((early.shape[1], len(matrix)))
    force[: len(matrix) - split] = matrix[split:]
    waiting = 0
    for i in [*range(first + 1, grid.instants), *range(first + 1)]:
        nodes = np.flatnonzero(held[i])
        if not len(nodes) and not force.any():
            waiting += 1
            continue
        state = carried @ grid.carry(state, waiting) + early @ force  # without new forces
        waiting, before, force = 0, force, np.zeros_like(force)
        if len(nodes):
            force = _forces(motion, motion.slip[i], i, nodes, state, before)
            state = state + late @ force
    early_rest = waiting // 2  # `carry` is for less than a period
    state = grid.carry(grid.carry(state, early_rest), waiting - early_rest)
    matrix = np.concatenate([state, force[: len(matrix) - split]])
    return Monodromy(matrix, modes)


def _forces(
    motion: Motion,
    slip: FloatArray,
    i: int,
    nodes: IntArray,
    state: FloatArray,
    before: FloatArray,
) -> FloatArray:
    """Return the deviations of the forces at an instant, (3 * nodes, columns).

    Args:
        motion: the periodic motion.
        slip: slip velocities at the instant, (nodes, 2).
        i: number of the instant.
        nodes: numbers of the nodes in contact.
        state: deviations of the state of the modes without these forces, (states, columns).
        before: deviations of the forces at the instant before, (3 * nodes, columns).
    """
    grid, blade = motion.grid, motion.grid.blade
    to_place, to_velocity = grid.to_nodes
    late, flexible = grid.transition[2], blade.compliance
    place = DIRECTIONS * nodes
    ways = np.zeros((len(flexible), len(nodes)))
    for direction in range(DIRECTIONS):
        ways[place + direction, np.arange(len(nodes))] = -motion.ways[i, nodes, direction]
    rows, free = to_place[place] @ late + flexible[place], to_place[place] @ state
    if not blade.turns:
        return np.asarray(-ways @ np.linalg.solve(rows @ ways, free))
    cosine, sine = np.cos(motion.angle[i, nodes]), np.sin(motion.angle[i, nodes])
    turned, pressed = np.zeros_like(ways), blade.friction * motion.normal[i, nodes]
    turned[place + 1, np.arange(len(nodes))] = pressed * sine
    turned[place + 2, np.arange(len(nodes))] = -pressed * cosine
    rate = to_velocity @ late + flexible / grid.step
    free_rate = to_velocity @ state - flexible @ before / grid.step
    across, free_across = (
        cosine[:, None] * each[place + 2] - sine[:, None] * each[place + 1]
        for each in (rate, free_rate)
    )
    along = slip[nodes, 1] * sine + slip[nodes, 0] * cosine
    both = np.hstack([ways, turned])
    matrix = np.vstack([rows, across]) @ both
    matrix[len(nodes) :, len(nodes) :] -= np.diag(along)
    return np.asarray(-both @ np.linalg.solve(matrix, np.vstack([free, free_across])))
