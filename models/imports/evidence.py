"""Evidence in imported matrices that their rows belong to the nodes of the table.

A stiffness K resists no rigid motion: K times a translation of all nodes is zero, except near
displacements that are fixed. This holds for reduced matrices too.
"""

from collections.abc import Iterator

import numpy as np
import scipy.sparse as sp

from bladewhirl.meshes.line_mesh import BoolArray, FloatArray, IntArray
from bladewhirl.models.imports.parts import ForeignPart
from bladewhirl.models.superelements.superelement import FIXED, SuperelementError

ROUNDING = 1e-4
"""A force is zero up to this fraction of the sum of the magnitudes of its terms."""

FEWER = 0.9
"""Another order of the rows is right if forces are zero except for this share of those before."""

UNEQUAL = 0.01
"""Masses along x, y and z differ by more than this fraction if displacements are missing."""


def check_order(part: ForeignPart) -> None:
    """Check that the rows are x, y and z node by node, not all x, then all y, then all z.

    Raises:
        SuperelementError: in the other order a translation strains fewer rows.
    """
    nodes = np.flatnonzero((part.dofs != FIXED).all(axis=1))
    dofs = part.dofs[nodes]
    if len(nodes) < 2 or part.size % len(nodes) or np.any(np.diff(dofs, axis=1) != 1):
        return
    rank = np.argsort(np.argsort(dofs[:, 0]))
    other = rank[:, None] + len(nodes) * np.arange(3)
    here, there = (np.mean(_strained(part, rows)) for rows in (dofs, other))
    if there < FEWER * here:
        raise SuperelementError(
            "expected rows x, y and z of one node after the other, but a translation strains"
            f" {100 * here:.0f} % of the rows of the stiffness, and {100 * there:.0f} % if they are"
            " x of all nodes, then y, then z: write their numbers as row_x, row_y and row_z"
        )


def hints_of(
    part: ForeignPart, mass: FloatArray, rigid_modes: int, *, free: bool, clamped: bool
) -> Iterator[str]:
    """Yield hints that rows belong to other nodes or directions.

    Args:
        part: matrices before nodes are clamped.
        mass: mass along x, y and z without fixed nodes [kg], (3,).
        rigid_modes: number of rigid modes of the superelement.
        free: whether the matrices contain the nodes to clamp.
        clamped: whether nodes of the superelement are fixed, and it is no sector.
    """
    if np.ptp(mass) > UNEQUAL * mass.max():
        values = ", ".join(f"{value:.4g}" for value in mass)
        yield (
            f"unusual masses along x, y and z = {values} kg: expected equal ones, unless single"
            " displacements are fixed or tied to others"
        )
    if clamped and rigid_modes:
        yield (
            f"unusual {rigid_modes} rigid modes of a clamped part: expected none; check the clamped"
            " nodes and the rows of their displacements"
        )
    if not free or (part.dofs == FIXED).any():
        return
    if _strained(part, part.dofs).any():
        yield (
            "K times a translation is not zero: expected nodes that are all free before some are"
            " clamped, or matrices of a supported or rotating part"
        )
    elif part.size == part.dofs.size and _strained_by_rotation(part):
        yield (
            "K times a rotation is not zero: expected the position of each node at its own rows,"
            " or matrices of a rotating part"
        )


def _strained(part: ForeignPart, dofs: IntArray) -> BoolArray:
    """Return whether each force under a translation along x, y and z is not zero."""
    moved = np.zeros((part.size, 3))
    for axis in range(3):
        moved[dofs[dofs[:, axis] != FIXED, axis], axis] = 1.0
    return _forces(part, moved)


def _strained_by_rotation(part: ForeignPart) -> bool:
    place = part.points - part.points.mean(axis=0)
    moved = np.zeros((part.size, 3))
    for axis in range(3):
        moved[part.dofs.ravel(), axis] = np.cross(np.eye(3)[axis], place).ravel()
    return bool(_forces(part, moved).any())


def _forces(part: ForeignPart, moved: FloatArray) -> BoolArray:
    stiffness = sp.csr_array(part.stiffness)
    terms = abs(stiffness) @ abs(moved)
    strained = np.asarray(abs(stiffness @ moved) > ROUNDING * terms, dtype=np.bool_)
    return np.asarray(strained[terms > 0.0])
