"""Finite element model of a flexible casing: a closed ring of curved beams, springs and struts.

The foot of a support is on the centre line of the ring. A support acts on the motion of the wall at
its foot: the radial and tangential displacements w and u, and the counter-clockwise rotation of
the section phi = u/R - w'. The foot may be anywhere in an element: w, u and phi are interpolated
with the Hermite functions, so that results do not jump when a foot passes a node. The frequencies
converge with fourth order if all feet are at nodes. With a foot inside an element, they converge
with second to third order if the support transmits only a force, and with first order if the
support transmits a moment, like a built-in strut (an error of one per cent with 40 elements).

A strut is one straight beam element with mass from the wall to the ground, without internal modes:
a strut that is pinned at both ends is a bar; a strut that is built in at both ends also bends.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

import numpy as np
import scipy.sparse as sp

from bladewhirl.meshes.hermite import cubic_weights, slope_weights
from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.meshes.plane import rotate
from bladewhirl.meshes.ring_mesh import RingMesh
from bladewhirl.models.elements.cyclic import SectorLayout
from bladewhirl.models.elements.structure import Structure
from bladewhirl.models.sections.rectangular import Section
from bladewhirl.models.sections.wall import Wall, WallProperties

OUTWARD, ALONG, ROTATION = range(3)
"""Motions of the foot on which a support acts: radial, tangential, rotation."""


@dataclass(frozen=True, kw_only=True)
class Support:
    """Spring or strut that supports the wall at an angle."""

    kind: Literal["spring", "strut"]
    angle: float  #: angle of the foot from +x [rad]
    reach: tuple[float, float]  #: vector from foot to ground, x and y [m]; zero for a spring
    stiffness: FloatArray  #: stiffness matrix for w, u, phi [N/m, N, N m], (3, 3)
    mass: FloatArray  #: mass matrix for w, u, phi [kg, kg m, kg m2], (3, 3)
    weight: float  #: total mass of the support [kg]
    dampers: FloatArray
    """Factor d of the damping matrix d^T d for w, u, phi, with a row for each damper, (dampers, 3);
    in [(N s/m)^1/2] for w and u, in [(N s m)^1/2] for phi."""


def spring(
    angle: float,
    *,
    radial: float,
    tangential: float,
    radial_damping: float = 0.0,
    tangential_damping: float = 0.0,
) -> Support:
    """Return a support of two springs to the ground, each with a parallel damper.

    Args:
        angle: angle of the foot from +x [rad].
        radial: radial stiffness [N/m].
        tangential: tangential stiffness [N/m].
        radial_damping: radial damping [N s/m].
        tangential_damping: tangential damping [N s/m].
    """
    damping = np.diag([radial_damping, tangential_damping, 0.0])
    return Support(
        kind="spring",
        angle=angle,
        reach=(0.0, 0.0),
        stiffness=np.diag([radial, tangential, 0.0]),
        mass=np.zeros((3, 3)),
        weight=0.0,
        dampers=np.sqrt(damping[damping.any(axis=1)]),
    )


def strut(
    angle: float,
    section: Section,
    *,
    length: float,
    inclination: float,
    ends: Literal["pinned", "built-in"],
    damping: float = 0.0,
) -> Support:
    """Return a support by a straight strut to the ground.

    Args:
        angle: angle of the foot from +x [rad].
        section: section and material of the strut.
        length: length of the strut [m].
        inclination: angle from the outward normal to the strut, counter-clockwise [rad].
        ends: "pinned" or "built-in", for both ends.
        damping: damping along the strut [N s/m].
    """
    axes = rotate(np.eye(3), inclination)  # along, across, turn
    total = section.line_mass * length
    stiffness = np.zeros((3, 3))
    stiffness[0, 0] = section.axial_stiffness / length
    mass = np.diag([total / 3.0, total / 3.0, 0.0])
    if ends == "built-in":
        across = np.array([[12.0 / length**2, 6.0 / length], [6.0 / length, 4.0]])
        stiffness[1:, 1:] = section.bending_stiffness / length * across
        mixed = 11.0 * length / 210.0
        mass[1:, 1:] = total * np.array([[13.0 / 35.0, mixed], [mixed, length**2 / 105.0]])
    direction = angle + inclination
    return Support(
        kind="strut",
        angle=angle,
        reach=(length * np.cos(direction), length * np.sin(direction)),
        stiffness=axes.T @ stiffness @ axes,
        mass=axes.T @ mass @ axes,
        weight=total,
        dampers=np.sqrt(damping) * axes[:1] if damping else np.zeros((0, 3)),
    )


def foot_rows(mesh: RingMesh, node_dofs: IntArray, angles: Iterable[float]) -> sp.csr_array:
    """Return the matrix from a field to w, u and phi at given angles, (3 * angles, size).

    Args:
        mesh: the ring.
        node_dofs: degrees of freedom u, u', w, w' of each node, (nodes, 4).
        angles: angles of the feet from +x [rad].
    """
    theta = np.array(list(angles), dtype=np.float64)
    count, length = mesh.elements, mesh.element_length
    place = np.mod(theta, 2.0 * np.pi) * count / (2.0 * np.pi)
    first = np.floor(place).astype(np.int64)
    value = cubic_weights(place - first, length).T
    slope = slope_weights(place - first, length).T
    rows = sp.lil_array((3 * len(theta), node_dofs.size))
    for i, element in enumerate(first):
        ends = node_dofs[[element % count, (element + 1) % count]]
        along, outward = ends[:, :2].ravel(), ends[:, 2:].ravel()
        rows[[3 * i + OUTWARD], outward] = value[i]
        rows[[3 * i + ALONG], along] = value[i]
        rows[[3 * i + ROTATION], along] = value[i] / mesh.radius
        rows[[3 * i + ROTATION], outward] = -slope[i]
    return sp.csr_array(rows)


def at_feet(matrices: Iterable[FloatArray]) -> sp.csr_array:
    """Return the block-diagonal matrix of the matrices of all supports, (rows, 3 * supports).

    Args:
        matrices: matrix of each support, with columns for w, u and phi at its foot.
    """
    blocks = [sp.csr_array(matrix) for matrix in matrices]
    return sp.csr_array(sp.block_diag(blocks)) if blocks else sp.csr_array((0, 0))


TANGENTIAL, TANGENTIAL_SLOPE, RADIAL, RADIAL_SLOPE = range(4)
"""Degrees of freedom of a node: u, du/ds, w, dw/ds, where s is the arc length."""


@dataclass(frozen=True, kw_only=True)
class CasingModel:
    """A casing in the static frame, with Hermite functions for u and w: 4 DoF per node."""

    mesh: RingMesh
    properties: WallProperties  #: mean properties of each element, (elements,)
    curvature: Literal["exact", "shallow"]  #: bending strain, see `forms`
    foundation: float  #: uniform elastic support [N/m per metre of circumference]
    supports: tuple[Support, ...]  #: springs and struts at angles
    structure: Structure
    dampers: sp.csr_array  #: factor d of the damping matrix d^T d of the supports, (dampers, size)

    @property
    def mass(self) -> float:
        """Mass of wall and struts [kg]."""
        wall = self.properties.line_mass.sum() * self.mesh.element_length
        return float(wall + sum(support.weight for support in self.supports))

    def nodal(self, shapes: FloatArray) -> FloatArray:
        """Return the nodal values (w, dw/ds, u, du/ds) of fields, (nodes, 4, fields).

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
        wall: section of the wall.
        curvature: exact strains, or the shallow-arch bending strain w'' (see `forms`).
        support: uniform elastic support, radial and tangential [N/m per metre of circumference].
        rotation: "free" or "fixed" rigid rotation of the ring.
        supports: springs and struts at angles.
    """
    count = mesh.elements
    nodes = np.arange(count)
    # Loaded with scikit-fem, which a rigid casing does not need.
    from bladewhirl.models.elements.assembly import curved_beams
    from bladewhirl.models.elements.forms import curved_stiffness, mass

    assembler = curved_beams(
        np.full(count, mesh.element_length), np.column_stack([nodes, np.roll(nodes, -1)]), count
    )
    properties = wall.properties(mesh, assembler.points, assembler.weights)
    ones = np.ones(count)
    elastic = assembler.matrix(
        curved_stiffness,
        EA=properties.axial_stiffness,
        EI=properties.bending_stiffness,
        curvature=ones / mesh.radius,
        bend=ones / mesh.radius if curvature == "exact" else 0.0 * ones,
    )
    node_dofs = assembler.node_dofs
    feet = foot_rows(mesh, node_dofs, [each.angle for each in supports])
    springs = assembler.matrix(mass, rho_A=support * ones)
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
