"""Textbook frame analysis, dense and in fixed axes: a second opinion on beams and assembly.

The matrices are typed in from Przemieniecki, Theory of Matrix Structural Analysis (1968).
"""

import numpy as np
import scipy.linalg as la

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.elements.bladed_disk import BladedDiskModel


def beam_stiffness(EA: float, EI: float, length: float) -> FloatArray:
    """Bernoulli beam with rod, (u, w, w') at both ends, (6, 6)."""
    a, b, c, d = EA / length, 12 * EI / length**3, 6 * EI / length**2, EI / length
    return np.array(
        [
            [a, 0, 0, -a, 0, 0],
            [0, b, c, 0, -b, c],
            [0, c, 4 * d, 0, -c, 2 * d],
            [-a, 0, 0, a, 0, 0],
            [0, -b, -c, 0, b, -c],
            [0, c, 2 * d, 0, -c, 4 * d],
        ]
    )


def beam_mass(rho_A: float, length: float) -> FloatArray:
    """Consistent mass of the same beam, (6, 6)."""
    s = length
    return (rho_A * s / 420.0) * np.array(
        [
            [140, 0, 0, 70, 0, 0],
            [0, 156, 22 * s, 0, 54, -13 * s],
            [0, 22 * s, 4 * s**2, 0, 13 * s, -3 * s**2],
            [70, 0, 0, 140, 0, 0],
            [0, 54, 13 * s, 0, 156, -22 * s],
            [0, -13 * s, -3 * s**2, 0, -22 * s, 4 * s**2],
        ]
    )


def frame_matrices(disk: BladedDiskModel, spring: float) -> tuple[FloatArray, FloatArray]:
    """Mass and stiffness of a bladed disk in fixed axes, (x, y, rotation) of node after node.

    The centre's rotation is held and left out, the centre's springs are in.
    """
    mesh, properties = disk.mesh, disk.properties
    size = 3 * len(mesh.points)
    mass, stiffness = np.zeros((size, size)), np.zeros((size, size))
    for i, (first, second) in enumerate(mesh.lines):
        x, y = mesh.points[second] - mesh.points[first]
        length = float(np.hypot(x, y))
        cos, sin = x / length, y / length
        turn = np.kron(np.eye(2), np.array([[cos, sin, 0], [-sin, cos, 0], [0, 0, 1]]))
        where = np.r_[3 * first : 3 * first + 3, 3 * second : 3 * second + 3]
        mass[np.ix_(where, where)] += turn.T @ beam_mass(properties.line_mass[i], length) @ turn
        stiffness[np.ix_(where, where)] += (
            turn.T
            @ beam_stiffness(properties.axial_stiffness[i], properties.bending_stiffness[i], length)
            @ turn
        )
    centre = 3 * int(mesh.node_sets["centre"][0])
    stiffness[[centre, centre + 1], [centre, centre + 1]] += spring
    free = np.setdiff1d(np.arange(size), centre + 2)
    return mass[np.ix_(free, free)], stiffness[np.ix_(free, free)]


def frame_frequencies(disk: BladedDiskModel, spring: float) -> FloatArray:
    """All natural frequencies [rad/s], ascending."""
    mass, stiffness = frame_matrices(disk, spring)
    return np.asarray(np.sqrt(la.eigh(stiffness, mass, eigvals_only=True)))
