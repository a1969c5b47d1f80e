"""Arrays of the rotor: by harmonic for a cyclic rotor, otherwise dense. Arrays for the coupling of
its modes by Coriolis forces and damping."""

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.stage.contact_problem import ContactProblem, ReducedRotor
from bladewhirl.solvers.kernel.structs import Struct, aligned, aligned_copy, lib, padded
from bladewhirl.solvers.packing.arrangement import (
    FIT,
    Arrangement,
    Harmonics,
    by_column,
    by_sliding,
    dense_arrangement,
    lengthened,
    pack_body,
    scheme_inverse,
)

ROUNDING = 1e-14
"""An entry of A^-1 up to this fraction of the largest counts as zero."""

ALIKE = 1e-12
"""Cosine and sine modes are equally damped if their damping differs by at most this fraction of the
largest."""


def pack_rotor(problem: ContactProblem, dt: float, *, cyclic: bool) -> tuple[Arrangement, Struct]:
    """Return the arrangement and the arrays of the rotor.

    Args:
        problem: contact problem.
        dt: time step [s].
        cyclic: use the DFT columns of the modes.

    Raises:
        ValueError: modes do not vary as their DFT columns.
    """
    rotor = problem.rotor
    tips, modes = rotor.tip_radial.shape
    inverse, turning = rotor_inverse(rotor, dt), rotor.by_velocity is not None
    if cyclic:
        harmonics = Harmonics(tips, fold=False, unit=lib.HALF, alone=turning)
        arrangement = harmonics.arrangement(harmonics.place[rotor.column])
        radial, across = harmonics.amplitudes(rotor.tip_radial, rotor.column)
        if not np.abs(across).max(initial=0.0) <= FIT * np.abs(radial).max(initial=0.0):
            raise ValueError(
                "a cyclic rotor's mode pairs must be aligned to the tips' radial motion"
            )
        tangential, crossed = harmonics.amplitudes(rotor.tip_tangential, rotor.column)
        shape, cross_shape = harmonics.shape, harmonics.crossed
    else:
        arrangement = dense_arrangement(modes)
        radial, tangential, crossed = np.ones(modes), np.zeros(modes), np.ones(modes)
        shape, cross_shape = map(arrangement.pack, (rotor.tip_radial, rotor.tip_tangential))
    # radial response of the tips to unit forces at the tips
    pressed, dragged = (
        (rows @ inverse.T if turning else rows * inverse.diagonal()) @ rotor.tip_radial.T
        for rows in (rotor.tip_radial, rotor.tip_tangential)
    )
    spread = aligned_copy(shape)
    loads = [load.rotor for load in problem.loads]
    return arrangement, Struct(
        "Rotor",
        body=pack_body(
            rotor.frequency,
            rotor.damping_ratio,
            loads,
            arrangement,
            dt,
            coupled=turning,
        ),
        radial=arrangement.grid(radial),
        tangential=arrangement.grid(tangential),
        crossed=arrangement.grid(crossed),
        shape=by_column(shape, arrangement),
        cross_shape=by_column(cross_shape, arrangement),
        spread=spread,
        drag_spread=spread if cyclic else aligned_copy(cross_shape),
        half=arrangement.half,
        shared=cyclic,
        w=by_sliding(pressed, dragged, problem.friction),
        position=lengthened(rotor.tip_angle * len(problem.casing.nodal) / (2.0 * np.pi)),
        recess=lengthened(problem.metal_recess),
    )


def rotor_inverse(rotor: ReducedRotor, dt: float) -> FloatArray:
    """Return A^-1 of the rotor [s2], (modes, modes); see `CentralDifference`."""
    if rotor.by_velocity is None:
        return np.diag(scheme_inverse(rotor.frequency, rotor.damping_ratio, dt))
    damping = rotor.damping
    return np.asarray(np.linalg.inv(np.eye(len(damping)) / dt**2 + damping / (2.0 * dt)))


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
    inverse = rotor_inverse(rotor, dt)
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
