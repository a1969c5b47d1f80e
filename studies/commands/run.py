"""`bladewhirl run`: march a case; write its result, summary, figures and ParaView series."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from bladewhirl.models.inputs.errors import UserError
from bladewhirl.studies.commands import options
from bladewhirl.studies.commands.exits import INTERRUPTED
from bladewhirl.studies.commands.progress import progress_bar, reduction_bar

if TYPE_CHECKING:
    from bladewhirl.studies.runs.recorded_march import Activity

RUNS = Path("runs")
"""Default folder of runs."""


def run(
    case: Annotated[
        Path | None, typer.Argument(help="Case file; not with --resume.", show_default=False)
    ] = None,
    output: Annotated[
        Path | None, options.output("Folder to make; by default runs/NAME of the case.", "DIR")
    ] = None,
    overrides: options.Changes = None,
    overwrite: options.Overwrite = False,
    frames: Annotated[
        int, typer.Option(help="Number of frames of the ParaView series; 0 for no series.")
    ] = 300,
    start: options.Start = None,
    end: options.End = None,
    rotating: options.Rotating = False,
    resume: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            help="Continue the run in this folder; --set march.duration=6 makes it longer.",
        ),
    ] = None,
    json: options.AsJson = False,
) -> None:
    """March a case in time.

    DIR then contains the resolved case.toml, provenance.json, result.nc (netCDF, opens with
    xarray), summary.json, and orbit.png, energy.png and vtk/series.pvd for ParaView, which show the
    complete run or the window of --from and --to. A divergent motion is a valid result. Ctrl-C ends
    the march and keeps its records; --resume DIR finishes a run that was killed, or stopped by a
    full disk, with bitwise the same result. --overwrite replaces the old run when the new one is
    finished.
    """
    from rich.console import Console

    from bladewhirl.models.case.file import faults_from, read_case
    from bladewhirl.studies.runs.folder import CASE_NAME
    from bladewhirl.studies.runs.run import resume as resume_run
    from bladewhirl.studies.runs.run import run as run_case

    values = overrides or []
    if (case is None) == (resume is None):
        raise UserError("run: expected either CASE or --resume DIR")
    if resume is not None and (output is not None or overwrite or (start, end) != (None, None)):
        raise UserError(
            f"--resume {resume}: omit --output, --overwrite, --from and --to of a new run"
        )
    source = case or (resume or Path()) / CASE_NAME
    step, begun = read_case(source, values).march.time_step, 0.0
    with faults_from(source, values), progress_bar("preparing") as update, reduction_bar():

        def progress(activity: Activity, done: int, total: int) -> None:
            nonlocal begun
            begun = begun or time.monotonic()
            passed = time.monotonic() - begun
            rate = f"  {done / passed:,.0f} steps/s" if passed else ""
            reached = f"{done * step:.4f} of {total * step:g} s"
            update(done, total, label=activity, text=reached + rate)

        if resume is not None:
            finished = resume_run(
                resume, values, frames=frames, rotating=rotating, progress=progress
            )
        else:
            finished = run_case(
                read_case(source, values),
                output or RUNS / source.stem,
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
    for line in (finished.end_message, *(f"Hint: {hint}." for hint in finished.hints)):
        if line:
            typer.echo(line, err=True)
    if finished.end_reason == "interrupted":
        raise typer.Exit(INTERRUPTED)
