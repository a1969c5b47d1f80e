"""Mode names of a case: "all", the paper's "six", or a list such as "1F:1,suspension,casing:1".

A name selects modes of the bladed disk (FAMILY or FAMILY:k) or of the casing (casing:FAMILY or
casing:FAMILY:k). Without ":k" it selects all nodal diameters; * is any family. "casing:k" is the
lowest radial casing mode with k nodal diameters, rigid or flexible. This mode is coupled by the
springs between the bodies; "casing" selects it for every k. Degenerate pairs are never split.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Any

import numpy as np

from bladewhirl.meshes.line_mesh import IntArray
from bladewhirl.models.inputs.fields import expectation

ALL, SIX = "all", "six"

SIX_MODES = "1F:1,suspension:1,casing:1"
"""The paper's truncated space: Eqs (4)-(9)."""

EVERY = "*"

CASING = "casing"

_RADIAL = re.compile(r"casing(?::(\d+))?", re.ASCII)
_NAME = re.compile(r"(casing:)?(\*|[A-Za-z0-9]+)(?::(\d+))?", re.ASCII)


@dataclass(frozen=True, kw_only=True)
class ModeName:
    """Modes of one family, of one nodal diameter or of all."""

    on_casing: bool
    family: str | None  #: None: the lowest radial mode of each nodal diameter, on the casing
    nodal_diameter: int | None

    def __str__(self) -> str:
        """Return the name as written in a case."""
        parts = [CASING if self.on_casing else None, self.family, self.nodal_diameter]
        return ":".join(str(part) for part in parts if part is not None)


@dataclass(frozen=True, kw_only=True)
class NamedModes:
    """Modes of one body, to choose from."""

    family: tuple[str, ...]  #: (modes,)
    nodal_diameter: IntArray  #: (modes,)

    def numbers(self, name: ModeName) -> IntArray:
        """Return the numbers of the modes with a name, ascending."""
        here = np.array([name.family in (EVERY, family) for family in self.family], dtype=np.bool_)
        if name.nodal_diameter is not None:
            here &= self.nodal_diameter == name.nodal_diameter
        return np.flatnonzero(here)


def parse_mode_names(text: str) -> tuple[ModeName, ...]:
    """Names in a list with commas.

    Raises:
        ValueError: a word that is no name.
    """
    return tuple(_parsed(word.strip()) for word in text.split(","))


def mode_choice(value: Any) -> str:
    """Check the text of a choice, as a validator of a case's key."""
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
        choice: as in a case.
        rotor: modes of the bladed disk.
        casing: modes of the casing.
        radial: lowest radial casing modes by nodal diameter; none without cyclic symmetry.

    Raises:
        ValueError: a name of modes that the stage does not have.
    """
    if choice == ALL:
        return np.arange(len(rotor.family)), np.arange(len(casing.family))
    disk, wall = [np.zeros(0, dtype=np.int64)], [np.zeros(0, dtype=np.int64)]
    for name in parse_mode_names(SIX_MODES if choice == SIX else choice):
        if name.family is None:
            numbers = _radial(name, radial)
        else:
            numbers = (casing if name.on_casing else rotor).numbers(name)
        if not numbers.size:
            raise ValueError(_instead(name, casing if name.on_casing else rotor, radial))
        (wall if name.on_casing else disk).append(numbers)
    return np.unique(np.concatenate(disk)), np.unique(np.concatenate(wall))


def _radial(name: ModeName, radial: dict[int, IntArray]) -> IntArray:
    none = np.zeros(0, dtype=np.int64)
    if name.nodal_diameter is not None:
        return radial.get(name.nodal_diameter, none)
    return np.concatenate([none, *radial.values()])


def _parsed(word: str) -> ModeName:
    radial, named = _RADIAL.fullmatch(word), _NAME.fullmatch(word)
    if radial:
        return ModeName(on_casing=True, family=None, nodal_diameter=_number(radial[1]))
    if named:
        return ModeName(
            on_casing=named[1] is not None, family=named[2], nodal_diameter=_number(named[3])
        )
    raise ValueError(f'"{word}" is not a mode name')


def _number(text: str | None) -> int | None:
    return None if text is None else int(text)


def _instead(name: ModeName, modes: NamedModes, radial: dict[int, IntArray]) -> str:
    """Return a message that lists the available names."""
    families = list(dict.fromkeys(modes.family))
    body = "casing" if name.on_casing else "bladed disk"
    if name.family is None:
        known: Sequence[int] = sorted(radial)
        if not known:
            return f"{name}: the stage has no cyclic symmetry, name families of the casing"
        return f"{name}: radial modes of the casing have nodal diameters {_listed(known)}"
    if name.family != EVERY and name.family not in families:
        near = get_close_matches(name.family, families, n=1)
        hint = f", did you mean {near[0]}?" if near else ""
        return f"{name}: families of the {body} are {', '.join(families)}{hint}"
    diameters = modes.nodal_diameter[[name.family in (EVERY, family) for family in modes.family]]
    return (
        f"{name}: {name.family} of the {body} has nodal diameters {_listed(np.unique(diameters))}"
    )


def _listed(numbers: Sequence[int] | IntArray) -> str:
    return ", ".join(str(int(number)) for number in numbers)
