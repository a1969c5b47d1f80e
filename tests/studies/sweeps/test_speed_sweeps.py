"""Sweeps over the acceleration, the torque of a drive and the time of the loss of a blade."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sweep_work import CASE, InProcess, Killed, same_bits

import bladewhirl as bw
from bladewhirl.studies.runs.prepare import prepare
from bladewhirl.studies.runs.recorded_march import march_in_memory
from bladewhirl.studies.sweeps.sweep import resume_sweep, run_sweep

TURNING = {"rotation.effects": "full", "excitation.ramp": 0.0, "casing.clearance": 0.02}
FREE = {
    "march.speed": 1.0,
    "march.drive": {"inertia": 0.1},
    "excitation.clearance_speed": 3.0,  # at the start the tips are inside the wall
}
RISING = {"march.run_up": {"from": 0.9, "to": 1.05, "end": 6e-3}, "march.speed": None}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("changes", "key", "values"),
    [
        ({"blade_loss": {"blade": 2, "time": 2e-3}}, "blade_loss.time", [2e-3, 4e-3]),
        (FREE, "march.drive.torque", [-50.0, 50.0]),
        (RISING, "march.run_up.end", [4e-3, 6e-3]),
    ],
)
def test_points_are_marches_also_after_a_kill(
    tmp_path: Path, process: InProcess, changes: dict[str, Any], key: str, values: list[float]
) -> None:
    given = bw.with_values(CASE, TURNING | changes)
    whole = run_sweep(given, {key: values}, tmp_path / "whole")
    assert whole.failed == 0
    process.left = 1
    with pytest.raises(Killed):
        run_sweep(given, {key: values}, tmp_path / "part")
    process.left = 10**9
    assert resume_sweep(tmp_path / "part").failed == 0
    with bw.open_sweep(tmp_path / "whole") as one:
        assert same_bits(tmp_path / "whole", tmp_path / "part")
        largest = one["shaft_radius_max"].values
        result, _ = march_in_memory(prepare(bw.with_values(given, {key: values[0]})))
        radius = bw.shaft_orbit(result)["radius"].values.max()
        np.testing.assert_array_equal(largest[0], radius)
        assert np.unique(largest).size == 2


def test_a_ramp_that_is_too_fast_for_the_records_is_refused(tmp_path: Path) -> None:
    given = bw.with_values(CASE, TURNING | RISING)
    with pytest.raises(bw.UserError, match=r"end = 1e-4: march\.record_step = 5e-5: expected"):
        run_sweep(given, {"march.run_up.end": [1e-4, 6e-3]}, tmp_path / "new")
    assert not (tmp_path / "new").exists()


@pytest.mark.slow
def test_an_early_end_is_refused_where_the_loss_of_a_blade_leaves_an_imbalance(
    tmp_path: Path,
) -> None:
    lost = {"blade_loss": {"blade": 2, "time": 2e-3}, "excitation": {"type": "none"}}
    given = bw.with_values(CASE, lost)
    with pytest.raises(bw.UserError, match="but after the loss of a blade a load never ends"):
        run_sweep(given, {"blade_loss.time": [2e-3, 3e-3]}, tmp_path / "new", stop_when="damped")
