"""Datasets of branches of periodic motions, and a function to open them."""

from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
import xarray as xr

from bladewhirl.models.case.file import read_case
from bladewhirl.models.inputs.table import path_of, value_at
from bladewhirl.models.inputs.units import Speed, to_si
from bladewhirl.postprocess.fields.kinematics import ViewError
from bladewhirl.postprocess.fields.netcdf import ResultError, open_file, plausible
from bladewhirl.solvers.periodic.bifurcation import KINDS

BRANCH_NAME = "branch.nc"  #: name of the file of a branch in its folder
CASE_NAME = "case.toml"  #: name of the file of its case
CASE_FILE = "case_file"  #: attribute of an open branch with the path of its case
NODES = ("instant", "node")
SPEED = "march.speed"

KIND_NAMES = dict(enumerate(("none", *KINDS)))  #: names of the numbers of `kind`

OF_KEY = "of the key"  #: unit of variables that have the unit of the key of the branch
VARIABLES: Mapping[str, tuple[tuple[str, ...], str, str]] = {
    "parameter": ((), OF_KEY, "value of the key"),
    "speed_rad_s": ((), "rad/s", "speed of rotation"),
    "impulse_per_revolution": ((), "N s", "normal impulse per revolution"),
    "residual": ((), "1", "residual of the equations"),
    "kind": ((), "1", "bifurcation: " + ", ".join(f"{n} {name}" for n, name in KIND_NAMES.items())),
    "shift": ((), OF_KEY, "change of the parameter of a bifurcation with twice as many instants"),
    "heading": ((), OF_KEY, "change of the parameter along the tangent of unit length"),
    "multiplier_real": (("multiplier",), "1", "real part of the multiplier"),
    "multiplier_imaginary": (("multiplier",), "1", "imaginary part of the multiplier"),
    "normal_force": (NODES, "N", "normal force"),
    "slip_direction": (NODES, "rad", "angle of the direction of sliding from the tangent"),
    "contact_displacement": ((*NODES, "direction"), "m", "displacement of the contact nodes"),
    "amplitude": (("order", "node", "direction"), "m", "amplitude of the harmonics"),
    "tangent_force": (NODES, "N", "change of the normal force along the tangent of unit length"),
    "tangent_direction": (NODES, "rad", "change of the direction of sliding along the tangent"),
    "next_step": ((), "1", "length of the next step"),
}
"""Dimensions after `point`, unit and name of each variable of a branch."""
TO_RESUME = ("tangent_force", "tangent_direction", "next_step")
"""Variables that files of earlier versions do not have."""
COORDINATES = ("instant", "node", "direction", "order", "multiplier")
"""Coordinates of a branch, which have no unit."""
ATTRIBUTES = {"title": str, "case": str, "key": str, "unit": str, "start": float, "stop": float}
"""Attributes of a branch, and their types."""


def open_branch(path: str | Path) -> xr.Dataset:
    """Return the branch of periodic motions in a file or folder, with the variables of
    `bladewhirl.branch`.

    Raises:
        ResultError: it cannot be read or contains no points of a branch.
    """
    data, file = open_file(path, BRANCH_NAME, "the file of a branch")
    with data:
        for fault in _faults(data):
            raise ResultError(f"{file}: expected the file of a branch with {fault}")
        loaded = data.load()
    case = file.parent / CASE_NAME
    return with_stability(loaded.assign_attrs({CASE_FILE: str(case)} if case.exists() else {}))


def _faults(data: xr.Dataset) -> Iterator[str]:
    """Yield what an opened file of a branch lacks."""
    for name, (dimensions, *_) in VARIABLES.items():
        if name not in data.variables:
            if name not in TO_RESUME:
                yield f"the variable {name!r}"
        elif data[name].dims != ("point", *dimensions) or data[name].dtype != np.float64:
            yield f"{name!r} as numbers over {', '.join(('point', *dimensions))}"
    for name in ("point", *COORDINATES):
        if not data.sizes.get(name):
            yield f"at least one {name}"
    if (instants := data.sizes["instant"]) & (instants - 1):
        yield f"a power of two of instants, not {instants}"
    for name, kind in ATTRIBUTES.items():
        value = data.attrs.get(name)
        if not isinstance(value, kind) or (isinstance(value, float) and not plausible(value)):
            yield f"the attribute {name!r}"
    for name, least in (("blade", 0), ("periods", 1), ("points", 1)):
        value = data.attrs.get(name, 1)
        if not isinstance(value, int | np.integer) or value < least:
            yield f"the attribute {name!r} as a whole number of at least {least}"


def with_stability(data: xr.Dataset) -> xr.Dataset:
    """Return a branch with the variable `stable`: all multipliers are less than 1 in magnitude."""
    size = np.hypot(data["multiplier_real"].values, data["multiplier_imaginary"].values)
    return data.assign(stable=("point", size.max(axis=1) < 1.0))


def of_sweep(branch: xr.Dataset, sweep: xr.Dataset) -> float:
    """Return the factor from the parameter of a branch to the same key of a sweep.

    Raises:
        ViewError: one of them is none, or the sweep is not over this key.
    """
    if "key" not in branch.attrs:
        raise ViewError("expected a branch to lay over a sweep")
    key, given = str(branch.attrs["key"]), str(branch.attrs["unit"])
    name = key.replace(".", "_")
    if "state" not in sweep or name not in sweep.coords:
        raise ViewError(f"expected a sweep over {key}, the key of the branch")
    unit = str(sweep[name].attrs["units"])
    if key == SPEED:
        reference = float(sweep["reference_frequency"].mean()) if unit == "1" else 1.0
        return float((branch["speed_rad_s"] / branch["parameter"])[0]) / reference
    return to_si(f"1 {given}", unit) if given else 1.0


def fixed(branch: xr.Dataset, sweep: xr.Dataset, name: str) -> float:
    """Return the value of a swept key, given as its dimension, in the case of a branch, in the unit
    of the sweep.

    Raises:
        ViewError: the case of the branch is unknown, or has no value of the key.
    """
    key, file = str(sweep[name].attrs["long_name"]), branch.attrs.get(CASE_FILE)
    if file is None:
        raise ViewError(f"{key}: expected a branch in a folder with its {CASE_NAME}")
    value = value_at(read_case(str(file)), path_of(key))
    if isinstance(value, Speed):
        reference = float(sweep["reference_frequency"].mean())
        ratio = value.multiple(reference)
        return ratio if str(sweep[name].attrs["units"]) == "1" else ratio * reference
    if value is None:
        raise ViewError(f"{file}: expected a value of {key}")
    return float(value)
