"""Frequencies over nodal diameter and over the stiffness of the shaft."""

from functools import cache

import numpy as np
import pytest
import xarray as xr

from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import with_values
from bladewhirl.models.modal.modal_model import ModalModel
from bladewhirl.models.stage.modal import modal_model
from bladewhirl.postprocess.modal.veering import plot_shaft_veering
from bladewhirl.solvers.stability.veering import shaft_veering, whirl_veering
from bladewhirl.studies.modal.veering import clamping_shifts, veering, veering_facts


@cache
def stage(stiffness: float = 3.4e7) -> ModalModel:
    return modal_model(with_values(Case(), {"shaft.stiffness": stiffness}))


@cache
def diagrams() -> xr.Dataset:
    return veering(stage(), stiffnesses=np.geomspace(1e4, 1e11, 30))


def test_a_mass_on_a_spring_in_front_of_an_oscillator() -> None:
    """Two masses in closed form: m1 on the spring kappa, joined to m2 by k."""
    m1, m2, k = 2.0, 0.5, 300.0
    springs = np.array([1.0, 100.0, 1e4])
    stiffness = np.array([[k, -k], [-k, k]], dtype=np.complex128)
    mass = np.diag([m1, m2]).astype(np.complex128)
    actual = shaft_veering(stiffness, mass, np.array([1.0 + 0j, 0.0]), springs=springs, branches=1)
    for kappa, frequency, share in zip(
        springs, actual.frequency[:, 0], actual.spring_share[:, 0], strict=True
    ):
        middle = (kappa + k) / m1 + k / m2
        square = (middle - np.sqrt(middle**2 - 4.0 * kappa * k / (m1 * m2))) / 2.0
        assert frequency == pytest.approx(np.sqrt(square), rel=1e-9)
        ratio = k / (k - m2 * square)  # of the second mass's motion to the first's
        energy = kappa + k * (ratio - 1.0) ** 2
        assert share == pytest.approx(kappa / energy, rel=1e-6)
    assert actual.clamped == pytest.approx([np.sqrt(k / m2)])


def test_the_same_two_masses_with_coriolis_forces_and_spin_softening() -> None:
    """All roots of a polynomial of fourth degree, and a third mass that nothing joins to them."""
    m, g, k = np.array([2.0, 0.5, 1.0]), np.array([3.0, -2.0, 0.0]), 300.0
    softening, own = 7.0, 20.0
    elastic = np.array([[k, -k, 0.0], [-k, k, 0.0], [0.0, 0.0, own**2 + softening]]) + 0j
    matrices = np.diag(m) + 0j, elastic - softening * np.diag(m), 1j * np.diag(g)
    springs, centre = np.array([40.0, 100.0, 1e4]), np.array([1.0 + 0j, 0.0, 0.0])
    actual = whirl_veering(matrices, elastic, centre, springs=springs, branches=2)
    assert actual.direction == ("backward", "backward", "forward", "forward")
    for kappa, frequency, share in zip(springs, actual.frequency, actual.spring_share, strict=True):
        first, second = (
            np.polynomial.Polynomial([held - softening * mass, -turned, -mass])
            for held, turned, mass in zip((kappa + k, k), g[:2], m[:2], strict=True)
        )
        roots = np.sort([*(first * second - k**2).roots().real, own, -own])
        w = roots[[3, 4, 2, 1]]  # the lowest backward, positive, and the lowest forward
        np.testing.assert_allclose(frequency * [1.0, 1.0, -1.0, -1.0], w, rtol=1e-9)
        ratio = k / second(w)  # of the second mass's motion to the first's
        energy = np.where(np.isclose(abs(w), own), np.inf, kappa + k * (ratio - 1.0) ** 2)
        np.testing.assert_allclose(share, kappa / energy, rtol=1e-9, atol=1e-15)
    alone = np.polynomial.Polynomial([k - softening * m[1], -g[1], -m[1]]).roots()
    clamped = np.sort([*alone, own, -own])[[2, 3, 1, 0]]
    np.testing.assert_allclose(actual.clamped * [1.0, 1.0, -1.0, -1.0], clamped)


@pytest.mark.slow
def test_branches_are_the_frequencies_of_stages_built_with_that_stiffness() -> None:
    springs = np.array([1e5, 3.4e7, 5e9])
    actual = veering(stage(), families=2, stiffnesses=springs)["branch_frequency"]
    for kappa, row in zip(springs, 2.0 * np.pi * actual.values, strict=True):
        modes = stage(float(kappa)).disks["free"].labelled
        first = modes.frequency[(modes.nodal_diameter == 1) & (modes.column == 1)]
        # Rounding errors of the highest squared frequency, 2e9 times the lowest, are 2e-7 of it.
        np.testing.assert_allclose(row, first[:5], rtol=3e-7)


def test_branches_rise_between_those_of_a_clamped_centre() -> None:
    """Interlacing: each branch stays between two neighbouring clamped frequencies."""
    actual = diagrams()
    frequency, clamped = actual["branch_frequency"].values, actual["clamped_frequency"].values
    assert (np.diff(frequency, axis=0) > -1e-9 * frequency[1:]).all()
    assert (frequency <= clamped * (1 + 1e-9)).all()
    assert (frequency[:, 1:] >= clamped[:-1] * (1 - 1e-9)).all()
    np.testing.assert_allclose(frequency[-1, :3], clamped[:3], rtol=1e-3)
    # A soft shaft carries the disk as a rigid body: all the energy is in the springs.
    assert actual["branch_spring_share"].values[0, 0] > 0.99


def test_clamped_frequencies_of_the_branches_are_those_of_the_clamped_stage() -> None:
    modes = stage().disks["clamped"].labelled
    first = modes.frequency[(modes.nodal_diameter == 1) & (modes.column == 1)][:5]
    actual = diagrams()["clamped_frequency"].values
    np.testing.assert_allclose(2.0 * np.pi * actual, first, rtol=1e-9)


def test_clamping_changes_one_nodal_diameter_and_the_suspension_is_between_the_families() -> None:
    actual = diagrams()
    shifts = clamping_shifts(actual)
    assert shifts.pop(1) > 0.02
    assert set(shifts) == {0, *range(2, 12)}
    assert max(shifts.values()) < 1e-9
    assert veering_facts(actual)["suspension, rotating frame"] == "2.527 ω₁"
    assert actual.sizes["mode"] == 2 * 12 * 12 + 1


@pytest.mark.slow
def test_past_a_critical_speed_where_both_waves_of_the_suspension_go_backward() -> None:
    """More families than there are modes are all of them."""
    past = {"rotation.effects": "full", "march.speed": 2.0, "shaft.stiffness": 5e6}
    springs = np.geomspace(1e7, 3.4e7, 7)
    actual = veering(with_values(Case(), past), families=10**11, stiffnesses=springs)
    waves = veering_facts(actual)["suspension, rotating frame"]
    assert waves.count("backward") == 2
    shifts = clamping_shifts(actual)
    assert shifts.pop(1) > 1e-3 > max(shifts.values())
    names = [text.get_text() for text in plot_shaft_veering(actual).axes[0].texts]
    assert names.count("suspension") == 2  # each where the springs have the energy
