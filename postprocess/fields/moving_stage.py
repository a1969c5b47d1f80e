"""A stage and how it moves by its modes: what a picture is drawn from, and nothing else.

Variables have the names, dimensions and units that they have in a result. There is no contact, no
load and no march in it, since a natural mode and a stage at rest have none.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.modal.stage_arrays import StageArrays
from bladewhirl.solvers.march.schema import HISTORY, STATIC, Variable


def stage_dataset(arrays: StageArrays) -> xr.Dataset:
    """Geometry and modes of a stage."""
    return xr.Dataset(
        {
            name: _entry(variable, np.asarray(getattr(arrays, name)))
            for name, variable in STATIC.items()
        }
    )


def moving_stage(arrays: StageArrays, motion: Mapping[str, FloatArray]) -> xr.Dataset:
    """Geometry and modes of a stage with its motion over time.

    Args:
        arrays: the stage.
        motion: by name `time`, `rotor_displacement` and `casing_displacement`, and what else of a
            result is known, such as velocities and the gap.
    """
    return stage_dataset(arrays).assign(
        {name: _entry(HISTORY[name], values) for name, values in motion.items()}
    )


def _entry(variable: Variable, values: NDArray[Any]) -> tuple[object, ...]:
    """A variable as xarray takes it."""
    return variable.dimensions, values, variable.attributes
