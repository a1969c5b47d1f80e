"""The real discrete Fourier transform (DFT) over sectors, as `elements.cyclic` describes it."""

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray


def real_dft(sectors: int) -> FloatArray:
    """Return the orthonormal real DFT, (sectors, sectors): x = F u, u = F^T x (Eqs 11-13).

    If the centre moves by a distance `a`, its components in the axes of sector n are
    a (cos n alpha, -sin n alpha). Their transforms are a sqrt(N/2) in k = 1 and zero in every other
    k, so the centre is coupled to k = 1 only. Eq. (13) is printed with another constant, which does
    not change this.
    """
    angles = 2.0 * np.pi * np.arange(sectors) / sectors
    basis = np.empty((sectors, sectors))
    for column in range(sectors):
        k, sine = nodal_diameter_of(column), column % 2 == 0
        basis[:, column] = np.sin(k * angles) if sine and k else np.cos(k * angles)
    return np.asarray(basis / np.linalg.norm(basis, axis=0))


def nodal_diameter_of(column: int) -> int:
    """Return the nodal diameter of a column of the real DFT."""
    return (column + 1) // 2
