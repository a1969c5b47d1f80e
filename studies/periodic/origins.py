"""Motions from which a search begins: the last period of a run, or the last point of a branch."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from bladewhirl.models.inputs.errors import UserError
from bladewhirl.postprocess.fields.result import open_result
from bladewhirl.postprocess.periodic.dataset import BRANCH_NAME, open_branch
from bladewhirl.solvers.periodic.blade import Blade, Grid
from bladewhirl.solvers.periodic.contact import Motion

FEWEST_RECORDS = 64  #: records of a run in a period of the motion
INSTANTS = 256  #: instants of the motion of a run


def motion_of(folder: Path, blade: Blade) -> Motion:
    """Return the forces in a folder as a guess of a motion of a blade.

    Args:
        folder: folder of a run, whose last period is taken, or of a branch.
        blade: the structure and its number of periods.

    Raises:
        UserError: the folder has neither, or other contact nodes, or too few records.
    """
    return _of_branch(folder, blade) if (folder / BRANCH_NAME).exists() else _of_run(folder, blade)


def _of_branch(folder: Path, blade: Blade) -> Motion:
    last = open_branch(folder).isel(point=-1)
    nodes, periods = last["normal_force"].shape[1], int(last.attrs.get("periods", 1))
    if nodes != blade.nodes or periods != blade.periods:
        raise UserError(
            f"{folder}: has {nodes} contact nodes and motions of {periods} periods; expected"
            f" {blade.nodes} nodes and {blade.periods} as here"
        )
    own = Grid(blade, last.sizes["instant"])
    return Motion(own, last["normal_force"].values, last["slip_direction"].values)


def _of_run(folder: Path, blade: Blade) -> Motion:
    with open_result(folder) as result:
        time = result["time"].values
        impulse = result["contact_impulse"].values.reshape(len(time), -1)[:, : blade.nodes]
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
