"""Faults of a sketch that show before it is built: names, sectors, sections, lengths."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from itertools import pairwise

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.sketch import SketchSpring, SketchTable, split_reference
from bladewhirl.models.inputs.errors import Fault

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
    yield from _shared_parts(sketch)
    yield from _edits(sketch)
    yield from _lengths(sketch)


def _names(sketch: SketchTable) -> Iterator[Fault]:
    known = {node.name for node in sketch.nodes}
    for kind, names in (
        ("node", [node.name for node in sketch.nodes]),
        ("member", [member.name for member in sketch.members]),
        ("set", [named.name for named in sketch.sets]),
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


def _shared_parts(sketch: SketchTable) -> Iterator[Fault]:
    """Parts between shared nodes are there once: sectors given for them say nothing."""
    for place, references, sectors in (
        *((f"member {m.name!r}", (m.first, m.second), m.sectors) for m in sketch.members),
        *((f"mass at {m.node!r}", (m.node,), m.sectors) for m in sketch.masses),
        *((f"spring at {s.node!r}", _ends(s), s.sectors) for s in sketch.springs),
        *((f"link of {k.led!r}", (k.leader, k.led), k.sectors) for k in sketch.links),
    ):
        if sectors is not None and _is_shared(sketch, references):
            expected = "no sectors: its nodes are shared, so that it is there once"
            yield Fault(key=f"sketch: {place}", expected=expected)


def _edits(sketch: SketchTable) -> Iterator[Fault]:
    """Edits that would have no effect, or undo one another."""
    shared = {node.name for node in sketch.nodes if node.shared}
    members = {member.name: member for member in sketch.members}
    seen: Counter[tuple[int, str]] = Counter()
    for edit in sketch.edits:
        part = f"node {edit.node!r}" if edit.node is not None else f"member {edit.member!r}"
        place = f"sketch: edit of {part} in sector {edit.sector}"
        seen[edit.sector, part] += 1
        if seen[edit.sector, part] == 2:
            yield Fault(key=place, expected="one edit of a part in a sector, with all that differs")
        member = members.get(edit.member or "")
        is_shared = edit.node in shared or (
            member is not None and _is_shared(sketch, (member.first, member.second))
        )
        if is_shared and edit.sector != 0:
            yield Fault(key=place, expected="sector 0, which shared parts belong to")
        if member is not None and member.sectors is not None and edit.sector not in member.sectors:
            found = ", ".join(map(str, member.sectors)) or "none"
            yield Fault(key=place, expected=f"a sector that has it ({found})")


def _is_shared(sketch: SketchTable, references: tuple[str, ...]) -> bool:
    shared = {node.name for node in sketch.nodes if node.shared}
    return all(split_reference(reference)[0] in shared for reference in references)


def _ends(spring: SketchSpring) -> tuple[str, ...]:
    return (spring.node,) if spring.other is None else (spring.node, spring.other)


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
        yield "spring", _ends(spring)
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
