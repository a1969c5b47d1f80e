"""`bladewhirl run`: march a case and leave its result, summary, figures and ParaView series."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from bladewhirl.studies.commands.exits import INTERRUPTED
from bladewhirl.studies.commands.options import CaseFile, Changes, End, Rotating, Start
from bladewhirl.studies.commands.progress import progress_bar

if TYPE_CHECKING:
    from bladewhirl.studies.runs.run import Activity

RUNS = Path("runs")
"""Folder that runs go to where none is named."""


def run(
    case: CaseFile,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", "-o", metavar="DIR", help="Folder to make; runs/NAME of the case if none."
        ),
    ] = None,
    overrides: Changes = None,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Replace the run in an existing folder.")
    ] = False,
    frames: Annotated[
        int, typer.Option(help="Frames of the ParaView series; 0 for no series.")
    ] = 300,
    start: Start = None,
    end: End = None,
    rotating: Rotating = False,
    json: Annotated[
        bool, typer.Option("--json", help="Print the summary as one JSON document.")
    ] = False,
) -> None:
    """March a case in time.

    DIR gets the resolved case.toml, provenance.json, result.nc (netCDF, opens with xarray),
    summary.json, orbit.png, energy.png and vtk/series.pvd for ParaView: of all of the run, or of
    the window of --from and --to. A motion that diverges is a result as any other. Ctrl-C ends the
    march in order and keeps what was recorded.
    """
    from rich.console import Console

    from bladewhirl.models.case.file import faults_from, read_case
    from bladewhirl.studies.commands.options import parse_window
    from bladewhirl.studies.runs.run import run as run_case

    values = overrides or []
    window = parse_window(start, end)
    checked = read_case(case, values)
    step, begun = checked.march.time_step, 0.0
    with faults_from(case, values), progress_bar("preparing") as update:

        def progress(activity: Activity, done: int, total: int) -> None:
            nonlocal begun
            begun = begun or time.monotonic()
            passed = time.monotonic() - begun
            rate = f"  {done / passed:,.0f} steps/s" if passed else ""
            reached = f"{done * step:.4f} of {total * step:g} s"
            update(done, total, label=activity, told=reached + rate)

        done = run_case(
            checked,
            output or RUNS / case.stem,
            overwrite=overwrite,
            frames=frames,
            start=window[0],
            end=window[1],
            rotating=rotating,
            progress=progress,
        )
    if json:
        typer.echo(done.summary.to_json(), nl=False)
    else:
        Console().print(done)
    for line in (done.end_message, *(f"Hint: {hint}." for hint in done.hints)):
        if line:
            typer.echo(line, err=True)
    if done.end_reason == "interrupted":
        raise typer.Exit(INTERRUPTED)
