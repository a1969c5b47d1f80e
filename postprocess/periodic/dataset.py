"""Datasets of branches of periodic motions, and a function to open them."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import xarray as xr

from bladewhirl.models.case.file import read_case
from bladewhirl.models.inputs.table import path_of, value_at
from bladewhirl.models.inputs.units import Speed, to_si
from bladewhirl.postprocess.fields.kinematics import ViewError
from bladewhirl.postprocess.fields.netcdf import ResultError
from bladewhirl.solvers.periodic.bifurcation import KINDS

BRANCH_NAME = "branch.nc"  #: name of the file of a branch in its folder
CASE_NAME = "case.toml"  #: name of the file of its case
CASE_FILE = "case_file"  #: attribute of an open branch with the path of its case
NODES = ("instant", "node")
SPEED = "march.speed"

KIND_NAMES = dict(enumerate(("none", *KINDS)))  #: names of the numbers of `kind`

VARIABLES: Mapping[str, tuple[tuple[str, ...], str, str]] = {
    "parameter": ((), "", "value of the key"),
    "speed_rad_s": ((), "rad/s", "speed of rotation"),
    "impulse_per_revolution": ((), "N s", "normal impulse per revolution"),
    "residual": ((), "1", "residual of the equations"),
    "kind": ((), "1", "bifurcation: " + ", ".join(f"{n} {name}" for n, name in KIND_NAMES.items())),
    "shift": ((), "", "change of the parameter of a bifurcation with twice as many instants"),
    "heading": ((), "1", "change of the parameter along the branch, with its sign"),
    "multiplier_real": (("multiplier",), "1", "real part of the multiplier"),
    "multiplier_imaginary": (("multiplier",), "1", "imaginary part of the multiplier"),
    "normal_force": (NODES, "N", "normal force"),
    "slip_direction": (NODES, "rad", "angle of the direction of sliding from the tangent"),
    "contact_displacement": ((*NODES, "direction"), "m", "displacement of the contact nodes"),
    "amplitude": (("order", "node", "direction"), "m", "amplitude of the harmonics"),
}
"""Dimensions after `point`, unit and name of each variable of a branch."""


def open_branch(path: str | Path) -> xr.Dataset:
    """Return the branch of periodic motions in a file or folder, with the variables of
    `bladewhirl.branch`.

    Raises:
        ResultError: it cannot be read or contains no points of a branch.
    """
    file = Path(path) / BRANCH_NAME if Path(path).is_dir() else Path(path)
    try:
        with xr.open_dataset(file, engine="h5netcdf") as data:
            loaded = data.load()
    except (OSError, ValueError) as error:
        raise ResultError(f"{file}: expected the file of a branch ({error})") from None
    if not set(VARIABLES) <= set(loaded.variables) or not loaded.sizes["point"]:
        raise ResultError(f"{file}: expected the file of a branch with at least one point")
    case = file.parent / CASE_NAME
    return with_stability(loaded.assign_attrs({CASE_FILE: str(case)} if case.exists() else {}))


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
