"""Mode names of a case: "all", the paper's "six", or a list such as "1F:1,suspension,casing:1".

A name selects modes of the bladed disk (FAMILY or FAMILY:k) or of the casing (casing:FAMILY or
casing:FAMILY:k). Without ":k" it selects all nodal diameters; * is any family. "casing:k" is the
lowest radial casing mode with k nodal diameters, rigid or flexible, which springs may couple to the
bladed disk; "casing" selects this mode for every k. Both modes of a degenerate pair are always
selected together.
"""

import re
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Any

import numpy as np

from bladewhirl.meshes.line_mesh import IntArray
from bladewhirl.models.inputs.fields import expectation

ALL, SIX = "all", "six"

SIX_MODES = "1F:1,suspension:1,casing:1"  #: modes of the truncated space of the paper, Eqs (4)-(9)

EVERY = "*"

CASING = "casing"

_RADIAL = re.compile(r"casing(?::(?P<diameter>\d+))?", re.ASCII)
_NAME = re.compile(
    r"(?P<body>casing:)?(?P<family>\*|[A-Za-z0-9]+)(?::(?P<diameter>\d+))?", re.ASCII
)


@dataclass(frozen=True, kw_only=True)
class ModeName:
    """Name of the modes of a family, for one nodal diameter or for all nodal diameters."""

    on_casing: bool
    family: str | None  #: family; None is the lowest radial casing mode of each nodal diameter
    nodal_diameter: int | None  #: nodal diameter; None is all

    def __str__(self) -> str:
        """Return the name as written in a case."""
        parts = [CASING if self.on_casing else None, self.family, self.nodal_diameter]
        return ":".join(str(part) for part in parts if part is not None)


@dataclass(frozen=True, kw_only=True)
class NamedModes:
    """Families and nodal diameters of the modes of bladed disk or casing, to select by name."""

    family: tuple[str, ...]  #: family of each mode, (modes,)
    nodal_diameter: IntArray  #: nodal diameter of each mode, (modes,)

    def numbers(self, name: ModeName) -> IntArray:
        """Return the numbers of the modes that a name selects, ascending."""
        here = np.array([name.family in (EVERY, family) for family in self.family], dtype=np.bool_)
        if name.nodal_diameter is not None:
            here &= self.nodal_diameter == name.nodal_diameter
        return np.flatnonzero(here)


def parse_mode_names(text: str) -> tuple[ModeName, ...]:
    """Return the mode names in a comma-separated list.

    Raises:
        ValueError: an entry is not a mode name.
    """
    return tuple(_parsed(word.strip()) for word in text.split(","))


def mode_choice(value: Any) -> str:
    """Validate the text that selects modes, as the value of a key of a case."""
    phrase = '"all", "six" or modes by name such as "1F:1, suspension, casing:1"'
    if not isinstance(value, str):
        raise expectation(phrase)
    if value not in (ALL, SIX):
        try:
            parse_mode_names(value)
        except ValueError as error:
            raise expectation(phrase, error) from None
    return value


def chosen_modes(
    choice: str, rotor: NamedModes, casing: NamedModes, radial: dict[int, IntArray]
) -> tuple[IntArray, IntArray]:
    """Return the numbers of the selected modes of bladed disk and casing, ascending.

    Args:
        choice: text that selects modes, as in a case.
        rotor: modes of the bladed disk.
        casing: modes of the casing.
        radial: numbers of the lowest radial casing modes by nodal diameter; an empty dictionary
            without cyclic symmetry.

    Raises:
        ValueError: a name selects no mode of the stage.
    """
    if choice == ALL:
        return np.arange(len(rotor.family)), np.arange(len(casing.family))
    disk, wall = [np.zeros(0, dtype=np.int64)], [np.zeros(0, dtype=np.int64)]
    for name in parse_mode_names(SIX_MODES if choice == SIX else choice):
        if name.family is None:
            k = name.nodal_diameter
            numbers = np.concatenate([wall[0], *(radial[n] for n in radial if k in (None, n))])
        else:
            numbers = (casing if name.on_casing else rotor).numbers(name)
        if not numbers.size:
            raise ValueError(_instead(name, casing if name.on_casing else rotor, radial))
        (wall if name.on_casing else disk).append(numbers)
    return np.unique(np.concatenate(disk)), np.unique(np.concatenate(wall))


def _parsed(word: str) -> ModeName:
    match = _RADIAL.fullmatch(word) or _NAME.fullmatch(word)
    if match is None:
        raise ValueError(f'"{word}" is not a mode name')
    parts = match.groupdict()
    diameter = None if parts["diameter"] is None else int(parts["diameter"])
    on_casing = parts.get("body", CASING) is not None
    return ModeName(on_casing=on_casing, family=parts.get("family"), nodal_diameter=diameter)


def _instead(name: ModeName, modes: NamedModes, radial: dict[int, IntArray]) -> str:
    """Return a message that lists the available names."""
    families = list(dict.fromkeys(modes.family))
    body = "casing" if name.on_casing else "bladed disk"
    if name.family is None and not radial:
        return f"{name}: the stage has no cyclic symmetry; name modes of the casing by family"
    if name.family not in (None, EVERY, *families):
        near = get_close_matches(str(name.family), families, n=1)
        hint = f", did you mean {near[0]}?" if near else ""
        return f"{name}: families of the {body} are {', '.join(families)}{hint}"
    of_family = [name.family in (EVERY, family) for family in modes.family]
    diameters = radial if name.family is None else modes.nodal_diameter[of_family]
    called = f"{name.family} of the {body} has"
    if name.family is None:
        called = "radial modes of the casing have"
    return f"{name}: {called} nodal diameters {', '.join(map(str, np.unique([*diameters])))}"
