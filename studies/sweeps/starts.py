"""Motions from which the marches of a sweep start: rest, or a periodic motion."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np

from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import with_values
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.modal_loads import NEVER, Start
from bladewhirl.models.stage.stage import Stage
from bladewhirl.postprocess.sweep.dataset import flag
from bladewhirl.studies.sweeps.axes import Grid, Value

START = "--start"

StartName = Literal["rest", "periodic"]  #: motion from which marches start

STARTS: tuple[StartName, ...] = get_args(StartName)

SPEED = "march.speed"

BRANCHES_NAME = "branches"  #: folder of the branches of a sweep, a folder for each

STATES = "bladewhirl.studies.periodic.initial_states"
"""Module that computes periodic motions; it uses sweeps, and is imported when it is needed."""

START_RULE = (
    "the march at each point starts on a periodic motion of the point, with its displacements,"
    " velocities and contact forces; ramps of loads, loads that end, and the closure of the casing"
    " are over. The branch of motions over the speed, or over the first key without a swept speed,"
    " is followed from the smallest value; of its motions at a point the one with the largest"
    " impulse is taken, a stable one if there is one. Where there is no branch, the motion is that"
    " of bladewhirl periodic; where none is found the march starts at rest, and `start` says so"
)
"""Text of the rule, which every such sweep contains."""


@dataclass(frozen=True)
class Line:
    """Points of a sweep that differ in one key, over which a branch is followed."""

    number: int  #: number of the line
    key: str
    values: tuple[Value, ...]  #: values of the key
    others: dict[str, Value]  #: values of the other keys

    @property
    def folder(self) -> Path:
        """Folder of the branch in that of the sweep."""
        return Path(BRANCHES_NAME) / str(self.number)


def line_of(grid: Grid, point: int) -> Line | None:
    """Return the line of a point; None for the points of a table."""
    if grid.table:
        return None
    keys = list(grid.over)
    along = keys.index(SPEED) if SPEED in keys else 0
    position = np.unravel_index(point, grid.shape)
    places = {axis.key: int(i) for axis, i in zip(grid.axes, position, strict=True)}
    others = {key: grid.over[key][places[key]] for key in keys if key != keys[along]}
    shape = [len(grid.over[key]) for key in others]
    number = int(np.ravel_multi_index([places[key] for key in others], shape)) if others else 0
    return Line(number, keys[along], grid.over[keys[along]], others)


def lines(grid: Grid) -> Iterator[Line]:
    """Yield the lines of a sweep, each once."""
    numbers = set[int]()
    for point in range(grid.size):
        line = line_of(grid, point)
        if line is not None and line.number not in numbers:
            numbers.add(line.number)
            yield line


def check_start(case: Case) -> None:
    """Check that marches of a case can start on a periodic motion.

    Raises:
        UserError: they cannot; the message has the reason.
    """
    import_module(STATES).check(case)


def follow_branches(case: Case, grid: Grid, directory: Path) -> None:
    """Follow the branches of a sweep into its folder, or continue them there."""
    for line in lines(grid):
        at_line = with_values(case, line.others)
        import_module(STATES).follow(at_line, line.key, line.values, directory / line.folder)


def start_of(
    stage: Stage, branch: Path | None, value: Value | None
) -> tuple[Start | None, dict[str, Any]]:
    """Return the periodic motion from which a march starts, None if none was found, and what the
    dataset of a sweep says about it."""
    found = import_module(STATES).start_of(stage, branch, value)
    start, impulse = (None, np.nan) if found is None else found
    name = "rest" if found is None else "periodic"
    return start, {"start": np.int8(flag("start", name)), "start_impulse": np.float64(impulse)}


def begun(problem: ContactProblem, start: Start) -> ContactProblem:
    """Return the contact problem of a march that starts from a motion that has lasted: ramps of
    loads, loads that end, and the closure of the casing are over."""
    shape = problem.start.rotor.shape
    lasting = (replace(load, ramp=0.0) for load in problem.loads if np.isinf(load.end))
    return replace(
        problem,
        start=replace(
            start,
            rotor=start.rotor.reshape(shape),
            rotor_velocity=start.rotor_velocity.reshape(shape),
        ),
        loads=tuple(lasting),
        casing=replace(problem.casing, clearance=problem.clearance(NEVER)),
        closure=None,
    )
