"""A bladed disk of beams as a superelement."""

import numpy as np
import scipy.sparse as sp

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.elements.bladed_disk import BladedDiskModel
from bladewhirl.models.superelements.superelement import FIXED, Superelement


def wheel_superelement(
    disk: BladedDiskModel, shaft_stiffness: tuple[float, float], name: str
) -> Superelement:
    """Return the full finite element model of a bladed disk as a wheel, without the springs of the
    shaft.

    Coordinates are the free degrees of freedom of the beams, but x and y displacements of the tips
    in place of radial and tangential ones. Points are all nodes. Rotation effects of the stage are
    included in the stiffness, Coriolis forces are not.

    Args:
        disk: finite element model.
        shaft_stiffness: stiffness of the springs along x and y [N/m], which is subtracted.
        name: name of the superelement.
    """
    structure, size = disk.structure, disk.structure.size
    turn = _to_cartesian_tips(disk)
    mass, stiffness = (
        sp.csr_array(turn.T @ matrix @ turn) for matrix in (structure.mass, structure.stiffness)
    )
    springs = np.zeros(size)
    springs[disk.centre] = shaft_stiffness[: len(disk.centre)]
    stiffness = sp.csr_array(stiffness - sp.diags_array(springs))
    tips = len(disk.tip_radial)
    axial = np.full(tips, FIXED)
    motion = disk.cartesian(turn.toarray())
    motion[:, 2] = 0.0  # displacements along z, in place of rotations
    flat = disk.mesh.points
    return Superelement(
        mass=mass,
        stiffness=stiffness,
        contact_position=np.pad(flat[disk.model.tips], ((0, 0), (0, 1))),
        contact_dofs=np.column_stack([disk.tip_radial, disk.tip_tangential, axial]),
        centre_dofs=disk.centre if len(disk.centre) else None,
        points=np.pad(flat, ((0, 0), (0, 1))),
        recovery=sp.csr_array(motion.reshape(3 * len(flat), size)),
        name=name,
        source="bladewhirl, bladed disk of beams",
    )


def _to_cartesian_tips(disk: BladedDiskModel) -> sp.csr_array:
    """Return the matrix from coordinates with x and y displacements of the tips, in place of their
    radial and tangential displacements, to the free degrees of freedom, (size, size)."""
    turn: FloatArray = np.zeros((disk.structure.size, disk.structure.size))
    np.fill_diagonal(turn, 1.0)
    c, s = np.cos(disk.tip_angles), np.sin(disk.tip_angles)
    first, second = disk.tip_radial, disk.tip_tangential
    turn[first, first], turn[first, second] = c, s
    turn[second, first], turn[second, second] = -s, c
    return sp.csr_array(turn)
