"""Table of a case for a bladed disk drawn node by node, and checks that its parts fit together."""

from collections import Counter
from collections.abc import Iterator
from functools import cached_property
from itertools import chain
from math import hypot
from typing import Annotated

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.sketch_parts import (
    SketchEdit,
    SketchLink,
    SketchMass,
    SketchMember,
    SketchNode,
    SketchSet,
    SketchSpring,
    split_reference,
)
from bladewhirl.models.inputs.fields import Length, count
from bladewhirl.models.inputs.table import Inconsistency, Table

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
"""Pairs of the name of a part of a sketch and a text that completes "expected ..."."""


def _parts(sketch: SketchTable) -> Iterator[tuple[str, Part]]:
    """Yield all parts that refer to nodes, each with its name for messages."""
    for member in sketch.members:
        yield f"member {member.name!r}", member
    for mass in sketch.masses:
        yield f"mass at {mass.node!r}", mass
    for spring in sketch.springs:
        yield f"spring at {spring.node!r}", spring
    for link in sketch.links:
        yield f"link of {link.led!r}", link


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
    parts = [(place, part.references) for place, part in _parts(sketch)]
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
    for place, part in _parts(sketch):
        chosen = part.sectors
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


def turned(point: tuple[float, float], angle: float) -> FloatArray:
    """Return a point rotated about the origin by an angle [rad], (2,)."""
    cos, sin = np.cos(angle), np.sin(angle)
    x, y = point
    return np.array([cos * x - sin * y, sin * x + cos * y])
