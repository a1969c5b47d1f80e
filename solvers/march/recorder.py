"""Records of a march on disk, in `result.nc`, a netCDF-4 file that grows during the march, or in
memory, for marches whose histories are not written to a file.

Every variable has named dimensions, units and a long name. Flushed data remain if the process is
killed. Only h5py can flush a file, so the file is opened with h5py and passed to h5netcdf. Records
are flushed before the attribute `steps` includes them.
"""

from collections.abc import Mapping
from contextlib import AbstractContextManager
from os import PathLike
from typing import Any

import h5netcdf
import h5py
import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.inputs.timing import Timing
from bladewhirl.models.modal.stage_arrays import StageArrays
from bladewhirl.models.stage.wall_coating import WallCoating, rod_angles
from bladewhirl.solvers.march.march import Chunk, CoatingRecords, coating_steps, joined
from bladewhirl.solvers.march.schema import (
    COATING,
    HISTORY,
    NAMES,
    RESULT_FORMAT,
    STAGE,
    TIME,
    Variable,
    index_values,
    parts_of,
)
from bladewhirl.solvers.march.storage import GuardedFile

Attribute = str | int | float

Values = np.ndarray[Any, np.dtype[Any]]

INTERRUPTED, UNFINISHED = "interrupted", "unfinished"
"""Values of `end_reason` of a march that the user interrupted, and of a march that was killed."""

STORAGE_BYTES = 2**16
"""Size of the chunks in which HDF5 stores a history [bytes]: large enough for few reads, and small
enough to waste little space in a short run."""

STRUCTURE_BYTES = 100_000
"""Approximate size of names, attributes and chunk indices in a result."""


CASING = ("casing_displacement", "casing_velocity")
"""Histories of the motion of the casing."""


class NonFiniteError(ArithmeticError):
    """Error for a record that is not finite; all earlier records have been written."""


