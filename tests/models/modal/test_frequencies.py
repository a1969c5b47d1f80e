"""Lowest frequencies of large stages, to the digits that their matrices hold."""

import numpy as np
import pytest
import scipy.linalg as la

from bladewhirl.models.case.case import case_from
from bladewhirl.models.elements.build import case_bladed_disk
from bladewhirl.models.modal.frequencies import lowest_frequencies


@pytest.mark.parametrize(("blades", "elements"), [(300, 10), (40, 50)])
def test_frequencies_are_quotients_in_long_double(blades: int, elements: int) -> None:
    tables = {"bladed_disk": {"blades": blades, "elements_per_blade": elements}}
    structure = case_bladed_disk(case_from(tables), clamped=False).structure
    actual = lowest_frequencies(structure, 3)
    assert structure.layout is not None
    for k, (mass, stiffness) in structure.layout.blocks(structure.mass, structure.stiffness):
        if k not in (0, 1, 2, blades // 2):
            continue
        vectors = la.eigh(stiffness, mass)[1][:, :3].astype(np.clongdouble)
        strain, inertia = (
            np.sum(vectors.conj() * (matrix.astype(np.clongdouble) @ vectors), axis=0).real
            for matrix in (stiffness, mass)
        )
        np.testing.assert_allclose(actual[k], np.sqrt(strain / inertia).astype(float), rtol=1e-9)
