"""Results on disk: layout, growth, what a kill leaves, and that nothing infinite gets in."""

from dataclasses import fields, replace
from functools import cache
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import xarray as xr
from synthetic_result import synthetic_result

from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import with_values
from bladewhirl.models.inputs.timing import Timing
from bladewhirl.models.modal.stage_arrays import StageArrays
from bladewhirl.models.stage.build_beams import build_beams
from bladewhirl.postprocess.fields.result import open_result
from bladewhirl.solvers.march.march import Chunk, CoatingRecords
from bladewhirl.solvers.march.recorder import (
    Attribute,
    NonFiniteError,
    Recorder,
    histories_of,
    result_bytes,
)
from bladewhirl.solvers.march.schema import COATING, HISTORY, NAMES, RESULT, STAGE
from bladewhirl.solvers.march.storage import GuardedFile

SMALL = {
    "bladed_disk.blades": 5,
    "bladed_disk.elements_per_blade": 2,
    "casing.elements": 8,
    "reduction.fixed_interface_modes": 10,
}
SUPPORTS = {
    "casing.springs": [{"angle": 0.0, "radial": 1e6}, {"angle": 2.0, "tangential": 1e5}],
    "casing.struts": [{"angle": 3.0, "length": 0.2}],
}
NO_BEAMS = (
    "line",
    "wheel",
    "wheels",
    "rings",
    "further wheels",
    "further points",
    "waves",
    "waves of stress",
    "joints",
    "dampers",
    "nodes",
    "points",
    "waves",
    "waves of stress",
    "gauges",
    "stress",
    "speed",
    "critical",
    "inertia",
    "drive",
    "changes",
)
"""Parts that stages of beams at a constant speed do not have."""

ATTRIBUTES: dict[str, Attribute] = {
    "title": "made up",
    "speed": 100.0,
    "reference_frequency": 250.0,
    "clamped": 0,
}


@cache
def small_stage(*, supported: bool = False) -> StageArrays:
    if not supported:
        return build_beams(with_values(Case(), SMALL)).arrays
    return replace(
        build_beams(with_values(Case(), SMALL | SUPPORTS)).arrays,
        rotor_link=np.array([[3, 2]]),
        rotor_spring=np.array([[1, -1], [2, 5]]),
        mass_node=np.array([1, 4]),
        point_mass=np.array([0.25, 0.5]),
    )


def made_up(stage: StageArrays, first: int, count: int) -> Chunk:
    """Records whose every number tells where it belongs."""
    sizes = {
        "rotor_mode": len(stage.rotor_frequency),
        "casing_mode": len(stage.casing_frequency),
        "contact_node": len(stage.tip_node),
    }
    number = np.arange(first, first + count)
    values: dict[str, Any] = {"step": 100 * number, "time": 1e-4 * number}
    for place, (name, variable) in enumerate(histories_of(stage).items()):
        if name == "time":
            continue
        width = [sizes[dimension] for dimension in variable.dimensions[1:]]
        columns = np.arange(np.prod(width, dtype=int)).reshape(width)
        values[name] = number.reshape(-1, *[1] * len(width)) * 1000 + columns + place / 64
    for name in ("contact_steps", "contacts"):
        values[name] = values[name].astype(np.int64)
    return Chunk(**values)


def test_the_layout_covers_everything_there_is() -> None:
    assert [*STAGE] == [field.name for field in fields(StageArrays)]
    assert {*HISTORY} == {field.name for field in fields(Chunk)} - {"step", "coating"}
    assert {*COATING} - {"rod_angle"} == {field.name for field in fields(CoatingRecords)}


@pytest.mark.slow
def test_what_a_stage_has_none_of_is_left_out(tmp_path: Path) -> None:
    with Recorder(tmp_path / "result.nc", small_stage(), ATTRIBUTES) as recorder:
        recorder.write(made_up(small_stage(), 0, 1))
    with xr.open_dataset(tmp_path / "result.nc") as actual:
        missing = {*STAGE} - {*actual.variables}
        hung = {"rotor_link", "rotor_spring", "mass_node", "point_mass"}
        absent = {name for name in STAGE if STAGE[name].part in NO_BEAMS}
        assert missing == {name for name in STAGE if name.startswith("support_")} | hung | absent
        assert "support" not in actual.sizes


