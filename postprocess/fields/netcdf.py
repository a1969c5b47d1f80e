"""Read and validate netCDF-4 files, also incomplete files left by a killed run.

Files are read with h5py: h5netcdf computes the length of a dimension that can grow from all its
variables whenever a shape is needed, which takes half a second for the result of a run.
"""

from collections.abc import Mapping
from contextlib import ExitStack
from os import PathLike
from pathlib import Path
from typing import Any, Self

import h5py
import numpy as np
import xarray as xr
from xarray.backends import BackendArray
from xarray.core import indexing

from bladewhirl.meshes.hdf5 import open_hdf5
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.solvers.march.schema import TIME, Variable, parts_of
from bladewhirl.solvers.march.storage import CutFile

#: largest plausible magnitude of a number in SI units; a positive number is larger than 1 / MOST
MOST = 1e30
POSITIVE = (
    "reference_frequency casing_radius tip_radius blade_length time_step record_step "
    "yield_strength endurance strength"
)
NUMBERS = (
    "format speed friction clamped steps complementarity_residual unsolved_steps "
    "dt_over_critical wall_time us_per_step fuse_time unsolved_time unsolved_impulse unsolved_wear"
)
TEXTS = "title version symmetry blade_loss case end_reason end_message over criterion window"
"""Attributes of results and sweeps that are validated if a file contains them."""


class ResultError(UserError):
    """A file or folder is not a valid result or sweep of bladewhirl."""


def plausible(values: Any, *, gaps: bool = False) -> bool:
    """Return true if all magnitudes are below `MOST`; NaN is accepted if gaps are allowed."""
    return bool(np.all((np.abs(values) < MOST) | (gaps & np.isnan(values))))


NO_VARIABLE = b"This is a netCDF dimension but not a netCDF variable"
"""Text with which the attribute NAME of a dimension without values begins."""

INTERNAL = {"CLASS", "NAME", "DIMENSION_LIST", "REFERENCE_LIST", "_FillValue"}
"""Attributes of variables that netCDF-4 needs for itself, with those that begin with "_N"."""


class StoredArray(BackendArray):
    """Array of a file, read and validated when used.

    Args:
        array: array of the file.
        shape: shape of the part that is read.
        label: file and variable, for messages.
        gaps: whether NaN is allowed, for missing values as in a sweep.
    """

    def __init__(
        self, array: h5py.Dataset, shape: tuple[int, ...], label: str, *, gaps: bool
    ) -> None:
        self._array, self.shape, self.dtype = array, shape, array.dtype
        self._label, self._gaps = label, gaps

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
        """Return a part of the array."""
        return indexing.explicit_indexing_adapter(
            key, self.shape, indexing.IndexingSupport.OUTER_1VECTOR, self._read
        )

    def __deepcopy__(self, memo: object) -> Self:
        """Return the array itself: it is never written to."""
        return self

    def _read(self, key: tuple[Any, ...]) -> Any:
        inside = tuple(
            slice(*part.indices(size)) if isinstance(part, slice) else part
            for part, size in zip(key, self.shape, strict=True)
        )
        try:
            if h5py.check_string_dtype(self.dtype):
                return np.asarray(self._array.asstr()[inside], dtype=str)
            values = self._array[inside]
        except Exception as error:  # HDF5 raises many kinds for damaged bytes
            raise ResultError(f"{self._label}: {error}") from None
        if self.dtype.kind == "f" and not plausible(values, gaps=self._gaps):
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
    with ExitStack() as opened:
        try:
            whole = opened.enter_context(CutFile(file))
            h5 = opened.enter_context(open_hdf5(file, stream=whole))
            stored = _stored(h5, str(file), gaps=gaps, cache=cache)
            records = slice(complete_records(stored.attrs))
            dataset = stored.isel({TIME: records}, missing_dims="ignore")
            dataset = dataset.assign_coords(  # with an index
                {
                    dimension: _coordinate(dataset[dimension])
                    for dimension in dataset.dims
                    if dimension in dataset.coords and dataset[dimension].dims == (dimension,)
                }
            )
        except ResultError:
            raise
        except Exception as error:  # HDF5 and xarray raise many kinds for damaged bytes
            raise ResultError(
                f"{file}: expected {kind} in netCDF-4, could not read it: {error}"
            ) from None
        dataset.set_close(opened.pop_all().close)
    return dataset, file


