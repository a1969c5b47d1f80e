"""Shaft springs for a required frequency of the suspension pair."""

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import case_fault
from bladewhirl.models.elements.build import case_bladed_disk, numbers_within_reach, tip_in_sector
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.modal.labels import labelled_modes

KEY = "shaft.suspension_frequency"

HALVINGS = 12  # number of times an interval of stiffnesses is halved

HIDDEN = 50.0 * np.finfo(np.float64).eps
"""Fraction of the largest ratio of stiffness to mass. Rounding errors of the stiffness matrix
change a squared frequency below this fraction by more than 2 %."""

ABOVE_ROUNDING = "a frequency above the rounding error"

AGREE = 0.01
"""The mean frequency of the suspension pair may differ from the required frequency by this
fraction, because mistuned blades split the pair; a larger difference indicates another family."""


def with_sized_shaft(case: Case) -> Case:
    """Return the case with the shaft.stiffness that gives its `shaft.suspension_frequency`, if set.

    Let D = K - w^2 M be the dynamic stiffness of the disk without shaft springs, and let C select
    the two displacements of the centre. With springs k at the centre, w is a natural frequency if
    det(I + k C^T D^-1 C) = 0. If blades differ, w lies between the two frequencies of the pair;
    half of the trace of C^T D^-1 C is therefore used for both directions.

    Raises:
        CaseError: no springs give the frequency, or the mode at that frequency is of another
            family; the error names the nearest possible frequencies.
    """
    required = case.shaft.suspension_frequency
    if required is None:
        return case
    with numbers_within_reach(case):
        structure = (disk := case_bladed_disk(case, clamped=False)).structure
        floating, square = structure.stiffness - structure.springs, (2.0 * np.pi * required) ** 2
        if square <= HIDDEN * (floating.diagonal() / structure.mass.diagonal()).max():
            raise CaseError([case_fault(case, KEY, ABOVE_ROUNDING)])
        dynamic = floating - square * structure.mass
        centre = np.zeros((structure.size, 2))
        centre[disk.centre] = np.eye(2)
        flexibility = centre.T @ spla.splu(sp.csc_array(dynamic)).solve(centre)
        stiffness = -2.0 / float(np.trace(flexibility))
        if np.isfinite(stiffness) and stiffness > 0.0:
            sized = _on_springs(case, stiffness)
            if abs(_suspension(sized) / required - 1.0) <= AGREE:
                return sized
        raise CaseError([case_fault(case, KEY, _within_reach(case, required, abs(stiffness)))])


def _on_springs(case: Case, stiffness: float) -> Case:
    shaft = case.shaft.model_copy(update={"stiffness": stiffness, "suspension_frequency": None})
    return case.model_copy(update={"shaft": shaft})


def _suspension(case: Case) -> float:
    """Return the mean frequency of the suspension pair of a case [Hz]."""
    disk = case_bladed_disk(case, clamped=False)
    modes = labelled_modes(disk.structure, tip_in_sector(disk), "bladed-disk")
    return float(modes.frequency[modes.find("suspension", 1)].mean() / (2.0 * np.pi))


def _within_reach(case: Case, required: float, stiffness: float) -> str:
    """Return as text the possible suspension frequencies nearest to the required frequency."""
    springs = stiffness * np.geomspace(1e-4, 1e4, 40)
    frequencies = np.array([_suspension(_on_springs(case, float(each))) for each in springs])
    above = int(np.searchsorted(frequencies > required, True))
    if 0 < above < len(frequencies):
        soft, stiff = springs[above - 1 : above + 1]
        for _ in range(HALVINGS):
            middle = float(np.sqrt(soft * stiff))
            soft, stiff = (
                (middle, stiff)
                if _suspension(_on_springs(case, middle)) < required
                else (soft, middle)
            )
        low, high = (_suspension(_on_springs(case, float(each))) for each in (soft, stiff))
        if high / low > 1.0 + 2.0 * AGREE:
            return (
                f"at most {low:.4g} Hz or at least {high:.4g} Hz: for any springs that"
                " give a frequency in between, the mode with one nodal diameter belongs to another"
                " family. Blades that bend at frequencies farther from the required one (shorter"
                " or thicker, longer or thinner), or another disk, change these limits;"
                " shaft.stiffness accepts any springs"
            )
        return ABOVE_ROUNDING
    nearest = frequencies.min() if above == 0 else frequencies.max()
    return f"a frequency that the suspension can have; the nearest is {nearest:.4g} Hz"
