"""Finite element model of a flexible casing: a closed ring of curved beams."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import scipy.sparse as sp

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.meshes.ring_mesh import RingMesh
from bladewhirl.models.elements.assembly import curved_beams
from bladewhirl.models.elements.cyclic import SectorLayout
from bladewhirl.models.elements.forms import (
    curved_exact_stiffness,
    curved_shallow_stiffness,
    mass,
    support_stiffness,
)
from bladewhirl.models.elements.structure import Structure
from bladewhirl.models.elements.supports import Support, at_feet, foot_rows
from bladewhirl.models.sections.wall import Wall, WallProperties

TANGENTIAL, TANGENTIAL_SLOPE, RADIAL, RADIAL_SLOPE = range(4)
"""Components of a node: u, du/ds, w, dw/ds with s the arc length."""


@dataclass(frozen=True, kw_only=True)
class CasingModel:
    """A casing in the static frame: Hermite in both fields, 4 DoF a node."""

    mesh: RingMesh
    properties: WallProperties  #: mean properties of each element, (elements,)
    curvature: Literal["exact", "shallow"]  #: bending strain, see `elements`
    foundation: float  #: uniform elastic support [N/m per metre of circumference]
    supports: tuple[Support, ...]  #: springs and struts at angles
    structure: Structure
    dampers: sp.csr_array  #: of the supports: rows d of the damping d^T d, (dampers, size)

    @property
    def mass(self) -> float:
        """Mass of wall and struts [kg]."""
        wall = self.properties.line_mass.sum() * self.mesh.element_length
        return float(wall + sum(support.weight for support in self.supports))

    def nodal(self, shapes: FloatArray) -> FloatArray:
        """Nodal values (w, dw/ds, u, du/ds) of fields, (nodes, 4, fields).

        Args:
            shapes: fields on the free DoF, (size, fields).
        """
        order = [RADIAL, RADIAL_SLOPE, TANGENTIAL, TANGENTIAL_SLOPE]
        return np.asarray(shapes[self.structure.node_dofs[:, order]])


def assemble_casing(
    mesh: RingMesh,
    wall: Wall,
    *,
    curvature: Literal["exact", "shallow"],
    support: float,
    rotation: Literal["free", "fixed"],
    supports: tuple[Support, ...] = (),
) -> CasingModel:
    """Assemble a casing.

    Args:
        mesh: the ring.
        wall: its section.
        curvature: exact strains, or the shallow-arch bending strain w'' (see `elements`).
        support: uniform elastic support, radial and tangential [N/m per metre of circumference].
        rotation: whether the ring may turn as a whole.
        supports: springs and struts at angles.
    """
    count = mesh.elements
    nodes = np.arange(count)
    assembler = curved_beams(
        np.full(count, mesh.element_length), np.column_stack([nodes, np.roll(nodes, -1)]), count
    )
    properties = wall.properties(mesh, assembler.points, assembler.weights)
    ones = np.ones(count)
    elastic = assembler.matrix(
        curved_exact_stiffness if curvature == "exact" else curved_shallow_stiffness,
        EA=properties.axial_stiffness,
        EI=properties.bending_stiffness,
        curvature=ones / mesh.radius,
    )
    node_dofs = assembler.node_dofs
    feet = foot_rows(mesh, node_dofs, [each.angle for each in supports])
    springs = assembler.matrix(support_stiffness, support=support * ones)
    springs = springs + feet.T @ at_feet(each.stiffness for each in supports) @ feet
    total_mass = assembler.matrix(mass, rho_A=properties.line_mass)
    total_mass = total_mass + feet.T @ at_feet(each.mass for each in supports) @ feet
    constraints = np.zeros((node_dofs.size, 1 if rotation == "fixed" else 0))
    if rotation == "fixed":
        constraints[node_dofs[:, TANGENTIAL], 0] = 1.0
    structure = Structure(
        mass=total_mass,
        stiffness=sp.csr_array(elastic + springs),
        springs=springs,
        node_dofs=node_dofs,
        layout=SectorLayout(sector_dofs=node_dofs, centre_dofs=np.full(3, -1)),
        constraints=constraints,
    )
    return CasingModel(
        mesh=mesh,
        properties=properties.mean(assembler.weights),
        curvature=curvature,
        foundation=support,
        supports=supports,
        structure=structure,
        dampers=sp.csr_array(at_feet(each.dampers for each in supports) @ feet),
    )
