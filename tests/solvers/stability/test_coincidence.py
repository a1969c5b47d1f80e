"""Coincidence speeds: Eq. (14), for counter-rotating waves alone."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bladewhirl.solvers.stability.coincidence import Coincidences, coincidences

ROTOR = np.array([1.03, 1.0, 2.5, 1.02, 6.0])
ROTOR_K = np.array([0, 1, 1, 2, 2])
CASING = np.array([41.0, 0.055, 58.0, 0.64])
CASING_K = np.array([0, 1, 1, 2])


def stage() -> Coincidences:
    return coincidences(
        rotor_frequency=ROTOR,
        rotor_nodal_diameter=ROTOR_K,
        casing_frequency=CASING,
        casing_nodal_diameter=CASING_K,
    )


def test_every_pair_of_one_nodal_diameter_has_its_speed() -> None:
    actual = stage()
    assert len(actual.speed) == 6
    expected = {
        (3, 3): (1.02 + 0.64) / 2,
        (1, 1): 1.055,
        (2, 1): 2.555,
        (4, 3): 3.32,
        (1, 2): 59.0,
        (2, 2): 60.5,
    }
    assert dict(zip(zip(actual.rotor, actual.casing, strict=True), actual.speed, strict=True)) == (
        pytest.approx(expected)
    )
    assert list(actual.nodal_diameter) == [2, 1, 1, 2, 1, 1]
    assert (np.diff(actual.speed) > 0.0).all()


def test_corotating_waves_never_coincide() -> None:
    actual = stage()
    for mode, k in enumerate(ROTOR_K):
        for wall, wall_k in enumerate(CASING_K):
            if k == wall_k and k > 0:
                apart = abs(CASING[wall] - ROTOR[mode]) / k
                assert not np.isclose(actual.speed, apart).any()


@pytest.mark.slow
@given(rotor=st.floats(0.1, 100.0), casing=st.floats(0.0, 100.0), k=st.integers(1, 20))
def test_both_bodies_see_the_same_wave_at_the_coincidence(
    rotor: float, casing: float, k: int
) -> None:
    actual = coincidences(
        rotor_frequency=[rotor],
        rotor_nodal_diameter=[k],
        casing_frequency=[casing],
        casing_nodal_diameter=[k],
    )
    assert k * actual.speed[0] - casing == pytest.approx(rotor, abs=1e-9)
