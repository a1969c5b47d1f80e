"""Axial force along the beams of a bladed disk that turns."""

from __future__ import annotations

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.elements.attachments import COMPONENTS
from bladewhirl.models.elements.bladed_disk import nodal_to_line_axes
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
