"""The coupled modes of a case, as chosen on the command line."""

from __future__ import annotations

from dataclasses import dataclass
from difflib import get_close_matches

import numpy as np

from bladewhirl.meshes.line_mesh import IntArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.coupling.springs import CouplingModes
from bladewhirl.models.coupling.stage_modes import StageModes, stage_modes
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.inputs.mode_names import ALL, SIX, family_and_diameter
from bladewhirl.models.modal.full_stage import ModalStage, modal_stage


@dataclass(frozen=True, kw_only=True)
class System:
    """Coupled modes of a stage, and what else a study of their stability needs."""

    stage: StageModes  #: the modes chosen, with the amplitudes chosen
    whole: StageModes  #: all modes that couple, with physical amplitudes
    with_pi: bool  #: whether the factor pi of Eq. (8) is kept
    damped: bool
    physical: bool
    reference: float  #: frequency that speeds are multiples of [rad/s]

    @property
    def modes(self) -> CouplingModes:
        """The modes chosen."""
        return self.stage.modes

    @property
    def six(self) -> CouplingModes:
        """The paper's six modes, with the amplitudes chosen."""
        six = self.whole.six_modes()
        return (six if self.physical else six.with_unit_amplitudes()).modes

    @property
    def is_six(self) -> bool:
        """Whether the modes chosen are the paper's six."""
        return self.modes.name == ("casing k=1", "1F k=1", "suspension")

    def options(self) -> dict[str, object]:
        """What was chosen, for reports."""
        return {
            "modes": list(self.modes.name),
            "damped": self.damped,
            "pi": self.with_pi,
            "amplitude": "physical" if self.physical else "paper",
            "reference_frequency": self.reference,
        }


def couple(case: Case, *, chosen: str, damped: bool, with_pi: bool, physical: bool) -> System:
    """Find the modes of the full stage and couple the chosen ones.

    Args:
        case: the case.
        chosen: see `choose`.
        damped: with the damping of the case, or none.
        with_pi: keep the factor pi of Eq. (8).
        physical: with the modes' own amplitudes instead of one for each.

    Raises:
        UserError: a stage without cyclic symmetry, or modes that it does not have.
    """
    return couple_modes(
        modal_stage(case), chosen=chosen, damped=damped, with_pi=with_pi, physical=physical
    )


def couple_modes(
    modal: ModalStage, *, chosen: str, damped: bool, with_pi: bool, physical: bool
) -> System:
    """Couple modes of a full stage; see `couple`."""
    try:
        whole = stage_modes(modal, damping_ratio=modal.case.damping.ratio if damped else 0.0)
    except ValueError as error:
        raise UserError(f"stability: {error}") from None
    stage = choose(whole, chosen)
    return System(
        stage=stage if physical else stage.with_unit_amplitudes(),
        whole=whole,
        with_pi=with_pi,
        damped=damped,
        physical=physical,
        reference=modal.reference_frequency,
    )


def choose(whole: StageModes, text: str) -> StageModes:
    """Choose modes by "six", "all", or families with or without nodal diameters: "1F,casing:2".

    Raises:
        UserError: an unknown family, or a nodal diameter that the family does not have.
    """
    if text == ALL:
        return whole
    if text == SIX:
        try:
            return whole.six_modes()
        except ValueError as error:
            raise UserError(f"--modes six: {error}") from None
    found = [_entries(whole, word.strip()) for word in text.split(",")]
    return whole.take(np.unique(np.concatenate(found)))


def _entries(whole: StageModes, word: str) -> IntArray:
    family, number = family_and_diameter(word)
    known = list(dict.fromkeys(whole.family))
    if family not in known:
        near = get_close_matches(family, known, n=1)
        hint = f" (did you mean {near[0]}?)" if near else ""
        listed = ", ".join(["six", "all", *known])
        raise UserError(f"--modes {word or chr(34) * 2}: expected one of {listed}{hint}")
    if number is None:
        return whole.find(family)
    diameters = [int(k) for k in whole.modes.nodal_diameter[whole.find(family)]]
    if number not in diameters:
        listed = ", ".join(map(str, diameters))
        raise UserError(f"--modes {word}: expected a nodal diameter of {family}: {listed}")
    return whole.find(family, number)
