"""Matrices of elastic solids with scikit-fem.

Unknown 3 n + c is displacement c of node n; after the nodes come the incompatible modes of elements
that have some. Each block of displacements i and k is assembled with a scalar element,
which takes a ninth of the time of a vector element.
"""

from collections.abc import Callable
from itertools import combinations_with_replacement
from typing import Any, Literal, NamedTuple

import numpy as np
import scipy.sparse as sp
from skfem import Basis, BilinearForm

from bladewhirl.meshes.files.groups import MeshFileError
from bladewhirl.meshes.files.volumes import VolumeMesh
from bladewhirl.meshes.line_mesh import BoolArray, FloatArray, IntArray
from bladewhirl.models.solids.elements import ELEMENTS, ElementType, Mapping, Rule, Unknowns
from bladewhirl.models.solids.materials import Materials
from bladewhirl.models.superelements.cholesky import Cholesky

HOURGLASS = 5e-4
"""Coefficient of the stiffness against hourglass modes, as in CalculiX."""

MODES = np.array(
    [
        [1, 1, -1, -1, -1, -1, 1, 1],
        [1, -1, -1, 1, -1, 1, 1, -1],
        [1, -1, 1, -1, 1, -1, 1, -1],
        [-1, 1, -1, 1, 1, -1, 1, -1],
    ]
)
"""Hourglass modes of the nodes of a hexahedron in the order of VTK, (4, 8)."""


DISTORTION = 1e-2
"""Largest deviation of a cell of C3D8R from a parallelepiped, divided by its size."""


class Block(NamedTuple):
    """Cells with elements of one type."""

    kind: ElementType
    cells: IntArray  #: numbers of the cells among all cells
    nodes: IntArray  #: nodes of each cell, (cells, nodes)
    positions: FloatArray  #: their positions [m], (cells, nodes, 3)
    unknowns: Unknowns  #: unknowns of its functions

    def basis(self, rule: Rule, functions: type[Any]) -> Basis:
        """Return functions of displacements at the points of a quadrature."""
        return self.kind.basis(self.positions, self.unknowns, rule, functions)


