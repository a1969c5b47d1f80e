"""Matrices of a bladed disk that turns, assembled once for all speeds.

In its rotating frame, about the state in which it turns steadily,

    M x'' + (D + 2 Omega G) x' + (K + Omega^2 (K_G1 - M_t)) x = f,

with the geometric stiffness Omega^2 K_G1 of the axial forces that the centrifugal load
Omega^2 M_t X leaves in beams and rigid links, the Coriolis matrix G, and M_t, the mass matrix
without the rotary inertia of point masses, which no rotation about the axis pulls at. Beams have
translational inertia only, so elsewhere M_t is M. Springs keep their direction, so a force in them
adds no stiffness.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.shaft import Effects
from bladewhirl.models.elements.assembly import straight_beams
from bladewhirl.models.elements.bladed_disk import (
    COMPONENTS,
    FIRST,
    ROTATION,
    SECOND,
    BladedDiskModel,
    elastic_stiffness,
    nodal_to_line_axes,
)
from bladewhirl.models.elements.forms import (
    coriolis,
    mass,
    tension_stiffness,
)
from bladewhirl.models.elements.structure import Structure
from bladewhirl.models.geometry.beam_model import BeamModel

POINTS, WEIGHTS = np.polynomial.legendre.leggauss(4)
"""On -1 to 1: they integrate what a tapered beam has of line load, and its mean, exactly."""


def axial_force(
    model: BeamModel, displacement: FloatArray, places: FloatArray, *, omega: float
) -> FloatArray:
    """Axial force N(x), tension positive [N], (lines, places).

    Its mean is that of the elongation, E A (u_2 - u_1) / L; from there it falls outward by the load
    rho A Omega^2 (r_0 + x), with r_0 the place of the first end along the line. So forces at the
    nodes balance exactly, whatever the mesh.

    Args:
        model: beams, masses and what hangs on them.
        displacement: static, of every node in its own axes [m, m, 1], (3 nodes,).
        places: in every line, 0 at its first end to 1, (places,).
        omega: speed of rotation [rad/s].
    """
    mesh, lengths = model.mesh, model.mesh.lengths
    inner, shares = 0.5 * (1.0 + POINTS), 0.5 * WEIGHTS
    nodal = displacement.reshape(-1, COMPONENTS)[mesh.lines].reshape(len(lengths), -1)
    along = np.einsum("lij,lj->li", nodal_to_line_axes(mesh)[:, [0, COMPONENTS]], nodal)
    stiffness = model.properties.at(inner).axial_stiffness @ shares
    mean = stiffness * (along[:, 1] - along[:, 0]) / lengths
    lost = _load_from_first_end(model, places, omega)
    return np.asarray(
        mean[:, None] + (_load_from_first_end(model, inner, omega) @ shares)[:, None] - lost
    )


def _load_from_first_end(model: BeamModel, places: FloatArray, omega: float) -> FloatArray:
    """Centrifugal load along each line from its first end to places in it [N], (lines, places)."""
    mesh, lengths = model.mesh, model.mesh.lengths
    axes = np.column_stack([np.cos(mesh.line_axes), np.sin(mesh.line_axes)])
    start = np.einsum("li,li->l", mesh.points[mesh.lines[:, 0]], axes)
    within = np.outer(places, 0.5 * (1.0 + POINTS))  # (places, points)
    line_mass = model.properties.at(within.ravel()).line_mass.reshape(-1, *within.shape)
    reach = start[:, None, None] + lengths[:, None, None] * within
    return np.asarray(
        omega**2 * lengths[:, None] * places * ((line_mass * reach) @ (0.5 * WEIGHTS))
    )


@dataclass(frozen=True, kw_only=True)
class RotationMatrices:
    """Matrices and fields of a turning bladed disk over its free DoF, for Omega = 1 rad/s."""

    structure: Structure  #: at rest
    mass: sp.csr_array  #: M_t, of translations [kg, kg m, kg m2], (size, size)
    geometric: sp.csr_array  #: K_G1 [N s2/m, N s2, N m s2], (size, size)
    coriolis: sp.csr_array  #: G, skew [kg, kg m, kg m2], (size, size)
    load: FloatArray  #: M_t X [kg m, kg m2], (size,)
    growth: FloatArray  #: K^-1 M_t X, displacement over Omega^2 [m s2, s2], (size,)

    def stiffness(self, omega: float) -> sp.csr_array:
        """K_Omega = K + Omega^2 (K_G1 - M_t) at a speed [rad/s]."""
        return sp.csr_array(self.structure.stiffness + omega**2 * (self.geometric - self.mass))

    def at_speed(self, omega: float, effects: Effects) -> Structure:
        """The structure about the state in which it turns steadily.

        Args:
            omega: speed of rotation [rad/s], counter-clockwise.
            effects: that count; with none it is the structure at rest.
        """
        if effects == "none":
            return self.structure
        gyroscopic = sp.csr_array(2.0 * omega * self.coriolis) if effects == "full" else None
        return replace(
            self.structure,
            stiffness=self.stiffness(omega),
            at_rest=self.structure,
            gyroscopic=gyroscopic,
        )


def rotation_matrices(disk: BladedDiskModel) -> RotationMatrices:
    """Assemble the rotation matrices of a bladed disk that was assembled at rest."""
    model, structure, unknowns = disk.model, disk.structure, disk.expansion
    mesh = model.mesh
    assembler = straight_beams(mesh.lengths, mesh.lines, len(mesh.points))
    transform = nodal_to_line_axes(mesh)
    line_mass = model.properties.at(assembler.points).line_mass
    point_masses = np.zeros((len(mesh.points), COMPONENTS))  # on translations only
    np.add.at(point_masses[:, FIRST], model.masses.node, model.masses.mass)
    point_masses[:, SECOND] = point_masses[:, FIRST]
    weights = point_masses.ravel()
    inertial = sp.csr_array(
        assembler.matrix(mass, transform, rho_A=line_mass) + sp.diags_array(weights)
    )
    turning = assembler.matrix(coriolis, transform, skew=True, rho_A=line_mass)
    x, y = mesh.points.T
    cos, sin = np.cos(mesh.node_axes), np.sin(mesh.node_axes)
    # Positions about the axis in nodal axes, rotation zero.
    places = np.column_stack([cos * x + sin * y, cos * y - sin * x, np.zeros(len(x))]).ravel()
    full_load = inertial @ places
    load = np.asarray(unknowns.T @ full_load)
    growth = np.asarray(spla.spsolve(structure.stiffness.tocsc(), load))
    field = unknowns @ growth
    force = axial_force(model, field, assembler.points, omega=1.0)
    stiffened = assembler.matrix(tension_stiffness, transform, tension=force)
    if model.links.led.size:
        carried = full_load - elastic_stiffness(model, assembler, transform) @ field
        stiffened = sp.csr_array(stiffened + _arm_stiffness(model, carried))
    geometric, translated = (unknowns.T @ each @ unknowns for each in (stiffened, inertial))
    turned = unknowns.T @ (turning + _point_coriolis(weights)) @ unknowns
    return RotationMatrices(
        structure=structure,
        mass=sp.csr_array((translated + translated.T) / 2.0),
        geometric=sp.csr_array((geometric + geometric.T) / 2.0),
        coriolis=sp.csr_array((turned - turned.T) / 2.0),
        load=load,
        growth=growth,
    )


def _point_coriolis(weights: FloatArray) -> sp.csr_array:
    """Coriolis matrix of point masses over all DoF of all nodes."""
    first = np.arange(FIRST, len(weights), COMPONENTS)
    second, values = first + SECOND, weights[first]
    entries = (
        np.concatenate([-values, values]),
        (np.concatenate([first, second]), np.concatenate([second, first])),
    )
    return sp.csr_array(entries, shape=(len(weights), len(weights)))


def _arm_stiffness(model: BeamModel, carried: FloatArray) -> sp.csr_array:
    """Geometric stiffness of rigid links on the rotations of their leaders.

    A turn by theta shortens an arm a by theta^2 a / 2 along itself, so a force F that it carries
    outward from its leader resists with the moment (F . a) theta.

    Args:
        model: with its links.
        carried: force and moment of every node on its link, in the node's axes, (3 nodes,).
    """
    mesh, links = model.mesh, model.links
    cos, sin = np.cos(mesh.node_axes[links.led]), np.sin(mesh.node_axes[links.led])
    first, second = carried.reshape(-1, COMPONENTS)[links.led, :ROTATION].T
    arm = mesh.points[links.led] - mesh.points[links.leader]
    moment = arm[:, 0] * (cos * first - sin * second) + arm[:, 1] * (sin * first + cos * second)
    diagonal = np.zeros(len(carried))
    np.add.at(diagonal, COMPONENTS * links.leader + ROTATION, moment)
    return sp.csr_array(sp.diags_array(diagonal))
