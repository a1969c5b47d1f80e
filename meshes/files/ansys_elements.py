"""Elements of .cdb files of Ansys with their types and real constants: ET, KEYOPT, EBLOCK, R."""

import re
from collections import Counter
from collections.abc import Iterator
from typing import NamedTuple

from bladewhirl.meshes.files.ansys_text import (
    Command,
    integers,
    is_number,
    rows_of,
    whole_in,
    width_of,
)
from bladewhirl.meshes.files.groups import MeshFileError, places_of_nodes

NODES = re.compile(r"\D*(\d+)i(\d+),\s*\d*[eg](\d+)", re.IGNORECASE)
"""Format of the rows of nodes: number and width of the integers, and width of the coordinates."""


class Element(NamedTuple):
    """An element of an EBLOCK."""

    rows: range  #: numbers of its lines
    number: int
    kind: int  #: number of its type
    material: int
    constants: int  #: number of its real constants
    nodes: list[int]


def element_types(
    lines: list[str], commands: list[Command]
) -> tuple[dict[int, int], dict[tuple[int, int], int]]:
    """Return the number of the element of each type, and the values of KEYOPT by the type and the
    number of the option."""
    types, options = dict[int, int](), dict[tuple[int, int], int]()
    for command, given, number, line in commands:
        if command == "ET" and len(given) > 1:
            kind = whole_in(given[0], line)
            types[kind] = whole_in(re.sub(r"\D", "", given[1]), line)
            for key, value in enumerate(given[2:8], 1):
                if value:
                    options[kind, key] = whole_in(value, line)
        elif command == "KEYOPT" and len(given) > 2 and given[1].isdigit():
            options[whole_in(given[0], line), int(given[1])] = whole_in(given[2] or "0", line)
        elif command == "ETBLOCK":
            width = width_of(lines, number + 1)
            for row in lines[number + 2 : number + 2 + int(given[0])]:
                values = integers(row, width)
                types[values[0]] = values[1]
                options |= {
                    (values[0], k): value for k, value in enumerate(values[2:8], 1) if value
                }
    return types, options


def _blocks(commands: list[Command], *, solid: bool) -> Iterator[int]:
    """Yield the number of the line after each EBLOCK with the key SOLID, or without it.

    Raises:
        MeshFileError: elements are in the compact form, which does not contain materials.
    """
    for command, given, row, _ in commands:
        if command == "EBLOCK":
            if "COMPACT" in given:
                raise MeshFileError("EBLOCK in its long form; COMPACT does not contain materials")
            if ("SOLID" in given) == solid:
                yield row + 1


def elements_of(lines: list[str], commands: list[Command]) -> Iterator[Element]:
    """Yield the elements of the blocks with the key SOLID.

    Raises:
        MeshFileError: a block is not complete, or an element lacks mid-side nodes.
    """
    for start in _blocks(commands, solid=True):
        width, rows = width_of(lines, start), rows_of(lines, start + 1)
        for first, row in rows:
            values = integers(row, width)
            if len(values) < 11:
                raise MeshFileError(f"11 numbers before the nodes of an element, got {row[:60]!r}")
            nodes, size, last = values[11:], values[8], first
            while len(nodes) < size:
                last, row = next(rows, (-1, ""))
                if last < 0:
                    raise MeshFileError(f"all {size} nodes of element {values[10]}")
                nodes += integers(row, width)
            if 0 in nodes[:size]:
                raise MeshFileError(f"all mid-side nodes; element {values[10]} lacks some")
            kind, material, constants = values[1], values[0], values[2]
            yield Element(
                range(first, last + 1), values[10], kind, material, constants, nodes[:size]
            )


def other_blocks(lines: list[str], commands: list[Command]) -> dict[int, tuple[int, int]]:
    """Return the lines of the blocks of elements without the key SOLID, as which programs write
    elements on surfaces, with the numbers of the real constants and of the type of each element;
    0 for other lines of a block."""
    found: dict[int, tuple[int, int]] = {}
    for start in _blocks(commands, solid=False):
        found[start - 1] = found[start] = 0, 0
        width = width_of(lines, start)
        for number, row in rows_of(lines, start + 1):
            _, kind, constants, *_ = (*integers(row, width), 0, 0, 0)
            found[number] = constants, kind
    return found


def check_numbers_of(lines: list[str], commands: list[Command], elements: list[Element]) -> None:
    """Check that no number of a node or an element is used twice, that coordinates are numbers, and
    that all nodes of the elements are defined."""
    nodes = Counter[int]()
    for command, _, start, _ in commands:
        if command != "NBLOCK":
            continue
        form = lines[start + 1] if start + 1 < len(lines) else ""
        if not (found := NODES.match(form)):
            raise MeshFileError(f"a format such as (3i9,6e21.13e3), got {form.strip()[:40]!r}")
        count, width, real = map(int, found.groups())
        for _, row in rows_of(lines, start + 2):
            nodes[(integers(row[:width], width) or [0])[0]] += 1
            given = (row[at : at + real].strip() for at in range(count * width, len(row), real))
            if not all(map(is_number, filter(None, given))):
                raise MeshFileError(f"numbers as coordinates of a node, got {row[:60]!r}")
    for what, counts in (("node", nodes), ("element", Counter(one.number for one in elements))):
        if twice := [number for number, count in counts.items() if count > 1]:
            raise MeshFileError(f"each {what} once; {what} {twice[0]} is there twice")
    defined = dict(nodes)
    for one in elements:
        places_of_nodes(defined, one.number, one.nodes)


def real_constants(lines: list[str], commands: list[Command]) -> Iterator[tuple[int, int]]:
    """Yield the number of a set and the number of each of its real constants that is not 0."""
    for command, given, number, _ in commands:
        if command == "R" and given and is_number(given[0]):
            for place, value in enumerate(given[1:], 1):
                if is_number(value) and float(value):
                    yield int(float(given[0])), place
        elif command == "RLBLOCK":
            rows = [row for _, row in rows_of(lines, number + 3)]
            while rows:
                set_number, size = integers(rows[0][:18], 9)[:2]
                text = rows.pop(0)[18:]
                values = [text[at : at + 16] for at in range(0, len(text), 16)]
                while len(values) < size and rows:
                    text = rows.pop(0)
                    values += [text[at : at + 16] for at in range(0, len(text), 16)]
                for place, value in enumerate(values, 1):
                    if is_number(value) and float(value):
                        yield set_number, place
