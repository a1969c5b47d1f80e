"""The dataset of a sweep on disk: allocated before the sweep, filled in place.

Every array is allocated at the start and written in place, so the structure of the file does not
change during the sweep: after a kill the file can still be opened. The variable `state` of a point
is written after the data of the point have been flushed. Files of sweeps with the same points are
equal, independent of the order in which the points were computed.
"""

import json
import re
from collections.abc import Mapping
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import h5netcdf
import h5py
import numpy as np
from numpy.typing import NDArray

from bladewhirl.files import json_text, replacing, write_atomically
from bladewhirl.meshes.hdf5 import open_hdf5
from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.postprocess.energy.regimes import CRITERION_TEXT
from bladewhirl.postprocess.sweep import dataset
from bladewhirl.solvers.march.schema import POINT, SCREENING, SWEEP, SWEEP_FORMAT
from bladewhirl.studies.runs.folder import FAILURES_NAME, read_failures
from bladewhirl.studies.sweeps.axes import Grid
from bladewhirl.studies.sweeps.points import Failure, Outcome

Coordinates = Mapping[str, tuple[FloatArray, str]]
"""Values of each swept key, with their unit; of perturbed keys the unperturbed values, by the name
of the variable with the drawn values."""


def create(
    directory: Path,
    grid: Grid,
    coordinates: Coordinates,
    layout: dataset.Layout,
    attributes: Any,
    *,
    screen: bool = False,
) -> None:
    """Create the dataset of a sweep in its folder, completely or not at all. Besides the attributes
    of every sweep the dataset has `attributes`; if points are screened, it also has the variables
    in `SCREENING`."""
    with (
        replacing(directory / dataset.SWEEP_NAME) as draft,
        h5py.File(draft, "w") as h5,
        h5netcdf.File(h5, "w") as file,
    ):
        names = tuple(axis.name for axis in grid.axes)
        sizes = dict(zip(names, grid.shape, strict=True))
        file.dimensions = {**sizes, **layout.sizes}
        as_given, along = [], list[tuple[str, str, FloatArray, str, str]]()
        for axis in grid.axes:
            along.append((axis.name, axis.name, *coordinates[axis.key], axis.key))
            if axis.unit:
                as_given.append(re.sub(r"\W+", "_", f"{axis.name} {axis.unit}"))
                label = f"{axis.key}, as given"
                along.append((as_given[-1], axis.name, axis.numbers, axis.unit, label))
        for axis in grid.table:
            along.append((axis.name, POINT, *coordinates[axis.key], axis.key))
            as_given.append(axis.name)
        label = "frequency in the rotating frame, forward positive"
        along.append(("frequency", "frequency", layout.frequency, "Hz", label))
        for name, dimension, values, unit, label in along:
            made = file.create_variable(name, (dimension,), np.float64, data=values)
            made.attrs.update({"units": unit, "long_name": label})
        for name, labels in layout.names.items():
            text = np.array(labels, dtype=object)
            file.create_variable(name, (name,), h5py.string_dtype(), data=text)
        for name, variable in {**layout.variables, **(SCREENING if screen else {})}.items():
            lengths = {dimension: layout.sizes[dimension] for dimension in variable.dimensions}
            made = _reserve(h5, file, name, np.dtype(variable.kind), {**sizes, **lengths})
            made.attrs.update(variable.attributes)
            labels = variable.labels
            if name == "state" and not screen and (grid.draws is None or grid.draws.until is None):
                labels = labels[: dataset.NOT_NEEDED]  # only --until and --screen leave draws out
            if labels:
                made.attrs["flag_values"] = np.arange(len(labels), dtype="i1")
                made.attrs["flag_meanings"] = " ".join(labels)
        for key, name in grid.drawn.items():
            made = _reserve(h5, file, name, np.dtype("f8"), sizes)
            made.attrs.update({"units": coordinates[name][1], "long_name": f"drawn value of {key}"})
        file.attrs["coordinates"] = " ".join(as_given)
        file.attrs["over"] = json.dumps(grid.over)
        if grid.table:
            file.attrs["table"] = json.dumps(grid.listed)
        file.attrs["format"] = SWEEP_FORMAT
        file.attrs["criterion"] = CRITERION_TEXT
        file.attrs["window"] = (
            f"spectra and mean energies are over the last {layout.window:.6g} s of each march,"
            f" at most {dataset.WINDOW_SHARE:.0%} of it"
        )
        file.attrs.update(attributes)


