"""Opening sweeps: values as they were given, coordinates of the points, formats."""

import shutil
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray as xr
from synthetic_result import synthetic_result
from synthetic_sweep import LAYOUT, REPORT

import bladewhirl as bw
from bladewhirl.postprocess.sweep.digest import digest
from bladewhirl.postprocess.sweep.frequency_map import frequency_map
from bladewhirl.postprocess.sweep.quantities import along
from bladewhirl.solvers.march.schema import SWEEP_FORMAT
from bladewhirl.studies.sweeps.axes import Axis, Grid
from bladewhirl.studies.sweeps.store import Store, create

RPM = np.array([2500.0, 2600.0])
RAD_PER_S = RPM * np.pi / 30


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A sweep over two speeds in rpm, the second of which is missing."""
    folder = tmp_path_factory.mktemp("made")
    grid = Grid(axes=(Axis(key="march.speed", values=("2500 rpm", "2600 rpm")),))
    create(folder, grid, {"march.speed": (RAD_PER_S, "rad/s")}, LAYOUT, {"title": "rpm"})
    with Store(folder, grid) as store:
        store.write(0, digest(synthetic_result(speed=RAD_PER_S[0]), REPORT, LAYOUT))
    return folder


@pytest.fixture
def folder(made: Path, tmp_path: Path) -> Path:
    """A copy of the sweep, which a test may change."""
    return Path(shutil.copytree(made, tmp_path, dirs_exist_ok=True))


def test_speeds_in_rpm_stay_beside_si_and_the_ratio(folder: Path) -> None:
    with bw.open_sweep(folder) as sweep:
        np.testing.assert_array_equal(sweep["march_speed"], RAD_PER_S)
        point = sweep.swap_dims(march_speed="march_speed_rpm").sel(march_speed_rpm=2500.0)
        assert point["state"].item() == "done"
        assert point["speed_ratio"].item() == pytest.approx(RAD_PER_S[0] / 75.0)
        assert np.isnan(sweep["speed_ratio"][1])
        assert sweep["contact_share"].sel(blade=3, march_speed=RAD_PER_S[0]).item() > 0
        lines = along(sweep, "march_speed", ["regime"])
        assert {*lines.coords} == {"march_speed"}


def test_before_format_4_waves_have_the_frequencies_of_modes(folder: Path) -> None:
    with h5py.File(folder / "sweep.nc", "r+") as file:
        file.attrs["format"] = 3
        del file["mode_forward_frequency"]
    with bw.open_sweep(folder) as sweep:
        xr.testing.assert_equal(sweep["mode_forward_frequency"], sweep["mode_frequency"])
        assert frequency_map(sweep, "march_speed")["mode_line"].notnull().any()


@pytest.mark.parametrize("name", ["march_speed", "frequency", "growth_rate", "spectrum", "regime"])
def test_numbers_that_were_changed_are_refused(folder: Path, name: str) -> None:
    with h5py.File(folder / "sweep.nc", "r+") as file:
        first = (0,) * file[name].ndim
        changed = 0.999 * np.nan_to_num(file[name][first], nan=1.0)
        file[name][first] = changed if file[name].dtype.kind == "f" else 0
    with pytest.raises(bw.ResultError, match="but point 0 was changed after it was written"):
        bw.open_sweep(folder)
    with pytest.raises(bw.UserError, match="expected point 0 as it was written"):
        Store(folder, Grid(axes=(Axis(key="march.speed", values=("2500 rpm", "2600 rpm")),)))


@pytest.mark.parametrize("name", ["title", "criterion", "window", "over"])
def test_what_every_sweep_says_of_itself_is_not_missing(folder: Path, name: str) -> None:
    with h5py.File(folder / "sweep.nc", "r+") as file:
        del file.attrs[name]
    with pytest.raises(bw.ResultError, match="expected a sweep of bladewhirl, it has no"):
        bw.open_sweep(folder)


def test_a_newer_format_is_refused(folder: Path) -> None:
    with h5py.File(folder / "sweep.nc", "r+") as file:
        file.attrs["format"] = SWEEP_FORMAT + 1
    with pytest.raises(bw.ResultError, match=r"sweep\.nc: expected .* format .* newer version"):
        bw.open_sweep(folder)
