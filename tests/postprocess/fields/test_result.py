"""Datasets on disk: results, and files that are checked while they are read."""

import re
import shutil
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray as xr
from synthetic_result import synthetic_result

from bladewhirl.postprocess.fields.netcdf import ResultError, open_file, write_netcdf
from bladewhirl.postprocess.fields.result import (
    PORTION,
    open_result,
    portions,
    reduce_modes,
    result_fault,
    with_coordinates,
)
from bladewhirl.solvers.march.schema import RESULT_FORMAT


@pytest.fixture(scope="module")
def stored(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A result on disk."""
    file = tmp_path_factory.mktemp("stored") / "result.nc"
    synthetic_result(records=21).to_netcdf(file, engine="h5netcdf")
    return file


@pytest.fixture
def run(stored: Path, tmp_path: Path) -> Path:
    """The folder of a run with its result."""
    folder = tmp_path / "run"
    folder.mkdir()
    shutil.copy(stored, folder)
    return folder


class TestOpenResult:
    def test_by_folder_and_by_file_alike(self, run: Path) -> None:
        with open_result(run) as by_folder, open_result(str(run / "result.nc")) as by_file:
            xr.testing.assert_identical(by_folder, by_file)
            xr.testing.assert_allclose(by_folder, with_coordinates(synthetic_result(records=21)))

    def test_histories_stay_on_disk(self, run: Path) -> None:
        with open_result(run) as result:
            reduce_modes(result, "rotor_displacement", np.ones((1, 5)))
            assert "values with dtype" in repr(result["rotor_displacement"])  # none are shown

    def test_nothing_there(self, tmp_path: Path) -> None:
        with pytest.raises(ResultError, match=r"result\.nc: expected a result .* no such file"):
            open_result(tmp_path)

    def test_hdf5_of_another_kind(self, tmp_path: Path) -> None:
        with h5py.File(tmp_path / "result.nc", "w") as file:
            file["table"] = np.arange(3)
        with pytest.raises(ResultError, match="expected a bladewhirl result; it has no"):
            open_result(tmp_path)

    @pytest.mark.parametrize(
        ("change", "message"),
        [
            (lambda r: r.drop_vars("centre_node"), "expected a bladewhirl result; it has no 'cent"),
            (lambda r: r.drop_vars("time"), "expected a bladewhirl result; it has no 'time'"),
            (
                lambda r: (
                    r.drop_vars(r.attrs["derived"].split())
                    .drop_attrs(deep=False)
                    .assign_attrs(format=RESULT_FORMAT)
                ),
                "has no 'title'",
            ),
            (lambda r: r.assign_attrs(speed="fast"), "'speed' to be a finite number, found 'fast'"),
            (lambda r: r.assign_attrs(tip_radius=0.0), "'tip_radius' to be a positive number"),
            (
                lambda r: r.transpose(),
                r"'rotor_displacement' with the dimensions \(time, rotor_mode\)",
            ),
            (lambda r: r.isel(time=slice(0)), "expected at least one record"),
            (lambda r: r.assign_coords(time=r["time"].values[::-1]), "'time' to increase"),
            (
                lambda r: r.assign(rotor_line=0 * r["rotor_line"]),
                "'rotor_line' to connect different",
            ),
            (lambda r: r.assign_coords(casing_angle=0 * r["casing_angle"]), "within one turn"),
            (lambda r: r.assign_attrs(format=RESULT_FORMAT + 1), "of format .* newer"),
        ],
    )
    def test_invalid_results(
        self, change: Callable[[xr.Dataset], xr.Dataset], message: str
    ) -> None:
        fault = result_fault(change(synthetic_result(records=3)))
        assert re.search(message, f"expected {fault}")

    def test_more_data_than_a_file_can_hold(self, tmp_path: Path) -> None:
        """HDF5 stores nothing of what is declared and never written."""
        file = tmp_path / "result.nc"
        synthetic_result(records=3).to_netcdf(file, engine="h5netcdf")
        with h5py.File(file, "a") as stored:
            stored.create_dataset("more", (10**9,), dtype="f8")
        with pytest.raises(ResultError, match=r"declares 8e\+09 bytes of data in a file of"):
            open_result(file)

    def test_a_refused_file_is_let_go(self, tmp_path: Path) -> None:
        file = tmp_path / "result.nc"
        synthetic_result(records=3).drop_vars("gap").to_netcdf(file, engine="h5netcdf")
        with pytest.raises(ResultError):
            open_result(file)
        synthetic_result(records=3).to_netcdf(file, engine="h5netcdf")  # fails on a held file


class TestCoordinates:
    def test_blades_nodes_axes_and_components_are_found_by_name(self, run: Path) -> None:
        with open_result(run) as actual:
            plain = synthetic_result(records=21)
            np.testing.assert_array_equal(actual["gap"].sel(blade=3), plain["gap"][:, 3])
            assert actual["casing_shape"].sel(casing_component="u").sizes == {
                "casing_node": 40,
                "casing_mode": 4,
            }
            angle = actual["clearance"].coords["wall_angle"]
            np.testing.assert_array_equal(angle, plain["casing_angle"])
            family = actual["rotor_displacement"].coords["rotor_family"]
            assert actual["rotor_displacement"][:, family == "1F"].sizes["rotor_mode"] == 2


def test_results_that_lack_a_load_are_refused(run: Path) -> None:
    old = synthetic_result(records=3).assign(steady_stress_rest=("time", np.zeros(3)))
    old.assign_attrs(format=14).to_netcdf(run / "result.nc", engine="h5netcdf")
    with pytest.raises(ResultError, match=r"format 15 or newer of 3D blades .* found format 14"):
        open_result(run)


def test_results_before_format_10_are_refused(run: Path) -> None:
    old = synthetic_result(records=3)
    old.assign_attrs(format=9).to_netcdf(run / "result.nc", engine="h5netcdf")
    with pytest.raises(ResultError, match="format 10 or newer, found format 9; run the case again"):
        open_result(run)


class TestPortions:
    @pytest.mark.parametrize("records", [1, 7, 8, 9, 24])
    def test_every_record_once_in_order(self, records: int) -> None:
        cuts = list(portions(synthetic_result(records=records), 8))
        numbers = np.concatenate([np.arange(records)[cut] for cut in cuts])
        np.testing.assert_array_equal(numbers, np.arange(records))
        assert max(cut.stop - cut.start for cut in cuts) <= 8

    def test_sums_modes_at_every_record_across_portions(self) -> None:
        records = 2 * PORTION + 3
        motion = np.arange(records)[:, None] * np.array([1.0, -2.0, 0.0, 3.0, 0.5])
        result = synthetic_result(records=records)
        result["rotor_displacement"] = ("time", "rotor_mode"), motion
        rows = np.array([[1.0, 1.0, 1.0, 1.0, 2.0], [0.0, 0.0, 7.0, 0.0, 0.0]])
        sums = reduce_modes(result, "rotor_displacement", rows)
        np.testing.assert_allclose(sums[:, 0], 3.0 * np.arange(records), rtol=1e-14)
        assert not sums[:, 1].any()
        squares = reduce_modes(result, "rotor_displacement", rows[:1], np.square)
        np.testing.assert_allclose(squares[:, 0], 14.5 * np.arange(records) ** 2.0, rtol=1e-14)


def test_round_trip(tmp_path: Path) -> None:
    data = synthetic_result(records=9).assign_coords(
        named=("contact_node", [f"b{i}" for i in range(22)]), number=3.5
    )
    write_netcdf(data, tmp_path / "data.nc")
    stored, _ = open_file(tmp_path, "data.nc", "data")
    with stored:
        xr.testing.assert_identical(stored, data)
        gap = data["gap"].values
        np.testing.assert_array_equal(
            stored["gap"].isel(time=[1, 4], contact_node=[7, 3]), gap[[1, 4]][:, [7, 3]]
        )


def test_damaged_values_are_named(tmp_path: Path) -> None:
    data = synthetic_result(records=9)
    data["gap"][5, 3] = np.nan
    write_netcdf(data, tmp_path / "data.nc")
    for gaps in (False, True):
        stored, _ = open_file(tmp_path, "data.nc", "data", gaps=gaps)
        with stored:
            assert np.isfinite(stored["gap"].isel(time=slice(5))).all()  # before the damage
            if gaps:
                assert np.isnan(stored["gap"].values[5, 3])
            else:
                with pytest.raises(ResultError, match=r"data\.nc: gap: expected finite numbers"):
                    stored["gap"].load()