def _stored(h5: h5py.File, label: str, *, gaps: bool, cache: bool) -> xr.Dataset:
    """Return all variables of a netCDF-4 file, whose values are read when used; see `open_file`.
    `label` is the file, for messages."""
    everything = {name: each for name, each in h5.items() if isinstance(each, h5py.Dataset)}
    numbers = {
        array.attrs.get("_Netcdf4Dimid"): name
        for name, array in everything.items()
        if _is_scale(array)
    }
    arrays = {
        name: array
        for name, array in everything.items()
        if not array.attrs.get("NAME", b"").startswith(NO_VARIABLE)
    }
    dimensions = {name: _dimensions(name, array, numbers) for name, array in arrays.items()}
    sizes: dict[str, int] = {}  # if a run was killed, some of its histories may be longer
    for name, array in arrays.items():
        for dimension, size in zip(dimensions[name], array.shape, strict=True):
            sizes[dimension] = min(size, sizes.get(dimension, size))
    attributes = _attributes(h5)
    variables, coordinates = {}, {*sizes, *str(attributes.pop("coordinates", "")).split()}
    for name, array in arrays.items():
        shape = tuple(sizes[dimension] for dimension in dimensions[name])
        data: Any = StoredArray(array, shape, f"{label}: {name}", gaps=gaps)
        data = indexing.LazilyIndexedArray(data)
        if cache:
            data = indexing.MemoryCachedArray(data)  # type: ignore[no-untyped-call]
        variables[name] = xr.Variable(dimensions[name], data, _attributes(array))
        coordinates.update(str(variables[name].attrs.pop("coordinates", "")).split())
    # Indexes would read the coordinates at once, also beyond the last complete record.
    kept = {name: variables.pop(name) for name in sorted(coordinates & variables.keys())}
    return xr.Dataset(variables, xr.Coordinates(kept, indexes={}), attributes)


def _coordinate(array: xr.DataArray) -> tuple[Any, Any, dict[Any, Any]]:
    """Return dimensions, values and attributes of a coordinate, with texts of fixed width."""
    texts = array.dtype.kind == "O"
    return array.dims, np.asarray(array.values, dtype=str if texts else None), array.attrs


def _is_scale(array: h5py.Dataset) -> bool:
    """Return whether a variable is a dimension. The functions of HDF5 for dimensions, which h5py
    calls, end the process if an attribute is damaged."""
    return bool(array.attrs.get("CLASS") == b"DIMENSION_SCALE")


def _dimensions(name: str, array: h5py.Dataset, numbers: Mapping[Any, str]) -> tuple[str, ...]:
    """Return the names of the dimensions of a variable; `numbers` maps the number of each dimension
    to its name."""
    if "_Netcdf4Coordinates" in array.attrs:  # a dimension that has values over several dimensions
        return tuple(numbers[number] for number in array.attrs["_Netcdf4Coordinates"])
    if _is_scale(array) and array.ndim == 1:
        return (name,)
    axes = array.attrs.get("DIMENSION_LIST", [()] * array.ndim)
    scales = [array.file[axis[0]].name.rpartition("/")[2] if len(axis) else "" for axis in axes]
    return tuple(scale or f"{name}_axis_{number}" for number, scale in enumerate(scales))


def _attributes(stored: h5py.Dataset | h5py.File) -> dict[str, Any]:
    """Return the attributes of a variable or a file; an array of one value becomes this value."""
    attributes = {}
    for name in stored.attrs:
        if name in INTERNAL or name.startswith(("_N", "_n")):
            continue
        value = stored.attrs[name]
        if isinstance(value, h5py.Empty):
            value = ""
        if isinstance(value, np.ndarray) and value.size == 1:
            value = value.ravel()[0]
        attributes[name] = value.decode() if isinstance(value, bytes) else value
    return attributes


def complete_records(attributes: Mapping[str, Any]) -> int | None:
    """Return the number of complete records by the attributes of a file; None if they do not state
    it.

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
    """Return a text on the first invalid attribute, what is expected and what was found; an empty
    text if all attributes are valid."""
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


def has(dataset: xr.Dataset, part: str) -> bool:
    """Return whether a result has a part that not every stage has, see
    `solvers.march.schema.Variable`: a "centre", a flexible "casing", a shaft "line", "lines" of
    beams, "gauges", "stress" at points of a file, a "coating" and others."""
    return part in parts_of(map(str, dataset.variables))


def need(dataset: xr.Dataset, *names: str) -> None:
    """Check that a result has variables that not every stage has.

    Raises:
        ResultError: the result lacks one of the variables.
    """
    if missing := [name for name in names if name not in dataset]:
        title = dataset.attrs.get("title", "")
        raise ResultError(f"expected a result with {', '.join(missing)}; {title!r} has none")


def expectation(values: Any, variable: Variable, nodes: int = 0) -> str:
    """Return a text that says which values of `variable` are valid, such as "numbers"; an empty
    text if `values` are valid."""
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
