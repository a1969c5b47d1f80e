"""`bladewhirl plot`: figures by name, windows, and what it refuses."""

from pathlib import Path

import numpy as np
import pytest
import synthetic_result as synthetic
import xarray as xr
from command_line import answer, refusal
from typer.testing import CliRunner

from bladewhirl.postprocess.plotting.registry import RUN_FIGURES
from bladewhirl.studies.commands.cli import app


@pytest.fixture
def directory(tmp_path: Path) -> Path:
    """The folder of a run."""
    return made(tmp_path / "run", synthetic.SPEED)


OF_OTHERS = {"coating_strain", "contact_force", "rotation_speed", "critical_speed"}
OF_OTHERS |= {"bearing_force", "shaft_displacement", "joint_force"}
"""Variables of results with a coating, of superelements, with a speed that varies, of lines, with
joints."""


def made(folder: Path, speed: float) -> Path:
    folder.mkdir()
    result = synthetic.synthetic_result(shaft_radius=1.2e-3, speed=speed, records=1001)
    result.to_netcdf(folder / "result.nc", engine="h5netcdf")
    return folder


def test_figures_come_with_their_data(directory: Path) -> None:
    answer("plot", directory, "state-space", "spectrum")
    expected = {f"{n}.{end}" for n in ("state-space", "spectrum") for end in ("png", "nc")}
    assert {path.name for path in (directory / "plots").iterdir()} == expected | {"manifest.json"}
    with xr.open_dataset(directory / "plots" / "state-space.nc", engine="h5netcdf") as data:
        assert data.sizes["time"] == 1001
        assert data.sizes["revolution"] == 13  # 1 s at 80 rad/s: 12.7 turns
    with xr.open_dataset(directory / "plots" / "spectrum.nc", engine="h5netcdf") as data:
        assert set(data["mode"].values) == {"1F", "suspension", "casing", "Ω"}
        peak = float(data.frequency[int(np.argmax(data.amplitude.values))])
        assert peak == pytest.approx(-70.0, abs=5.0)


def test_a_window_and_a_folder(directory: Path, tmp_path: Path) -> None:
    window = ["--from", "0.1", "--to", "200 ms", "-o", tmp_path / "figures"]
    answer("plot", directory / "result.nc", "gaps", "orbit", "gaps", *window)
    assert len(list((tmp_path / "figures").iterdir())) == 4 + 1  # the manifest
    with xr.open_dataset(tmp_path / "figures" / "orbit.nc", engine="h5netcdf") as data:
        assert data.time.values[[0, -1]] == pytest.approx([0.1, 0.2])


@pytest.mark.slow
def test_a_figure_for_a_paper(directory: Path) -> None:
    options = ["--format", "svg", "--width", "85", "--title", "Rub of a fan"]
    printed = answer("plot", directory, "orbit", *options).stdout
    assert printed.endswith("orbit.svg and .nc.\n")
    text = (directory / "plots" / "orbit.svg").read_text()
    assert 'width="240.94' in text  # points
    assert "Rub of a fan" in text
    assert "rpm)" not in text  # the title that it has by default


@pytest.mark.slow
def test_figures_that_a_run_does_not_have_are_left_out_of_all(tmp_path: Path) -> None:
    still = made(tmp_path / "still", 0.0)
    result = answer("plot", still, "all")
    assert result.stderr.startswith("state-space left out: a Poincaré map needs one revolution")
    absent = {name for name, kind in RUN_FIGURES.items() if OF_OTHERS.intersection(kind.needs)}
    assert not any(name in result.stderr for name in absent)
    left_out = 3 + 4 + len(absent)  # three need a turn or a motion, four sensors
    assert len(list((still / "plots").iterdir())) == 2 * (len(RUN_FIGURES) - left_out) + 1
    refusal("plot", still, "state-space")


def test_without_a_name_the_names_are_listed(directory: Path) -> None:
    result = answer("plot", directory)
    names = [name for name, kind in RUN_FIGURES.items() if not OF_OTHERS.intersection(kind.needs)]
    assert [line.partition(":")[0] for line in result.stdout.splitlines()] == names


@pytest.mark.slow
def test_figures_that_exist_are_drawn_before_the_others_are_named(tmp_path: Path) -> None:
    still = made(tmp_path / "still", 0.0)
    words = ["plot", still, "state-space", "orbit", "wear", "nonsense", "--format", "svg"]
    result = CliRunner().invoke(app, [str(word) for word in words])
    assert result.exit_code == 2
    assert (still / "plots" / "orbit.svg").is_file()
    first, second, third = result.stderr.splitlines()
    assert first.startswith("nonsense: a run has the figures ")
    assert second.startswith("state-space left out: a Poincaré map needs one revolution")
    expected = "figure 'wear': expected a result with coating_strain"
    assert third == f"wear left out: {expected}"
    assert refusal("plot", still, "wear") == expected
