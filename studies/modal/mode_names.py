"""Names of modes on the command line: "1F:1", "suspension", "casing:1F:2", or lists of these."""

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
    """A mode, or a degenerate pair, of a body: the bladed disk or the casing."""

    body: Body
    family: str
    nodal_diameter: int
    numbers: IntArray
    """Numbers among the modes of the body: a single mode, the cosine and sine modes of a pair, or
    waves in both directions."""
    rank: int = 0
    """Number from 1 if several modes have the same name, as with unequal sectors; 0 if the name is
    unique."""

    @property
    def name(self) -> str:
        """Name on the command line."""
        diameter = "" if self.family == "suspension" else f":{self.nodal_diameter}"
        prefix = "" if self.body == "bladed-disk" else f"{CASING}:"
        return f"{prefix}{self.family}{diameter}"

    @property
    def stem(self) -> str:
        """Name of the mode's files without suffix."""
        return self.name.replace(":", "-") + (f"-{self.rank}" if self.rank else "")


def choose_modes(stage: ModalStage, option: str, text: str) -> list[ChosenMode]:
    """Return the modes of a list of names, separated by commas; errors contain the option's name.

    A name without nodal diameter means all nodal diameters of the family. A name that several modes
    have, as with unequal sectors, means all of these modes.

    Raises:
        UserError: a family is unknown, or does not have the nodal diameter.
    """
    return [mode for name in text.split(",") for mode in _named(stage, option, name.strip())]


def family_of(
    stage: ModalStage, body: Body, family: str, diameters: list[int], *, every: bool = False
) -> list[ChosenMode]:
    """Return the lowest mode of a family with each nodal diameter, or all of them with `every`;
    nodal diameters without such a mode are skipped."""
    modes, chosen = modes_of(stage, body), []
    for k in diameters:
        numbers = modes.find(family, k)
        order = modes.modes.rank if isinstance(modes, Whirl) else modes.column
        paired = numbers.size and order[numbers[0]] >= 0
        groups = [numbers] if paired else list(numbers[:, None])
        groups = groups if every else groups[:1]
        chosen += [
            ChosenMode(
                body=body,
                family=family,
                nodal_diameter=k,
                numbers=group,
                rank=place if len(groups) > 1 else 0,
            )
            for place, group in enumerate(groups, 1)
        ]
    return chosen


def modes_of(stage: ModalStage, body: Body) -> LabelledModes | Whirl:
    """Return the modes of a body; for a bladed disk with Coriolis forces, its whirling modes."""
    return (stage.disk_whirl or stage.disk_modes) if body == "bladed-disk" else stage.casing_modes


def _named(stage: ModalStage, option: str, name: str) -> list[ChosenMode]:
    on_casing = name.startswith(f"{CASING}:")
    body: Body = "casing" if on_casing else "bladed-disk"
    family, colon, number = name.removeprefix(f"{CASING}:").partition(":")
    modes = modes_of(stage, body)
    families = list(dict.fromkeys(modes.family))
    if family not in families:
        near = get_close_matches(family, families, n=1)
        hint = f" (did you mean {near[0]}?)" if near else ""
        expected = f"a family of the {'casing' if on_casing else 'bladed disk'}"
        listed = ", ".join(families)
        raise UserError(f"{option} {name or chr(34) * 2}: expected {expected}: {listed}{hint}")
    of_family = np.flatnonzero([other == family for other in modes.family])
    diameters = np.unique(modes.nodal_diameter[of_family]).tolist()
    if colon and (not number.isdecimal() or int(number) not in diameters):
        listed = ", ".join(map(str, diameters))
        raise UserError(f"{option} {name}: expected a nodal diameter of {family}: {listed}")
    return family_of(stage, body, family, [int(number)] if colon else diameters, every=True)
