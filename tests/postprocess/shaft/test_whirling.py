"""Windows of time and the whirl over time, against circles in closed form."""

import numpy as np
import pytest
import synthetic_result as synthetic

from bladewhirl.postprocess.fields.kinematics import ViewError
from bladewhirl.postprocess.fields.windows import (
    evenly_spaced,
    late_part,
    select_window,
    span_edges,
    span_means,
    span_starts,
)
from bladewhirl.postprocess.shaft.orbits import shaft_orbit
from bladewhirl.postprocess.shaft.whirl_history import plot_whirl_history, whirl_history


class TestWindows:
    def test_a_window_holds_both_its_ends(self) -> None:
        window = select_window(synthetic.synthetic_result(), 0.1, 0.3)
        assert window.time.values[0] == pytest.approx(0.1)
        assert window.time.values[-1] == pytest.approx(0.3)
        assert window.sizes["time"] == 201

    @pytest.mark.parametrize(("start", "end"), [(0.3, 0.1), (0.5, None), (0.1, 0.1003)])
    def test_a_window_that_shows_nothing_is_refused(self, start: float, end: float | None) -> None:
        with pytest.raises(
            ViewError, match=r"window .* expected (a start before|at least two records)"
        ):
            select_window(synthetic.synthetic_result(), start, end)

    def test_the_late_part_is_the_last_third(self) -> None:
        late = late_part(synthetic.synthetic_result(records=301))
        assert late.time.values[[0, -1]] == pytest.approx([0.2, 0.3])

    def test_a_last_record_that_came_early_is_dropped_from_spectra(self) -> None:
        result = synthetic.synthetic_result(records=40)
        time = result.time.values.copy()
        time[-1] -= 0.3e-3
        even, step = evenly_spaced(result.assign_coords(time=time), 16)
        assert even.sizes["time"] == 39
        assert step == pytest.approx(synthetic.RECORD_STEP)

    def test_a_step_that_changes_is_refused(self) -> None:
        result = synthetic.synthetic_result(records=40)
        time = result.time.values.copy()
        time[20:] += 0.5e-3
        with pytest.raises(ViewError, match=r"step changes at 0\.019 s"):
            evenly_spaced(result.assign_coords(time=time), 16)

    def test_spans_share_the_records_out(self) -> None:
        time = np.arange(1001.0)
        starts = span_starts(time, 10)
        np.testing.assert_array_equal(starts, 100 * np.arange(10))
        edges = span_edges(time, starts, -1.0)
        np.testing.assert_array_equal(edges, [-1, *(100 * np.arange(1, 10) - 1), 1000])
        assert span_means(time, starts)[:2] == pytest.approx([49.5, 149.5])


class TestWhirlHistory:
    """`verify results` compares the rates of circles in both frames with their frequency."""

    def test_a_slow_circle_has_its_direction_in_every_span(self) -> None:
        whirls = whirl_history(synthetic.synthetic_result(records=2001))
        np.testing.assert_array_equal(whirls.direction.sel(frame="static"), 1)

    def test_a_rate_that_changes_is_followed(self) -> None:
        orbit = shaft_orbit(synthetic.synthetic_result(records=4001))
        time = orbit.time.values
        angle, rate = -90 * time + 5 * time**2, -90 + 10 * time
        place = 1e-3 * np.column_stack([np.cos(angle), np.sin(angle)])
        orbit["rotating"] = ("time", "axis"), place
        orbit["rotating_velocity"] = (
            ("time", "axis"),
            rate[:, None] * place[:, ::-1] * [-1.0, 1.0],
        )
        orbit["radius"] = "time", np.full(len(time), 1e-3)
        whirls = whirl_history(orbit)
        expected = -90 + 10 * whirls.time
        np.testing.assert_allclose(whirls.rate.sel(frame="rotating"), expected, rtol=1e-10)
        np.testing.assert_allclose(whirls.radius, 1e-3, rtol=1e-12)
        assert whirls.sizes["time"] > 5
        np.testing.assert_array_equal(whirls.direction.sel(frame="rotating"), -1)

    def test_a_shaft_at_rest_has_neither_rate_nor_direction(self) -> None:
        whirls = whirl_history(synthetic.synthetic_result(shaft_radius=0.0))
        assert np.isnan(whirls.rate).all()
        assert not whirls.direction.any()
        plot_whirl_history(whirls)