def test_a_result_grows_and_reads_back_to_the_last_bit(tmp_path: Path) -> None:
    stage = small_stage(supported=True)
    with Recorder(tmp_path / "result.nc", stage, ATTRIBUTES) as recorder:
        with h5py.File(tmp_path / "result.nc") as begun:  # what a kill before any record leaves
            assert begun.attrs["steps"] == len(begun["time"]) == 0
        for first, count in ((0, 7), (7, 0), (7, 200), (207, 1)):
            recorder.write(made_up(stage, first, count))
        assert (recorder.records, recorder.steps) == (208, 20_700)
        recorder.finish("completed", "", {"wall_time": 0.5})
    whole = made_up(stage, 0, 208)
    with xr.open_dataset(tmp_path / "result.nc") as actual:
        absent = {name for name in RESULT if RESULT[name].part in NO_BEAMS}
        absent |= {*COATING, "direction", "xyz", "stress_component"}
        absent |= {"shaft_component", "joint_direction", "joint_state", "joint_side"}
        assert {*actual.variables} == {*RESULT} - absent
        for name in actual.variables:
            variable = RESULT[str(name)]
            assert actual[name].dims == variable.dimensions
            assert actual[name].attrs["units"] == variable.units
            assert actual[name].attrs["long_name"] == variable.long_name
            kind = actual[name].dtype.kind
            assert kind in "OU" if variable.kind == "str" else kind == variable.kind[0]
            assert name in actual.coords or not variable.is_coordinate
        for name in histories_of(stage):
            np.testing.assert_array_equal(actual[name].values, getattr(whole, name))
        for name, given in stage.stored.items():
            np.testing.assert_array_equal(actual[name].values, given)
        assert actual["contact_steps"].dtype == np.int64
        assert actual["rotor_family"].values[0] == "1F"
        assert actual["rotor_shape"].sel(rotor_component="y").sizes["rotor_node"] == 16
        assert actual.encoding["unlimited_dims"] == {"time"}
        expected = {"end_reason": "completed", "end_message": "", "steps": 20_700, **ATTRIBUTES}
        assert {name: actual.attrs[name] for name in expected} == expected
        assert actual.attrs["wall_time"] == 0.5


def test_variables_and_dimensions_are_those_postprocess_is_tested_with(tmp_path: Path) -> None:
    stage = small_stage()
    model = synthetic_result(records=3)
    attributes: dict[str, Attribute] = {str(name): value for name, value in model.attrs.items()}
    with Recorder(tmp_path / "result.nc", stage, attributes) as recorder:
        recorder.write(made_up(stage, 0, 1))
    with open_result(tmp_path) as actual:
        assert {*model.variables} == {*actual.variables} - {*NAMES}
        for name, variable in model.variables.items():
            assert actual[name].dims == variable.dims
            text = variable.dtype.kind in "UO"
            assert actual[name].dtype.kind in ("UO" if text else variable.dtype.kind)


def test_a_number_that_is_not_finite_never_gets_in(tmp_path: Path) -> None:
    stage = small_stage()
    chunk = made_up(stage, 0, 6)
    gap = chunk.gap.copy()
    gap[4, 2] = np.inf
    velocity = chunk.rotor_velocity.copy()
    velocity[5, 0] = np.nan
    with Recorder(tmp_path / "result.nc", stage, ATTRIBUTES) as recorder:
        with pytest.raises(NonFiniteError, match="record 4 is not finite"):
            recorder.write(replace(chunk, gap=gap, rotor_velocity=velocity))
        assert (recorder.records, recorder.steps) == (4, 300)
        recorder.finish("divergent", "too far", {})
    with xr.open_dataset(tmp_path / "result.nc") as actual:
        assert actual.sizes["time"] == 4
        for name in actual.variables:
            if actual[name].dtype.kind == "f":
                assert np.isfinite(actual[name].values).all()


@pytest.mark.parametrize(("chunk", "chunks", "tolerance"), [(4000, 5, 0.02), (7, 1, 0.05)])
def test_the_size_of_a_result_is_foretold(
    tmp_path: Path, chunk: int, chunks: int, tolerance: float
) -> None:
    stage = small_stage()
    path = tmp_path / "result.nc"
    with Recorder(path, stage, ATTRIBUTES) as recorder:
        for number in range(chunks):
            recorder.write(made_up(stage, number * chunk, chunk))
    messages = result_bytes(
        stage, Timing(time_step=1.0, record_step=1.0, duration=chunk * chunks - 1.0), None
    )
    assert path.stat().st_size == pytest.approx(messages, rel=tolerance)


def test_what_a_file_contained_changes_only_at_the_next_check(tmp_path: Path) -> None:
    """Data at the end reach the disk at once; changes of earlier data, among them the header, are
    seen in the file object, but not on the disk before `check`."""
    path = tmp_path / "file"
    file = GuardedFile(path)
    file.write(b"a" * 300)
    file.check()
    for place, content in ((200, b"new" + b"a" * 97 + b"end"), (0, b"head")):
        file.seek(place)
        file.write(content)
    assert path.read_bytes() == b"a" * 300 + b"end"
    seen = bytearray(303)
    file.seek(0)
    file.readinto(seen)
    file.check()
    assert path.read_bytes() == bytes(seen) == b"head" + b"a" * 196 + b"new" + b"a" * 97 + b"end"
    file.close()
