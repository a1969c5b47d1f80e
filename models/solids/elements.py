"""Finite elements of solids by their names in Abaqus and CalculiX: C3D4 to C3D20R.

An element has functions for its shape and for displacements, and quadrature points. The functions
are elements of scikit-fem, or have its interface `skfem.element.Element`.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from skfem import (
    Basis,
    ElementHex1,
    ElementHex2,
    ElementHexS2,
    ElementTetP1,
    ElementTetP2,
    ElementWedge1,
)
from skfem.element import DiscreteField
from skfem.element.element_h1 import ElementH1
from skfem.quadrature import get_quadrature
from skfem.refdom import RefHex, RefLine, RefTet, RefTri, RefWedge

from bladewhirl.meshes.cells import CELL_TYPES, CellType
from bladewhirl.meshes.line_mesh import FloatArray, IntArray

Rule = tuple[FloatArray, FloatArray]
"""Points, (3, points), and weights, (points,), of a quadrature in the reference cell."""

CENTRE = np.full((3, 1), 0.5)


class Mapping:
    """Map from the reference cell to cells, with the interface of `skfem.mapping.Mapping` as far as
    forms need it.

    Args:
        shape: element whose functions describe the shape.
        positions: positions of the nodes of each cell in the order of the element, (cells, nodes,
            3).
    """

    def __init__(self, shape: Any, positions: FloatArray) -> None:
        self._shape, self._positions = shape, positions
        self._last: tuple[Any, FloatArray, FloatArray] | None = None

    # The names are those of scikit-fem.
    def F(self, X: FloatArray, tind: None = None) -> FloatArray:
        """Return positions, (3, cells, points)."""
        values = [self._shape.lbasis(X, n)[0] for n in range(self._positions.shape[1])]
        return np.asarray(np.einsum("eni,nq->ieq", self._positions, values))

    def detDF(self, X: FloatArray, tind: None = None) -> FloatArray:
        """Return determinants of the Jacobian matrices, (cells, points)."""
        return self._at(X)[0]

    def invDF(self, X: FloatArray, tind: None = None) -> FloatArray:
        """Return inverses of the Jacobian matrices, (3, 3, cells, points)."""
        return self._at(X)[1]

    def _at(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        if self._last is None or self._last[0] is not points:
            slopes = [
                np.broadcast_to(self._shape.lbasis(points, n)[1], points.shape)
                for n in range(self._positions.shape[1])
            ]
            jacobian = np.einsum("eni,njq->eqij", self._positions, slopes, optimize=True)
            determinant = np.linalg.det(jacobian)
            flat = (determinant == 0.0)[..., None, None] * np.eye(3)  # cells without a volume
            inverse = np.moveaxis(np.linalg.inv(jacobian + flat), (2, 3), (0, 1))
            self._last = (points, determinant, inverse)
        return self._last[1:]


class ElementWedge2(ElementH1):  # type: ignore[misc]  # scikit-fem has no types
    """Wedge with 15 nodes, quadratic in the triangle and along the edges."""

    nodal_dofs, edge_dofs, maxdeg = 1, 1, 4
    dofnames = ("u", "u")
    refdom = RefWedge
    doflocs = CELL_TYPES["wedge15"].reference

    def lbasis(self, X: FloatArray, i: int) -> tuple[FloatArray, FloatArray]:
        """Return values, (points,), and gradients, (3, points), of function i."""
        x, y, z = X[0], X[1], 2.0 * X[2] - 1.0
        areas = np.array([1.0 - x - y, x, y])
        slopes = np.array([[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]])
        bubble, side = 1.0 - z**2, -1.0 if i < 3 or 6 <= i < 9 else 1.0
        if i < 6:
            area, slope = areas[i % 3], slopes[i % 3]
            end, plane = 0.5 * (1.0 + side * z), area * (2.0 * area - 1.0)
            value = plane * end - 0.5 * area * bubble
            across = (4.0 * area - 1.0) * end - 0.5 * bubble
            along = 0.5 * side * plane + area * z
        elif i < 12:
            a, b = i % 3, (i + 1) % 3
            value = 2.0 * areas[a] * areas[b] * (1.0 + side * z)
            slope = slopes[a][:, None] * areas[b] + slopes[b][:, None] * areas[a]
            across = 2.0 * (1.0 + side * z)
            along = 2.0 * side * areas[a] * areas[b]
            return value, np.array([*(slope * across), 2.0 * along])
        else:
            area, slope = areas[i - 12], slopes[i - 12]
            value, across, along = area * bubble, bubble, -2.0 * area * z
        return value, np.array([slope[0] * across, slope[1] * across, 2.0 * along])


class ElementHexMean(ElementHex1):  # type: ignore[misc]
    """Hexahedron with 8 nodes whose functions have their mean gradient in the cell (Flanagan and
    Belytschko 1981, equation 16) and the value 1/8 everywhere."""

    def gbasis(
        self, mapping: Mapping, X: FloatArray, i: int, tind: None = None
    ) -> tuple[DiscreteField]:
        """Return function i; the weights of the points must be equal."""
        volume = mapping.detDF(X)
        slope = np.asarray(super().gbasis(mapping, X, i)[0].grad) * volume
        mean = slope.sum(axis=-1, keepdims=True) / volume.sum(axis=-1, keepdims=True)
        field = DiscreteField(
            value=np.full(volume.shape, 0.125), grad=np.broadcast_to(mean, slope.shape)
        )
        return (field,)


class ElementHexIncompatible(ElementHex1):  # type: ignore[misc]
    """Hexahedron with 8 nodes and the incompatible modes 1 - x^2, 1 - y^2 and 1 - z^2 of Wilson,
    whose gradients are those at the centre of the cell, as in CalculiX."""

    def gbasis(
        self, mapping: Mapping, X: FloatArray, i: int, tind: None = None
    ) -> tuple[DiscreteField]:
        """Return function i, from 8 an incompatible mode."""
        if i < 8:
            return tuple(super().gbasis(mapping, X, i))
        at_centre = mapping.invDF(CENTRE)[i - 8]
        place = 2.0 * X[i - 8] - 1.0
        value = np.broadcast_to(1.0 - place**2, mapping.detDF(X).shape)
        return (DiscreteField(value=value, grad=at_centre * (-4.0 * place)),)


class Unknowns(NamedTuple):
    """Unknowns of the functions of each cell, with the interface of `skfem.assembly.Dofs`."""

    element_dofs: IntArray  #: (functions, cells)
    N: int  #: number of unknowns


class _Cells(NamedTuple):
    """Interface of a mesh of scikit-fem, without nodes."""

    refdom: Any
    nelements: int

    def dim(self) -> int:
        return 3


@dataclass(frozen=True, kw_only=True)
class ElementType:
    """Finite element of one name."""

    cell_type: str  #: shape of the cell, one of `CELL_TYPES`
    shape: type[Any]  #: functions of the shape
    functions: type[Any]  #: functions of the displacements in the stiffness
    stiffness_rule: Rule  #: quadrature of the stiffness
    mass_functions: type[Any]  #: functions of the displacements in the mass
    mass_rule: Rule  #: quadrature that is exact for the mass of cells with plane faces
    internal: int = 0  #: number of functions that belong to no node
    reduced: float = 0.0
    """Share of the mass with the quadrature of the stiffness. The mass of C3D8R with one point is
    singular; the share of the full mass makes it positive definite."""
    hourglass: bool = False  #: true for a stiffness against hourglass modes

    @property
    def cell(self) -> CellType:
        """Shape of the cell."""
        return CELL_TYPES[self.cell_type]

    @property
    def first_order(self) -> bool:
        """Whether the element is too stiff in bending."""
        return self.functions in (ElementTetP1, ElementWedge1, ElementHex1)

    @cached_property
    def order(self) -> IntArray:
        """Node of a cell of each function of the shape, (nodes,)."""
        places = {tuple(place): number for number, place in enumerate(self.cell.reference.tolist())}
        return np.array([places[tuple(place)] for place in self.shape.doflocs.tolist()])

    def nodes_of(self, unknowns: Unknowns) -> IntArray:
        """Return the nodes of each cell in the order of `order`, (nodes, cells)."""
        return unknowns.element_dofs[: len(self.order)]

    def basis(
        self, positions: FloatArray, unknowns: Unknowns, rule: Rule, functions: type[Any]
    ) -> Basis:
        """Return the functions at the points of a quadrature.

        Args:
            positions: positions of the nodes of each cell in the order of `order`.
            unknowns: unknowns of the functions.
            rule: quadrature.
            functions: `shape` or `functions`.
        """
        return Basis(
            _Cells(self.shape.refdom, len(positions)),
            functions(),
            mapping=Mapping(self.shape(), positions),
            quadrature=rule,
            dofs=unknowns,
            disable_doflocs=True,
        )


def _wedge(triangle: int, line: int) -> Rule:
    """Return a quadrature of a wedge that is exact to given degrees in the triangle and along."""
    plane, areas = get_quadrature(RefTri, triangle)
    heights, lengths = get_quadrature(RefLine, line)
    points = [(*place, height) for height in heights[0] for place in plane.T]
    return np.array(points).T, np.outer(lengths, areas).ravel()


_TETRA = {order: get_quadrature(RefTet, order) for order in (1, 2, 6)}
_CUBE = {order: get_quadrature(RefHex, order) for order in (3, 5)}
_HEIGHTS, _LENGTHS = get_quadrature(RefLine, 3)
_TWO_POINTS = np.array([*np.full((2, 2), 1.0 / 3.0), _HEIGHTS[0]]), 0.5 * _LENGTHS


def _element(
    cell_type: str, shape: type[Any], stiffness: Rule, mass: Rule, **more: Any
) -> ElementType:
    return ElementType(
        **{"functions": shape, "mass_functions": shape} | more,
        cell_type=cell_type,
        shape=shape,
        stiffness_rule=stiffness,
        mass_rule=mass,
    )


ELEMENTS = {
    "C3D4": _element("tetra", ElementTetP1, _TETRA[1], _TETRA[2]),
    "C3D6": _element("wedge", ElementWedge1, _TWO_POINTS, _wedge(2, 3)),
    "C3D8": _element("hexahedron", ElementHex1, _CUBE[3], _CUBE[3]),
    "C3D8I": _element(
        *("hexahedron", ElementHex1, _CUBE[3], _CUBE[5]),
        functions=ElementHexIncompatible,
        mass_functions=ElementHexIncompatible,
        internal=3,
    ),
    "C3D8R": _element(
        *("hexahedron", ElementHex1, _CUBE[3], _CUBE[3]),
        functions=ElementHexMean,
        reduced=0.99,
        hourglass=True,
    ),
    "C3D10": _element("tetra10", ElementTetP2, _TETRA[2], _TETRA[6]),
    "C3D15": _element("wedge15", ElementWedge2, _wedge(2, 5), _wedge(6, 5)),
    "C3D20": _element("hexahedron20", ElementHexS2, _CUBE[5], _CUBE[5]),
    "C3D20R": _element("hexahedron20", ElementHexS2, _CUBE[3], _CUBE[5], reduced=1.0),
    "C3D27": _element("hexahedron27", ElementHex2, _CUBE[5], _CUBE[5]),
}
"""Elements by name. Their stiffness has the usual quadratures: 1 and 4 points for tetrahedra, 2 and
9 for wedges, 2 x 2 x 2 and 3 x 3 x 3 for hexahedra, 2 x 2 x 2 for C3D20R."""
