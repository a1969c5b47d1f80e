"""Datasets of sweeps: the data that are stored for every point, and a function to open them.

The swept keys are the first dimensions of every variable; the key march.speed is the dimension
march_speed. Results that are words, such as the regime, are stored as integer codes with a list of
their meanings (CF conventions), so that each point has a fixed size and can be written in place;
`open_sweep` turns the codes into text.
"""

import json
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from math import prod
from pathlib import Path
from typing import Any
from zlib import crc32

import numpy as np
import xarray as xr

from bladewhirl.postprocess.fields import netcdf
from bladewhirl.postprocess.fields.kinematics import Array
from bladewhirl.solvers.march.schema import (
    DRAW,
    NAMES,
    SCREENING,
    SWEEP,
    SWEEP_FORMAT,
    Variable,
    index_values,
    parts_of,
)

SWEEP_NAME = "sweep.nc"  #: name of the dataset's file in the folder of a sweep
MISSING, DONE, FAILED, NOT_NEEDED = range(4)  #: codes of the variable `state` of a point
SCREENED = "screened"  #: name of the variable that marks screening marches
#: all checksums are verified when a dataset is opened, unless it is larger than this [bytes]
CHECKED_BYTES = 2**28
BLOCK = 64  #: number of points whose checksums are verified together
WINDOW_SHARE = 0.5
"""Length of the time window for spectra and mean energies, divided by that of the shortest march.
The window is at the end of every march, after the transient. In a march that ended early the window
is at most this fraction of the march."""

LINE, GROUP, SAMPLE, SECTION = "mode", "energy_group", "sample", "section"
DIRECTION = "direction"  #: name of the dimension of the directions of a contact node's displacement

NATURAL_MODE = "natural"  #: name of the dimension of natural frequencies
NATURAL = 24  #: number of natural frequencies that are stored

SECTIONS = 64
"""Largest number of points of the Poincaré map, and of local maxima of the displacement, that are
stored for a march; the last ones are kept."""

MODE_LINES: Mapping[str, tuple[str, str | None]] = {
    "suspension": ("rotor", "suspension"),
    "1F k=1": ("rotor", "1F"),
    "2F k=1": ("rotor", "2F"),
    "casing k=1": ("casing", None),
}
"""Modes with one nodal diameter, which can move the shaft: body, and family or None for any."""


@dataclass(frozen=True, kw_only=True)
class Layout:
    """Sizes of the data of a point; all points of a sweep have the same sizes."""

    frequency: Array  #: of spectra, multiples of 1 / window [Hz], (frequencies,)
    samples: int  #: number of samples of the thinned histories
    nodal_diameters: int = 0  #: number of nodal diameters of the first blade family, from 0
    blades: int
    parts: frozenset[str] = frozenset({"", "centre", "families"})
    """Parts of the stage, see `solvers.march.schema.Variable`, that determine the variables."""

    @property
    def variables(self) -> dict[str, Variable]:
        """Variables of the sweep, by name."""
        return {name: variable for name, variable in SWEEP.items() if variable.part in self.parts}

    @property
    def window(self) -> float:
        """Time window of spectra and mean energies, at the end of each march [s]."""
        return float(1.0 / (self.frequency[1] - self.frequency[0]))

    @property
    def groups(self) -> tuple[str, ...]:
        """Names of the groups of rotor modes whose strain energies are stored: the suspension, the
        first blade family by nodal diameter, and all other modes; without families, all modes."""
        if "families" not in self.parts:
            return ("all",)
        return ("suspension", *(f"1F k={k}" for k in range(self.nodal_diameters)), "rest")

    @property
    def sizes(self) -> dict[str, int]:
        """Length of each dimension in addition to the swept keys."""
        sizes = {
            "frequency": len(self.frequency),
            SAMPLE: self.samples,
            "blade": self.blades,
            SECTION: SECTIONS,
            NATURAL_MODE: NATURAL,
            **{name: len(labels) for name, labels in self.names.items()},
        }
        used = {name for variable in self.variables.values() for name in variable.dimensions}
        return {name: size for name, size in sizes.items() if name in used | {"frequency"}}

    @property
    def names(self) -> dict[str, tuple[str, ...]]:
        """Names of the elements along each dimension whose elements have names."""
        named = {
            GROUP: self.groups,
            LINE: tuple(MODE_LINES),
            DIRECTION: NAMES[DIRECTION].labels,
        }
        used = {name for variable in self.variables.values() for name in variable.dimensions}
        return {name: labels for name, labels in named.items() if name in used}

    def shape(self, name: str) -> tuple[int, ...]:
        """Shape of a variable at one point."""
        return tuple(self.sizes[dimension] for dimension in SWEEP[name].dimensions)

    @property
    def bytes_per_point(self) -> int:
        """Size of a point in the dataset [bytes]."""
        return sum(
            np.dtype(variable.kind).itemsize * int(np.prod(self.shape(name), dtype=np.int64))
            for name, variable in self.variables.items()
        )


