"""`bladewhirl sweep`: march a case with many values of its keys, on all cores or a cluster."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from bladewhirl.models.inputs.errors import UserError
from bladewhirl.studies.commands import options
from bladewhirl.studies.commands.terminal import ALL_FAILED, emit, interruptible, progress_bar
from bladewhirl.studies.runs.columns import table as table_of

if TYPE_CHECKING:
    from pathlib import Path

    from bladewhirl.models.case.case import Case
    from bladewhirl.studies.sweeps.axes import Grid
    from bladewhirl.studies.sweeps.plan import SweepPlan
    from bladewhirl.studies.sweeps.sweep import Sweep


SHOWN_FAILURES = 10  #: largest number of failed points printed; failures.json lists all


def sweep(
    context: typer.Context,
    case: options.NewCase = None,
    over: Annotated[list[str] | None, typer.Option(metavar="KEY=VALUES")] = None,
    table: options.File = None,
    output: options.OutputFolder = None,
    overrides: options.Changes = None,
    scheduler: options.Scheduler = None,
    workers: options.Workers = None,
    histories: Annotated[bool, typer.Option("--histories")] = False,
    stop_when: Literal["damped"] | None = None,
    draws: int | None = None,
    perturb: Annotated[list[str] | None, typer.Option(metavar="KEY=SIZE")] = None,
    seed: int = 0,
    draw: int | None = None,
    until: Annotated[float | None, typer.Option(metavar="WIDTH")] = None,
    screen: Annotated[bool, typer.Option("--screen")] = False,
    carry: Annotated[Literal["up", "down"] | None, typer.Option("--continue")] = None,
    start: Literal["rest", "periodic"] = "rest",
    resume: options.Resume = None,
    yes: Annotated[bool, typer.Option("--yes")] = False,
    json: options.AsJson = False,
) -> None:
    """March a case with every value of a key, or every combination of values of several keys.

    Each combination is a point; with --table the points are the rows of a file. DIR then contains
    sweep.nc (netCDF, opens with xarray), with spectra, energies, regimes and decimated histories of
    every point, and some figures. `bladewhirl plot DIR` draws more figures: whirl, contacts,
    energies, bifurcations, maps over two keys. Failed points are listed in failures.json. --resume
    DIR finishes a sweep that was interrupted or killed, with bitwise the same result.

    Args:
        over: A numeric key of the case and its values: march.speed=0.95:2:0.005 (start:stop:step,
            the stop included) or contact.friction=0.05,0.1; units as in the case file,
            "casing.clearance=0.5 mm,1 mm". Several --over: all combinations.
        table: CSV file of points, in place of --over: keys in the first line, with units as in
            "march.speed,casing.clearance [mm]", and a point in every other line.
        output: Folder to make.
        histories: Keep the full history of every point.
        stop_when: End marches early. damped: when blades do not touch and the motion has too little
            energy for another contact.
        draws: Number of random draws: marches of each point, with values changed by --perturb.
        perturb: Random change of a key in each random draw: "contact.friction = 0.05" is a normal
            distribution with a standard deviation of 5 %. A following "absolute" means SI units,
            "uniform" a uniform distribution.
        seed: Seed of the random draws.
        draw: March nothing; write the case of this random draw at each point into the output
            folder, to run it on its own.
        until: March no more random draws of a point when the 95 % interval of the share of every
            regime excludes one half or is narrower than WIDTH, such as 0.2.
        screen: First march the random draws with scaled masses of the casing and longer time steps;
            then repeat points with an uncertain outcome at the time step of the case.
        carry: Start the march at each speed from the motion at the speed before, with rising or
            with falling speed.
        start: Motion from which each march starts. periodic: a periodic motion of the point (see
            bladewhirl periodic) with the largest impulse on the branch over the speed, or over the
            first key; DIR/branches keeps the branches. Where none is found the march starts at
            rest, and sweep.nc says so.
        resume: Finish the sweep in this folder; with a larger number of --draws or a smaller
            --until, add random draws.
        yes: Allow more than 100,000 points or long marches.
    """
    from bladewhirl.models.case.file import read_case
    from bladewhirl.studies.sweeps.axes import make_grid, parse_over
    from bladewhirl.studies.sweeps.draws import parse_draws
    from bladewhirl.studies.sweeps.plan import read_plan
    from bladewhirl.studies.sweeps.sweep import SweepFailed, Watch, resume_sweep, run_sweep
    from bladewhirl.studies.sweeps.table import point_table

    options.refuse_both(scheduler, workers)
    place = resume or output
    remedy = interruptible(f"bladewhirl sweep --resume {place} finishes it", place)
    try:
        with progress_bar("sweeping", lines="points") as update, remedy:

            def progress(done: int, failed: int, points: int) -> None:
                update(done + failed, points, text=f"{done} of {points} done", failed=failed)

            watch = Watch(planned=_print_plan, progress=progress)
            if resume is not None:
                reason = f"--resume: {resume}/sweep.json contains the input of this sweep"
                allowed = "resume scheduler workers draws until draw yes json".split()
                options.only(context, reason, *allowed, *["output"] * (draw is not None))
                if draw is not None:
                    plan = read_plan(resume)
                    _write_draw(plan.case, plan.grid, draw, output)
                    return
                result = resume_sweep(
                    resume,
                    scheduler=scheduler,
                    workers=workers,
                    draws=draws,
                    until=until,
                    watch=watch,
                )
            elif case is None or not (over or table) or output is None:
                raise UserError(
                    "sweep: expected either CASE, --over KEY=VALUES and -o DIR, or --resume DIR"
                )
            else:
                values = parse_over(over or [])
                keys = values if table is None else point_table(table).values
                option = "--over" if table is None else "--table"
                for override in overrides or []:
                    key = override.partition("=")[0].strip()
                    if key in keys:
                        raise UserError(f"--set {override}: omit it, because {option} sets {key}")
                varied = read_case(case, overrides or [])
                if draw is not None:
                    random = parse_draws(draws, perturb or (), seed, until)
                    points = None if table is None else point_table(table)
                    grid = make_grid(varied, values, large=yes, draws=random, table=points)
                    _write_draw(varied, grid, draw, output)
                    return
                result = run_sweep(
                    varied,
                    values,
                    output,
                    table=table,
                    scheduler=scheduler,
                    workers=workers,
                    histories=histories,
                    large=yes,
                    stop_when=stop_when,
                    draws=draws,
                    perturb=perturb or (),
                    seed=seed,
                    until=until,
                    screen=screen,
                    carry=carry,
                    start=start,
                    watch=watch,
                )
    except SweepFailed as error:
        result = error.sweep
    _report(result, json=json)
    if not result.done:
        raise typer.Exit(ALL_FAILED)


def _write_draw(case: Case, grid: Grid, draw: int, output: Path | None) -> None:
    """Write the cases of a random draw, and print their names and values."""
    from bladewhirl.studies.sweeps.drawn import write_drawn_cases

    if output is None:
        raise UserError(f"--draw {draw}: needs -o DIR, a new folder for the cases")
    typer.echo("\n".join(write_drawn_cases(case, grid, draw, output)))


def _report(result: Sweep, *, json: bool) -> None:
    """Print the outcome, and on standard error the failed points and the figures that could not be
    drawn."""
    from bladewhirl.studies.modal.speeds_to_avoid import COLUMNS

    title = "Speeds to avoid, of those of the sweep, and their margin from the speed of the case"
    numbers = ("points", "done", "failed", "not_needed", "screened", "marched", "wall_time")
    document: dict[str, Any] = {"directory": str(result.directory)}
    document |= {name: getattr(result, name) for name in numbers}
    document["failures"] = result.grid.failed(result.failures)
    avoided = document["speeds_to_avoid"] = _avoided(result)
    not_needed = f", {result.not_needed} random draws skipped" if result.not_needed else ""
    screened = f" ({result.screened} screened)" if result.screened else ""
    names = ", ".join(sorted(path.name for path in result.directory.iterdir()))
    emit(
        document,
        f"{result.done} of {result.points} points done{screened}, {result.failed} failed"
        f"{not_needed};"
        f" {result.marched} marched in {result.wall_time:.3g} s",
        *([table_of(avoided, COLUMNS, title)] if avoided else []),
        f"{result.directory}: {names}",
        json=json,
    )
    for point, reason in sorted(result.failures.items())[:SHOWN_FAILURES]:
        typer.echo(f"failed: {result.grid.label(point)}: {reason}", err=True)
    for name, reason in result.left_out.items():
        typer.echo(f"{name} left out: {reason}", err=True)
    if result.failed > SHOWN_FAILURES:
        typer.echo(f"failed: {result.failed - SHOWN_FAILURES} more, see failures.json", err=True)


def _avoided(result: Sweep) -> list[Any]:
    """Return the speeds to avoid; none if no point is done."""
    from bladewhirl.postprocess.sweep.avoid import speeds_to_avoid
    from bladewhirl.postprocess.sweep.dataset import open_sweep

    if not result.done:
        return []
    with open_sweep(result.directory) as dataset:
        return speeds_to_avoid(dataset)


def _print_plan(plan: SweepPlan) -> None:
    """Print hints about the case, and the size of the sweep."""
    from bladewhirl.studies.sweeps.starts import lines

    for hint in plan.hints:
        typer.echo(f"Hint: {hint}.", err=True)
    full = f", full histories {plan.history_bytes / 1e6:.3g} MB" if plan.histories else ""
    fewer = " if all are repeated after screening" if plan.screen else ""
    typer.echo(
        f"{plan.grid.size} points, {plan.steps:.3g} steps in all{fewer};"
        f" sweep.nc {plan.dataset_bytes / 1e6:.3g} MB{full}",
        err=True,
    )
    if plan.start == "periodic":
        count = sum(1 for _ in lines(plan.grid))
        typer.echo(f"branches of periodic motions that are followed first: {count}", err=True)
