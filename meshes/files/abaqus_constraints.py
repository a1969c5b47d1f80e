"""Nodes that are held, or move as a rigid body, in input of Abaqus and CalculiX."""

from collections.abc import Sequence
from itertools import chain

from bladewhirl.meshes.files.abaqus_mesh import AbaqusMesh
from bladewhirl.meshes.files.abaqus_sets import ELEMENTS, NODES, named
from bladewhirl.meshes.files.abaqus_text import Card, real, whole
from bladewhirl.meshes.files.groups import MeshFileError

AXES = {"ENCASTRE": {1, 2, 3, 4, 5, 6}, "PINNED": {1, 2, 3}}
AXES |= {"XSYMM": {1, 5, 6}, "YSYMM": {2, 4, 6}, "ZSYMM": {3, 4, 5}}
AXES |= {"XASYMM": {2, 3, 4}, "YASYMM": {1, 3, 5}, "ZASYMM": {1, 2, 6}}
"""Displacements and rotations that the names of boundary conditions hold."""


def read_boundary(card: Card, content: AbaqusMesh) -> None:
    """Read the displacements that are held; OP=NEW frees those of the steps before it."""
    if card.parameters.get("OP", "").upper() == "NEW" and content.renewed != content.step:
        for node, axes in content.held.items():
            content.earlier.setdefault(node, set()).update(axes)
        content.held, content.renewed = {}, content.step
    for how in ("USER", "SUBMODEL"):
        if how in card.parameters:
            content.others[f"BOUNDARY, {how}"] += 1
            return
    for row in card.rows:
        first, last, value = (*row[1:4], "", "", "")[:3]
        nodes, axes = named(row[0], content, NODES), AXES.get(first.upper(), set())
        if not axes:
            low, high = whole(first), whole(last or first)
            if low > high:
                raise MeshFileError(f"degrees of freedom from low to high, got {first}, {last}")
            axes = {one for one in range(1, 7) if low <= one <= high}
        if not axes:  # a temperature, for instance
            continue
        if value and real(value):
            content.others["BOUNDARY of motions"] += 1
            continue
        for node in nodes:
            content.held.setdefault(node, set()).update(axes)


def read_coupling(card: Card, content: AbaqusMesh) -> None:
    """Read the nodes that move with a reference node as a rigid body."""
    if card.keyword in ("DISTRIBUTING", "KINEMATIC"):  # of the coupling before
        if card.keyword == "DISTRIBUTING":  # its nodes move independently
            content.distributed.append(content.couplings.pop()[1])
        elif not _displacements(card.rows):
            content.couplings.pop()
            content.others["KINEMATIC of some displacements"] += 1
        return
    reference = [*named(card.needs("REF NODE"), content, NODES)]
    for node in reference if "ROTNODE" in card.parameters else ():
        content.turns[node] = [*named(card.needs("ROT NODE"), content, NODES)]
    keys = ("SURFACE", "NSET", "ELSET", "TIENSET", "PINNSET")
    nodes: list[int] = []
    for key, value in card.parameters.items():
        if key in keys and key != "ELSET":
            nodes += named(value, content, NODES)
        elif key == "ELSET":
            nodes += content.nodes_of(named(value, content, ELEMENTS))
    if card.keyword == "KINEMATIC COUPLING":
        if not _displacements([row[1:] for row in card.rows]):
            content.others["KINEMATIC COUPLING of some displacements"] += 1
            return
        nodes += chain.from_iterable(named(row[0], content, NODES) for row in card.rows)
    content.couplings.append((f"*{card.keyword}", reference, nodes))


def _displacements(rows: Sequence[Sequence[str]]) -> bool:
    """Return whether rows of first and last degrees of freedom contain all three displacements.
    Without a row they do."""
    ranges = [[whole(value) for value in row[:2] if value] for row in rows]
    return not any(ranges) or all(
        any(min(row) <= one <= max(row) for row in ranges if row) for one in (1, 2, 3)
    )
