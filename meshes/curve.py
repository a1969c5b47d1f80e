"""Points along straight and curved centre lines."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline

from bladewhirl.meshes.line_mesh import FloatArray

SAMPLES = 64
"""Samples between two given points by which the length of a curve is measured."""


def points_along(given: FloatArray, elements: int) -> FloatArray:
    """Ends of equally long elements along a centre line, (elements + 1, 2).

    Two points are joined by a straight line, more by a smooth curve: a cubic spline over the
    length of their chords. The first and the last point are kept to the last bit.

    Args:
        given: points that the line goes through, in order [m], (points, 2); no two in a row alike.
        elements: number of elements.
    """
    share = np.linspace(0.0, 1.0, elements + 1)[:, None]
    if len(given) == 2:
        return np.asarray((1.0 - share) * given[0] + share * given[1])
    chords = np.linalg.norm(np.diff(given, axis=0), axis=1)
    knots = np.concatenate([[0.0], np.cumsum(chords)])
    curve = CubicSpline(knots, given)
    fine = np.interp(np.arange(SAMPLES * len(chords) + 1) / SAMPLES, np.arange(len(knots)), knots)
    steps = np.linalg.norm(np.diff(curve(fine), axis=0), axis=1)
    length = np.concatenate([[0.0], np.cumsum(steps)])
    points = np.asarray(curve(np.interp(share[:, 0] * length[-1], length, fine)))
    points[0], points[-1] = given[0], given[-1]
    return points
