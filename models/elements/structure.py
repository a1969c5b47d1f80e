"""Finite element structure: its matrices, its table of degrees of freedom and its sectors."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.elements.cyclic import SectorLayout
from bladewhirl.models.structure.rotating import Effects, Rotating
from bladewhirl.models.structure.waves import Waves


@dataclass(frozen=True, kw_only=True)
class Structure(Rotating[sp.csr_array]):
    """A structure on its free degrees of freedom, with sparse matrices in m, kg, s and rad; the
    stiffness includes springs."""

    FORMS: ClassVar[tuple[str, ...]] = (*Rotating.FORMS, "springs", "translated")

    springs: sp.csr_array  #: part of `stiffness` due to springs, (size, size)
    node_dofs: IntArray  #: DoF of each node, (nodes, components); -1 if fixed
    layout: SectorLayout | None  #: sectors; None for a structure without sectors
    constraints: FloatArray
    """Fields v to which every motion x is orthogonal, v^T M x = 0, (size, constraints); may be
    empty."""
    translated: sp.csr_array = None
    """Mass matrix M_t of the translations, on which the rotation acts, (size, size); None if it is
    not known. It is part of `stiffness_speed` with a negative sign."""
    inertia: float = 0.0
    """Moment of inertia of the undeformed structure about the axis [kg m2]; with `translated`."""
    at_rest: "Structure | None" = None
    """The structure at rest; None if this structure has no rotation effects."""

    @property
    def still(self) -> "Structure":
        """The structure at rest."""
        return self if self.at_rest is None else self.at_rest

    @property
    def elastic(self) -> sp.csr_array:
        """Stiffness without rotation effects, positive definite if the structure is supported."""
        return self.still.stiffness

    def at(self, omega: float, effects: Effects = "full") -> "Structure":
        """Return the structure linearised about its state of steady rotation.

        Args:
            omega: speed of rotation [rad/s], counter-clockwise.
            effects: rotation effects to include; for "none", the structure at rest is returned.
        """
        if effects == "none":
            return self.under(effects)
        return replace(super().at(omega, effects), at_rest=self)

    @cached_property
    def growth(self) -> FloatArray:
        """Static displacement K^-1 M_t X for a speed of 1 rad/s [m s2, s2], (size,)."""
        return np.asarray(spla.spsolve(self.elastic.tocsc(), self.centrifugal_load))

    def static_displacement(self, omega: float, *, follows: bool = True) -> FloatArray:
        """Return the static displacement u due to steady rotation, (size,).

        Args:
            omega: speed of rotation [rad/s].
            follows: let the load increase with the displacement: (K - Omega^2 M_t) u = Omega^2 M_t
                X. If false, u is proportional to Omega^2; it is then 0.02 % smaller at the
                reference frequency.
        """
        if not follows:
            return omega**2 * self.growth
        softened = sp.csc_array(self.elastic - omega**2 * self.translated)
        return np.asarray(spla.spsolve(softened, omega**2 * self.loads[:, 0]))

    def displaced(self, displacement: FloatArray) -> "Structure":
        """Return the structure with the loads of the rotation in a displaced state, (size,), and
        its moment of inertia."""
        (centrifugal, euler), moved = self.loads.T, self.translated @ displacement
        return replace(
            self,
            centrifugal_load=centrifugal + moved,
            euler_load=euler - self.coriolis @ displacement,
            inertia=float(self.inertia + displacement @ (2.0 * centrifugal + moved)),
        )

    def wave(self, k: int) -> Waves:
        """Return the matrices of nodal diameter k, with the stiffness at rest.

        Raises:
            ValueError: the sectors are not equal.
        """
        if not self.still.is_cyclic or self.layout is None:
            raise ValueError("waves of one nodal diameter need equal sectors")
        rest = replace(self, stiffness=self.elastic)
        blocks = rest.projected(self.layout.basis(k), Waves.FORMS)
        return Waves(nodal_diameter=k, **{name: block.toarray() for name, block in blocks.items()})

    def waves(self) -> Iterator[Waves]:
        """Yield the matrices of each nodal diameter, with the stiffness at rest; if sectors differ,
        those of their mean."""
        assert self.layout is not None
        given = replace(self, stiffness=self.elastic).given(Waves.FORMS)
        for k, blocks in self.layout.blocks(*given.values()):
            matrices: dict[str, Any] = dict(zip(given, blocks, strict=True))
            yield Waves(nodal_diameter=k, **matrices)

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
