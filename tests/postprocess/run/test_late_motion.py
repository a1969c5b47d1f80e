"""What a sweep keeps of late motions: circles and ellipses with known answers."""

import numpy as np
import pytest
import synthetic_result as synthetic
import xarray as xr

from bladewhirl.postprocess.fields.windows import late_part
from bladewhirl.postprocess.run.late_motion import LateMotion, late_motion, radius_peaks
from bladewhirl.postprocess.shaft.orbits import shaft_orbit


def of(result: xr.Dataset) -> LateMotion:
    late = late_part(result)
    return late_motion(late, shaft_orbit(late))


def test_a_drifting_whirl_scatters() -> None:
    """A chirp from 15 to 25 Hz over the last third: its rates are evenly spread."""
    result = synthetic.synthetic_result(records=3001)
    time = result["time"].values
    begin, end = time[-1] * 2 / 3, time[-1]
    rate = 2 * np.pi * (15.0 + 10.0 * (time - begin) / (end - begin))
    angle = np.concatenate([[0.0], np.cumsum(np.diff(time) * (rate[1:] + rate[:-1]) / 2)])
    circle = np.column_stack([np.cos(angle), np.sin(angle)])
    result["rotor_displacement"][:, :2] = 1e-3 * circle
    result["rotor_velocity"][:, :2] = 1e-3 * rate[:, None] * (circle[:, ::-1] * [-1.0, 1.0])
    result["rotor_displacement"][:, 2:] = 0.0
    actual = of(result)
    assert actual.whirl_frequency == pytest.approx(20.0, rel=1e-3)
    assert actual.whirl_scatter == pytest.approx(10.0 / np.sqrt(12.0), rel=0.02)


def test_maxima_of_an_ellipse_are_its_long_half_axis() -> None:
    """Seven records a turn: the maxima lie between them."""
    time = 0.01 * np.arange(100)
    turn = 2 * np.pi * 100.0 / 7.0 * time
    place = np.column_stack([3.0 * np.cos(turn), 2.0 * np.sin(turn)])
    velocity = 200.0 * np.pi / 7.0 * np.column_stack([-3.0 * np.sin(turn), 2.0 * np.cos(turn)])
    orbit = xr.Dataset(
        {"rotating": (("time", "axis"), place), "rotating_velocity": (("time", "axis"), velocity)},
        coords={"time": time},
    )
    peaks = radius_peaks(orbit)
    assert len(peaks) == 28  # twice a turn, the first record itself left out
    np.testing.assert_allclose(peaks, 3.0, rtol=0.02)


@pytest.mark.parametrize("records", [1, 2, 401])
def test_a_shaft_at_rest_has_no_whirl(records: int) -> None:
    result = synthetic.synthetic_result(shaft_radius=0.0, records=records, speed=0.0)
    actual = of(result)
    assert actual.late_radius == 0.0
    assert np.isnan(actual.whirl_frequency)
    assert actual.whirl_rotating == "none"
    assert actual.scenario == "at-rest"
    assert len(actual.section) == len(actual.radius_peak) == 0
