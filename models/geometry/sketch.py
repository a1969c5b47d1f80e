"""A bladed disk drawn in Python: nodes and members between them, sector by sector.

    sketch = Sketch(sectors=22)
    sketch.node("centre", 0.0, 0.0, shared=True)
    sketch.node("root", 0.05)
    sketch.node("tip", 0.5)
    sketch.member("blades", "root", "tip", blade, elements=10)
    sketch.member("spokes", "centre", "root", disk)
    sketch.member("rim", "root", "root+1", disk)
    sketch.set("centre", "centre")
    sketch.set("tips", "tip")

What is drawn is one sector, its radial line on +x; it is repeated counter-clockwise. `Sketch.case`
puts it into a case, which everything else works on; `Sketch.build` makes the beam model alone. The
first tip belongs on +x: an imbalance pulls that way.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from typing import Any

from pydantic import ValidationError

from bladewhirl.models.case.case import Case
from bladewhirl.models.case.check import case_from, faults_of
from bladewhirl.models.case.sketch import SketchTable
from bladewhirl.models.case.sketch_parts import (
    SketchEdit,
    SketchLink,
    SketchMass,
    SketchMember,
    SketchNode,
    SketchSet,
    SketchSpring,
)
from bladewhirl.models.geometry.beam_model import BeamModel
from bladewhirl.models.geometry.sketch_build import build_sketch
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.sections.rectangular import Section

Point = tuple[float, float]


class Sketch:
    """Gathers the parts of one sector and the differences of some sectors.

    Lengths are numbers in metres or text with a unit, and so with all that has one. Sectors are
    numbered from 0 counter-clockwise; ``sectors`` of a part are those that have it, None for all.

    Args:
        sectors: of the bladed disk.
        tip_radius: from which the clearance counts; the largest of the tips' own when None.

    Raises:
        CaseError: a value that is none, as each part is drawn; parts that do not fit together show
            when the sketch is put into a case or built.
    """

    def __init__(self, sectors: int = 1, *, tip_radius: float | str | None = None) -> None:
        self._head: dict[str, Any] = {"sectors": sectors}
        if tip_radius is not None:
            self._head["tip_radius"] = tip_radius
        self._parts: defaultdict[str, list[Any]] = defaultdict(list)

    @property
    def table(self) -> SketchTable:
        """The sketch in the form that a case contains.

        Raises:
            CaseError: parts that do not fit together, each named.
        """
        parts = {name: tuple(items) for name, items in self._parts.items()} | self._head
        try:
            return SketchTable(**parts)
        except ValidationError as error:
            raise CaseError(faults_of(error, parts, "sketch")) from None

    def case(self, **tables: Any) -> Case:
        """Return a case with this bladed disk, the input of the rest of the package.

        Args:
            tables: the other tables of a case, ``march={"speed": 1.2, "duration": "0.5 s"}``, and
                its title, "Sketch of 17 sectors" and the like when there is none.

        Raises:
            CaseError: all faults of the tables.
        """
        table = self.table
        return case_from({"title": f"Sketch of {table.sectors} sectors", **tables, "sketch": table})

    def build(self) -> BeamModel:
        """The beam model of all sectors.

        Raises:
            CaseError: parts that do not fit together, each named.
        """
        return build_sketch(self.table)

    def node(self, name: str, x: float | str, y: float | str = 0.0, *, shared: bool = False) -> str:
        """Put a node into each sector, or one for all; returns its name."""
        self._add("nodes", SketchNode, name, name=name, at=(x, y), shared=shared)
        return name

    def member(
        self,
        name: str,
        first: str,
        second: str,
        section: Section | Sequence[Section] | None = None,
        *,
        elements: int = 1,
        path: Iterable[Sequence[float | str]] = (),
        part: str | None = None,
        sectors: Iterable[int] | None = None,
    ) -> None:
        """Lay beams between two nodes.

        Args:
            name: of the member.
            first: node that it starts at.
            second: node that it ends at; "root+1" is the one of the next sector.
            section: of its beams; a sequence is spread evenly from end to end, linear in between.
            elements: number of beams, equally long.
            path: points of a smooth centre line between the nodes [m], as in sector 0.
            part: name of the line set, for members that make up one; that of the member if None.
            sectors: that have it.
        """
        self._add(
            "members",
            SketchMember,
            name,
            name=name,
            first=first,
            second=second,
            **_sections(section),
            elements=elements,
            path=tuple(map(tuple, path)),
            part=part,
            sectors=_chosen(sectors),
        )

    def mass(
        self,
        node: str,
        mass: float | str,
        *,
        inertia: float | str = 0.0,
        sectors: Iterable[int] | None = None,
    ) -> None:
        """Hang a point mass [kg], with a rotary inertia [kg m2], on a node."""
        chosen = _chosen(sectors)
        self._add("masses", SketchMass, node, node=node, mass=mass, inertia=inertia, sectors=chosen)

    def spring(
        self,
        node: str,
        other: str | None = None,
        *,
        radial: float | str = 0.0,
        tangential: float | str = 0.0,
        rotation: float | str = 0.0,
        sectors: Iterable[int] | None = None,
    ) -> None:
        """Join two nodes, or a node and the rotating frame, by a spring [N/m, N m/rad].

        Its directions are the radius of ``node`` and across it, x and y at the origin.
        """
        self._add(
            "springs",
            SketchSpring,
            node,
            node=node,
            other=other,
            radial=radial,
            tangential=tangential,
            rotation=rotation,
            sectors=_chosen(sectors),
        )

    def link(self, leader: str, led: str, *, sectors: Iterable[int] | None = None) -> None:
        """Let a node lead another as if on a rigid arm."""
        self._add("links", SketchLink, led, leader=leader, led=led, sectors=_chosen(sectors))

    def set(self, name: str, *nodes: str) -> None:
        """Name nodes; ``tips`` (blade by blade) and ``centre`` are needed."""
        self._add("sets", SketchSet, name, name=name, nodes=nodes)

    def move(self, sector: int, node: str, x: float | str, y: float | str = 0.0) -> None:
        """Put a node of one sector elsewhere; coordinates as in sector 0 [m]."""
        self._add("edits", SketchEdit, node, sector=sector, node=node, at=(x, y))

    def change(
        self,
        sector: int,
        member: str,
        *,
        stiffness: float = 1.0,
        mass: float = 1.0,
        section: Section | Sequence[Section] | None = None,
        path: Iterable[Sequence[float | str]] | None = None,
    ) -> None:
        """Make a member of one sector otherwise.

        Args:
            sector: which one.
            member: its name.
            stiffness: factor on Young's modulus.
            mass: factor on the density.
            section: instead of the member's own.
            path: instead of the member's own.

        Raises:
            CaseError: a value that is none.
        """
        self._add(
            "edits",
            SketchEdit,
            member,
            sector=sector,
            member=member,
            stiffness=stiffness,
            mass=mass,
            **_sections(section),
            path=None if path is None else tuple(map(tuple, path)),
        )

    def _add(self, kind: str, part: Any, called: str, /, **values: Any) -> None:
        try:
            self._parts[kind].append(part(**values))
        except ValidationError as error:
            raise CaseError(faults_of(error, values, f"sketch.{kind} {called!r}")) from None


def _sections(section: Section | Sequence[Section] | None) -> dict[str, Any]:
    if section is None or isinstance(section, Section):
        return {"section": section}
    return {"stations": tuple(section)}


def _chosen(sectors: Iterable[int] | None) -> tuple[int, ...] | None:
    return None if sectors is None else tuple(sectors)
