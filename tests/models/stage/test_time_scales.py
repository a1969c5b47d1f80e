"""Hints and refusals where a time step, a duration or a start does not fit the case."""

from typing import Any

import pytest

import bladewhirl as bw
from bladewhirl.models.case.plausibility import case_hints
from bladewhirl.models.case.sensors import StrainGauge
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.stage.hints import stage_hints
from bladewhirl.studies.runs.prepare import prepare

STAGE: dict[str, Any] = {
    "bladed_disk": {"blades": 5, "elements_per_blade": 2},
    "casing": {"elements": 20, "support": 8e6},
}


def case(march: dict[str, Any], **tables: Any) -> bw.Case:
    return bw.case_from(STAGE | {"march": {"time_step": 1e-6} | march} | tables)


def test_a_force_faster_than_the_steps_is_mentioned() -> None:
    for hertz, mentioned in ((1e12, True), (2e5, True), (5e4, False)):
        load = {"type": "harmonic", "frequency": hertz}
        said = " ".join(case_hints(case({"time_step": 2e-6}, excitation=load)))
        assert ("a period has" in said) == mentioned


def test_a_run_up_after_the_end_is_mentioned() -> None:
    run_up = {"from": 0.5, "to": 0.6, "start": "50 ms", "end": "60 ms"}
    for duration, mentioned in ((0.05, True), (0.055, False)):
        said = " ".join(case_hints(case({"run_up": run_up, "duration": duration})))
        assert ("begins after the end of the march" in said) == mentioned


def test_losses_within_a_step_are_mentioned() -> None:
    for loss, mentioned in ((1e9, True), (1.0, False)):
        drive = {"inertia": 1.0, "loss": loss}
        stage = bw.build_stage(case({"speed": "100 rad/s", "drive": drive}))
        assert ("march.drive.loss" in " ".join(stage_hints(stage))) == mentioned


def test_a_drive_whose_imbalance_starts_in_the_wall_is_refused() -> None:
    tables = {"rotation": {"effects": "full"}, "shaft": {"stiffness": 2e7}}
    for unbalance, allowed in ((50.0, False), (1e-3, True)):
        load = {"type": "imbalance", "unbalance": unbalance, "ramp": 0.0}
        drive = {"speed": "300 rad/s", "drive": {"inertia": 1.0}, "duration": 1e-3}
        given = case(drive, excitation=load, **tables)
        if allowed:
            prepare(given)
            continue
        with pytest.raises(CaseError, match=r"casing\.clearance.*imbalance acts from the start"):
            prepare(given)


def test_tiny_directions_of_gauges_are_directions() -> None:
    tiny, unit = (
        StrainGauge(type="strain", point=3, direction=(size, 0.0, 0.0)) for size in (1e-300, 1.0)
    )
    assert tiny.direction == unit.direction
