"""Timoshenko elements of a round shaft.

The deflection w of an element is a Hermite polynomial with the slopes theta + gamma at its ends,
for the rotations theta of the sections and a shear strain gamma that is constant in the element,

    gamma = Phi / (1 + Phi) ((w_2 - w_1) / L - (theta_1 + theta_2) / 2),   Phi = 12 E I / (kappa G A
    L^2),

which is exact in statics for a constant section (Przemieniecki 1968, Section 5.6). A plane of a
round shaft has the matrices of any other one; the unknowns of a node are w and theta.
"""

from dataclasses import dataclass

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray

POINTS_ORDER = 8  #: polynomial order that is integrated exactly


@dataclass(frozen=True, kw_only=True)
class RoundElements:
    """Elements of a round shaft from left to right; arrays (elements,), at both ends (elements,
    2)."""

    node: FloatArray  #: position of each node [m], (elements + 1,)
    outer: FloatArray  #: outer diameter at both ends [m], (elements, 2)
    inner: FloatArray  #: diameter of the bore [m]
    young_modulus: FloatArray  #: Young's modulus [Pa]
    shear_modulus: FloatArray  #: shear modulus times the shear coefficient [Pa]
    torsion_modulus: FloatArray  #: shear modulus [Pa]
    density: FloatArray  #: density [kg/m3]

    @property
    def length(self) -> FloatArray:
        """Length of each element [m], (elements,)."""
        return np.diff(self.node)


@dataclass(frozen=True, kw_only=True)
class ShaftMatrices:
    """Matrices of a shaft in one plane, for the deflection and the rotation of each node in turn,
    (2 nodes, 2 nodes)."""

    stiffness: FloatArray  #: stiffness [N/m, N, N m]
    translation: FloatArray  #: mass of the deflections [kg, kg m, kg m2]
    rotation: FloatArray  #: rotary inertia of the sections about a diameter [kg, kg m, kg m2]


def shaft_matrices(shaft: RoundElements) -> ShaftMatrices:
    """Return the matrices of a shaft in one plane."""
    from skfem import Basis, ElementLineHermite, MeshLine1  # only a shaft line needs it

    length, count = shaft.length, len(shaft.length)
    mesh = MeshLine1(shaft.node[None, :], np.arange(count)[None, :] + np.array([[0], [1]]))
    basis = Basis(mesh, ElementLineHermite(), intorder=POINTS_ORDER)
    along, weight = basis.X[0], basis.dx
    outer = shaft.outer @ np.array([1.0 - along, along])
    area = np.pi / 4.0 * (outer**2 - shaft.inner[:, None] ** 2)
    inertia = np.pi / 64.0 * (outer**4 - shaft.inner[:, None] ** 4)
    young, density = shaft.young_modulus[:, None], shaft.density[:, None]

    sheared = shaft.shear_modulus * (area * weight).sum(axis=1) / length  # kappa G A
    phi = 12.0 * shaft.young_modulus * (inertia * weight).sum(axis=1) / (sheared * length**3)
    one, half = np.ones(count), 0.5 * np.ones(count)
    gamma = np.stack([-one / length, -half, one / length, -half]) * (phi / (1.0 + phi))
    slopes = np.zeros((4, 4, count))  # Hermite unknowns by unknowns of the element
    slopes[range(4), range(4)] = 1.0
    slopes[1] += gamma
    slopes[3] += gamma

    fields = [field for (field,) in basis.basis]
    deflection = np.einsum("hie,hep->iep", slopes, [np.asarray(each) for each in fields])
    slope = np.einsum("hie,hep->iep", slopes, [each.grad[0] for each in fields])
    bend = np.einsum("hie,hep->iep", slopes, [each.hess[0, 0] for each in fields])
    turned = slope - gamma[:, :, None]

    def assembled(left: FloatArray, density: FloatArray) -> FloatArray:
        blocks = np.einsum("iep,jep,ep->eij", left, left, density * weight)
        whole = np.zeros((2 * count + 2, 2 * count + 2))
        for element, block in enumerate(blocks):
            first = 2 * element
            whole[first : first + 4, first : first + 4] += block
        return whole

    strained = assembled(bend, young * inertia)
    spread = np.broadcast_to(gamma[:, :, None], deflection.shape)
    strained += assembled(
        spread, (sheared / length)[:, None] * length[:, None] * np.ones(outer.shape)
    )
    return ShaftMatrices(
        stiffness=strained,
        translation=assembled(deflection, density * area),
        rotation=assembled(turned, density * inertia),
    )


def cowper(bore: float, poisson_ratio: float) -> float:
    """Return the shear coefficient of a hollow circular section (Cowper 1966).

    Args:
        bore: inner diameter divided by outer diameter.
        poisson_ratio: Poisson's ratio.
    """
    square, nu = bore**2, poisson_ratio
    whole = (7.0 + 6.0 * nu) * (1.0 + square) ** 2 + (20.0 + 12.0 * nu) * square
    return 6.0 * (1.0 + nu) * (1.0 + square) ** 2 / whole
