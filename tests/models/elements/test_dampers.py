"""Dampers of supports and shaft: a full damping matrix in the march."""

import numpy as np
import pytest
from stages import SMALL, ring, ring_moved, stage, steel

from bladewhirl.models.elements.casing import spring, strut


def test_dampers_of_a_ring_that_moves_as_a_whole() -> None:
    """Power of three dampers at 120 degrees: 3 (c_r + c_t) / 2 v^2; of a strut's, c (e v)^2."""
    angles = 0.3 + 2.0 * np.pi * np.arange(3) / 3
    casing = ring(
        *(
            spring(a, radial=0, tangential=0, radial_damping=70, tangential_damping=20)
            for a in angles
        )
    )
    along_x = ring_moved(casing, 1.0, 0.0, 0.0)
    power = np.sum((casing.dampers @ along_x) ** 2)
    assert power == pytest.approx(1.5 * 90.0, rel=1e-5)
    leaning = ring(
        strut(1.0, steel(0.01), length=0.3, inclination=0.4, ends="built-in", damping=50.0)
    )
    power = np.sum((leaning.dampers @ along_x) ** 2)
    assert power == pytest.approx(50.0 * np.cos(1.4) ** 2, rel=1e-4)


def test_dampers_of_the_shaft_act_on_the_centre() -> None:
    dampers = ("shaft.damping=400.0", "shaft.damping_y=100.0")
    rotor = stage(*SMALL, *dampers).rotor
    np.testing.assert_allclose(rotor.dampers, np.array([[20.0], [10.0]]) * rotor.centre)
    assert not stage(*SMALL, *dampers, "shaft.clamped=true").rotor.dampers.any()
