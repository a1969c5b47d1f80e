"""Finite element structure: its matrices, its table of degrees of freedom and its sectors."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.elements.cyclic import SectorLayout


@dataclass(frozen=True, kw_only=True)
class Structure:
    """Mass and stiffness of a structure on its free degrees of freedom, sparse and symmetric."""

    mass: sp.csr_array  #: mass matrix [kg, kg m, kg m2], (size, size)
    stiffness: sp.csr_array  #: stiffness with springs [N/m, N, N m], (size, size)
    springs: sp.csr_array  #: part of `stiffness` due to springs, (size, size)
    node_dofs: IntArray  #: DoF of each node, (nodes, components); -1 if fixed
    layout: SectorLayout | None  #: sectors; None for a structure without sectors
    constraints: FloatArray
    """Fields v to which every motion x is orthogonal, v^T M x = 0, (size, constraints); may be
    empty."""
    at_rest: "Structure | None" = None
    """The structure without rotation effects; None if this structure has no rotation effects."""
    gyroscopic: sp.csr_array | None = None
    """Skew matrix 2 Omega G of the Coriolis forces, which multiplies velocities
    [N s/m, N s, N m s], (size, size)."""

    @property
    def elastic(self) -> sp.csr_array:
        """Stiffness without rotation effects, positive definite if the structure is supported."""
        return self.stiffness if self.at_rest is None else self.at_rest.stiffness

    @property
    def size(self) -> int:
        """Number of free degrees of freedom."""
        return int(self.mass.shape[0])

    @cached_property
    def is_cyclic(self) -> bool:
        """True if the mass and stiffness matrices are identical in all sectors."""
        return self.layout is not None and self.layout.is_symmetry_of(
            self.mass, self.stiffness, self.springs
        )

    @property
    def symmetry(self) -> str:
        """Symmetry of the matrices, and the method used for modes and reduction, in words."""
        if self.layout is None:
            return "no sectors: dense path"
        if not self.is_cyclic:
            if self.layout.is_symmetry_of(self.mass, self.stiffness - self.springs):
                return f"{self.layout.sectors} equal sectors on springs that differ: dense path"
            return f"{self.layout.sectors} sectors that differ: dense path"
        return f"{self.layout.sectors} equal sectors: cyclic path"


def keep_free(node_dofs: IntArray, fixed: IntArray) -> IntArray:
    """Renumber the free degrees of freedom from zero.

    Args:
        node_dofs: DoF of each node in the unconstrained structure, (nodes, components).
        fixed: numbers of the DoF fixed at zero.

    Returns:
        `node_dofs` with the new numbers, -1 if fixed.
    """
    free = np.setdiff1d(np.arange(node_dofs.size), fixed)
    renumbered = np.full(node_dofs.size, -1, dtype=np.int64)
    renumbered[free] = np.arange(len(free))
    return np.asarray(renumbered[node_dofs])
