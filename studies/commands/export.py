"""`bladewhirl export`: a run as a series for ParaView."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

VTK = "vtk"
"""Folder in that of the run where the series goes."""


def export(
    directory: Annotated[
        Path, typer.Argument(metavar="DIR", help="Folder of a run, or its result.nc.")
    ],
    frames: Annotated[int, typer.Option(min=1, help="Instants, evenly spread.")] = 300,
    start: Annotated[
        str | None,
        typer.Option(
            "--from", help='Start of the series: seconds, or "0.8 ms"; of the run if none.'
        ),
    ] = None,
    end: Annotated[str | None, typer.Option("--to", help="End of the series.")] = None,
    surface: Annotated[
        bool, typer.Option("--surface", help="Boxes of true thickness and width, not lines.")
    ] = False,
    rotating: Annotated[
        bool, typer.Option("--rotating", help="Show the series as seen from the rotor.")
    ] = False,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help=f"Folder for the series; DIR/{VTK} if none."),
    ] = None,
) -> None:
    """Write a series for ParaView: open series.pvd, press Apply, add Warp By Vector.

    Parts are named rotor and casing, with --surface contact too. Fields: displacement, velocity,
    radial_displacement, gap, contact_force (for Glyph), axial and bending strain and stress.
    An earlier series in the folder is replaced.
    """
    from rich.console import Console
    from rich.progress import Progress

    from bladewhirl.models.inputs.errors import UserError
    from bladewhirl.postprocess.fields.fields import frame_records, sampling_hint
    from bladewhirl.postprocess.fields.result import open_result
    from bladewhirl.postprocess.paraview.series import export_vtk
    from bladewhirl.studies.commands.times import options_of_window, parse_time

    window = (parse_time("--from", start), parse_time("--to", end))
    folder = output or (directory if directory.is_dir() else directory.parent) / VTK
    console = Console(stderr=True)
    with options_of_window(), open_result(directory) as result:
        records = frame_records(result, frames, *window)
        with Progress(console=console, transient=True, disable=not console.is_terminal) as bar:
            task = bar.add_task(folder.name, total=len(records))
            try:
                index = export_vtk(
                    result,
                    folder,
                    frames=frames,
                    start=window[0],
                    end=window[1],
                    rotating=rotating,
                    surface=surface,
                    progress=lambda done, total: bar.update(task, completed=done, total=total),
                )
            except OSError as error:
                raise UserError(f"{folder}: cannot be written ({error.strerror})") from None
        first, last = result["time"].values[records[[0, -1]]]
        hint = sampling_hint(result, records)
    typer.echo(f"Wrote {index}: {len(records)} instants from {first:.6g} s to {last:.6g} s.")
    if hint:
        typer.echo(f"Hint: {hint}.", err=True)
