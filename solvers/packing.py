"""Lay a contact problem out for the kernel: cyclic where the bodies are, dense otherwise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.contact_problem import ReducedCasing, ReducedRotor
from bladewhirl.models.cyclic import is_pair, nodal_diameter_of, real_dft
from bladewhirl.solvers.kernel import (
    U_KIND,
    U_SLOPE,
    W_KIND,
    W_SLOPE,
    Body,
    Casing,
    Rotor,
    Scratch,
)
from bladewhirl.solvers.lanes import HALF, LANES

BoolArray = NDArray[np.bool_]

PAIR = 2 * LANES  # the kernel takes a casing's columns two registers at a time
CACHE_LINE = 64  # bytes
FIT = 1e-9  # largest relative misfit of a cyclic body's rows to its DFT columns


@dataclass(frozen=True, kw_only=True)
class Layout:
    """Where each mode stands in a (rows, columns) arrangement."""

    rows: int
    columns: int
    entry: IntArray  #: place of each mode in the flat arrangement, (modes,)
    fold: int  #: 2 when columns are split by the parity of their nodal diameter
    used: int  #: columns in use of each part; the rest is padding

    @property
    def entries(self) -> int:
        """Length of the flat arrangement."""
        return self.rows * self.columns

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
    columns = _padded(max(modes, 1), PAIR)
    return Layout(rows=1, columns=columns, entry=np.arange(modes), fold=1, used=max(modes, 1))


def cyclic_layout(column: IntArray, points: int, *, fold: bool) -> tuple[Layout, IntArray]:
    """Rows by rank, columns by harmonic.

    Opposite points are equal in harmonics of even k and opposite in those of odd k; ``fold``
    keeps the two apart so that the kernel can use that (even numbers of points only).

    Returns:
        the layout and the place of each DFT column among the arrangement's columns, (points,).
    """
    parity = np.array([nodal_diameter_of(c) % 2 for c in range(points)])
    place = np.arange(points)
    columns = _padded(points, PAIR if fold else LANES)
    parts = 2 if fold and points % 2 == 0 else 1
    if parts == 2:
        half = _padded(points // 2)
        for odd in (0, 1):
            place[parity == odd] = odd * half + np.arange(np.count_nonzero(parity == odd))
        columns = 2 * half
    rank = np.zeros(len(column), dtype=np.int64)
    for c in range(points):
        own = column == c
        rank[own] = np.arange(np.count_nonzero(own))
    rows = int(rank.max(initial=0)) + 1
    entry = rank * columns + place[column]
    return Layout(rows=rows, columns=columns, entry=entry, fold=parts, used=points // parts), place


def _partner(column: int, points: int) -> int:
    """The sine of a cosine and the reverse; a single harmonic is its own partner."""
    if not is_pair(nodal_diameter_of(column), points):
        return column
    return column + 1 if column % 2 else column - 1


def aligned(shape: int | tuple[int, ...]) -> FloatArray:
    """Zeros that start on a cache line."""
    count = int(np.prod(shape))
    raw = np.zeros(count + CACHE_LINE // 8)
    first = -(raw.ctypes.data // 8) % (CACHE_LINE // 8)
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


def _by_column(shape: FloatArray, used: int) -> FloatArray:
    """Shape (points, columns) as (columns in use, padded points)."""
    out = aligned((used, _padded(len(shape))))
    out[:, : len(shape)] = shape[:, :used].T
    return out


def _by_parity(shapes: FloatArray, layout: Layout, part: int) -> FloatArray:
    """One parity of shapes (kinds, nodes, columns), as (kinds, columns in use, padded nodes)."""
    kinds, nodes, columns = shapes.shape
    if part >= layout.fold:
        return aligned((kinds, 0, LANES))
    first = part * columns // layout.fold
    own = shapes[:, : nodes // layout.fold, first : first + layout.used]
    out = aligned((kinds, layout.used, _padded(own.shape[1])))
    out[:, :, : own.shape[1]] = own.transpose(0, 2, 1)
    return out


def _by_sliding(pressed: FloatArray, dragged: FloatArray, friction: float) -> FloatArray:
    """Response to a normal force with its friction, for sliding backward, none, and forward."""
    return aligned_copy(np.array([pressed + s * friction * dragged for s in (-1.0, 0.0, 1.0)]))


@dataclass(frozen=True, kw_only=True)
class _Harmonics:
    """DFT columns of a cyclic body and the layout that holds them."""

    layout: Layout
    basis: FloatArray  #: (points, points)
    crossed: FloatArray  #: partner of each column, a single harmonic being its own
    single: BoolArray  #: whether a column has no partner, (points,)
    place: IntArray

    def shape(self, crossed: bool) -> FloatArray:
        """Shape matrix in the arrangement's columns, (points, columns)."""
        basis = self.crossed if crossed else self.basis
        shape = np.zeros((len(basis), self.layout.columns))
        shape[:, self.place] = basis
        return shape

    def amplitudes(self, rows: FloatArray, column: IntArray) -> tuple[FloatArray, FloatArray]:
        """Amplitude of each mode on its own column and on the partner, (modes,) each."""
        own = np.einsum("pm,pm->m", self.basis[:, column], rows)
        other = np.einsum("pm,pm->m", self.crossed[:, column], rows)
        other[self.single[column]] = 0.0
        fitted = self.basis[:, column] * own + self.crossed[:, column] * other
        if not np.abs(fitted - rows).max(initial=0.0) <= FIT * np.abs(rows).max(initial=0.0):
            raise ValueError(
                "modes carry DFT columns that their displacements do not follow; give column -1 "
                "to modes without cyclic symmetry"
            )
        return own, other