class Store(AbstractContextManager["Store"]):
    """The dataset of a sweep, open for writing by this process only.

    Args:
        directory: folder of the sweep.
        grid: points of the sweep.
        plan: digest of the plan with which the dataset was created; None if it had no plan.

    Raises:
        UserError: another process has opened the dataset, it cannot be written, it is from another
            plan, or its data were changed.
    """

    def __init__(self, directory: Path, grid: Grid, plan: str | None = None) -> None:
        self._directory, self._grid = directory, grid
        path, failed = directory / dataset.SWEEP_NAME, read_failures(directory, grid.size)
        #: reason of each failed point
        self.failures = {int(entry["point"]): entry["reason"] for entry in failed}
        try:
            self._h5 = open_hdf5(path, "r+")
        except BlockingIOError:
            raise UserError(f"{path}: is in use; is the sweep still running?") from None
        except OSError as error:
            raise UserError(f"{path}: expected the dataset of a sweep ({error})") from None
        try:
            digest = self._h5.attrs.get("plan")
        except (OSError, RuntimeError, KeyError):
            digest = None
        if digest != plan:
            self._h5.close()
            raise UserError(
                f"{path}: expected the dataset of the plan in this folder, not of another plan"
            )
        self._table = {name: each for name, each in SWEEP.items() if name in self._h5}
        names = (*(axis.name for axis in (*grid.axes, *grid.table)), "frequency")
        self._coordinates = [self._h5[name][()] for name in names]
        changed = dataset.changed_point(
            self._table,
            lambda name, rows: np.asarray(self._h5[name][rows]),
            grid.shape,
            self._coordinates,
        )
        if changed is not None:
            self._h5.close()
            raise UserError(
                f"{path}: expected point {changed} as it was written; it was changed or damaged"
            )
        # The variables are kept, because a lookup by name takes a third of the time of writing a
        # point.
        self._variables = {name: self._h5[name] for name in self._table}
        self._drawn = {key: self._h5[name] for key, name in grid.drawn.items()}
        #: state of every point as written, (points,)
        self.state = np.asarray(self._h5["state"][()], dtype=np.int8).ravel()
        self._screened = self._h5.get(dataset.SCREENED)

    def __exit__(self, *error: object) -> None:
        """Close the file, also after an error."""
        self._h5.close()

    @property
    def frequency(self) -> FloatArray:
        """Frequencies of the spectra [Hz]."""
        return np.asarray(self._h5["frequency"][()], dtype=np.float64)

    @property
    def regime(self) -> NDArray[np.int8]:
        """Code of the regime of every point as written, (points,)."""
        return np.asarray(self._h5["regime"][()], dtype=np.int8).ravel()

    @property
    def end_reason(self) -> NDArray[np.int8]:
        """Code of the reason of the end of every march as written, (points,)."""
        return np.asarray(self._h5["end_reason"][()], dtype=np.int8).ravel()

    @property
    def screened(self) -> NDArray[np.bool_]:
        """True for every point whose march as written is a screening march, (points,)."""
        if self._screened is None:
            return np.zeros(self.state.size, dtype=np.bool_)
        return np.asarray(self._screened[()], dtype=np.bool_).ravel()

    @property
    def done(self) -> int:
        """Number of finished points."""
        return int(np.count_nonzero(self.state == dataset.DONE))

    @property
    def not_needed(self) -> int:
        """Number of random draws that were skipped because the outcome of their point was known."""
        return int(np.count_nonzero(self.state == dataset.NOT_NEEDED))

    def read(self, point: int) -> dict[str, FloatArray]:
        """Read the data of a finished point."""
        index = np.unravel_index(point, self._grid.shape)
        names = (name for name in self._table if name not in ("state", "checksum"))
        return {name: np.asarray(self._variables[name][index]) for name in names}

    def write(self, point: int, outcome: Outcome, *, screened: bool = False) -> None:
        """Write a point: first its data, then its state. If the point has data, they are marked as
        missing before they are replaced.

        Args:
            point: number of the point.
            outcome: its data, or the reason of its failure.
            screened: whether the march is a screening march.
        """
        index = np.unravel_index(point, self._grid.shape)
        if self.state[point] == dataset.DONE:
            self._write_state(point, dataset.MISSING)
        if self._screened is not None:
            self._screened[index] = screened
        drawn = self._grid.values(point) if self._drawn else {}
        for key, variable in self._drawn.items():
            variable[index] = drawn[key]
        if isinstance(outcome, Failure):
            self.failures[point] = outcome.reason
        else:
            self.failures.pop(point, None)
            for name, values in outcome.items():
                self._variables[name][index] = values
            checksum = dataset.checksum(self._table, outcome, self._coordinates)
            self._variables["checksum"][index] = checksum
        self._h5.flush()
        self._write_state(point, dataset.FAILED if isinstance(outcome, Failure) else dataset.DONE)

    def leave_out(self, point: int) -> None:
        """Mark a random draw as not needed. If the draw has data, they are erased."""
        if self.state[point] == dataset.NOT_NEEDED:
            return
        self.failures.pop(point, None)
        if self._screened is not None and self.state[point] != dataset.MISSING:
            index = np.unravel_index(point, self._grid.shape)
            self._write_state(point, dataset.MISSING)
            for variable in (*self._variables.values(), *self._drawn.values()):
                variable[index] = _empty(variable.dtype)
            self._screened[index] = False
        self._write_state(point, dataset.NOT_NEEDED)

    def _write_state(self, point: int, state: int) -> None:
        self._write_failures()
        self.state[point] = state
        self._variables["state"][np.unravel_index(point, self._grid.shape)] = state
        self._h5.flush()

    def _write_failures(self) -> None:
        path = self._directory / FAILURES_NAME
        if not self.failures:
            path.unlink(missing_ok=True)
            return
        rows = self._grid.failed(self.failures)
        write_atomically(path, json_text(rows))


def _reserve(
    h5: h5py.File, file: h5netcdf.File, name: str, kind: np.dtype[Any], sizes: Mapping[str, int]
) -> Any:
    """Create and allocate a variable: floats are NaN; integers are zeros, not marked as missing."""
    empty = _empty(kind)
    fill = empty if kind.kind == "f" else None
    made = file.create_variable(name, tuple(sizes), kind, fillvalue=fill)
    # HDF5 allocates a contiguous array when its first value is written.
    h5[name][(0,) * len(sizes)] = empty
    return made


def _empty(kind: np.dtype[Any]) -> Any:
    """Return the value of the elements of a variable before they are written."""
    return kind.type(np.nan if kind.kind == "f" else 0)
