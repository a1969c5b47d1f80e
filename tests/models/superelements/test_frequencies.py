"""Natural frequencies of a chain of masses, by dense and by sparse matrices."""

from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp

from bladewhirl.models.superelements import frequencies


def chain(size: int) -> tuple[Any, Any, Any]:
    """Return mass, stiffness and frequencies of equal masses between two walls."""
    ones = np.full(size - 1, -1e6)
    stiffness = sp.diags_array([ones, np.full(size, 2e6), ones], offsets=[-1, 0, 1], format="csr")
    wave = np.pi * np.arange(1, size + 1) / (2 * (size + 1))
    return sp.eye_array(size, format="csr"), stiffness, 2e3 * np.sin(wave) / (2.0 * np.pi)


@pytest.mark.parametrize("small", [10, 1000])
def test_frequencies_of_a_chain(monkeypatch: pytest.MonkeyPatch, small: int) -> None:
    monkeypatch.setattr(frequencies, "SMALL", small)
    mass, stiffness, expected = chain(200)
    actual = frequencies.lowest_frequencies(mass, stiffness, 12)
    assert actual == pytest.approx(expected[:12], rel=1e-9)


@pytest.mark.parametrize("small", [10, 1000])
def test_coordinates_without_mass_have_no_frequency(
    monkeypatch: pytest.MonkeyPatch, small: int
) -> None:
    """Springs in series: every second node of a chain twice as long and stiff has no mass."""
    monkeypatch.setattr(frequencies, "SMALL", small)
    _, _, expected = chain(100)
    _, stiffness, _ = chain(201)
    mass = sp.diags_array(np.arange(201) % 2.0, format="csr")
    actual = frequencies.lowest_frequencies(mass, 2.0 * stiffness, 12)
    assert actual == pytest.approx(expected[:12], rel=1e-9)


def test_rigid_modes_have_frequency_zero() -> None:
    _, stiffness, _ = chain(100)
    stiffness[0, 0] = stiffness[99, 99] = 1e6
    actual = frequencies.lowest_frequencies(sp.eye_array(100), stiffness, 2)
    wave = np.pi / 200
    assert actual == pytest.approx([0.0, 2e3 * np.sin(wave) / (2.0 * np.pi)], abs=1e-4)