def _harmonics(column: IntArray, points: int, *, fold: bool) -> _Harmonics:
    layout, place = cyclic_layout(column, points, fold=fold)
    basis = real_dft(points)
    partner = np.array([_partner(c, points) for c in range(points)])
    return _Harmonics(
        layout=layout,
        basis=basis,
        crossed=basis[:, partner],
        single=partner == np.arange(points),
        place=place,
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
        harmonics = _harmonics(rotor.column, tips, fold=False)
        layout = harmonics.layout
        radial, across = harmonics.amplitudes(rotor.tip_radial, rotor.column)
        if not np.abs(across).max(initial=0.0) <= FIT * np.abs(radial).max(initial=0.0):
            raise ValueError(
                "a cyclic rotor's mode pairs must be aligned to the tips' radial motion"
            )
        tangential, crossed = harmonics.amplitudes(rotor.tip_tangential, rotor.column)
        shape, cross_shape = harmonics.shape(False), harmonics.shape(True)
    else:
        layout = dense_layout(modes)
        radial, tangential, crossed = np.ones(modes), np.zeros(modes), np.ones(modes)
        shape = np.zeros((tips, layout.columns))
        cross_shape = np.zeros((tips, layout.columns))
        shape[:, :modes], cross_shape[:, :modes] = rotor.tip_radial, rotor.tip_tangential
    grid = (layout.rows, layout.columns)
    weighted, weighted_tangential = rotor.tip_radial * inverse, rotor.tip_tangential * inverse
    return layout, Rotor(
        radial=layout.pack(radial).reshape(grid),
        tangential=layout.pack(tangential).reshape(grid),
        crossed=layout.pack(crossed).reshape(grid),
        shape=_by_column(shape, layout.used),
        cross_shape=_by_column(cross_shape, layout.used),
        spread=aligned_copy(shape),
        cross_spread=aligned_copy(cross_shape),
        w=_by_sliding(
            weighted @ rotor.tip_radial.T, weighted_tangential @ rotor.tip_radial.T, friction
        ),
        position=_lengthened(rotor.tip_angle * casing_nodes / (2.0 * np.pi)),
        recess=_lengthened(rotor.tip_recess),
    )


def pack_casing(
    casing: ReducedCasing, inverse: FloatArray, friction: float, *, cyclic: bool
) -> tuple[Layout, Casing]:
    """Arrange the casing; see `pack_rotor`."""
    nodes, kinds, modes = casing.nodal.shape
    if cyclic:
        harmonics = _harmonics(casing.column, nodes, fold=True)
        layout = harmonics.layout
        weights, shapes = [], []
        for kind in range(kinds):
            own, across = harmonics.amplitudes(casing.nodal[:, kind], casing.column)
            single = harmonics.single[casing.column]
            crossed = kind in (W_SLOPE, U_KIND)  # odd under reflection
            wrong = np.where(single, 0.0, own if crossed else across)
            if np.abs(wrong).max() > FIT * np.abs(casing.nodal[:, kind]).max():
                raise ValueError("a cyclic casing must be symmetric under reflection")
            weights.append(np.where(single, own, across) if crossed else own)
            shapes.append(harmonics.shape(crossed))
        weight, shape = np.array(weights), np.array(shapes)
    else:
        layout = dense_layout(modes)
        weight = np.ones((kinds, modes))
        shape = np.zeros((kinds, nodes, layout.columns))
        shape[..., :modes] = casing.nodal.transpose(1, 0, 2)
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
    whole = _padded(nodes + 1)
    clearance = aligned((2, whole))
    clearance[:, : nodes + 1] = casing.clearance[np.append(np.arange(nodes), 0)].T
    even = _by_parity(shape, layout, 0)
    odd = _by_parity(shape, layout, 1)
    spreads = [aligned_copy(s) for s in shape]
    if cyclic:  # two kinds share each shape: half of the memory to go through
        spreads[U_KIND], spreads[U_SLOPE] = spreads[W_SLOPE], spreads[W_KIND]
    return layout, Casing(
        weight=layout.pack(weight).reshape(kinds, layout.rows, layout.columns),
        even=even,
        odd=odd,
        spread_w=spreads[W_KIND],
        spread_w_s=spreads[W_SLOPE],
        spread_u=spreads[U_KIND],
        spread_u_s=spreads[U_SLOPE],
        compliance=aligned_copy(blocks.reshape(3, -1)),
        spacing=1 if cyclic else nodes if nodes > 1 else 0,  # one node: there is one block
        clearance=clearance,
        nodes=nodes,
        element_length=casing.element_length,
    )


def pack_body(
    frequency: FloatArray, damping_ratio: FloatArray, loads: FloatArray, layout: Layout, dt: float
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
    rotor: Rotor, casing: Casing, tips: int, loads: int, layouts: tuple[Layout, Layout]
) -> Scratch:
    """Working arrays for one march."""
    columns = max(layouts[0].columns, layouts[1].columns)
    padded, nodal = len(rotor.position), _padded(casing.nodes + 1) + 3 * casing.even.shape[2]
    return Scratch(
        columns=aligned((6, columns)),
        forces=aligned((4, layouts[1].columns)),
        nodal=aligned((2, nodal)),
        tip=aligned((4, padded)),
        gap=aligned((2, padded)),
        hermite=aligned((4, padded)),
        element=np.zeros(tips, dtype=np.int64),
        difference=aligned((2, max(layouts[0].entries, layouts[1].entries))),
        load=np.zeros(loads),
        rows=np.zeros(2 * tips, dtype=np.int64),
        factor=aligned((4, _padded(2 * tips))),
        active=np.zeros(tips, dtype=np.int64),
        ends=aligned(tips * HALF),
        diagonal=np.zeros(tips),
        solve=aligned((tips, _padded(tips + 1))),
        solution=np.zeros(tips),
        multiplier=np.zeros(tips),
        sign=np.zeros(tips),
        work=np.zeros(2),
        tableau=np.zeros((tips, 2 * tips + 2)),
        basis=np.zeros(tips, dtype=np.int64),
    )
