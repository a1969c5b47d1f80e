"""Stiffness of a rotating solid: centrifugal stress and spin softening."""

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spl

from bladewhirl.models.solids.assembly import Elasticity, Solid
from bladewhirl.models.superelements.frequencies import SYMMETRIC_ORDER

IN_PLANE = np.diag([1.0, 1.0, 0.0])


def rotating_stiffness(
    solid: Solid, mass: sp.csr_array, tie: sp.csr_array, material: Elasticity, speed: float
) -> sp.csr_array:
    """Return the stiffness of a solid that rotates about z, (3 nodes, 3 nodes) [N/m].

    Args:
        solid: finite elements; their axis of rotation is z.
        mass: mass of one component of the displacements [kg], (nodes, nodes).
        tie: matrix from coordinates to displacements, (3 nodes, coordinates): that of the free
            displacements, or for a sector that of nodal diameter 0.
        material: elastic constants.
        speed: speed of rotation [rad/s].
    """
    softening = speed**2 * sp.kron(mass, IN_PLANE, format="csr")
    load = tie.T @ (softening @ solid.points.ravel())
    factor = spl.splu(sp.csc_array(tie.T @ solid.stiffness(material) @ tie), **SYMMETRIC_ORDER)
    displacement = tie @ factor.solve(load)
    return sp.csr_array(solid.stiffness(material, displacement) - softening)
