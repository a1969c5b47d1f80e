"""Stresses of a reduced superelement: of its modes, of contact forces, and of steady rotation.

The stress at a point of the surface is

    s = S (Phi q + Y f + Omega^2 u),      K(Omega) u = M X

with the rows S of `stress_recovery`, the modes Phi and their coordinates q, the displacements Y by
contact forces f without their part in the modes (so that the stress under static forces is exact),
and the static displacements u by the centrifugal forces M X of the structure, `centrifugal_load`.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray

if TYPE_CHECKING:
    from bladewhirl.models.superelements.superelement import Superelement

COMPONENTS = 6  #: components xx, yy, zz, xy, yz and zx of a stress


@dataclass(frozen=True, kw_only=True)
class ReducedStress:
    """Stress at the points of a reduced superelement, in the axes of its file; in those of each
    sector for a wheel from a sector."""

    modes: FloatArray  #: stress for unit modal coordinates [Pa kg^-1/2/m], (6p, modes)
    forces: FloatArray
    """Stress by unit contact forces without their part in the modes [Pa/N], (1, 6p, 3c); for a
    wheel from a sector that of a sector by forces on the sector that is a number of sectors behind,
    (sectors, 6p of a sector, 3c of a sector)."""
    steady: FloatArray | None
    """Stress by the centrifugal forces at 1 rad/s [Pa s2], (6p,); None if the file does not give
    them."""


def load_columns(part: "Superelement", rows: FloatArray) -> FloatArray:
    """Return columns of forces on contact nodes, with the centrifugal load if its stress is needed,
    (n, 3c or 3c + 1)."""
    if part.stress_recovery is None or part.centrifugal_load is None:
        return rows
    return np.column_stack([rows, part.centrifugal_load])


def reduced_stress(
    part: "Superelement", squares: FloatArray, shapes: FloatArray, moved: FloatArray, elastic: Any
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
        steady = rows @ (moved[:, -1] + shapes[:, elastic] @ loads)
    return ReducedStress(
        modes=np.asarray(rows @ shapes),
        forces=np.asarray(rows @ moved[:, : 3 * part.contacts])[None],
        steady=steady,
    )


def stress_faults(part: "Superelement") -> Iterator[str]:
    """Yield the faults of the arrays of stresses, each as "KEY: expected ..."."""
    n, rows, given_points = part.size, part.stress_recovery, part.points
    points = 0 if given_points is None or not given_points.ndim else len(given_points)
    if part.centrifugal_load is not None and part.centrifugal_load.shape != (n,):
        yield f"centrifugal_load: expected ({n},), got {part.centrifugal_load.shape}"
    if rows is not None and rows.shape != (COMPONENTS * points, n):
        given = tuple(map(int, rows.shape))
        yield f"stress_recovery: expected {(COMPONENTS * points, n)}, six rows a point, got {given}"
    for key, least, most in (("young_modulus", 0.0, np.inf), ("poisson_ratio", -1.0, 0.5)):
        values = getattr(part, key)
        if values is None:
            continue
        if rows is None:
            yield f"{key}: only allowed together with stress_recovery, which is missing"
        elif values.shape != (points,):
            yield f"{key}: expected a number for each point, ({points},), got {values.shape}"
        elif not ((values > least) & (values <= most)).all():
            yield f"{key}: expected numbers above {least:g}, up to {most:g}"
    if (part.young_modulus is None) != (part.poisson_ratio is None):
        yield "young_modulus: expected both young_modulus and poisson_ratio, or neither"
