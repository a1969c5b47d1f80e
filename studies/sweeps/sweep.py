"""Sweeps: a case is marched at many points, by many processes, into one dataset.

Only the calling process writes the dataset; workers only march. The content of the dataset depends
on the case and the points, not on the number of workers, their order, or interruptions.
"""

import os
import shutil
import time
import warnings
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from bladewhirl.files import PREFIX
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.template import dumps_case
from bladewhirl.models.inputs.errors import Hint, UserError
from bladewhirl.postprocess.sweep.dataset import DONE, SWEEP_NAME
from bladewhirl.solvers.march.free_motion import StopWhen
from bladewhirl.studies.runs import folder
from bladewhirl.studies.sweeps.axes import OVER, TABLE, Grid, PointTable, Value, make_grid
from bladewhirl.studies.sweeps.carried import STATES_NAME, Carry
from bladewhirl.studies.sweeps.draws import UNTIL, parse_draws
from bladewhirl.studies.sweeps.marching import march_points
from bladewhirl.studies.sweeps.plan import (
    SweepOptions,
    SweepPlan,
    plan_sweep,
    read_plan,
    require_new,
    write_plan,
)
from bladewhirl.studies.sweeps.points import Work
from bladewhirl.studies.sweeps.rounds import Rounds
from bladewhirl.studies.sweeps.starts import StartName, follow_branches
from bladewhirl.studies.sweeps.store import Store, create
from bladewhirl.studies.sweeps.table import Columns, point_table
from bladewhirl.studies.sweeps.workers import process_context


@dataclass(frozen=True, kw_only=True)
class Watch:
    """Progress callbacks of a sweep."""

    #: called once, before anything is written
    planned: Callable[[SweepPlan], None] = lambda plan: None
    progress: Callable[[int, int, int], None] = lambda done, failed, points: None
    """Called at the start and after every point with the numbers of finished, failed and all
    points."""


@dataclass(frozen=True, kw_only=True)
class Sweep:
    """Outcome of a sweep."""

    directory: Path
    points: int
    done: int
    failures: dict[int, str]  #: reason of each failed point
    grid: Grid
    wall_time: float  #: wall time of this call [s]
    marched: int  #: number of points marched by this call
    not_needed: int = 0  #: number of random draws that were skipped, see `until` and `screen`
    screened: int = 0  #: number of points with the result of a screening march
    left_out: Mapping[str, str] = field(default_factory=dict)  #: figures not drawn, and the reasons

    @property
    def failed(self) -> int:
        """Number of failed points."""
        return len(self.failures)


class SweepFailed(UserError):
    """All points of a sweep failed; its `sweep` contains the reasons, as failures.json does."""

    def __init__(self, sweep: Sweep) -> None:
        point, reason = min(sweep.failures.items())
        super().__init__(
            f"{sweep.directory}: all {sweep.failed} points failed, first"
            f" {sweep.grid.label(point)}: {reason}"
        )
        self.sweep = sweep


