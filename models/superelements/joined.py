"""Modes that describe the motions of a structure over a range of speeds."""

from dataclasses import replace
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


def over_speeds(
    part: Superelement, highest: float, *, between: bool = True
) -> tuple[Superelement, ...]:
    """Return a structure at rest and at half and all of the highest speed [rad/s], with K + Omega^2
    M in place of the stiffness K: the modes are the same, and rotation softens none of them. The
    structure at half the speed is only needed for speeds `between`.

    The modes of all three together describe motions at any speed in between, which those at rest
    alone do slowly: 160 modes of each nodal diameter of a sector of solids leave an error of 1e-3
    where stiffening raises a frequency by a hundredth. Without matrices of the change of the
    stiffness, or without a speed, only the structure at rest is returned.
    """
    if part.stiffness_speed is None or highest == 0.0:
        return (part,)
    speeds = (0.5 * highest, highest) if between else (highest,)
    turning = map(part.at, speeds)
    return part, *(
        replace(each, stiffness=each.stiffness + omega**2 * part.mass)
        for each, omega in zip(turning, speeds, strict=True)
    )


def range_of(omega: float) -> float:
    """Return the next power of two above a speed [rad/s], up to which structures are condensed, so
    that points of a sweep and single runs have the same numbers; 0 at rest."""
    return 2.0 ** float(np.ceil(np.log2(abs(omega)))) if omega else 0.0


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
