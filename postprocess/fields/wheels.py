"""Parts of the result of a shaft line on which several wheels touch walls, wheel by wheel."""

import numpy as np
import xarray as xr

WHEELS = {
    "contact_node": "wheel",
    "casing_node": "casing_wheel",
    "wall_angle": "wall_wheel",
    "support": "support_wheel",
}
"""Dimensions with parts of all wheels, and variables with the wheel of each part."""


def wheel_numbers(dataset: xr.Dataset) -> list[int]:
    """Return the numbers of the wheels with a wall, 0 for the first or only one."""
    names = [*_parted(dataset).values()]
    return [int(number) for number in np.unique(dataset[names[0]].values)] if names else [0]


def _parted(dataset: xr.Dataset) -> dict[str, str]:
    """Return the entries of `WHEELS` that a dataset has."""
    return {
        dimension: name
        for dimension, name in WHEELS.items()
        if name in dataset.variables and dataset[name].dims == (dimension,)
    }


def of_wheel(dataset: xr.Dataset, number: int) -> xr.Dataset:
    """Return a result with the contact nodes and the ring of one of several wheels with walls; a
    result of one wheel as it is."""
    chosen = {
        dimension: np.flatnonzero(dataset[name].values == number)
        for dimension, name in _parted(dataset).items()
    }
    if not chosen:
        return dataset
    part = dataset.isel(chosen)
    if "ring_radius" not in part.variables:
        return part
    return part.assign_attrs(casing_radius=float(part["ring_radius"].values[0]))


def of_first_wheel(dataset: xr.Dataset) -> xr.Dataset:
    """Return a result with the contact nodes and the ring of the first of several wheels, which
    pictures show."""
    return of_wheel(dataset, 0)