def run_sweep(
    case: Case,
    over: Mapping[str, Sequence[Value]] | None = None,
    directory: str | Path = "sweep",
    *,
    table: str | Path | Columns | None = None,
    scheduler: str | None = None,
    workers: int | None = None,
    histories: bool = False,
    large: bool = False,
    stop_when: StopWhen | None = None,
    draws: int | None = None,
    perturb: Sequence[str] = (),
    seed: int = 0,
    until: float | None = None,
    screen: bool = False,
    carry: Carry | None = None,
    start: StartName = "rest",
    watch: Watch | None = None,
) -> Sweep:
    """March a case at every combination of values, or at the points of a table, and collect the
    results in a dataset.

    The folder then contains sweep.json (the plan), provenance.json, sweep.nc (open it with
    `open_sweep`), failures.json if points failed, figures, and histories/ if requested.
    `resume_sweep` finishes a sweep that was interrupted or killed.

    Args:
        case: case that the sweep varies.
        over: values of each swept key, in the form of the case file.
        directory: folder to make.
        table: points in place of `over`: a DataFrame, a mapping of columns, or the path of a CSV
            file, see `table.point_table`. The dataset then has the dimension `point`.
        scheduler: address of a dask scheduler; if None, processes of this computer march.
        workers: number of processes of this computer; one per core when None.
        histories: whether to keep the full histories of every point; with a scheduler, all workers
            must have access to the folder under the same path.
        large: whether to allow more than 100,000 points, a billion steps of one march, or a
            trillion steps of the sweep.
        stop_when: "damped" ends a march early when no tip can touch any more; the attribute
            `stop_rule` of the dataset contains the rule.
        draws: number of random draws, marches of each point with random changes; `probability`
            gives the shares of the regimes. The dataset then has the dimension `draw`.
        perturb: random changes, such as "contact.friction = 0.05": a normal distribution with a
            standard deviation of 5 %. More words are possible, see `draws.parse_draws`.
        seed: seed of the random draws.
        until: march no more draws of a point when the 95 % interval of the share of every regime
            excludes one half or is narrower than `until`. The `state` of the other draws is
            "not-needed".
        screen: first march the draws with scaled masses of the casing and a longer time step; then
            repeat points with an uncertain outcome at the time step of the case. The variable
            `screened` marks the former marches; the attribute `screen_rule` is the rule.
        carry: "up" or "down": start the march at each speed from the motion at the speed below or
            above it, so that hysteresis is seen; the attribute `carry_rule` is the rule.
        start: "periodic" starts each march on a periodic motion, see `bladewhirl.periodic`, of the
            branch over the speed or the first key; the folder branches/ keeps the branches. The
            variable `start` says "rest" where none was found, `start_impulse` is the impulse per
            revolution of the motion; the attribute `start_rule` is the rule.
        watch: progress callbacks.

    Warns:
        Hint: an implausible value at the first or the last point.

    Raises:
        UserError: as for `make_grid`, `point_table` and `plan_sweep`; both or none of `over` and
            `table` are given; the folder exists or cannot be written; the scheduler does not
            answer; or all points fail (`SweepFailed`).
    """
    directory = Path(directory)
    require_new(directory)
    if scheduler is None:
        process_context()
    if over and table is not None:
        raise UserError(f"{OVER}, {TABLE}: omit one of them")
    grid = make_grid(
        case,
        over or {},
        large=large,
        draws=parse_draws(draws, perturb, seed, until),
        table=None if table is None else point_table(table),
    )
    options = SweepOptions(
        histories=histories, stop_when=stop_when, screen=screen, carry=carry, start=start
    )
    watch = watch or Watch()
    plan = plan_sweep(case, grid, options, large=large)
    for hint in plan.hints:
        warnings.warn(hint, Hint, stacklevel=2)
    watch.planned(plan)
    watch.progress(0, 0, grid.size)
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
    draws: int | None = None,
    until: float | None = None,
    watch: Watch | None = None,
) -> Sweep:
    """Finish the sweep in a folder: march the missing points, and the failed points again.

    Args:
        directory: folder of the sweep.
        scheduler: see `run_sweep`.
        workers: see `run_sweep`.
        draws: new, larger number of random draws of each point; the finished draws are kept.
        until: new, smaller width of the intervals of a sweep with `until`.
        watch: progress callbacks.

    Raises:
        UserError: the folder contains no sweep, or a sweep of another program version; the sweep
            is still running; the scheduler does not answer; or draws cannot be added.
    """
    directory = Path(directory)
    plan = read_plan(directory)
    if draws is not None or until is not None:
        plan = _add_draws(plan, directory, draws, until)
    watch = watch or Watch()
    watch.planned(plan)
    return _carry_out(plan, directory, watch, scheduler, workers)


def _carry_out(
    plan: SweepPlan, directory: Path, watch: Watch, scheduler: str | None, workers: int | None
) -> Sweep:
    """March all unfinished points of the plan into the dataset in the folder, and draw figures."""
    from bladewhirl.postprocess.sweep.figures import leave_figures

    began = time.perf_counter()
    histories = directory.absolute() / folder.HISTORIES_NAME
    states = directory.absolute() / STATES_NAME
    if plan.histories:
        histories.mkdir(exist_ok=True)
    if plan.carry is not None:
        states.mkdir(exist_ok=True)
    if plan.start == "periodic":
        follow_branches(plan.case, plan.grid, directory)
    if not (directory / SWEEP_NAME).exists():
        grid, attributes = plan.grid, plan.attributes
        create(directory, grid, plan.coordinates, plan.layout, attributes, screen=plan.screen)
    with Store(directory, plan.grid, plan.digest) as store:
        # The data of a point must match the file, not the defaults of this computer.
        layout = replace(plan.layout, frequency=store.frequency)
        work = Work(
            case=dumps_case(plan.case),
            layout=layout,
            histories=str(histories),
            stop_when=plan.stop_when,
            states=str(states),
            start=plan.start,
            directory=str(directory.absolute()),
        )
        marched = 0
        watch.progress(store.done, 0, plan.grid.size)
        rounds = Rounds(
            plan, store, partial(march_points, work, scheduler=scheduler, workers=workers)
        )
        for number, outcome in rounds.outcomes():
            _check_there(directory)
            if outcome is None:
                store.leave_out(number)
                if plan.histories:
                    (histories / str(plan.point(number).history)).unlink(missing_ok=True)
            else:
                store.write(number, outcome, screened=rounds.screening)
                marched += 1
            needed = plan.grid.size - store.not_needed
            watch.progress(store.done - rounds.waiting, len(store.failures), needed)
        swept = Sweep(
            directory=directory,
            points=plan.grid.size,
            done=store.done,
            not_needed=store.not_needed,
            screened=int(np.count_nonzero(store.screened & (store.state == DONE))),
            failures=dict(store.failures),
            grid=plan.grid,
            wall_time=time.perf_counter() - began,
            marched=marched,
        )
    _check_there(directory)
    if swept.done == swept.points:
        shutil.rmtree(states, ignore_errors=True)
    swept = replace(swept, left_out=leave_figures(directory))
    if swept.failures and not swept.done:
        raise SweepFailed(swept)
    return swept


