"""`bladewhirl run`: march a case and leave its result, summary, figures and ParaView series."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from rich.console import Console

    from bladewhirl.studies.runs.run import Activity, Progress, Run

RUNS = Path("runs")
"""Folder that runs go to where none is named."""

EXIT_INTERRUPTED = 130
"""Exit code of an interrupted run, that of the shell for Ctrl-C."""


def run(
    case: Annotated[Path, typer.Argument(help="Case file.")],
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", "-o", metavar="DIR", help="Folder to make; runs/NAME of the case if none."
        ),
    ] = None,
    overrides: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="KEY=VALUE", help="Change the case, march.speed=1.2."),
    ] = None,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Replace the run in an existing folder.")
    ] = False,
    frames: Annotated[
        int, typer.Option(help="Frames of the ParaView series; 0 for no series.")
    ] = 300,
    start: Annotated[
        str | None,
        typer.Option(
            "--from", help='Start of the series: seconds, or "0.8 ms"; of the run if none.'
        ),
    ] = None,
    end: Annotated[str | None, typer.Option("--to", help="End of the series.")] = None,
    rotating: Annotated[
        bool, typer.Option("--rotating", help="Show the series as seen from the rotor.")
    ] = False,
    json: Annotated[
        bool, typer.Option("--json", help="Print the summary as one JSON document.")
    ] = False,
) -> None:
    """March a case in time.

    DIR gets the resolved case.toml, provenance.json, result.nc (netCDF, opens with xarray),
    summary.json, orbit.png, energy.png and vtk/series.pvd for ParaView. A motion that diverges is
    a result as any other. Ctrl-C ends the march in order and keeps what was recorded.
    """
    from rich.console import Console

    from bladewhirl.models.case.file import faults_from, read_case
    from bladewhirl.studies.commands.times import parse_time
    from bladewhirl.studies.runs.run import run as run_case

    values = overrides or []
    window = (parse_time("--from", start), parse_time("--to", end))
    checked = read_case(case, values)
    errors = Console(stderr=True)
    steps = checked.march.steps
    with (
        faults_from(case, values),
        _progress_bar(errors, steps, checked.march.time_step) as progress,
    ):
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
        _print(done)
    for line in (done.end_message, *(f"Hint: {hint}." for hint in done.hints)):
        if line:
            typer.echo(line, err=True)
    if done.end_reason == "interrupted":
        raise typer.Exit(EXIT_INTERRUPTED)


def _print(done: Run) -> None:
    """What came out, to read."""
    from rich.console import Console

    from bladewhirl.postprocess.run.summary import summary_table

    console = Console()
    console.print(summary_table(done.summary))
    console.print(done.symmetry, markup=False, highlight=False)
    names = ", ".join(sorted(path.name for path in done.directory.iterdir()))
    console.print(f"{done.directory}: {names}", markup=False, highlight=False)


@contextmanager
def _progress_bar(console: Console, steps: int, time_step: float) -> Iterator[Progress]:
    """Simulated time, steps per second and time left, on a terminal."""
    from rich import progress as bars

    duration = steps * time_step
    with bars.Progress(
        bars.TextColumn("{task.fields[stage]}"),
        bars.BarColumn(),
        bars.TextColumn("{task.fields[reached]:.4f} of {task.fields[duration]:g} s"),
        bars.TextColumn("{task.fields[rate]}"),
        bars.TimeRemainingColumn(),
        bars.TextColumn("left"),
        console=console,
        transient=True,
        disable=not console.is_terminal,
    ) as bar:
        task = bar.add_task(
            "", total=steps, stage="preparing", reached=0.0, duration=duration, rate=""
        )

        def progress(activity: Activity, done: int, total: int) -> None:
            speed = bar.tasks[task].speed
            bar.update(
                task,
                completed=done,
                stage=activity,
                reached=done * time_step,
                rate=f"{speed:,.0f} steps/s" if speed else "",
            )

        yield progress
