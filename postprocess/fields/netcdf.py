"""netCDF-4 to Datasets and back with little of the time that xarray's own backends take.

They look every dimension up anew at each read and load dask to write a table. What is read here
was written by this program, or is refused by who asked for it: numbers and text with dimensions,
units and coordinates, nothing packed or masked.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import ExitStack
from os import PathLike
from pathlib import Path
from typing import Any

import h5netcdf
import h5py
import numpy as np
import xarray as xr
from xarray.backends import BackendArray
from xarray.core import indexing

from bladewhirl.postprocess.fields.array_types import ask_loaded_only
from bladewhirl.solvers.march.storage import CutFile

ask_loaded_only()

Values = np.ndarray[Any, np.dtype[Any]]

Lengths = Callable[[Mapping[str, Any]], Mapping[str, int]]
"""Given the attributes of a file, gives what is whole of its dimensions, by name."""

Reading = Callable[[str, Callable[[], Values]], Values]
"""Given a variable's name and what reads a part of it, gives that part."""

NO_VARIABLE = b"This is a netCDF dimension but not a netCDF variable."
"""How the name of a dimension begins that is no variable, too."""

SCALE = b"DIMENSION_SCALE"
"""Class of a variable that is a dimension, too."""

BOOKS = frozenset(
    {"CLASS", "NAME", "REFERENCE_LIST", "DIMENSION_LIST", "DIMENSION_LABELS", "_FillValue"}
    | {"_Netcdf4Dimid", "_Netcdf4Coordinates", "_NCProperties", "_nc3_strict"}
)
"""Attributes that netCDF keeps its books in."""


class Stored(BackendArray):
    """A variable on disk, read when used.

    Args:
        variable: where it is.
        shape: what is read of it: of a march that was killed some histories are longer.
        look: reads it.
    """

    def __init__(self, variable: h5py.Dataset, shape: tuple[int, ...], look: Reading) -> None:
        text = h5py.check_string_dtype(variable.dtype) is not None
        self._variable = variable.asstr() if text else variable
        self._name, self._look = _name(variable), look
        self.shape = shape
        self.dtype = np.dtype(object) if text else variable.dtype

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
        """Read a part."""
        return indexing.explicit_indexing_adapter(
            key, self.shape, indexing.IndexingSupport.OUTER_1VECTOR, self._read
        )

    def __deepcopy__(self, memo: object) -> Stored:
        """The same: nobody writes to it."""
        return self

    def _read(self, key: tuple[Any, ...]) -> Values:
        within = tuple(
            slice(*part.indices(size)) if isinstance(part, slice) else part
            for part, size in zip(key, self.shape, strict=True)
        )
        return self._look(self._name, lambda: np.asarray(self._variable[within], dtype=self.dtype))


def open_netcdf(
    path: str | PathLike[str], look: Reading, whole: Lengths = lambda _: {}, *, cache: bool = True
) -> xr.Dataset:
    """Open a netCDF-4 file, also one that was cut off; arrays are read when used.

    Args:
        path: of the file.
        look: reads a part of a variable.
        whole: how much of each dimension may be read; all of those that it doesn't name.
        cache: keep what is read as a whole.

    Raises:
        OSError, RuntimeError, KeyError, ValueError, TypeError: it can't be read as one.
    """
    with ExitStack() as stack:
        raw = stack.enter_context(CutFile(path))
        dataset = _dataset(stack.enter_context(h5py.File(raw, "r")), look, whole, cache=cache)
        dataset.set_close(stack.pop_all().close)
    return dataset


