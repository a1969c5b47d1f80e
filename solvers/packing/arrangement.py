"""Arrangement of the modes of a body (rotor or casing) in the arrays of the kernel, and the arrays
of its recurrence in time."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.elements.cyclic import is_pair
from bladewhirl.models.stage.modal_loads import Load
from bladewhirl.models.stage.wall import ReducedCasing
from bladewhirl.models.structure.dft import nodal_diameter_of, real_dft
from bladewhirl.solvers.kernel.structs import Struct, aligned, aligned_copy, lib, padded

PAIR = 2 * lib.LANES  # the kernel processes the columns of a casing two registers at a time
FIT = 1e-9  # largest relative deviation of the displacements of a cyclic body from its DFT columns


@dataclass(frozen=True, kw_only=True)
class Arrangement:
    """Position of each mode in an array of rows and columns.

    On a cyclic body the columns are in two halves: the partner of a cosine column is the sine
    column ``half`` columns further on, and vice versa. If ``parts`` is 2, each half has first
    ``used`` columns of even nodal diameter, then ``used`` columns of odd nodal diameter.
    """

    rows: int  #: number of rows
    columns: int  #: number of columns
    entry: IntArray  #: position of each mode in the flattened array, (modes,)
    half: int = 0  #: number of columns between partners; 0 without partners
    parts: int = 1  #: number of parts of each half, 1 or 2
    used: int  #: number of columns in use in each part of each half

    @property
    def entries(self) -> int:
        """Length of the flattened array."""
        return self.rows * self.columns

    def columns_of(self, part: int) -> IntArray:
        """Return the columns in use of a part, cosine columns first."""
        first = part * self.used + np.arange(self.used)
        return np.concatenate([first, self.half + first]) if self.half else first

    def pack(self, values: FloatArray) -> FloatArray:
        """Put values of modes (..., modes) into their positions in flattened arrays (...,
        entries)."""
        packed = aligned((*values.shape[:-1], self.entries))
        packed[..., self.entry] = values
        return packed

    def grid(self, values: FloatArray) -> FloatArray:
        """Put one value for each mode (modes,) into its position in an array (rows, columns)."""
        return self.pack(values).reshape(self.rows, self.columns)

    def unpack(self, packed: FloatArray) -> FloatArray:
        """Return the values of the modes from flattened arrays, (..., modes)."""
        return packed.take(self.entry, axis=-1)


def dense_arrangement(modes: int) -> Arrangement:
    """Return an arrangement with one row and with a column for each mode."""
    used = max(modes, 1)
    return Arrangement(rows=1, columns=padded(used, PAIR), entry=np.arange(modes), used=used)


def _couples(points: int, parity: int | None, *, alone: bool) -> list[tuple[int, ...]]:
    """Return the DFT columns in pairs: cosine column, sine column.

    Args:
        points: number of points of the circumference.
        parity: 0 for even nodal diameters, 1 for odd nodal diameters; None for all.
        alone: return each column without a partner separately; otherwise all of them in one tuple.
    """
    columns = [c for c in range(points) if parity in (None, nodal_diameter_of(c) % 2)]
    paired = [c for c in columns if is_pair(nodal_diameter_of(c), points)]
    single = [c for c in columns if not is_pair(nodal_diameter_of(c), points)]
    both = [*zip(paired[::2], paired[1::2], strict=True)]
    together = [(column,) for column in single] if alone else [tuple(single)]
    return [*both, *together] if single else list(both)


class Harmonics:
    """DFT columns of a cyclic body and their positions among the columns of its arrangement.

    Args:
        points: number of points of the circumference of the body.
        fold: separate columns of even and odd nodal diameter, if the number of points is even. The
            kernel then uses that values at opposite points are equal for even nodal diameters and
            have opposite signs for odd nodal diameters.
        unit: each half is padded to a multiple of this number of columns.
        alone: give each column without a partner a position with an empty partner. The blocks of a
            rotating body then contain all coupling between its modes.
    """

    def __init__(self, points: int, *, fold: bool, unit: int, alone: bool = False) -> None:
        self.parts = 2 if fold and points % 2 == 0 else 1
        couples = [
            _couples(points, part if self.parts == 2 else None, alone=alone)
            for part in range(self.parts)
        ]
        self.used = max(map(len, couples))
        self.half = padded(self.parts * self.used, unit)
        self.place = np.zeros(points, dtype=np.int64)  # column of each DFT column
        for part, pairs in enumerate(couples):
            for slot, couple in enumerate(pairs):
                for block, column in enumerate(couple):
                    self.place[column] = block * self.half + part * self.used + slot
        self.single = np.array([not is_pair(nodal_diameter_of(c), points) for c in range(points)])
        self.basis = real_dft(points)
        self.shape = np.zeros((points, 2 * self.half))  # DFT basis in the columns of arrangements
        self.shape[:, self.place] = self.basis
        self.crossed = np.roll(self.shape, self.half, axis=1)  # partner of each column

    def amplitudes(self, rows: FloatArray, column: IntArray) -> tuple[FloatArray, FloatArray]:
        """Return the amplitude of each mode in its DFT column and in the partner column.

        Args:
            rows: values of each mode at the points, (points, modes).
            column: DFT column of each mode, (modes,).

        Returns:
            both amplitudes, (modes,) each.

        Raises:
            ValueError: the values are not a combination of both columns.
        """
        direct = np.einsum("pm,pm->m", self.basis[:, column], rows)
        partner = self.crossed[:, self.place[column]]
        other = np.where(self.single[column], 0.0, np.einsum("pm,pm->m", partner, rows))
        fitted = self.basis[:, column] * direct + partner * other
        if not np.abs(fitted - rows).max(initial=0.0) <= FIT * np.abs(rows).max(initial=0.0):
            raise ValueError(
                "the DFT columns of some modes do not match their displacements; give column -1 "
                "to modes without cyclic symmetry"
            )
        return direct, other

    def arrangement(self, place: IntArray) -> Arrangement:
        """Return the arrangement in which the modes of each column are below each other.

        Args:
            place: column of each mode, (modes,).
        """
        columns = 2 * self.half
        rank = np.zeros(len(place), dtype=np.int64)
        for c in range(columns):
            here = place == c
            rank[here] = np.arange(np.count_nonzero(here))
        return Arrangement(
            rows=int(rank.max(initial=0)) + 1,
            columns=columns,
            entry=rank * columns + place,
            half=self.half,
            parts=self.parts,
            used=self.used,
        )


def pack_body(
    frequency: FloatArray,
    damping_ratio: FloatArray,
    loads: list[FloatArray],
    arrangement: Arrangement,
    dt: float,
    *,
    coupled: bool = False,
) -> Struct:
    """Return the coefficients of the recurrence in time of the modes of a body.

    Args:
        frequency: frequency of each mode [rad/s], (modes,); negative if its square is negative.
        damping_ratio: damping ratio of each mode, (modes,).
        loads: modal forces of each load pattern, (modes,) each.
        arrangement: arrangement of the modes.
        dt: time step [s].
        coupled: true if the matrix A = M/dt^2 + D/(2 dt) couples the modes.
    """
    inverse = scheme_inverse(frequency, damping_ratio, dt)
    stiffness, size = frequency * np.abs(frequency), np.abs(frequency)
    decay = damping_ratio * size / dt
    if coupled:
        inverse, decay = np.ones_like(inverse), np.full_like(decay, -1.0 / dt**2)
    load = arrangement.pack(np.reshape(loads, (len(loads), len(frequency))))
    return Struct(
        "Body",
        a=arrangement.pack(inverse * (2.0 / dt**2 - stiffness)),
        b=arrangement.pack(inverse * (decay - 1.0 / dt**2)),
        c=arrangement.pack(inverse),
        stiffness=arrangement.pack(stiffness),
        damping=arrangement.pack(2.0 * damping_ratio * size),
        load=load,
        loaded=_registers_in_use(load),
    )


def scheme_inverse(frequency: FloatArray, damping_ratio: FloatArray, dt: float) -> FloatArray:
    """Return the inverse of A = M/dt^2 + D/(2 dt) for each mode [s2], (modes,)."""
    return np.asarray(1.0 / (1.0 / dt**2 + damping_ratio * np.abs(frequency) / dt))


def folded(shape: FloatArray, arrangement: Arrangement) -> FloatArray:
    """Return the shape (points, columns) on a quarter of the circle for `fold_field` (kernel).

    The result has no rows if folding is impossible: the columns are not separated by parity, or
    the points of a quarter, padded to whole vector registers, extend beyond half of the circle.
    """
    points = len(shape)
    width = padded(points // 4 + 1)
    if arrangement.parts == 1 or width - 1 > points // 2:
        return aligned((0, lib.LANES))
    quarter = shape[:width]
    last = quarter[:, arrangement.half + arrangement.used - 1]
    rows = quarter[:, np.concatenate([arrangement.columns_of(part) for part in range(2)])].T
    rows = rows.reshape(2, 2, arrangement.used, width).transpose(1, 0, 2, 3).reshape(-1, width)
    rows[3 * arrangement.used - 1] = 0.0
    return aligned_copy(np.vstack([rows, last]))


def lengthened(values: FloatArray) -> FloatArray:
    """Return arrays whose rows are padded with zeros to whole registers, (..., padded)."""
    out = aligned((*values.shape[:-1], padded(values.shape[-1])))
    out[..., : values.shape[-1]] = values
    return out


def closed_nodes(casing: ReducedCasing) -> IntArray:
    """Return the numbers of the nodes of each wall and of its first node again, (walls, closed);
    of several walls as often as to fill whole registers."""
    closed = casing.closed
    width = closed.shape[1]
    further = 0 if casing.walls == 1 else padded(width) - width
    return np.pad(closed, ((0, 0), (0, further)), "edge")


def by_column(shape: FloatArray, arrangement: Arrangement) -> FloatArray:
    """Transpose a shape (points, columns) to (used columns, padded points)."""
    used = arrangement.half + arrangement.parts * arrangement.used
    return lengthened(shape[:, :used].T)


def load_times(loads: Sequence[Load]) -> FloatArray:
    """Return end, ramp, frequency and phase of each load pattern, (patterns, 4)."""
    times = [[load.end, load.ramp, load.frequency, load.phase] for load in loads]
    return np.reshape(times, (len(loads), 4)).astype(np.float64)


def _registers_in_use(patterns: FloatArray) -> IntArray:
    """Return where each load pattern is not zero: the first entry of each group of LANES entries
    with a nonzero number, padded with -1, (patterns, groups)."""
    used = [lib.LANES * np.flatnonzero(p.reshape(-1, lib.LANES).any(axis=1)) for p in patterns]
    places = np.full((len(patterns), max(map(len, used), default=0) + 1), -1)
    for row, place in zip(places, used, strict=True):
        row[: len(place)] = place
    return places
