"""Modes by name on the command line: "1F:1", "suspension", "casing:1F:2", or lists of them."""

from __future__ import annotations

from dataclasses import dataclass
from difflib import get_close_matches

import numpy as np

from bladewhirl.meshes.line_mesh import IntArray
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.inputs.mode_names import CASING
from bladewhirl.models.modal.full_stage import ModalStage, Whirl
from bladewhirl.models.modal.labels import Body, LabelledModes


@dataclass(frozen=True, kw_only=True)
class ChosenMode:
    """A mode, or a degenerate pair, of one body."""

    body: Body
    family: str
    nodal_diameter: int
    numbers: IntArray
    """Among the body's modes: one, the cosine and the sine of a pair, or waves both ways."""
    which: int = 0
    """Among modes of the same name, as sectors that differ have them, from 1; 0 of the only one."""

    @property
    def name(self) -> str:
        """As on the command line."""
        own = self.family
        if self.family != "suspension":
            own = f"{self.family}:{self.nodal_diameter}"
        return own if self.body == "bladed-disk" else f"{CASING}:{own}"

    @property
    def stem(self) -> str:
        """Of files that show it."""
        return self.name.replace(":", "-") + (f"-{self.which}" if self.which else "")


def choose_modes(stage: ModalStage, option: str, text: str) -> list[ChosenMode]:
    """Modes from a list of names; a name without nodal diameter means all it has, and one that
    several modes of a stage of unequal sectors have means each of them.

    Args:
        stage: finite element models with their modes.
        option: what errors call it, "--animate".
        text: names with commas between them.

    Raises:
        UserError: an unknown family, or a nodal diameter that the family does not have.
    """
    return [mode for word in text.split(",") for mode in _named(stage, option, word.strip())]


def family_of(
    stage: ModalStage, body: Body, family: str, diameters: list[int], *, every: bool = False
) -> list[ChosenMode]:
    """Those modes of a family that there are among some nodal diameters; of several that have the
    same name the lowest, unless `every` is wanted.
    """
    modes = modes_of(stage, body)
    chosen = []
    for k in diameters:
        found = _with_partners(modes, family, k)[: None if every else 1]
        which = range(1, len(found) + 1) if len(found) > 1 else range(len(found))
        chosen += [
            ChosenMode(body=body, family=family, nodal_diameter=k, numbers=numbers, which=own)
            for own, numbers in zip(which, found, strict=True)
        ]
    return chosen


def modes_of(stage: ModalStage, body: Body) -> LabelledModes | Whirl:
    """Modes of one body of a stage; of the bladed disk whirling ones where it has them."""
    return (stage.disk_whirl or stage.disk_modes) if body == "bladed-disk" else stage.casing_modes


def _named(stage: ModalStage, option: str, word: str) -> list[ChosenMode]:
    on_casing = word.startswith(f"{CASING}:")
    body: Body = "casing" if on_casing else "bladed-disk"
    family, colon, number = word.removeprefix(f"{CASING}:").partition(":")
    modes = modes_of(stage, body)
    known = list(dict.fromkeys(modes.family))
    if family not in known:
        near = get_close_matches(family, known, n=1)
        hint = f" (did you mean {near[0]}?)" if near else ""
        where = f"a family of the {'casing' if on_casing else 'bladed disk'}"
        raise UserError(f"{option} {word or chr(34) * 2}: expected {where}, {_listed(known)}{hint}")
    diameters = sorted({int(k) for k in modes.nodal_diameter[_of_family(modes, family)]})
    if colon and (not number.isdecimal() or int(number) not in diameters):
        listed = ", ".join(map(str, diameters))
        raise UserError(f"{option} {word}: expected a nodal diameter of {family}: {listed}")
    return family_of(stage, body, family, [int(number)] if colon else diameters, every=True)


def _of_family(modes: LabelledModes | Whirl, family: str) -> IntArray:
    return np.flatnonzero([name == family for name in modes.family])


def _with_partners(modes: LabelledModes | Whirl, family: str, k: int) -> list[IntArray]:
    """Modes of a name, those that are a pair or waves both ways together."""
    found = modes.find(family, k)
    told_apart = modes.modes.rank if isinstance(modes, Whirl) else modes.column
    if not found.size:
        return []
    return [found] if told_apart[found[0]] >= 0 else list(found[:, None])


def _listed(families: list[str]) -> str:
    """Families in words: "1F to 30F, suspension"."""
    ranks = sorted(int(name[:-1]) for name in families if name[:-1].isdecimal())
    others = [name for name in families if not name[:-1].isdecimal()]
    flexible = [f"1F to {ranks[-1]}F"] if len(ranks) > 1 else [f"{rank}F" for rank in ranks]
    return ", ".join([*flexible, *others])
