"""Modes with one nodal diameter as functions of the stiffness of the shaft springs.

The matrices of the nodal diameter k = 1 are the block k = 1. The shaft springs add the rank-one
matrix kappa s s^H to its stiffness, where s is the displacement of the centre. By the inequalities
of Weyl and Cauchy, each frequency rises with kappa, up to the frequency of the same rank with a
clamped centre, and never passes the next frequency. The branches therefore veer and do not cross:
the n-th branch is the n-th frequency at every stiffness.
"""

from dataclasses import dataclass

import numpy as np
import scipy.linalg as la
from numpy.typing import NDArray

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.structure.eigenproblems import gyroscopic_eigen, gyroscopic_frequencies


@dataclass(frozen=True, kw_only=True)
class ShaftVeering:
    """Branches of frequencies as functions of the spring stiffness."""

    stiffness: FloatArray  #: stiffness kappa of each of the two springs [N/m], (stiffnesses,)
    frequency: FloatArray  #: frequencies [rad/s], (stiffnesses, branches)
    spring_share: FloatArray  #: share of the strain energy in the springs, (stiffnesses, branches)
    clamped: FloatArray  #: frequencies with a clamped centre [rad/s], (branches,)
    direction: tuple[str, ...]
    """Direction of travel of each branch in rotating axes, (branches,): "backward", then "forward";
    "both" without Coriolis forces."""


def shaft_veering(
    stiffness: NDArray[np.complex128],
    mass: NDArray[np.complex128],
    centre: NDArray[np.complex128],
    *,
    springs: FloatArray,
    branches: int,
) -> ShaftVeering:
    """Follow the lowest frequencies of block k = 1 as the stiffness of the shaft springs changes.

    Args:
        stiffness: stiffness matrix of the block without springs, Hermitian, (n, n).
        mass: mass matrix of the block, (n, n).
        centre: s of the springs' stiffness kappa s s^H, (n,); a unit coordinate vector.
        springs: stiffnesses kappa [N/m], (stiffnesses,).
        branches: number of branches, from the lowest.
    """
    frequency, share = np.empty((2, len(springs), branches))
    unit = np.outer(centre, centre.conj())
    for i, kappa in enumerate(springs):
        squares, vectors = la.eigh(
            stiffness + kappa * unit, mass, subset_by_index=(0, branches - 1)
        )
        squares = np.maximum(squares, 0.0)
        frequency[i] = np.sqrt(squares)
        in_springs = kappa * np.abs(centre.conj() @ vectors) ** 2
        share[i] = in_springs / np.maximum(squares, np.finfo(float).tiny)
    at_rest = np.flatnonzero(np.abs(centre) < 0.5)
    inside = np.ix_(at_rest, at_rest)
    clamped = la.eigvalsh(stiffness[inside], mass[inside], subset_by_index=(0, branches - 1))
    return ShaftVeering(
        stiffness=springs,
        frequency=frequency,
        spring_share=np.minimum(share, 1.0),
        clamped=np.sqrt(np.maximum(clamped, 0.0)),
        direction=("both",) * branches,
    )


def whirl_veering(
    matrices: tuple[NDArray[np.complex128], ...],
    elastic: NDArray[np.complex128],
    centre: NDArray[np.complex128],
    *,
    springs: FloatArray,
    branches: int,
) -> ShaftVeering:
    """Follow the lowest frequencies of block k = 1 at speed, for backward and forward waves.

    As kappa increases, the signed frequencies of backward waves rise, and the signed frequencies of
    forward waves fall. The branches of one direction do not cross.

    Args:
        matrices: mass, stiffness K_Omega without springs and Coriolis matrix of the block, (n, n)
            each.
        elastic: elastic stiffness without softening, for the strain energy, (n, n).
        centre: s of the springs' stiffness kappa s s^H, (n,); a unit coordinate vector.
        springs: stiffnesses kappa [N/m], (stiffnesses,).
        branches: number of branches in each direction, from the lowest.
    """
    mass, stiffness, coriolis = matrices
    size, unit = len(mass), np.outer(centre, centre.conj())

    def chosen(size: int) -> NDArray[np.int64]:
        """Return the columns of the lowest backward waves, then of the lowest forward waves."""
        ranks = np.arange(branches)
        return np.concatenate([size - 1 - ranks, size + ranks])

    frequency, share = np.empty((2, len(springs), 2 * branches))
    for i, kappa in enumerate(springs):
        w, vectors = gyroscopic_eigen(mass, stiffness + kappa * unit, coriolis)
        kept = vectors[:, chosen(size)]
        frequency[i] = np.abs(w[chosen(size)].real)
        spring_energy = kappa * np.abs(centre.conj() @ kept) ** 2
        material = np.einsum("im,ij,jm->m", kept.conj(), elastic, kept).real
        share[i] = spring_energy / np.maximum(spring_energy + material, np.finfo(float).tiny)
    free = np.flatnonzero(np.abs(centre) < 0.5)
    w = gyroscopic_frequencies(*(each[np.ix_(free, free)] for each in (mass, stiffness, coriolis)))
    return ShaftVeering(
        stiffness=springs,
        frequency=frequency,
        spring_share=share,
        clamped=np.abs(w[chosen(len(free))].real),
        direction=("backward",) * branches + ("forward",) * branches,
    )
