"""Read and validate netCDF-4 files through xarray, also incomplete files left by a killed run."""

import warnings
from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import Any, Self

import h5py
import numpy as np
import xarray as xr
from xarray.backends import BackendArray
from xarray.core import indexing

from bladewhirl.models.inputs.errors import UserError
from bladewhirl.solvers.march.schema import NODES, TIME, Variable, tables_of
from bladewhirl.solvers.march.storage import CutFile

#: largest plausible magnitude of a number in SI units; a positive number is larger than 1 / MOST
MOST = 1e30
POSITIVE = "reference_frequency casing_radius tip_radius time_step record_step yield_strength"
NUMBERS = (
    "format speed friction clamped steps complementarity_residual unsolved_steps "
    "dt_over_critical wall_time us_per_step"
)
TEXTS = "title version symmetry case end_reason end_message over criterion window"
"""Attributes of results and sweeps that are validated if a file contains them."""


ROOM, DENSEST = 1e9, 100
"""A file whose arrays declare more than `ROOM` bytes and more than `DENSEST` times the size of the
file is rejected as damaged."""


class ResultError(UserError):
    """A file or folder is not a valid result or sweep of bladewhirl."""


def plausible(values: Any, *, gaps: bool = False) -> bool:
    """Return true if all magnitudes are below `MOST`; NaN is accepted if gaps are allowed."""
    return bool(np.all((np.abs(values) < MOST) | (gaps & np.isnan(values))))


class CheckedArray(BackendArray):
    """Variable of a file, read and validated when used.

    Args:
        variable: variable to read.
        label: file and variable, for messages.
        gaps: whether NaN is allowed, for missing values as in a sweep.
    """

    def __init__(self, variable: xr.Variable, label: str, *, gaps: bool) -> None:
        self._variable, self._label, self._gaps = variable, label, gaps
        self.shape, self.dtype = variable.shape, variable.dtype

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
        """Return a part of the array."""
        return indexing.explicit_indexing_adapter(
            key, self.shape, indexing.IndexingSupport.OUTER, self._read
        )

    def __deepcopy__(self, memo: object) -> Self:
        """Return the array itself: it is never written to."""
        return self

    def _read(self, key: tuple[Any, ...]) -> Any:
        try:
            values = self._variable[key].values
        except Exception as error:  # HDF5 raises many kinds for damaged bytes
            raise ResultError(f"{self._label}: {error}") from None
        if values.dtype.kind == "f" and not plausible(values, gaps=self._gaps):
            raise ResultError(f"{self._label}: expected finite numbers; the file is damaged")
        return values


