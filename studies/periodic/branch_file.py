"""The file of a branch, to which each point is added as it is found."""

from collections.abc import Iterable, Mapping
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import h5netcdf
import h5py
import numpy as np
import xarray as xr

from bladewhirl.models.inputs.errors import writing
from bladewhirl.postprocess.periodic.dataset import VARIABLES

Row = Mapping[str, Any]
"""Values of `VARIABLES` at a point."""


class BranchFile(AbstractContextManager["BranchFile"]):
    """File of a branch, open for writing.

    Args:
        path: path of the file.
        coordinates: coordinates; None: the file exists, and points are added to it.
        attributes: attributes of a new file.

    Raises:
        UserError: the file cannot be written.
    """

    def __init__(
        self, path: Path, coordinates: Mapping[str, Any] | None, attributes: Mapping[str, Any]
    ) -> None:
        with writing(path):
            self._h5 = h5py.File(path, "w" if coordinates is not None else "r+")
            self._file = h5netcdf.File(self._h5, "r+" if coordinates is None else "w")
        if coordinates is None:
            return
        file = self._file
        file.dimensions = {"point": None} | {name: len(each) for name, each in coordinates.items()}
        for name, each in coordinates.items():
            text = np.asarray(each).dtype.kind == "U"
            kind, data = (
                (h5py.string_dtype(), np.array(each, dtype=object)) if text else ("f8", each)
            )
            file.create_variable(name, (name,), kind, data=data)
        for name, (dimensions, unit, label) in VARIABLES.items():
            made = file.create_variable(name, ("point", *dimensions), "f8")
            made.attrs.update({"units": unit, "long_name": label})
        file.attrs.update(attributes)
        self._h5.flush()

    def add(self, row: Row) -> None:
        """Add a point at the end."""
        count = self._file.dimensions["point"].size
        self._file.resize_dimension("point", count + 1)
        for name in VARIABLES:
            self._file.variables[name][count] = row[name]
        self._h5.flush()

    def correct(self, name: str, point: int, value: float) -> None:
        """Change the value of a variable at a point."""
        self._file.variables[name][point] = value
        self._h5.flush()

    def note(self, **attributes: str) -> None:
        """Add attributes."""
        self._file.attrs.update(attributes)
        self._h5.flush()

    def __exit__(self, *_: object) -> None:
        """Close the file."""
        self._file.close()
        self._h5.close()


def dataset(
    rows: Iterable[Row], coordinates: Mapping[str, Any], attributes: Mapping[str, Any]
) -> xr.Dataset:
    """Return the Dataset of the points of a branch, as in its file."""
    rows = list(rows)
    data = {
        name: (
            ("point", *dimensions),
            np.stack([np.asarray(row[name], dtype=np.float64) for row in rows]),
            {"units": unit, "long_name": label},
        )
        for name, (dimensions, unit, label) in VARIABLES.items()
    }
    return xr.Dataset(data, dict(coordinates), dict(attributes))


def rows(data: xr.Dataset) -> list[Row]:
    """Return the points of a Dataset."""
    return [{name: data[name].values[n] for name in VARIABLES} for n in range(data.sizes["point"])]
