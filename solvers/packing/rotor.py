"""Arrays of the rotor and its contact nodes: by harmonic for a cyclic rotor, otherwise dense for
each copy. Arrays for the coupling of its modes by Coriolis forces and damping."""

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.reduced_rotor import ReducedRotor
from bladewhirl.models.structure.dft import real_dft
from bladewhirl.models.superelements.diameters import blade_numbers, by_diameter
from bladewhirl.solvers.kernel.structs import Arrays, Struct, aligned, aligned_copy, lib, padded
from bladewhirl.solvers.packing.arrangement import (
    FIT,
    PAIR,
    Arrangement,
    Harmonics,
    by_column,
    closed_nodes,
    folded,
    lengthened,
    pack_body,
    scheme_inverse,
)

FOLDED = 96
"""Number of blades from which displacements of tips are computed on a quarter of the circle, see
`arrangement.folded`. With fewer blades this saves less than a tenth of a step."""

ROUNDING = 1e-14
"""An entry of a matrix up to this fraction of the largest counts as zero."""

ALIKE = 1e-12
"""Cosine and sine modes are equally damped if their damping differs by at most this fraction of the
largest."""


DIRECTIONS = 3
"""Components of the displacement of a contact node: radial, tangential, axial."""


BladeColumns = tuple[int, IntArray]
"""Number of equal blades, and the DFT column over these blades of each mode, (modes,)."""


