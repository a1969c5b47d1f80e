"""The folder of a sweep whose points are closed-form motions of `synthetic_result`."""

from collections.abc import Mapping, Sequence
from math import prod
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from synthetic_result import synthetic_result

from bladewhirl.postprocess.sweep.dataset import Layout
from bladewhirl.postprocess.sweep.digest import digest
from bladewhirl.studies.sweeps.axes import Axis, Grid
from bladewhirl.studies.sweeps.points import Failure, Outcome
from bladewhirl.studies.sweeps.store import Store, create

LAYOUT = Layout(
    frequency=np.arange(-60, 61) / 0.2,  # of a window of 0.2 s
    samples=50,
    nodal_diameters=12,
    blades=22,
)

REPORT = {
    "complementarity_residual": 0.0,
    "dt_over_critical": 0.5,
    "steps": 400_000,
    "unsolved_steps": 0,
}


def synthetic_sweep(
    folder: Path,
    over: Mapping[str, Sequence[float]],
    motions: Sequence[Mapping[str, Any] | xr.Dataset | None],
    *,
    units: str | Mapping[str, str] = "1",
    case: str = "",
    title: str = "synthetic",
) -> Path:
    """Write a sweep.

    Args:
        folder: to make.
        over: swept keys with their values.
        motions: of every point, the last key running fastest: arguments of `synthetic_result`, or
            a result; a point that failed where None.
        units: of all keys, or of each.
        case: text of the case.
        title: of the case.
    """
    axes = tuple(Axis(key=key, values=tuple(values)) for key, values in over.items())
    grid = Grid(axes=axes)
    assert len(motions) == prod(grid.shape)
    folder.mkdir()
    each = dict.fromkeys(over, units) if isinstance(units, str) else units
    coordinates = {key: (np.array(values, dtype=float), each[key]) for key, values in over.items()}
    create(folder, grid, coordinates, LAYOUT, {"title": title, "case": case})
    outcomes: dict[int, Outcome] = {}
    for point, motion in enumerate(motions):
        if motion is None:
            outcomes[point] = Failure(reason="it could not be marched")
        else:
            result = motion if isinstance(motion, xr.Dataset) else synthetic_result(**motion)
            outcomes[point] = digest(result, REPORT, LAYOUT)
    with Store(folder, grid) as store:
        for point, outcome in outcomes.items():
            store.write(point, outcome)
    return folder
