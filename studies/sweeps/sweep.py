"""Sweeps: a case marched at many points, by many processes, into one dataset.

The process that calls alone writes the dataset; workers only march. What is in the dataset
depends on the case and the points, not on the number of workers, their order, or interruptions.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from bladewhirl.models.case.case import Case
from bladewhirl.models.case.template import dumps_case
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.postprocess.sweep.dataset import SWEEP_NAME
from bladewhirl.solvers.march.free_motion import RULE, StopWhen
from bladewhirl.studies.runs import folder
from bladewhirl.studies.sweeps.axes import Grid, Value, make_grid
from bladewhirl.studies.sweeps.plan import PLAN_NAME, Plan, plan_sweep, read_plan, write_plan
from bladewhirl.studies.sweeps.points import Work
from bladewhirl.studies.sweeps.store import Store, create
from bladewhirl.studies.sweeps.workers import march_points

HISTORIES_NAME = "histories"
"""Folder of full histories."""


@dataclass(frozen=True, kw_only=True)
class Watch:
    """Progress callbacks of a sweep."""

    planned: Callable[[Plan], None] = lambda plan: None  #: once, before anything is written
    progress: Callable[[int, int, int], None] = lambda done, failed, points: None
    """After every point: points done, points failed, points in all."""


@dataclass(frozen=True, kw_only=True)
class Sweep:
    """Outcome of a sweep."""

    directory: Path
    points: int
    done: int
    failures: dict[int, str]  #: reason of each failed point
    grid: Grid
    wall_time: float  #: of this call [s]
    marched: int  #: points marched by this call
    left_out: Mapping[str, str] = field(default_factory=dict)  #: figures not drawn, and why

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
    stop_when: StopWhen | None = None,
    watch: Watch | None = None,
) -> Sweep:
    """March a case at every combination of values and collect the results in a dataset.

    The folder gets sweep.json (the plan), provenance.json, sweep.nc (open it with `open_sweep`),
    failures.json if points failed, figures, and histories/ if asked for. A call that is
    interrupted or killed leaves a folder that `resume_sweep` finishes.

    Local workers are fresh Python processes, which import the main module: scripts need the usual
    ``if __name__ == "__main__":``.

    Args:
        case: that the sweep varies.
        over: values of each swept key, as the case file would hold them.
        directory: to make.
        scheduler: address of a dask scheduler; processes of this machine when None.
        workers: number of processes of this machine; one a core when None.
        histories: keep the full histories of every point; with a scheduler the folder must be
            seen by all workers under the same path.
        large: more than 100,000 points are meant, or more than a billion steps of one march or a
            trillion of all.
        stop_when: "damped" ends a march early when no tip can touch any more, by the rule that the
            dataset's attribute `stop_rule` says.
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
    grid = make_grid(case, over, large=large)
    plan = plan_sweep(case, grid, histories=histories, large=large, stop_when=stop_when)
    watch = watch or Watch()
    watch.planned(plan)
    try:
        directory.mkdir(parents=True, exist_ok=True)
        write_plan(plan, directory)
        folder.write_provenance(directory, plan.case)
    except OSError as error:
        raise UserError(f"{directory}: cannot be written ({error})") from None
    return _carry_out(plan, directory, watch, scheduler, workers)


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
    plan = read_plan(directory)
    watch = watch or Watch()
    watch.planned(plan)
    return _carry_out(plan, directory, watch, scheduler, workers)


def _carry_out(
    plan: Plan,
    directory: Path,
    watch: Watch,
    scheduler: str | None,
    workers: int | None,
) -> Sweep:
    """March every point that is not done yet."""
    from bladewhirl.postprocess.sweep.figures import leave_figures

    began = time.perf_counter()
    histories = directory.absolute() / HISTORIES_NAME
    if plan.histories:
        histories.mkdir(exist_ok=True)
    if not (directory / SWEEP_NAME).exists():
        attributes = {"title": plan.case.title, "case": folder.portable_case(plan.case)}
        attributes |= {"version": folder.version(), "plan": plan.digest}
        attributes |= {} if plan.stop_when is None else {"stop_rule": RULE}
        create(directory, plan.grid, plan.coordinates, plan.layout, attributes)
    with Store(directory, plan.grid, plan.digest) as store:
        # The data of a point must match the file, not the defaults of this machine.
        layout = replace(plan.layout, frequency=store.frequency)
        work = Work(
            case=dumps_case(plan.case),
            layout=layout,
            histories=str(histories),
            stop_when=plan.stop_when,
        )
        state, marched = store.state.copy(), 0
        watch.progress(store.done, 0, plan.grid.size)
        for number, outcome in march_points(
            work, plan.left(state), scheduler=scheduler, workers=workers
        ):
            store.write(number, outcome)
            marched += 1
            watch.progress(store.done, len(store.failures), plan.grid.size)
        swept = Sweep(
            directory=directory,
            points=plan.grid.size,
            done=store.done,
            failures=dict(store.failures),
            grid=plan.grid,
            wall_time=time.perf_counter() - began,
            marched=marched,
        )
    return replace(swept, left_out=leave_figures(directory))
