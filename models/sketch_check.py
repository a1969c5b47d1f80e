"""Faults of a sketch that show before it is built: names, sectors, sections, lengths."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from itertools import pairwise

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.faults import Fault
from bladewhirl.models.sketch_parts import SketchTable, split_reference

NEEDED_SETS = ("centre", "tips")


def sketch_faults(sketch: SketchTable) -> Iterator[Fault]:
    """What of a sketch does not fit together, part by part."""
    yield from _names(sketch)
    yield from _sectors(sketch)
    for member in sketch.members:
        place = f"sketch: member {member.name!r}"
        if member.section is None and not member.stations:
            yield Fault(key=place, expected="a section")
        if member.section is not None and member.stations:
            yield Fault(key=place, expected="either a section or stations")
    yield from _lengths(sketch)


def _names(sketch: SketchTable) -> Iterator[Fault]:
    known = {node.name for node in sketch.nodes}
    for kind, names in (
        ("node", [node.name for node in sketch.nodes]),
        ("member", [member.name for member in sketch.members]),
    ):
        for name, times in Counter(names).items():
            if times > 1:
                yield Fault(
                    key=f"sketch: {kind} {name!r}", expected=f"one of that name, not {times}"
                )
    if not sketch.members:
        yield Fault(key="sketch", expected="members")
    for name in NEEDED_SETS:
        if not sketch.node_sets.get(name):
            yield Fault(key="sketch", expected=f'the set "{name}"')
    for part, references in _references(sketch):
        for reference in references:
            if split_reference(reference)[0] not in known:
                found = ", ".join(sorted(known)) or "none"
                expected = f"a node of the sketch ({found}), not {reference!r}"
                yield Fault(key=f"sketch: {part}", expected=expected)
    yield from _bare_nodes(sketch)
    members = {member.name for member in sketch.members}
    for edit in sketch.edits:
        place = f"sketch: edit of sector {edit.sector}"
        if (edit.node is None) == (edit.member is None):
            yield Fault(key=place, expected="either a node to move or a member to change")
        elif edit.node is not None and edit.node not in known:
            yield Fault(key=place, expected=f"a node of the sketch, not {edit.node!r}")
        elif edit.member is not None and edit.member not in members:
            yield Fault(key=place, expected=f"a member of the sketch, not {edit.member!r}")
        elif edit.node is not None and edit.at is None:
            yield Fault(key=place, expected=f"where node {edit.node!r} is to be")


def _bare_nodes(sketch: SketchTable) -> Iterator[Fault]:
    """Nodes that nothing holds."""
    met = {
        split_reference(reference)[0]
        for part, references in _references(sketch)
        if part.partition(" ")[0] in ("member", "spring", "link")
        for reference in references
    }
    for node in sketch.nodes:
        if node.name not in met:
            place = f"sketch: node {node.name!r}"
            yield Fault(key=place, expected="a member, a link or a spring at it")


def _references(sketch: SketchTable) -> Iterator[tuple[str, tuple[str, ...]]]:
    for member in sketch.members:
        yield f"member {member.name!r}", (member.first, member.second)
    for mass in sketch.masses:
        yield "mass", (mass.node,)
    for spring in sketch.springs:
        yield "spring", (spring.node, *([] if spring.other is None else [spring.other]))
    for link in sketch.links:
        yield "link", (link.leader, link.led)
    for name, references in sketch.node_sets.items():
        yield f"set {name!r}", references


def _sectors(sketch: SketchTable) -> Iterator[Fault]:
    expected = f"sectors from 0 to {sketch.sectors - 1}, each once"
    for kind in ("members", "masses", "springs", "links"):
        for part in getattr(sketch, kind):
            chosen = part.sectors
            if chosen is not None and (
                len(set(chosen)) != len(chosen)
                or not all(0 <= sector < sketch.sectors for sector in chosen)
            ):
                called = getattr(part, "name", None) or getattr(part, "node", None) or part.led
                yield Fault(key=f"sketch: {kind} {called!r}", expected=expected)
    for edit in sketch.edits:
        if edit.sector >= sketch.sectors:
            place = f"sketch: edit of sector {edit.sector}"
            yield Fault(key=place, expected=f"a sector from 0 to {sketch.sectors - 1}")


def _lengths(sketch: SketchTable) -> Iterator[Fault]:
    """Members of no length, in sector 0 or where an edit makes them so."""
    nodes = {node.name for node in sketch.nodes}
    moved = {(e.sector, e.node): e.at for e in sketch.edits if e.node and e.at is not None}
    changed = {(e.sector, e.member): e.path for e in sketch.edits if e.member}
    touched = sorted({0, *(e.sector + shift for e in sketch.edits for shift in (-1, 0, 1))})
    for member in sketch.members:
        references = [split_reference(r) for r in (member.first, member.second)]
        if any(name not in nodes for name, _ in references):
            continue
        for sector in {sector % sketch.sectors for sector in touched}:
            if member.sectors is not None and sector not in member.sectors:
                continue
            path = changed.get((sector, member.name))
            points = [_position(sketch, moved, sector, r) for r in references]
            points[1:1] = [np.array(point) for point in (member.path if path is None else path)]
            steps = [float(np.linalg.norm(b - a)) for a, b in pairwise(points)]
            if not min(steps) > 1e-12 * float(np.abs(points).max()):
                where = f"member {member.name!r} in sector {sector}"
                expected = "a member with length: two points in a row of it are alike"
                yield Fault(key=f"sketch: {where}", expected=expected)
                break


def _position(
    sketch: SketchTable,
    moved: Mapping[tuple[int, str], tuple[float, float]],
    sector: int,
    reference: tuple[str, int],
) -> FloatArray:
    """Where a node is, in the axes of a sector."""
    name, shift = reference
    [node] = [node for node in sketch.nodes if node.name == name][:1]
    if node.shared:
        at, turns = node.at, -sector
    else:
        at, turns = moved.get(((sector + shift) % sketch.sectors, name), node.at), shift
    angle = 2.0 * np.pi * turns / sketch.sectors
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([cos * at[0] - sin * at[1], sin * at[0] + cos * at[1]])
