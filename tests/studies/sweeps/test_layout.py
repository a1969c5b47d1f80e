"""Points of a sweep: sizes of what is kept, stages that they share, and records in memory."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_array_equal
from small_run import small

import bladewhirl as bw
from bladewhirl.models.case.file import with_values
from bladewhirl.models.case.template import dumps_case
from bladewhirl.models.stage.build import build_stage
from bladewhirl.models.stage.stage import Stage
from bladewhirl.postprocess.sweep.digest import digest
from bladewhirl.studies.runs.prepare import prepare
from bladewhirl.studies.runs.recorded_march import march_in_memory, march_to_file
from bladewhirl.studies.sweeps.axes import make_grid
from bladewhirl.studies.sweeps.layout import (
    MOST_LINES,
    MOST_SAMPLES,
    REACH,
    Extent,
    make_layout,
    march_extent,
)
from bladewhirl.studies.sweeps.plan import plan_sweep
from bladewhirl.studies.sweeps.points import Point, Work, march_point
from bladewhirl.studies.sweeps.stages import stage_at


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
    counted = {(blades, each.records): n for (blades, each), n in actual.histories.items()}
    assert counted == {(6, 201): 1, (9, 1001): 2}
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


@pytest.mark.slow
@pytest.mark.parametrize("effects", ["none", "centrifugal"])
def test_a_stage_is_that_of_the_speed_of_its_point(effects: str) -> None:
    slow, fast = (
        bw.case_from({"march": {"speed": speed}, "rotation": {"effects": effects}})
        for speed in (0.5, 1.5)
    )
    stages = [stage_at(case) for case in (slow, fast)]
    arrays: list[Any] = [stage.arrays for stage in stages]
    frequencies = [each.rotor_frequency for each in arrays]
    for case, actual in zip((slow, fast), frequencies, strict=True):
        assert_array_equal(actual, bw.build_stage(case).arrays.rotor_frequency)
    assert (frequencies[0] == frequencies[1]).all() == (effects == "none")


@pytest.mark.slow
def test_records_in_memory_are_those_in_a_file(tmp_path: Path) -> None:
    case = bw.case_from({"march": {"speed": 1.05, "duration": "5 ms", "record_step": "20 us"}})
    prepared = prepare(stage_at(case))
    report = march_to_file(prepared, tmp_path / "result.nc", "")
    kept, same = march_in_memory(prepared)
    clocks = {"wall_time", "us_per_step"}
    assert {name: report[name] for name in report if name not in clocks} == {
        name: same[name] for name in same if name not in clocks
    }
    with bw.open_result(tmp_path) as actual:
        assert {*kept.variables} == {*actual.variables}
        assert {*kept.coords} == {*actual.coords}
        for name in kept.variables:
            assert kept[name].dims == actual[name].dims
            assert_array_equal(kept[name].values, actual[name].values)
        assert {*actual.attrs} == {*kept.attrs}


@pytest.mark.slow
def test_points_that_share_their_room_are_those_marched_in_their_own() -> None:
    """The second is shorter, the third has more records than the room that the first left."""
    case = bw.case_from({"march": {"speed": 1.05, "record_step": "20 us"}})
    grid = make_grid(case, {"march.duration": [0.004, 0.002, 0.006]}, large=False)
    layout = plan_sweep(case, grid).layout
    work = Work(case=dumps_case(case), layout=layout, histories="")
    points = [Point(number=number, values=grid.values(number)) for number in range(grid.size)]
    for shared, at_point in zip(
        [march_point(work, p) for p in points], grid.cases(case), strict=True
    ):
        own = digest(*march_in_memory(prepare(stage_at(at_point))), layout)
        assert isinstance(shared, dict)
        for name in own:
            assert_array_equal(shared[name], own[name])
