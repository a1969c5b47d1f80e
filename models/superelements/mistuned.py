"""Wheels whose blades differ in stiffness.

The stiffness of blade j is multiplied by 1 + d_j, so that the stiffness of a wheel becomes K + sum
d_j B_j with the stiffness B_j of the blade in it. In the waves of all nodal diameters of a tuned
wheel of sectors, with the amplitude exp(i k theta_j) p_k / sqrt(N) in sector j, the change couples
the wave k to the wave l by

    D(l - k) p_k^H B p_l,      D(n) = 1/N sum_j d_j exp(i n theta_j)

(Yang and Griffin 2001, J. Eng. Gas Turbines Power 123(4); exact but for the modes left out).
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.models.inputs.errors import Fault
from bladewhirl.models.structure.rotating import of_modes
from bladewhirl.models.superelements.reduction import RIGID_SECTOR, ReducedSuperelement, root_of
from bladewhirl.models.superelements.stresses import InModes
from bladewhirl.models.superelements.superelement import (
    FIXED,
    IndefiniteError,
    Matrix,
    Superelement,
    SuperelementError,
)


def _separate(blades: int, reason: str) -> SuperelementError:
    expected = (
        f"the stiffness of {blades} blades that are not connected with each other, and a contact"
        f" node on each of them; {reason}"
    )
    return SuperelementError(Fault(key="blade_stiffness", expected=expected))


def mistuned_wheel(part: Superelement, factor: FloatArray) -> Superelement:
    """Return a wheel whose blades have another stiffness.

    Args:
        part: wheel with blade_stiffness, whose contact nodes are listed blade by blade.
        factor: factor on the stiffness of each blade, (blades,).

    Raises:
        SuperelementError: the stiffness of the blades has not one part for each blade.
    """
    own, blades = sp.csr_array(part.blade_stiffness), len(factor)
    of_nodes = part.contact_dofs.reshape(blades, -1)
    _, member = connected_components(own, directed=False)
    stiff = own.diagonal() != 0.0
    change = np.full(part.size, np.nan)
    for blade, dofs in enumerate(of_nodes):
        inside = np.isin(member, member[dofs[dofs != FIXED]]) & stiff
        if not inside.any():
            raise _separate(blades, f"blade {blade} has none")
        if not np.isnan(change[inside]).all():
            raise _separate(blades, f"blade {blade} is part of another")
        change[inside] = factor[blade] - 1.0
    if np.isnan(change[stiff]).any():
        raise _separate(blades, "a part of it has no contact node")
    scale = sp.diags_array(np.where(stiff, change, 0.0))
    stiffness = part.stiffness + (
        scale @ own if sp.issparse(part.stiffness) else (scale @ own).toarray()
    )
    return replace(part, stiffness=stiffness, blade_stiffness=None)


def blade_products(stiffness: Matrix, fields: Sequence[ComplexArray]) -> FloatArray:
    """Return the products Z^T B Z of the stiffness B of the blade of a sector, (2 m, 2 m), where Z
    has the real parts and then the imaginary parts of the fields of each nodal diameter in turn.

    Args:
        stiffness: stiffness of the blade, (n, n).
        fields: fields of each nodal diameter, (n, modes) each.
    """
    parts = np.hstack([part for field in fields for part in (field.real, field.imag)])
    return np.asarray(parts.T @ (sp.csr_array(stiffness) @ parts))


def coupled_waves(
    products: FloatArray, shapes: Sequence[ComplexArray], sectors: int
) -> ComplexArray:
    """Return p_k^H B p_l for the waves k, l = 0, ..., N - 1, (N m, N m).

    Args:
        products: see `blade_products`.
        shapes: amplitudes of m waves of each nodal diameter k = 0, 1, ..., N / 2 in the fields of
            the products, (fields, m) each; waves N - k are their conjugates.
        sectors: number N of sectors.
    """
    pairs = [np.vstack([shape, 1j * shape]) for shape in shapes]
    size, ends = shapes[0].shape[1], np.cumsum([0, *map(len, pairs)])
    waves = [min(k, sectors - k) for k in range(sectors)]
    found = np.empty((sectors, size, sectors, size), dtype=np.complex128)
    for k, one in enumerate(waves):
        left = pairs[one].T if k != one else pairs[one].conj().T
        half = left @ products[ends[one] : ends[one + 1]]
        for n, other in enumerate(waves):
            right = pairs[other] if n == other else pairs[other].conj()
            found[k, :, n] = half[:, ends[other] : ends[other + 1]] @ right
    return found.reshape(sectors * size, -1)


def change_of_waves(coupled: ComplexArray, factor: FloatArray) -> FloatArray:
    """Return the change of the stiffness of a wheel on the real modes of its tuned blades, the
    cosine and then the sine modes of each nodal diameter, (N m, N m).

    Args:
        coupled: see `coupled_waves`, (N m, N m).
        factor: factor on the stiffness of each blade, (N,).
    """
    sectors = len(factor)
    number = np.arange(sectors)
    spectrum = np.fft.ifft(factor - 1.0)
    shares = spectrum[(number - number[:, None]) % sectors]
    size = len(coupled) // sectors
    return _on_real(coupled * np.repeat(np.repeat(shares, size, axis=0), size, axis=1), sectors)


def _on_real(matrix: ComplexArray, sectors: int) -> FloatArray:
    """Return a Hermitian matrix of the waves 0, ..., N - 1 on the real modes of each nodal
    diameter."""
    size = len(matrix) // sectors
    turn = np.zeros((sectors, sectors), dtype=np.complex128)
    column = 0
    for k in range(sectors // 2 + 1):
        if 0 < 2 * k < sectors:
            turn[[k, sectors - k], column] = np.sqrt(0.5)
            turn[[k, sectors - k], column + 1] = -1j * np.sqrt(0.5), 1j * np.sqrt(0.5)
            column += 2
        else:
            turn[k, column] = 1.0
            column += 1
    blocks = matrix.reshape(sectors, size, sectors, size)
    half = np.einsum("akbl,bc->akcl", blocks, turn, optimize=True)
    real = np.einsum("ad,akcl->dkcl", turn.conj(), half, optimize=True).real
    return np.asarray(real.reshape(matrix.shape))


def stiffened(
    reduced: ReducedSuperelement, change: FloatArray, modes: int, factor: FloatArray
) -> ReducedSuperelement:
    """Return a reduction with another stiffness. Stresses by contact forces without their part in
    the modes, and by steady rotation, remain those of equal blades.

    Args:
        reduced: reduction of the tuned wheel with more modes than are kept.
        change: change of the stiffness on its modes [1/s2], (more, more).
        modes: number of modes that are kept; the others are static.
        factor: factor on the stiffness of each blade, (blades,), by which the residual flexibility
            is divided.

    Raises:
        SuperelementError: the stiffness is not positive definite.
    """
    squares, turn = la.eigh(np.diag(reduced.squares) + change)
    if not squares[0] > 0.0:
        raise IndefiniteError(RIGID_SECTOR)
    stress = reduced.stress
    kept, rest = turn[:, :modes], reduced.contact @ turn[:, modes:]
    scale = 1.0 / np.sqrt(factor)
    softer = np.repeat(scale, len(rest) // len(factor))
    static = (rest / squares[modes:]) @ rest.T

    def in_kept(of_modes: InModes) -> InModes:
        return lambda given: of_modes(kept if given is None else kept @ given)

    def points_by_force(sums: sp.csr_array) -> FloatArray:
        own = sums @ sp.diags_array(np.repeat(scale, sums.shape[1] // len(factor)))
        moved = (sums @ reduced.points) @ (turn[:, modes:] / squares[modes:])
        return np.asarray(reduced.points_by_force(own) * softer + moved @ rest.T)

    root = None if reduced.root is None else root_of(reduced.root @ reduced.root + change)
    own = replace(reduced, root=root).projected(kept)
    return replace(
        reduced,
        **own | of_modes(squares[:modes]),
        compliance=softer[:, None] * reduced.compliance * softer + static,
        of_points=in_kept(reduced.of_points),
        waves=None,
        points_by_force=points_by_force,
        stress=None if stress is None else replace(stress, of_modes=in_kept(stress.of_modes)),
        kept=modes,
    )
