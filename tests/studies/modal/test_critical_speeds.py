"""Map of critical speeds over shaft stiffness, compared with frequencies at rest and at speed."""

import json
from pathlib import Path

import numpy as np
import pytest
from command_line import answer

import bladewhirl as bw
from bladewhirl.models.modal.full_stage import modal_stage
from bladewhirl.models.rotation.waves import waves
from bladewhirl.postprocess.modal.veering import plot_critical_speeds
from bladewhirl.studies.modal.critical_speeds import ORDERS, critical_speeds

RPM = 30.0 / np.pi


def small(**tables: object) -> bw.Case:
    blades = {"blades": 6, "elements_per_blade": 3}
    return bw.case_from({"bladed_disk": blades, "rotation": {"effects": "full"}, **tables})


def test_a_disk_on_soft_springs_is_critical_at_its_frequency_at_rest() -> None:
    soft = 1e3  # N/m
    stage = modal_stage(bw.with_values(small(), {"shaft.stiffness": soft}))
    (pair,) = {float(f) for f in stage.free_modes.frequency[:2].round(9)}
    speeds = critical_speeds(stage, stiffnesses=np.array([soft, 4.0 * soft]))
    lowest = speeds["critical_speed"].isel(branch=0)
    np.testing.assert_allclose(lowest.isel(stiffness=0), pair * RPM, rtol=1e-4)
    np.testing.assert_allclose(lowest.isel(stiffness=1), 2.0 * pair * RPM, rtol=1e-3)
    np.testing.assert_allclose(speeds["spring_share"].isel(branch=0), 1.0, rtol=1e-3)


@pytest.mark.parametrize("stiffness", [1e6, 1e8])
def test_the_shaft_whirls_at_the_speed_of_rotation(stiffness: float) -> None:
    speeds = critical_speeds(small(), stiffnesses=np.array([stiffness]))["critical_speed"]
    own = modal_stage(bw.with_values(small(), {"shaft.stiffness": stiffness}))
    assert own.turning is not None
    block = waves(own.turning.matrices, 1, "full")
    for direction, order in ORDERS.items():
        for rpm in speeds.sel(direction=direction).values.ravel():
            nearest = np.abs(block.frequencies(rpm / RPM) - order * rpm / RPM).min()
            assert nearest < 1e-5 * rpm / RPM


def test_the_command_lists_the_speeds_of_the_case(tmp_path: Path) -> None:
    file = tmp_path / "case.toml"
    file.write_text(bw.dumps_case(small()), encoding="utf-8")
    document = json.loads(answer("critical-speeds", file, "--json", "--branches", "1").stdout)
    assert document["stiffness"] == small().shaft.stiffness
    speeds = critical_speeds(small(), stiffnesses=np.array([document["stiffness"]]), branches=1)
    expected = speeds["critical_speed"].values.ravel()
    assert [row["rpm"] for row in document["critical_speeds"]] == pytest.approx(expected)
    assert [row["direction"] for row in document["critical_speeds"]] == list(ORDERS)


def test_the_figure_has_a_line_a_branch() -> None:
    springs = np.geomspace(1e6, 1e9, 5)
    axes = plot_critical_speeds(critical_speeds(small(), stiffnesses=springs)).axes[0]
    assert len(axes.collections) == 4
    assert axes.get_xlim() == (1e6, 1e9)
