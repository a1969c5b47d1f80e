"""Make a beam model of a sketch: repeat its sector, divide members into elements, check parts."""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import pairwise
from typing import TypeVar

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray, LineMesh, points_along
from bladewhirl.meshes.plane import rotate
from bladewhirl.meshes.symmetry import rotational_sectors
from bladewhirl.models.case.sketch import (
    Part,
    SketchEdit,
    SketchMember,
    SketchTable,
    split_reference,
)
from bladewhirl.models.geometry.beam_model import (
    GROUND,
    BeamModel,
    NodeSprings,
    PointMasses,
    RigidLinks,
    check_model,
)
from bladewhirl.models.inputs.errors import CaseError, Fault
from bladewhirl.models.sections.rectangular import (
    CHANGES,
    QUANTITIES,
    LineProperties,
    along_elements,
)

PartT = TypeVar("PartT", bound=Part)

Key = tuple[str, int]
"""Identifier of a node in a sector: its name and 0, or the name of a member and the number of the
node along the member."""

CENTRE = "centre"

SHORTEST = 1e-12
"""Two points of a member coincide up to this fraction of the distance of its farthest point from
the origin."""


def build_sketch(sketch: SketchTable) -> BeamModel:
    """Repeat a sketch sector by sector and make a beam model of it.

    Nodes are numbered sector by sector, in the order in which members use them; shared nodes come
    last. If sectors differ or have several blades, equal sectors with one blade each are searched
    for in the complete mesh.

    Raises:
        CaseError: parts that do not fit together; the error names each part.
    """
    drawing = _Drawing(sketch)
    mesh, properties = drawing.mesh(), drawing.properties()
    model = BeamModel(
        mesh=mesh,
        properties=properties,
        masses=drawing.masses(),
        springs=drawing.springs(),
        links=drawing.links(),
        tip_radius=sketch.radius,
    )
    check_model(model, "sketch")
    if mesh.sectors is not None and len(mesh.sectors) == len(model.tips):
        return model
    sectors = rotational_sectors(mesh.points, model.joints, model.tips, model.centre)
    if sectors is None:
        return model
    return replace(model, mesh=replace(mesh, sectors=sectors))


