"""Assembly of beam elements over a mesh of lines with scikit-fem.

scikit-fem has no mesh of lines in the plane. Each element is therefore an interval [0, L_e] of a
one-dimensional mesh without connections; the elements are connected by common degrees of freedom.
A Hermite element of scikit-fem caches values of its first mesh, so each call makes a new element.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp
from skfem import Basis, Element, ElementLineHermite, ElementLineP1, MeshLine1
from skfem.assembly import Dofs

from bladewhirl.meshes.line_mesh import FloatArray, IntArray


@dataclass(frozen=True, kw_only=True)
class LineAssembler:
    """Assembler of weak forms over lines, made by `straight_beams` or `curved_beams`."""

    basis: Any  #: scikit-fem basis over the one-dimensional mesh
    node_dofs: IntArray  #: degrees of freedom of each node, (nodes, DoF per node)

    @property
    def points(self) -> FloatArray:
        """Positions of the quadrature points in an element, from 0 to 1, (points,)."""
        return np.asarray(self.basis.X[0])

    @property
    def weights(self) -> FloatArray:
        """Weights of the quadrature points, with sum one, (points,)."""
        return np.asarray(self.basis.W)

    def matrix(
        self,
        form: Any,
        transform: FloatArray | None = None,
        *,
        skew: bool = False,
        **coefficients: FloatArray,
    ) -> sp.csr_array:
        """Assemble a weak form over all elements.

        Args:
            form: weak form, see `forms`.
            transform: matrix of each element from nodal axes to element axes, (elements, DoF per
                element, DoF per element).
            skew: true for a skew-symmetric form, false for a symmetric form.
            coefficients: coefficients of the form, either one value for each element, (elements,),
                or one for each quadrature point, (elements, points), see `points`.
        """
        fields = {
            name: np.broadcast_to(values.reshape(len(values), -1), self.basis.dx.shape).copy()
            for name, values in coefficients.items()
        }
        data = form.elemental(self.basis, **fields)
        if transform is not None:
            local = data.tolocal()
            data = data.fromlocal(np.einsum("eji,ejk,ekl->eil", transform, local, transform))
        matrix = sp.csr_array(data.tocsr())
        matrix.resize((self.node_dofs.size, self.node_dofs.size))  # last nodes may have no line
        mirrored = -matrix.T if skew else matrix.T
        return sp.csr_array((matrix + mirrored) / 2.0)  # exactly symmetric, or exactly skew


def straight_beams(lengths: FloatArray, lines: IntArray, nodes: int) -> LineAssembler:
    """Return an assembler of straight Bernoulli beams, DoF (u, w, w') per node; ``lengths`` [m]."""
    return _assembler(ElementLineP1() * ElementLineHermite(), lengths, lines, nodes)


def curved_beams(lengths: FloatArray, lines: IntArray, nodes: int) -> LineAssembler:
    """Return an assembler of curved beams with Hermite functions for u and w, DoF (u, u', w, w')
    per node; ``lengths`` along the arc [m]."""
    return _assembler(ElementLineHermite() * ElementLineHermite(), lengths, lines, nodes)


def _assembler(element: Element, lengths: FloatArray, lines: IntArray, nodes: int) -> LineAssembler:
    count = len(lengths)
    ends = np.column_stack([np.zeros(count), lengths]).reshape(1, -1)
    flat = MeshLine1(ends, np.ascontiguousarray(np.arange(2 * count).reshape(-1, 2).T))
    # Only the connectivity of this mesh is used; its points need not exist.
    topology = MeshLine1(np.zeros((1, nodes)), np.ascontiguousarray(lines.T), validate=False)
    dofs = Dofs(topology, element)
    basis = Basis(flat, element, dofs=dofs, intorder=6, disable_doflocs=True)
    per_node = len(dofs.nodal_dofs)  # numbered node by node, also nodes without lines
    node_dofs = np.arange(per_node * nodes, dtype=np.int64).reshape(nodes, per_node)
    return LineAssembler(basis=basis, node_dofs=node_dofs)
