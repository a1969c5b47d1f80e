"""Commands that march a case: once, or with several time steps or modes."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from bladewhirl.models.inputs.errors import UserError
from bladewhirl.studies.commands import options
from bladewhirl.studies.commands.terminal import (
    INTERRUPTED,
    emit,
    hints_at_once,
    interruptible,
    progress_bar,
)
from bladewhirl.studies.runs.columns import Column, facts, rows_of, table

if TYPE_CHECKING:
    from bladewhirl.studies.runs.recorded_march import Activity

RUNS = Path("runs")  #: default folder of runs

TIME_STEP, MODES = Column("time_step", "Δt [µs]", ".4g", 1e6), Column("modes", "modes", "d")
REFINEMENT = (
    Column("regime", "regime"),
    Column("radius_max", "largest [mm]", ".5g", 1e3),
    Column("contact_impulse", "impulse [N s]", ".5g"),
    Column("distance", "motion [%]", ".3g", 100.0),
    Column("impulse_error", "impulse [%]", ".3g", 100.0),
)
"""Columns of the tables of `convergence`; the last two are differences from the finest march."""

ORDERS = (
    Column("time_steps.free_until", "first contact [ms]", ".4g", 1e3),
    Column("time_steps.free_order", "order in the time step, before contact", ".3g"),
    Column("time_steps.displacement_order", "order in the time step, displacement", ".3g"),
    Column("time_steps.impulse_order", "order in the time step, contact impulse", ".3g"),
    Column("modes.motion_converged", "same regime with all numbers of modes (1: yes)", "d"),
)
"""Labels of the orders of convergence. A dash stands for an order that cannot be computed, because
there are too few differences, or because the differences are not monotone."""


def run(
    context: typer.Context,
    case: options.NewCase = None,
    output: options.OutputFolder = None,
    overrides: options.Changes = None,
    overwrite: options.Overwrite = False,
    frames: int = 300,
    start: options.Start = None,
    end: options.End = None,
    rotating: options.Rotating = False,
    resume: options.Resume = None,
    json: options.AsJson = False,
) -> None:
    """March a case in time.

    DIR then contains the resolved case.toml, provenance.json, result.nc (netCDF, opens with
    xarray), summary.json, and orbit.png, energy.png and vtk/series.pvd for ParaView, which show the
    complete run or the window of --from and --to. A divergent motion is a valid result. Ctrl-C ends
    the march and keeps its records; --resume DIR finishes a run that was killed, or stopped by a
    full disk, with bitwise the same result. --overwrite replaces the old run when the new one is
    finished.

    Args:
        output: Folder to make; by default runs/NAME of the case.
        frames: Number of frames of the ParaView series; 0 for no series.
        resume: Continue the run in this folder; --set march.duration=6 makes it longer.
    """
    from rich.console import Console

    from bladewhirl.solvers.march.schema import RESULT_NAME
    from bladewhirl.studies.runs.folder import CASE_NAME

    if (case is None) == (resume is None):
        raise UserError("run: expected either CASE or --resume DIR")
    if resume is not None:
        options.only(context, "--resume", "resume", "overrides", "frames", "rotating", "json")
    source = case or (resume or Path()) / CASE_NAME
    folder = resume or output or RUNS / source.stem
    with (
        options.case_of(source, overrides) as read,
        progress_bar("preparing") as update,
        hints_at_once() as shown,
        interruptible(f"bladewhirl run --resume {folder} continues", folder / RESULT_NAME),
    ):
        from bladewhirl.studies.runs.run import resume as resume_run
        from bladewhirl.studies.runs.run import run as run_case

        turn = read.march.steps_per_revolution
        step, unit = (1.0 / turn, "revolutions") if turn else (read.march.time_step, "s")
        begun = 0.0

        def progress(activity: Activity, done: int, total: int) -> None:
            nonlocal begun
            begun = begun or time.monotonic()
            passed = time.monotonic() - begun
            rate = f"  {done / passed:,.0f} steps/s" if passed > 1.0 else ""
            reached = f"{done * step:.4f} of {total * step:g} {unit}"
            update(done, total, label=activity, text=reached + rate)

        if resume is not None:
            finished = resume_run(
                resume, overrides or [], frames=frames, rotating=rotating, progress=progress
            )
        else:
            finished = run_case(
                read,
                folder,
                overwrite=overwrite,
                frames=frames,
                start=start,
                end=end,
                rotating=rotating,
                progress=progress,
            )
    if json:
        typer.echo(finished.summary.to_json(), nl=False)
    else:
        Console().print(finished)
    stopped = finished.end_reason == "interrupted"
    remedy = f"bladewhirl run --resume {finished.directory} finishes the run" if stopped else ""
    hints = (f"Hint: {hint}." for hint in finished.hints if hint not in shown)
    for line in (finished.end_message, *hints, remedy):
        if line:
            typer.echo(line, err=True)
    if stopped:
        raise typer.Exit(INTERRUPTED)


def convergence(
    case: options.CaseFile,
    time_steps: Annotated[
        Sequence[float] | None,
        options.several("--time-steps", "STEP,STEP,...", options.in_si("s"), "times"),
    ] = None,
    modes: Annotated[
        Sequence[int] | None, options.several("--modes", "COUNT,COUNT,...", int, "whole numbers")
    ] = None,
    output: options.CaseFolder = None,
    overwrite: options.Overwrite = False,
    workers: options.Workers = None,
    json: options.AsJson = False,
    overrides: options.Changes = None,
) -> None:
    """Study how a march depends on its time step and on its modes.

    The case is marched with several time steps, then with several numbers of modes: those of beams
    with a fixed interface, of a superelement, or of a shaft line. The output lists differences of
    motion and contact impulse from the finest march, the orders of convergence, and the regimes, as
    in Section 4.2 of the paper. Figures with their data, convergence.json and the marches are
    written into DIR.

    Args:
        time_steps: Time steps in s or with a unit; by default 4, 2, 1, 1/2 times that of the case.
        modes: Numbers of modes; by default 0.4 to 1.2 times that of the case.
    """
    from bladewhirl.studies.convergence.study import convergence as study

    folder = output or Path(f"{case.stem}-convergence")
    with (
        options.case_of(case, overrides) as read,
        progress_bar("marches", lines="marches") as update,
    ):
        result = study(
            read,
            folder,
            time_steps=time_steps and time_steps[::-1],
            modes=modes,
            overwrite=overwrite,
            workers=workers,
            progress=update,
        )
    document = result.as_json()
    tables = [
        table(rows_of(data, columns), columns, title)
        for data, columns, title in (
            (result.time_steps, (TIME_STEP, *REFINEMENT), "Refinement of the time step"),
            (result.modes, (MODES, *REFINEMENT), "Refinement of the modes"),
        )
    ]
    orders = {column.heading: column.text(document) for column in ORDERS}
    emit(document, *tables, facts(orders), json=json, written=[folder])
