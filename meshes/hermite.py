"""Cubic Hermite functions of an element, by which beams bend and fields run between nodes.

They multiply value and slope at the first end, then at the second. The march has the same
functions in C, in `solvers.kernel`.
"""

from __future__ import annotations

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray


def cubic_weights(x: FloatArray, length: float = 1.0) -> FloatArray:
    """Weights at places 0 to 1 of an element of some length, (4, places)."""
    rest = 1.0 - x
    first = [rest**2 * (1.0 + 2.0 * x), length * x * rest**2]
    return np.stack([*first, x**2 * (3.0 - 2.0 * x), -length * x**2 * rest])


def slope_weights(x: FloatArray, length: float = 1.0) -> FloatArray:
    """Derivatives of `cubic_weights` along the element, (4, places)."""
    rest = 1.0 - x
    first = [-6.0 * x * rest / length, rest * (1.0 - 3.0 * x)]
    return np.stack([*first, 6.0 * x * rest / length, x * (3.0 * x - 2.0)])


def curvature_weights(x: FloatArray) -> FloatArray:
    """Second derivatives of `cubic_weights` on an element of unit length, (4, places)."""
    return np.stack([12.0 * x - 6.0, 6.0 * x - 4.0, 6.0 - 12.0 * x, 6.0 * x - 2.0])
