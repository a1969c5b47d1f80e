"""Stresses of a reduction."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from bladewhirl.models.superelements.stresses import reduced_stress


def test_the_stress_of_steady_rotation_adds_the_modes_to_the_static_displacement() -> None:
    """A rigid mode and two elastic ones, whose displacements are 1 + 5/4 and 1 + 7/10, by hand."""
    part: Any = SimpleNamespace(
        stress_recovery=np.array([[1.0, 2.0, 3.0]]),
        centrifugal_load=np.array([8.0, 5.0, 7.0]),
        contacts=0,
    )
    squares, elastic = np.array([1.0, 4.0, 10.0]), np.array([False, True, True])
    found = reduced_stress(part, squares, np.eye(3), np.ones((3, 1)), elastic)
    assert found is not None
    assert found.steady == pytest.approx([1.0 + 2.0 * 2.25 + 3.0 * 1.7])
    assert found.modes == pytest.approx(part.stress_recovery)
