"""Matrices of isotropic elastic solids with scikit-fem.

Unknown 3 n + c is displacement c of node n. Each block of displacements i and k is assembled with a
scalar element, which takes a ninth of the time of a vector element.
"""

from dataclasses import replace
from itertools import combinations_with_replacement, product
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spl
from skfem import Basis, BilinearForm, MeshHex1, MeshTet1
from skfem.assembly import Dofs

from bladewhirl.meshes.files.groups import MeshFileError
from bladewhirl.meshes.files.volumes import VolumeMesh
from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.solids.cells import CELL_TYPES, CellType
from bladewhirl.models.superelements.frequencies import SYMMETRIC_ORDER


class Elasticity(NamedTuple):
    """Constants of an isotropic elastic material."""

    young_modulus: float  #: Young's modulus [Pa]
    poisson_ratio: float  #: Poisson's ratio

    @property
    def tensor(self) -> FloatArray:
        """Elasticity tensor [Pa], (3, 3, 3, 3)."""
        shear = self.young_modulus / (2.0 * (1.0 + self.poisson_ratio))
        lame = 2.0 * shear * self.poisson_ratio / (1.0 - 2.0 * self.poisson_ratio)
        one = np.eye(3)
        symmetric = np.einsum("ik,jl->ijkl", one, one) + np.einsum("il,jk->ijkl", one, one)
        return np.asarray(lame * np.einsum("ij,kl->ijkl", one, one) + shear * symmetric)


class Solid:
    """Finite elements of a solid; positions in m.

    Cells have the shape that all their nodes describe (isoparametric elements).

    Raises:
        MeshFileError: a cell has no volume, or is turned inside out somewhere.
    """

    def __init__(self, mesh: VolumeMesh) -> None:
        self.points = mesh.points  #: positions of the nodes [m], (nodes, 3)
        self._type = CELL_TYPES[mesh.cell_type]
        self._mesh, self._node = _skfem_mesh(mesh, self._type)
        _check_volumes(mesh, self._basis(self._type.stiffness_order))

    @property
    def nodes(self) -> int:
        """Number of nodes."""
        return len(self.points)

    def mass(self, density: float, *, reduced: bool = False) -> sp.csr_array:
        """Return the consistent mass of one component of the displacements [kg], (nodes, nodes).

        Args:
            density: density [kg/m3].
            reduced: true for the quadrature of the stiffness, false for one that is exact for cells
                with plane faces.
        """
        mass = BilinearForm(lambda u, v, w: density * u * v)
        order = self._type.stiffness_order if reduced else self._type.mass_order
        return self._assembled(mass, self._basis(order))

    def stiffness(
        self, material: Elasticity, displacement: FloatArray | None = None
    ) -> sp.csr_array:
        """Return the stiffness for small motions about a static displacement [N/m], (3 * nodes,
        3 * nodes).

        The block of displacements i and k is int (F_ia C_ajbl F_kb + S_jl delta_ik) dN/dx_j
        dN^T/dx_l dV with the shape functions N, the elasticity tensor C, the gradient F of the
        deformed positions and the stress S, which is linear in the displacement. The first term is
        the elastic stiffness of the deformed solid, the second the geometric stiffness.

        Args:
            material: elastic constants.
            displacement: static displacements of the nodes [m], (3 * nodes,); zero by default.
        """
        basis = self._basis(self._type.stiffness_order)
        law = material.tensor
        if displacement is None:
            tangent = law[..., None, None]
        else:
            moved = displacement.reshape(-1, 3)[self._node]
            gradient = np.array([basis.interpolate(component).grad for component in moved.T])
            stress = np.einsum("ajbl,blen->ajen", law, gradient)
            position = np.eye(3)[..., None, None] + gradient
            tangent = np.einsum("iaen,ajbl,kben->ijklen", position, law, position, optimize=True)
            tangent += np.einsum("ik,jlen->ijklen", np.eye(3), stress)
        blocks = sp.csr_array((3 * self.nodes, 3 * self.nodes))
        for i, k in combinations_with_replacement(range(3), 2):
            block = self._assembled(_contraction(tangent[i, :, k]), basis)
            unit = np.zeros((3, 3))
            unit[i, k] = 1.0
            upper = sp.kron(block, unit, format="csr")
            blocks += upper if i == k else upper + upper.T
        return sp.csr_array(blocks)

    def _basis(self, order: int) -> Any:
        return Basis(self._mesh, self._type.element(), intorder=order)

    def _assembled(self, form: BilinearForm, basis: Any) -> sp.csr_array:
        entries = form.assemble(basis).tocoo()
        place = (self._node[entries.row], self._node[entries.col])
        return sp.csr_array((entries.data, place), shape=(self.nodes, self.nodes))