class _Drawing:
    """Nodes and lines of all sectors of a sketch, numbered and with positions."""

    def __init__(self, sketch: SketchTable) -> None:
        self._sketch = sketch
        self._sets = sketch.node_sets
        self._alpha = 2.0 * np.pi / sketch.sectors
        self._nodes = {node.name: node for node in sketch.nodes}
        self._moved = {(e.sector, e.node): e for e in sketch.edits if e.node is not None}
        self._changed = {(e.sector, e.member): e for e in sketch.edits if e.member is not None}
        self._number: dict[tuple[int, Key], int] = {}
        self._point: list[FloatArray] = []
        self._axis: list[float] = []
        self._lines: dict[str, list[tuple[int, int]]] = {}
        self._sections: dict[str, list[FloatArray]] = {}
        self._tables = {each.name: _table(each, each.elements) for each in sketch.members}
        self._shared: list[tuple[int, Key]] = []
        self._own: list[list[Key]] = [[] for _ in range(sketch.sectors)]
        for sector in range(sketch.sectors):
            self._number_sector(sector)
        for place in self._shared:
            self._put(place, self._at(*place))
        for member in sketch.members:
            for sector in self._sectors_of(member):
                self._lay(member, sector)

    def mesh(self) -> LineMesh:
        """Return the mesh of all nodes and lines, with sets, and with sectors if they are equal."""
        sets = {
            name: [self._at_node(node, s) for s in range(self._sketch.sectors) for node in nodes]
            for name, nodes in self._sets.items()
        }
        lines, count = [], 0
        line_sets: dict[str, list[int]] = {}
        for member in self._sketch.members:
            member_lines = self._lines.get(member.name, [])
            lines += member_lines
            line_sets.setdefault(member.line_set, []).extend(
                range(count, count + len(member_lines))
            )
            count += len(member_lines)
        return LineMesh(
            points=np.array(self._point).reshape(-1, 2),
            lines=np.array(lines, dtype=np.int64).reshape(-1, 2),
            node_axes=np.array(self._axis),
            node_sets={name: np.array([*dict.fromkeys(nodes)]) for name, nodes in sets.items()},
            line_sets={name: np.array(member_lines) for name, member_lines in line_sets.items()},
            sectors=self._alike(),
        )

    def properties(self) -> LineProperties:
        """Return the sections of all lines."""
        sections = [
            s for member in self._sketch.members for s in self._sections.get(member.name, [])
        ]
        names = (*QUANTITIES, *CHANGES)
        return LineProperties(**dict(zip(names, np.hstack(sections), strict=True)))

    def masses(self) -> PointMasses:
        """Return the point masses of all sectors."""
        masses = [
            (*nodes, mass.mass, mass.inertia) for mass, nodes in self._each(self._sketch.masses)
        ]
        node, mass, inertia = np.array(masses).reshape(-1, 3).T
        return PointMasses(node=node.astype(np.int64), mass=mass, inertia=inertia)

    def springs(self) -> NodeSprings:
        """Return the springs of all sectors."""
        ends, stiffness = [], []
        for spring, nodes in self._each(self._sketch.springs):
            ends.append([*nodes, GROUND][:2])
            stiffness.append((spring.radial, spring.tangential, spring.rotation))
        node, other = np.array(ends, dtype=np.int64).reshape(-1, 2).T
        return NodeSprings(node=node, other=other, stiffness=np.array(stiffness).reshape(-1, 3))

    def links(self) -> RigidLinks:
        """Return the rigid links of all sectors."""
        links = [nodes for _, nodes in self._each(self._sketch.links)]
        leader, led = np.array(links, dtype=np.int64).reshape(-1, 2).T
        return RigidLinks(led=led, leader=leader)

    def _number_sector(self, sector: int) -> None:
        """Number the nodes that belong to a sector, in the order in which members use them."""
        for member in self._sketch.members:
            if sector not in self._sectors_of(member):
                continue
            points = self._line_of(member, sector)
            repeated = not self._sketch.is_shared(*member.references)
            ends = (self._place(member.first, sector), self._place(member.second, sector))
            self._meet(ends[0], sector)
            for i, point in enumerate(points[1:-1]):
                key = (member.name, i + 1)
                if repeated:
                    self._own[sector].append(key)
                self._put((sector, key), point)
            self._meet(ends[1], sector)
        for name in self._nodes:
            self._meet(self._place(name, sector), sector)

    def _meet(self, place: tuple[int, Key], sector: int) -> None:
        if place in self._number:
            return
        if self._nodes[place[1][0]].shared:
            if place not in self._shared:
                self._shared.append(place)
        elif place[0] == sector:
            self._own[sector].append(place[1])
            self._put(place, self._at(*place))

    def _put(self, place: tuple[int, Key], point: FloatArray) -> None:
        self._number[place] = len(self._point)
        self._point.append(point)
        self._axis.append(float(np.arctan2(point[1], point[0])) if point.any() else 0.0)

    def _lay(self, member: SketchMember, sector: int) -> None:
        between = [self._number[sector, (member.name, i)] for i in range(1, member.elements)]
        chain = [
            self._at_node(member.first, sector),
            *between,
            self._at_node(member.second, sector),
        ]
        self._lines.setdefault(member.name, []).extend(pairwise(chain))
        edit = self._changed.get((sector, member.name))
        if edit is not None and _sections(edit):
            table = _table(edit, member.elements)
        else:
            table = self._tables[member.name].copy()
        if edit is not None:
            for name, factor in (("young_modulus", edit.stiffness), ("density", edit.mass)):
                table[[QUANTITIES.index(name), len(QUANTITIES) + QUANTITIES.index(name)]] *= factor
        self._sections.setdefault(member.name, []).append(table)

    def _line_of(self, member: SketchMember, sector: int) -> FloatArray:
        """Return the points at the ends of the elements of a member [m], (elements + 1, 2)."""
        edit = self._changed.get((sector, member.name))
        path = member.path if edit is None or edit.path is None else edit.path
        given = [
            self._at(*self._place(member.first, sector)),
            *(rotate(point, sector * self._alpha) for point in path),
            self._at(*self._place(member.second, sector)),
        ]
        points = np.array(given)
        steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
        if not steps.min() > SHORTEST * np.abs(points).max():
            expected = "different consecutive points of the member; two of them coincide"
            key = f"sketch: member {member.name!r} in sector {sector}"
            raise CaseError([Fault(key=key, expected=expected)])
        return points_along(points, member.elements)

    def _at(self, sector: int, key: Key) -> FloatArray:
        """Return the position of a named node in a sector [m], (2,)."""
        edit = self._moved.get((sector, key[0]))
        at = self._nodes[key[0]].at if edit is None or edit.at is None else edit.at
        return rotate(at, sector * self._alpha)

    def _place(self, reference: str, sector: int) -> tuple[int, Key]:
        name, shift = split_reference(reference)
        shared = self._nodes[name].shared
        return (0 if shared else (sector + shift) % self._sketch.sectors, (name, 0))

    def _at_node(self, reference: str, sector: int) -> int:
        return self._number[self._place(reference, sector)]

    def _each(self, parts: Iterable[PartT]) -> Iterator[tuple[PartT, list[int]]]:
        """Yield every part in each of its sectors, with the nodes to which it refers."""
        for part in parts:
            for sector in self._sectors_of(part):
                yield part, [self._at_node(name, sector) for name in part.references]

    def _sectors_of(self, part: Part) -> Iterable[int]:
        """Return the sectors that have a part; a part between shared nodes exists only once."""
        if self._sketch.is_shared(*part.references):
            return range(1)
        return range(self._sketch.sectors) if part.sectors is None else part.sectors

    def _alike(self) -> np.ndarray[tuple[int, ...], np.dtype[np.int64]] | None:
        """Return the nodes of each sector, in the same order, (sectors, nodes per sector).

        None if sectors have different nodes, if there are fewer than three sectors, or if nodes
        other than the centre are shared.
        """
        order = self._own[0]
        shared = [key[0] for _, key in self._shared]
        only_centre = shared == [*self._sets[CENTRE]]
        if len(self._own) < 3 or not only_centre or not order:
            return None
        if any(set(numbers) != set(order) for numbers in self._own[1:]):
            return None
        return np.array(
            [[self._number[sector, key] for key in order] for sector in range(len(self._own))]
        )


def _sections(part: SketchMember | SketchEdit) -> tuple:  # type: ignore[type-arg]
    return part.stations or (() if part.section is None else (part.section,))


def _table(part: SketchMember | SketchEdit, elements: int) -> FloatArray:
    """Return the sections of equal elements: rows of quantities, then of changes, (8, elements)."""
    return np.vstack(along_elements(_sections(part), elements))
