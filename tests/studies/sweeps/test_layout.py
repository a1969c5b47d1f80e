"""Sizes of what a sweep keeps: one for all of its points, whatever their marches."""

import numpy as np
import pytest
from small_run import small

from bladewhirl.models.case.file import with_values
from bladewhirl.models.stage.stage import Stage, build_stage
from bladewhirl.studies.sweeps.layout import (
    MOST_LINES,
    MOST_SAMPLES,
    REACH,
    Extent,
    make_layout,
    march_extent,
)


@pytest.fixture(scope="module")
def stage() -> Stage:
    return build_stage(small())


def extent(*durations: float, record_step: float = 1e-4) -> Extent:
    values = {"march.record_step": record_step}
    return march_extent(small(**{"march.duration": d, **values}) for d in durations)


def test_the_extent_is_that_of_all_points() -> None:
    more = with_values(small(**{"march.duration": 0.1}), {"bladed_disk.blades": 9})
    actual = march_extent([small(**{"march.duration": 0.02}), more, more])
    assert (actual.shortest, actual.record_step) == (0.02, 1e-4)
    assert (actual.steps, actual.most_steps) == (10_000 + 2 * 50_000, 50_000)
    assert actual.histories == {(6, 201): 1, (9, 1001): 2}
    assert (actual.blades, actual.records) == (9, 1001)


def test_lines_are_multiples_of_one_over_the_window_of_the_shortest(stage: Stage) -> None:
    layout = make_layout(extent(0.4, 1.0), stage)
    assert layout.window == pytest.approx(0.2)
    np.testing.assert_allclose(np.diff(layout.frequency), 5.0)
    np.testing.assert_allclose(layout.frequency, -layout.frequency[::-1])
    highest = REACH * stage.reference_frequency / (2.0 * np.pi)
    assert highest - 5.0 < layout.frequency[-1] <= highest
    assert (layout.samples, layout.blades, layout.nodal_diameters) == (MOST_SAMPLES, 6, 4)


def test_what_coarse_records_do_not_resolve_is_left_out(stage: Stage) -> None:
    layout = make_layout(extent(0.4, record_step=2e-3), stage)
    assert layout.frequency[-1] == pytest.approx(250.0)
    assert layout.samples == 201


def test_very_long_marches_reach_less_far(stage: Stage) -> None:
    assert len(make_layout(extent(1000.0), stage).frequency) == MOST_LINES
    assert len(make_layout(extent(1e-3), stage).frequency) >= 3
    instant = make_layout(extent(0.0), stage)
    assert np.isfinite(instant.frequency).all()
    assert instant.samples == 1
