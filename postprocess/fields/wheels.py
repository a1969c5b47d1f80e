"""Parts of the result of a shaft line on which several wheels touch walls, wheel by wheel."""

from collections.abc import Iterable

import numpy as np
import xarray as xr

from bladewhirl.solvers.march.schema import STAGE

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
    part = _of_wheels(dataset, [number])
    if part is dataset or "ring_radius" not in part.variables:
        return part
    return part.assign_attrs(casing_radius=float(part["ring_radius"].values[0]))


def _of_wheels(dataset: xr.Dataset, numbers: Iterable[int]) -> xr.Dataset:
    """Return a result with the contact nodes and rings of some of several wheels with walls."""
    chosen = {
        dimension: np.flatnonzero(np.isin(dataset[name].values, [*numbers]))
        for dimension, name in _parted(dataset).items()
    }
    return dataset.isel(chosen) if chosen else dataset


def of_first_wheel(dataset: xr.Dataset) -> xr.Dataset:
    """Return a result with the contact nodes and the ring of the first of several wheels."""
    return of_wheel(dataset, 0)


def with_surfaces(dataset: xr.Dataset) -> xr.Dataset:
    """Return a result without the contact nodes and rings of further wheels that pictures cannot
    show, as their files have no surface."""
    numbers = wheel_numbers(dataset)
    if len(numbers) == 1:
        return dataset
    shown = np.zeros(0, dtype=np.int64)
    if "triangle" in dataset and "further_triangle" in dataset:
        corners = dataset["further_triangle"].values[:, 0]
        shown = np.unique(dataset["further_point_wheel"].values[corners])
    left = [0, *np.intersect1d(shown, numbers).tolist()]
    return dataset if left == numbers else _of_wheels(dataset, left)


def each_wheel(dataset: xr.Dataset) -> list[xr.Dataset]:
    """Return for each wheel of a result `with_surfaces` the result of this wheel alone, with its
    points; the shaft and stresses are in that of the first."""
    first, *others = wheel_numbers(dataset)
    return [of_wheel(dataset, first), *(_further(dataset, number) for number in others)]


def _further(dataset: xr.Dataset, number: int) -> xr.Dataset:
    """Return the result of a further wheel alone."""
    own = np.flatnonzero(dataset["further_point_wheel"].values == number)
    triangles = dataset["further_triangle"].values
    values = {
        "centre_shape": dataset["further_centre_shape"].values[number - 1],
        "point": dataset["further_point"].values[own],
        "point_shape": dataset["further_point_shape"].values[own],
        "triangle": triangles[np.isin(triangles[:, 0], own)] - own[0],
    }
    part = of_wheel(dataset, number)
    of_first = [str(name) for name in part.variables if name in STAGE]
    of_first = [name for name in of_first if STAGE[name].part in ("points", "stress", "wheel")]
    found = {name: (STAGE[name].dimensions, each) for name, each in values.items()}
    return part.drop_vars(of_first).assign(found)