def flag(variable: str, meaning: str) -> int:
    """Return the integer code by which a variable stores a meaning, such as a regime."""
    return SWEEP[variable].labels.index(meaning)


def checksum(
    variables: Mapping[str, Variable], numbers: Mapping[str, Array], coordinates: Iterable[Array]
) -> int:
    """Return the CRC-32 of the named arrays of a point and of the coordinates. Coordinates are the
    values of every swept key, and the frequencies of the spectra."""
    crc = 0
    for values in coordinates:
        crc = crc32(np.ascontiguousarray(values, dtype="f8").tobytes(), crc)
    for name, variable in variables.items():
        if name in numbers and name not in ("state", "checksum"):
            crc = crc32(np.ascontiguousarray(numbers[name], variable.kind).tobytes(), crc)
    return crc


def changed_point(
    variables: Mapping[str, Variable],
    read: Callable[[str, slice], Array],
    shape: tuple[int, ...],
    coordinates: Iterable[Array],
) -> int | None:
    """Return the number of the first finished point whose data do not have the stored checksum;
    None if all data are as written by the sweep.

    Args:
        variables: variables of the sweep.
        read: function that returns rows of a variable along the first swept key.
        shape: number of values of each swept key.
        coordinates: values of every swept key, and frequencies of the spectra.
    """
    width, given = prod(shape[1:]), list(coordinates)
    for first in range(0, shape[0], max(1, BLOCK // width)):
        rows = slice(first, first + max(1, BLOCK // width))
        block = {name: read(name, rows) for name in variables}
        flat = {n: values.reshape(-1, *values.shape[len(shape) :]) for n, values in block.items()}
        for point in np.flatnonzero(flat["state"] == DONE):
            numbers = {name: values[point] for name, values in flat.items()}
            if checksum(variables, numbers, given) != numbers["checksum"]:
                return int(first * width + point)
    return None


def open_sweep(path: str | Path) -> xr.Dataset:
    """Open the dataset of a sweep, by its file or folder; arrays are read when used.

    Results that are words, such as the regime, are returned as text. The coordinate `speed_ratio`
    of the points is the speed divided by the reference frequency. If swept values were given with a
    unit, the values in this unit are a further coordinate, such as `march_speed_rpm`. Arrays are
    not cached, so that histories of many points, read one after another, take the memory of one
    point. The checksums of all points are verified if the dataset is not larger than
    `CHECKED_BYTES`. Close the dataset, or use ``with``.

    Raises:
        ResultError: the file does not exist, is not a sweep, was written by a newer version, or was
            changed after it was written.
    """
    dataset, file = netcdf.open_file(path, SWEEP_NAME, "a sweep", gaps=True, cache=False)
    fault = _fault(dataset)
    if fault:
        dataset.close()
        raise netcdf.ResultError(f"{file}: expected a sweep of bladewhirl, {fault}")
    named: dict[str, Any] = {
        name: (dataset[name].dims, np.array(variable.labels)[dataset[name].values])
        for name, variable in {**SWEEP, **SCREENING}.items()
        if variable.labels and name in dataset
    }
    if "mode_forward_frequency" not in dataset and "mode_frequency" in dataset:  # before format 4
        named["mode_forward_frequency"] = dataset["mode_frequency"]
    ratio = dataset["rotation_speed"] / dataset["reference_frequency"]
    about = {"units": "1", "long_name": "speed divided by the reference frequency"}
    opened = dataset.assign(named).assign_coords(
        blade=index_values("blade", dataset.sizes["blade"]), speed_ratio=ratio.assign_attrs(about)
    )
    opened.set_close(dataset.close)
    return opened


def _fault(dataset: xr.Dataset) -> str:
    """Return the reason why this version cannot read a dataset as a sweep; an empty text if it
    can."""
    if "over" not in dataset.attrs or "state" not in dataset:
        return "it has no states of its points"
    for name in ("title", "criterion", "window"):
        if name not in dataset.attrs:
            return f"it has no {name!r}"
    if fault := netcdf.attribute_fault(dataset.attrs):
        return fault
    made_by = dataset.attrs.get("format", 1)
    if made_by > SWEEP_FORMAT:
        return (
            f"of format {SWEEP_FORMAT} or older, found format {made_by}; a newer version reads it"
        )
    if made_by < 8 and netcdf.has(dataset, "nodes"):
        return (
            f"of a superelement of format 8 or newer, found format {made_by}; run the sweep again"
        )
    parts = parts_of(map(str, dataset.variables))
    for name, variable in {**SWEEP, **SCREENING}.items():
        if name not in dataset:
            if variable.since <= made_by and variable.part in parts and name in SWEEP:
                return f"it has no {name!r}"
            continue
        if dataset[name].dims != (*swept(dataset), *variable.dimensions):
            return f"with {name!r} over the points of the sweep"
        # Only codes are checked now; numbers are checked when they are read.
        if variable.labels and (expected := netcdf.expectation(dataset[name].values, variable)):
            return f"with {name!r} as {expected}"
    try:
        coordinates = stored_coordinates(dataset)
    except (ValueError, AttributeError, TypeError):
        return "with the keys of its table as JSON"
    for name in coordinates:
        values = dataset[name].values if name in dataset else np.zeros(0)
        if (
            values.ndim != 1
            or values.dtype.kind != "f"
            or not values.size
            or not np.isfinite(values).all()
        ):
            return f"with finite numbers along {name!r}"
    blades, groups = dataset.sizes["blade"], dataset.sizes.get(GROUP, 2)
    layout = Layout(
        frequency=dataset["frequency"].values,
        samples=dataset.sizes[SAMPLE],
        nodal_diameters=groups - 2,
        blades=blades,
        parts=frozenset(parts),
    )
    for name, labels in layout.names.items():
        if name not in dataset or dataset[name].values.tolist() != [*labels]:
            return f"with other names along {name!r}"
    if np.any(np.diff(dataset["frequency"].values) <= 0.0):
        return "with ascending numbers along 'frequency'"
    return _changed(dataset, made_by)


def _changed(dataset: xr.Dataset, made_by: int) -> str:
    if made_by < SWEEP["checksum"].since or dataset.nbytes > CHECKED_BYTES:
        return ""
    coordinates = [dataset[name].values for name in stored_coordinates(dataset)]
    point = changed_point(
        {name: variable for name, variable in SWEEP.items() if name in dataset},
        lambda name, rows: dataset[name][rows].values,
        dataset["state"].shape,
        coordinates,
    )
    return "" if point is None else f"but point {point} was changed after it was written"


def swept(dataset: xr.Dataset) -> list[str]:
    """Return the dimensions of the swept keys, in the order of the sweep."""
    return [str(dimension) for dimension in dataset["state"].dims]


def swept_keys(dataset: xr.Dataset) -> list[str]:
    """Return the names of the swept keys as coordinates, in the order of the sweep, without the
    random draws. The keys of a table are coordinates along the dimension `point`."""
    keys = json.loads(dataset.attrs.get("table", "{}"))
    names = [key.replace(".", "_") for key in keys]
    return names or [name for name in swept(dataset) if name != DRAW]


def stored_coordinates(dataset: xr.Dataset) -> list[str]:
    """Return the names of the coordinates that the checksums of the points include."""
    return [*dict.fromkeys((*swept(dataset), *swept_keys(dataset))), "frequency"]
