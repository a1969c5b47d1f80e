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

A sketch describes one sector, whose radial line is on +x; the sector is repeated counter-clockwise.
`Sketch.case` makes a case, the input of the rest of the package; `Sketch.build` makes the beam
model only. Put the first tip on +x, because the force of an imbalance acts in that direction.
"""

from collections import defaultdict
from collections.abc import Iterable, Sequence
from typing import Any, get_args

from pydantic import ValidationError

from bladewhirl.models.case.case import Case, case_from
from bladewhirl.models.case.check import faults_of
from bladewhirl.models.case.sketch import SketchTable
from bladewhirl.models.geometry.beam_model import BeamModel
from bladewhirl.models.geometry.sketch_build import build_sketch
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.sections.rectangular import Section

Point = tuple[float, float]


class Sketch:
    """A bladed disk drawn as the parts of one sector, with changes in single sectors.

    Values are numbers in SI units, or text with a unit. Sectors are numbered from 0
    counter-clockwise. The argument ``sectors`` of a part lists the sectors that have this part;
    None means all.

    Args:
        sectors: number of sectors of the bladed disk.
        tip_radius: radius from which the clearance is measured [m]; if None, the radius of the
            outermost tip.

    Raises:
        CaseError: a value is invalid, at the call that draws the part; or parts do not fit
            together, when `case`, `build` or `table` is used.
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
            CaseError: parts that do not fit together; the error names each part.
        """
        parts = {name: tuple(items) for name, items in self._parts.items()} | self._head
        try:
            return SketchTable(**parts)
        except ValidationError as error:
            raise CaseError(faults_of(error, parts, "sketch")) from None

    def case(self, **tables: Any) -> Case:
        """Return a case with this bladed disk; the rest of the package takes cases as input.

        Args:
            tables: other tables of the case, such as ``march={"speed": 1.2, "duration": "0.5 s"}``,
                and its title; the default title is "Sketch of 17 sectors" for 17 sectors.

        Raises:
            CaseError: the case is invalid; the error lists all faults.
        """
        table = self.table
        return case_from({"title": f"Sketch of {table.sectors} sectors", **tables, "sketch": table})

    def build(self) -> BeamModel:
        """Return the beam model of all sectors.

        Raises:
            CaseError: parts that do not fit together; the error names each part.
        """
        return build_sketch(self.table)

    def node(self, name: str, x: float | str, y: float | str = 0.0, *, shared: bool = False) -> str:
        """Add a node to each sector, or a single node that all sectors share.

        Args:
            name: name of the node.
            x: coordinate in sector 0 [m].
            y: coordinate in sector 0 [m].
            shared: make a single node that all sectors share.

        Returns:
            the name.
        """
        self._add("nodes", name, name=name, at=(x, y), shared=shared)
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
        """Add a member: beams along a straight or curved centre line between two nodes.

        Args:
            name: name of the member.
            first: node at the start.
            second: node at the end; "root+1" is the node "root" of the next sector.
            section: section of the beams. A sequence of sections is placed at equal distances from
                end to end, with linear interpolation between.
            elements: number of beams, which have equal lengths.
            path: points of a smooth centre line between the nodes, in the coordinates of sector 0
                [m].
            part: name of the line set of the beams, which several members may share; if None, the
                name of the member.
            sectors: sectors that have the member.
        """
        self._add(
            "members",
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
        """Add a point mass [kg] with a rotary inertia [kg m2] at a node."""
        chosen = _chosen(sectors)
        self._add("masses", node, node=node, mass=mass, inertia=inertia, sectors=chosen)

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
        """Add a spring between two nodes, or between a node and the rotating frame.

        Args:
            node: first node.
            other: second node; None for the rotating frame.
            radial: stiffness along the radius of ``node``; along x if ``node`` is at the origin
                [N/m].
            tangential: stiffness across this radius; along y if ``node`` is at the origin [N/m].
            rotation: stiffness against rotation [N m/rad].
            sectors: sectors that have the spring.
        """
        self._add(
            "springs",
            node,
            node=node,
            other=other,
            radial=radial,
            tangential=tangential,
            rotation=rotation,
            sectors=_chosen(sectors),
        )

    def link(self, leader: str, led: str, *, sectors: Iterable[int] | None = None) -> None:
        """Add a rigid link: a rigid arm connects the node ``led`` to the node ``leader``."""
        self._add("links", led, leader=leader, led=led, sectors=_chosen(sectors))

    def set(self, name: str, *nodes: str) -> None:
        """Define a set of nodes; ``tips`` (in blade order) and ``centre`` are needed."""
        self._add("sets", name, name=name, nodes=nodes)

    def move(self, sector: int, node: str, x: float | str, y: float | str = 0.0) -> None:
        """Move a node of one sector to new coordinates [m], given in the axes of sector 0."""
        self._add("edits", node, sector=sector, node=node, at=(x, y))

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
        """Change a member in one sector.

        Args:
            sector: number of the sector.
            member: name of the member.
            stiffness: factor on Young's modulus of the member.
            mass: factor on the density of the member.
            section: new section or sections; None keeps the sections of the member.
            path: new points of the centre line [m]; None keeps the points of the member.

        Raises:
            CaseError: an invalid value.
        """
        self._add(
            "edits",
            member,
            sector=sector,
            member=member,
            stiffness=stiffness,
            mass=mass,
            **_sections(section),
            path=None if path is None else tuple(map(tuple, path)),
        )

    def _add(self, kind: str, called: str, /, **values: Any) -> None:
        part, _ = get_args(SketchTable.model_fields[kind].annotation)  # a tuple of parts
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
