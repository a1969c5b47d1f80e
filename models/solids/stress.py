"""Stress at the nodes of a solid for unit displacements.

The stress at the quadrature points of the stiffness is extrapolated to the nodes of each element by
the polynomial that fits it best, as in CalculiX, and averaged over the elements of one material
that meet at the node.
"""

from itertools import product
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.solids.assembly import Solid
from bladewhirl.models.solids.elements import ElementType
from bladewhirl.models.solids.materials import Materials

COMPONENTS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))
"""Components xx, yy, zz, xy, yz and zx of a symmetric tensor."""

TOGETHER = 2000  #: number of cells whose rows are computed together


class NodalStress(NamedTuple):
    """Stress at some nodes, and the material that it belongs to."""

    rows: sp.csr_array
    """Matrix from the displacements to the components xx, yy, zz, xy, yz and zx of the stress at
    each node [Pa/m], (6 nodes, 3 * size)."""
    young_modulus: FloatArray  #: Young's modulus [Pa], (nodes,)
    poisson_ratio: FloatArray  #: Poisson's ratio, (nodes,)


def nodal_stress(solid: Solid, nodes: IntArray, materials: Materials) -> NodalStress:
    """Return the stress at nodes, where materials meet in the stiffest of them.

    Args:
        solid: finite elements.
        nodes: numbers of nodes, ascending.
        materials: materials of all cells.
    """
    constants = np.stack([materials.young_modulus, materials.poisson_ratio], axis=1)
    kinds, kind = np.unique(constants, axis=0, return_inverse=True)  # ascending moduli
    place = np.full(solid.size, -1)
    place[nodes] = np.arange(len(nodes))
    stiffest, count = np.full(len(nodes), -1), np.zeros(len(nodes))
    for block in solid.blocks:
        at = place[block.kind.nodes_of(block.unknowns)]  # (nodes of a cell, cells)
        own = np.broadcast_to(kind.ravel()[block.cells], at.shape)
        np.maximum.at(stiffest, at[at >= 0], own[at >= 0])
    used = []
    for block in solid.blocks:
        at = place[block.kind.nodes_of(block.unknowns)]
        own = (at >= 0) & (stiffest[at] == kind.ravel()[block.cells])
        np.add.at(count, at[own], 1.0)
        used.append((block, np.where(own, at, -1)))
    total = sp.csr_array((6 * len(nodes), 3 * solid.size))
    for block, at in used:
        law = materials.tensor[..., block.cells]
        law = np.stack([law[i, j] for i, j in COMPONENTS])  # (6, 3, 3, cells)
        shared = np.flatnonzero((at >= 0).any(axis=0))
        spread = extrapolation(block.kind)
        for first in range(0, len(shared), TOGETHER):
            cells = shared[first : first + TOGETHER]
            part = block._replace(
                positions=block.positions[cells],
                unknowns=block.unknowns._replace(
                    element_dofs=block.unknowns.element_dofs[:, cells]
                ),
            )
            basis = part.basis(part.kind.stiffness_rule, part.kind.functions)
            gradient = np.array([field[0].grad for field in basis.basis])  # (functions, 3, ...)
            at_nodes = np.einsum("aq,fleq->aefl", spread, gradient, optimize=True)
            local, cell = np.nonzero(at[:, cells] >= 0)
            target = at[:, cells][local, cell]
            stress = np.einsum(
                "ckln,nfl->ncfk", law[..., cells[cell]], at_nodes[local, cell], optimize=True
            )
            stress /= count[target][:, None, None, None]
            unknown = part.unknowns.element_dofs[:, cell].T  # (places, functions)
            rows = 6 * target[:, None, None, None] + np.arange(6)[:, None, None]
            columns = 3 * unknown[:, None, :, None] + np.arange(3)
            rows, columns = (np.broadcast_to(one, stress.shape).ravel() for one in (rows, columns))
            total += sp.csr_array((stress.ravel(), (rows, columns)), shape=total.shape)
    young_modulus, poisson_ratio = kinds[stiffest].T
    return NodalStress(total, young_modulus, poisson_ratio)


def extrapolation(kind: ElementType) -> FloatArray:
    """Return the matrix from values at the quadrature points of the stiffness to those at the nodes
    of a cell, (nodes, points), exact for polynomials as in `_terms`."""
    points, nodes = kind.stiffness_rule[0].T, kind.cell.reference[kind.order]
    fitted = _terms(points, kind.cell_type)
    return np.asarray(_terms(nodes, kind.cell_type, len(points)) @ np.linalg.pinv(fitted))


def _terms(at: FloatArray, cell_type: str, points: int = 0) -> FloatArray:
    """Return the terms of a polynomial at places, (places, terms): linear in a tetrahedron, linear
    in the triangle and along a wedge, products of linear or of quadratic polynomials of each
    coordinate in a hexahedron, as far as the number of quadrature points (by default that of the
    places) allows."""
    x, y, z = at.T
    one, number = np.ones(len(at)), points or len(at)
    if number == 1:
        terms = [one]
    elif cell_type.startswith("tetra"):
        terms = [one, x, y, z]
    elif cell_type.startswith("wedge"):
        plane = [one, x, y] if number > 2 else [one]
        terms = [*plane, *(term * z for term in plane)]
    else:
        powers = [[axis**n for n in range(round(number ** (1.0 / 3.0)))] for axis in (x, y, z)]
        terms = [a * b * c for a, b, c in product(*powers)]
    return np.stack(terms, axis=1)
