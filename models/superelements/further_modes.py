"""Modes that describe how those at one speed, and the state of steady rotation, change with it.

The lowest modes at another speed, and the static displacements by the loads of the rotation at this
and other speeds, become further modes of a structure whose speed varies. Its state of steady
rotation then follows from its modes, with the stress, the strain and the place of every point.
"""

from typing import Any

import numpy as np
import scipy.linalg as la

from bladewhirl.meshes.line_mesh import FloatArray

FLEXIBLE = 1e-6
"""A direction of the residual flexibility counts as rigid if its eigenvalue is at most this
fraction of the largest."""

NEW = 1e-5
"""A mode with another stiffness adds a motion if at least this share of its amplitude is new."""


def further(stiffness: Any, mass: Any, shapes: Any, others: Any, limit: float) -> tuple[Any, Any]:
    """Return what the modes of a structure with another stiffness have besides given modes, as
    further modes: squared frequencies, (m,), and mass-normalised shapes, (n, m).

    They let the given modes change their shapes as the stiffness changes, almost as static
    displacements, because they are stiff. Those above a frequency get so much more mass that they
    have this frequency, so that they do not shorten the time step.

    Args:
        stiffness: stiffness matrix, (n, n).
        mass: mass matrix, (n, n).
        shapes: given modes, mass-normalised, (n, modes).
        others: lowest modes with another stiffness, and static displacements, (n, others).
        limit: highest frequency of the further modes [rad/s].
    """
    others = scaled(mass, others)
    for _ in range(2):  # the second time for rounding errors
        others = others - shapes @ (shapes.conj().T @ (mass @ others))
    others = independent(mass, others)
    squares, turn = la.eigh(others.conj().T @ (stiffness @ others))
    heavier = np.maximum(1.0, squares / limit**2)
    return squares / heavier, others @ turn / np.sqrt(heavier)


def independent(mass: Any, fields: Any) -> Any:
    """Return mass-normalised fields that span given fields but for `NEW`, (n, m)."""
    squares, turn = la.eigh(fields.conj().T @ (mass @ fields))
    found = squares > NEW**2
    return fields @ (turn[:, found] / np.sqrt(squares[found]))


def scaled(mass: Any, fields: Any) -> Any:
    """Return fields with a generalised mass of one, without those that are zero, (n, m)."""
    own = np.sqrt(np.einsum("nm,nm->m", fields.conj(), mass @ fields).real)
    return fields[:, own > 0.0] / own[own > 0.0]


def stiffest(squares: FloatArray, contact: Any, compliance: Any) -> float:
    """Return the highest frequency of modes whose contact nodes are fixed in each direction with a
    residual flexibility [rad/s].

    Args:
        squares: squared frequencies of the modes [rad2/s2], (modes,).
        contact: displacements of the contact nodes [kg^-1/2], (3c, modes).
        compliance: residual flexibility [m/N], (3c, 3c).
    """
    flexibility, ways = np.linalg.eigh(compliance)
    flexible = flexibility > FLEXIBLE * flexibility[-1]
    rows = (ways[:, flexible] / np.sqrt(flexibility[flexible])).conj().T @ contact
    return float(np.sqrt(np.linalg.eigvalsh(np.diag(squares) + rows.conj().T @ rows)[-1]))
