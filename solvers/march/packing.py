"""Lay a contact problem out for the kernel: cyclic where the bodies are, dense otherwise."""

from __future__ import annotations

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.coupling.springs import CouplingSprings
from bladewhirl.models.stage.contact_problem import ContactProblem, ReducedCasing, ReducedRotor
from bladewhirl.solvers.kernel.arrays import (
    U_KIND,
    U_SLOPE,
    W_KIND,
    W_SLOPE,
    BodyArrays,
    CasingArrays,
    ContactScratch,
    DamperArrays,
    DamperEnds,
    FieldScratch,
    GyroscopicArrays,
    NodalField,
    RotorArrays,
    Scratch,
    SpringArrays,
    SpringEnds,
    SpringScratch,
)
from bladewhirl.solvers.kernel.vectors import HALF, LANES
from bladewhirl.solvers.march.arrangement import (
    FIT,
    Arrangement,
    Harmonics,
    aligned,
    aligned_copy,
    dense_arrangement,
    padded,
)

ROUNDING = 1e-14
"""Entries of A^-1 below this share of the largest are rounding."""


def _lengthened(values: FloatArray) -> FloatArray:
    """Vector padded to whole registers."""
    out = aligned(padded(len(values)))
    out[: len(values)] = values
    return out


def _by_column(shape: FloatArray, arrangement: Arrangement) -> FloatArray:
    """Shape (points, columns) as (columns to the last in use, padded points)."""
    used = arrangement.half + arrangement.parts * arrangement.used
    out = aligned((used, padded(len(shape))))
    out[:, : len(shape)] = shape[:, :used].T
    return out


