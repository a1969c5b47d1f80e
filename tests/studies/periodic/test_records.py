"""A turn of a periodic motion as a run."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import answer
from periodic_cases import case
from places import ROOT

import bladewhirl as bw
from bladewhirl.postprocess.fields.kinematics import closure_change

SMALL = {"march.speed": "7500 rpm"}


@pytest.mark.slow
@pytest.mark.parametrize(
    "changes",
    [{"casing.slope": "3 deg", "march.speed": "5000 rpm"}, {"bladed_disk.superelement.copies": 2}],
)
def test_a_record_has_the_motion(changes: dict[str, Any], tmp_path: Path) -> None:
    """Also in a cone, and with a second blade, which turns behind the first."""
    own = case(**{**SMALL, **changes})
    data = bw.periodic(own)
    bw.record_motion(own, data, tmp_path / "motion")
    one = data.isel(speed=0)
    with bw.open_result(tmp_path / "motion") as result:
        blade = result["contact_displacement"].values[:, : one.sizes["node"]]
        share = np.mod(result["time"].values / float(one["period"]), 1.0)
        impulse = result["contact_impulse"].values[:, : one.sizes["node"]].sum()
        wall = closure_change(result, np.array([0]), np.zeros(1))
    assert wall == pytest.approx(-1e-4)  # pictures show the casing at the end of its closure
    assert impulse == pytest.approx(float(one["impulse_per_revolution"]), rel=1e-2)
    expected = one["contact_displacement"].values
    grid = np.arange(len(expected) + 1) / len(expected)
    closed = np.concatenate([expected, expected[:1]])
    for node in range(expected.shape[1]):
        for way in range(3):
            there = np.interp(share, grid, closed[:, node, way])
            assert blade[:, node, way] == pytest.approx(there, abs=0.01 * np.ptp(expected))


@pytest.mark.slow
def test_films_show_the_motion_of_an_imbalance(tmp_path: Path) -> None:
    file, folder = ROOT / "examples" / "imbalance.toml", tmp_path / "motion"
    answer("periodic", file, "-o", folder)
    with bw.open_result(folder) as result:
        radius = np.hypot(*(result["centre_shape"].values @ result["rotor_displacement"].values.T))
        turns = result["time"].values[-1] * result.attrs["speed"] / (2.0 * np.pi)
        assert bw.export_vtk(result, tmp_path / "vtk", frames=4).exists()
    assert radius == pytest.approx(radius[0], rel=2e-4)
    assert turns == pytest.approx(1.0, abs=0.01)


@pytest.mark.slow
def test_a_march_that_leaves_the_motion_is_no_record(tmp_path: Path) -> None:
    own = case(**SMALL)
    data = bw.periodic(own)
    with pytest.raises(bw.ViewError, match=r"grow by a factor of .*e"):
        bw.record_motion(own, data.assign(multipliers=1e3 * data["multipliers"]), tmp_path / "m")
    several = data.isel(speed=[0, 0]).assign(rpm=("speed", [7400.0, 7500.0]))
    with pytest.raises(bw.UserError, match="2 speeds; expected one"):
        bw.record_motion(own, several, tmp_path / "m")
    assert not (tmp_path / "m").exists()
