"""Results on disk: opened lazily, validated, read portion by portion.

The modal histories of a long run take hundreds of megabytes. No function of this module loads a
complete history: `portions` divides the records, and `reduce_modes` turns the modal coordinates of
each record into the few numbers that an analysis needs.
"""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, nullcontext
from os import PathLike
from typing import Any, Literal

import numpy as np
import xarray as xr
from xarray.backends import BackendArray
from xarray.core import indexing

from bladewhirl.meshes.plane import rotate
from bladewhirl.models.case.shaft import Shaft
from bladewhirl.models.modal.stage_arrays import StageArrays
from bladewhirl.postprocess.fields.kinematics import Array, table_of_result, tip_rows
from bladewhirl.postprocess.fields.netcdf import ResultError as ResultError
from bladewhirl.postprocess.fields.netcdf import (
    attribute_fault,
    expectation,
    open_file,
)
from bladewhirl.postprocess.fields.wheels import of_wheel, wheel_numbers
from bladewhirl.solvers.march import schema

PORTION = 4096  #: records read at a time: 5 MB for 156 modes
DERIVED = "derived"  #: name of the attribute with the names of the variables that `completed` adds
OLDEST_FORMAT = 10  #: of results that are read; older ones name contact nodes otherwise
BLOCK = 256  #: records multiplied at a time, which remain in the cache
ATTRIBUTES = (
    *("title", "speed", "reference_frequency", "casing_radius", "tip_radius"),
    *("time_step", "record_step"),
)
"""Attributes of a result that every analysis needs."""


def open_result(path: str | PathLike[str]) -> xr.Dataset:
    """Open `result.nc`, or the folder of a run that contains it; histories are read when used.

    The result of a killed run can be opened up to the last record that was written to disk. Close
    the result (or use `with`) before the file is written again. The coordinates of the Dataset are
    the numbers of blades and casing nodes; axes and components of vectors; family, nodal diameter
    and frequency of each mode; and the angles of tips and casing nodes:
    ``open_result("run")["gap"].sel(blade=3)``.

    Raises:
        ResultError: the file does not exist, is not netCDF-4, is not a result, or has no record
            yet.
    """
    dataset, file = open_file(path, schema.RESULT_NAME, "a result")
    try:
        if fault := result_fault(dataset):
            raise ResultError(f"{file}: expected {fault}")
        complete = with_coordinates(_stored(dataset))
    except ResultError:
        dataset.close()
        raise
    complete.set_close(dataset.close)
    return complete


def with_coordinates(dataset: xr.Dataset) -> xr.Dataset:
    """Return a result with all coordinates of the schema, with empty arrays of contact nodes for a
    shaft line without a wheel, and with what follows from the stored arrays, see `completed`."""
    table, empty = schema.STAGE, {}
    if not _has_wheel(dataset):
        sizes = dict.fromkeys(schema.OF_WHEEL, 0) | {schema.TIME: dataset.sizes[schema.TIME]}
        empty = {
            name: _entry(variable, np.zeros([sizes[d] for d in variable.dimensions], variable.kind))
            for name, variable in {**schema.HISTORY, **table}.items()
            if not variable.part and schema.OF_WHEEL.intersection(variable.dimensions)
        }
    dataset = completed(dataset.assign(empty) if empty else dataset)
    indices = {
        name: (name, schema.index_values(name, dataset.sizes[name]), variable.attributes)
        for name, variable in schema.NAMES.items()
        if name in dataset.dims and name not in dataset.coords
    }
    described = [name for name in dataset if name in table and table[str(name)].is_coordinate]
    complete = dataset.assign_coords(indices).set_coords(described)
    return complete if "blade" in complete.xindexes else complete.set_xindex("blade")


