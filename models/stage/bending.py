"""Foreshortening of bent blades of beams in their modes."""

from collections.abc import Iterator

import numpy as np

from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import case_fault
from bladewhirl.models.elements.bladed_disk import BladedDiskModel
from bladewhirl.models.elements.foreshortening import blade_beams, drawback, fewest_terms
from bladewhirl.models.geometry.beam_model import BeamModel
from bladewhirl.models.inputs.errors import Fault
from bladewhirl.models.modal.modes import Modes
from bladewhirl.models.stage.foreshortening import Foreshortening

NEGLECTED = 1e-6
"""Terms of a quadratic form are neglected if they are below this fraction of the largest term when
all modes have the same energy."""


def foreshortening(case: Case, disk: BladedDiskModel, modes: Modes) -> Foreshortening | None:
    """Return the foreshortening of the blades in some modes; None if the case has none. See
    `models.elements.foreshortening` for the quadratic form."""
    if not case.contact.foreshortening:
        return None
    frequency = np.abs(modes.frequency)
    weight = np.maximum(frequency, 0.01 * np.median(frequency))
    around = case.contact.tip_rotation
    forms = [
        fewest_terms(*drawback(disk, modes.shapes, blade, around=around), weight, NEGLECTED)
        for blade in range(len(disk.model.tips))
    ]
    terms = max(len(signs) for _, signs, _ in forms)
    rows, sign = np.zeros((len(forms), terms, modes.count)), np.zeros((len(forms), terms))
    for blade, (row, signs, _) in enumerate(forms):
        rows[blade, : len(signs)], sign[blade, : len(signs)] = row, signs
    return Foreshortening(rows=rows, sign=sign, frequency=max(each for *_, each in forms))


def foreshortening_faults(case: Case, model: BeamModel) -> Iterator[Fault]:
    """Yield a fault if no beam ends at a tip."""
    if not case.contact.foreshortening:
        return
    for blade, tip in enumerate(model.tips):
        if not len(blade_beams(model, int(tip)).lines):
            expected = f"false, because no beam ends at the tip of blade {blade}"
            yield case_fault(case, "contact.foreshortening", expected)
            break
