"""Static growth of a bladed disk under centrifugal load, and the remaining clearance."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.elements.bladed_disk import BladedDiskModel
from bladewhirl.models.rotation.matrices import RotationMatrices


def static_displacement(
    matrices: RotationMatrices, omega: float, *, follows: bool = True
) -> FloatArray:
    """Displacement of the steadily turning state, (size,).

    Args:
        matrices: of the bladed disk.
        omega: speed of rotation [rad/s].
        follows: whether the load follows the growth, (K - Omega^2 M_t) u = Omega^2 M_t X; it adds
            some 0.02 % at the reference frequency. Without, u is proportional to Omega^2.
    """
    if not follows:
        return omega**2 * matrices.growth
    softened = sp.csc_array(matrices.structure.stiffness - omega**2 * matrices.mass)
    return np.asarray(spla.spsolve(softened, omega**2 * matrices.load))


def tip_growth(disk: BladedDiskModel, matrices: RotationMatrices, omega: float) -> FloatArray:
    """Radial growth of each tip at a speed of rotation [rad/s], the load following it [m]."""
    return static_displacement(matrices, omega)[disk.tip_radial]


def speed_of_growth(
    disk: BladedDiskModel, matrices: RotationMatrices, gap: float | FloatArray
) -> float:
    """Speed of rotation at which the first tip has grown by the room it has [rad/s].

    Growth is taken proportional to Omega^2, which is right to some 0.1 %; inf if no tip grows.

    Args:
        disk: the bladed disk.
        matrices: its.
        gap: of each tip [m], one value or (blades,).
    """
    rate = matrices.growth[disk.tip_radial]
    squares = np.divide(gap, rate, out=np.full(len(rate), np.inf), where=rate > 0.0)
    return float(np.sqrt(squares.min()))
