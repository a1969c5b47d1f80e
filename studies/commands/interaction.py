"""`bladewhirl interaction`: interaction map of a superelement against the speed."""

from pathlib import Path
from typing import Annotated, Any

import typer

from bladewhirl.studies.commands import options
from bladewhirl.studies.commands.output import emit, table
from bladewhirl.studies.commands.progress import progress_bar, reduction_bar
from bladewhirl.studies.modal.columns import Column, rows_of

SPEEDS: Any = "0.1:1:91"

ROWS = (
    Column("rpm", "[rpm]", ".1f"),
    Column("contact_impulse", "impulse [N s]", ".4g"),
    Column("contact_force_max", "force [N]", ".4g"),
    Column("radial", "radial", ".4g", 1e3),
    Column("tangential", "tangential", ".4g", 1e3),
    Column("axial", "axial", ".4g", 1e3),
    Column("divergent", "divergent"),
)
"""Columns of the speeds with the largest impulses."""

SHOWN = 10
"""Number of speeds in the table."""


def interaction(
    case: options.CaseFile,
    speeds: Annotated[
        options.Span,
        options.span(
            "--speeds",
            'Speeds of rotation: multiples of the lowest natural frequency, or "2000 rpm:9000 rpm'
            ':600".',
            counted=True,
        ),
    ] = SPEEDS,
    turns: Annotated[int, typer.Option(help="Revolutions at each speed.", min=2)] = 50,
    steps: Annotated[
        int | None,
        typer.Option(help="Time steps in a revolution; by default those of march.time_step."),
    ] = None,
    node: Annotated[int, typer.Option(help="Contact node of the spectra.", min=0)] = 0,
    workers: Annotated[
        int | None, typer.Option(help="Number of threads; all processors by default.", min=1)
    ] = None,
    output: options.CaseFolder = None,
    overwrite: options.Replace = False,
    json: options.AsJson = False,
    overrides: options.Changes = None,
) -> None:
    """March a superelement at many speeds and draw impulse, displacements and spectra.

    Each march begins at rest and lasts the given number of revolutions; the second half counts. The
    table lists the speeds with the largest impulses. march.speed and march.duration of the case are
    not used. With --json and no -o nothing is written.
    """
    import numpy as np

    from bladewhirl.models.case.file import faults_from, read_case
    from bladewhirl.models.stage.superelement_stage import superelement_stage
    from bladewhirl.postprocess.superelement.interaction import plot_interaction
    from bladewhirl.studies.runs.figures_folder import save_figures
    from bladewhirl.studies.sweeps.interaction import interaction_map

    folder = output if output is not None or json else Path(f"{case.stem}-interaction")
    values = overrides or []
    read = read_case(case, values)
    with faults_from(case, values), progress_bar("speeds", lines="speeds") as update:
        reference = 1.0
        if read.bladed_disk.superelement is not None:
            with reduction_bar():
                reference = superelement_stage(read).reference_frequency
        data = interaction_map(
            read,
            speeds.values(reference).tolist(),
            turns=turns,
            steps_per_turn=steps,
            node=node,
            workers=workers,
            progress=lambda done, total: update(done, total),
        )
    rpm = data["speed"] * 30.0 / np.pi
    numbers = data.drop_dims("line").assign(rpm=rpm)
    largest = np.argsort(-data["contact_impulse"].values)[:SHOWN]
    document = {"speeds": rows_of(numbers, (*ROWS, Column("contact_share"), Column("turns")))}
    if folder is not None:
        figures = {"interaction": (plot_interaction(data), data)}
        save_figures(folder, figures, overwrite=overwrite)
    rows = rows_of(numbers.isel(speed=np.sort(largest)), ROWS)
    title = "Speeds with the largest impulses per revolution; largest displacements [mm]"
    emit(document, table(rows, ROWS, title), json=json, written=[folder])
