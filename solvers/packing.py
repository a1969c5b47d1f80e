"""Lay a contact problem out for the kernel: cyclic where the bodies are, dense otherwise."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import prod

import numpy as np
from numpy.typing import NDArray

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.contact_problem import ReducedCasing, ReducedRotor
from bladewhirl.models.coupling import Springs as ModalSprings
from bladewhirl.models.cyclic import is_pair, nodal_diameter_of, real_dft
from bladewhirl.solvers.kernel_arrays import (
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
from bladewhirl.solvers.lanes import HALF, LANES

BoolArray = NDArray[np.bool_]

PAIR = 2 * LANES  # the kernel takes a casing's columns two registers at a time
CACHE_LINE = 64  # bytes
FIT = 1e-9  # largest relative misfit of a cyclic body's rows to its DFT columns


@dataclass(frozen=True, kw_only=True)
class Layout:
    """Where each mode stands in a (rows, columns) arrangement.

    On a cyclic body each column has a partner ``half`` columns on, or back: the sine of a cosine
    and the reverse. Columns that differ by the parity of their nodal diameter stand apart when
    ``parts`` is 2: the first ``used`` of each half are even, the next odd.
    """

    rows: int
    columns: int
    entry: IntArray  #: place of each mode in the flat arrangement, (modes,)
    half: int = 0  #: columns from one to its partner; 0 without partners
    parts: int = 1
    used: int  #: columns in use of each part of each half

    @property
    def entries(self) -> int:
        """Length of the flat arrangement."""
        return self.rows * self.columns

    def columns_of(self, part: int) -> IntArray:
        """Columns in use of a part, cosines first."""
        first = part * self.used + np.arange(self.used)
        return np.concatenate([first, self.half + first]) if self.half else first

    def pack(self, values: FloatArray) -> FloatArray:
        """Spread values of modes (..., modes) over the arrangement (..., entries)."""
        packed = aligned((*values.shape[:-1], self.entries))
        packed[..., self.entry] = values
        return packed

    def unpack(self, packed: FloatArray) -> FloatArray:
        """Read the values of modes back, (..., modes)."""
        return np.ascontiguousarray(packed[..., self.entry])


def _padded(size: int, unit: int = LANES) -> int:
    return -(-size // unit) * unit


def dense_layout(modes: int) -> Layout:
    """One row, a column a mode."""
    used = max(modes, 1)
    return Layout(rows=1, columns=_padded(used, PAIR), entry=np.arange(modes), used=used)


def _couples(points: int, parity: int | None) -> list[tuple[int, ...]]:
    """DFT columns of one parity (or all) two by two: cosine and sine, singles with each other."""
    wanted = [c for c in range(points) if parity in (None, nodal_diameter_of(c) % 2)]
    paired = [c for c in wanted if is_pair(nodal_diameter_of(c), points)]
    single = [c for c in wanted if not is_pair(nodal_diameter_of(c), points)]
    both = [*zip(paired[::2], paired[1::2], strict=True)]
    return [*both, tuple(single)] if single else list(both)


def aligned(shape: int | tuple[int, ...]) -> FloatArray:
    """Zeros that start on a cache line."""
    count = prod(shape) if isinstance(shape, tuple) else shape
    raw = np.zeros(count + CACHE_LINE // 8)
    address = raw.ctypes.data
    first = -(address // 8) % (CACHE_LINE // 8)
    return raw[first : first + count].reshape(shape)


def aligned_copy(values: FloatArray) -> FloatArray:
    """Copy that starts on a cache line."""
    out = aligned(values.shape)
    out[...] = values
    return out


def _lengthened(values: FloatArray) -> FloatArray:
    """Vector padded to whole registers."""
    out = aligned(_padded(len(values)))
    out[: len(values)] = values
    return out


def _by_column(shape: FloatArray, layout: Layout) -> FloatArray:
    """Shape (points, columns) as (columns to the last in use, padded points)."""
    used = layout.half + layout.parts * layout.used
    out = aligned((used, _padded(len(shape))))
    out[:, : len(shape)] = shape[:, :used].T
    return out


def _folded(shape: FloatArray, layout: Layout) -> FloatArray:
    """Shape (nodes, columns) on a quarter of the circle, as the kernel's `_folded_fields` has it.

    No rows where the kernel cannot fold: without parity, or on so few nodes that whole registers
    of a quarter reach over half of the circle.
    """
    nodes = len(shape)
    width = _padded(nodes // 4 + 1)
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


class _Harmonics:
    """DFT columns of a cyclic body and where they stand among its arrangement's.

    Args:
        points: of the body's circumference.
        fold: keep columns of even and odd nodal diameter apart, so that the kernel can use that
            opposite points are equal in the former and opposite in the latter (even numbers of
            points only).
        unit: each half is padded to a multiple of it.
    """

    def __init__(self, points: int, *, fold: bool, unit: int) -> None:
        self.parts = 2 if fold and points % 2 == 0 else 1
        couples = [
            _couples(points, part if self.parts == 2 else None) for part in range(self.parts)
        ]
        self.used = max(map(len, couples))
        self.half = _padded(self.parts * self.used, unit)
        self.place = np.zeros(points, dtype=np.int64)  # of each DFT column
        for part, own in enumerate(couples):
            for slot, couple in enumerate(own):
                for block, column in enumerate(couple):
                    self.place[column] = block * self.half + part * self.used + slot
        self.single = np.array([not is_pair(nodal_diameter_of(c), points) for c in range(points)])
        self.basis = real_dft(points)
        self.shape = np.zeros((points, 2 * self.half))  # in the arrangement's columns
        self.shape[:, self.place] = self.basis
        self.crossed = np.roll(self.shape, self.half, axis=1)  # each column's partner

    def amplitudes(self, rows: FloatArray, column: IntArray) -> tuple[FloatArray, FloatArray]:
        """Amplitude of each mode on its own column and on the partner, (modes,) each."""
        own = np.einsum("pm,pm->m", self.basis[:, column], rows)
        partner = self.crossed[:, self.place[column]]
        other = np.where(self.single[column], 0.0, np.einsum("pm,pm->m", partner, rows))
        fitted = self.basis[:, column] * own + partner * other
        if not np.abs(fitted - rows).max(initial=0.0) <= FIT * np.abs(rows).max(initial=0.0):
            raise ValueError(
                "modes carry DFT columns that their displacements do not follow; give column -1 "
                "to modes without cyclic symmetry"
            )
        return own, other

    def layout(self, place: IntArray) -> Layout:
        """Arrangement with each mode in the column given, (modes,), rows by rank."""
        columns = 2 * self.half
        rank = np.zeros(len(place), dtype=np.int64)
        for c in range(columns):
            own = place == c
            rank[own] = np.arange(np.count_nonzero(own))
        return Layout(
            rows=int(rank.max(initial=0)) + 1,
            columns=columns,
            entry=rank * columns + place,
            half=self.half,
            parts=self.parts,
            used=self.used,
        )


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
        harmonics = _Harmonics(tips, fold=False, unit=HALF)
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
    harmonics = _Harmonics(len(nodal), fold=True, unit=LANES)
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
    clearance = aligned((2, _padded(nodes + 1)))
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
    springs: ModalSprings | None,
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
    springs: ModalSprings | None, rotor: Layout, casing: Layout, angle_per_step: float
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
    columns = _padded(max(layout.columns + layout.half + LANES for layout in layouts))
    padded = len(rotor.position)
    return Scratch(
        columns=aligned((3, columns)),
        forces=aligned((6, columns)),
        nodal=aligned((2, casing.clearance.shape[1])),
        tip=aligned((4, padded)),
        gap=aligned((2, padded)),
        hermite=aligned((4, padded)),
        element=np.zeros(tips, dtype=np.int64),
        difference=aligned((2, max(layouts[0].entries, layouts[1].entries))),
        load=np.zeros(loads),
        rows=np.zeros(2 * padded, dtype=np.int64),
        factor=aligned((6, 2 * padded)),
        active=np.zeros(tips, dtype=np.int64),
        known=np.zeros((2, tips), dtype=np.int64),
        on_rotor=aligned((tips, padded)),
        ends=aligned(HALF * padded),
        solve=aligned((tips + 1, padded)),
        others=aligned_copy(1.0 - np.eye(tips, padded)),
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
