"""Matrices of a rotating bladed disk, assembled once for all speeds.

In the notation of `structure.rotating` K1 is K_G1 - M_t, and K2 is zero. M_t is the mass matrix
without the rotary inertia of point masses, on which the rotation exerts no force; beams have
translational inertia only. Omega^2 M_t X is the centrifugal load at the positions X, and Omega^2
K_G1 is the geometric stiffness due to the axial forces that this load causes in beams and rigid
links. Springs keep their direction, so a force in a spring adds no stiffness.
"""

from dataclasses import replace

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.meshes.plane import directions, rotate
from bladewhirl.models.elements.bladed_disk import (
    COMPONENTS,
    FIRST,
    ROTATION,
    SECOND,
    BeamMatrices,
    BladedDiskModel,
    nodal_to_line_axes,
    node_springs,
)
from bladewhirl.models.elements.structure import Structure
from bladewhirl.models.geometry.beam_model import BeamModel

POINTS, WEIGHTS = np.polynomial.legendre.leggauss(4)
"""Gauss points and weights on -1 to 1, which integrate the line load of a tapered beam exactly."""


def axial_force(
    model: BeamModel, displacement: FloatArray, places: FloatArray, *, omega: float
) -> FloatArray:
    """Return the axial force N(x) in every line, positive in tension [N], (lines, places).

    The mean force follows from the elongation, E A (u_2 - u_1) / L. The force decreases along the
    line by the load rho A Omega^2 (r_0 + x), where r_0 is the coordinate of the first end along
    the line. The forces at the nodes are then in exact balance for every mesh.

    Args:
        model: beam model.
        displacement: static displacements and rotation of every node, in the axes of the node
            [m, m, 1], (3 * nodes,).
        places: positions in every line, from 0 at the first end to 1 at the second, (places,).
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
    """Return the centrifugal load of each line between its first end and each position [N], (lines,
    places)."""
    mesh, lengths = model.mesh, model.mesh.lengths
    axes = directions(mesh.line_axes)
    start = np.einsum("li,li->l", mesh.points[mesh.lines[:, 0]], axes)
    within = np.outer(places, 0.5 * (1.0 + POINTS))  # (places, points)
    line_mass = model.properties.at(within.ravel()).line_mass.reshape(-1, *within.shape)
    reach = start[:, None, None] + lengths[:, None, None] * within
    return np.asarray(
        omega**2 * lengths[:, None] * places * ((line_mass * reach) @ (0.5 * WEIGHTS))
    )


def rotation_matrices(disk: BladedDiskModel) -> Structure:
    """Return the structure of a bladed disk that was assembled at rest, with the matrices and loads
    of its rotation."""
    from bladewhirl.models.elements.forms import coriolis, tension_stiffness

    model, structure, unknowns = disk.model, disk.structure, disk.expansion
    mesh = model.mesh
    beams = BeamMatrices(model)
    point_masses = np.zeros((len(mesh.points), COMPONENTS))  # on translations only
    np.add.at(point_masses[:, FIRST], model.masses.node, model.masses.mass)
    point_masses[:, SECOND] = point_masses[:, FIRST]
    weights = point_masses.ravel()
    inertial = sp.csr_array(beams.mass() + sp.diags_array(weights))
    turning = beams.of(coriolis, skew=True, rho_A=beams.sections.line_mass)
    # Position vectors of the nodes in nodal axes; their rotation is zero.
    places = np.pad(rotate(mesh.points, -mesh.node_axes), ((0, 0), (0, 1))).ravel()
    full_load = inertial @ places
    load = np.asarray(unknowns.T @ full_load)
    growth = np.asarray(spla.spsolve(structure.stiffness.tocsc(), load))
    field = unknowns @ growth
    force = axial_force(model, field, beams.assembler.points, omega=1.0)
    stiffened = beams.of(tension_stiffness, tension=force)
    if model.links.led.size:
        elastic = beams.stiffness() + node_springs(model, beams.assembler.node_dofs)
        carried = full_load - elastic @ field
        stiffened = sp.csr_array(stiffened + _arm_stiffness(model, carried))
    geometric, translated = (unknowns.T @ each @ unknowns for each in (stiffened, inertial))
    turning = sp.csr_array(turning + _point_coriolis(weights))
    turned = unknowns.T @ turning @ unknowns
    rotary = np.zeros((len(mesh.points), COMPONENTS))
    np.add.at(rotary[:, ROTATION], model.masses.node, model.masses.inertia)
    softening, skew = sp.csr_array((translated + translated.T) / 2.0), (turned - turned.T) / 2.0
    return replace(
        structure,
        stiffness_speed=sp.csr_array((geometric + geometric.T) / 2.0 - softening),
        gyroscopic=sp.csr_array(2.0 * skew),
        translated=softening,
        centrifugal_load=load,
        euler_load=-np.asarray(unknowns.T @ (turning @ places + rotary.ravel())),
        inertia=float(places @ full_load + rotary.sum()),
        speed=0.0,
    )


def _point_coriolis(weights: FloatArray) -> sp.csr_array:
    """Return the Coriolis matrix of the point masses, with a row for every DoF of every node."""
    first = np.arange(FIRST, len(weights), COMPONENTS)
    second, values = first + SECOND, weights[first]
    entries = (
        np.concatenate([-values, values]),
        (np.concatenate([first, second]), np.concatenate([second, first])),
    )
    return sp.csr_array(entries, shape=(len(weights), len(weights)))


def _arm_stiffness(model: BeamModel, carried: FloatArray) -> sp.csr_array:
    """Return the geometric stiffness of rigid links against rotation of their leaders.

    A rotation theta of the leader moves the end of an arm a towards the leader by theta^2 |a| / 2.
    A force F at the end of the arm therefore resists with the moment (F . a) theta.

    Args:
        model: beam model with the links.
        carried: force and moment of every node on its link, in the axes of the node, (3 * nodes,).
    """
    mesh, links = model.mesh, model.links
    force = carried.reshape(-1, COMPONENTS)[links.led, :ROTATION]
    arm = mesh.points[links.led] - mesh.points[links.leader]
    moment = np.sum(arm * rotate(force, mesh.node_axes[links.led]), axis=1)
    diagonal = np.zeros(len(carried))
    np.add.at(diagonal, COMPONENTS * links.leader + ROTATION, moment)
    return sp.csr_array(sp.diags_array(diagonal))
