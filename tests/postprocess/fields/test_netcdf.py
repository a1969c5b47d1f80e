"""Datasets on disk as xarray's own backend has them."""

from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray as xr
from synthetic_result import synthetic_result

from bladewhirl.postprocess.fields.netcdf import open_netcdf, write_netcdf


def test_what_is_written_is_read_alike_by_xarray(tmp_path: Path) -> None:
    data = synthetic_result(records=9).assign_coords(
        named=("blade", [f"b{i}" for i in range(22)]), number=3.5
    )
    write_netcdf(data, tmp_path / "data.nc")
    with (
        open_netcdf(tmp_path / "data.nc", lambda name, read: read()) as ours,
        xr.open_dataset(tmp_path / "data.nc", engine="h5netcdf", decode_times=False) as theirs,
    ):
        assert {*ours.coords} == {*theirs.coords}
        assert ours.attrs == theirs.attrs
        xr.testing.assert_equal(ours, theirs)
        xr.testing.assert_equal(ours, data)
        gap = data["gap"].values
        for part in (slice(6, 1, -2), slice(-3, None), [5, 0, 5]):
            np.testing.assert_array_equal(ours["gap"].isel(time=part, blade=2), gap[part, 2])
        np.testing.assert_array_equal(
            ours["gap"].isel(time=[1, 4], blade=[7, 3]), gap[[1, 4]][:, [7, 3]]
        )


def test_an_attribute_that_is_no_text_and_no_number_is_refused(tmp_path: Path) -> None:
    """As netCDF's own are whose name has a flipped bit."""
    write_netcdf(synthetic_result(records=2), tmp_path / "data.nc")
    with h5py.File(tmp_path / "data.nc", "a") as file:
        file["gap"].attrs["DIMENSION_LISU"] = np.array([file["time"].ref], dtype=h5py.ref_dtype)
    with pytest.raises(TypeError, match="attribute DIMENSION_LISU: expected text or numbers"):
        open_netcdf(tmp_path / "data.nc", lambda name, read: read())
