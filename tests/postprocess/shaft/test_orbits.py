"""The shaft's orbit and its Poincaré map, against circles and lines in closed form."""

import numpy as np
import pytest
import synthetic_result as synthetic
import xarray as xr
from matplotlib.figure import Figure

import bladewhirl as bw
from bladewhirl.postprocess.shaft.orbits import plot_orbit, shaft_orbit
from bladewhirl.postprocess.shaft.whirl import whirl

RADIUS = 0.8e-3
RATE = 70.0  # rad/s, backward in rotating axes: what the synthetic shaft does


class TestShaftOrbit:
    def test_a_backward_circle_turns_at_the_speed_less_its_rate_in_static_axes(self) -> None:
        orbit = shaft_orbit(synthetic.synthetic_result())
        time = orbit.time.values
        back, on = -RATE * time, (synthetic.SPEED - RATE) * time
        np.testing.assert_allclose(
            orbit.rotating, RADIUS * np.column_stack([np.cos(back), np.sin(back)]), atol=1e-17
        )
        np.testing.assert_allclose(
            orbit.static, RADIUS * np.column_stack([np.cos(on), np.sin(on)]), atol=1e-16
        )
        np.testing.assert_allclose(orbit.radius, RADIUS, rtol=1e-13)

    def test_velocities_are_those_of_the_circles(self) -> None:
        orbit = shaft_orbit(synthetic.synthetic_result())
        for frame, rate in (("rotating", -RATE), ("static", synthetic.SPEED - RATE)):
            place = orbit[frame].values
            around = rate * np.column_stack([-place[:, 1], place[:, 0]])
            np.testing.assert_allclose(orbit[f"{frame}_velocity"], around, atol=1e-14)

    def test_a_centre_fixed_in_the_rotor_goes_round_with_it(self) -> None:
        orbit = shaft_orbit(synthetic.resting(401, rotor_displacement=[RADIUS, 0, 0, 0, 0]))
        assert whirl(orbit, "rotating").direction == "none"
        assert whirl(orbit, "static").direction == "forward"
        assert whirl(orbit, "static").rate == pytest.approx(synthetic.SPEED, rel=1e-12)


class TestPlotOrbit:
    def figure(self, **parameters: float) -> Figure:
        return plot_orbit(shaft_orbit(synthetic.synthetic_result(**parameters)))  # type: ignore[arg-type]

    def test_two_frames_with_equal_axes_in_mm(self) -> None:
        rotating, static, _ = self.figure().axes
        for axes, name in ((rotating, "rotating"), (static, "static")):
            assert name in axes.get_title()
            assert axes.get_aspect() == 1.0
            assert axes.get_xlabel() == "x [mm]"
            assert axes.get_xlim() == axes.get_ylim() == pytest.approx((-1.1, 1.1))
        assert "backward, 11.1 Hz" in rotating.get_title()
        assert "forward, 1.59 Hz" in static.get_title()

    @pytest.mark.parametrize(("records", "seconds"), [(401, 0.4 / 3), (2001, 4 * np.pi / RATE)])
    def test_strong_lines_are_the_last_two_turns_within_the_last_third(
        self, records: int, seconds: float
    ) -> None:
        rotating, static, radius = self.figure(records=records).axes
        for axes, rate in ((rotating, RATE), (static, synthetic.SPEED - RATE)):
            (late,) = [mark for mark in axes.lines if str(mark.get_label()).startswith("last ")]
            path = np.asarray(late.get_xydata())
            angle = np.unwrap(np.arctan2(path[:, 1], path[:, 0]))
            turned = abs(angle[-1] - angle[0])
            assert turned == pytest.approx(rate * seconds, abs=rate * 1.1e-3)
        assert np.ptp(np.asarray(radius.lines[0].get_xdata())) == pytest.approx(seconds, abs=1.1e-3)

    def test_a_shaft_at_rest_and_no_clearance(self) -> None:
        result = synthetic.synthetic_result(shaft_radius=0.0, records=2)
        result["clearance"] = 0.0 * result["clearance"]
        for axes in plot_orbit(shaft_orbit(result)).axes[:2]:
            assert "at rest" in axes.get_title()
            assert axes.get_xlim() == (-1.0, 1.0)


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
