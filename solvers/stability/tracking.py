"""Continuous branches of eigenvalues along a line of parameters (Fig. 12)."""

import numpy as np
from scipy.optimize import linear_sum_assignment

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray


def track(parameter: FloatArray, values: ComplexArray) -> ComplexArray:
    """Reorder spectra so that each column is one continuous branch.

    The branches are extrapolated linearly to the next parameter, and the eigenvalues there are
    assigned to the branches with the least sum of squared distances. Branches that cross therefore
    keep their direction. Beyond a point at which two branches coincide, the order of the two is
    arbitrary.

    Args:
        parameter: position along the line, strictly monotonic, (m,).
        values: spectra in any order, (m, n).

    Returns:
        the reordered rows of `values`, (m, n); the first row keeps its order.
    """
    branches = np.array(values)
    for i in range(1, len(branches)):
        expected = branches[i - 1]
        if i > 1:
            share = (parameter[i] - parameter[i - 1]) / (parameter[i - 1] - parameter[i - 2])
            expected = expected + share * (branches[i - 1] - branches[i - 2])
        distance = np.abs(expected[:, None] - branches[i][None, :]) ** 2
        branches[i] = branches[i][linear_sum_assignment(distance)[1]]
    return branches
