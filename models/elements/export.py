"""A bladed disk of beams as a superelement."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Literal

import numpy as np
import scipy.sparse as sp

from bladewhirl.meshes.line_mesh import BoolArray, FloatArray, IntArray
from bladewhirl.models.elements.bladed_disk import (
    COMPONENTS,
    FIRST,
    ROTATION,
    BeamMatrices,
    BladedDiskModel,
)
from bladewhirl.models.structure.rotating import Rotating
from bladewhirl.models.superelements.superelement import FIXED, Superelement, SuperelementError

BLADES = "blades"  #: name of the lines of the blades


def wheel_superelement(
    disk: BladedDiskModel, name: str, further: Sequence[IntArray] = ()
) -> Superelement:
    """Return the full finite element model of a bladed disk as a wheel, without the springs of the
    shaft.

    Coordinates are the free degrees of freedom of the beams; at contact nodes, x and y
    displacements replace the radial and tangential ones. Points are all nodes. The matrices are
    those at rest; with rotation effects, the superelement also has stiffness_speed, gyroscopic and
    the loads of the rotation.

    Args:
        disk: finite element model.
        name: name of the superelement.
        further: nodes, one of each blade, that are contact nodes besides the tips, (blades,) each.
    """
    nodes = np.column_stack([disk.model.tips, *further]).ravel()  # blade by blade
    structure, size = disk.structure.still, disk.structure.size
    structure = replace(structure, stiffness=structure.stiffness - structure.springs)
    turn = to_cartesian(disk, nodes)
    matrices = structure.projected(turn, (*Rotating.FORMS, *Rotating.LOADS))
    in_plane = structure.node_dofs[nodes, FIRST:ROTATION]
    motion = disk.cartesian(turn.toarray())
    motion[:, 2] = 0.0  # displacements along z, in place of rotations
    flat = disk.mesh.points
    return Superelement(
        **matrices,
        contact_position=np.pad(flat[nodes], ((0, 0), (0, 1))),
        contact_dofs=np.pad(in_plane, ((0, 0), (0, 1)), constant_values=FIXED),
        centre_dofs=disk.centre if len(disk.centre) else None,
        points=np.pad(flat, ((0, 0), (0, 1))),
        recovery=sp.csr_array(motion.reshape(3 * len(flat), size)),
        name=name,
        source="bladewhirl, bladed disk of beams",
    )


def to_cartesian(disk: BladedDiskModel, nodes: IntArray) -> sp.csr_array:
    """Return the matrix from the coordinates of `wheel_superelement`, in which the displacements of
    contact nodes are along x and y, to the free degrees of freedom, (size, size)."""
    turn: FloatArray = np.zeros((disk.structure.size, disk.structure.size))
    np.fill_diagonal(turn, 1.0)
    x, y = disk.mesh.points[nodes].T
    angle = np.mod(np.arctan2(y, x), 2.0 * np.pi)
    c, s = np.cos(angle), np.sin(angle)
    first, second = disk.structure.node_dofs[nodes, FIRST:ROTATION].T
    turn[first, first], turn[first, second] = c, s
    turn[second, first], turn[second, second] = -s, c
    return sp.csr_array(turn)


def part_superelement(
    disk: BladedDiskModel, kind: Literal["sector", "blade"], name: str
) -> Superelement:
    """Return the finite elements of one sector, or of one blade clamped at its root.

    Coordinates are x and y displacements and rotations of the nodes. The rotation of a node on a
    face of the sector is the third component in `left_dofs` and `right_dofs`: like a displacement
    along z, it is the same in the axes of all sectors.

    Args:
        disk: finite element model without rotation effects, with equal sectors of beams only.
        kind: "sector", of a disk with clamped centre, or "blade".
        name: name of the superelement.

    Raises:
        SuperelementError: the bladed disk has no equal sectors, or its centre moves.
    """
    mesh, model = disk.mesh, disk.model
    sectors = mesh.sectors
    if sectors is None or disk.structure.layout is None or len(sectors) < 3:
        raise SuperelementError(f"expected three or more equal sectors for a {kind}")
    if kind == "sector" and len(disk.centre):
        raise SuperelementError("expected shaft.clamped = true for a sector")
    others = (model.springs.node.size, model.masses.node.size, model.links.led.size)
    if others[:2] != (0, 0) or (kind == "sector" and others[2]):
        raise SuperelementError(f"expected a {kind} of beams, without masses, springs and links")
    of_sector = np.full(len(mesh.points), -1)
    of_sector[sectors] = np.arange(len(sectors))[:, None]
    ends = of_sector[mesh.lines]
    inside = ((ends == 0) | (ends == -1)).all(axis=1) & (ends == 0).any(axis=1)
    if kind == "blade":
        chosen = inside & (np.array(mesh.line_parts) == BLADES)
        clamped = np.intersect1d(mesh.node_sets["roots"], mesh.lines[chosen])
    else:
        chosen = inside | (np.sort(ends, axis=1) == [0, 1]).all(axis=1)
        clamped = np.array([model.centre])
    nodes = np.setdiff1d(mesh.lines[chosen], clamped)
    mass_matrix, stiffness = _lines_alone(disk, chosen, nodes)
    dofs = COMPONENTS * np.arange(len(nodes))[:, None] + np.arange(COMPONENTS)
    tip = int(np.flatnonzero(np.isin(nodes, model.tips[of_sector[model.tips] == 0]))[0])
    recovery = sp.lil_array((3 * len(nodes), dofs.size))
    for axis in range(ROTATION):
        recovery[3 * np.arange(len(nodes)) + axis, dofs[:, axis]] = 1.0
    faces: dict[str, Any] = {}
    if kind == "sector":
        right = np.flatnonzero(of_sector[nodes] == 1)
        twins = sectors[0][np.argsort(sectors[1])][
            np.searchsorted(np.sort(sectors[1]), nodes[right])
        ]
        blades = chosen & (np.array(mesh.line_parts) == BLADES)
        faces["blade_stiffness"] = _lines_alone(disk, blades, nodes)[1]
        faces["sectors"] = len(sectors)
        faces |= {"left_dofs": dofs[np.searchsorted(nodes, twins)], "right_dofs": dofs[right]}
    flat = np.pad(mesh.points[nodes], ((0, 0), (0, 1)))
    return Superelement(
        mass=mass_matrix,
        stiffness=stiffness,
        contact_position=flat[[tip]],
        contact_dofs=np.array([[*dofs[tip, :ROTATION], FIXED]]),
        points=flat,
        recovery=sp.csr_array(recovery),
        name=name,
        source=f"bladewhirl, {kind} of a bladed disk of beams",
        **faces,
    )


def _lines_alone(
    disk: BladedDiskModel, chosen: BoolArray, nodes: IntArray
) -> tuple[sp.csr_array, sp.csr_array]:
    """Return mass and stiffness of the chosen lines alone, for x, y and rotation of given nodes."""
    flat = replace(disk.mesh, node_axes=np.zeros_like(disk.mesh.node_axes))
    beams, weight = BeamMatrices(replace(disk.model, mesh=flat)), chosen.astype(float)[:, None]
    kept = beams.assembler.node_dofs[nodes].ravel()
    whole = beams.mass(weight), beams.stiffness(weight)
    inertial, elastic = (sp.csr_array(matrix[np.ix_(kept, kept)]) for matrix in whole)
    return inertial, elastic
