"""Sweeps: a case is marched at many points, by many processes, into one dataset.

Only the calling process writes the dataset; workers only march. The content of the dataset depends
on the case and the points, not on the number of workers, their order, or interruptions.
"""

import time
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from bladewhirl.models.case.case import Case
from bladewhirl.models.case.template import dumps_case
from bladewhirl.models.inputs.errors import Hint, UserError
from bladewhirl.postprocess.sweep.dataset import SWEEP_NAME
from bladewhirl.solvers.march.free_motion import RULE, StopWhen
from bladewhirl.studies.runs import folder
from bladewhirl.studies.sweeps.axes import Grid, Value, make_grid
from bladewhirl.studies.sweeps.draws import parse_draws
from bladewhirl.studies.sweeps.plan import PLAN_NAME, Plan, plan_sweep, read_plan, write_plan
from bladewhirl.studies.sweeps.points import Work
from bladewhirl.studies.sweeps.store import Store, create
from bladewhirl.studies.sweeps.workers import march_points

HISTORIES_NAME = "histories"
"""Name of the folder of full histories."""


@dataclass(frozen=True, kw_only=True)
class Watch:
    """Progress callbacks of a sweep."""

    planned: Callable[[Plan], None] = lambda plan: None  #: called once, before anything is written
    progress: Callable[[int, int, int], None] = lambda done, failed, points: None
    """Called after every point with the numbers of finished, failed and all points."""


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
    left_out: Mapping[str, str] = field(default_factory=dict)  #: figures not drawn, and the reasons

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
    draws: int | None = None,
    perturb: Sequence[str] = (),
    seed: int = 0,
    watch: Watch | None = None,
) -> Sweep:
    """March a case at every combination of values and collect the results in a dataset.

    These are written into the folder: sweep.json (the plan), provenance.json, sweep.nc (open it
    with `open_sweep`), failures.json if points failed, figures, and histories/ if requested.
    `resume_sweep` finishes a sweep that was interrupted or killed.

    Local workers are fresh Python processes, which import the main module: scripts need the usual
    ``if __name__ == "__main__":``.

    Args:
        case: case that the sweep varies.
        over: values of each swept key, in the form of the case file.
        directory: folder to make.
        scheduler: address of a dask scheduler; if None, processes of this machine march.
        workers: number of processes of this machine; one per core when None.
        histories: whether to keep the full histories of every point; with a scheduler, all workers
            must have access to the folder under the same path.
        large: whether to allow more than 100,000 points, a billion steps of one march, or a
            trillion steps of the sweep.
        stop_when: "damped" ends a march early when no tip can touch any more; the attribute
            `stop_rule` of the dataset contains the rule.
        draws: number of marches of each point with random changes; `probability` gives the shares
            of the regimes. The dataset then has the dimension `draw`.
        perturb: random changes, such as "contact.friction = 0.05": a normal distribution with a
            standard deviation of 5 %. More words are possible, see `draws.parse_draws`.
        seed: seed of the draws.
        watch: progress callbacks.

    Warns:
        Hint: an implausible value at the first or the last point.

    Raises:
        UserError: as for `make_grid` and `plan_sweep`; or the folder exists or cannot be written,
            or the scheduler does not answer.
    """
    directory = Path(directory)
    if directory.exists() and (not directory.is_dir() or any(directory.iterdir())):
        resumable = (directory / PLAN_NAME).exists()
        hint = "; --resume finishes the sweep in it" if resumable else ""
        raise UserError(f"{directory}: expected a new or an empty folder{hint}")
    grid = make_grid(case, over, large=large, draws=parse_draws(draws, perturb, seed))
    plan = plan_sweep(case, grid, histories=histories, large=large, stop_when=stop_when)
    for hint in plan.hints:
        warnings.warn(hint, Hint, stacklevel=2)
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
    """Finish the sweep in a folder: march the missing points, and the failed points again.

    The other arguments are described in `run_sweep`.

    Raises:
        UserError: the folder contains no sweep, or a sweep of another program version; the sweep
            is still running; or the scheduler does not answer.
    """
    directory = Path(directory)
    plan = read_plan(directory)
    watch = watch or Watch()
    watch.planned(plan)
    return _carry_out(plan, directory, watch, scheduler, workers)


def _carry_out(
    plan: Plan, directory: Path, watch: Watch, scheduler: str | None, workers: int | None
) -> Sweep:
    """March all unfinished points of the plan into the dataset in the folder, and draw figures."""
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
