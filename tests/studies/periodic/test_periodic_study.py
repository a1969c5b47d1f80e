"""Dataset and command of periodic motions."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from command_line import answer, refusal
from periodic_cases import case
from typer.testing import CliRunner

import bladewhirl as bw
from bladewhirl.studies.commands.cli import app


@pytest.mark.slow
@pytest.mark.parametrize(("speed", "slope"), [(7000.0, 0.0), (5000.0, "3 deg")])
def test_a_motion_is_that_of_a_long_run(tmp_path: Path, speed: float, slope: Any) -> None:
    """Also in a conical wall, in which displacements and forces have other axes."""
    own = case(**{"casing.slope": slope, "march.speed": f"{speed} rpm"})
    data = bw.periodic(own).isel(speed=0)
    assert data["stable"]
    bw.run(own, tmp_path / "run", frames=0)
    turn = 60.0 / speed
    with bw.open_result(tmp_path / "run") as result:
        last = result["contact_impulse"].sel(time=slice(0.4 - 20.0 * turn, None)).sum()
        moved = result["contact_displacement"].sel(time=slice(0.3, None)).load()
    assert data["impulse_per_revolution"] == pytest.approx(float(last) / 20.0, rel=1e-2)
    for number, direction in enumerate(("radial", "tangential", "axial")):
        periodic = data["contact_displacement"].sel(direction=direction)
        marched = moved[..., number]
        for one, other in ((periodic.min(), marched.min()), (periodic.max(), marched.max())):
            assert float(one) == pytest.approx(float(other), abs=1e-2 * float(abs(marched).max()))


@pytest.mark.slow
def test_a_dataset_describes_motions_at_speeds() -> None:
    data = bw.periodic(case(), speeds=["7000 rpm", "11000 rpm"])
    assert data["rpm"].values == pytest.approx([7000.0, 11000.0])
    assert data["period"].values == pytest.approx([30.0 / 7000.0, 30.0 / 11000.0])
    assert data["order"].values[:3].tolist() == [0, 2, 4]
    moved, amplitude = data["contact_displacement"], data["amplitude"]
    assert amplitude.isel(order=0).values == pytest.approx(np.abs(moved.mean("instant").values))
    square = amplitude.isel(order=0) ** 2 + 0.5 * (amplitude[:, 1:] ** 2).sum("order")
    assert square.values == pytest.approx((moved**2).mean("instant").values, rel=1e-2, abs=1e-12)
    pushed = -data["contact_force"].sel(direction="radial").sum("node").mean("instant")
    turns = 2.0 * data["period"]
    assert (pushed * turns).values == pytest.approx(data["impulse_per_revolution"].values, rel=5e-3)
    touching = data["contact_force"].sel(direction="radial") < 0.0
    assert float(abs(data["gap"].where(touching)).max()) < 1e-12
    assert float(data["gap"].min()) > -1e-12
    assert (data["residual"] < 1e-9).all()
    sizes = np.abs(data["multipliers"].values)
    assert (np.diff(sizes, axis=1) <= 1e-9).all()


@pytest.mark.slow
def test_the_command_prints_and_draws(tmp_path: Path) -> None:
    file = tmp_path / "case.toml"
    file.write_text(bw.dumps_case(case(**{"march.speed": "7500 rpm"})))
    document = json.loads(
        answer("periodic", str(file), "--speeds", "6000 rpm,7500 rpm", "--json").stdout
    )
    first, second = document["solutions"]
    assert first["speed_rad_s"] == pytest.approx(6000.0 * np.pi / 30.0)
    assert second["stable"] is True
    assert second["residual"] < 1e-9
    assert np.hypot(*second["multipliers"][0]) == pytest.approx(second["largest_multiplier"])
    printed = answer("periodic", str(file), "-o", str(tmp_path / "out")).stdout
    assert "7500.0" in printed
    assert (tmp_path / "out" / "periodic.png").exists()
    with xr.open_dataset(tmp_path / "out" / "periodic.nc") as data:
        assert float(data["impulse_per_revolution"][0]) == pytest.approx(
            second["impulse_per_revolution"]
        )


def test_a_failed_speed_leaves_the_others(tmp_path: Path) -> None:
    """The rub at 7000 rpm is large, the others are small."""
    file = tmp_path / "case.toml"
    file.write_text(bw.dumps_case(case(**{"march.displacement_limit": "2 mm"})))
    speeds = "7500 rpm,7000 rpm,8000 rpm"
    done = CliRunner().invoke(app, ["periodic", str(file), "--speeds", speeds, "--json"])
    assert done.exit_code == 2
    document = json.loads(done.stdout)
    assert [round(each["speed_rpm"]) for each in document["solutions"]] == [7500, 8000]
    (reason,) = document["failures"]
    assert reason in done.stderr
    assert "at 7000 rpm contact nodes move by 0.005" in reason


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"casing.closure.amount": "0.05 mm"}, "no contact at 7000 rpm: the smallest gap is 0.03"),
        ({"casing.profile": None, "casing.clearance": "0.2 mm"}, "no period"),
        ({"contact.tip_rotation": True}, "tip_rotation"),
        ({"bladed_disk.superelement.copies": 2}, "blade 2: expected 0 to 1"),
    ],
)
def test_refusals_are_one_sentence(tmp_path: Path, changes: Any, message: str) -> None:
    file = tmp_path / "case.toml"
    file.write_text(bw.dumps_case(case(**changes)))
    number = 2 if message.startswith("blade 2") else 0
    assert message in refusal("periodic", file, "--blade", number)


def test_a_number_of_periods_that_needs_gigabytes_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "case.toml"
    file.write_text(bw.dumps_case(case()))
    expected = "periodic: periods 1000: expected from 1 to 32"
    assert expected in refusal("periodic", file, "--periods", 1000)


@pytest.mark.slow
def test_a_motion_of_two_periods_needs_a_start(tmp_path: Path) -> None:
    """From the motion without contact the search comes to the motion of one period."""
    file = tmp_path / "case.toml"
    file.write_text(bw.dumps_case(case(**{"march.speed": "7500 rpm"})))
    assert "at 7500 rpm the motion repeats in less than 2 periods; expected another start" in (
        refusal("periodic", file, "--periods", 2)
    )
    run = tmp_path / "empty"
    run.mkdir()
    assert "result.nc" in refusal("periodic", file, "--from", run)