def result_of(
    stage: StageArrays, histories: Mapping[str, Array], attributes: Mapping[str, Any]
) -> xr.Dataset:
    """Return a result from arrays in memory, with the content that `open_result` reads from a file.

    Args:
        stage: arrays that describe the stage.
        histories: histories by their name in the schema.
        attributes: attributes of the result.
    """
    values = {**stage.stored, **histories}
    dataset = xr.Dataset(
        {name: _entry(schema.RESULT[name], each) for name, each in values.items()},
        attrs={"format": schema.RESULT_FORMAT, **attributes},
    )
    return with_coordinates(dataset.set_coords(schema.TIME))


def stage_dataset(arrays: StageArrays, motion: Mapping[str, Array] | None = None) -> xr.Dataset:
    """Return geometry, modes and motion of a stage, with the names and units of a result.

    The Dataset lacks the data of contact, load and march, which pictures of modes do not need.

    Args:
        arrays: arrays that describe the stage.
        motion: `time`, `rotor_displacement`, `casing_displacement` and other histories.
    """
    return completed(described({**arrays.stored, **(motion or {})}))


class _ContactMotion(BackendArray):
    """Displacement of the contact nodes of beams, computed when used.

    Args:
        motion: modal coordinates, (time, modes).
        rows: displacement of the nodes for unit modal coordinates, (3, contact_node, modes).
    """

    def __init__(self, motion: xr.Variable, rows: Array) -> None:
        self._motion, self._rows = motion, np.swapaxes(rows, 0, 1)
        self.shape, self.dtype = (len(motion), *self._rows.shape[:2]), rows.dtype

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
        """Return a part of the array."""
        return indexing.explicit_indexing_adapter(
            key, self.shape, indexing.IndexingSupport.OUTER, self._part
        )

    def _part(self, key: tuple[Any, ...]) -> Array:
        time, node, direction = key
        rows = self._rows[node][..., direction, :]
        return np.tensordot(self._motion[time].values, rows, (-1, -1))


class _ShapesOfSectors(BackendArray):
    """Shapes of the points of all sectors, computed when used from those of the first sector, see
    `models.superelements.reduction.SectorWaves`.

    Args:
        first: shapes of the first sector, (point, component, mode).
        number: number of each wave, (mode,).
        partner: other mode of the pair, (mode,).
        sectors: number of sectors.
        turns: whether the components are those of vectors, which turn with the sector.
    """

    def __init__(
        self, first: xr.Variable, number: Array, partner: Array, sectors: int, *, turns: bool
    ) -> None:
        self._first, self._number, self._partner = first, number, partner
        self._sectors, self._turns = sectors, turns
        self.shape, self.dtype = (sectors * first.shape[0], *first.shape[1:]), first.dtype

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
        """Return a part of the array."""
        return indexing.explicit_indexing_adapter(
            key, self.shape, indexing.IndexingSupport.BASIC, self._part
        )

    def _part(self, key: tuple[Any, ...]) -> Array:
        first = self._first.values
        points, pair = np.atleast_1d(np.arange(self.shape[0])[key[0]]), first[..., self._partner]
        sector, place = np.divmod(points, len(first))
        moved = np.empty((len(points), *self.shape[1:]))
        for one in np.unique(sector):
            among, angle = sector == one, 2.0 * np.pi / self._sectors * one
            own, phase = place[among], angle * self._number
            each = np.cos(phase) * first[own] - np.sin(phase) * pair[own]
            moved[among] = rotate(each, angle, axis=1) if self._turns else each
        whole = slice(None) if isinstance(key[0], slice) else 0
        return np.asarray(moved[(whole, *key[1:])])


def _shapes_of_sectors(dataset: xr.Dataset) -> dict[str, xr.Variable]:
    """Return the shapes of all points of equal sectors, of which the first sector is stored."""
    found = {}
    for name in ("point_shape", "stress_shape"):
        if (stored := f"sector_{name}") in dataset and name not in dataset:
            first, variable = dataset.variables[stored], schema.RESULT[name]
            number, partner = dataset["mode_wave"].values, dataset["mode_partner"].values
            sectors, turns = dataset.sizes["point"] // len(first), name == "point_shape"
            shapes = _ShapesOfSectors(first, number, partner, sectors, turns=turns)
            lazy = indexing.LazilyIndexedArray(shapes)
            found[name] = xr.Variable(variable.dimensions, lazy, variable.attributes)
    return found