def _folded(shape: FloatArray, arrangement: Arrangement) -> FloatArray:
    """Shape (nodes, columns) on a quarter of the circle, as the kernel's `_folded_fields` has it.

    No rows where the kernel cannot fold: without parity, or on so few nodes that whole registers
    of a quarter reach over half of the circle.
    """
    nodes = len(shape)
    width = padded(nodes // 4 + 1)
    if arrangement.parts == 1 or width - 1 > nodes // 2:
        return aligned((0, LANES))
    own = shape[:width]
    last = own[:, arrangement.half + arrangement.used - 1]
    rows = own[:, np.concatenate([arrangement.columns_of(part) for part in range(2)])].T
    rows = rows.reshape(2, 2, arrangement.used, width).transpose(1, 0, 2, 3).reshape(-1, width)
    rows[3 * arrangement.used - 1] = 0.0
    return aligned_copy(np.vstack([rows, last]))


def _by_sliding(pressed: FloatArray, dragged: FloatArray, friction: float) -> FloatArray:
    """Response to a normal force with its friction, for sliding backward, none, and forward."""
    return np.array([pressed + s * friction * dragged for s in (-1.0, 0.0, 1.0)])


def pack_rotor(
    problem: ContactProblem, dt: float, *, cyclic: bool
) -> tuple[Arrangement, RotorArrays]:
    """Arrange the rotor.

    Args:
        problem: what is marched.
        dt: time step [s].
        cyclic: whether to use the DFT columns of the rotor's modes.

    Raises:
        ValueError: modes that do not follow their DFT columns.
    """
    rotor = problem.rotor
    tips, modes = rotor.tip_radial.shape
    if cyclic:
        harmonics = Harmonics(tips, fold=False, unit=HALF)
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
        shape = np.zeros((tips, arrangement.columns))
        cross_shape = np.zeros((tips, arrangement.columns))
        shape[:, :modes], cross_shape[:, :modes] = rotor.tip_radial, rotor.tip_tangential
    pressed, dragged = _answer_at_tips(rotor, dt)
    spread = aligned_copy(shape)
    loads = [load.rotor for load in problem.loads]
    return arrangement, RotorArrays(
        body=pack_body(
            rotor.frequency,
            rotor.damping_ratio,
            loads,
            arrangement,
            dt,
            coupled=rotor.by_velocity is not None,
        ),
        radial=arrangement.grid(radial),
        tangential=arrangement.grid(tangential),
        crossed=arrangement.grid(crossed),
        shape=_by_column(shape, arrangement),
        cross_shape=_by_column(cross_shape, arrangement),
        spread=spread,
        drag_spread=spread if cyclic else aligned_copy(cross_shape),
        half=arrangement.half,
        shared=cyclic,
        w=_by_sliding(pressed, dragged, problem.friction).reshape(3 * tips, tips),
        position=_lengthened(rotor.tip_angle * len(problem.casing.nodal) / (2.0 * np.pi)),
        recess=_lengthened(rotor.tip_recess),
    )


def _answer_at_tips(rotor: ReducedRotor, dt: float) -> tuple[FloatArray, FloatArray]:
    """Radial answer A^-1 of the tips to forces on them, radial and tangential, (forces, tips)."""
    if rotor.by_velocity is None:
        inverse = scheme_inverse(rotor.frequency, rotor.damping_ratio, dt)
        radial, tangential = rotor.tip_radial * inverse, rotor.tip_tangential * inverse
    else:
        full = _turning_inverse(rotor.damping, dt).T
        radial, tangential = rotor.tip_radial @ full, rotor.tip_tangential @ full
    return radial @ rotor.tip_radial.T, tangential @ rotor.tip_radial.T


def pack_gyroscopic(
    problem: ContactProblem, packed: RotorArrays, arrangement: Arrangement, dt: float
) -> GyroscopicArrays | None:
    """What couples the modes of a rotor that feels Coriolis forces; None where they don't count.

    Args:
        problem: what is marched.
        packed: its rotor.
        arrangement: of the rotor's modes.
        dt: time step [s].
    """
    rotor = problem.rotor
    if rotor.by_velocity is None:
        return None
    damping = rotor.damping
    inverse = _turning_inverse(damping, dt)
    loss, full_loss = _losses((damping + damping.T) / 2.0, arrangement)
    stands_still = [0, 1] if rotor.circulation != 0.0 else []
    pull = rotor.circulation * rotor.centre * np.array([[1.0], [-1.0]])
    cyclic, none = arrangement.half > 0, np.zeros(0, dtype=np.int64)
    blocks, rest, to, by = (
        _blocks(inverse, arrangement) if cyclic else (aligned(0), aligned(0), none, none)
    )
    normal, normal_across, shear, shear_across = (
        _answers(inverse, arrangement, packed) if cyclic else 4 * [aligned((0, LANES))]
    )
    return GyroscopicArrays(
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
    """A^-1 (modes, modes) of a cyclic rotor as blocks, and the entries that they leave out."""
    rows, columns, half = arrangement.rows, arrangement.columns, arrangement.half
    entries = arrangement.entries
    full = np.zeros((entries, entries))
    full[np.ix_(arrangement.entry, arrangement.entry)] = inverse
    grid = full.reshape(rows, columns, rows, columns)
    cosine = np.arange(half)
    sine = half + cosine
    own, across = grid[:, cosine, :, cosine].copy(), grid[:, cosine, :, sine].copy()
    for to, by, block in (
        (cosine, cosine, own),
        (sine, sine, own),
        (cosine, sine, across),
        (sine, cosine, -across),
    ):
        grid[:, to, :, by] -= block
    to, by = np.nonzero(np.abs(full) > ROUNDING * np.abs(inverse).max())
    order = np.argsort(by, kind="stable")
    blocks = np.zeros((2, half, rows + rows % 2, rows))
    blocks[:, :, :rows] = own, across
    registers = blocks.reshape(2, half // HALF, HALF, -1, 2, rows).transpose(1, 3, 5, 0, 4, 2)
    return aligned_copy(registers.reshape(-1)), full[to, by][order], to[order], by[order]


def _losses(damping: FloatArray, arrangement: Arrangement) -> tuple[FloatArray, FloatArray]:
    """What gives d^T D d: by pairs of rows in a column or, if columns are damped together, by all.

    Args:
        damping: D, symmetric [1/s], (modes, modes).
        arrangement: of the modes.

    Returns:
        (pairs of rows, columns) and (entries, entries): upper triangles, twice what is beside the
        diagonal. One of them has no rows.
    """
    rows, columns, entries = arrangement.rows, arrangement.columns, arrangement.entries
    full = aligned((entries, entries))
    full[np.ix_(arrangement.entry, arrangement.entry)] = damping
    twice = np.triu(2.0 * full) - np.diag(np.diag(full))
    together = np.equal.outer(np.arange(entries) % columns, np.arange(entries) % columns)
    if np.abs(full[~together]).max(initial=0.0) > ROUNDING * np.abs(damping).max(initial=0.0):
        return aligned((0, LANES)), aligned_copy(twice)
    grid = twice.reshape(rows, columns, rows, columns)
    pairs = [
        grid[m, range(columns), n, range(columns)] for m in range(rows) for n in range(m, rows)
    ]
    return aligned_copy(np.array(pairs)), aligned((0, LANES))


def _answers(inverse: FloatArray, arrangement: Arrangement, rotor: RotorArrays) -> list[FloatArray]:
    """Answer of a cyclic rotor's modes to normal forces and friction on it by column.

    Returns:
        answer to the normal force on a mode's own column and on the partner's, then to friction.
    """
    columns, half = arrangement.columns, arrangement.half
    modes, column = np.arange(len(inverse)), arrangement.entry % columns
    partner = (column + half) % columns
    found = []
    for own, across in (
        (rotor.radial, np.zeros_like(rotor.radial)),
        (rotor.tangential, rotor.crossed),
    ):
        force = np.zeros((len(modes), columns))
        force[modes, column] = own.ravel()[arrangement.entry]
        force[modes, partner] += across.ravel()[arrangement.entry]
        answer = inverse @ force
        found += [arrangement.grid(answer[modes, each]) for each in (column, partner)]
    return found


def _cyclic_casing(casing: ReducedCasing) -> tuple[Arrangement, FloatArray, FloatArray]:
    """Arrangement, weights (4, modes) by kind of nodal value, and shape of a cyclic casing.

    w and u' of a mode follow its column, w' and u the partner; so a single harmonic's mode of w'
    and u stands in the partner's place.
    """
    column, nodal = casing.column, casing.nodal
    harmonics = Harmonics(len(nodal), fold=True, unit=LANES)
    single = harmonics.single[column]
    kinds = range(nodal.shape[1])
    pairs = [harmonics.amplitudes(nodal[:, kind], column) for kind in kinds]
    scales = [max(np.abs(nodal[:, kind]).max(), np.finfo(float).tiny) for kind in kinds]
    direct, turned = (W_KIND, U_SLOPE), (W_SLOPE, U_KIND)  # even and odd under reflection
    size = [np.abs(own) / scale for (own, _), scale in zip(pairs, scales, strict=True)]
    odd = single & (
        np.maximum(*(size[kind] for kind in turned)) > np.maximum(*(size[kind] for kind in direct))
    )
    weights = []
    for kind, (own, across) in zip(kinds, pairs, strict=True):
        out_of_place = odd if kind in direct else single & ~odd
        right, wrong = (own, across) if kind in direct else (across, own)
        wrong = np.where(single, np.where(out_of_place, own, 0.0), wrong)
        if np.abs(wrong).max() > FIT * scales[kind]:
            raise ValueError("a cyclic casing must be symmetric under reflection")
        weights.append(np.where(single, np.where(out_of_place, 0.0, own), right))
    place = harmonics.place[column]
    place = np.where(odd, (place + harmonics.half) % (2 * harmonics.half), place)
    return harmonics.arrangement(place), np.array(weights), harmonics.shape


def _compliance(
    casing: ReducedCasing, inverse: FloatArray, friction: float, *, cyclic: bool
) -> FloatArray:
    """Four nodal values under a tip for a unit force of another, by sense of sliding and elements.

    Blocks of 4 x 4, (3, elements, elements, 4, 4); cyclic: (3, 2 elements, 4, 4), by the distance
    of two elements from -nodes to nodes - 1.
    """
    nodes, kinds, modes = casing.nodal.shape
    forces = casing.nodal.reshape(nodes * kinds, modes) * inverse
    rows = casing.nodal[:, :2].reshape(2 * nodes, modes)
    response = (forces @ rows.T).reshape(nodes, kinds, nodes, 2)
    ends = np.column_stack([np.arange(nodes), np.roll(np.arange(nodes), -1)])
    pressed, dragged = (
        response[ends][:, :, force]
        .reshape(nodes, 4, nodes, 2)[:, :, ends]
        .reshape(nodes, 4, nodes, 4)
        .transpose(2, 0, 1, 3)
        for force in ([W_KIND, W_SLOPE], [U_KIND, U_SLOPE])
    )
    blocks = _by_sliding(pressed, dragged, friction)
    return np.tile(blocks[:, :, 0], (1, 2, 1, 1)) if cyclic else blocks


def pack_casing(
    problem: ContactProblem, dt: float, *, cyclic: bool
) -> tuple[Arrangement, CasingArrays]:
    """Arrange the casing; see `pack_rotor`."""
    casing = problem.casing
    nodes, kinds, modes = casing.nodal.shape
    if cyclic:
        arrangement, weight, shape = _cyclic_casing(casing)
        # One array for all kinds: less memory to go through.
        shapes, spreads = [_by_column(shape, arrangement)] * kinds, [aligned_copy(shape)] * kinds
    else:
        arrangement = dense_arrangement(modes)
        weight = np.ones((kinds, modes))
        wide = np.zeros((kinds, nodes, arrangement.columns))
        wide[:, :, :modes] = casing.nodal.transpose(1, 0, 2)
        shape = wide[0]
        shapes, spreads = [_by_column(w, arrangement) for w in wide], [*map(aligned_copy, wide)]
    clearance = aligned((2, padded(nodes + 1)))
    clearance[:, : nodes + 1] = casing.clearance[np.append(np.arange(nodes), 0)].T
    weights, half = [arrangement.grid(w) for w in weight], arrangement.half
    radial, tangential = (
        NodalField(
            weights[v], weights[s], *halves, shapes[v], shapes[s], spreads[v], spreads[s], start
        )
        for v, s, halves, start in (
            (W_KIND, W_SLOPE, (0, half), clearance),
            (U_KIND, U_SLOPE, (half, 0), aligned(clearance.shape)),
        )
    )
    inverse = scheme_inverse(casing.frequency, casing.damping_ratio, dt)
    blocks = _compliance(casing, inverse, problem.friction, cyclic=cyclic)
    loads = [load.casing for load in problem.loads]
    return arrangement, CasingArrays(
        body=pack_body(casing.frequency, casing.damping_ratio, loads, arrangement, dt),
        radial=radial,
        tangential=tangential,
        fold=_folded(shape, arrangement),
        half=half,
        shared=cyclic,
        compliance=aligned_copy(blocks.reshape(-1)),
        spacing=1 if cyclic else nodes if nodes > 1 else 0,  # one node: there is one block
        nodes=nodes,
        element_length=casing.element_length,
    )


def pack_body(
    frequency: FloatArray,
    damping_ratio: FloatArray,
    loads: list[FloatArray],
    arrangement: Arrangement,
    dt: float,
    *,
    coupled: bool = False,
) -> BodyArrays:
    """Modal recurrence of one body.

    Args:
        frequency: [rad/s], negative where its square is, (modes,).
        damping_ratio: (modes,).
        loads: modal force of each load pattern, (modes,) each.
        arrangement: of the body's modes.
        dt: time step [s].
        coupled: whether A couples the modes.
    """
    inverse = scheme_inverse(frequency, damping_ratio, dt)
    stiffness, size = frequency * np.abs(frequency), np.abs(frequency)
    decay = damping_ratio * size / dt
    if coupled:
        inverse, decay = np.ones_like(inverse), np.full_like(decay, -1.0 / dt**2)
    load = arrangement.pack(np.reshape(loads, (len(loads), len(frequency))))
    return BodyArrays(
        a=arrangement.pack(inverse * (2.0 / dt**2 - stiffness)),
        b=arrangement.pack(inverse * (decay - 1.0 / dt**2)),
        c=arrangement.pack(inverse),
        stiffness=arrangement.pack(stiffness),
        damping=arrangement.pack(2.0 * damping_ratio * size),
        load=load,
        loaded=_registers_in_use(load),
    )


def pack_dampers(
    problem: ContactProblem,
    bodies: tuple[BodyArrays, BodyArrays],
    arrangements: tuple[Arrangement, Arrangement],
    dt: float,
) -> DamperArrays | None:
    """Dampers at points of rotor and casing; None without any.

    Args:
        problem: what is marched.
        bodies: rotor and casing.
        arrangements: of the modes of each.
        dt: time step [s].
    """
    ends = []
    given = (problem.rotor.dampers, problem.casing.dampers)
    for rows, body, arrangement in zip(given, bodies, arrangements, strict=True):
        strong = arrangement.pack(rows[rows.any(axis=1)])  # those without strength only cost time
        if body is bodies[0] and problem.rotor.by_velocity is not None:  # its A has them
            strong = strong[:0]
        solve = np.linalg.inv(2.0 * dt * np.eye(len(strong)) + strong * body.c @ strong.T)
        ends.append(DamperEnds(strong, solve))
    return DamperArrays(*ends) if any(len(end.rows) for end in ends) else None


def pack_springs(
    problem: ContactProblem, arrangements: tuple[Arrangement, Arrangement], dt: float
) -> SpringArrays | None:
    """Springs between the bodies and under the shaft, by harmonic; None without any.

    Args:
        problem: what is marched.
        arrangements: of the modes of rotor and casing.
        dt: time step [s].
    """
    rotor, anisotropy = problem.rotor, problem.rotor.anisotropy
    if problem.springs is None and anisotropy == 0.0:
        return None
    springs = _springs_between(problem.springs, arrangements, problem.speed * dt)
    if anisotropy == 0.0:
        return springs
    first, modes = len(springs.factor), len(rotor.frequency)
    ends = springs.rotor
    return springs._replace(
        nodal_diameter=np.append(springs.nodal_diameter, 1.0),
        factor=np.append(springs.factor, [anisotropy, -anisotropy]),
        rotor=SpringEnds(
            place=np.append(ends.place, np.tile(arrangements[0].entry, 2)),
            wave=np.append(ends.wave, np.repeat([first, first + 1], modes)),
            amplitude=np.append(ends.amplitude, rotor.centre),
        ),
    )


def _springs_between(
    springs: CouplingSprings | None,
    arrangements: tuple[Arrangement, Arrangement],
    angle_per_step: float,
) -> SpringArrays:
    if springs is None:
        none = np.zeros(0, dtype=np.int64)
        ends = SpringEnds(none, none, np.zeros(0))
        return SpringArrays(np.zeros(0), np.zeros(0), ends, ends, angle_per_step)
    modes, harmonics = springs.modes, np.array(springs.modes.harmonics)
    wave = 2 * np.searchsorted(harmonics, modes.nodal_diameter)[modes.entry] + modes.is_sine
    both = []
    for arrangement, on_casing in zip(arrangements, (False, True), strict=True):
        coordinates, numbers = springs.coordinates(on_casing=on_casing)
        amplitude = modes.amplitude[modes.entry][coordinates]
        both.append(SpringEnds(arrangement.entry[numbers], wave[coordinates], amplitude))
    return SpringArrays(
        nodal_diameter=harmonics.astype(np.float64),
        factor=np.repeat(springs.factors, 2),
        rotor=both[0],
        casing=both[1],
        angle_per_step=angle_per_step,
    )


def _registers_in_use(patterns: FloatArray) -> IntArray:
    """Where each pattern has a register of numbers that are not all zero, then -1."""
    used = [LANES * np.flatnonzero(p.reshape(-1, LANES).any(axis=1)) for p in patterns]
    places = np.full((len(patterns), max(map(len, used), default=0) + 1), -1)
    for row, place in zip(places, used, strict=True):
        row[: len(place)] = place
    return places


def _turning_inverse(damping: FloatArray, dt: float) -> FloatArray:
    """Inverse of A of a rotor whose modes are coupled by velocity [s2], (modes, modes)."""
    return np.asarray(np.linalg.inv(np.eye(len(damping)) / dt**2 + damping / (2.0 * dt)))


def scheme_inverse(frequency: FloatArray, damping_ratio: FloatArray, dt: float) -> FloatArray:
    """Inverse of A = M/dt^2 + D/(2 dt) for each mode [s2], (modes,)."""
    return np.asarray(1.0 / (1.0 / dt**2 + damping_ratio * np.abs(frequency) / dt))


def make_scratch(
    rotor: RotorArrays,
    casing: CasingArrays,
    arrangements: tuple[Arrangement, Arrangement],
    springs: SpringArrays | None,
    dampers: DamperArrays | None,
) -> Scratch:
    """Working arrays for one march."""
    waves = len(springs.factor) if springs is not None else 0
    strokes = max(len(dampers.rotor.rows), len(dampers.casing.rows)) if dampers is not None else 0
    # Columns, the first half of them once more, and what the last register runs over.
    columns = padded(max(a.columns + a.half + LANES for a in arrangements))
    tips, wide, nodes = len(rotor.spread), len(rotor.position), casing.radial.start.shape[1]
    return Scratch(
        fields=FieldScratch(
            rotor=aligned(columns),
            value=aligned(columns),
            slope=aligned(columns),
            nodal=aligned(nodes),
            nodal_slope=aligned(nodes),
            moved=aligned((2, max(a.entries for a in arrangements))),
            at=aligned(wide),
            element=np.zeros(tips, dtype=np.int64),
            hermite=aligned((4, wide)),
            radial=aligned(wide),
            tangential=aligned(wide),
            other=aligned(wide),
            free_gap=aligned(wide),
            gap=aligned(wide),
        ),
        contact=ContactScratch(
            sign=np.zeros(tips),
            multiplier=np.zeros(tips),
            active=np.zeros(tips, dtype=np.int64),
            known=np.zeros((2, tips), dtype=np.int64),
            on_rotor=aligned((tips, wide)),
            ends=aligned(HALF * wide),
            system=aligned((tips + 1, wide)),
            others=aligned_copy(1.0 - np.eye(tips, wide)),
            diagonal=np.zeros(tips),
            solution=np.zeros(tips),
            tableau=np.zeros((tips, 2 * tips + 2)),
            basis=np.zeros(tips, dtype=np.int64),
            rows=np.zeros(2 * wide, dtype=np.int64),
            factor=aligned((6, 2 * wide)),
            columns=aligned((6, columns)),
            work=np.zeros(2),
        ),
        springs=SpringScratch(
            rotor=np.zeros((2, waves)),
            casing=np.zeros((2, waves)),
            stretch=np.zeros((4, waves)),
            force=np.zeros((2, waves)),
        ),
        turned=aligned(arrangements[0].entries),
        amplitude=np.zeros(len(rotor.body.load)),
        stroke=np.zeros(strokes),
        damper_force=np.zeros((2, strokes)),
    )