class Solid:
    """Finite elements of a solid; positions in m.

    Cells have the shape that all their nodes describe (isoparametric elements).

    Args:
        mesh: mesh, with lengths in m.
        materials: materials of its cells.

    Raises:
        MeshFileError: a cell has no volume, or is turned inside out somewhere.
    """

    def __init__(self, mesh: VolumeMesh, materials: Materials) -> None:
        self._materials = materials
        self.blocks: list[Block] = []  #: cells by the type of their elements
        counts = [ELEMENTS[name].internal * len(cells) for name, cells in mesh.blocks]
        self.size = len(mesh.points) + sum(counts)  #: number of nodes and internal functions
        self.points = mesh.points  #: positions of the nodes [m], (nodes, 3)
        first, following = 0, len(mesh.points)
        for (name, cells), count in zip(mesh.blocks, counts, strict=True):
            kind = ELEMENTS[name]
            nodes = cells[:, kind.order]
            internal = following + np.arange(count).reshape(len(cells), -1)
            unknowns = np.concatenate([nodes, internal], axis=1).T
            numbers = np.arange(first, first + len(cells))
            self.blocks.append(
                Block(kind, numbers, nodes, mesh.points[nodes], Unknowns(unknowns, self.size))
            )
            first, following = first + len(cells), following + count
        self.cells = first  #: number of cells
        _check_volumes(self.blocks)
        for block in self.blocks:
            if block.kind.hourglass:
                _check_parallelepipeds(block)

    def mass(self, *, reduced: bool | None = None) -> sp.csr_array:
        """Return the consistent mass of one component of the displacements [kg], (size, size).

        Args:
            reduced: true for the quadrature of the stiffness, false for one that is exact for cells
                with plane faces; None for that of the name of each element.
        """
        total = sp.csr_array((self.size, self.size))
        for block in self.blocks:
            kind = block.kind
            density = self._materials.density[block.cells, None]
            share = kind.reduced if reduced is None else float(reduced)
            if share > 0.0:
                basis = block.basis(kind.stiffness_rule, kind.functions)
                total += _mass_form(share * density).assemble(basis)
            if share < 1.0:
                basis = block.basis(kind.mass_rule, kind.mass_functions)
                total += _mass_form((1.0 - share) * density).assemble(basis)
        return sp.csr_array(total)

    def stiffness(self, chosen: BoolArray | None = None) -> sp.csr_array:
        """Return the stiffness at rest [N/m], (3 * size, 3 * size), of all cells or of those for
        which `chosen` is true, (cells,)."""
        share = np.ones(self.cells) if chosen is None else chosen.astype(float)

        def law(block: Block, basis: Basis) -> FloatArray:
            return np.asarray((share[block.cells] * self._law(block))[..., None])

        return self._assembled(law, hourglass=share)

    def within(self, nodes: IntArray) -> BoolArray:
        """Return true for each cell all of whose nodes are among the given ones, (cells,)."""
        among = np.zeros(self.size, dtype=np.bool_)
        among[nodes] = True
        inside = np.zeros(self.cells, dtype=np.bool_)
        for block in self.blocks:
            inside[block.cells] = among[block.nodes].all(axis=1)
        return inside

    def stiffness_terms(self, displacement: FloatArray) -> tuple[sp.csr_array, ...]:
        """Return the changes of the stiffness by static displacements u [N/m], (3 * size, 3 * size)
        each: by the stress, by the other terms that are linear in u, and by those quadratic in u.

        The stiffness for small motions about u has for displacements i and k the block
        int (F_ia C_ajbl F_kb + S_jl delta_ik) dN/dx_j dN^T/dx_l dV with the shape functions N, the
        elasticity tensor C, the gradient F = I + du/dx of the deformed positions and the stress S,
        which is linear in u.

        Args:
            displacement: static displacements u [m], (3 * size,).
        """
        moved, unit = displacement.reshape(-1, 3), np.eye(3)

        def gradient(basis: Basis) -> FloatArray:
            return np.array([basis.interpolate(one).grad for one in moved.T])

        def by_stress(block: Block, basis: Basis) -> FloatArray:
            stress = np.einsum("ajble,blen->ajen", self._law(block), gradient(basis))
            return np.asarray(np.einsum("ik,jlen->ijklen", unit, stress))

        def linear(block: Block, basis: Basis) -> FloatArray:
            half = np.einsum("iaen,ajkle->ijklen", gradient(basis), self._law(block))
            return np.asarray(half + np.einsum("ijklen->klijen", half))

        def quadratic(block: Block, basis: Basis) -> FloatArray:
            first = gradient(basis)
            law = self._law(block)
            return np.asarray(
                np.einsum("iaen,ajble,kben->ijklen", first, law, first, optimize=True)
            )

        return tuple(map(self._assembled, (by_stress, linear, quadratic)))

    def _law(self, block: Block) -> FloatArray:
        """Return the elasticity tensor of each cell, (3, 3, 3, 3, cells)."""
        return self._materials.tensor[..., block.cells]

    def _assembled(
        self,
        tangent: Callable[[Block, Basis], FloatArray],
        *,
        hourglass: FloatArray | None = None,
    ) -> sp.csr_array:
        """Return the matrix of int T_ijkl dN/dx_j dN^T/dx_l dV for displacements i and k, (3 *
        size, 3 * size).

        Args:
            tangent: function that returns T, (3, 3, 3, 3, cells, points or 1).
            hourglass: factor on the stiffness against hourglass modes of each cell, (cells,); None
                to leave it out.
        """
        blocks = sp.csr_array((3 * self.size, 3 * self.size))
        for block in self.blocks:
            basis = block.basis(block.kind.stiffness_rule, block.kind.functions)
            law = tangent(block, basis)
            gradient = np.array([field[0].grad for field in basis.basis])  # (functions, 3, ...)
            functions, _, cells, _ = gradient.shape
            rows = np.moveaxis(gradient, (0, 1), (1, 3)).reshape(cells, functions, -1)
            for i, k in combinations_with_replacement(range(3), 2):
                if not law[i, :, k].any():
                    continue
                columns = np.einsum("jleq,mleq->eqjm", law[i, :, k] * basis.dx, gradient)
                entries = rows @ columns.reshape(cells, -1, functions)
                part = _spread(entries, block.unknowns)
                if i == k and hourglass is not None and block.kind.hourglass:
                    modulus = (hourglass * self._materials.young_modulus)[block.cells]
                    part += _hourglass_stiffness(block, basis, modulus)
                unit = np.zeros((3, 3))
                unit[i, k] = 1.0
                upper = sp.kron(part, unit, format="csr")
                blocks += upper if i == k else upper + upper.T
        return sp.csr_array(blocks)


def _mass_form(density: FloatArray) -> BilinearForm:
    return BilinearForm(lambda u, v, w: density * u * v)


def _spread(entries: FloatArray, unknowns: Unknowns) -> sp.csr_array:
    """Return the sum of matrices of cells (cells, functions, functions) over unknowns."""
    places = unknowns.element_dofs.T
    rows, columns = np.broadcast_arrays(places[:, :, None], places[:, None])
    size = (unknowns.N, unknowns.N)
    return sp.csr_array((entries.ravel(), (rows.ravel(), columns.ravel())), shape=size)