def _dataset(h5: h5py.File, look: Reading, whole: Lengths, *, cache: bool) -> xr.Dataset:
    of_file = _attributes(h5.attrs)
    stored = {name: item for name, item in h5.items() if isinstance(item, h5py.Dataset)}
    scales = {
        int(item.attrs["_Netcdf4Dimid"]): name
        for name, item in stored.items()
        if item.attrs.get("CLASS") == SCALE and "_Netcdf4Dimid" in item.attrs
    }
    over = {name: _dimensions(scales, h5, item) for name, item in stored.items()}
    lengths = dict(whole(of_file))
    for name, item in stored.items():
        for dimension, length in zip(over[name], item.shape, strict=True):
            lengths[dimension] = min(length, lengths.get(dimension, length))
    variables, described = {}, []
    for name, item in stored.items():
        if item.attrs.get("NAME", b"").startswith(NO_VARIABLE):
            continue
        lazy: Any = indexing.LazilyIndexedArray(
            Stored(item, tuple(lengths[each] for each in over[name]), look)
        )
        attributes = _attributes(item.attrs)
        described += str(attributes.pop("coordinates", "")).split()
        if cache:
            lazy = indexing.MemoryCachedArray(lazy)  # type: ignore[no-untyped-call]
        variables[name] = xr.Variable(over[name], lazy, attributes)
    described += str(of_file.pop("coordinates", "")).split()
    chosen = {name for name in described if name in variables}
    chosen |= {name for name, variable in variables.items() if variable.dims == (name,)}
    return xr.Dataset(
        {name: variable for name, variable in variables.items() if name not in chosen},
        {name: variables[name] for name in variables if name in chosen},
        of_file,
    )


def _dimensions(
    scales: Mapping[int, str], h5: h5py.File, variable: h5py.Dataset
) -> tuple[str, ...]:
    """Names of a variable's dimensions; those that have none are named by their length.

    Args:
        scales: dimensions by number.
        h5: the file.
        variable: in it.
    """
    listed = variable.attrs.get("DIMENSION_LIST")
    if listed is not None:
        return tuple(_name(h5[scale[0]]) for scale in listed)
    if "_Netcdf4Coordinates" in variable.attrs:
        return tuple(scales[number] for number in variable.attrs["_Netcdf4Coordinates"])
    if variable.attrs.get("CLASS") == SCALE:
        return (_name(variable),)
    return tuple(f"unnamed_{length}" for length in variable.shape)


def _name(variable: h5py.Dataset) -> str:
    return str(variable.name).rpartition("/")[2]


def _attributes(found: Mapping[str, Any]) -> dict[str, Any]:
    """What attributes say, numbers that are alone as such.

    Raises:
        TypeError: one is neither text nor numbers, as netCDF's own are under a damaged name.
    """
    values = {name: value for name, value in found.items() if name not in BOOKS}
    for name, value in values.items():
        told = np.asarray(value)
        if told.dtype.kind not in "biufSU" and not all(isinstance(each, str) for each in told.flat):
            raise TypeError(f"attribute {name}: expected text or numbers")
    return {
        name: value[0] if isinstance(value, np.ndarray) and value.shape == (1,) else value
        for name, value in values.items()
    }


def write_netcdf(dataset: xr.Dataset, path: str | Path) -> None:
    """Write a Dataset as netCDF-4; an older file is replaced.

    Raises:
        OSError: the system refuses.
    """
    with h5netcdf.File(path, "w") as file:
        file.dimensions = {str(name): size for name, size in dataset.sizes.items()}
        for name, variable in dataset.variables.items():
            values, attributes = variable.values, dict(variable.attrs)
            if values.dtype == bool:  # netCDF has none: as xarray writes and reads them
                values, attributes["dtype"] = values.astype(np.int8), "bool"
            text = values.dtype.kind in "UO"
            made = file.create_variable(
                str(name),
                tuple(map(str, variable.dims)),
                h5py.string_dtype() if text else values.dtype,
                data=values.astype(object) if text else values,
            )
            made.attrs.update(attributes)
        file.attrs.update(dataset.attrs)
        file.attrs["coordinates"] = " ".join(
            str(name) for name in dataset.coords if name not in dataset.sizes
        )
