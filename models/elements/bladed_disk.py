"""Finite element model of a bladed disk: beams, shaft springs, point masses and rigid links."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp

from bladewhirl.meshes.line_mesh import FloatArray, IntArray, LineMesh
from bladewhirl.meshes.plane import rotate
from bladewhirl.models.elements.cyclic import NO_COLUMN, SectorLayout
from bladewhirl.models.elements.structure import Structure, keep_free
from bladewhirl.models.geometry.beam_model import GROUND, BeamModel
from bladewhirl.models.sections.rectangular import LineProperties

COMPONENTS = 3
"""Degrees of freedom of a node: displacements along its first and second axis, and rotation."""


def point_masses(model: BeamModel, node_dofs: IntArray) -> sp.csr_array:
    """Return the mass matrix of the point masses, with a row for every DoF of every node."""
    masses = model.masses
    diagonal = np.zeros(node_dofs.size)
    each = np.column_stack([masses.mass, masses.mass, masses.inertia])
    np.add.at(diagonal, node_dofs[masses.node], each)
    return sp.csr_array(sp.diags_array(diagonal))


def node_springs(model: BeamModel, node_dofs: IntArray) -> sp.csr_array:
    """Return the stiffness matrix of the springs, with a row for every DoF of every node."""
    springs, axes = model.springs, model.mesh.node_axes
    stretch = sp.lil_array((springs.stiffness.size, node_dofs.size))
    for i, (node, other) in enumerate(zip(springs.node, springs.other, strict=True)):
        rows = COMPONENTS * i + np.arange(COMPONENTS)
        stretch[np.ix_(rows, node_dofs[node])] = np.eye(COMPONENTS)
        if other != GROUND:
            stretch[np.ix_(rows, node_dofs[other])] = -rotate(np.eye(3), axes[node] - axes[other])
    each = sp.csr_array(stretch)
    return sp.csr_array(each.T @ sp.diags_array(springs.stiffness.ravel()) @ each)


def node_expansion(model: BeamModel, node_dofs: IntArray) -> sp.csr_array:
    """Return the matrix from the free DoF to the motion of every node, (3 * nodes, free DoF).

    A rigid arm connects a led node to its leader. If the leader at p_0 has the displacement u and
    the rotation theta, the led node at p has the displacement u + theta x (p - p_0).

    Args:
        model: beam model with the rigid links.
        node_dofs: free DoF of each node, -1 if fixed or tied, (nodes, 3).
    """
    mesh, links = model.mesh, model.links
    size = int(node_dofs.max()) + 1
    free = np.flatnonzero(node_dofs.ravel() >= 0)
    shape = (node_dofs.size, size)
    direct = sp.csr_array((np.ones(len(free)), (free, node_dofs.ravel()[free])), shape=shape)
    if not links.led.size:
        return direct
    arms = sp.lil_array((node_dofs.size, node_dofs.size))
    for led, leader in zip(links.led, links.leader, strict=True):
        rows = COMPONENTS * led + np.arange(COMPONENTS)
        arms[np.ix_(rows, COMPONENTS * leader + np.arange(COMPONENTS))] = _arm(mesh, led, leader)
    return sp.csr_array(direct + sp.csr_array(arms) @ direct)


def _arm(mesh: LineMesh, led: int, leader: int) -> FloatArray:
    """Return the matrix from the motion of a leader to the motion of its led node, (3, 3)."""
    moved = rotate(np.eye(3), mesh.node_axes[led] - mesh.node_axes[leader])
    x, y = mesh.points[led] - mesh.points[leader]
    # A unit rotation moves the end of the arm by (-y, x); in the axes of the led node:
    moved[:2, 2] = rotate((-y, x), -mesh.node_axes[led])
    return moved


FIRST, SECOND, ROTATION = range(COMPONENTS)
"""Components of a node: along its first and second axis (radial, tangential; x, y), rotation."""


@dataclass(frozen=True, kw_only=True)
class BladedDiskModel:
    """A bladed disk in its rotating frame: straight Bernoulli beams, 3 DoF per node.

    The centre node does not rotate, except as the hub of a wheel on a shaft line. Springs along x
    and y support the centre node, or it is fixed (clamped).
    """

    model: BeamModel
    structure: Structure
    expansion: sp.csr_array  #: matrix from free DoF to the motion of each node, (3 * nodes, size)

    @property
    def mesh(self) -> LineMesh:
        """Mesh of the bladed disk."""
        return self.model.mesh

    @property
    def properties(self) -> LineProperties:
        """Section and material of each line."""
        return self.model.properties

    @property
    def tip_radial(self) -> IntArray:
        """Radial DoF of each blade tip, (blades,)."""
        return np.asarray(self.structure.node_dofs[self.model.tips, FIRST])

    @property
    def tip_tangential(self) -> IntArray:
        """Tangential DoF of each blade tip, (blades,)."""
        return np.asarray(self.structure.node_dofs[self.model.tips, SECOND])

    @property
    def centre(self) -> IntArray:
        """Free translations of the centre node: x and y, or none when clamped."""
        dofs = self.structure.node_dofs[self.model.centre, :ROTATION]
        return np.asarray(dofs[dofs >= 0])

    @property
    def tip_angles(self) -> FloatArray:
        """Angle of each tip from +x in the rotating frame [rad], (blades,)."""
        points = self.mesh.points[self.model.tips]
        return np.asarray(np.mod(np.arctan2(points[:, 1], points[:, 0]), 2.0 * np.pi))

    @property
    def rotates(self) -> bool:
        """True if the structure is that at a speed."""
        return self.structure.at_rest is not None

    @property
    def speed(self) -> float:
        """Speed of rotation of the structure [rad/s]; 0 at rest."""
        return self.structure.speed or 0.0

    def growth(self, omega: float | None = None) -> FloatArray:
        """Return the radial growth of each tip by steady rotation [m], (blades,), at a speed
        [rad/s], by default that of the structure; zero without effects of the rotation."""
        if not self.rotates:
            return np.zeros(len(self.tip_radial))
        at = self.speed if omega is None else omega
        return self.structure.static_displacement(at)[self.tip_radial]

    def blade_columns(self, column: IntArray) -> IntArray:
        """Convert DFT columns over the sectors to DFT columns over the blades, (modes,).

        The columns are equal if each sector has one blade; otherwise every column is `NO_COLUMN`.
        """
        layout = self.structure.layout
        one_each = layout is not None and layout.sectors == len(self.model.tips)
        return column if one_each else np.full_like(column, NO_COLUMN)

    def cartesian(self, shapes: FloatArray) -> FloatArray:
        """Return displacements along x and y and rotation of every node, (nodes, 3, fields).

        Args:
            shapes: fields on the free DoF, (size, fields).
        """
        local = (self.expansion @ shapes).reshape(len(self.mesh.points), COMPONENTS, -1)
        return rotate(local, self.mesh.node_axes[:, None], axis=1)


def assemble_bladed_disk(
    model: BeamModel,
    *,
    shaft_stiffness: float | tuple[float, float],
    clamped: bool,
    torsion_stiffness: float | None = None,
) -> BladedDiskModel:
    """Assemble a bladed disk.

    Stiffness and mass are integrated with the section at the quadrature points. The bending
    frequencies of tapered beams therefore converge with fourth order, as for prismatic beams.

    Args:
        model: beams, masses, springs and links.
        shaft_stiffness: stiffness of both springs at the centre, or one value each for x and y
            [N/m].
        clamped: fix the centre instead of supporting it by springs.
        torsion_stiffness: stiffness of a spring against the rotation of the centre [N m]; None for
            a centre that does not rotate.
    """
    beams, mesh = BeamMatrices(model), model.mesh
    inertial, assembler = beams.mass(), beams.assembler
    centre = assembler.node_dofs[model.centre]
    fixed = centre if clamped else centre[ROTATION:]
    spring = np.zeros(inertial.shape[0])
    spring[centre[:ROTATION]] = shaft_stiffness
    if torsion_stiffness is not None:
        fixed, spring[centre[ROTATION]] = fixed[:0], torsion_stiffness
    shaft = sp.csr_array(sp.diags_array(spring))

    led = assembler.node_dofs[model.links.led].ravel()
    node_dofs = keep_free(assembler.node_dofs, np.union1d(fixed, led))
    expansion = node_expansion(model, node_dofs)

    def reduced(matrix: sp.csr_array) -> sp.csr_array:
        small = sp.csr_array(expansion.T @ matrix @ expansion)
        return sp.csr_array((small + small.T) / 2.0)

    structure = Structure(
        mass=reduced(inertial + point_masses(model, assembler.node_dofs)),
        stiffness=reduced(beams.stiffness() + node_springs(model, assembler.node_dofs) + shaft),
        springs=reduced(shaft),
        node_dofs=node_dofs,
        layout=_sector_layout(mesh, node_dofs),
        constraints=np.zeros((expansion.shape[1], 0)),
    )
    return BladedDiskModel(model=model, structure=structure, expansion=expansion)


class BeamMatrices:
    """Assembler of the matrices of the beams of a model, with a row for every DoF of every node."""

    def __init__(self, model: BeamModel) -> None:
        """Prepare the assembly; `sections` are those at its quadrature points."""
        # Loaded with scikit-fem, which superelements do not need.
        from bladewhirl.models.elements.assembly import straight_beams

        mesh = model.mesh
        self.assembler = straight_beams(mesh.lengths, mesh.lines, len(mesh.points))
        self.sections = model.properties.at(self.assembler.points)
        self._transform = nodal_to_line_axes(mesh)

    def of(self, form: Any, *, skew: bool = False, **coefficients: FloatArray) -> sp.csr_array:
        """Assemble a weak form, see `LineAssembler.matrix`."""
        return self.assembler.matrix(form, self._transform, skew=skew, **coefficients)

    def mass(self, weight: float | FloatArray = 1.0) -> sp.csr_array:
        """Return the mass matrix, with a factor on that of each line, (lines, 1), or at each
        quadrature point, (lines, points)."""
        from bladewhirl.models.elements.forms import mass

        return self.of(mass, rho_A=weight * self.sections.line_mass)

    def stiffness(self, weight: float | FloatArray = 1.0) -> sp.csr_array:
        """Return the stiffness matrix, with a factor on that of each line, (lines, 1)."""
        from bladewhirl.models.elements.forms import straight_stiffness

        return self.of(
            straight_stiffness,
            EA=weight * self.sections.axial_stiffness,
            EI=weight * self.sections.bending_stiffness,
        )


def nodal_to_line_axes(mesh: LineMesh) -> FloatArray:
    """Return for each line the matrix from nodal axes to the axes of the line, (lines, 6, 6)."""
    transform = np.zeros((len(mesh.lines), 6, 6))
    for end in range(2):
        turn = mesh.line_axes - mesh.node_axes[mesh.lines[:, end]]
        block = slice(COMPONENTS * end, COMPONENTS * (end + 1))
        transform[:, block, block] = rotate(np.eye(COMPONENTS), turn[:, None])
    return transform


def _sector_layout(mesh: LineMesh, node_dofs: IntArray) -> SectorLayout | None:
    """Return sectors of the free DoF; None if nodes are tied or fixed in some sectors only."""
    if mesh.sectors is None:
        return None
    dofs = node_dofs[mesh.sectors].reshape(len(mesh.sectors), -1)
    gone = dofs < 0
    if np.any(gone.any(axis=0) != gone.all(axis=0)):
        return None
    return SectorLayout(
        sector_dofs=dofs[:, ~gone[0]],
        centre_dofs=node_dofs[mesh.node_sets["centre"][0]],
        rounding=_rounding(mesh),
    )


def _rounding(mesh: LineMesh) -> float:
    """Return a bound on the relative error of matrix entries due to rounded coordinates.

    The error of the angle of a point, 2 pi n / N, is 2 pi eps, so a point at radius R is accurate
    to 2 pi eps R. The relative error of the length L of a line, and the error of its direction,
    are then d = 4 pi eps R / L. The matrix of a line has powers of L up to L^-3. Its error due to
    the length is therefore 3 d, and its error due to the direction is d for each index. The errors
    of two sectors can have opposite signs: the total bound is 10 d.
    """
    radius = np.hypot(*mesh.points.T)[mesh.lines].max(axis=1)
    return float(40.0 * np.pi * np.finfo(np.float64).eps * (radius / mesh.lengths).max())
