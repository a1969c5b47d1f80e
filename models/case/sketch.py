"""Table of a case for a bladed disk drawn node by node, and checks that its parts fit together."""

import re
from collections import Counter
from collections.abc import Iterator
from functools import cached_property
from itertools import chain
from math import hypot
from typing import Annotated, ClassVar

from pydantic import StrictBool, StrictStr

from bladewhirl.models.inputs.fields import (
    Inertia,
    Length,
    Mass,
    Position,
    StiffnessOrZero,
    count,
    number,
    quantity,
    text,
)
from bladewhirl.models.inputs.rules import Inconsistency
from bladewhirl.models.inputs.table import Table
from bladewhirl.models.sections.rectangular import Section

_REFERENCE = re.compile(r"(?P<name>[A-Za-z_][\w ]*)(?P<shift>[+-]\d{1,6})?", re.ASCII)


def split_reference(reference: str) -> tuple[str, int]:
    """Split a reference into the name of the node and the offset of its sector."""
    match = _REFERENCE.fullmatch(reference)
    assert match is not None  # references are validated
    return match["name"], int(match["shift"] or 0)


Chosen = tuple[int, ...] | None  #: sectors that have a part; None for all

Name = Annotated[
    str,
    text(
        re.compile(r"[A-Za-z_][\w ]*", re.ASCII),
        'a name of letters, digits, spaces and underscores such as "blade root"',
    ),
]
Reference = Annotated[
    str, text(_REFERENCE, 'the name of a node, such as "root", or "root+1" in the next sector')
]
Factor = Annotated[float, number("positive")]


class SketchNode(Table):
    """A node."""

    name: Name
    at: Position  #: x and y, or radius and angle, in sector 0 [m]
    shared: StrictBool = False  #: one node for all sectors


class SketchPart(Table):
    """A part that refers to nodes."""

    title: ClassVar[str]  #: beginning of the name of the part in messages
    called: ClassVar[str] = "node"  #: key whose value completes this name
    ends: ClassVar[tuple[str, ...]]  #: keys of the nodes to which the part refers

    @property
    def place(self) -> str:
        """Name of the part in messages."""
        return f"{self.title} {getattr(self, self.called)!r}"

    @property
    def references(self) -> tuple[str, ...]:
        """Nodes to which the part refers, without the rotating frame."""
        return tuple(node for key in self.ends if (node := getattr(self, key)) is not None)


class SketchMember(SketchPart):
    """Beams along a straight or curved centre line between two nodes."""

    title, called, ends = "member", "name", ("first", "second")

    name: Name
    first: Reference
    second: Reference
    section: Section | None = None  #: section along the entire member
    stations: tuple[Section, ...] = ()  #: sections at equal distances, in place of `section`
    elements: Annotated[int, count(1)] = 1
    path: tuple[Position, ...] = ()  #: points in between, in sector 0 [m]
    part: Name | None = None  #: name of the line set; if None, the name of the member
    sectors: Chosen = None

    @property
    def line_set(self) -> str:
        """Name of the line set that its elements belong to."""
        return self.part or self.name


class SketchMass(SketchPart):
    """A point mass."""

    title, ends = "mass at", ("node",)

    node: Reference
    mass: Mass  #: mass [kg]
    inertia: Inertia = 0.0  #: rotary [kg m2]
    sectors: Chosen = None


class SketchSpring(SketchPart):
    """A spring between two nodes, or between a node and the rotating frame, by its stiffnesses."""

    title, ends = "spring at", ("node", "other")

    node: Reference
    other: Reference | None = None  #: second node; None is the rotating frame
    radial: StiffnessOrZero = 0.0  #: along the first node's radius; along x at the origin [N/m]
    tangential: StiffnessOrZero = 0.0  #: across this radius; along y at the origin [N/m]
    rotation: Annotated[float, quantity("N m", "not negative")] = 0.0  #: against rotation [N m/rad]
    sectors: Chosen = None


class SketchLink(SketchPart):
    """A rigid link: the led node moves as if a rigid arm connected it to the leader."""

    title, called, ends = "link of", "led", ("leader", "led")

    leader: Reference
    led: Reference
    sectors: Chosen = None


class SketchEdit(Table):
    """Change in one sector only: the position of a node, or the properties of a member."""

    sector: Annotated[int, count(0)]
    node: Name | None = None  #: node to move
    at: Position | None = None  #: new position, in the coordinates of sector 0 [m]
    member: Name | None = None  #: member to change
    stiffness: Factor = 1.0  #: factor on Young's modulus of the member
    mass: Factor = 1.0  #: factor on the density of the member
    section: Section | None = None
    stations: tuple[Section, ...] = ()
    path: tuple[Position, ...] | None = None


class SketchSet(Table):
    """A named set that contains the listed nodes of every sector."""

    name: StrictStr
    nodes: tuple[Reference, ...]


NEEDED_SETS = ("centre", "tips")

Part = SketchMember | SketchMass | SketchSpring | SketchLink
"""A part that refers to nodes; it can exist in some of the sectors only."""