def _check_there(directory: Path) -> None:
    """Check that nobody has removed the folder of a sweep, which is not made again.

    Raises:
        UserError: the folder, or the dataset in it, is missing.
    """
    if not (directory / SWEEP_NAME).exists():
        raise UserError(f"{directory}: was removed while the sweep was running")


def _add_draws(
    plan: SweepPlan, directory: Path, count: int | None, until: float | None
) -> SweepPlan:
    """Return the plan of a sweep with `count` random draws at each point, and write plan and
    dataset with these draws into the folder of the sweep. Draws are marched until the confidence
    intervals are narrower than `until`. None keeps the value of the plan.

    The dataset is replaced before the plan. After a kill in between, the same call completes both.

    Raises:
        UserError: the sweep has no draws, or not fewer than `count`; it keeps histories, which are
            numbered by draw, or carries motion from speed to speed; or its dataset is in use,
            damaged or of another plan.
    """
    draws = plan.grid.draws
    of_count = f"--resume {directory}, --draws {count}"
    of_until = f"--resume {directory}, {UNTIL} {until or 0.0:g}"
    either = of_until if count is None else of_count
    if draws is None:
        raise UserError(f"{either}: this sweep was made without --draws")
    if plan.histories or plan.carry:
        kept = "--histories" if plan.histories else "--continue"
        raise UserError(f"{either}: a sweep with {kept} cannot get more random draws")
    if count is not None and count <= draws.count:
        raise UserError(f"{of_count}: expected more than the {draws.count} draws of the sweep")
    if until is not None:
        if draws.until is None:
            raise UserError(f"{of_until}: this sweep was made without {UNTIL}")
        if not 0.0 < until < draws.until:
            raise UserError(f"{of_until}: expected less than the {draws.until:g} of the sweep")
    count = count or draws.count
    table = PointTable(values=plan.grid.listed) if plan.grid.table else None
    more = replace(draws, count=count, until=until or draws.until)
    grid = make_grid(plan.case, plan.grid.over, large=True, draws=more, table=table)
    options = SweepOptions(stop_when=plan.stop_when, screen=plan.screen, start=plan.start)
    wider = plan_sweep(plan.case, grid, options)
    widened = False
    with suppress(UserError), Store(directory, wider.grid, wider.digest):
        widened = True
    if not widened:
        with TemporaryDirectory(prefix=PREFIX, dir=directory) as draft:
            _copy_draws(plan, directory, wider, Path(draft))
            os.replace(Path(draft) / SWEEP_NAME, directory / SWEEP_NAME)
    (directory / folder.FAILURES_NAME).unlink(missing_ok=True)  # they are marched again
    write_plan(wider, directory)
    return wider


def _copy_draws(plan: SweepPlan, directory: Path, more: SweepPlan, draft: Path) -> None:
    """Create the dataset of the plan `more` in the folder `draft`, with all finished draws of the
    dataset of `plan` in `directory`."""
    assert plan.grid.draws is not None
    assert more.grid.draws is not None
    with Store(directory, plan.grid, plan.digest) as old:
        layout = replace(more.layout, frequency=old.frequency)
        create(draft, more.grid, more.coordinates, layout, more.attributes, screen=more.screen)
        screened = old.screened
        with Store(draft, more.grid, more.digest) as new:
            for number in np.flatnonzero(old.state == DONE):
                point, draw = divmod(int(number), plan.grid.draws.count)
                new.write(
                    point * more.grid.draws.count + draw,
                    old.read(int(number)),
                    screened=bool(screened[number]),
                )
