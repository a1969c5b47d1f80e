"""Modes of a structure in the space of given fields."""

from typing import Any, TypeVar

import numpy as np
import scipy.linalg as la

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.models.superelements.reduction import small_shift
from bladewhirl.models.superelements.superelement import Superelement

DEPENDENT = 1e-13
"""A direction in the space of modes at several speeds is a rounding error if its stiffness is at
most this fraction of the largest one."""

LEAST_MASS = 1e-8  #: least mass of a motion of unit stiffness, divided by the largest one

Field = TypeVar("Field", FloatArray, ComplexArray)


def joined(part: Superelement, fields: list[Field]) -> Field:
    """Return mass-normalised modes of the structure at rest in the space of all fields, (n, m).

    Motions without mass, which incompatible modes of elements have, get the mass `LEAST_MASS`.
    """
    if len(fields) == 1:
        return fields[0]
    basis, shift = np.hstack(fields), small_shift(part)
    for _ in range(3):  # again for rounding errors
        basis = basis / np.linalg.norm(basis, axis=0)
        strained = part.stiffness @ basis + shift * (part.mass @ basis)
        lengths, turn = la.eigh(_hermitian(basis.conj().T @ strained))
        kept = lengths > DEPENDENT * lengths[-1]
        basis = basis @ (turn[:, kept] / np.sqrt(lengths[kept]))
    masses, turn = la.eigh(_hermitian(basis.conj().T @ (part.mass @ basis)))
    least = LEAST_MASS * masses[-1]
    return np.asarray(basis @ (turn / np.sqrt(np.maximum(masses, least)))[:, ::-1])


def _hermitian(matrix: Any) -> Any:
    return 0.5 * (matrix + matrix.conj().T)
