"""Points of a sweep: stages that they share or may not, and records in memory."""

from pathlib import Path

import pytest
from numpy.testing import assert_array_equal

import bladewhirl as bw
from bladewhirl.models.case.template import dumps_case
from bladewhirl.models.stage.stage import Stage
from bladewhirl.postprocess.sweep.digest import digest
from bladewhirl.studies.runs.prepare import prepare_any
from bladewhirl.studies.runs.recorded_march import march_in_memory, march_to_file
from bladewhirl.studies.sweeps.axes import make_grid
from bladewhirl.studies.sweeps.plan import plan_sweep
from bladewhirl.studies.sweeps.points import Point, Work, march_point, stage_at


@pytest.mark.parametrize("effects", ["none", "centrifugal"])
def test_a_stage_is_that_of_the_speed_of_its_point(effects: str) -> None:
    slow, fast = (
        bw.case_from({"march": {"speed": speed}, "rotation": {"effects": effects}})
        for speed in (0.5, 1.5)
    )
    stages = [stage_at(case) for case in (slow, fast)]
    frequencies = [stage.arrays.rotor_frequency for stage in stages if isinstance(stage, Stage)]
    for case, actual in zip((slow, fast), frequencies, strict=True):
        assert_array_equal(actual, bw.build_stage(case).arrays.rotor_frequency)
    assert (frequencies[0] == frequencies[1]).all() == (effects == "none")


def test_records_in_memory_are_those_in_a_file(tmp_path: Path) -> None:
    case = bw.case_from({"march": {"speed": 1.05, "duration": "5 ms", "record_step": "20 us"}})
    prepared = prepare_any(stage_at(case))
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
        assert {*actual.attrs} - {*kept.attrs} == {"format"}


def test_points_that_share_their_room_are_those_marched_in_their_own() -> None:
    """The second is shorter, the third has more records than the room that the first left."""
    case = bw.case_from({"march": {"speed": 1.05, "record_step": "20 us"}})
    grid = make_grid(case, {"march.duration": [0.004, 0.002, 0.006]}, large=False)
    layout = plan_sweep(case, grid, histories=False).layout
    work = Work(case=dumps_case(case), layout=layout, histories="")
    points = [Point(number=number, values=grid.values(number)) for number in range(grid.size)]
    for shared, at_point in zip(
        [march_point(work, p) for p in points], grid.cases(case), strict=True
    ):
        own = digest(*march_in_memory(prepare_any(stage_at(at_point))), layout)
        assert isinstance(shared, dict)
        for name in own:
            assert_array_equal(shared[name], own[name])
