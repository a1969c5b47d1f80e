"""Lay a contact problem out for the kernel: cyclic where the bodies are, dense otherwise."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.coupling.springs import CouplingSprings
from bladewhirl.models.stage.contact_problem import ReducedCasing, ReducedRotor
from bladewhirl.solvers.kernel.arrays import (
    U_KIND,
    U_SLOPE,
    W_KIND,
    W_SLOPE,
    Body,
    Casing,
    Dampers,
    KindArrays,
    Rotor,
    Scratch,
    Springs,
)
from bladewhirl.solvers.kernel.vectors import HALF, LANES
from bladewhirl.solvers.march.layout import (
    FIT,
    Harmonics,
    Layout,
    aligned,
    aligned_copy,
    dense_layout,
    padded,
)


def _lengthened(values: FloatArray) -> FloatArray:
    """Vector padded to whole registers."""
    out = aligned(padded(len(values)))
    out[: len(values)] = values
    return out


def _by_column(shape: FloatArray, layout: Layout) -> FloatArray:
    """Shape (points, columns) as (columns to the last in use, padded points)."""
    used = layout.half + layout.parts * layout.used
    out = aligned((used, padded(len(shape))))
    out[:, : len(shape)] = shape[:, :used].T
    return out


def _folded(shape: FloatArray, layout: Layout) -> FloatArray:
    """Shape (nodes, columns) on a quarter of the circle, as the kernel's `_folded_fields` has it.

    No rows where the kernel cannot fold: without parity, or on so few nodes that whole registers
    of a quarter reach over half of the circle.
    """
    nodes = len(shape)
    width = padded(nodes // 4 + 1)
    if layout.parts == 1 or width - 1 > nodes // 2:
        return aligned((0, LANES))
    own = shape[:width]
    last = own[:, layout.half + layout.used - 1]
    rows = own[:, np.concatenate([layout.columns_of(part) for part in range(2)])].T
    rows = rows.reshape(2, 2, layout.used, width).transpose(1, 0, 2, 3).reshape(-1, width)
    rows[3 * layout.used - 1] = 0.0
    return aligned_copy(np.vstack([rows, last]))


def _by_sliding(pressed: FloatArray, dragged: FloatArray, friction: float) -> FloatArray:
    """Response to a normal force with its friction, for sliding backward, none, and forward."""
    return np.array([pressed + s * friction * dragged for s in (-1.0, 0.0, 1.0)])


def pack_rotor(
    rotor: ReducedRotor,
    inverse: FloatArray,
    casing_nodes: int,
    friction: float,
    *,
    cyclic: bool,
) -> tuple[Layout, Rotor]:
    """Arrange the rotor.

    Args:
        rotor: reduced rotor.
        inverse: inverse of the scheme's diagonal for each mode [s2], (modes,).
        casing_nodes: number of casing elements, the unit of the tips' positions.
        friction: Coulomb coefficient.
        cyclic: whether to use its DFT columns.
    """
    tips, modes = rotor.tip_radial.shape
    if cyclic:
        harmonics = Harmonics(tips, fold=False, unit=HALF)
        layout = harmonics.layout(harmonics.place[rotor.column])
        radial, across = harmonics.amplitudes(rotor.tip_radial, rotor.column)
        if not np.abs(across).max(initial=0.0) <= FIT * np.abs(radial).max(initial=0.0):
            raise ValueError(
                "a cyclic rotor's mode pairs must be aligned to the tips' radial motion"
            )
        tangential, crossed = harmonics.amplitudes(rotor.tip_tangential, rotor.column)
        shape, cross_shape = harmonics.shape, harmonics.crossed
        dragged = shape
    else:
        layout = dense_layout(modes)
        radial, tangential, crossed = np.ones(modes), np.zeros(modes), np.ones(modes)
        shape = np.zeros((tips, layout.columns))
        cross_shape = np.zeros((tips, layout.columns))
        shape[:, :modes], cross_shape[:, :modes] = rotor.tip_radial, rotor.tip_tangential
        dragged = cross_shape
    grid = (layout.rows, layout.columns)
    on_tips = aligned_copy(shape)
    weighted, weighted_tangential = rotor.tip_radial * inverse, rotor.tip_tangential * inverse
    return layout, Rotor(
        radial=layout.pack(radial).reshape(grid),
        tangential=layout.pack(tangential).reshape(grid),
        crossed=layout.pack(crossed).reshape(grid),
        shape=_by_column(shape, layout),
        cross_shape=_by_column(cross_shape, layout),
        spread=on_tips,
        drag_spread=on_tips if dragged is shape else aligned_copy(dragged),
        half=layout.half,
        shared=cyclic,
        w=_by_sliding(
            weighted @ rotor.tip_radial.T, weighted_tangential @ rotor.tip_radial.T, friction
        ).reshape(3 * tips, tips),
        position=_lengthened(rotor.tip_angle * casing_nodes / (2.0 * np.pi)),
        recess=_lengthened(rotor.tip_recess),
    )


def _cyclic_casing(casing: ReducedCasing) -> tuple[Layout, FloatArray, list[FloatArray]]:
    """Layout, weights (4, modes) and shapes of a cyclic casing, by kind of nodal value.

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
    return harmonics.layout(place), np.array(weights), [harmonics.shape] * len(weights)


