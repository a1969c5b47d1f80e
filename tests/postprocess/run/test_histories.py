"""Histories of blades and of the casing in windows of seconds, against closed forms."""

import numpy as np
import pytest
import xarray as xr
from synthetic_result import RECORD_STEP, resting, synthetic_result

import bladewhirl as bw
from bladewhirl.postprocess.fields.kinematics import ViewError

WINDOWED = (
    "casing_displacement contact_force family_energies gap shaft_orbit strain_energies"
    " stress_history tip_displacement amplitude_growth contact_classes contact_phase poincare_map"
    " shaft_spectrogram shaft_spectrum whirl_history"
).split()


@pytest.fixture(scope="module")
def result() -> xr.Dataset:
    return synthetic_result(records=1601, growth=1.0)


@pytest.mark.parametrize("name", WINDOWED)
def test_a_window_in_seconds_is_that_of_the_records(result: xr.Dataset, name: str) -> None:
    analyse = getattr(bw, name)
    actual = analyse(result, start=0.2, end=1.5)
    xr.testing.assert_identical(actual, analyse(result.isel(time=slice(200, 1501))))
    assert actual.attrs["speed"] == result.attrs["speed"]
    with pytest.raises(ViewError, match=r"window \[0\.7, 0\.2\] s: expected a start"):
        analyse(result, start=0.7, end=0.2)


def test_what_needs_the_orbit_takes_it_instead_of_the_result(result: xr.Dataset) -> None:
    orbit = bw.shaft_orbit(result)
    for analyse in (bw.whirl_history, bw.shaft_spectrum, bw.poincare_map):
        xr.testing.assert_identical(analyse(orbit, start=0.3), analyse(result, start=0.3))


def test_tips_move_along_and_across_their_radius(result: xr.Dataset) -> None:
    """A translation along x and a bending that turns the tips, both in closed form."""
    still = resting(rotor_displacement=[2e-3, 0.0, 0.0, 1e-3, 0.0])
    moved = bw.tip_displacement(still)["displacement"].isel(time=1)
    angle = result["tip_angle"].values
    assert moved.attrs["units"] == "m"
    np.testing.assert_allclose(moved.sel(component="radial"), 2e-3 * np.cos(angle), atol=1e-15)
    across = -2e-3 * np.sin(angle) + 1e-3 * np.cos(angle)
    np.testing.assert_allclose(moved.sel(component="tangential"), across, atol=1e-15)


def test_the_casing_moves_between_its_nodes_as_its_cubics_do() -> None:
    still = resting(casing_displacement=[2e-3, 0.0, 1e-3, 0.0])
    angle = np.array([0.0, 0.071, 3.0, 6.28])
    moved = bw.casing_displacement(still, angle)["displacement"].isel(time=1)
    np.testing.assert_array_equal(moved["angle"], angle)
    error = (2e-3 + 16 * 1e-3) * (2 * np.pi / 40) ** 4 / 384  # of cubics between 40 nodes
    radial = 2e-3 * np.cos(angle) + 1e-3 * np.cos(2 * angle)
    np.testing.assert_allclose(moved.sel(component="radial"), radial, rtol=0, atol=error)
    along = -2e-3 * np.sin(angle) - 0.5e-3 * np.sin(2 * angle)
    np.testing.assert_allclose(moved.sel(component="tangential"), along, rtol=0, atol=error)
    assert bw.casing_displacement(still, angle=0.5).sizes["angle"] == 1
    turned = bw.casing_displacement(still, angle="90 deg")
    xr.testing.assert_identical(turned, bw.casing_displacement(still, angle=np.pi / 2))
    with pytest.raises(bw.UserError, match='angle = "90 mm": expected an angle'):
        bw.casing_displacement(still, angle="90 mm")
    two = bw.casing_displacement(still, angle=["90 deg", "0.5 rad"])
    xr.testing.assert_identical(two, bw.casing_displacement(still, angle=[np.pi / 2, 0.5]))
    for beyond in (90, "400 deg", np.nan):
        with pytest.raises(bw.UserError, match="expected within a turn"):
            bw.casing_displacement(still, angle=beyond)


def test_forces_are_impulses_over_the_time_since_the_record_before(result: xr.Dataset) -> None:
    early = result.isel(time=slice(0, 5)).copy(deep=True)
    early["contact_impulse"][:] = 0.5
    early["friction_impulse"][:] = 0.05
    early = early.assign_coords(time=[0.0, 1e-3, 2e-3, 3e-3, 3.5e-3])  # ended between records
    forces = bw.contact_force(early).sel(blade=3)
    expected = 0.5 / (RECORD_STEP * np.array([1, 1, 1, 1, 0.5]))
    np.testing.assert_allclose(forces["normal"], expected)
    np.testing.assert_allclose(forces["friction"], 0.1 * expected)
