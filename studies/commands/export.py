"""`bladewhirl export`: a run as a series for ParaView."""

from pathlib import Path
from typing import Annotated

import typer

from bladewhirl.models.inputs.errors import UserError, writing
from bladewhirl.studies.commands import options
from bladewhirl.studies.commands.progress import progress_bar

VTK = "vtk"
"""Name of the folder of the series in the folder of the run."""


def export(
    directory: options.RunFolder,
    frames: Annotated[int, typer.Option(min=1, help="Number of instants, evenly spaced.")] = 300,
    start: options.Start = None,
    end: options.End = None,
    surface: Annotated[
        bool,
        typer.Option("--surface", help="Write boxes of true thickness and width instead of lines."),
    ] = False,
    rotating: options.Rotating = False,
    exaggeration: Annotated[
        float | None,
        typer.Option(
            help="Factor on displacement and clearance in the field warp; automatic by default."
        ),
    ] = None,
    output: Annotated[
        Path | None, options.output(f"Folder to write; by default DIR/{VTK}.")
    ] = None,
    overwrite: options.Replace = False,
) -> None:
    """Write a series for ParaView: run its view.py, or open series.pvd and apply Warp By Vector.

    The parts are rotor, casing, contact, supports. Warp By Vector with warp and factor 1 shows the
    stage as bladewhirl render does. For a superelement the parts are blades and contact, with
    displacement and force. Fields: displacement, velocity, radial_displacement, gap, axial
    and bending strain and stress; part, blade, thickness; contact_force (for Glyph).
    An earlier series that bladewhirl wrote into the folder is replaced.
    """
    from bladewhirl.postprocess.fields.kinematics import sampling_hint
    from bladewhirl.postprocess.fields.result import open_result
    from bladewhirl.postprocess.paraview.series import export_vtk, series_records
    from bladewhirl.postprocess.superelement.series import export_points
    from bladewhirl.solvers.march.schema import NODES, tables_of

    folder = output or (directory if directory.is_dir() else directory.parent) / VTK
    with open_result(directory) as result:
        if tables_of(result.attrs) is NODES:
            if surface or exaggeration is not None:
                raise UserError("--surface, --exaggeration: not allowed for a superelement")
            with writing(folder):
                index = export_points(
                    result,
                    folder,
                    frames=frames,
                    start=start,
                    end=end,
                    rotating=rotating,
                    overwrite=overwrite,
                )
            typer.echo(f"Wrote {index}.")
            return
        records = series_records(result, frames, start, end)
        with progress_bar(folder.name) as update, writing(folder):
            index = export_vtk(
                result,
                folder,
                records=records,
                rotating=rotating,
                surface=surface,
                exaggeration=exaggeration,
                overwrite=overwrite,
                progress=update,
            )
        first, last = result["time"].values[records[[0, -1]]]
        hint = sampling_hint(result, records)
    typer.echo(f"Wrote {index}: {len(records)} instants from {first:.6g} s to {last:.6g} s.")
    if hint:
        typer.echo(f"Hint: {hint}.", err=True)
