"""Lowest frequencies of full structures, and the errors of reduced ones."""

from collections.abc import Mapping

import numpy as np
import scipy.sparse.linalg as spla

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.elements.cyclic import NO_COLUMN
from bladewhirl.models.elements.structure import Structure
from bladewhirl.models.modal.modes import (
    DENSE_LIMIT,
    Modes,
    lowest_pairs,
    natural_frequencies,
)
from bladewhirl.models.structure.dft import nodal_diameter_of

Frequencies = Mapping[int, FloatArray]
"""Frequencies by nodal diameter in ascending order [rad/s]; a pair has one entry. The key -1 has
all frequencies of a structure without symmetry."""


def lowest_frequencies(structure: Structure, count: int) -> Frequencies:
    """Return the lowest frequencies of a supported structure.

    Args:
        structure: full structure without constraints.
        count: number of frequencies of each nodal diameter. Without symmetry, the number of
            frequencies is `count` times the number of sectors.
    """
    layout = structure.layout
    if layout is not None and structure.is_cyclic:
        return {
            k: natural_frequencies(structure, lowest_pairs(stiffness, mass, count)[0])
            for k, (mass, stiffness) in layout.blocks(structure.mass, structure.stiffness)
        }
    total = count * (layout.sectors if layout else 1)
    if structure.size > DENSE_LIMIT:
        squares = spla.eigsh(
            structure.stiffness.tocsc(),
            k=min(total, structure.size - 1),
            M=structure.mass.tocsc(),
            sigma=0.0,
            return_eigenvectors=False,
        )
    else:
        squares = lowest_pairs(structure.stiffness.toarray(), structure.mass.toarray(), total)[0]
    return {NO_COLUMN: natural_frequencies(structure, np.sort(squares))}


def family_errors(modes: Modes, family: list[str], full: Frequencies) -> dict[str, float]:
    """Return for each family the largest relative error of its frequencies; frequencies that
    ``full`` lacks are left out.

    Args:
        modes: modes of a reduced model.
        family: family of each mode, (modes,).
        full: frequencies of the full model.
    """
    errors: dict[str, float] = {}
    rank: dict[int, int] = {}
    for mode in range(modes.count):
        column = int(modes.column[mode])
        position = rank.get(column, 0)
        rank[column] = position + 1
        exact = full[NO_COLUMN if column == NO_COLUMN else nodal_diameter_of(column)]
        if position < len(exact) and exact[position] != 0.0:
            error = abs(modes.frequency[mode] / exact[position] - 1.0)
            errors[family[mode]] = max(errors.get(family[mode], 0.0), float(error))
    return errors
