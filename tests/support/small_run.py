"""A case of a few blades, cheap to march, runs that break off, and commands in a process."""

from pathlib import Path

import h5py
import numpy as np
import pytest

import bladewhirl as bw
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import loads, with_values
from bladewhirl.solvers.march.schema import HISTORY, RESULT_NAME
from bladewhirl.studies.runs.recorded_march import Activity

SMALL = """
title = "A few blades"
[bladed_disk]
blades = 6
elements_per_blade = 2
[casing]
elements = 12
support = 7.975e6
[reduction]
fixed_interface_modes = 10
[excitation]
type = "casing-distortion"
modal_force = 30000
duration = "5 ms"
[march]
time_step = 2e-6
record_step = 1e-4
duration = 0.01
"""

COMMAND = "from bladewhirl.studies.commands.cli import main; main()"
"""Program of a process that takes the arguments of `bladewhirl`."""

NOT_HERE = (
    "nodes",
    "speed",
    "drive",
    "changes",
    "line",
    "joints",
    "dampers",
)  # parts of other stages
RECORDED = [name for name, variable in HISTORY.items() if variable.part not in NOT_HERE]
"""Histories of a stage of beams at a constant speed."""


def small(**values: object) -> Case:
    """The case with other values, by dotted key."""
    return with_values(loads(SMALL), values)


class Disturbed(Exception):
    """The march ends as by a kill, as far as its folder goes."""


def broken_off(case: Case, directory: Path, steps: int, *, overwrite: bool = False) -> None:
    """Run a case and break off after a number of steps."""

    def disturb(activity: Activity, done: int, total: int) -> None:
        if done >= steps:
            raise Disturbed

    with pytest.raises(Disturbed):
        bw.run(case, directory, frames=0, overwrite=overwrite, progress=disturb)


def assert_same_bits(one: Path, other: Path) -> None:
    """Assert that the results of two runs are equal to the last bit."""
    with h5py.File(one / RESULT_NAME) as left, h5py.File(other / RESULT_NAME) as right:
        assert set(left) == set(right)
        for name in left:
            np.testing.assert_array_equal(left[name][()], right[name][()])