def pack_casing(
    casing: ReducedCasing, inverse: FloatArray, friction: float, *, cyclic: bool
) -> tuple[Layout, Casing]:
    """Arrange the casing; see `pack_rotor`."""
    nodes, kinds, modes = casing.nodal.shape
    if cyclic:
        layout, weight, shapes = _cyclic_casing(casing)
    else:
        layout = dense_layout(modes)
        weight = np.ones((kinds, modes))
        shapes = [np.zeros((nodes, layout.columns)) for _ in range(kinds)]
        for kind, shape in enumerate(shapes):
            shape[:, :modes] = casing.nodal[:, kind]
    forces = casing.nodal.reshape(nodes * kinds, modes) * inverse
    rows = casing.nodal[:, :2].reshape(2 * nodes, modes)
    response = (forces @ rows.T).reshape(nodes, kinds, nodes, 2)
    ends = np.column_stack([np.arange(nodes), np.roll(np.arange(nodes), -1)])
    # Four nodal values (two ends) moved by four normal or four tangential nodal forces.
    pressed, dragged = (
        response[ends][:, :, force]
        .reshape(nodes, 4, nodes, 2)[:, :, ends]
        .reshape(nodes, 4, nodes, 4)
        .transpose(2, 0, 1, 3)
        for force in ([W_KIND, W_SLOPE], [U_KIND, U_SLOPE])
    )
    blocks = _by_sliding(pressed, dragged, friction)
    if cyclic:  # by the distance of two elements, from -nodes to nodes - 1
        blocks = np.tile(blocks[:, :, 0], (1, 2, 1, 1))
    clearance = aligned((2, padded(nodes + 1)))
    clearance[:, : nodes + 1] = casing.clearance[np.append(np.arange(nodes), 0)].T

    def by_kind(make: Callable[[FloatArray], FloatArray]) -> list[FloatArray]:
        """One array for all kinds where they share their shape: less memory to go through."""
        return [make(shapes[0])] * kinds if cyclic else [make(shape) for shape in shapes]

    return layout, Casing(
        weight=layout.pack(weight).reshape(kinds, layout.rows, layout.columns),
        shape=KindArrays(*by_kind(lambda shape: _by_column(shape, layout))),
        fold=_folded(shapes[0], layout),
        spread=KindArrays(*by_kind(aligned_copy)),
        half=layout.half,
        shared=cyclic,
        compliance=aligned_copy(blocks.reshape(-1)),
        spacing=1 if cyclic else nodes if nodes > 1 else 0,  # one node: there is one block
        clearance=clearance,
        no_clearance=aligned(clearance.shape),
        nodes=nodes,
        element_length=casing.element_length,
    )


def pack_body(
    frequency: FloatArray,
    damping_ratio: FloatArray,
    loads: FloatArray,
    layout: Layout,
    dt: float,
) -> Body:
    """Modal recurrence of one body.

    Args:
        frequency: [rad/s], (modes,).
        damping_ratio: (modes,).
        loads: modal forces of the load patterns, (patterns, modes).
        layout: arrangement of the body's modes.
        dt: time step [s].
    """
    inverse = scheme_inverse(frequency, damping_ratio, dt)
    decay = damping_ratio * frequency / dt
    return Body(
        a=layout.pack(inverse * (2.0 / dt**2 - frequency**2)),
        b=layout.pack(inverse * (decay - 1.0 / dt**2)),
        c=layout.pack(inverse),
        stiffness=layout.pack(frequency**2),
        damping=layout.pack(2.0 * damping_ratio * frequency),
        load=layout.pack(loads),
        loaded=_registers_in_use(layout.pack(loads)),
    )


def pack_dampers(
    rotor: FloatArray,
    casing: FloatArray,
    bodies: tuple[Body, Body],
    layouts: tuple[Layout, Layout],
    dt: float,
) -> Dampers | None:
    """Damping at points of both bodies; None without any.

    Args:
        rotor: rows G of the rotor's damping G^T G [s^-1/2], (dampers, modes).
        casing: the same for the casing.
        bodies: rotor and casing.
        layouts: arrangement of the modes of each.
        dt: time step [s].
    """
    packed = []
    for rows, body, layout in zip((rotor, casing), bodies, layouts, strict=True):
        strong = layout.pack(rows[rows.any(axis=1)])  # those without strength only cost time
        packed += [
            strong,
            np.linalg.inv(2.0 * dt * np.eye(len(strong)) + strong * body.c @ strong.T),
        ]
    return Dampers(*packed) if any(map(len, packed)) else None


