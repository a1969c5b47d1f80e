"""Lowest frequencies of a finite element structure, and their error after reduction."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import scipy.sparse.linalg as spla

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.elements.cyclic import NO_COLUMN, nodal_diameter_of
from bladewhirl.models.elements.structure import Structure
from bladewhirl.models.modal.modes import (
    DENSE_LIMIT,
    Modes,
    lowest_pairs,
    natural_frequencies,
)

Frequencies = Mapping[int, FloatArray]
"""Ascending frequencies [rad/s] by nodal diameter, pairs once; all under -1 without symmetry."""


def lowest_frequencies(structure: Structure, count: int) -> Frequencies:
    """Return the lowest frequencies of a supported structure.

    Args:
        structure: in full, without constraint fields; sector by sector where it is cyclic.
        count: how many of each nodal diameter; without symmetry times the number of sectors.
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
    """Return the largest relative frequency error of each family within the range of ``full``.

    Args:
        modes: of a reduced model.
        family: of each of them, (modes,).
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
