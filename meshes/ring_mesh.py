"""Mesh of a casing: nodes on a circle, connected by curved elements."""

from dataclasses import dataclass

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray

W, W_SLOPE, U, U_SLOPE = range(4)
"""Positions of w, dw/ds, u and du/ds in every array of nodal values of a casing."""


@dataclass(frozen=True, kw_only=True)
class RingMesh:
    """A closed ring of equal curved elements; element i joins nodes i and i + 1 (mod elements)."""

    elements: int  #: number of elements and of nodes
    radius: float  #: radius of the ring [m]

    @property
    def angles(self) -> FloatArray:
        """Angle of each node [rad], (elements,)."""
        return 2.0 * np.pi * np.arange(self.elements) / self.elements

    @property
    def element_length(self) -> float:
        """Arc length of one element [m]."""
        return 2.0 * np.pi * self.radius / self.elements
