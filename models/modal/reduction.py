"""Craig-Bampton reduction (Eq. 3), for each nodal diameter if the structure is cyclic.

The "constraint modes" of the paper after Eq. (3) are fixed-interface modes. Their number is
increased by one if the last mode is the first of a degenerate pair.
"""

from dataclasses import dataclass

import numpy as np
import scipy.linalg as la
import scipy.sparse.linalg as spla

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray, IntArray
from bladewhirl.models.elements.cyclic import NO_COLUMN, SectorLayout, is_pair
from bladewhirl.models.elements.structure import Structure
from bladewhirl.models.modal.modes import (
    DENSE_LIMIT,
    Modes,
    align_phase,
    collect_modes,
    lowest_pairs,
    rayleigh_quotients,
)
from bladewhirl.models.structure.rotating import Rotating

DEGENERATE = 1e-6
"""Relative difference below which two squared fixed-interface frequencies count as a pair."""


@dataclass(frozen=True, kw_only=True)
class ReducedModes:
    """Modes of the Craig-Bampton model of a structure, as fields on the full structure.

    The field of the full structure is x = modes.shapes q, where q are the mass-normalised modal
    coordinates of the reduced model.
    """

    modes: Modes  #: modes of the reduced model, as fields on the full structure
    boundary: IntArray  #: boundary DoF, (boundary,)
    kept: int  #: number of fixed-interface modes, at least the requested number


def craig_bampton(
    structure: Structure, boundary: IntArray, fixed_interface_modes: int, reference: tuple[int, int]
) -> ReducedModes:
    """Reduce a structure to boundary DoF and fixed-interface modes.

    Args:
        structure: structure to reduce, which must be on springs or supports.
        boundary: numbers of the boundary DoF.
        fixed_interface_modes: number of modes with a fixed boundary; increased by one to complete a
            pair.
        reference: see `structure_modes`.

    Raises:
        ValueError: `fixed_interface_modes` is larger than the number of internal DoF.
    """
    internal = structure.size - len(boundary)
    if fixed_interface_modes > internal:
        raise ValueError(
            f"{fixed_interface_modes} fixed-interface modes requested, but the bladed disk has "
            f"{internal} internal degrees of freedom"
        )
    if structure.is_cyclic:
        modes, kept = _cyclic(structure, boundary, fixed_interface_modes, reference)
    else:
        modes, kept = _plain(structure, boundary, fixed_interface_modes)
    return ReducedModes(modes=modes, boundary=boundary, kept=kept)


@dataclass(frozen=True, kw_only=True)
class _Block(Rotating[ComplexArray]):
    """One nodal diameter with its boundary, interior and fixed-interface modes."""

    edge: IntArray
    inside: IntArray
    squares: FloatArray
    vectors: ComplexArray

    def basis(self, kept: int) -> ComplexArray:
        """Return the Craig-Bampton basis with the lowest ``kept`` fixed-interface modes."""
        edge, inside = self.edge, self.inside
        basis = np.zeros((len(self.mass), len(edge) + kept), dtype=self.vectors.dtype)
        basis[edge, np.arange(len(edge))] = 1.0
        if len(edge):
            basis[inside, : len(edge)] = -la.solve(
                self.stiffness[np.ix_(inside, inside)],
                self.stiffness[np.ix_(inside, edge)],
                assume_a="pos",
            )
        basis[inside, len(edge) :] = self.vectors[:, :kept]
        return basis


def craig_bampton_basis(structure: Structure, boundary: IntArray, kept: int) -> FloatArray:
    """Return the real Craig-Bampton basis of a structure, (size, boundary + kept).

    First come the static shapes for a unit displacement of each boundary DoF, then the
    mass-normalised fixed-interface modes in ascending order of frequency.

    Args:
        structure: structure to reduce, which must be on springs or supports.
        boundary: numbers of the boundary DoF.
        kept: number of fixed-interface modes; the number in `ReducedModes` separates no pair.
    """
    inside = np.setdiff1d(np.arange(structure.size), boundary)
    if structure.is_cyclic:
        layout, blocks, count = _cyclic_blocks(structure, boundary, kept)
        squares, parts = [], []
        for k, block in blocks.items():
            vectors = np.zeros((len(block.mass), count[k]), dtype=np.complex128)
            vectors[block.inside] = block.vectors[:, : count[k]]
            parts.append(layout.real_shapes(k, vectors)[0])
            squares.append(np.repeat(block.squares[: count[k]], 1 + is_pair(k, layout.sectors)))
        fixed = np.hstack(parts)[:, np.argsort(np.concatenate(squares), kind="stable")]
    else:
        fixed = np.zeros((structure.size, kept))
        fixed[inside] = _inside_modes(structure, inside, kept)[1]
    return np.hstack([_static_shapes(structure, boundary, inside), fixed])


