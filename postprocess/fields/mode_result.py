"""Natural modes in time, laid out like the result of a run, so that what draws a run draws them.

A single mode stands. A degenerate pair stands, or travels either way: with the convention of
`bladewhirl.models.elements.cyclic` the cosine times cos(omega t) plus the sine times sin(omega t)
travels forward, minus it backward.
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib import metadata
from typing import Any, Literal

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.case.file import dumps_case
from bladewhirl.models.modal.full_stage import ModalStage
from bladewhirl.models.modal.labels import Body
from bladewhirl.models.modal.stage_arrays import StageArrays
from bladewhirl.postprocess.fields.fields import casing_rows, line_rows
from bladewhirl.solvers.march.schema import HISTORY, STATIC, Variable

Wave = Literal["standing", "forward", "backward"]

PICTURES = 48
"""Records of one period, which then repeats."""

SHARE_OF_RADIUS = 1e-3
"""Size of a motion, as a share of the tip radius, where there is no clearance to compare with."""

BEAM_STATIONS = 8
"""Parts of a beam on which its largest displacement is looked for."""


def stage_dataset(arrays: StageArrays) -> xr.Dataset:
    """Geometry and modes of a stage under the names and dimensions they have in a result."""
    return xr.Dataset(
        {
            name: _entry(variable, np.asarray(getattr(arrays, name)))
            for name, variable in STATIC.items()
        }
    )


def with_history(stage: xr.Dataset, history: Mapping[str, FloatArray]) -> xr.Dataset:
    """Add what a march records to a stage, from a history in which nothing touches.

    Args:
        stage: from `stage_dataset`.
        history: variables of a result over time, equally spaced; those left out are zero, as loads
            and contact are where there are none.
    """
    time = history["time"]
    sizes = {**stage.sizes, "time": len(time)}
    found: dict[str, NDArray[Any]] = {}
    for name, variable in HISTORY.items():
        shape = tuple(sizes[dimension] for dimension in variable.dimensions)
        counted = name in ("contacts", "contact_steps")
        none = np.zeros(shape, dtype=np.int64 if counted else np.float64)
        found[name] = history.get(name, none)
    recorded = xr.Dataset({name: _entry(HISTORY[name], found[name]) for name in HISTORY})
    step = float(time[1] - time[0])
    return stage.merge(recorded).assign_attrs(time_step=step, record_step=step)


def mode_motion(
    stage: ModalStage, body: Body, numbers: IntArray, *, wave: Wave, title: str
) -> xr.Dataset:
    """One period of a mode of the bladed disk or of the casing, seen from its own frame.

    The largest displacement is the clearance, so that nothing touches, or a thousandth of the tip
    radius where there is none. The other body is at rest; speed, loads and friction are zero.

    Args:
        stage: finite element models with their modes.
        body: that moves.
        numbers: of the mode among those of the body, or of the cosine and the sine of a pair.
        wave: standing (the cosine of a pair), or travelling, which takes a pair.
        title: of the result.

    Raises:
        ValueError: a travelling wave of a single mode.
    """
    on_disk, resting = body == "bladed-disk", np.zeros(1, dtype=np.int64)
    arrays = stage.arrays(numbers if on_disk else resting, resting if on_disk else numbers)
    fixed = stage_dataset(arrays).assign_attrs(_attributes(stage, title))
    frequency = float((arrays.rotor_frequency if on_disk else arrays.casing_frequency)[0])
    time = 2.0 * np.pi / frequency * np.arange(PICTURES) / PICTURES
    shift, rate = _coordinates(frequency * time, len(numbers), wave)
    scale = shown_clearance(stage) / _largest(fixed, body, shift)
    displacement, velocity = scale * shift, scale * frequency * rate
    rest = np.zeros((PICTURES, 1))
    rotor, casing = (displacement, rest) if on_disk else (rest, displacement)
    history = {
        "time": time,
        "rotor_displacement": rotor,
        "rotor_velocity": velocity if on_disk else rest,
        "casing_displacement": casing,
        "casing_velocity": rest if on_disk else velocity,
        "gap": stage.disk.model.tip_recess + _gaps(fixed, rotor, casing),
        "energy": 0.5 * np.sum(velocity**2 + (frequency * displacement) ** 2, axis=1),
    }
    return with_history(fixed, history)


def _entry(variable: Variable, values: NDArray[Any]) -> tuple[object, ...]:
    """A variable as xarray takes it."""
    return variable.dimensions, values, {"units": variable.units, "long_name": variable.long_name}


def _coordinates(phase: FloatArray, modes: int, wave: Wave) -> tuple[FloatArray, FloatArray]:
    """Modal coordinates of unit size over a phase, and their rates by phase, (pictures, modes)."""
    cos, sin = np.cos(phase), np.sin(phase)
    if wave == "standing":
        still = np.zeros((len(phase), modes - 1))
        return np.column_stack([cos, still]), np.column_stack([-sin, still])
    if modes != 2:
        raise ValueError(f"a single mode stands; it has no {wave} wave")
    sense = 1.0 if wave == "forward" else -1.0
    return np.column_stack([cos, sense * sin]), np.column_stack([-sin, sense * cos])


def shown_clearance(stage: ModalStage) -> float:
    """Clearance [m], or a thousandth of the tip radius where there is none."""
    given = stage.case
    return given.casing.clearance or SHARE_OF_RADIUS * given.tip_radius


def _largest(geometry: xr.Dataset, body: Body, coordinates: FloatArray) -> float:
    """Largest displacement of a body anywhere at any time, for coordinates (pictures, modes)."""
    if body == "bladed-disk":
        rows = line_rows(geometry, BEAM_STATIONS)[1]
    else:
        rows = casing_rows(geometry, geometry["casing_angle"].values)
    return float(np.linalg.norm(rows @ coordinates.T, axis=-2).max())


def _gaps(geometry: xr.Dataset, rotor: FloatArray, casing: FloatArray) -> FloatArray:
    """Gap at each tip of full length, (pictures, blades)."""
    angle = geometry["tip_angle"].values
    outward = np.column_stack([np.cos(angle), np.sin(angle)])
    shapes = geometry["rotor_shape"].values[geometry["tip_node"].values, :2]
    tips = np.einsum("ba,bam->bm", outward, shapes)
    wall = casing_rows(geometry, angle)[:, 0]
    clearance = np.interp(
        angle, geometry["casing_angle"], geometry["clearance"], period=2.0 * np.pi
    )
    return np.asarray(clearance + casing @ wall.T - rotor @ tips.T)


def _attributes(stage: ModalStage, title: str) -> dict[str, str | int | float]:
    given = stage.case
    return {
        "title": title,
        "version": metadata.version("bladewhirl"),
        "speed": 0.0,
        "reference_frequency": stage.reference_frequency,
        "casing_radius": stage.casing.mesh.radius,
        "tip_radius": given.tip_radius,
        "friction": 0.0,
        "clamped": int(given.shaft.clamped),
        "end_reason": "completed",
        "end_message": "one period of a natural mode",
        "case": dumps_case(given),
        "steps": PICTURES,
    }