def open_file(
    path: str | PathLike[str], name: str, kind: str, *, gaps: bool = False, cache: bool = True
) -> tuple[xr.Dataset, Path]:
    """Open a netCDF-4 file; arrays are read when used.

    Args:
        path: path of the file, or of the folder that contains it.
        name: name of the file, if the path is a folder.
        kind: kind of file, for messages: "a result".
        gaps: whether NaN is allowed, for missing values.
        cache: whether to keep arrays in memory after reading.

    Returns:
        the Dataset, whose contents are not yet checked, and the path of the file.

    Raises:
        ResultError: the file does not exist or is not netCDF-4.
    """
    file = Path(path) / name if Path(path).is_dir() else Path(path)
    if not file.is_file():
        raise ResultError(f"{file}: expected {kind} (or its folder), found no such file")
    raw = CutFile(file)
    try:
        with h5py.File(raw, "r") as plain:
            plain.attrs.get("_nc3_strict")  # h5netcdf 1.8 prints a traceback where this fails
        with warnings.catch_warnings(record=True) as warned:  # by xarray, of damaged dimensions
            warnings.simplefilter("always")
            stored = xr.open_dataset(
                raw,
                engine="h5netcdf",
                cache=False,
                decode_times=False,
                mask_and_scale=False,
                phony_dims="access",
                # an index would be read at once, beyond the last complete record
                create_default_indexes=False,
            )
        if warned:
            raise ValueError(warned[0].message)
        declared, size = sum(variable.nbytes for variable in stored.values()), file.stat().st_size
        if declared > max(ROOM, DENSEST * size):
            raise ValueError(
                f"it declares {declared:.3g} bytes of data in a file of {size:.3g} bytes"
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
    """Return the number of complete records that attributes of a file state; None if they do not.

    If a run is killed while it writes to disk, its histories may be longer than the number of
    complete records, with missing data; these must not be read.
    """
    steps, spacing = attributes.get("steps", 0), attributes.get("record_step")
    if attribute_fault(attributes) or steps == 0 or spacing is None:
        return None  # steps = 0: older versions wrote `steps` only at the end of the run
    every = max(1, round(spacing / attributes["time_step"]))
    return 1 - int(-steps // every) if steps > 0 else 0


def write_netcdf(dataset: xr.Dataset, path: str | Path) -> None:
    """Write a Dataset as netCDF-4; an older file is replaced.

    Raises:
        OSError: the file cannot be written.
    """
    encoding = {name: {"_FillValue": None} for name in dataset.variables}
    dataset.to_netcdf(path, engine="h5netcdf", encoding=encoding)


def attribute_fault(attributes: Mapping[str, Any]) -> str:
    """Describe the first invalid attribute; empty if all attributes are valid."""
    for name in (*POSITIVE.split(), *NUMBERS.split()):
        value = np.asarray(attributes.get(name, 1.0))
        kind = "positive" if name in POSITIVE.split() else "finite"
        valid = value.ndim == 0 and value.dtype.kind in "fiu" and plausible(value)
        if not valid or (kind == "positive" and not value > 1.0 / MOST):
            return f"attribute {name!r} to be a {kind} number, found {attributes[name]!r}"
    for name in TEXTS.split():
        text = attributes.get(name, "")
        # h5py returns bytes that are not UTF-8 as halves of surrogate pairs.
        if not isinstance(text, str) or any("\ud800" <= letter <= "\udfff" for letter in text):
            return f"attribute {name!r} to be text, found {text!r:.60}"
    return ""


def check_beams(dataset: xr.Dataset) -> None:
    """Check that a result is that of a bladed disk of beams.

    Raises:
        ResultError: it is the result of a superelement.
    """
    if tables_of(dataset.attrs) is NODES:
        raise ResultError(
            f"expected the result of a bladed disk of beams, found that of a superelement,"
            f" {dataset.attrs.get('title', '')!r}"
        )


def value_fault(dataset: xr.Dataset) -> str:
    """Describe the first invalid array that does not depend on time; empty if all are valid."""
    tables = tables_of(dataset.attrs)
    nodes = dataset.sizes.get("rotor_node", 0)
    for name, variable in tables.stage.items():
        if name in dataset and (expected := expectation(dataset[name].values, variable, nodes)):
            return f"{name!r} to be {expected}"
    if tables is NODES:
        return ""
    ends = dataset["rotor_point"].values[dataset["rotor_line"].values]
    if not np.any(ends[:, 0] != ends[:, 1], axis=-1).all():
        return "'rotor_line' to connect different points"
    angle = dataset["casing_angle"].values
    if not (np.all(np.diff(angle) > 0.0) and angle[-1] - angle[0] < 2.0 * np.pi):
        return "'casing_angle' to increase within one turn"
    return ""


def expectation(values: Any, variable: Variable, nodes: int = 0) -> str:
    """Describe valid values of a variable; empty if the values are valid."""
    if values.dtype.kind not in {"f": "f", "i": "iu", "s": "OUT"}[variable.kind[0]]:
        return "text" if variable.kind == "str" else "numbers"
    labels = variable.labels if variable.kind == "str" else range(len(variable.labels))
    if variable.labels and not np.isin(values, np.array(list(labels))).all():
        return f"one of {', '.join(map(str, labels))}"
    match variable.values:
        case "positive":
            valid = values > 1.0 / MOST
        case "not negative":
            valid = values >= 0
        case "rotor_node":
            valid = (values >= 0) & (values < nodes)
        case "rotor_node or -1":
            valid = (values >= -1) & (values < nodes)
        case _:
            return ""
    return "" if np.all(valid) else variable.values
