"""Records of a march on disk: `result.nc`, netCDF-4 that grows as the march goes on.

Every variable has named dimensions, units and a long name. What has been flushed survives a kill:
h5py flushes, h5netcdf does not, so the file is opened with the one and handed to the other.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from os import PathLike
from types import TracebackType
from typing import Any, NamedTuple, Self

import h5netcdf
import h5py
import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.modal.stage_arrays import StageArrays
from bladewhirl.solvers.march.march import Chunk

Attribute = str | int | float

RESULT_NAME = "result.nc"
"""The result's file in the folder of a run."""

INTERRUPTED, UNFINISHED = "interrupted", "unfinished"
"""`end_reason` of a march that the user ended early, and of one that was killed."""

STORAGE_BYTES = 2**16
"""Size of the pieces that HDF5 stores a history in: a few reads for a portion of records, and
little lost where a run is short."""

STRUCTURE_BYTES = 100_000
"""About what names, attributes and the places of pieces take in a result."""


class Variable(NamedTuple):
    """How a variable of a result is written."""

    dimensions: tuple[str, ...]
    units: str
    long_name: str


TIME = "time"
_PER_TIP = (TIME, "blade")
_ROTOR, _CASING = (TIME, "rotor_mode"), (TIME, "casing_mode")

HISTORY: Mapping[str, Variable] = {
    "time": Variable((TIME,), "s", "time"),
    "rotor_displacement": Variable(
        _ROTOR, "kg^0.5 m", "modal coordinates of the bladed disk, rotating axes, mass-normalised"
    ),
    "rotor_velocity": Variable(_ROTOR, "kg^0.5 m/s", "rates of rotor_displacement"),
    "casing_displacement": Variable(
        _CASING, "kg^0.5 m", "modal coordinates of the casing, static axes, mass-normalised"
    ),
    "casing_velocity": Variable(_CASING, "kg^0.5 m/s", "rates of casing_displacement"),
    "gap": Variable(_PER_TIP, "m", "smallest gap of each tip since the last record"),
    "contact_impulse": Variable(_PER_TIP, "N s", "normal impulse since the last record"),
    "friction_impulse": Variable(
        _PER_TIP,
        "N s",
        "friction impulse since the last record, positive when it drags the blade to -theta",
    ),
    "contact_steps": Variable(_PER_TIP, "1", "steps with contact since the last record"),
    "contacts": Variable((TIME,), "1", "tips in contact at the record"),
    "energy": Variable((TIME,), "J", "energy of both bodies and of all springs, at the half step"),
    "external_work": Variable((TIME,), "J", "work of the loads since the start"),
    "normal_work": Variable((TIME,), "J", "work of the normal contact forces since the start"),
    "friction_work": Variable((TIME,), "J", "work of the friction forces since the start"),
    "damping_work": Variable((TIME,), "J", "energy taken by damping since the start"),
    "coupling_work": Variable(
        (TIME,), "J", "work of turning the rotor against springs that stand still, since the start"
    ),
}
"""Recorded over time; the names are those of `Chunk`."""

_SHAPE_UNITS = "kg^-0.5 (rotation, slopes: kg^-0.5/m)"

