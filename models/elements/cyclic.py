"""Cyclic symmetry: the real discrete Fourier transform (DFT) over sectors, and the reduction of a
structure to a single sector for each nodal diameter.

These conventions hold for the whole package. The sectors n = 0..N-1 are numbered counter-clockwise,
in the sense of rotation, at a distance of alpha = 2 pi / N. A field with nodal diameter k has
sector values Re(p exp(i k n alpha)). *Forward* means in the sense of rotation: for positive omega
and k, a motion exp(i (k theta - omega t)) travels forward, and exp(i (k theta + omega t)) travels
backward.

The columns of the real DFT are numbered 0 for k = 0, 2k - 1 for the cosine and 2k for the sine of
k = 1..floor((N-1)/2), and N - 1 for k = N/2 when N is even. (The paper's floor(N/2 - 1) holds for
even N only; its Eqs 11-13 are used with the corrected constant, see `structure.dft.real_dft`.)
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray, IntArray

SYMMETRY_TOLERANCE = 1e-12
"""A matrix counts as cyclically symmetric if a rotation by one sector changes each entry by at most
this fraction of the largest entry in the same row or column. As this scale is local, one soft
spring that differs from the others is noticed even if the matrix also contains stiff beams."""

NO_COLUMN = -1  #: DFT column of a mode computed without cyclic symmetry


def nodal_diameters(sectors: int) -> range:
    """Return all nodal diameters of a structure with N sectors: 0..floor(N/2)."""
    return range(sectors // 2 + 1)


def is_pair(k: int, sectors: int) -> bool:
    """Return true if modes of nodal diameter k are pairs of a cosine and a sine mode. Modes with
    k = 0 or k = N/2 are single."""
    return 0 < 2 * k < sectors


def wave_parts(field: FloatArray, angle: FloatArray, k: IntArray) -> FloatArray:
    """Return cosine and sine parts of fields that are sampled at equal steps around the circle.

    A field sum_k a_k cos k theta + b_k sin k theta has the parts a_k and b_k; k is at most half
    the number of angles N. For k = N/2 the samples do not determine both parts; the parts with the
    least a_k^2 + b_k^2 are returned.

    Args:
        field: samples of the fields, (angles, fields).
        angle: theta [rad], (angles,).
        k: nodal diameters, (harmonics,).

    Returns:
        a_k and b_k, (harmonics, 2, fields).
    """
    count = len(angle)
    share = np.where((k == 0) | (2 * k == count), 1.0, 2.0) / count
    phase = np.multiply.outer(k, angle)
    waves = np.stack([np.cos(phase), np.sin(phase)], axis=1)
    return np.asarray(share[:, None, None] * (waves @ field))


def evenly_spaced(angles: FloatArray) -> bool:
    """Return true if angles increase in equal steps of 2 pi divided by their number."""
    even = 2.0 * np.pi * np.arange(len(angles)) / len(angles)
    steps = np.mod(angles - angles[0] - even, 2 * np.pi)
    return bool(np.minimum(steps, 2.0 * np.pi - steps).max() < 1e-9)


@dataclass(frozen=True, kw_only=True)
class SectorLayout:
    """Numbers of the degrees of freedom of each sector and of the centre in a structure."""

    sector_dofs: IntArray
    """Degrees of freedom of each sector in polar axes, in the same order in every sector,
    (sectors, DoF per sector)."""
    centre_dofs: IntArray  #: DoF x, y, rotation of the centre, (3,); -1 for a missing DoF
    rounding: float = 0.0
    """Bound on the relative change of matrix entries between sectors by rounded coordinates."""

    @property
    def sectors(self) -> int:
        """Number of sectors N."""
        return len(self.sector_dofs)

    @property
    def size(self) -> int:
        """Number of degrees of freedom of the whole structure."""
        return self.sector_dofs.size + int(np.count_nonzero(self.centre_dofs >= 0))

    def basis(self, k: int) -> sp.csc_array:
        """Return the orthonormal complex basis of nodal diameter k, (size, DoF of the block).

        The centre's translation along (1, i)/sqrt(2) belongs to k = 1: if the structure is turned
        by one sector, this translation is multiplied by exp(-i alpha), and so are the sector values
        exp(i n alpha) of k = 1.
        """
        count, per_sector = self.sector_dofs.shape
        wave = np.exp(2j * np.pi * k * np.arange(count) / count) / np.sqrt(count)
        rows = [self.sector_dofs.ravel()]
        columns = [np.tile(np.arange(per_sector), count)]
        values = [np.repeat(wave, per_sector)]
        centre_x, centre_y, centre_rotation = self.centre_dofs
        if k == 1 and centre_x >= 0:
            rows.append(np.array([centre_x, centre_y]))
            columns.append(np.full(2, per_sector))
            values.append(np.array([1.0, 1.0j]) / np.sqrt(2.0))
        if k == 0 and centre_rotation >= 0:
            rows.append(np.array([centre_rotation]))
            columns.append(np.array([per_sector]))
            values.append(np.ones(1, dtype=np.complex128))
        column = np.concatenate(columns)
        entries = (np.concatenate(values), (np.concatenate(rows), column))
        return sp.csc_array(entries, shape=(self.size, int(column.max()) + 1))

    def turn(self) -> sp.csr_array:
        """Return the matrix that rotates a field by one sector, (size, size)."""
        count = self.sectors
        alpha = 2.0 * np.pi / count
        rows, columns = [np.roll(self.sector_dofs, -1, axis=0).ravel()], [self.sector_dofs.ravel()]
        values = [np.ones(self.sector_dofs.size)]
        centre_x, centre_y, centre_rotation = self.centre_dofs
        if centre_x >= 0:
            rows.append(np.array([centre_x, centre_x, centre_y, centre_y]))
            columns.append(np.array([centre_x, centre_y, centre_x, centre_y]))
            cos, sin = np.cos(alpha), np.sin(alpha)
            values.append(np.array([cos, -sin, sin, cos]))
        if centre_rotation >= 0:
            rows.append(np.array([centre_rotation]))
            columns.append(np.array([centre_rotation]))
            values.append(np.ones(1))
        entries = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
        return sp.csr_array(entries, shape=(self.size, self.size))

    def is_symmetry_of(self, *matrices: sp.csr_array) -> bool:
        """Return true if the matrices are invariant under a rotation by one sector."""
        turn, tolerance = self.turn(), max(SYMMETRY_TOLERANCE, self.rounding)
        for matrix in matrices:
            change = (turn @ matrix @ turn.T - matrix).tocoo()
            largest = abs(matrix).max(axis=1).toarray()
            scale = np.maximum(largest[change.row], largest[change.col])
            if np.any(np.abs(change.data) > tolerance * scale):
                return False
        return True

    def blocks(self, *matrices: sp.csr_array) -> Iterator[tuple[int, tuple[ComplexArray, ...]]]:
        """Yield each nodal diameter k with the dense block of each matrix that acts on k.

        If sectors differ, the blocks belong to the mean of all sectors.
        """
        means = [self._mean_sector(matrix) for matrix in matrices]
        for k in nodal_diameters(self.sectors):
            basis = self.basis(k) if k <= 1 else None
            if basis is not None and basis.shape[1] > self.sector_dofs.shape[1]:  # with the centre
                blocks = ((basis.conj().T @ matrix @ basis).toarray() for matrix in matrices)
            else:
                blocks = (self._turned(mean, k) for mean in means)
            yield k, tuple(blocks)

    def _mean_sector(self, matrix: sp.csr_array) -> tuple[FloatArray, IntArray]:
        """Return the blocks of a matrix that couple a sector with itself and with other sectors;
        each block is the mean over all sectors.

        Returns:
            values (entries,) and their positions (3, entries): offset in sectors to the coupled
            sector, row, and column within the block.
        """
        count, per_sector = self.sector_dofs.shape
        sector, place = np.full((2, self.size), -1)
        sector[self.sector_dofs] = np.arange(count)[:, None]
        place[self.sector_dofs] = np.arange(per_sector)
        entries = matrix.tocoo()
        inside = (sector[entries.row] >= 0) & (sector[entries.col] >= 0)
        row, column = entries.row[inside], entries.col[inside]
        on = (sector[column] - sector[row]) % count
        shape = (count, per_sector, per_sector)
        flat = np.ravel_multi_index((on, place[row], place[column]), shape)
        known, which = np.unique(flat, return_inverse=True)
        total = np.bincount(which, weights=entries.data[inside], minlength=len(known))
        return total / count, np.array(np.unravel_index(known, shape))

    def _turned(self, mean: tuple[FloatArray, IntArray], k: int) -> ComplexArray:
        """Return block k of a matrix without a centre, from its `_mean_sector`."""
        count, per_sector = self.sector_dofs.shape
        values, (on, row, column) = mean
        turned = values * np.exp(2j * np.pi * ((k * on) % count) / count)
        return np.asarray(sp.coo_array((turned, (row, column)), (per_sector, per_sector)).toarray())

    def real_shapes(self, k: int, vectors: ComplexArray) -> tuple[FloatArray, IntArray]:
        """Return real fields from complex amplitudes; of each pair, the cosine before the sine.

        Args:
            k: nodal diameter.
            vectors: complex amplitudes p, (DoF of the block, m). Vectors that are orthonormal with
                respect to the mass of the block give fields that are orthonormal with respect to
                the mass of the structure.

        Returns:
            fields (size, m or 2 m) and the DFT column of each.
        """
        fields = self.basis(k) @ vectors
        if not is_pair(k, self.sectors):
            column = 0 if k == 0 else self.sectors - 1
            return np.ascontiguousarray(fields.real), np.full(fields.shape[1], column)
        # Re(p exp(i k n alpha)) is the cosine; Re(-i p exp(i k n alpha)) is the sine.
        pairs = np.sqrt(2.0) * np.stack([fields.real, fields.imag], axis=-1)
        columns = np.tile([2 * k - 1, 2 * k], fields.shape[1])
        return pairs.reshape(len(fields), -1), columns


def wave_shares(shapes: FloatArray, weights: FloatArray, layout: SectorLayout) -> FloatArray:
    """Return the share of each nodal diameter in each field, (floor(N/2) + 1, m).

    The shares of each field sum to one.

    Args:
        shapes: fields, (size, m).
        weights: weight of each degree of freedom, the diagonal of the mass matrix, (size,).
        layout: sectors of the structure.
    """
    spectrum = np.fft.fft(shapes[layout.sector_dofs], axis=0, norm="ortho")
    power = np.einsum("nim,i->nm", np.abs(spectrum) ** 2, weights[layout.sector_dofs[0]])
    shares = power[: layout.sectors // 2 + 1].copy()
    for k in nodal_diameters(layout.sectors):
        if is_pair(k, layout.sectors):
            shares[k] += power[layout.sectors - k]
    centre = layout.centre_dofs
    for k, dofs in ((1, centre[:2]), (0, centre[2:])):
        dofs = dofs[dofs >= 0]
        shares[k] += weights[dofs] @ shapes[dofs] ** 2
    return np.asarray(shares / shares.sum(axis=0))
