"""Sweeps: a case marched at many points, by many processes, into one dataset.

The process that calls alone writes the dataset; workers only march. What is in the dataset
depends on the case and the points, not on the number of workers, their order, or interruptions.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from bladewhirl.models.case import Case
from bladewhirl.models.case_file import dumps_case, loads, with_values
from bladewhirl.models.faults import UserError
from bladewhirl.models.march_problem import march_faults
from bladewhirl.postprocess.sweep_result import DONE, SWEEP_NAME, Layout
from bladewhirl.studies import run_directory as folder
from bladewhirl.studies.runs import prepare_stage
from bladewhirl.studies.sweep_axes import (
    OVER,
    Grid,
    Value,
    coordinate,
    make_grid,
    refuse_faulty,
    unit_of,
    value_at,
)
from bladewhirl.studies.sweep_cluster import march_groups
from bladewhirl.studies.sweep_layout import make_layout
from bladewhirl.studies.sweep_points import Group, Work, stage_at
from bladewhirl.studies.sweep_store import Coordinates, Store, create, write_whole

PLAN_NAME = "sweep.json"
"""What a sweep is, so that it can be resumed."""

HISTORIES_NAME = "histories"
"""Folder of full histories."""

GROUP_SIZE = 1
"""Points in a unit of work. Part of the plan: what is marched together must not change on
resume."""

CHECKED_STAGES = 32
"""Stages built before a sweep to see whether they can be marched; faults of further ones show
as failed points."""


@dataclass(frozen=True, kw_only=True)
class Plan:
    """A sweep that has been checked: its points and what it will take."""

    case: Case
    grid: Grid
    coordinates: Coordinates
    layout: Layout
    histories: bool
    group_size: int
    steps: int  #: of all marches together, if none ends early
    history_bytes: int  #: of all full histories

    @property
    def dataset_bytes(self) -> int:
        """Size of the dataset [bytes]."""
        return self.grid.size * self.layout.bytes_per_point

    @property
    def groups(self) -> list[range]:
        """Points of each unit of work."""
        size, width = self.grid.size, self.group_size
        return [range(first, min(first + width, size)) for first in range(0, size, width)]


@dataclass(frozen=True, kw_only=True)
class Watch:
    """Who is told how a sweep goes."""

    planned: Callable[[Plan], None] = lambda plan: None  #: once, before anything is written
    progress: Callable[[int, int, int], None] = lambda done, failed, points: None
    """After every group: points done, points failed, points in all."""


@dataclass(frozen=True, kw_only=True)
class Sweep:
    """What a sweep left."""

    directory: Path
    points: int
    done: int
    failures: dict[int, str]  #: reason of each failed point
    grid: Grid
    wall_time: float  #: of this call [s]
    marched: int  #: points marched by this call

    @property
    def failed(self) -> int:
        """Number of failed points."""
        return len(self.failures)


def run_sweep(
    case: Case,
    over: Mapping[str, Sequence[Value]],
    directory: str | Path,
    *,
    scheduler: str | None = None,
    workers: int | None = None,
    histories: bool = False,
    large: bool = False,
    watch: Watch | None = None,
) -> Sweep:
    """March a case at every combination of values and keep what matters of each in a dataset.

    The folder gets sweep.json (the plan), provenance.json, sweep.nc (open it with `open_sweep`),
    failures.json if points failed, figures, and histories/ if asked for. A call that is
    interrupted or killed leaves a folder that `resume_sweep` finishes.

    Local workers are fresh Python processes, which import the main module: scripts need the usual
    ``if __name__ == "__main__":``.

    Args:
        case: that the sweep varies.
        over: values of each swept key, as the case file would hold them.
        directory: to make.
        scheduler: address of an existing dask scheduler; a local cluster when None.
        workers: of the local cluster; one a core when None.
        histories: keep the full histories of every point; with a scheduler the folder must be
            seen by all workers under the same path.
        large: more than 100,000 points are meant.
        watch: is told how it goes.

    Raises:
        UserError: what `make_grid` and `plan_sweep` refuse, a folder that exists or can't be
            written, a scheduler that does not answer.
    """
    directory = Path(directory)
    if directory.exists() and (not directory.is_dir() or any(directory.iterdir())):
        resumable = (directory / PLAN_NAME).exists()
        hint = "; --resume finishes the sweep in it" if resumable else ""
        raise UserError(f"{directory}: expected a new or an empty folder{hint}")
    plan = plan_sweep(case, make_grid(case, over, large=large), histories=histories)
    watch = watch or Watch()
    watch.planned(plan)
    try:
        directory.mkdir(parents=True, exist_ok=True)
        folder.write_provenance(directory)
        write_whole(directory / PLAN_NAME, _plan_text(plan))
    except OSError as error:
        raise UserError(f"{directory}: cannot be written ({error})") from None
    return _carry_out(plan, directory, scheduler, workers, watch)


def resume_sweep(
    directory: str | Path,
    *,
    scheduler: str | None = None,
    workers: int | None = None,
    watch: Watch | None = None,
) -> Sweep:
    """Finish a sweep: march what is missing, and what failed again.

    Args:
        directory: of the sweep.
        scheduler: as in `run_sweep`, and so the others.
        workers: see there.
        watch: see there.

    Raises:
        UserError: no sweep there, one of another version of the program, one still running, or a
            scheduler that does not answer.
    """
    directory = Path(directory)
    plan = _read_plan(directory)
    watch = watch or Watch()
    watch.planned(plan)
    return _carry_out(plan, directory, scheduler, workers, watch)


def plan_sweep(case: Case, grid: Grid, *, histories: bool, group_size: int = GROUP_SIZE) -> Plan:
    """Check every point of a sweep and find what it will take.

    Raises:
        UserError: faults of the case at points, each with its point.
    """
    cases = list(grid.cases(case))
    coordinates = _coordinates(case, grid, cases)
    _check_stages(grid, cases)
    layout, history_bytes = make_layout(cases, stage_at(cases[0]))
    return Plan(
        case=case,
        grid=grid,
        coordinates=coordinates,
        layout=layout,
        histories=histories,
        group_size=group_size,
        steps=sum(each.march.steps for each in cases),
        history_bytes=history_bytes if histories else 0,
    )


def _coordinates(case: Case, grid: Grid, cases: Sequence[Case]) -> Coordinates:
    found = {}
    numbers = np.arange(grid.size).reshape(grid.shape)
    for position, axis in enumerate(grid.axes):
        along = np.moveaxis(numbers, position, 0).reshape(len(axis.values), -1)[:, 0]
        values, unit = coordinate([value_at(cases[point], axis.key) for point in along])
        found[axis.key] = (values, unit or unit_of(case, axis.key))
    return found


def _check_stages(grid: Grid, cases: Sequence[Case]) -> None:
    """Build the stages of points, the first and the last among them, and look for faults.

    Raises:
        UserError: faults, each with its point.
    """
    faults: list[str] = []
    swept_body = [axis for axis in grid.axes if not axis.key.startswith(("march.", "contact."))]
    chosen = range(grid.size)
    if swept_body:
        spread = np.linspace(0, grid.size - 1, min(CHECKED_STAGES, grid.size))
        chosen = np.unique(spread.round().astype(int)).tolist()
    for point in chosen:
        try:
            found = [str(fault) for fault in march_faults(stage_at(cases[point]))]
        except UserError as error:
            found = error.lines
        faults += [f"{OVER}, point {grid.label(point)}: {line}" for line in found[:1]]
    refuse_faulty(faults)


def _plan_text(plan: Plan) -> str:
    document = {
        folder.PACKAGE: folder.version(),
        "case": dumps_case(plan.case),
        "over": {axis.key: axis.values for axis in plan.grid.axes},
        "histories": plan.histories,
        "group_size": plan.group_size,
    }
    return json.dumps(document, indent=2, ensure_ascii=False) + "\n"


def _read_plan(directory: Path) -> Plan:
    """The plan of a sweep that was begun.

    Raises:
        UserError: there is none, or it is another version's.
    """
    path = directory / PLAN_NAME
    try:
        document: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        made_by, text, over = (document[key] for key in (folder.PACKAGE, "case", "over"))
        histories, group_size = bool(document["histories"]), int(document["group_size"])
    except OSError as error:
        raise UserError(f"{path}: expected the plan of a sweep ({error.strerror})") from None
    except (ValueError, KeyError, TypeError) as error:
        raise UserError(f"{path}: expected the plan of a sweep ({error!r})") from None
    if made_by != folder.version():
        raise UserError(
            f"{path}: expected a sweep of bladewhirl {folder.version()}, this one is of {made_by};"
            " its points would not agree to the last bit"
        )
    case = loads(text, file=str(path))
    return plan_sweep(
        case, make_grid(case, over, large=True), histories=histories, group_size=group_size
    )


def _carry_out(
    plan: Plan,
    directory: Path,
    scheduler: str | None,
    workers: int | None,
    watch: Watch,
) -> Sweep:
    """March every group that is not done yet."""
    from bladewhirl.postprocess.sweep_figures import draw_sweep

    began = time.perf_counter()
    histories = directory.absolute() / HISTORIES_NAME
    if plan.histories:
        histories.mkdir(exist_ok=True)
    if not (directory / SWEEP_NAME).exists():
        attributes = {"title": plan.case.title, "case": dumps_case(plan.case)}
        attributes["version"] = folder.version()
        create(directory, plan.grid, plan.coordinates, plan.layout, attributes)
    with Store(directory, plan.grid) as store:
        # What is kept of a point has to fit the file, whatever this machine would have chosen.
        layout = replace(plan.layout, frequency=store.frequency)
        work = Work(case=dumps_case(plan.case), layout=layout, histories=str(histories))
        state = store.state
        left = [
            _group(plan, number, points)
            for number, points in enumerate(plan.groups)
            if not all(state[point] == DONE for point in points)
        ]
        watch.progress(store.done, 0, plan.grid.size)
        if left:
            _compile(plan.case, next(iter(left[0].points.values())))
        for outcomes in march_groups(work, left, scheduler=scheduler, workers=workers):
            store.write(outcomes)
            watch.progress(store.done, len(store.failures), plan.grid.size)
        swept = Sweep(
            directory=directory,
            points=plan.grid.size,
            done=store.done,
            failures=store.failures,
            grid=plan.grid,
            wall_time=time.perf_counter() - began,
            marched=sum(len(group.points) for group in left),
        )
    if swept.done:
        draw_sweep(directory)
    return swept


def _compile(case: Case, values: Mapping[str, Value]) -> None:
    """Leave compiled code where local workers find it.

    Those that compile side by side may get code that differs in the last bits of a result.
    """
    with suppress(UserError):  # a point that can't be marched is told of by its worker
        prepare_stage(stage_at(with_values(case, values)))


def _group(plan: Plan, number: int, points: range) -> Group:
    digits = len(str(plan.grid.size - 1))
    names = {point: f"point_{point:0{digits}d}.nc" for point in points} if plan.histories else {}
    return Group(
        number=number,
        points={point: plan.grid.values(point) for point in points},
        history_names=names,
    )
