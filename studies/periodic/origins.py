"""Motions from which a search begins: the last period of a run, or the last point of a branch."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import xarray as xr

from bladewhirl.models.inputs.errors import UserError
from bladewhirl.postprocess.fields.result import open_result
from bladewhirl.postprocess.periodic.dataset import BRANCH_NAME, open_branch
from bladewhirl.solvers.periodic.blade import Blade, Grid
from bladewhirl.solvers.periodic.contact import Motion

FEWEST_RECORDS = 64  #: records of a run in a period of the motion
INSTANTS = 256  #: instants of the motion of a run


def motion_of(folder: Path, blade: Blade, number: int) -> Motion:
    """Return the forces in a folder as a guess of a motion of a blade.

    Args:
        folder: folder of a run, whose last period is taken, or of a branch.
        blade: the structure and its number of periods.
        number: number of the blade, whose forces in a run are taken.

    Raises:
        UserError: the folder has neither, or other contact nodes, or too few records.
    """
    if not (folder / BRANCH_NAME).exists():
        return _of_run(folder, blade, number)
    last = open_branch(folder).isel(point=-1)
    check_nodes(last, blade, str(folder))
    own = Grid(blade, last.sizes["instant"])
    return Motion(own, last["normal_force"].values, last["slip_direction"].values)


def check_nodes(branch: xr.Dataset, blade: Blade, place: str) -> None:
    """Check that the motions of a branch at a place are those of a blade.

    Raises:
        UserError: it has other contact nodes, or motions of another number of periods.
    """
    nodes, periods = branch.sizes["node"], int(branch.attrs.get("periods", 1))
    if nodes != blade.nodes or periods != blade.periods:
        raise UserError(
            f"{place}: has {nodes} contact nodes and motions of {periods} periods; expected"
            f" {blade.nodes} nodes and {blade.periods} as here"
        )


def _of_run(folder: Path, blade: Blade, number: int) -> Motion:
    with open_result(folder) as result:
        time = result["time"].values
        own = result["blade"].values == number
        if np.count_nonzero(own) != blade.nodes:
            raise UserError(
                f"{folder}: has {np.count_nonzero(own)} contact nodes on blade {number}; expected"
                f" {blade.nodes} as here"
            )
        impulse = result["contact_impulse"].values[:, own]
    if len(time) < FEWEST_RECORDS:
        raise UserError(f"{folder}: has {len(time)} records; expected at least {FEWEST_RECORDS}")
    step, grid = float(np.diff(time).mean()), Grid(blade, INSTANTS)
    if step > blade.period / FEWEST_RECORDS or time[-1] < 2.0 * blade.period:
        raise UserError(
            f"{folder}: records every {step:.3g} s; expected at least {FEWEST_RECORDS} in each of"
            f" two periods of {blade.period:.6g} s (march.record_step)"
        )
    late = time > time[-1] - blade.period
    force, phase = impulse[late] / step, np.mod(time[late] - 0.5 * step, blade.period)
    normal = [np.interp(grid.time, phase, each, period=blade.period) for each in force.T]
    start = Motion.free(grid)
    return replace(start, normal=np.maximum(0.0, np.stack(normal, axis=1)))
