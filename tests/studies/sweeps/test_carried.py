"""Sweeps that carry the motion from speed to speed: order, state, interruptions, hysteresis."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from small_run import small
from sweep_work import InProcess, Killed, assert_carried_on, same_bits

import bladewhirl as bw
from bladewhirl.models.stage.build import build_stage
from bladewhirl.models.stage.modal_loads import NEVER, Load
from bladewhirl.postprocess.sweep.dataset import DONE, MISSING, flag, open_sweep
from bladewhirl.studies.runs.prepare import prepare
from bladewhirl.studies.runs.recorded_march import march_in_memory
from bladewhirl.studies.sweeps.carried import COMPLETED, Chains, continued, late_state
from bladewhirl.studies.sweeps.stages import stage_at

DIVERGENT = flag("end_reason", "divergent")
FREE = {
    "casing.clearance": 0.2,
    "excitation": {"type": "engine-order", "order": 2, "amplitude": 1e3},
    "damping.ratio": 0.02,
    "march.time_step": 4e-6,
}


def chains(carry: Any, state: list[int], end_reason: int = COMPLETED) -> Chains:
    """Two chains of three speeds, which are not in order."""
    ends = np.full(6, end_reason, dtype=np.int8)
    return Chains((3, 2), 0, np.array([2.0, 3.0, 1.0]), carry, np.array(state, np.int8), ends)


def test_points_of_a_chain_follow_each_other() -> None:
    order = chains("up", [MISSING] * 6)
    points = order.next_points()
    assert [next(points) for _ in range(4)] == [(4, None), (5, None), None, None]
    order.take(5, COMPLETED)
    assert [next(points), next(points)] == [(1, 5), None]
    order.take(1, DIVERGENT)
    order.take(4, None)
    assert [next(points) for _ in range(3)] == [(0, None), (3, None), None]
    for number in (0, 3, 2):
        order.take(number, COMPLETED)
    assert list(points) == []
    assert next(chains("down", [MISSING] * 6).next_points()) == (2, None)


def test_a_resumed_chain_goes_on_behind_its_last_finished_point() -> None:
    state = [MISSING, DONE, DONE, DONE, DONE, DONE]  # speeds 2, 3 and 1 of two chains
    points = chains("up", state).next_points()
    assert [next(points), next(points)] == [(0, 4), None]
    assert next(chains("up", state, DIVERGENT).next_points()) == (0, None)


@pytest.mark.parametrize("effects", ["none", "full"])
def test_a_march_in_two_parts_is_one_march(effects: str) -> None:
    """At the same speed the carried motion goes on: after whole revolutions the forces of an engine
    order are those of the start."""
    changes = {**FREE, "rotation.effects": effects, "march.record_step": 8e-6}
    turn = 2.0 * np.pi / stage_at(small(**changes)).speed
    case = small(**changes, **{"march.duration": 8e-6 * round(2.5 * turn / 8e-6)})
    assert_carried_on(build_stage(case), "rotor_displacement", "rotor_velocity")


def test_loads_go_on_without_ramp_and_pulses_are_over() -> None:
    loads: Any = [{"type": "casing-distortion"}, {"type": "engine-order", "ramp": 0.3}]
    stage = build_stage(small(excitation=loads))
    prepared = prepare(stage)
    result, _ = march_in_memory(prepared)
    after = continued(stage, prepared.problem, late_state(stage, result))
    assert [load.ramp for load in after.loads] == [0.0, 0.0]
    assert all(load.end == NEVER for load in after.loads)
    expected = [replace(load, ramp=0.0) for load in prepared.problem.loads[1:]]
    for load, other in zip(after.loads, expected, strict=True):
        assert isinstance(load, Load)
        np.testing.assert_array_equal(load.rotor, other.rotor)


def short() -> bw.Case:
    case = small(**FREE)
    return small(**FREE, **{"march.duration": 3.4 * 2.0 * np.pi / stage_at(case).speed})


@pytest.mark.slow
def test_neither_workers_nor_kills_change_the_file(process: InProcess, tmp_path: Path) -> None:
    over: Any = {"march.speed": [1.0, 1.1], "contact.friction": [0.1, 0.2]}
    case = short()
    bw.run_sweep(case, over, tmp_path / "one", carry="down", workers=1)
    process.left = 3
    with pytest.raises(Killed):
        bw.run_sweep(case, over, tmp_path / "two", carry="down", workers=2)
    process.left = 10**9
    assert len(list((tmp_path / "two" / "states").iterdir())) == 3
    bw.resume_sweep(tmp_path / "two", workers=2)
    assert same_bits(tmp_path / "one", tmp_path / "two")
    assert not (tmp_path / "two" / "states").exists()
    bw.run_sweep(case, over, tmp_path / "up", carry="up", workers=2)
    with open_sweep(tmp_path / "one") as down, open_sweep(tmp_path / "up") as up:
        assert down.attrs["carry"] == "down"
        same = [
            np.array_equal(down["spectrum"].sel(march_speed=at), up["spectrum"].sel(march_speed=at))
            for at in (1.0, 1.1)
        ]
    assert same == [False, False]  # each is the first speed of one of the two sweeps