def _static_shapes(structure: Structure, boundary: IntArray, inside: IntArray) -> FloatArray:
    """Return the static fields for a unit displacement of each boundary DoF, (size, boundary)."""
    shapes = np.zeros((structure.size, len(boundary)))
    shapes[boundary, np.arange(len(boundary))] = 1.0
    rows = structure.stiffness[inside]
    shapes[inside] = -spla.splu(rows[:, inside].tocsc()).solve(rows[:, boundary].toarray())
    return shapes


def _cyclic(
    structure: Structure, boundary: IntArray, count: int, reference: tuple[int, int]
) -> tuple[Modes, int]:
    layout, blocks, kept = _cyclic_blocks(structure, boundary, count)
    squares, shapes, columns, total = [], [], [], 0
    for k, block in blocks.items():
        basis = block.basis(kept[k])
        reduced = (basis.conj().T @ matrix @ basis for matrix in (block.stiffness, block.mass))
        vectors = basis @ la.eigh(*reduced)[1]
        square = rayleigh_quotients(block.stiffness, block.mass, vectors)
        pair = is_pair(k, layout.sectors)
        fields, column = layout.real_shapes(k, align_phase(vectors, reference, pair=pair))
        twice = 2 if pair else 1
        squares.append(np.repeat(square, twice))
        shapes.append(fields)
        columns.append(column)
        total += twice * kept[k]
    modes = collect_modes(
        structure, np.concatenate(squares), np.hstack(shapes), np.concatenate(columns)
    )
    return modes, total


def _cyclic_blocks(
    structure: Structure, boundary: IntArray, count: int
) -> tuple[SectorLayout, dict[int, _Block], dict[int, int]]:
    """Return the block and the number of fixed-interface modes of each nodal diameter."""
    layout = structure.layout
    assert layout is not None  # is_cyclic
    blocks = {
        k: _split(mass, stiffness, _edge(layout, boundary, k), count)
        for k, (mass, stiffness) in layout.blocks(structure.mass, structure.stiffness)
    }
    kept, left = dict.fromkeys(blocks, 0), count
    for _, k in sorted((square, k) for k, block in blocks.items() for square in block.squares):
        if left <= 0:
            break
        kept[k] += 1
        left -= 2 if is_pair(k, layout.sectors) else 1  # pairs are complete
    return layout, blocks, kept


def _edge(layout: SectorLayout, boundary: IntArray, k: int) -> IntArray:
    """Return the positions of the boundary DoF in the block of nodal diameter k."""
    members = abs(layout.basis(k)) > 0.0
    kept = np.isin(np.arange(layout.size), boundary).astype(np.int64)
    in_edge, whole = kept @ members, members.sum(axis=0)
    if not np.all((in_edge == 0) | (in_edge == whole)):
        raise ValueError(
            "the boundary DoF of a cyclic structure must be the same in all sectors and contain "
            "both translations of the centre or none"
        )
    return np.flatnonzero(in_edge)


def _split(mass: ComplexArray, stiffness: ComplexArray, edge: IntArray, count: int) -> _Block:
    inside = np.setdiff1d(np.arange(len(mass)), edge)
    squares, vectors = lowest_pairs(
        stiffness[np.ix_(inside, inside)], mass[np.ix_(inside, inside)], count
    )
    return _Block(
        mass=mass, stiffness=stiffness, edge=edge, inside=inside, squares=squares, vectors=vectors
    )


def _plain(structure: Structure, boundary: IntArray, count: int) -> tuple[Modes, int]:
    inside = np.setdiff1d(np.arange(structure.size), boundary)
    squares, vectors = _inside_modes(structure, inside, min(count + 1, len(inside)))
    while 0 < count < len(squares) and squares[count] - squares[count - 1] <= (
        DEGENERATE * squares[count - 1]
    ):
        count += 1
        squares, vectors = _inside_modes(structure, inside, min(count + 1, len(inside)))
    fixed = np.zeros((structure.size, count))
    fixed[inside] = vectors[:, :count]
    basis = np.hstack([_static_shapes(structure, boundary, inside), fixed])
    stiffness = structure.stiffness
    square, reduced = la.eigh(basis.T @ (stiffness @ basis), basis.T @ (structure.mass @ basis))
    modes = collect_modes(structure, square, basis @ reduced, np.full(len(square), NO_COLUMN))
    return modes, count


def _inside_modes(
    structure: Structure, inside: IntArray, count: int
) -> tuple[FloatArray, FloatArray]:
    stiffness = structure.stiffness[inside][:, inside]
    mass = structure.mass[inside][:, inside]
    if count == 0:
        return np.zeros(0), np.zeros((len(inside), 0))
    if len(inside) > DENSE_LIMIT and count < len(inside) // 2:
        squares, vectors = spla.eigsh(stiffness.tocsc(), k=count, M=mass.tocsc(), sigma=0.0)
        order = np.argsort(squares)
        return squares[order], vectors[:, order]
    squares, vectors = lowest_pairs(stiffness.toarray(), mass.toarray(), count)
    return squares, vectors.real
