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


EVERY_FORCE = "every_contact_force"
"""Variable with `contact_force` on the nodes of all wheels in the result of one of them: all forces
have a part in the stresses of a wheel."""


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
    if not chosen:
        return dataset
    part = dataset.isel(chosen)
    if "stress_by_force" not in part.variables or EVERY_FORCE in part.variables:
        return part
    force = dataset["contact_force"]
    of_nodes = [name for name, each in force.coords.items() if "contact_node" in each.dims]
    return part.assign({EVERY_FORCE: force.drop_vars(of_nodes).rename(contact_node="pushed_node")})


def of_first_wheel(dataset: xr.Dataset) -> xr.Dataset:
    """Return a result with the contact nodes and the ring of the first of several wheels."""
    return of_wheel(dataset, 0)


def with_surfaces(dataset: xr.Dataset) -> xr.Dataset:
    """Return a result without the contact nodes and rings of further wheels that pictures cannot
    show, as their files have no surface."""
    numbers = wheel_numbers(dataset)
    if len(numbers) == 1:
        return dataset
    left = [0, *np.intersect1d(_with_surface(dataset), numbers).tolist()]
    return dataset if left == numbers else _of_wheels(dataset, left)


def _with_surface(dataset: xr.Dataset) -> list[int]:
    """Return the numbers of the further wheels that pictures can show."""
    if "triangle" not in dataset or "further_triangle" not in dataset:
        return []
    corners = dataset["further_triangle"].values[:, 0]
    return [int(number) for number in np.unique(dataset["further_point_wheel"].values[corners])]


def wheels_without_wall(dataset: xr.Dataset) -> list[xr.Dataset]:
    """Return the results of further wheels without a wall: their points, and no contact node."""
    numbers = np.setdiff1d(_with_surface(dataset), wheel_numbers(dataset))
    part = dataset.isel(contact_node=slice(0))
    return [_with_points(dataset, part, number) for number in numbers.tolist()]


def each_wheel(dataset: xr.Dataset) -> list[xr.Dataset]:
    """Return for each wheel of a result `with_surfaces` the result of this wheel alone, with its
    points; the shaft and stresses are in that of the first."""
    first, *others = wheel_numbers(dataset)
    further = [_with_points(dataset, of_wheel(dataset, number), number) for number in others]
    return [of_wheel(dataset, first), *further]


def _with_points(dataset: xr.Dataset, part: xr.Dataset, number: int) -> xr.Dataset:
    """Return a part of a result with the points of a further wheel, without the shaft."""
    own = np.flatnonzero(dataset["further_point_wheel"].values == number)
    triangles = dataset["further_triangle"].values
    values = {
        "centre_shape": dataset["further_centre_shape"].values[number - 1],
        "point": dataset["further_point"].values[own],
        "point_shape": dataset["further_point_shape"].values[own],
        "triangle": triangles[np.isin(triangles[:, 0], own)] - own[0],
    }
    of_first = [str(name) for name in part.variables if name in STAGE]
    of_first = [name for name in of_first if STAGE[name].part in ("points", "stress", "wheel")]
    found = {name: (STAGE[name].dimensions, each) for name, each in values.items()}
    return part.drop_vars(of_first).assign(found)