def _contraction(tangent: FloatArray) -> BilinearForm:
    """Return the form tangent_jl dv/dx_j du/dx_l; terms without a coefficient are left out."""
    terms = [pair for pair in product(range(3), repeat=2) if tangent[pair].any()]
    return BilinearForm(
        lambda u, v, w: sum(tangent[j, k] * v.grad[j] * u.grad[k] for j, k in terms)
    )


def _skfem_mesh(mesh: VolumeMesh, kind: CellType) -> tuple[Any, IntArray]:
    """Return a mesh of scikit-fem and the node of each unknown of its scalar element."""
    places = {tuple(place): number for number, place in enumerate(kind.reference.tolist())}
    corners = [places[tuple(corner)] for corner in kind.mesh.elem.refdom.p.T.tolist()]
    vertices, t = np.unique(mesh.cells[:, corners].T, return_inverse=True)
    t = np.ascontiguousarray(t.reshape(len(corners), -1))
    first_order = MeshTet1 if len(corners) == 4 else MeshHex1
    made = first_order(np.ascontiguousarray(mesh.points[vertices].T), t)
    # Unknown i of the element of displacements is at the node nodes[i] of each cell. The nodes
    # of the element of the shape, more for 20-node hexahedra, are interpolated.
    element, shape = kind.element(), kind.mesh.elem()
    nodes = np.array([places[tuple(place)] for place in element.doflocs.tolist()])
    if first_order is not kind.mesh:
        made = kind.mesh.from_mesh(made)
        locations = made.doflocs.copy()
        for place, dofs in zip(shape.doflocs, Dofs(made, shape).element_dofs, strict=True):
            weights = [float(element.lbasis(place[:, None], i)[0][0]) for i in range(len(nodes))]
            locations[:, dofs] = np.einsum("i,eij->je", weights, mesh.points[mesh.cells[:, nodes]])
        made = replace(made, doflocs=locations)
    dofs = Dofs(made, element)
    node = np.empty(dofs.N, dtype=np.int64)
    node[dofs.element_dofs] = mesh.cells[:, nodes].T
    return made, node


def _check_volumes(mesh: VolumeMesh, basis: Any) -> None:
    """Check that the determinant of the mapping of each cell has one sign, and is not zero."""
    volumes = basis.mapping.detDF(basis.X)
    volumes = np.broadcast_to(volumes, (len(mesh.cells), np.shape(volumes)[-1]))
    least, most = volumes.min(axis=1), volumes.max(axis=1)
    bad = np.flatnonzero((least * most <= 0.0) | (abs(volumes).min(axis=1) < 1e-12 * abs(most)))
    if len(bad):
        where = ", ".join(f"{value:.6g}" for value in mesh.points[mesh.cells[bad[0]]].mean(axis=0))
        raise MeshFileError(
            f"cells that are not turned inside out; {len(bad)} of {len(mesh.cells)} are, such as "
            f"that around ({where}) m"
        )


IN_PLANE = np.diag([1.0, 1.0, 0.0])


def rotating_stiffness(
    solid: Solid, mass: sp.csr_array, tie: sp.csr_array, material: Elasticity, speed: float
) -> sp.csr_array:
    """Return the stiffness of a solid that rotates about z [N/m], (3 * nodes, 3 * nodes).

    Args:
        solid: finite elements; their axis of rotation is z.
        mass: mass of one component of the displacements [kg], (nodes, nodes).
        tie: matrix from the coordinates of the static deformation to all displacements, (3 * nodes,
            coordinates); the coordinates are the free displacements, for a sector those of a
            motion with nodal diameter 0.
        material: elastic constants.
        speed: speed of rotation [rad/s].
    """
    softening = speed**2 * sp.kron(mass, IN_PLANE, format="csr")
    load = tie.T @ (softening @ solid.points.ravel())
    factor = spl.splu(sp.csc_array(tie.T @ solid.stiffness(material) @ tie), **SYMMETRIC_ORDER)
    displacement = tie @ factor.solve(load)
    return sp.csr_array(solid.stiffness(material, displacement) - softening)
