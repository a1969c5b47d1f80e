"""Stresses of a reduced superelement: of its modes, of contact forces, and of steady rotation.

The stress at a point of the surface is

    s = S (Phi q + Y f + Omega^2 u),      K(Omega) u = M X

with the rows S of `stress_recovery`, the modes Phi and their coordinates q, the displacements Y by
contact forces f without their part in the modes (so that the stress under static forces is exact),
and the static displacements u by the centrifugal forces M X of the structure, `centrifugal_load`.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.superelements.superelement import Matrix, Superelement

RECOVERED = {"points": "recovery", "strains": "strain_recovery", "stresses": "stress_recovery"}
"""Names of what is recovered from the coordinates, and of its rows in the superelement."""


InModes = Callable[[FloatArray | None], FloatArray]
"""Function that returns a quantity at all points, (rows, m), in combinations of modes, (modes, m);
in the modes themselves for None. It may be large, and is computed where it is needed."""


@dataclass(frozen=True, kw_only=True)
class ReducedStress:
    """Stress at the points of a reduced superelement, in the axes of its file; in those of each
    sector for a wheel from a sector."""

    of_modes: InModes  #: computes `modes`
    forces: FloatArray
    """Stress by unit contact forces without their part in the modes [Pa/N], (1, 6p, 3c); for a
    wheel from a sector that of a sector by forces on the sector that is a number of sectors behind,
    (sectors, 6p of a sector, 3c of a sector)."""
    steady: FloatArray | None
    """Stress by the centrifugal forces at 1 rad/s [Pa s2], (6p,); None if the file does not give
    them."""

    @cached_property
    def modes(self) -> FloatArray:
        """Stress for unit modal coordinates [Pa kg^-1/2/m], (6p, modes)."""
        return self.of_modes(None)


def rows_in_modes(rows: Matrix, shapes: FloatArray) -> InModes:
    """Return the function of rows on the coordinates, (rows, n), and modes, (n, modes)."""
    return lambda turn: np.asarray(rows @ (shapes if turn is None else shapes @ turn))


def recovered_rows(part: Superelement) -> dict[str, Matrix]:
    """Return the rows of each of `RECOVERED`; no rows for what the file does not give."""
    none = sp.csr_array((0, part.size))
    given = {name: getattr(part, key) for name, key in RECOVERED.items()}
    return {name: none if rows is None else rows for name, rows in given.items()}


def load_columns(part: Superelement, rows: FloatArray) -> FloatArray:
    """Return columns of forces on contact nodes, and the loads of the rotation that are known,
    (n, 3c + loads)."""
    return np.column_stack([rows, part.loads])


def reduced_stress(
    part: Superelement, squares: FloatArray, shapes: FloatArray, moved: FloatArray, elastic: Any
) -> ReducedStress | None:
    """Return the stresses of a reduction; None without `stress_recovery`.

    Args:
        part: superelement.
        squares: squared frequencies of the modes [rad2/s2], (modes,).
        shapes: mass-normalised modes [kg^-1/2], (n, modes).
        moved: static displacements without their part in the modes, by the columns of
            `load_columns`.
        elastic: which modes are not rigid, (modes,).
    """
    rows = part.stress_recovery
    if rows is None:
        return None
    steady = None
    if part.centrifugal_load is not None:
        loads = shapes[:, elastic].T @ part.centrifugal_load / squares[elastic]
        steady = rows @ (moved[:, 3 * part.contacts] + shapes[:, elastic] @ loads)
    return ReducedStress(
        of_modes=rows_in_modes(rows, shapes),
        forces=np.asarray(rows @ moved[:, : 3 * part.contacts])[None],
        steady=steady,
    )
