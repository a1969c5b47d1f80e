"""Opening sweeps: values as they were given, spectra of points, coordinates, formats."""

import shutil
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray as xr
from synthetic_result import synthetic_result
from synthetic_sweep import LAYOUT, REPORT

import bladewhirl as bw
from bladewhirl.postprocess.sweep.digest import digest, magnitudes
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


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        *(
            (name, None, "expected a sweep of bladewhirl, it has no")
            for name in ("title", "criterion", "window", "over")
        ),
        ("format", SWEEP_FORMAT + 1, r"sweep\.nc: expected .* format .* newer version"),
    ],
)
def test_what_every_sweep_says_of_itself_is_checked(
    folder: Path, name: str, value: int | None, message: str
) -> None:
    with h5py.File(folder / "sweep.nc", "r+") as file:
        del file.attrs[name]
        if value is not None:
            file.attrs[name] = value
    with pytest.raises(bw.ResultError, match=message):
        bw.open_sweep(folder)


STEP = 1e-3
FREQUENCY = np.arange(-100, 101) / 0.5  # of a window of half a second


def test_circles_have_their_radius_at_their_frequency() -> None:
    time = STEP * np.arange(500)
    motion = 3.0 + 2.0 * np.exp(2j * np.pi * 40.0 * time) + 0.5 * np.exp(-2j * np.pi * 60.0 * time)
    magnitude = magnitudes(motion, STEP, FREQUENCY)
    expected = np.zeros(len(FREQUENCY))
    for frequency, radius in ((0.0, 3.0), (40.0, 2.0), (-60.0, 0.5)):
        place = int(np.argmin(np.abs(FREQUENCY - frequency)))
        expected[place - 1 : place + 2] += radius * np.array([0.5, 1.0, 0.5])  # a Hann window
    np.testing.assert_allclose(magnitude, expected, atol=1e-12)


def test_it_is_the_sum_that_defines_it_at_any_frequency_and_length() -> None:
    random = np.random.default_rng(1)
    motion = random.normal(size=137) + 1j * random.normal(size=137)
    window = np.sin(np.pi * (np.arange(137) + 0.5) / 137) ** 2
    turns = np.exp(-2j * np.pi * np.outer(FREQUENCY, STEP * np.arange(137)))
    np.testing.assert_allclose(
        magnitudes(motion, STEP, FREQUENCY),
        np.abs(turns @ (window * motion)) / window.sum(),
        rtol=1e-9,
    )


def test_too_few_records_have_no_spectrum() -> None:
    assert np.isnan(magnitudes(np.ones(3, dtype=complex), STEP, FREQUENCY)).all()
