"""The contact law of friction joints as a projection of trial forces, and its derivatives.

The forces l on a node with the gap g, the slip s and the friction coefficient mu satisfy

    0 <= l_n, g >= 0, l_n g = 0,    |l_t| <= mu l_n,    l_t = -mu l_n s / |s| where s is not zero

exactly if they are the projection of the trial forces p = l_n - rho_n g and tau = l_t - rho_t s
(Alart and Curnier 1991): l_n = max(p, 0) and l_t = tau min(1, mu l_n / |tau|). With x_+ = max(x,
0), the factor of tau is m / (m + (|tau| - m)_+) with m = mu l_n. A smooth law has (x + (x^2 +
e^2)^(1/2)) / 2 in place of x_+; it makes Newton's method lead to a motion near that of the true
law.
"""

from typing import NamedTuple

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray, IntArray

OPEN, STUCK, SLIPPING = range(3)
"""States of a node at an instant."""
SHARPER, ROUND = 0.3, 0.01
"""Smoothing e of slipping, and of the length of forces, relative to that of opening."""


class Projection(NamedTuple):
    """Forces that the law leaves of trial forces."""

    force: FloatArray  #: normal and two tangential forces [N], (..., nodes, 3)
    slope: FloatArray  #: derivatives by the trial forces, (..., nodes, 3, 3)


def states(trial: FloatArray, friction: FloatArray) -> IntArray:
    """Return the states of nodes by their trial forces (..., nodes, 3), (..., nodes)."""
    pressed = trial[..., 0]
    slips = np.linalg.norm(trial[..., 1:], axis=-1) > friction * pressed
    return np.where(pressed > 0.0, np.where(slips, SLIPPING, STUCK), OPEN)


def projected(trial: FloatArray, friction: FloatArray, smooth: float) -> Projection:
    """Return the forces of the law.

    Args:
        trial: trial forces [N], (..., nodes, 3).
        friction: friction coefficients, (nodes,).
        smooth: smoothing e of opening [N]; 0: the true law.
    """
    pressed, tau = trial[..., 0], trial[..., 1:]
    normal, closed = _positive(pressed, smooth)
    limit = friction * normal
    length = np.sqrt((tau**2).sum(axis=-1) + (ROUND * smooth) ** 2)
    beyond, slips = _positive(length - limit, SHARPER * smooth)
    whole = limit + beyond
    whole = np.where(whole > 0.0, whole, 1.0)
    share = np.where(length > 0.0, limit / whole, 1.0)
    force = np.concatenate([normal[..., None], share[..., None] * tau], axis=-1)
    slope = np.zeros((*trial.shape, trial.shape[-1]))
    slope[..., 0, 0] = closed
    way = tau / np.where(length > 0.0, length, 1.0)[..., None]
    by_limit = (1.0 - share * (1.0 - slips)) / whole
    slope[..., 1:, 0] = (by_limit * friction * closed)[..., None] * tau
    across = (limit * slips / whole**2)[..., None, None] * tau[..., :, None] * way[..., None, :]
    slope[..., 1:, 1:] = share[..., None, None] * np.eye(2) - across
    return Projection(force, slope)


def _positive(x: FloatArray, smooth: float) -> tuple[FloatArray, FloatArray]:
    """Return x_+ and its derivative."""
    if smooth == 0.0:
        return np.maximum(x, 0.0), (x > 0.0).astype(np.float64)
    root = np.sqrt(x**2 + smooth**2)
    return 0.5 * (x + root), 0.5 * (1.0 + x / root)
