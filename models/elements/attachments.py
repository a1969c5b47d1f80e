"""Matrices of all that hangs on the nodes of a beam model: point masses, springs, rigid links."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from bladewhirl.meshes.line_mesh import FloatArray, IntArray, LineMesh
from bladewhirl.models.geometry.beam_model import GROUND, BeamModel

COMPONENTS = 3
"""Displacement along a node's first and second axis, and its rotation."""


def point_masses(model: BeamModel, node_dofs: IntArray) -> sp.csr_array:
    """Mass matrix of the point masses over all DoF of all nodes."""
    masses = model.masses
    diagonal = np.zeros(node_dofs.size)
    each = np.column_stack([masses.mass, masses.mass, masses.inertia])
    np.add.at(diagonal, node_dofs[masses.node], each)
    return sp.csr_array(sp.diags_array(diagonal))


def node_springs(model: BeamModel, node_dofs: IntArray) -> sp.csr_array:
    """Stiffness matrix of the springs over all DoF of all nodes."""
    springs, axes = model.springs, model.mesh.node_axes
    stretch = sp.lil_array((springs.stiffness.size, node_dofs.size))
    for i, (node, other) in enumerate(zip(springs.node, springs.other, strict=True)):
        rows = COMPONENTS * i + np.arange(COMPONENTS)
        stretch[np.ix_(rows, node_dofs[node])] = np.eye(COMPONENTS)
        if other != GROUND:
            stretch[np.ix_(rows, node_dofs[other])] = -_turned(axes[node] - axes[other])
    each = sp.csr_array(stretch)
    return sp.csr_array(each.T @ sp.diags_array(springs.stiffness.ravel()) @ each)


def node_expansion(model: BeamModel, node_dofs: IntArray) -> sp.csr_array:
    """Components of every node from the free DoF, (3 nodes, free DoF).

    A led node moves as its leader's arm does: displacement u + theta x (p - p_leader).

    Args:
        model: with its rigid links.
        node_dofs: free DoF of each node, -1 if fixed or tied, (nodes, 3).
    """
    mesh, links = model.mesh, model.links
    size = int(node_dofs.max()) + 1
    free = np.flatnonzero(node_dofs.ravel() >= 0)
    shape = (node_dofs.size, size)
    direct = sp.csr_array((np.ones(len(free)), (free, node_dofs.ravel()[free])), shape=shape)
    if not links.led.size:
        return direct
    arms = sp.lil_array((node_dofs.size, node_dofs.size))
    for led, leader in zip(links.led, links.leader, strict=True):
        rows = COMPONENTS * led + np.arange(COMPONENTS)
        arms[np.ix_(rows, COMPONENTS * leader + np.arange(COMPONENTS))] = _arm(mesh, led, leader)
    return sp.csr_array(direct + sp.csr_array(arms) @ direct)


def _arm(mesh: LineMesh, led: int, leader: int) -> FloatArray:
    """Components of a led node from those of its leader, (3, 3)."""
    moved = _turned(mesh.node_axes[led] - mesh.node_axes[leader])
    x, y = mesh.points[led] - mesh.points[leader]
    cos, sin = np.cos(mesh.node_axes[led]), np.sin(mesh.node_axes[led])
    # A unit rotation moves the end of the arm by (-y, x); in the axes of the led node:
    moved[:2, 2] = [-y * cos + x * sin, y * sin + x * cos]
    return moved


def _turned(angle: float) -> FloatArray:
    """Components in axes turned by an angle from those in the axes themselves, (3, 3)."""
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