def blade_columns(rotor: ReducedRotor) -> BladeColumns | None:
    """Return the DFT columns over the blades, with which harmonics are treated separately; None if
    there are none, or if dense products are faster because there are fewer modes than blades.

    The blades of a wheel are equal if their contact nodes are the same, turned by the distance of
    blades, and if each mode moves the nodes with one nodal diameter. Which mode of a pair is called
    cosine has no meaning then, as a mode may have both parts.
    """
    tips, modes = len(rotor.tip_angle), len(rotor.frequency)
    if rotor.by_harmonics:
        return tips, rotor.column
    if rotor.copies > 1:
        return None
    for blades in blade_numbers(rotor.tip_angle):
        if blades >= modes:
            continue
        parts, of_column, diameter = by_diameter(rotor.contact, blades)
        others = parts * (of_column[:, None] != diameter)[:, None]
        left, moved = (np.einsum("bc,cim->bim", real_dft(blades), each) for each in (others, parts))
        left, moved = (np.abs(each).max(axis=(0, 2)) for each in (left, moved))
        if not (left <= 0.5 * FIT * moved).all():
            continue
        column = np.maximum(2 * diameter - 1, 0)
        for k in range(1, (blades + 1) // 2):
            cosine, sine = parts[2 * k - 1], parts[2 * k]
            own = np.flatnonzero(diameter == k)
            own = own[np.argsort(rotor.frequency[own], kind="stable")]
            first, second = own[0::2], own[1::2]
            for one, other in zip(first, second, strict=False):  # turned by a quarter of a wave
                turn = cosine[:, one] @ sine[:, other] - sine[:, one] @ cosine[:, other]
                column[other if turn > 0.0 else one] += 1
        return blades, column
    return None


def pack_rotor(
    problem: ContactProblem, dt: float, columns: BladeColumns | None
) -> tuple[Arrangement, Struct]:
    """Return the arrangement and the arrays of the rotor.

    Args:
        problem: contact problem.
        dt: time step [s].
        columns: DFT columns, see `blade_columns`; None to use none.

    Raises:
        ValueError: modes do not vary as their DFT columns.
    """
    rotor = problem.rotor
    contact, inverses, flexible = rotor.contact, rotor_inverses(rotor, dt), rotor.compliance
    compliance = contact @ inverses @ contact.T if flexible is None else flexible
    arrangement, arrays = (
        _dense(rotor) if columns is None else _harmonics(problem, columns, inverses[0])
    )
    return arrangement, Struct(
        "Rotor",
        body=_body(problem, arrangement, dt),
        copies=rotor.copies,
        half=arrangement.half,
        compliance=_by_force(compliance),
        massless=float(flexible is not None),
        full=float(problem.sliding == "full"),
        axial=float(problem.sliding == "full" or problem.joints is not None),
        **arrays,
        **_places(problem),
    )


def _harmonics(
    problem: ContactProblem, columns: BladeColumns, inverse: FloatArray
) -> tuple[Arrangement, Arrays]:
    """Return the arrangement of the modes by harmonic, and the weights of a blade's components.

    Args:
        problem: contact problem.
        columns: DFT columns, see `blade_columns`.
        inverse: A^-1, see `rotor_inverses`.
    """
    rotor, turning = problem.rotor, problem.rotor.by_velocity is not None
    blades, column = columns
    fold = blades >= FOLDED and not turning and problem.foreshortening is None
    harmonics = Harmonics(blades, fold=fold, unit=lib.HALF, alone=turning)
    arrangement = harmonics.arrangement(harmonics.place[column])
    # Forces on massless nodes act on the modes before the product with A^-1.
    couples = turning and rotor.compliance is None
    components = rotor.contact.reshape(blades, -1, len(inverse)).swapaxes(0, 1)
    weights, answers, crosses = [], [], []
    for rows in components:
        own, across = harmonics.amplitudes(rows, column)
        crosses.append(np.abs(across).max(initial=0.0) > FIT * np.abs(own).max(initial=0.0))
        across = across * crosses[-1]
        weights.append([arrangement.grid(each) for each in (own, across)])
        answers.append(_answers(inverse, arrangement, own, across) if couples else [])
    own, across = (aligned_copy(np.array(each)) for each in zip(*weights, strict=True))
    answer = answer_across = own[:0]
    if couples:
        answer, answer_across = (
            aligned_copy(np.array(each)) for each in zip(*answers, strict=True)
        )
    return arrangement, {
        "contact": aligned((0, 0)),
        "columns": aligned((DIRECTIONS, 0, 0)),
        "own": own,
        "across": across,
        "crosses": np.array(crosses, dtype=np.int64),
        "answer": answer,
        "answer_across": answer_across,
        "shape": by_column(harmonics.shape, arrangement),
        "fold": folded(harmonics.shape, arrangement),
        "spread": aligned_copy(harmonics.shape),
    }


def _dense(rotor: ReducedRotor) -> tuple[Arrangement, Arrays]:
    """Return an arrangement with a row of modes for each copy, and the displacements of the contact
    nodes of a copy."""
    contact = rotor.contact
    modes = contact.shape[1]
    columns = padded(max(modes, 1), PAIR)
    place = columns * np.arange(rotor.copies)[:, None] + np.arange(modes)
    arrangement = Arrangement(rows=rotor.copies, columns=columns, entry=place.ravel(), used=modes)
    by_direction = contact.reshape(-1, DIRECTIONS, modes).transpose(1, 2, 0)
    none, empty = aligned((0, 0, 0)), aligned((0, lib.LANES))
    return arrangement, {
        "contact": aligned_copy(contact),
        "columns": aligned_copy(by_direction),
        **dict.fromkeys(("own", "across", "answer", "answer_across"), none),
        "crosses": np.zeros(0, dtype=np.int64),
        **dict.fromkeys(("shape", "fold", "spread"), empty),
    }


def _by_force(compliance: FloatArray) -> FloatArray:
    """Return for each unit force the radial displacements of all nodes, then the tangential and the
    axial ones, from the displacements node by node, (copies, components, components)."""
    copies, size, _ = compliance.shape
    columns = compliance.swapaxes(1, 2).reshape(copies, size, size // DIRECTIONS, DIRECTIONS)
    return aligned_copy(columns.swapaxes(2, 3).reshape(copies, size, size))


def _body(problem: ContactProblem, arrangement: Arrangement, dt: float) -> Struct:
    rotor, loads = problem.rotor, [load.rotor for load in problem.loads]
    coupled = rotor.by_velocity is not None
    return pack_body(rotor.frequency, rotor.damping_ratio, loads, arrangement, dt, coupled=coupled)


def _places(problem: ContactProblem) -> Arrays:
    rotor, elements = problem.rotor, problem.casing.elements
    return {
        "wall": closed_nodes(problem.casing).shape[1] * rotor.wall,
        "position": lengthened(rotor.tip_angle * elements / (2.0 * np.pi)),
        "radius": lengthened(np.tile(rotor.contact_radius, rotor.copies)),
        "recess": lengthened(problem.metal_recess),
        "normal_part": lengthened(rotor.normal_part),
    }


def rotor_inverses(rotor: ReducedRotor, dt: float) -> FloatArray:
    """Return A^-1 of each copy of the rotor [s2], (copies, modes, modes); see
    `CentralDifference`."""
    if rotor.by_velocity is None:
        inverse = scheme_inverse(rotor.frequency, rotor.damping_ratio, dt)
        return np.array([np.diag(row) for row in rotor.by_copy(inverse)])
    damping = rotor.velocity_forces
    return np.asarray(np.linalg.inv(np.eye(damping.shape[-1]) / dt**2 + damping / (2.0 * dt)))


def pack_gyroscopic(
    problem: ContactProblem, arrangement: Arrangement, dt: float, like: Struct | None = None
) -> Struct | None:
    """Return the coupling of the rotor modes by Coriolis forces; None without Coriolis forces.

    Args:
        problem: contact problem.
        arrangement: arrangement of the rotor modes.
        dt: time step [s].
        like: the coupling at another speed, whose places of entries outside the blocks are kept.
    """
    rotor = problem.rotor
    if rotor.by_velocity is None:
        return None
    inverses = rotor_inverses(rotor, dt)
    damping = rotor.velocity_forces
    loss, full_loss, crosses = _losses((damping + damping.swapaxes(1, 2)) / 2.0, arrangement)
    stands_still = [0, 1] if rotor.circulation != 0.0 else []
    pull = rotor.circulation * rotor.centre * np.array([[1.0], [-1.0]])
    part = None if like is None else like.inverse
    return Struct(
        "Gyroscopic",
        inverse=modal_matrix(inverses, arrangement, part),
        loss=loss,
        loss_crosses=crosses,
        full_loss=full_loss,
        loss_end=_ends(full_loss),
        circulation=arrangement.pack(pull[stands_still]),
        centre=arrangement.pack(rotor.centre[::-1][stands_still]),
    )


def modal_matrix(
    matrices: FloatArray,
    arrangement: Arrangement,
    like: Struct | None = None,
) -> Struct:
    """Return a matrix over the modes of the rotor.

    Args:
        matrices: matrix of each copy, (copies, modes, modes).
        arrangement: arrangement of the rotor modes.
        like: a matrix whose places of entries outside the blocks are kept.
    """
    none = np.zeros(0, dtype=np.int64)
    blocks, rest, to, by = aligned(0), aligned(0), none, none
    full = aligned((0, lib.LANES))
    if arrangement.half > 0:
        places = None if like is None else (like.to, like.by)
        blocks, rest, to, by = _blocks(matrices[0], arrangement, places)
    else:
        full = _rows_by_copy(matrices, arrangement)
    first, last = _spans(full, len(matrices))
    return Struct(
        "ModalMatrix", blocks=blocks, rest=rest, to=to, by=by, full=full, first=first, last=last
    )


def _spans(rows: FloatArray, copies: int) -> tuple[IntArray, IntArray]:
    """Return the first row and the end of the rows of each copy in which the columns that the
    kernel processes together are not all zero, (copies * columns / PAIR,). Modes of one nodal
    diameter follow one another, so that few rows remain of a wheel."""
    size, spans = len(rows) // copies, copies * (rows.shape[1] // PAIR)
    if not size:
        none = np.zeros(spans, dtype=np.int64)
        return none, none
    entries = rows.reshape(copies, size, -1, PAIR).swapaxes(1, 2).reshape(spans, size, PAIR)
    used = np.asarray((entries != 0.0).any(axis=2))
    ends = np.where(used.any(axis=1), size - used[:, ::-1].argmax(axis=1), 0)
    return used.argmax(axis=1).astype(np.int64), ends.astype(np.int64)


def _ends(rows: FloatArray) -> IntArray:
    """Return the number of entries of each row up to the last that is not zero, (rows,)."""
    numbers = np.arange(1, rows.shape[1] + 1)
    return np.asarray((numbers * (rows != 0.0)).max(axis=1, initial=0), dtype=np.int64)


def _rows_by_copy(inverses: FloatArray, arrangement: Arrangement) -> FloatArray:
    """Return the response of the modes of a copy to a force on each mode, (modes, columns)."""
    copies, modes, _ = inverses.shape
    rows = aligned((copies * modes, arrangement.entries // copies))
    rows[:, :modes] = inverses.swapaxes(1, 2).reshape(copies * modes, modes)
    return rows


def _blocks(
    inverse: FloatArray,
    arrangement: Arrangement,
    places: tuple[IntArray, IntArray] | None,
) -> tuple[FloatArray, FloatArray, IntArray, IntArray]:
    """Split a matrix (modes, modes) of a cyclic rotor into a block for each nodal diameter and a
    rest, at given places or where it is not zero.

    Returns:
        the blocks in the order of the kernel; the nonzero entries outside the blocks; the row and
        the column of each of these entries.
    """
    rows, half = arrangement.rows, arrangement.half
    own, across, full = _split(inverse, arrangement)
    if places is None:
        to, by = np.nonzero(np.abs(full) > ROUNDING * np.abs(inverse).max(initial=0.0))
        order = np.argsort(by, kind="stable")
        places = to[order], by[order]
    blocks = np.zeros((2, half, padded(rows, lib.ROWS), rows))
    blocks[:, :, :rows] = own, across
    registers = blocks.reshape(2, half // lib.HALF, lib.HALF, -1, lib.ROWS, rows).transpose(
        1, 3, 5, 0, 4, 2
    )
    return aligned_copy(registers.reshape(-1)), full[places], *places


def _split(
    matrix: FloatArray, arrangement: Arrangement
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the blocks R and X of a matrix (modes, modes) of a cyclic rotor for each cosine
    column, (half, rows, rows) each, see `ModalMatrix` in `kernel.h`, and what is left, (entries,
    entries)."""
    rows, columns, entries = arrangement.rows, arrangement.columns, arrangement.entries
    full = np.zeros((entries, entries))
    full[np.ix_(arrangement.entry, arrangement.entry)] = matrix
    grid = full.reshape(rows, columns, rows, columns)
    cosine = np.arange(arrangement.half)
    sine = arrangement.half + cosine
    own, across = grid[:, cosine, :, cosine].copy(), grid[:, cosine, :, sine].copy()
    for to, by, block in (
        (cosine, cosine, own),
        (sine, sine, own),
        (cosine, sine, across),
        (sine, cosine, -across),
    ):
        grid[:, to, :, by] -= block
    empty = np.setdiff1d(np.arange(entries), arrangement.entry)  # positions without a mode
    full[empty], full[:, empty] = 0.0, 0.0
    return own, across, full


def _losses(damping: FloatArray, arrangement: Arrangement) -> tuple[FloatArray, FloatArray, int]:
    """Return the matrices from which the kernel computes the dissipation d^T D d.

    If the damping couples cosine and sine modes as waves do, D is stored as blocks, otherwise as a
    matrix of all modes. Blocks and matrix contain upper triangles only, with doubled entries
    outside the diagonal.

    Args:
        damping: D of each copy, symmetric [1/s], (copies, modes, modes).
        arrangement: arrangement of the modes.

    Returns:
        the blocks, in the order of `Gyroscopic`, and the matrix of all modes of each copy,
        (entries, columns), of which one is empty, without damping both; 1 if the blocks have X.
    """
    half, entries = arrangement.half, arrangement.entries
    none = aligned(0), aligned((0, lib.LANES))
    if not damping.any():
        return *none, 0
    if half > 0:
        own, across, left = _split(damping[0], arrangement)
        least = ALIKE * np.abs(damping).max()
        if np.abs(left).max(initial=0.0) <= least:
            crosses = bool(np.abs(across).max(initial=0.0) > least)
            return _loss_blocks([own, across] if crosses else [own]), none[1], int(crosses)
    copies, modes, _ = damping.shape
    full = aligned((copies, entries // copies, entries // copies))
    entry = arrangement.entry[:modes]
    full[np.ix_(np.arange(copies), entry, entry)] = damping
    twice = np.triu(2.0 * full) - full * np.eye(entries // copies)
    return none[0], aligned_copy(twice.reshape(entries, -1)), 0


def _loss_blocks(kinds: list[FloatArray]) -> FloatArray:
    """Return blocks of damping, of one kind or of two, (half, rows, rows) each, in the order of
    `Gyroscopic`."""
    half, rows, _ = kinds[0].shape
    blocks = np.zeros((len(kinds), half, padded(rows, lib.ROWS), rows))
    blocks[:, :, :rows] = [np.triu(2.0 * kind) - kind * np.eye(rows) for kind in kinds]
    registers = blocks.reshape(len(kinds), half // lib.HALF, lib.HALF, -1, lib.ROWS, rows)
    registers = registers.transpose(1, 3, 5, 0, 4, 2)
    groups = range(registers.shape[1])
    parts = [each[g, g * lib.ROWS :].ravel() for each in registers for g in groups]
    return aligned_copy(np.concatenate(parts))


def _answers(
    inverse: FloatArray, arrangement: Arrangement, own: FloatArray, across: FloatArray
) -> list[FloatArray]:
    """Return the response of the modes of a cyclic rotor to forces on a component of the blades, in
    the column of a mode and in its partner column, (rows, columns) each.

    Args:
        inverse: response of the modes to modal forces, (modes, modes).
        arrangement: arrangement of the modes.
        own: weight of each mode in its column, (modes,).
        across: weight of each mode in the partner column, (modes,).
    """
    columns = arrangement.columns
    modes, column = np.arange(len(inverse)), arrangement.entry % columns
    partner = (column + arrangement.half) % columns
    force = np.zeros((len(modes), columns))
    force[modes, column] = own
    force[modes, partner] += across
    answer = inverse @ force
    return [arrangement.grid(answer[modes, each]) for each in (column, partner)]
