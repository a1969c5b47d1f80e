"""State space and Poincaré map, against motions that repeat and some that do not."""

import numpy as np
import pytest
import synthetic_result as synthetic
import xarray as xr

import bladewhirl as bw

RADIUS = 0.8e-3


def synchronous(speed: float = synthetic.SPEED) -> xr.Dataset:
    """A shaft at a fixed place of the rotor, whose static circle has the speed of rotation."""
    place = [RADIUS, 0, 0, 0, 0]
    return bw.shaft_orbit(synthetic.resting(1001, speed, rotor_displacement=place))


class TestPoincareMap:
    @pytest.mark.parametrize("speed", [80.0, 77.7, -80.0])
    def test_a_synchronous_orbit_is_a_point(self, speed: float) -> None:
        points = bw.poincare_map(synchronous(speed))
        assert points.sizes["time"] == 1 + int(abs(speed) / (2 * np.pi))
        np.testing.assert_allclose(points.place, [[RADIUS, 0.0]] * len(points.time), atol=1e-9)
        np.testing.assert_allclose(
            points.velocity, [[0.0, RADIUS * speed]] * len(points.time), atol=1e-6
        )

    def test_another_circle_makes_a_ring_of_points_at_their_angles(self) -> None:
        """10 rad/s in static axes, 80 of rotation: an eighth of a turn a revolution."""
        orbit = bw.shaft_orbit(synthetic.synthetic_result(records=2001))
        points = bw.poincare_map(orbit)
        angle = 2 * np.pi / 8 * np.arange(points.sizes["time"])
        ring = RADIUS * np.column_stack([np.cos(angle), np.sin(angle)])
        np.testing.assert_allclose(points.place, ring, atol=1e-10)
        np.testing.assert_allclose(points.time, 2 * np.pi / 80 * np.arange(len(angle)))

    def test_a_window_keeps_the_phase_of_the_revolutions(self) -> None:
        orbit = bw.shaft_orbit(synthetic.synthetic_result(records=2001))
        whole, part = bw.poincare_map(orbit), bw.poincare_map(orbit.isel(time=slice(700, 1500)))
        kept = whole.sel(time=slice(0.7, 1.499))
        np.testing.assert_allclose(part.time, kept.time, rtol=1e-12)
        np.testing.assert_allclose(part.place, kept.place, atol=1e-10)

    def test_without_a_revolution_there_is_no_map(self) -> None:
        orbit = synchronous()
        with pytest.raises(bw.ViewError, match=r"one revolution or more.* 0\.115"):
            bw.poincare_map(orbit.isel(time=slice(5, 15)))
        with pytest.raises(bw.ViewError, match="one revolution or more"):
            bw.poincare_map(synchronous(speed=0.0))