STATIC: Mapping[str, Variable] = {
    "rotor_frequency": Variable(("rotor_mode",), "rad/s", "angular frequency of each rotor mode"),
    "rotor_nodal_diameter": Variable(("rotor_mode",), "1", "nodal diameter of each rotor mode"),
    "rotor_family": Variable(("rotor_mode",), "1", "family of each rotor mode"),
    "rotor_spring_share": Variable(
        ("rotor_mode",), "1", "share of a rotor mode's strain energy in the shaft springs"
    ),
    "casing_frequency": Variable(
        ("casing_mode",), "rad/s", "angular frequency of each casing mode"
    ),
    "casing_nodal_diameter": Variable(("casing_mode",), "1", "nodal diameter of each casing mode"),
    "casing_family": Variable(("casing_mode",), "1", "family of each casing mode"),
    "rotor_point": Variable(
        ("rotor_node", "axis"), "m", "undeformed rotor node, rotating axes at angle 0"
    ),
    "rotor_line": Variable(("rotor_line", "end"), "1", "rotor nodes at the ends of each line"),
    "rotor_thickness": Variable(
        ("rotor_line",), "m", "thickness of each line in the plane, at its middle"
    ),
    "rotor_width": Variable(
        ("rotor_line",), "m", "width of each line out of the plane, at its middle"
    ),
    "rotor_young_modulus": Variable(
        ("rotor_line",), "Pa", "Young's modulus of each line at its middle"
    ),
    "rotor_thickness_change": Variable(
        ("rotor_line",), "m", "change of the thickness from the first to the second end, linear"
    ),
    "rotor_width_change": Variable(
        ("rotor_line",), "m", "change of the width from the first to the second end, linear"
    ),
    "rotor_young_modulus_change": Variable(
        ("rotor_line",), "Pa", "change of Young's modulus from the first to the second end, linear"
    ),
    "rotor_part": Variable(("rotor_line",), "1", "part that each line belongs to"),
    "rotor_shape": Variable(
        ("rotor_node", "rotor_component", "rotor_mode"),
        _SHAPE_UNITS,
        "displacement of each rotor node for a unit modal coordinate, rotating axes",
    ),
    "rotor_link": Variable(
        ("rotor_link", "end"), "1", "rotor node that a rigid arm leads, and its leader"
    ),
    "rotor_spring": Variable(
        ("rotor_spring", "end"), "1", "rotor nodes that a spring joins, -1 for the rotating frame"
    ),
    "mass_node": Variable(("mass",), "1", "rotor node of each point mass"),
    "point_mass": Variable(("mass",), "kg", "each point mass"),
    "tip_node": Variable(("blade",), "1", "rotor node of each blade tip"),
    "tip_angle": Variable(("blade",), "rad", "angle of each tip from +x, rotating axes"),
    "centre_node": Variable((), "1", "rotor node of the shaft's centre"),
    "shaft_frame": Variable((), "1", "frame that the shaft's springs stand in, rotating or static"),
    "shaft_stiffness": Variable(
        ("axis",), "N/m", "shaft springs along the axes of their frame, 0 where the centre is held"
    ),
    "shaft_damping": Variable(
        ("axis",), "N s/m", "dampers beside them, along rotating axes, 0 where the centre is held"
    ),
    "casing_angle": Variable(("casing_node",), "rad", "angle of each casing node from +x"),
    "casing_thickness": Variable(
        ("casing_node",), "m", "thickness of the element from each casing node to the next"
    ),
    "casing_width": Variable(("casing_node",), "m", "width of the same element out of the plane"),
    "casing_young_modulus": Variable(("casing_node",), "Pa", "Young's modulus of the same element"),
    "casing_curvature": Variable(
        (), "1", "bending strain of the casing: exact, w'' - u'/R, or shallow, w''"
    ),
    "casing_shape": Variable(
        ("casing_node", "casing_component", "casing_mode"),
        _SHAPE_UNITS,
        "values of each casing node for a unit modal coordinate, cubic Hermite between nodes",
    ),
    "casing_foundation": Variable(
        (), "N/m2", "uniform elastic support of the casing, radial and tangential"
    ),
    "support_kind": Variable(("support",), "1", "spring or strut from the casing to the ground"),
    "support_angle": Variable(
        ("support",), "rad", "angle of each support's foot on the casing from +x"
    ),
    "support_reach": Variable(
        ("support", "axis"), "m", "from the foot of each strut to the ground, static axes"
    ),
    "support_radial_stiffness": Variable(
        ("support",), "N/m", "stiffness of each support at its foot, radial"
    ),
    "support_tangential_stiffness": Variable(
        ("support",), "N/m", "stiffness of each support at its foot, tangential"
    ),
    "support_radial_damping": Variable(
        ("support",), "N s/m", "damping of each support at its foot, radial"
    ),
    "support_tangential_damping": Variable(
        ("support",), "N s/m", "damping of each support at its foot, tangential"
    ),
    "clearance": Variable(("casing_node",), "m", "clearance at rest at each casing node"),
}
"""Known before the march; the names are those of `StageArrays`. What a stage has none of, such as
supports, is left out: netCDF takes a dimension of length zero for one that grows."""

LABELS: Mapping[str, tuple[str, ...]] = {
    "axis": ("x", "y"),
    "rotor_component": ("x", "y", "rotation"),
    "casing_component": ("w", "w_s", "u", "u_s"),
}
"""Names along the dimensions that have some: w radial, u tangential, _s by arc length."""


class NonFiniteError(ArithmeticError):
    """A record is not finite; those before it have been written."""


