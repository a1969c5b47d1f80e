"""Datasets on disk: written as xarray writes them, checked while they are read."""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from synthetic_result import synthetic_result

from bladewhirl.postprocess.fields.netcdf import ResultError, open_file, write_netcdf


def test_round_trip(tmp_path: Path) -> None:
    data = synthetic_result(records=9).assign_coords(
        named=("blade", [f"b{i}" for i in range(22)]), number=3.5
    )
    write_netcdf(data, tmp_path / "data.nc")
    stored, _ = open_file(tmp_path, "data.nc", "data")
    with stored:
        xr.testing.assert_identical(stored, data)
        gap = data["gap"].values
        np.testing.assert_array_equal(
            stored["gap"].isel(time=[1, 4], blade=[7, 3]), gap[[1, 4]][:, [7, 3]]
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