def completed(dataset: xr.Dataset) -> xr.Dataset:
    """Return a stage with what every stage has, whether its result stores it or not.

    Contact nodes of beams, of which there is one copy, move with nodes of the mesh, and no force
    acts on them along the axis. A file of matrices gives no growth of the tips by steady rotation,
    and no families of modes: their names are then empty, and the nodal diameter is -1. The springs
    of its shaft are those of the case, and the work of closing tips is unknown.
    """
    frequency, nodes = dataset["rotor_frequency"].values, dataset.sizes["contact_node"]
    modes = len(frequency)
    known: dict[str, Any] = {
        "contact_shape": np.zeros((0, 3, modes)),
        "copy_angle": np.zeros(1),
        "tip_growth": np.zeros(nodes),
        "rotor_backward_frequency": frequency,
        "rotor_forward_frequency": frequency,
        "rotor_nodal_diameter": np.full(modes, -1),
        "rotor_family": np.full(modes, ""),
    }
    if "shaft_stiffness" not in dataset:
        known["shaft_stiffness"] = np.array(table_of_result(dataset, "shaft", Shaft).springs)
    if "time" in dataset.dims:
        known["closing_work"] = np.full(dataset.sizes["time"], np.nan)
        known["axial_impulse"] = np.broadcast_to(0.0, (dataset.sizes["time"], nodes))
    if nodes and "contact_shape" not in dataset:
        angle = dataset["tip_angle"].values[:, None]
        shape = dataset["rotor_shape"].values[dataset["tip_node"].values, :2]
        known["contact_shape"] = np.pad(rotate(shape, -angle, axis=1), ((0, 0), (0, 1), (0, 0)))
    found: dict[str, Any] = {
        name: _entry(schema.RESULT[name], each)
        for name, each in known.items()
        if name not in dataset
    }
    if "rotor_displacement" in dataset and "contact_displacement" not in dataset:
        rows = np.swapaxes(known["contact_shape"], 0, 1)  # of the one copy
        if "contact_shape" in dataset:
            rows = tip_rows(dataset)
        motion = _ContactMotion(dataset.variables["rotor_displacement"], rows)
        lazy, variable = indexing.LazilyIndexedArray(motion), schema.RESULT["contact_displacement"]
        found["contact_displacement"] = xr.Variable(variable.dimensions, lazy, variable.attributes)
    found |= _shapes_of_sectors(dataset)
    added = {*str(dataset.attrs.get(DERIVED, "")).split(), *found}
    complete = dataset.assign(found)  # a new Dataset, also its attributes
    complete.attrs[DERIVED] = " ".join(sorted(added))
    return complete


def _stored(dataset: xr.Dataset) -> xr.Dataset:
    """Return a result without the variables that `completed` added before it was saved."""
    return dataset.drop_vars(str(dataset.attrs.get(DERIVED, "")).split(), errors="ignore")


def described(values: Mapping[str, Any]) -> xr.Dataset:
    """Return values by the names of a result, with their dimensions and units; empty ones are left
    out."""
    given = {name: each for name, each in values.items() if np.size(each)}
    return xr.Dataset({name: _entry(schema.RESULT[name], each) for name, each in given.items()})


def _has_wheel(dataset: xr.Dataset) -> bool:
    """Return whether the stage of a result has contact nodes; a shaft line can be without them."""
    return "shaft_position" not in dataset or "tip_angle" in dataset


def _entry(variable: schema.Variable, values: Any) -> tuple[Any, Array, dict[str, str]]:
    """Return a variable of the schema in the form that xarray accepts."""
    return variable.dimensions, np.asarray(values), variable.attributes


@contextmanager
def opened(result: xr.Dataset | str | PathLike[str]) -> Iterator[xr.Dataset]:
    """Yield a result: a Dataset is yielded unchanged, a file or folder is opened and closed
    afterwards."""
    with nullcontext(result) if isinstance(result, xr.Dataset) else open_result(result) as dataset:
        yield dataset