class Recorder:
    """Writes a result as its records arrive; use it as a context manager.

    Args:
        path: of the file, which is replaced where it exists.
        stage: arrays that describe the stage.
        attributes: of the file. `end_reason`, `end_message` and `steps` are kept by the recorder.

    Raises:
        OSError: the file cannot be made.
    """

    def __init__(
        self,
        path: str | PathLike[str],
        stage: StageArrays,
        attributes: Mapping[str, Attribute],
    ) -> None:
        self._records, self._steps = 0, 0
        self._h5 = h5py.File(path, "w")
        self._file = h5netcdf.File(self._h5, "w")
        sizes = _sizes(stage)
        self._file.dimensions = {TIME: None} | {name: size for name, size in sizes.items() if size}
        for name, labels in LABELS.items():
            self._create(name, Variable((name,), "1", f"names along {name}"), np.array(labels))
        for field in fields(stage):
            values = np.asarray(getattr(stage, field.name))
            if values.size:
                self._create(field.name, STATIC[field.name], values)
        for name, variable in HISTORY.items():
            self._create_history(name, variable, sizes)
        for name, value in attributes.items():
            self._file.attrs[name] = value
        self._file.attrs["end_reason"] = UNFINISHED
        self._file.attrs["end_message"] = ""
        self._h5.attrs["steps"] = np.int64(0)
        self.flush()

    def __enter__(self) -> Self:
        """The recorder itself."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Close the file, whatever happened."""
        self.close()

    @property
    def records(self) -> int:
        """Number of records written."""
        return self._records

    @property
    def steps(self) -> int:
        """Step of the last record."""
        return self._steps

    def write(self, chunk: Chunk) -> None:
        """Append records and flush them.

        Raises:
            NonFiniteError: a record is not finite; it and those after it are left out.
        """
        if chunk.records == 0:  # records may be further apart than chunks
            return
        history = {name: np.asarray(getattr(chunk, name)) for name in HISTORY}
        finite = _finite_records(history)
        first, last = self._records, self._records + finite
        if finite:
            for name, values in history.items():
                # Each by its name: h5netcdf resizes what the dimension lists as its users, and
                # one march in some hundreds was lost to a variable that was left as it was.
                self._h5[name].resize(last, axis=0)
                self._h5[name][first:last] = values[:finite]
            self._records, self._steps = last, int(chunk.step[finite - 1])
            self._h5.attrs.modify("steps", np.int64(self._steps))
        self.flush()
        if finite < chunk.records:
            raise NonFiniteError(f"record {last} is not finite")

    def finish(self, reason: str, message: str, report: Mapping[str, Attribute]) -> None:
        """Say how the march ended and what it knows of its quality."""
        for name, value in {"end_reason": reason, "end_message": message, **report}.items():
            self._file.attrs[name] = value
        self.flush()

    def flush(self) -> None:
        """Bring everything written so far to the disk."""
        self._h5.flush()

    def close(self) -> None:
        """Flush and close."""
        self._file.close()
        self._h5.close()

    def _create(self, name: str, variable: Variable, values: np.ndarray[Any, Any]) -> None:
        if values.dtype.kind == "U":
            values = values.astype(object)
        kind = h5py.string_dtype() if values.dtype == object else values.dtype
        created = self._file.create_variable(name, variable.dimensions, kind, data=values)
        _describe(created, variable)

    def _create_history(self, name: str, variable: Variable, sizes: Mapping[str, int]) -> None:
        widths = _widths(variable, sizes)
        rows = _rows_stored(widths)
        created = self._file.create_variable(
            name,
            variable.dimensions,
            np.int64 if name in ("contact_steps", "contacts") else np.float64,
            chunks=(rows, *widths),
        )
        _describe(created, variable)


def result_bytes(rotor_modes: int, casing_modes: int, blades: int, records: int) -> int:
    """Size of the histories of a result [bytes], each in whole pieces as they are stored."""
    sizes = {"rotor_mode": rotor_modes, "casing_mode": casing_modes, "blade": blades}
    total = 0
    for variable in HISTORY.values():
        widths = _widths(variable, sizes)
        rows = _rows_stored(widths)
        total += -(-records // rows) * rows * int(np.prod(widths))
    return 8 * total


def description_bytes(stage: StageArrays) -> int:
    """Size of what a result holds beside its histories [bytes], the same however long it is.

    Args:
        stage: arrays that describe the stage.
    """
    arrays = (np.asarray(getattr(stage, field.name)) for field in fields(stage))
    return STRUCTURE_BYTES + sum(array.nbytes for array in arrays)


def _widths(variable: Variable, sizes: Mapping[str, int]) -> tuple[int, ...]:
    """Shape of a history at one record."""
    return tuple(sizes[dimension] for dimension in variable.dimensions[1:])


def _rows_stored(widths: tuple[int, ...]) -> int:
    """Records in a piece of a history that are stored together."""
    return max(1, STORAGE_BYTES // (8 * int(np.prod(widths))))


def _describe(created: Any, variable: Variable) -> None:
    created.attrs["units"] = variable.units
    created.attrs["long_name"] = variable.long_name


def _sizes(stage: StageArrays) -> dict[str, int]:
    """Length of each dimension, found from the arrays that have it."""
    sizes = {name: len(labels) for name, labels in LABELS.items()}
    for name, variable in STATIC.items():
        for dimension, size in zip(
            variable.dimensions, np.shape(getattr(stage, name)), strict=True
        ):
            if sizes.setdefault(dimension, size) != size:
                raise ValueError(f"{name}: expected {sizes[dimension]} along {dimension}")
    return sizes


def _finite_records(history: Mapping[str, FloatArray]) -> int:
    """Number of leading records in which every number is finite."""
    bad = [
        np.flatnonzero(~np.isfinite(values.reshape(len(values), -1)).all(axis=1))
        for values in history.values()
    ]
    return min([len(history[TIME]), *(int(rows[0]) for rows in bad if rows.size)])
