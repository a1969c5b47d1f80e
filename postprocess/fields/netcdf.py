"""Read netCDF-4 files through xarray, checked and also when a killed run left them incomplete."""

from __future__ import annotations

from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import Any

import xarray as xr
from xarray.backends import BackendArray
from xarray.core import indexing

from bladewhirl.postprocess.fields.checked import ResultError, attribute_fault, plausible
from bladewhirl.solvers.march.schema import TIME
from bladewhirl.solvers.march.storage import CutFile


class CheckedArray(BackendArray):
    """Variable of a file that is read when used and checked as it is read.

    Args:
        variable: to read.
        label: file and variable, for messages.
        gaps: NaN stands for missing values, as in a sweep.
    """

    def __init__(self, variable: xr.Variable, label: str, *, gaps: bool) -> None:
        self._variable, self._label, self._gaps = variable, label, gaps
        self.shape, self.dtype = variable.shape, variable.dtype

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
        """Read a part."""
        return indexing.explicit_indexing_adapter(
            key, self.shape, indexing.IndexingSupport.OUTER, self._read
        )

    def __deepcopy__(self, memo: object) -> CheckedArray:
        """Return the array itself: it is never written to."""
        return self

    def _read(self, key: tuple[Any, ...]) -> Any:
        try:
            values = self._variable[key].values
        except Exception as error:  # HDF5 raises many kinds for damaged bytes
            raise ResultError(f"{self._label}: {error}") from None
        if values.dtype.kind == "f" and not plausible(values, gaps=self._gaps):
            raise ResultError(f"{self._label}: expected finite numbers, the file is damaged")
        return values


def open_file(
    path: str | PathLike[str], name: str, kind: str, *, gaps: bool = False, cache: bool = True
) -> tuple[xr.Dataset, Path]:
    """Open a netCDF-4 file, or the file of that name in a folder; arrays are read when used.

    Args:
        path: of the file or the folder.
        name: of the file in a folder.
        kind: of file, for messages: "a result".
        gaps: NaN stands for missing values.
        cache: keep arrays that were read.

    Returns:
        the Dataset, its contents unchecked, and the path of the file.

    Raises:
        ResultError: no such file, or not netCDF-4.
    """
    file = Path(path) / name if Path(path).is_dir() else Path(path)
    if not file.is_file():
        raise ResultError(f"{file}: expected {kind} (or its folder), found no such file")
    raw = CutFile(file)
    try:
        stored = xr.open_dataset(
            raw,
            engine="h5netcdf",
            cache=False,
            decode_times=False,
            mask_and_scale=False,
            phony_dims="access",
            create_default_indexes=False,  # an index is read at once, also behind the last record
        )
        dataset = stored.isel({TIME: slice(complete_records(stored.attrs))}, missing_dims="ignore")
        for dimension in map(str, dataset.dims):
            if dimension in dataset.coords and dataset[dimension].dims == (dimension,):
                dataset = dataset.set_xindex(dimension)
        checked = dataset.assign(
            {
                name: _checked(variable, f"{file}: {name}", gaps=gaps, cache=cache)
                for name, variable in dataset.variables.items()
                if name not in dataset.indexes
            }
        )
    except Exception as error:  # HDF5 and xarray raise many kinds for damaged bytes
        raw.close()
        raise ResultError(
            f"{file}: expected {kind} in netCDF-4, could not read it: {error}"
        ) from None

    def close() -> None:
        stored.close()
        raw.close()

    checked.set_close(close)
    return checked, file


def _checked(variable: xr.Variable, label: str, *, gaps: bool, cache: bool) -> xr.Variable:
    data: Any = indexing.LazilyIndexedArray(CheckedArray(variable, label, gaps=gaps))
    if cache:
        data = indexing.MemoryCachedArray(data)  # type: ignore[no-untyped-call]
    attributes = {name: value for name, value in variable.attrs.items() if name != "_FillValue"}
    return xr.Variable(variable.dims, data, attributes)


def complete_records(attributes: Mapping[str, Any]) -> int | None:
    """Number of records that the recorder marked as complete; None if it marked none.

    A kill during a flush leaves longer histories with missing pieces, which must not be read.
    """
    steps, spacing = attributes.get("steps", 0), attributes.get("record_step")
    if attribute_fault(attributes) or steps == 0 or spacing is None:
        return None  # steps = 0: older versions wrote it at the end only
    every = max(1, round(spacing / attributes["time_step"]))
    return 1 - int(-steps // every) if steps > 0 else 0


def write_netcdf(dataset: xr.Dataset, path: str | Path) -> None:
    """Write a Dataset as netCDF-4; an older file is replaced.

    Raises:
        OSError: the file cannot be written.
    """
    encoding = {name: {"_FillValue": None} for name in dataset.variables}
    dataset.to_netcdf(path, engine="h5netcdf", encoding=encoding)
