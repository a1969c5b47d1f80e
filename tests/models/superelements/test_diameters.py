"""Modes of a wheel in single nodal diameters."""

import numpy as np
import pytest

import bladewhirl as bw
from bladewhirl.models.structure.dft import nodal_diameter_of, real_dft
from bladewhirl.models.superelements.diameters import blade_numbers, turned_to_diameters
from bladewhirl.models.superelements.reduction import consistent
from bladewhirl.models.superelements.superelement import Superelement

BLADES = 6


@pytest.fixture(scope="module")
def wheel() -> Superelement:
    """A wheel of beams on a soft disk, whose blade modes have nearly equal frequencies."""
    disk = {"blades": BLADES, "elements_per_blade": 2}
    return bw.build_stage(bw.case_from({"bladed_disk": disk})).to_superelement()


def test_modes_of_an_exported_wheel_have_one_diameter(wheel: Superelement) -> None:
    """Each mode moves the contact nodes with one nodal diameter, as far as double precision."""
    modes = consistent(wheel, 12, 12)
    contact = modes.contact.reshape(BLADES, -1, modes.size)
    parts = np.abs(np.einsum("bc,bim->cim", real_dft(BLADES), contact)).max(axis=1)
    diameter = [nodal_diameter_of(column) for column in range(BLADES)]
    by_diameter = np.sort([parts[np.equal(diameter, k)].max(axis=0) for k in range(4)], axis=0)
    assert (by_diameter[-2] < 1e-10 * by_diameter[-1]).all()


@pytest.mark.parametrize(("apart", "undone"), [(1e-6, True), (1e-2, False)])
def test_only_what_rounding_can_mix_is_turned_back(apart: float, undone: bool) -> None:
    """A mixture of 1e-6 of two modes is undone where it changes squared frequencies by 1e-12; it
    stays where it changes them by 1e-8, as then the blades may differ."""
    angle = np.linspace(0.0, 2.0 * np.pi, BLADES, endpoint=False)
    radial = real_dft(BLADES)[:, [0, 5]]  # nodal diameters 0 and 3
    pure = np.zeros((3 * BLADES, 2))
    pure[::3] = radial
    mixture = 1e-6
    mixed = np.array([[1.0, mixture], [-mixture, 1.0]])
    squares = np.array([1.0, 1.0 + apart]) * 1e6
    turned = turned_to_diameters(squares, pure @ mixed, pure @ mixed, angle)
    assert np.abs(turned - (pure if undone else pure @ mixed)).max() < 1e-11


def test_numbers_of_blades_follow_from_the_angles() -> None:
    """Two nodes on each of six blades can also be four on each of three, but nodes at unequal
    distances are not of equal blades."""
    blade = 2.0 * np.pi / BLADES * np.arange(BLADES)
    angle = (blade[:, None] + [-0.1, 0.2]).ravel()
    assert blade_numbers(angle) == [6, 3]
    angle[3] += 1e-6
    assert blade_numbers(angle) == []
