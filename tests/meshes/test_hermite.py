"""Cubic Hermite functions: every cubic is met exactly, with its derivatives."""

import numpy as np
from numpy.polynomial import Polynomial

from bladewhirl.meshes.hermite import cubic_weights, curvature_weights, slope_weights


def test_cubics_are_exact() -> None:
    x = np.linspace(0.0, 1.0, 9)
    for cubic in (Polynomial([2.0]), Polynomial([0.3, -1.0]), Polynomial([1.0, 2.0, -3.0, 4.0])):
        slope = cubic.deriv()
        ends = np.array([cubic(0.0), slope(0.0), cubic(1.0), slope(1.0)])
        weights = (cubic_weights, slope_weights, curvature_weights)
        for made, exact in zip(weights, (cubic, slope, cubic.deriv(2)), strict=True):
            np.testing.assert_allclose(ends @ made(x), exact(x), atol=1e-13)
