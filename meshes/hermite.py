"""Cubic Hermite functions, which interpolate displacements and fields in an element.

The four functions belong to value and slope at the first end, and to value and slope at the second
end. `solvers.kernel` has the same functions in C.
"""

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray


def cubic_weights(x: FloatArray, length: float = 1.0) -> FloatArray:
    """Return the functions at positions x from 0 to 1 in an element, (4, positions)."""
    rest = 1.0 - x
    first = [rest**2 * (1.0 + 2.0 * x), length * x * rest**2]
    return np.stack([*first, x**2 * (3.0 - 2.0 * x), -length * x**2 * rest])


def slope_weights(x: FloatArray, length: float = 1.0) -> FloatArray:
    """Return the derivatives of `cubic_weights` along an element of this length, (4, positions)."""
    rest = 1.0 - x
    first = [-6.0 * x * rest / length, rest * (1.0 - 3.0 * x)]
    return np.stack([*first, 6.0 * x * rest / length, x * (3.0 * x - 2.0)])


def curvature_weights(x: FloatArray) -> FloatArray:
    """Return the second derivatives of `cubic_weights` for unit length, (4, positions)."""
    return np.stack([12.0 * x - 6.0, 6.0 * x - 4.0, 6.0 - 12.0 * x, 6.0 * x - 2.0])
