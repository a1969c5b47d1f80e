"""Nodes that the command D of .cdb files of Ansys holds, and components of nodes."""

from collections import defaultdict
from collections.abc import Iterable, Iterator

from bladewhirl.meshes.files.ansys_text import (
    Command,
    integers,
    is_number,
    rows_of,
    whole_in,
    width_of,
)
from bladewhirl.meshes.files.groups import MeshFileError

MOST_MEMBERS = 5_000_000  #: largest number of nodes of a range

DISPLACEMENTS = frozenset(["UX", "UY", "UZ"])


def held_nodes(lines: list[str], commands: list[Command]) -> tuple[list[int], list[str]]:
    """Return the nodes that the command D holds along x, y and z, and what else it says."""
    held, other = defaultdict[int, set[str]](set), 0
    components = dict(_components(lines, commands))
    selected: Iterable[int] | None = None  # nodes of a component that is selected
    for command, given, _, line in commands:
        if command == "CMSEL" or command[:3] in ("NSE", "NSL", "ALL"):
            alone = command == "CMSEL" and given[1:] and given[0] in ("", "S")
            selected = components.get(given[1]) if alone else None
        if command != "D" or len(given) < 2:
            continue
        node, label, value, _, end, step = (*given, *[""] * 6)[:6]
        nodes: Iterable[int] | None = components.get(node, selected if node == "ALL" else None)
        if is_number(node):
            first, last = whole_in(node, line), whole_in(end or node, line)
            nodes = _run(first, last, whole_in(step or "1", line))
        if nodes is None or (value and (not is_number(value) or float(value))):
            other += 1
            continue
        for one in nodes:
            held[one] |= DISPLACEMENTS if label == "ALL" else {label, *given[6:]} & DISPLACEMENTS
    whole = [node for node, axes in held.items() if len(axes) == 3]
    partly = sum(bool(axes) for axes in held.values()) - len(whole)
    notes = [f"D of single displacements of {partly} nodes"] if partly else []
    return whole, notes + ([f"{other} D of motions or selected nodes"] if other else [])


def _components(lines: list[str], commands: list[Command]) -> Iterator[tuple[str, list[int]]]:
    """Yield name and members of each component of nodes; a negative number ends a range."""
    for command, given, row, _ in commands:
        if command != "CMBLOCK" or given[1:2] != ["NODE"]:
            continue
        width, members = width_of(lines, row + 1), list[int]()
        for _, text in rows_of(lines, row + 2):
            for one in integers(text, width):
                if one < 0 and not members:
                    raise MeshFileError(f"a number before {one}, the end of a range")
                members += [one] if one >= 0 else _run(members[-1] + 1, -one)
        yield given[0], members


def _run(first: int, last: int, step: int = 1) -> range:
    """Return the numbers of a range, which a deck of a few lines can make of any length."""
    if step < 1 or (last - first) // step > MOST_MEMBERS:
        raise MeshFileError(f"ranges of at most {MOST_MEMBERS} nodes, got {first} to {last}")
    return range(first, last + 1, step)
