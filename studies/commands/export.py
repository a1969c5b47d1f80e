"""`bladewhirl export`: a run as a series for ParaView."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from bladewhirl.models.inputs.errors import writing
from bladewhirl.studies.commands.options import (
    End,
    Replace,
    Rotating,
    RunFolder,
    Start,
    options_of_window,
    parse_window,
)
from bladewhirl.studies.commands.progress import progress_bar

VTK = "vtk"
"""Folder in that of the run where the series goes."""


def export(
    directory: RunFolder,
    frames: Annotated[int, typer.Option(min=1, help="Instants, evenly spread.")] = 300,
    start: Start = None,
    end: End = None,
    surface: Annotated[
        bool, typer.Option("--surface", help="Boxes of true thickness and width, not lines.")
    ] = False,
    rotating: Rotating = False,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help=f"Folder for the series; DIR/{VTK} if none."),
    ] = None,
    overwrite: Replace = False,
) -> None:
    """Write a series for ParaView: open series.pvd, press Apply, add Warp By Vector.

    Parts are named rotor and casing, with --surface contact too. Fields: displacement, velocity,
    radial_displacement, gap, contact_force (for Glyph), axial and bending strain and stress.
    An earlier series that bladewhirl wrote into the folder is replaced.
    """
    from bladewhirl.postprocess.fields.kinematics import frame_records, sampling_hint
    from bladewhirl.postprocess.fields.result import open_result
    from bladewhirl.postprocess.paraview.series import write_series

    window = parse_window(start, end)
    folder = output or (directory if directory.is_dir() else directory.parent) / VTK
    with options_of_window(), open_result(directory) as result:
        records = frame_records(result, frames, *window)
        with progress_bar(folder.name) as update, writing(folder):
            index = write_series(
                result,
                folder,
                records,
                rotating=rotating,
                surface=surface,
                overwrite=overwrite,
                progress=update,
            )
        first, last = result["time"].values[records[[0, -1]]]
        hint = sampling_hint(result, records)
    typer.echo(f"Wrote {index}: {len(records)} instants from {first:.6g} s to {last:.6g} s.")
    if hint:
        typer.echo(f"Hint: {hint}.", err=True)