def pack_springs(
    springs: CouplingSprings | None,
    carried: ReducedRotor,
    rotor: Layout,
    casing: Layout,
    angle_per_step: float,
) -> Springs | None:
    """Springs between the bodies and under the shaft, by harmonic; None without any.

    Args:
        springs: between the bodies; None for bodies without.
        carried: the rotor, which knows what carries its centre.
        rotor: arrangement of the rotor's modes.
        casing: arrangement of the casing's modes.
        angle_per_step: turn of the rotor a step [rad].
    """
    between = _springs_between(springs, rotor, casing, angle_per_step)
    if carried.anisotropy == 0.0:
        return between if springs is not None else None
    first, modes = len(between.factor), np.arange(len(carried.frequency))
    return between._replace(
        nodal_diameter=np.append(between.nodal_diameter, 1.0),
        factor=np.append(between.factor, [carried.anisotropy, -carried.anisotropy]),
        rotor_place=np.append(between.rotor_place, np.tile(rotor.entry[modes], 2)),
        rotor_wave=np.append(between.rotor_wave, np.repeat([first, first + 1], len(modes))),
        rotor_amplitude=np.append(between.rotor_amplitude, carried.centre),
    )


def _springs_between(
    springs: CouplingSprings | None, rotor: Layout, casing: Layout, angle_per_step: float
) -> Springs:
    none = np.zeros(0, dtype=np.int64)
    if springs is None:
        empty = np.zeros(0)
        return Springs(empty, empty, none, none, empty, none, none, empty, angle_per_step)
    modes, harmonics = springs.modes, np.array(springs.modes.harmonics)
    harmonic = np.searchsorted(harmonics, modes.nodal_diameter)[modes.entry]
    wave = 2 * harmonic + modes.is_sine
    on_rotor, rotor_modes = springs.coordinates(on_casing=False)
    on_casing, casing_modes = springs.coordinates(on_casing=True)
    amplitude = modes.amplitude[modes.entry]
    return Springs(
        nodal_diameter=harmonics.astype(np.float64),
        factor=np.repeat(springs.factors, 2),
        rotor_place=rotor.entry[rotor_modes],
        rotor_wave=wave[on_rotor],
        rotor_amplitude=amplitude[on_rotor],
        casing_place=casing.entry[casing_modes],
        casing_wave=wave[on_casing],
        casing_amplitude=amplitude[on_casing],
        angle_per_step=angle_per_step,
    )


def _registers_in_use(patterns: FloatArray) -> IntArray:
    """Where each pattern has a register of numbers that are not all zero, then -1."""
    used = [LANES * np.flatnonzero(p.reshape(-1, LANES).any(axis=1)) for p in patterns]
    places = np.full((len(patterns), max(map(len, used), default=0) + 1), -1)
    for row, place in zip(places, used, strict=True):
        row[: len(place)] = place
    return places


def scheme_inverse(frequency: FloatArray, damping_ratio: FloatArray, dt: float) -> FloatArray:
    """Inverse of A = M/dt^2 + D/(2 dt) for each mode [s2], (modes,)."""
    return np.asarray(1.0 / (1.0 / dt**2 + damping_ratio * frequency / dt))


def make_scratch(
    rotor: Rotor,
    casing: Casing,
    tips: int,
    loads: int,
    layouts: tuple[Layout, Layout],
    springs: Springs | None,
    dampers: Dampers | None,
) -> Scratch:
    """Working arrays for one march."""
    harmonics = len(springs.nodal_diameter) if springs is not None else 0
    strokes = max(len(dampers.rotor), len(dampers.casing)) if dampers is not None else 0
    # Columns, the first half of them once more, and what the last register runs over.
    columns = padded(max(layout.columns + layout.half + LANES for layout in layouts))
    wide = len(rotor.position)
    return Scratch(
        columns=aligned((3, columns)),
        forces=aligned((6, columns)),
        nodal=aligned((2, casing.clearance.shape[1])),
        tip=aligned((4, wide)),
        gap=aligned((2, wide)),
        hermite=aligned((4, wide)),
        element=np.zeros(tips, dtype=np.int64),
        difference=aligned((2, max(layouts[0].entries, layouts[1].entries))),
        load=np.zeros(loads),
        rows=np.zeros(2 * wide, dtype=np.int64),
        factor=aligned((6, 2 * wide)),
        active=np.zeros(tips, dtype=np.int64),
        known=np.zeros((2, tips), dtype=np.int64),
        on_rotor=aligned((tips, wide)),
        ends=aligned(HALF * wide),
        solve=aligned((tips + 1, wide)),
        others=aligned_copy(1.0 - np.eye(tips, wide)),
        diagonal=np.zeros(tips),
        solution=np.zeros(tips),
        multiplier=np.zeros(tips),
        sign=np.zeros(tips),
        work=np.zeros(2),
        tableau=np.zeros((tips, 2 * tips + 2)),
        basis=np.zeros(tips, dtype=np.int64),
        rotor_waves=np.zeros((2, 2 * harmonics)),
        casing_waves=np.zeros((2, 2 * harmonics)),
        stretch=np.zeros((4, 2 * harmonics)),
        spring_force=np.zeros((2, 2 * harmonics)),
        stroke=np.zeros(strokes),
        damper_force=np.zeros((2, strokes)),
    )
