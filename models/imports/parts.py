"""Matrices and nodes of a part as another program wrote them, and the superelement made of them."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import ClassVar

import numpy as np
import scipy.sparse as sp

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.inputs.units import to_si
from bladewhirl.models.solids.groups import (
    AXES,
    chosen_nodes,
    clamped_on_both,
    contact_nodes,
    free_faces,
    listed,
    matching_faces,
    sector_faces,
)
from bladewhirl.models.solids.positions import EXAMPLE
from bladewhirl.models.structure.rotating import Rotating
from bladewhirl.models.superelements.hub import tied_to_hub
from bladewhirl.models.superelements.superelement import (
    FIXED,
    HUB,
    Matrix,
    Superelement,
    SuperelementError,
    errors_of,
)


@dataclass(frozen=True, kw_only=True)
class ForeignPart(Rotating[Matrix]):
    """Matrices and nodes of a part, in the units and axes of their program."""

    source: str  #: program and files, for messages and for the superelement
    FORMS: ClassVar[tuple[str, ...]] = Superelement.FORMS

    blade_stiffness: Matrix | None = None  #: part of the stiffness of the blades, (n, n)
    numbers: IntArray  #: number of each node in the program, (nodes,)
    points: FloatArray  #: positions of the nodes, (nodes, 3)
    dofs: IntArray
    """Row of the x, y and z displacement of each node, from 0; -1 where it is fixed, (nodes, 3)."""
    groups: Mapping[str, IntArray] = field(default_factory=dict)  #: name -> positions in `numbers`
    surface: IntArray | None = None  #: corners of surface triangles, positions in `numbers`, (t, 3)

    def __post_init__(self) -> None:
        size = self.size
        outside = self.dofs[(self.dofs != FIXED) & ((self.dofs < 0) | (self.dofs >= size))]
        if len(outside):
            raise SuperelementError(
                f"{self.source}: expected rows of nodes up to {size}, the size of the mass,"
                f" got {int(outside.max()) + 1}"
            )

    def without(self, rows: IntArray) -> "ForeignPart":
        """Return the part without some rows and columns of its matrices, whose displacements are
        fixed; `FIXED` is ignored."""
        kept = np.setdiff1d(np.arange(self.size), rows)
        place = np.full(self.size + 1, FIXED)  # the last entry is for displacements that are fixed
        place[kept] = np.arange(len(kept))
        chosen = {key: matrix[kept][:, kept] for key, matrix in self.given(self.FORMS).items()}
        return replace(self, dofs=place[self.dofs], **chosen)

    def without_empty_rows(self) -> "ForeignPart":
        """Return the part without the rows that are zero in all matrices, such as those of the
        rotations of nodes of solids; `source` states their number."""
        used = sum(abs(matrix).sum(axis=1) for matrix in self.given(self.FORMS).values())
        empty = np.flatnonzero(used == 0.0)
        if not len(empty):
            return self
        source = f"{self.source}, without {len(empty)} empty rows"
        return replace(self.without(empty), source=source)

    def over_speeds(self, others: Mapping[float, Matrix]) -> "ForeignPart":
        """Return the part with the stiffness K0 at rest and its changes K1 and K2 by rotation, of
        the polynomial K0 + Omega^2 K1 + Omega^4 K2 through the stiffnesses at given speeds.

        Args:
            others: stiffness at one or two further speeds [rad/s]; the speed of `stiffness` is that
                of the part, or 0 if it is unknown. With one further speed K2 is left out.

        Raises:
            SuperelementError: speeds are equal, or a stiffness has another size.
        """
        given = {self.speed or 0.0: self.stiffness, **others}
        if len({speed**2 for speed in given}) <= len(others):
            raise SuperelementError(
                "at: expected speeds that differ from each other, and from speed"
            )
        for matrix in others.values():
            if matrix.shape != self.stiffness.shape:
                raise SuperelementError(
                    f"at: expected stiffnesses of the same size, {self.size}, got {matrix.shape[0]}"
                )
        squares = np.square(list(given))
        unit = squares.max()
        powers = np.linalg.inv(np.vander(squares / unit, increasing=True))
        terms = [
            sum(share * matrix for share, matrix in zip(row, given.values(), strict=True))
            / unit**power
            for power, row in enumerate(powers)
        ]
        names = ("stiffness", "stiffness_speed", "stiffness_speed4")
        return replace(self, speed=0.0, **dict(zip(names, terms, strict=False)))

    def nodes(self, key: str, given: str, axis: str) -> IntArray:
        """Return the positions in `numbers` of the nodes of a group, of nodes given by their
        numbers, separated by commas, or of those at which a condition on positions in m and about
        an axis of rotation holds.

        Raises:
            SuperelementError: the group or a node is unknown; the error names ``key``.
        """
        words = given.replace(",", " ").split()
        if words and all(word.isdecimal() for word in words):
            words = [word.lstrip("0") or "0" for word in words]
            place = {str(number): row for row, number in enumerate(self.numbers)}
            unknown = [word for word in words if word not in place]
            if unknown:
                raise SuperelementError(
                    f"{key} {given}: expected nodes of {self.source}, which has no node"
                    f" {', '.join(unknown[:5])}"
                )
            return np.array([place[word] for word in words], dtype=np.int64)
        try:
            nodes = chosen_nodes(self.groups, given, self.points, axis)
        except ValueError as error:
            raise SuperelementError(f"{key} {given}: expected {EXAMPLE} ({error})") from None
        if nodes is None:
            raise SuperelementError(
                f"{key} {given}: expected numbers of nodes, or a group of {self.source}:"
                f" {listed(self.groups)}; or {EXAMPLE}"
            )
        if not len(nodes):
            raise SuperelementError(f"{key} {given}: expected a group with nodes")
        return np.asarray(nodes)


@dataclass(frozen=True, kw_only=True)
class Choice:
    """Choices for the superelement of a part: contact nodes, faces, units and axis."""

    contact: str  #: group, or numbers of nodes
    clamped: str | None = None  #: group or numbers of nodes to clamp, if the program did not
    hub: str | None = None  #: group or numbers of nodes to tie to a hub, in place of clamped ones
    contacts: int | None = None  #: number of contact nodes along the chord; all by default
    left: str | None = None  #: group or numbers of the nodes of the clockwise face
    right: str | None = None  #: group or numbers of the nodes of the counter-clockwise face
    copies: int | None = None  #: number of sectors
    length_unit: str = "m"  #: unit of length; stiffness is in N per unit of length
    mass_unit: str = "kg"  #: unit of mass
    axis: str = "z"  #: axis of rotation, "x", "y" or "z"
    name: str = ""  #: name of the superelement


def superelement_from(part: ForeignPart, choice: Choice) -> tuple[Superelement, FloatArray]:
    """Return a superelement, and the unit translations of its coordinates along x, y and z, (3, n).

    Raises:
        SuperelementError: groups, units or matrices are invalid.
    """
    length, mass = _unit(choice.length_unit, "m"), _unit(choice.mass_unit, "kg")
    if choice.axis not in AXES:
        raise SuperelementError(f"axis {choice.axis}: expected x, y or z")
    name = choice.name or part.source
    part = replace(part.without_empty_rows(), points=length * part.points)
    if choice.clamped is not None:
        part = part.without(part.dofs[part.nodes("clamped", choice.clamped, choice.axis)])
    points = part.points[:, AXES[choice.axis]]
    fixed = np.flatnonzero((part.dofs == FIXED).all(axis=1))
    tied = fixed[:0] if choice.hub is None else part.nodes("hub", choice.hub, choice.axis)
    nodes: dict[str, IntArray] = {}
    with errors_of(part.source):
        group = part.nodes("contact", choice.contact, choice.axis)
        if (sides := sector_faces(choice.left, choice.right, choice.copies)) is not None:
            left, right = (
                part.nodes(key, side, choice.axis)
                for key, side in (("left", sides[0]), ("right", sides[1]))
            )
            faces = matching_faces(points, left, right, sides[2])
            fixed, note = clamped_on_both(*faces, fixed)
            part = replace(part.without(part.dofs[fixed]), source=f"{part.source}{note}")
            tied = clamped_on_both(*faces, tied)[0]
            nodes = free_faces(*faces, np.union1d(fixed, tied))
        touching = contact_nodes(points, group, choice.contacts, np.union1d(fixed, tied), sides)
    dofs = part.dofs[:, AXES[choice.axis]]
    shown = np.arange(len(points)) if part.surface is None else np.unique(part.surface)
    made = Superelement(
        **{key: mass * matrix for key, matrix in part.given(part.FORMS).items()},
        speed=part.speed,
        contact_position=points[touching],
        contact_dofs=dofs[touching],
        points=points[shown],
        recovery=_recovery(dofs[shown], part.size),
        triangles=None if part.surface is None else np.searchsorted(shown, part.surface),
        name=name,
        source=part.source,
        left_dofs=dofs[nodes["left_dofs"]] if nodes else None,
        right_dofs=dofs[nodes["right_dofs"]] if nodes else None,
        sectors=choice.copies if nodes else None,
    )
    along = np.zeros((3, part.size))
    for axis in range(3):
        along[axis, dofs[dofs[:, axis] != FIXED, axis]] = 1.0
    if choice.hub is None:
        return made, along
    with errors_of(part.source):
        return _on_hub(made, dofs, points, tied), _with_hub(along, dofs[tied])


def _on_hub(part: Superelement, dofs: IntArray, points: FloatArray, tied: IntArray) -> Superelement:
    """Return a free superelement with nodes tied to a hub, and with the Coriolis forces of its
    translations if it has none.

    Args:
        part: the superelement.
        dofs: numbers of the displacements of all nodes, (nodes, 3).
        points: their positions [m], (nodes, 3).
        tied: nodes that are tied.

    Raises:
        SuperelementError: a displacement of these nodes is fixed.
    """
    place, spin = np.zeros(part.size), sp.lil_array((part.size, part.size))
    for (x, y, _), (to_x, to_y, _) in zip(dofs.tolist(), points.tolist(), strict=True):
        if FIXED not in (x, y):
            place[[x, y]], spin[x, y], spin[y, x] = (to_x, to_y), -1.0, 1.0
    if part.gyroscopic is None:
        coriolis = 2.0 * (part.mass @ sp.csr_array(spin))
        part = replace(part, gyroscopic=0.5 * (coriolis - coriolis.T))
    centre = np.array([0.0, 0.0, points[tied, 2].mean()])
    return tied_to_hub(part, dofs[tied], points[tied] - centre, centre, place)


def _with_hub(along: FloatArray, tied: IntArray) -> FloatArray:
    """Return unit translations of all coordinates, (3, n), for those of a superelement with tied
    nodes, whose displacements are given, (nodes, 3)."""
    return np.hstack([np.delete(along, tied.ravel(), axis=1), np.eye(3, HUB)])


def _recovery(dofs: IntArray, size: int) -> sp.csr_array:
    row = np.flatnonzero(dofs.ravel() != FIXED)
    entries = np.ones(len(row)), (row, dofs.ravel()[row])
    return sp.csr_array(entries, shape=(dofs.size, size))


def _unit(given: str, unit: str) -> float:
    try:
        return to_si(f"1 {given}", unit)
    except ValueError as error:
        kind, example = ("length", "mm") if unit == "m" else ("mass", "t")
        raise SuperelementError(
            f'{kind}_unit {given}: expected a unit of {kind} such as "{example}" ({error})'
        ) from None