def result_fault(dataset: xr.Dataset) -> str:
    """Return a text on the first fault of a Dataset: what is expected of a result with at least one
    record, and what was found. Return an empty text if there is no fault."""
    if fault := attribute_fault(dataset.attrs):
        return fault
    dataset, made_by = _stored(dataset), dataset.attrs.get("format", 1)
    if made_by > schema.RESULT_FORMAT:
        return (
            f"a result of format {schema.RESULT_FORMAT} or older, found format {made_by}; a newer"
            " bladewhirl reads it"
        )
    if "steady_stress_rest" in dataset:  # of motions without the load by the fourth power
        return (
            "a result of format 15 or newer of 3D blades whose speed varies, found format"
            f" {made_by}; run the case again"
        )
    if made_by < OLDEST_FORMAT and schema.TIME in dataset:
        needed = f"a result of format {OLDEST_FORMAT} or newer"
        return f"{needed}, found format {made_by}; run the case again"
    parts = schema.parts_of(map(str, dataset.variables))
    for key, variable in {**schema.HISTORY, **schema.STAGE}.items():
        absent = schema.OPTIONAL_DIMENSIONS
        if not _has_wheel(dataset):
            absent = absent | schema.OF_WHEEL
        optional = absent.intersection(variable.dimensions)
        if variable.part not in parts or variable.since > made_by or optional:
            continue
        if f"sector_{key}" in dataset:  # from which this one follows
            continue
        if key not in dataset:
            return f"a bladewhirl result; it has no {key!r}"
        dimensions = dataset[key].dims
        if dimensions != variable.dimensions:
            return (
                f"{key!r} with the dimensions ({', '.join(variable.dimensions)}), found"
                f" ({', '.join(map(str, dimensions))})"
            )
    for attribute in ATTRIBUTES:
        if attribute not in dataset.attrs:
            return f"a bladewhirl result; it has no {attribute!r}"
    nodes = dataset.sizes.get("rotor_node", 0)
    for name, variable in schema.STAGE.items():
        if name in dataset and (expected := expectation(dataset[name].values, variable, nodes)):
            return f"{name!r} to be {expected}"
    if "lines" in parts:
        ends = dataset["rotor_point"].values[dataset["rotor_line"].values]
        if not np.any(ends[:, 0] != ends[:, 1], axis=-1).all():
            return "'rotor_line' to connect different points"
    if "waves" in parts:
        modes, sectors = (
            dataset.sizes["mode"],
            dataset.sizes["point"] / dataset.sizes["sector_point"],
        )
        if dataset["mode_partner"].values.max() >= modes or sectors % 1.0:
            return "'mode_partner' to be modes, and equal numbers of points in all sectors"
    if "casing" in parts:
        for number in wheel_numbers(dataset):
            angle = of_wheel(dataset, number)["casing_angle"].values
            if not (np.all(np.diff(angle) > 0.0) and angle[-1] - angle[0] < 2.0 * np.pi):
                return "'casing_angle' to increase within one turn"
    if not dataset.sizes["time"]:
        return "at least one record, found none"
    if not (np.diff(dataset[schema.TIME].values) > 0.0).all():
        return "'time' to increase, the file was changed or damaged"
    return ""


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
    """Return weighted sums of the modal coordinates at every record, (time, row), read in portions.

    Args:
        dataset: a result.
        variable: modal history (time, mode).
        rows: weights of the modes, (row, mode).
        transform: applied to the modal coordinates first, such as `numpy.square`.
    """
    out = np.empty((dataset.sizes["time"], len(rows)))
    history = dataset.variables[variable]  # without coordinates, which take time to cut
    columns = np.ascontiguousarray(rows.T)
    for portion in portions(dataset):
        coordinates, reduced = history[portion].values, out[portion]
        for first in range(0, len(coordinates), BLOCK):
            block = coordinates[first : first + BLOCK]
            block = block if transform is None else transform(block)
            np.matmul(block, columns, out=reduced[first : first + BLOCK])
    return out
