"""Speeds at which a wave on a turning bladed disk stands still, or keeps pace with an engine order.

With K_Omega = K + Omega^2 (K_G1 - M_t) a wave exp(i (k theta + m Omega t)) is free where

    K p = Omega^2 (m^2 M + M_t - 2 i m G - K_G1) p,

one Hermitian eigenproblem for each nodal diameter k, without iteration. m = 0 is a critical speed
under a load that turns with the disk, as an imbalance does; m = k a backward wave that stands
still on the casing, m = -k a forward one that would pass it twice as fast as the disk.
"""

from __future__ import annotations

import scipy.sparse as sp

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.rotation import Effects
from bladewhirl.models.rotation.eigenproblems import positive_speeds
from bladewhirl.models.rotation.matrices import RotationMatrices


def synchronous_speeds(
    matrices: RotationMatrices, nodal_diameter: int, order: int, effects: Effects = "full"
) -> FloatArray:
    """Speeds at which a wave has `order` times the speed of rotation as its frequency.

    Args:
        matrices: of a bladed disk of equal sectors.
        nodal_diameter: k of the wave.
        order: m, positive backward, negative forward, 0 a wave that stands in the rotating frame.
        effects: that count.

    Returns:
        Omega ascending [rad/s], (waves,).

    Raises:
        ValueError: the bladed disk has no cyclic symmetry.
    """
    structure = matrices.structure
    if not structure.is_cyclic or structure.layout is None:
        raise ValueError("synchronous speeds by nodal diameter need equal sectors")
    pulled = sp.csr_array(order**2 * structure.mass)
    if effects != "none":
        pulled = sp.csr_array(pulled + matrices.mass - matrices.geometric)
    basis = structure.layout.basis(nodal_diameter)
    block = (basis.conj().T @ pulled @ basis).toarray()
    if effects == "full":
        block = block - 2j * order * (basis.conj().T @ matrices.coriolis @ basis).toarray()
    stiffness = (basis.conj().T @ structure.stiffness @ basis).toarray()
    return positive_speeds(stiffness, block)[0]
