"""Arrays for the coupling of the rotor modes by Coriolis forces and damping."""

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.solvers.kernel.structs import Struct, aligned, aligned_copy, lib, padded
from bladewhirl.solvers.packing.arrangement import Arrangement

ROUNDING = 1e-14
"""An entry of A^-1 up to this fraction of the largest counts as zero."""

ALIKE = 1e-12
"""Cosine and sine modes are equally damped if their damping differs by at most this fraction of the
largest."""


def pack_gyroscopic(
    problem: ContactProblem, packed: Struct, arrangement: Arrangement, dt: float
) -> Struct | None:
    """Return the coupling of the rotor modes by Coriolis forces; None without Coriolis forces.

    Args:
        problem: contact problem.
        packed: arrays of the rotor.
        arrangement: arrangement of the rotor modes.
        dt: time step [s].
    """
    rotor = problem.rotor
    if rotor.by_velocity is None:
        return None
    damping = rotor.damping
    inverse = turning_inverse(damping, dt)
    loss, full_loss = _losses((damping + damping.T) / 2.0, arrangement)
    stands_still = [0, 1] if rotor.circulation != 0.0 else []
    pull = rotor.circulation * rotor.centre * np.array([[1.0], [-1.0]])
    cyclic, none = arrangement.half > 0, np.zeros(0, dtype=np.int64)
    blocks, rest, to, by = (
        _blocks(inverse, arrangement) if cyclic else (aligned(0), aligned(0), none, none)
    )
    normal, normal_across, shear, shear_across = (
        _answers(inverse, arrangement, packed) if cyclic else 4 * [aligned((0, lib.LANES))]
    )
    return Struct(
        "Gyroscopic",
        blocks=blocks,
        rest=rest,
        to=to,
        by=by,
        full=arrangement.pack(inverse.T[: 0 if cyclic else None]),
        loss=loss,
        full_loss=full_loss,
        normal=normal,
        normal_across=normal_across,
        shear=shear,
        shear_across=shear_across,
        circulation=arrangement.pack(pull[stands_still]),
        centre=arrangement.pack(rotor.centre[::-1][stands_still]),
    )


def _blocks(
    inverse: FloatArray, arrangement: Arrangement
) -> tuple[FloatArray, FloatArray, IntArray, IntArray]:
    """Split A^-1 (modes, modes) of a cyclic rotor into a block for each nodal diameter and a rest.

    Returns:
        the blocks in the order of the kernel; the nonzero entries outside the blocks; the row and
        the column of each of these entries.
    """
    rows, columns, half = arrangement.rows, arrangement.columns, arrangement.half
    entries = arrangement.entries
    full = np.zeros((entries, entries))
    full[np.ix_(arrangement.entry, arrangement.entry)] = inverse
    grid = full.reshape(rows, columns, rows, columns)
    cosine = np.arange(half)
    sine = half + cosine
    direct, across = grid[:, cosine, :, cosine].copy(), grid[:, cosine, :, sine].copy()
    for to, by, block in (
        (cosine, cosine, direct),
        (sine, sine, direct),
        (cosine, sine, across),
        (sine, cosine, -across),
    ):
        grid[:, to, :, by] -= block
    empty = np.setdiff1d(np.arange(entries), arrangement.entry)  # positions without a mode
    full[empty], full[:, empty] = 0.0, 0.0
    to, by = np.nonzero(np.abs(full) > ROUNDING * np.abs(inverse).max())
    order = np.argsort(by, kind="stable")
    blocks = np.zeros((2, half, padded(rows, lib.ROWS), rows))
    blocks[:, :, :rows] = direct, across
    registers = blocks.reshape(2, half // lib.HALF, lib.HALF, -1, lib.ROWS, rows).transpose(
        1, 3, 5, 0, 4, 2
    )
    return aligned_copy(registers.reshape(-1)), full[to, by][order], to[order], by[order]


def _losses(damping: FloatArray, arrangement: Arrangement) -> tuple[FloatArray, FloatArray]:
    """Return the matrices from which the kernel computes the dissipation d^T D d.

    If the damping of cosine and sine modes is equal, D is stored as blocks, otherwise as a matrix
    of all modes. Blocks and matrix contain upper triangles only, with doubled entries outside the
    diagonal.

    Args:
        damping: D, symmetric [1/s], (modes, modes).
        arrangement: arrangement of the modes.

    Returns:
        the blocks, in the order of `Gyroscopic`, and the matrix of all modes, (entries, entries);
        one of the two is empty.
    """
    rows, half, entries = arrangement.rows, arrangement.half, arrangement.entries
    full = aligned((entries, entries))
    full[np.ix_(arrangement.entry, arrangement.entry)] = damping
    twice = np.triu(2.0 * full) - np.diag(np.diag(full))
    grid = twice.copy().reshape(2 * [rows, arrangement.columns])
    cosine = np.arange(half)
    direct = np.zeros((half, padded(rows, lib.ROWS), rows))
    direct[:, :rows] = grid[:, cosine, :, cosine]
    for column in (cosine, half + cosine):
        grid[:, column, :, column] -= direct[:, :rows]
    left = grid.reshape(entries, entries)[np.ix_(arrangement.entry, arrangement.entry)]
    if half == 0 or np.abs(left).max(initial=0.0) > ALIKE * np.abs(damping).max(initial=0.0):
        return aligned(0), aligned_copy(twice)
    registers = direct.reshape(half // lib.HALF, lib.HALF, -1, lib.ROWS, rows).transpose(
        0, 2, 4, 3, 1
    )
    groups = [registers[:, g, g * lib.ROWS :] for g in range(registers.shape[1])]
    by_register = [
        np.concatenate([group[h].ravel() for group in groups]) for h in range(len(registers))
    ]
    return aligned_copy(np.concatenate(by_register)), aligned((0, lib.LANES))


def _answers(inverse: FloatArray, arrangement: Arrangement, rotor: Struct) -> list[FloatArray]:
    """Return the response of the modes of a cyclic rotor to forces at the tips, by column.

    Returns:
        response to normal forces in the column of a mode and in its partner column, then response
        to friction forces in these columns, (rows, columns) each.
    """
    columns, half = arrangement.columns, arrangement.half
    modes, column = np.arange(len(inverse)), arrangement.entry % columns
    partner = (column + half) % columns
    answers = []
    for direct, across in (
        (rotor.radial, np.zeros_like(rotor.radial)),
        (rotor.tangential, rotor.crossed),
    ):
        force = np.zeros((len(modes), columns))
        force[modes, column] = direct.ravel()[arrangement.entry]
        force[modes, partner] += across.ravel()[arrangement.entry]
        answer = inverse @ force
        answers += [arrangement.grid(answer[modes, each]) for each in (column, partner)]
    return answers


def turning_inverse(damping: FloatArray, dt: float) -> FloatArray:
    """Return A^-1 of a rotor whose modes are coupled by forces due to velocities [s2],
    (modes, modes)."""
    return np.asarray(np.linalg.inv(np.eye(len(damping)) / dt**2 + damping / (2.0 * dt)))