class SketchTable(Table):
    """A bladed disk drawn node by node: one sector, which is repeated."""

    sectors: Annotated[int, count(1)] = 1
    nodes: tuple[SketchNode, ...] = ()
    members: tuple[SketchMember, ...] = ()
    masses: tuple[SketchMass, ...] = ()
    springs: tuple[SketchSpring, ...] = ()
    links: tuple[SketchLink, ...] = ()
    edits: tuple[SketchEdit, ...] = ()
    sets: tuple[SketchSet, ...] = ()
    tip_radius: Length | None = None
    """Radius from which the clearance is measured [m]; the largest tip radius if None."""

    @property
    def node_sets(self) -> dict[str, tuple[str, ...]]:
        """Nodes of each set, by name of the set."""
        return {named.name: named.nodes for named in self.sets}

    @property
    def tips(self) -> int:
        """Number of blade tips."""
        return self.sectors * len(self.node_sets.get("tips", ()))

    @property
    def radius(self) -> float:
        """Radius from which the clearance is measured [m]."""
        if self.tip_radius is not None:
            return self.tip_radius
        tips = {split_reference(tip)[0] for tip in self.node_sets.get("tips", ())}
        ends = [node.at for node in self.nodes if node.name in tips]
        ends += [edit.at for edit in self.edits if edit.node in tips and edit.at is not None]
        return max((hypot(*at) for at in ends), default=1.0)

    @cached_property
    def _shared(self) -> frozenset[str]:
        return frozenset(node.name for node in self.nodes if node.shared)

    def is_shared(self, *references: str) -> bool:
        """Return true if all sectors share all nodes in `references`."""
        return all(split_reference(reference)[0] in self._shared for reference in references)

    def inconsistencies(self) -> Iterator[Inconsistency]:
        """Yield names, references, sectors and edits that do not fit together."""
        for place, expected in chain(
            _name_faults(self), _reference_faults(self), _sector_faults(self), _edit_faults(self)
        ):
            yield Inconsistency("", expected, place=place)


Faults = Iterator[tuple[str, str]]
"""Pairs of texts: the name of a part of a sketch, and a text that completes "expected ..."."""


def _parts(sketch: SketchTable) -> Iterator[Part]:
    return chain(sketch.members, sketch.masses, sketch.springs, sketch.links)


def _name_faults(sketch: SketchTable) -> Faults:
    """Yield duplicate names and missing sets."""
    for kind, named in (("node", sketch.nodes), ("member", sketch.members), ("set", sketch.sets)):
        for name, times in Counter(one.name for one in named).items():
            if times > 1:
                yield f"{kind} {name!r}", f"only one {kind} of that name, not {times}"
    if not sketch.members:
        yield "members", "one or more"
    for member in sketch.members:
        if (member.section is None) == (not member.stations):
            yield f"member {member.name!r}", "either a section or stations, not both"
    for name in NEEDED_SETS:
        if not sketch.node_sets.get(name):
            yield "sets", f'the set "{name}"'


def _reference_faults(sketch: SketchTable) -> Faults:
    """Yield references to unknown nodes, and nodes that no member connects."""
    known = {node.name for node in sketch.nodes}
    connected: set[str] = set()
    parts = [(part.place, part.references) for part in _parts(sketch)]
    parts += [(f"set {name!r}", references) for name, references in sketch.node_sets.items()]
    for place, references in parts:
        for reference in references:
            name, _ = split_reference(reference)
            if name not in known:
                existing = ", ".join(sorted(known)) or "none"
                yield place, f"a node of the sketch ({existing}), not {reference!r}"
            if place.partition(" ")[0] in ("member", "spring", "link"):
                connected.add(name)
    for node in sketch.nodes:
        if node.name not in connected:
            yield f"node {node.name!r}", "a member, a link or a spring at this node"


def _sector_faults(sketch: SketchTable) -> Faults:
    """Yield sectors that do not exist, and sectors chosen for a part between shared nodes."""
    for part in _parts(sketch):
        place, chosen = part.place, part.sectors
        if chosen is None:
            continue
        if len(set(chosen)) < len(chosen) or not all(0 <= s < sketch.sectors for s in chosen):
            yield place, f"sectors from 0 to {sketch.sectors - 1}, each at most once"
        if sketch.is_shared(*part.references):
            yield (
                place,
                "not allowed with a list of sectors: all its nodes are shared, so it exists once",
            )
    for edit in sketch.edits:
        if edit.sector >= sketch.sectors:
            yield f"edit of sector {edit.sector}", f"a sector from 0 to {sketch.sectors - 1}"


def _edit_faults(sketch: SketchTable) -> Faults:
    """Yield edits of unknown parts, edits of a part that the sector lacks, and repeated edits of a
    part."""
    nodes = {node.name for node in sketch.nodes}
    members = {member.name: member for member in sketch.members}
    seen: Counter[tuple[int, str]] = Counter()
    for edit in sketch.edits:
        place = f"edit of sector {edit.sector}"
        if (edit.node is None) == (edit.member is None):
            yield place, "either a node to move or a member to change"
        elif edit.node is not None and edit.node not in nodes:
            yield place, f"a node of the sketch, not {edit.node!r}"
        elif edit.member is not None and edit.member not in members:
            yield place, f"a member of the sketch, not {edit.member!r}"
        elif edit.node is not None and edit.at is None:
            yield place, f"the new position of node {edit.node!r}"
        part = f"node {edit.node!r}" if edit.node is not None else f"member {edit.member!r}"
        place = f"edit of {part} in sector {edit.sector}"
        seen[edit.sector, part] += 1
        if seen[edit.sector, part] == 2:
            yield place, "at most one edit for each part and sector, with all its differences"
        member = members.get(edit.member or "")
        references = member.references if member else [edit.node] if edit.node else []
        if references and sketch.is_shared(*references) and edit.sector != 0:
            yield place, "sector 0: shared parts belong to this sector"
        if member is not None and member.sectors is not None and edit.sector not in member.sectors:
            existing = ", ".join(map(str, member.sectors)) or "none"
            yield place, f"a sector with this part ({existing})"