def _hourglass_stiffness(block: Block, basis: Any, young_modulus: FloatArray) -> sp.csr_array:
    """Return the stiffness of one displacement against hourglass modes [N/m].

    It is a sum over the four modes of a g g^T, with the vectors g of Flanagan and Belytschko (1981,
    equation 51), which are zero for a uniform gradient, and a = `HOURGLASS` E V sum |B|^2 for the
    mean gradients B of the functions and the volume V.
    """
    gradient = np.array([field[0].grad[..., 0] for field in basis.basis])  # (8, 3, cells)
    order = np.argsort(block.kind.order)  # from the order of VTK
    gradient, x = gradient[order], block.positions[:, order]
    spread = np.einsum("enj,mn->emj", x, MODES)
    modes = MODES - np.einsum("emj,nje->emn", spread, gradient)
    volume = basis.dx.sum(axis=1)
    scale = HOURGLASS * young_modulus * volume * (gradient**2).sum(axis=(0, 1))
    entries = np.einsum("e,ema,emb->eab", scale, modes, modes)
    return _spread(entries, Unknowns(block.unknowns.element_dofs[order], block.unknowns.N))


def _check_volumes(blocks: list[Block]) -> None:
    """Check that the determinant of the mapping of each cell has one sign, and is not zero."""
    bad: list[FloatArray] = []
    for block in blocks:
        points = block.kind.stiffness_rule[0]
        volumes = Mapping(block.kind.shape(), block.positions).detDF(points)
        least, most = volumes.min(axis=1), volumes.max(axis=1)
        inside_out = (least * most <= 0.0) | (abs(volumes).min(axis=1) < 1e-12 * abs(most))
        bad += [*block.positions[inside_out].mean(axis=1)]
    if bad:
        where = ", ".join(f"{value:.6g}" for value in bad[0])
        total = sum(len(block.cells) for block in blocks)
        raise MeshFileError(
            f"cells that are not turned inside out; {len(bad)} of {total} are, such as "
            f"that around ({where}) m"
        )


def _check_parallelepipeds(block: Block) -> None:
    """Check that the stiffness against hourglass modes is that of other programs.

    CalculiX subtracts the uniform gradient from these modes only along z of the deck; frequencies
    differ by up to 20 % where the cells are no parallelepipeds. Abaqus has another coefficient.
    """
    x = block.positions[:, np.argsort(block.kind.order)]
    spread = np.linalg.norm(np.einsum("enj,mn->emj", x, MODES), axis=2).max(axis=1) / 8.0
    size = np.linalg.norm(np.ptp(x, axis=1), axis=1)
    if len(bad := np.flatnonzero(spread > DISTORTION * size)):
        raise MeshFileError(
            f"parallelepipeds as elements C3D8R; {len(bad)} of {len(x)} are distorted, and their"
            " frequencies would depend on an artificial stiffness that differs between programs:"
            " write C3D8I, or C3D20R with mid-side nodes"
        )


IN_PLANE = np.diag([1.0, 1.0, 0.0])


Measure = Literal["prestress", "stress"]


def stiffness_by_rotation(
    solid: Solid,
    stiffness: sp.csr_array,
    mass: sp.csr_array,
    tie: sp.csr_array,
    measure: Measure,
) -> tuple[sp.csr_array, sp.csr_array | None, FloatArray]:
    """Return K1 and K2 of the stiffness K + Omega^2 K1 + Omega^4 K2 of a solid that rotates about
    z, (3 * size, 3 * size) each; K2 is None for "stress"; and the forces that hold its clamped
    nodes against the centrifugal forces at 1 rad/s [kg m], (size, 3), which are zero elsewhere but
    on the faces of a sector.

    K1 is the stiffness by the stress of the centrifugal forces, minus the mass in the plane of
    rotation. For "prestress", as in a linear static step with a following perturbation step of
    CalculiX, K1 and K2 also have the elastic stiffness of the statically deformed solid. The static
    displacements follow from the stiffness at rest. Centrifugal forces act on the functions of the
    nodes, not on incompatible modes.

    Args:
        solid: finite elements; their axis of rotation is z.
        stiffness: stiffness at rest [N/m], (3 * size, 3 * size).
        mass: mass of one component of the displacements [kg], (size, size).
        tie: matrix from the coordinates of the static deformation to all displacements, (3 * size,
            coordinates); the coordinates are the free displacements, for a sector those of a
            motion with nodal diameter 0.
        measure: "prestress" or "stress".

    Raises:
        LinAlgError: the stiffness at rest is singular.
    """
    nodal = sp.eye_array(solid.size, len(solid.points), format="csr")
    softening = sp.kron(nodal.T @ mass @ nodal, IN_PLANE, format="csr")
    spread = sp.kron(nodal, np.eye(3), format="csr")
    forces = spread @ (softening @ solid.points.ravel())
    load = tie.T @ forces
    moved = Cholesky.of(sp.csr_array(tie.T @ stiffness @ tie)).solve(load[:, None])[:, 0]
    with np.errstate(over="ignore", invalid="ignore"):  # the superelement checks its matrices
        by_stress, linear, quadratic = solid.stiffness_terms(tie @ moved)
    held = (stiffness @ (tie @ moved) - forces).reshape(-1, 3)
    first = sp.csr_array(by_stress - spread @ softening @ spread.T)
    if measure == "stress":
        return first, None, held
    return sp.csr_array(first + linear), quadratic, held
