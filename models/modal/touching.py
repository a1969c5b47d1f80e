"""Waves whose contact nodes are held by the wall.

While a node touches, its displacement normal to a rigid wall is zero. The modes of a rub lie
between those with free and those with held nodes. With the displacements P of the contact nodes in
some modes and their flexibility C by the modes that are left out, P q + C f = 0 adds the stiffness
P^H C^-1 P to that of the modes.
"""

from dataclasses import dataclass, replace

import numpy as np

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.models.structure.waves import Waves

STIFFEST = 1e-7
"""Least flexibility of held nodes, as a fraction of their static flexibility, if no modes are left
out; frequencies change by a smaller fraction."""


@dataclass(frozen=True, kw_only=True)
class Tips:
    """Contact nodes of one nodal diameter."""

    contact: ComplexArray
    """Displacements of the nodes normal to the wall, tangential, and along the wall [kg^-1/2],
    (3 * nodes, n)."""
    radius: FloatArray  #: radius of the nodes [m], (nodes,)
    flexibility: ComplexArray | None
    """Static flexibility of the nodes at rest by all modes [m/N], (nodes, nodes); None if the n
    coordinates are all there are."""

    @property
    def rows(self) -> ComplexArray:
        """Displacement of the nodes normal to the wall [kg^-1/2], (nodes, n)."""
        return self.contact[::3]


def held(wave: Waves, tips: Tips) -> Waves:
    """Return the waves of a nodal diameter with its contact nodes held."""
    by_modes = tips.rows @ np.linalg.solve(wave.stiffness, tips.rows.conj().T)
    whole = by_modes if tips.flexibility is None else tips.flexibility
    left_out = 0.5 * (whole - by_modes + (whole - by_modes).conj().T)
    least = STIFFEST * float(np.abs(np.diag(whole)).max())
    values, vectors = np.linalg.eigh(left_out)
    soft = tips.rows.conj().T @ vectors
    stiff = (soft / np.maximum(values, least)) @ soft.conj().T
    return replace(wave, stiffness=wave.stiffness + stiff)
