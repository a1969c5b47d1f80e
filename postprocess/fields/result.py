"""Results as they lie on disk: opened lazily, checked, read portion by portion.

A result of a long run holds modal histories of hundreds of megabytes. Nothing here loads one
whole: `portions` cuts the records, and `reduce_modes` turns modes into the few numbers a record
that an analysis needs.
"""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Literal

import numpy as np
import xarray as xr

from bladewhirl.models.inputs.errors import UserError
from bladewhirl.postprocess.fields.fields import Array
from bladewhirl.solvers.march.recorder import RESULT_NAME as RESULT_NAME

PORTION = 4096
"""Records read at a time: 5 MB for 156 modes."""

HISTORY = {
    "rotor_displacement": ("time", "rotor_mode"),
    "rotor_velocity": ("time", "rotor_mode"),
    "casing_displacement": ("time", "casing_mode"),
    "casing_velocity": ("time", "casing_mode"),
    "gap": ("time", "blade"),
    "contact_impulse": ("time", "blade"),
    "friction_impulse": ("time", "blade"),
    "contact_steps": ("time", "blade"),
    "contacts": ("time",),
    "energy": ("time",),
    "external_work": ("time",),
    "normal_work": ("time",),
    "friction_work": ("time",),
    "damping_work": ("time",),
    "coupling_work": ("time",),
}
"""What a result records over time, with its dimensions."""

STAGE = {
    "rotor_frequency": ("rotor_mode",),
    "rotor_nodal_diameter": ("rotor_mode",),
    "rotor_family": ("rotor_mode",),
    "rotor_shape": ("rotor_node", "rotor_component", "rotor_mode"),
    "casing_frequency": ("casing_mode",),
    "casing_shape": ("casing_node", "casing_component", "casing_mode"),
    "tip_angle": ("blade",),
    "centre_node": (),
    "clearance": ("casing_node",),
}
"""What every analysis needs to know of the stage, with its dimensions."""

ATTRIBUTES = ("speed", "reference_frequency", "casing_radius", "time_step", "record_step")
"""Numbers every analysis needs, as attributes of the result."""


class ResultError(UserError):
    """A path holds no result of bladewhirl."""


def open_result(path: str | Path) -> xr.Dataset:
    """Open `result.nc`, or the folder of the run that holds it; histories are read when used.

    A killed run opens too, up to what it had flushed. Close it (or use `with`) before writing
    the file anew.

    Raises:
        ResultError: nothing there, not netCDF-4, not a result, or no record in it yet.
    """
    path = Path(path)
    file = path / RESULT_NAME if path.is_dir() else path
    if not file.is_file():
        raise ResultError(f"{file}: expected a result (or the folder of a run), found no such file")
    try:
        # HDF5 files without named dimensions get numbered ones, and are refused by check_result.
        dataset = xr.open_dataset(file, engine="h5netcdf", decode_times=False, phony_dims="sort")
    except (OSError, ValueError, KeyError) as error:
        raise ResultError(
            f"{file}: expected a netCDF-4 result, could not read it: {error}"
        ) from None
    try:
        check_result(dataset, str(file))
    except ResultError:
        dataset.close()
        raise
    return dataset


def check_result(dataset: xr.Dataset, name: str) -> None:
    """See that a Dataset is a result with at least one record; `name` says which in messages.

    Raises:
        ResultError: it is not.
    """
    for variable, dimensions in {"time": ("time",), **HISTORY, **STAGE}.items():
        if variable not in dataset:
            raise ResultError(f"{name}: expected a bladewhirl result, it has no {variable!r}")
        found = dataset[variable].dims
        if found != dimensions:
            raise ResultError(
                f"{name}: expected {variable!r} over ({', '.join(dimensions)}), "
                f"found it over ({', '.join(map(str, found))})"
            )
    for attribute in ATTRIBUTES:
        if attribute not in dataset.attrs:
            raise ResultError(f"{name}: expected a bladewhirl result, no attribute {attribute!r}")
    if not dataset.sizes["time"]:
        raise ResultError(f"{name}: expected at least one record, the run left none")


def portions(dataset: xr.Dataset, size: int = PORTION) -> Iterator[slice]:
    """Cut the records into slices of at most `size`."""
    records = dataset.sizes["time"]
    for first in range(0, records, size):
        yield slice(first, min(first + size, records))


def reduce_modes(
    dataset: xr.Dataset,
    variable: Literal[
        "rotor_displacement", "rotor_velocity", "casing_displacement", "casing_velocity"
    ],
    rows: Array,
    transform: Callable[[Array], Array] | None = None,
) -> Array:
    """Sum modes into rows at every record, a portion at a time: (time, row).

    Args:
        dataset: a result.
        variable: modal history (time, mode).
        rows: weights of the modes, (row, mode).
        transform: applied to the modal coordinates first, such as `numpy.square`.
    """
    out = np.empty((dataset.sizes["time"], len(rows)))
    for portion in portions(dataset):
        coordinates = dataset[variable].isel(time=portion).values
        out[portion] = (coordinates if transform is None else transform(coordinates)) @ rows.T
    return out