class Recorder(AbstractContextManager["Recorder"]):
    """Writer of the records of a march to a result file; use the writer as a context manager.

    Args:
        path: path of the file; an existing file is replaced.
        stage: arrays that describe the stage.
        attributes: attributes of the file. The recorder adds `end_reason`, `end_message` and
            `steps`.

    Raises:
        OSError: the file cannot be created.
    """

    def __init__(
        self, path: str | PathLike[str], stage: StageArrays, attributes: Mapping[str, Attribute]
    ) -> None:
        self.records, self.steps = 0, 0  #: number of records written, and step of the last record
        self._raw = GuardedFile(path)
        self._h5 = h5py.File(self._raw, "w")
        self._file = h5netcdf.File(self._h5, "w")
        sizes, stored = sizes_of(stage), stage.stored
        self._histories = histories_of(stage)
        variables = {name: STAGE[name] for name in stored} | self._histories
        used = dict.fromkeys(name for each in variables.values() for name in each.dimensions)
        self._file.dimensions = {name: None if name == TIME else sizes[name] for name in used}
        for name in (name for name in NAMES if name in used):
            self._create(name, NAMES[name], index_values(name, sizes[name]))
        for name, values in stored.items():
            self._create(name, STAGE[name], values)
        for name, variable in self._histories.items():
            self._create_history(name, variable, sizes)
        for name, value in attributes.items():
            self._file.attrs[name] = value
        self._file.attrs["format"] = RESULT_FORMAT
        self._file.attrs["coordinates"] = " ".join(
            name for name in stored if STAGE[name].is_coordinate
        )
        self._file.attrs["end_reason"] = UNFINISHED
        self._file.attrs["end_message"] = ""
        self._h5.attrs["steps"] = np.int64(0)
        self.flush()

    def write(self, chunk: Chunk) -> None:
        """Append records and write them to the disk.

        Raises:
            NonFiniteError: a record is not finite; this record and all later ones are left out.
            OSError: writing fails; earlier records remain in the file.
        """
        if chunk.records == 0:  # a chunk may be shorter than the time between records
            return
        history = {name: np.asarray(getattr(chunk, name)) for name in self._histories}
        finite = finite_records(history)
        first, last = self.records, self.records + finite
        if chunk.coating is not None:
            self._write_coating(chunk.coating, first, last)
        if finite:
            for name, values in history.items():
                # Each variable is resized by its name: h5netcdf resizes the variables in a list of
                # the dimension, and this list was incomplete in one of several hundred marches.
                self._h5[name].resize(last, axis=0)
                self._h5[name][first:last] = values[:finite]
            self.flush()
            self.records, self.steps = last, int(chunk.step[finite - 1])
            self._h5.attrs.modify("steps", np.int64(self.steps))
        self.flush()
        if finite < chunk.records:
            raise NonFiniteError(f"record {last} is not finite")

    def _write_coating(self, coating: CoatingRecords, first: int, last: int) -> None:
        """Append the records of a coating from the first to the last number, and its profiles."""
        records = coating_records(coating)
        if "rod" not in self._file.dimensions:
            _, tracks, rods = records["coating_strain"].shape
            sizes = {"track": tracks, "rod": rods, "contact_node": coating.coating_impulse.shape[1]}
            for name in ("track", "rod"):
                self._file.dimensions[name] = sizes[name]
            self._file.dimensions["wear_time"] = None
            self._create("rod_angle", COATING["rod_angle"], rod_angles(rods))
            for name in records:
                self._create_history(name, COATING[name], sizes)
        profiles = len(self._h5["wear_time"])
        for name, values in records.items():
            begin, end = first, last
            if COATING[name].dimensions[0] != TIME:
                begin, end = profiles, profiles + len(values)
            self._h5[name].resize(end, axis=0)
            self._h5[name][begin:end] = values[: end - begin]

    def finish(self, reason: str, message: str, report: Mapping[str, Attribute]) -> None:
        """Store the reason of the end, a message and the quality measures of the march."""
        for name, value in {"end_reason": reason, "end_message": message, **report}.items():
            self._file.attrs[name] = value
        self.flush()

    def flush(self) -> None:
        """Write all buffered data to the disk.

        Raises:
            OSError: writing failed.
        """
        self._h5.flush()
        self._raw.check()

    def __exit__(self, *error: object) -> None:
        """Flush and close the file, also after an error."""
        self._file.close()
        self._h5.close()
        self._raw.close()

    def _create(self, name: str, variable: Variable, values: np.ndarray[Any, Any]) -> None:
        if values.dtype.kind == "U":
            values = values.astype(object)
        kind = h5py.string_dtype() if values.dtype == object else values.dtype
        created = self._file.create_variable(name, variable.dimensions, kind, data=values)
        created.attrs.update(variable.attributes)

    def _create_history(self, name: str, variable: Variable, sizes: Mapping[str, int]) -> None:
        widths = widths_of(variable, sizes)
        rows = _rows_stored(widths)
        created = self._file.create_variable(
            name, variable.dimensions, variable.kind, chunks=(rows, *widths)
        )
        created.attrs.update(variable.attributes)


class Records:
    """Store of the records of a march in memory, with the interface of `Recorder`.

    Args:
        stage: arrays that describe the stage.
        attributes: attributes of the result.
        most: largest number of records, for which memory is allocated.
        room: arrays of an earlier march whose records are no longer needed. Large enough arrays are
            reused, because new memory pages cost more time than writing.
        casing: whether the motion of the casing is stored.
    """

    def __init__(
        self,
        stage: StageArrays,
        attributes: Mapping[str, Attribute],
        most: int,
        room: dict[str, Values] | None = None,
        casing: bool = True,
    ) -> None:
        self.stage, self.records, self.steps = stage, 0, 0
        self.attributes = dict(attributes)
        sizes = sizes_of(stage)
        self._coating: list[CoatingRecords] = []
        self._room: dict[str, Values] = {} if room is None else room
        self._history = histories_of(stage)
        self._stored = [name for name in self._history if casing or name not in CASING]
        for name in self._stored:
            variable = self._history[name]
            widths, stored = widths_of(variable, sizes), self._room.get(name)
            if stored is None or len(stored) < most or stored.shape[1:] != widths:
                self._room[name] = np.empty((most, *widths), dtype=variable.kind)

    @property
    def histories(self) -> dict[str, Values]:
        """All records that are stored, by the names of the schema."""
        histories = {name: self._room[name][: self.records] for name in self._stored}
        if self._coating:
            coating = coating_records(joined(self._coating))
            for name, values in coating.items():
                histories[name] = values[
                    : self.records if COATING[name].dimensions[0] == TIME else None
                ]
            histories["rod_angle"] = rod_angles(coating["coating_strain"].shape[-1])
        return histories

    def write(self, chunk: Chunk) -> None:
        """Append records.

        Raises:
            NonFiniteError: a record is not finite; this record and all later ones are left out.
        """
        history = {name: np.asarray(getattr(chunk, name)) for name in self._history}
        finite = finite_records(history)
        last = self.records + finite
        for name in self._stored:
            self._room[name][self.records : last] = history[name][:finite]
        self.records = last
        if chunk.coating is not None:
            self._coating.append(chunk.coating)
        if finite:
            self.steps = int(chunk.step[finite - 1])
        if finite < chunk.records:
            raise NonFiniteError(f"record {last} is not finite")

    def finish(self, reason: str, message: str, report: Mapping[str, Attribute]) -> None:
        """Store the reason of the end, a message and the quality measures of the march."""
        self.attributes |= {"end_reason": reason, "end_message": message, **report}


