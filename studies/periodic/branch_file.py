"""The file of a branch, to which each point is added as it is found."""

from collections.abc import Iterable, Mapping
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import h5netcdf
import h5py
import numpy as np
import xarray as xr

from bladewhirl.meshes.hdf5 import open_hdf5
from bladewhirl.models.inputs.errors import writing
from bladewhirl.postprocess.periodic.dataset import OF_KEY, VARIABLES

UNITS = "key_units"  #: attribute of a branch with the unit of its key, also where none was given

Row = Mapping[str, Any]
"""Values of `VARIABLES` at a point."""


class BranchFile(AbstractContextManager["BranchFile"]):
    """File of a branch, open for writing.

    Args:
        path: path of the file.
        coordinates: coordinates; None: the file exists, and points are added to it.
        attributes: attributes of a new file.
        points: number of points of a file that exists; further ones are removed.

    Raises:
        UserError: the file cannot be written.
    """

    def __init__(
        self,
        path: Path,
        coordinates: Mapping[str, Any] | None,
        attributes: Mapping[str, Any],
        points: int = 0,
    ) -> None:
        with writing(path):
            self._h5 = h5py.File(path, "w") if coordinates is not None else open_hdf5(path, "r+")
            self._file = h5netcdf.File(self._h5, "r+" if coordinates is None else "w")
        file = self._file
        if coordinates is None:
            file.resize_dimension("point", points)
            return
        file.dimensions = {"point": None} | {name: len(each) for name, each in coordinates.items()}
        for name, each in coordinates.items():
            text = np.asarray(each).dtype.kind == "U"
            kind, data = (
                (h5py.string_dtype(), np.array(each, dtype=object)) if text else ("f8", each)
            )
            made = file.create_variable(name, (name,), kind, data=data)
            made.attrs["units"] = "1"
        for name, (dimensions, *_) in VARIABLES.items():
            made = file.create_variable(name, ("point", *dimensions), "f8")
            made.attrs.update(_described(name, attributes))
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
            _described(name, attributes),
        )
        for name, (dimensions, *_) in VARIABLES.items()
    }
    axes = {name: (name, each, {"units": "1"}) for name, each in coordinates.items()}
    return xr.Dataset(data, axes, dict(attributes))


def _described(name: str, attributes: Mapping[str, Any]) -> dict[str, str]:
    """Return unit and name of a variable of a branch with attributes."""
    _, unit, label = VARIABLES[name]
    return {"units": attributes[UNITS] if unit == OF_KEY else unit, "long_name": label}


def rows(data: xr.Dataset) -> list[Row]:
    """Return the points of a Dataset."""
    return [{name: data[name].values[n] for name in VARIABLES} for n in range(data.sizes["point"])]
