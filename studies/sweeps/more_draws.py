"""More random draws at the points of an existing sweep; the finished draws are kept."""

import os
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from bladewhirl.files import PREFIX
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.postprocess.sweep.dataset import DONE, SWEEP_NAME
from bladewhirl.studies.runs.folder import FAILURES_NAME
from bladewhirl.studies.sweeps.axes import PointTable, make_grid
from bladewhirl.studies.sweeps.draws import UNTIL
from bladewhirl.studies.sweeps.plan import Plan, plan_sweep, write_plan
from bladewhirl.studies.sweeps.store import Store, create


def add_draws(
    plan: Plan, directory: Path, count: int | None = None, until: float | None = None
) -> Plan:
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
    option = f"{UNTIL} {until:g}" if count is None and until is not None else f"--draws {count}"
    if draws is None:
        raise UserError(f"--resume {directory}, {option}: this sweep was made without --draws")
    if plan.histories or plan.carry:
        kept = "--histories" if plan.histories else "--continue"
        raise UserError(
            f"--resume {directory}, {option}: a sweep with {kept} cannot get more random draws"
        )
    if count is not None and count <= draws.count:
        raise UserError(
            f"--resume {directory}, {option}: expected more than the {draws.count} draws it has"
        )
    if until is not None and draws.until is None:
        raise UserError(
            f"--resume {directory}, {UNTIL} {until:g}: this sweep was made without {UNTIL}"
        )
    if until is not None and draws.until is not None and not 0.0 < until < draws.until:
        raise UserError(
            f"--resume {directory}, {UNTIL} {until:g}: expected less than its width {draws.until:g}"
        )
    count = count or draws.count
    table = PointTable(values=plan.grid.listed) if plan.grid.table else None
    more = replace(draws, count=count, until=until or draws.until)
    grid = make_grid(plan.case, plan.grid.over, large=True, draws=more, table=table)
    wider = plan_sweep(
        plan.case, grid, histories=False, stop_when=plan.stop_when, screen=plan.screen
    )
    if not _is_dataset_of(wider, directory):
        with TemporaryDirectory(prefix=PREFIX, dir=directory) as draft:
            _copy(plan, directory, wider, Path(draft))
            os.replace(Path(draft) / SWEEP_NAME, directory / SWEEP_NAME)
    (directory / FAILURES_NAME).unlink(missing_ok=True)  # they are marched again
    write_plan(wider, directory)
    return wider


def _is_dataset_of(plan: Plan, directory: Path) -> bool:
    """Return whether the dataset in a folder is that of a plan."""
    try:
        with Store(directory, plan.grid, plan.digest):
            return True
    except UserError:
        return False


def _copy(plan: Plan, directory: Path, more: Plan, draft: Path) -> None:
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
