"""Shaft springs sized for a wanted frequency of the suspension pair."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import case_fault
from bladewhirl.models.elements.build import (
    case_bladed_disk,
    numbers_within_reach,
    tip_in_sector,
)
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.modal.labels import labelled_modes

KEY = "shaft.suspension_frequency"

AGREE = 0.01
"""Largest relative difference of the suspension's mean frequency from the one wanted: blades that
differ split the pair, another family is farther away."""


def with_sized_shaft(case: Case) -> Case:
    """The case with the shaft.stiffness that `shaft.suspension_frequency` asks for, if it does.

    Springs k at the centre of a disk that floats, of dynamic stiffness D = K - w^2 M, make w a
    frequency where det(I + k C^T D^-1 C) = 0; C picks the centre's two displacements. Where blades
    differ, the pair is split about w: half of the trace stands for both.

    Raises:
        CaseError: no springs do, or the mode that they bring to w belongs to another family.
    """
    wanted = case.shaft.suspension_frequency
    if wanted is None:
        return case
    with numbers_within_reach(case):
        structure = (disk := case_bladed_disk(case, clamped=False)).structure
        floating = structure.stiffness - structure.springs
        dynamic = floating - (2.0 * np.pi * wanted) ** 2 * structure.mass
        centre = np.zeros((structure.size, 2))
        centre[disk.centre] = np.eye(2)
        flexibility = centre.T @ spla.splu(sp.csc_array(dynamic)).solve(centre)
        stiffness = -2.0 / float(np.trace(flexibility))
        if not (np.isfinite(stiffness) and stiffness > 0.0):
            raise CaseError([case_fault(case, KEY, "a frequency that springs can bring about")])
        shaft = case.shaft.model_copy(update={"stiffness": stiffness, "suspension_frequency": None})
        sized = case.model_copy(update={"shaft": shaft})
        held = case_bladed_disk(sized, clamped=False)
        modes = labelled_modes(held.structure, tip_in_sector(held), "bladed-disk")
    found = float(modes.frequency[modes.find("suspension", 1)].mean() / (2.0 * np.pi))
    if abs(found / wanted - 1.0) > AGREE:
        expected = (
            "a frequency at which the shaft springs hold most of the mode: springs of"
            f" {stiffness:.4g} N/m give it to another family, the suspension is at {found:.4g} Hz"
        )
        raise CaseError([case_fault(case, KEY, expected)])
    return sized
