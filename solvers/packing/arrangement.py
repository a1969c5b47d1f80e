"""Arrangement of a body's modes as the kernel works on them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.elements.cyclic import is_pair, nodal_diameter_of, real_dft
from bladewhirl.solvers.kernel.structs import aligned, lib, padded

PAIR = 2 * lib.LANES  # the kernel takes a casing's columns two registers at a time
FIT = 1e-9  # largest relative misfit of a cyclic body's rows to its DFT columns


@dataclass(frozen=True, kw_only=True)
class Arrangement:
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

    def grid(self, values: FloatArray) -> FloatArray:
        """The same of one value a mode as (rows, columns)."""
        return self.pack(values).reshape(self.rows, self.columns)

    def unpack(self, packed: FloatArray) -> FloatArray:
        """Read the values of modes back, (..., modes)."""
        return packed.take(self.entry, axis=-1)


def dense_arrangement(modes: int) -> Arrangement:
    """One row, a column a mode."""
    used = max(modes, 1)
    return Arrangement(rows=1, columns=padded(used, PAIR), entry=np.arange(modes), used=used)


def _couples(points: int, parity: int | None, *, alone: bool) -> list[tuple[int, ...]]:
    """DFT columns of one parity (or all) two by two: cosine and sine, singles together or alone."""
    wanted = [c for c in range(points) if parity in (None, nodal_diameter_of(c) % 2)]
    paired = [c for c in wanted if is_pair(nodal_diameter_of(c), points)]
    single = [c for c in wanted if not is_pair(nodal_diameter_of(c), points)]
    both = [*zip(paired[::2], paired[1::2], strict=True)]
    together = [(column,) for column in single] if alone else [tuple(single)]
    return [*both, *together] if single else list(both)


class Harmonics:
    """DFT columns of a cyclic body and where they stand among its arrangement's.

    Args:
        points: of the body's circumference.
        fold: keep columns of even and odd nodal diameter apart, so that the kernel can use that
            opposite points are equal in the former and opposite in the latter (even numbers of
            points only).
        unit: each half is padded to a multiple of it.
        alone: give each column without a partner a place whose partner is empty, so that the
            blocks of a turning body hold all that couples its modes.
    """

    def __init__(self, points: int, *, fold: bool, unit: int, alone: bool = False) -> None:
        self.parts = 2 if fold and points % 2 == 0 else 1
        couples = [
            _couples(points, part if self.parts == 2 else None, alone=alone)
            for part in range(self.parts)
        ]
        self.used = max(map(len, couples))
        self.half = padded(self.parts * self.used, unit)
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
                "the DFT columns of some modes do not match their displacements; give column -1 "
                "to modes without cyclic symmetry"
            )
        return own, other

    def arrangement(self, place: IntArray) -> Arrangement:
        """Arrangement with each mode in the column given, (modes,), rows by rank."""
        columns = 2 * self.half
        rank = np.zeros(len(place), dtype=np.int64)
        for c in range(columns):
            own = place == c
            rank[own] = np.arange(np.count_nonzero(own))
        return Arrangement(
            rows=int(rank.max(initial=0)) + 1,
            columns=columns,
            entry=rank * columns + place,
            half=self.half,
            parts=self.parts,
            used=self.used,
        )
