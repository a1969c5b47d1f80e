"""Foreshortening of the blades of a contact problem, from the case and the beams of the blades."""

from collections.abc import Iterator

import numpy as np

from bladewhirl.models.case.file import case_fault
from bladewhirl.models.elements.foreshortening import blade_beams, drawback, fewest_terms
from bladewhirl.models.inputs.errors import Fault
from bladewhirl.models.stage.contact_problem import Foreshortening
from bladewhirl.models.stage.stage import Stage

NEGLECTED = 1e-6
"""Terms of a quadratic form below this fraction of the largest are neglected, for modes of equal
energy."""


def foreshortening(stage: Stage) -> Foreshortening | None:
    """Return the foreshortening of the blades in the modes of `reduction.modes`; None if the case
    has none. See `models.elements.foreshortening` for the quadratic form."""
    if not stage.case.contact.foreshortening:
        return None
    modes = stage.reduction.modes.take(stage.kept.rotor)
    frequency = np.abs(modes.frequency)
    weight = np.maximum(frequency, 0.01 * np.median(frequency))
    around = stage.case.contact.tip_rotation
    forms = [
        fewest_terms(*drawback(stage.disk, modes.shapes, blade, around=around), weight, NEGLECTED)
        for blade in range(len(stage.disk.model.tips))
    ]
    terms = max(len(signs) for _, signs, _ in forms)
    rows, sign = np.zeros((len(forms), terms, modes.count)), np.zeros((len(forms), terms))
    for blade, (row, signs, _) in enumerate(forms):
        rows[blade, : len(signs)], sign[blade, : len(signs)] = row, signs
    return Foreshortening(rows=rows, sign=sign, frequency=max(each for *_, each in forms))


def foreshortening_faults(stage: Stage) -> Iterator[Fault]:
    """Yield a fault if no beam ends at a tip."""
    case, model = stage.case, stage.disk.model
    if not case.contact.foreshortening:
        return
    for blade, tip in enumerate(model.tips):
        if not len(blade_beams(model, int(tip))):
            expected = f"false, because no beam ends at the tip of blade {blade}"
            yield case_fault(case, "contact.foreshortening", expected)
            break