def result_bytes(
    stage: StageArrays,
    timing: Timing,
    coating: WallCoating | None,
    blades: int | None = None,
) -> int:
    """Return the size of a result [bytes]; its histories are stored in whole chunks of HDF5.

    Args:
        stage: arrays that describe the stage.
        timing: duration, time step and record step of the march.
        coating: coating of the wall; None without a coating.
        blades: number of blades in the histories; all blades of the stage if None.
    """
    sizes, lengths = sizes_of(stage), {TIME: timing.records}
    if blades is not None:
        sizes |= {"contact_node": blades * (sizes["contact_node"] // (1 + int(stage.blade.max())))}
    variables = [*histories_of(stage).values()]
    if coating is not None:
        variables += COATING.values()
        tracks, rods = coating.strain.shape
        sizes |= {"rod": rods, "track": tracks}
        lengths |= {"rod": rods, "wear_time": 1 + timing.steps // coating_steps(timing)}
    total = 0
    for variable in variables:
        widths = widths_of(variable, sizes)
        rows = _rows_stored(widths)
        total += -(-lengths[variable.dimensions[0]] // rows) * rows * int(np.prod(widths))
    return STRUCTURE_BYTES + sum(array.nbytes for array in stage.stored.values()) + 8 * total


def widths_of(variable: Variable, sizes: Mapping[str, int]) -> tuple[int, ...]:
    """Return the shape of one record of a history."""
    return tuple(sizes[dimension] for dimension in variable.dimensions[1:])


def _rows_stored(widths: tuple[int, ...]) -> int:
    """Return the number of records of a history in one chunk of HDF5."""
    return max(1, STORAGE_BYTES // (8 * int(np.prod(widths))))


def sizes_of(stage: StageArrays) -> dict[str, int]:
    """Return the length of each dimension from the shapes of the arrays."""
    sizes = {name: len(each.labels) for name, each in NAMES.items() if each.labels}
    for name, values in stage.stored.items():
        for dimension, size in zip(STAGE[name].dimensions, values.shape, strict=True):
            if sizes.setdefault(dimension, size) != size:
                raise ValueError(f"{name}: expected {sizes[dimension]} along {dimension}")
    return sizes


def histories_of(stage: StageArrays) -> dict[str, Variable]:
    """Return the histories that a march of a stage records."""
    parts, known = parts_of(stage.stored), {TIME, *sizes_of(stage)}
    return {
        name: variable
        for name, variable in HISTORY.items()
        if variable.part in parts and known.issuperset(variable.dimensions)
    }


def coating_records(coating: CoatingRecords) -> dict[str, Values]:
    """Return the records of a coating that a march has, by the names of the schema."""
    records = {name: np.asarray(values) for name, values in vars(coating).items()}
    return {name: records[name] for name in COATING if name in records and records[name].size}


def finite_records(history: Mapping[str, FloatArray]) -> int:
    """Return the number of records before the first record with a number that is not finite."""
    with np.errstate(over="ignore", invalid="ignore"):
        doubtful = [values for values in history.values() if not np.isfinite(values.sum())]
    bad = [
        np.flatnonzero(~np.isfinite(values.reshape(len(values), -1)).all(axis=1))
        for values in doubtful
    ]
    return min([len(history[TIME]), *(int(rows[0]) for rows in bad if rows.size)])
