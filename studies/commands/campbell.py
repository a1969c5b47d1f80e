"""`bladewhirl campbell`: speeds at which waves on rotor and casing coincide."""

from pathlib import Path
from typing import Annotated, Any

import typer

from bladewhirl.studies.commands import options
from bladewhirl.studies.commands.output import emit, facts, table
from bladewhirl.studies.modal.columns import Column, texts

SPEEDS: Any = "0:3"
OPERATING: Any = "0.6:2"

SPECIAL_SPEEDS = (
    Column("waves_meet", "two waves merge and grow without contact from", ".6g"),
    Column("clearance_gone", "tip growth equals the clearance at rest at", ".6g"),
)


def campbell(
    case: options.CaseFile,
    speeds: Annotated[
        options.Span,
        options.span(
            "--speeds", 'Speeds of the diagrams: multiples of ω₁, or "2000 rpm:9000 rpm".'
        ),
    ] = SPEEDS,
    operating: Annotated[
        options.Span,
        options.span("--operating", 'Operating range to shade: multiples of ω₁, or "40 Hz:60 Hz".'),
    ] = OPERATING,
    families: Annotated[
        int,
        typer.Option(
            help="Number of families of the bladed disk, without the suspension pair.", min=1
        ),
    ] = 5,
    output: options.CaseFolder = None,
    html: Annotated[
        Path | None,
        typer.Option(help="Write both diagrams as an interactive page, FILE.html.", metavar="FILE"),
    ] = None,
    overwrite: options.Replace = False,
    json: options.AsJson = False,
    overrides: options.Changes = None,
) -> None:
    """Find coincidence speeds, and draw a Campbell diagram in the rotating and one in the static
    frame.

    Where k Ω = ω_casing + ω_rotor, Eq. (14), a forward wave on the casing and a backward wave on
    the rotor travel at the same speed in space, and contact amplifies both waves. The table lists
    the coincidence speeds inside --speeds; JSON lists all coincidence speeds, for every nodal
    diameter and family. With --json or --html a folder is made only if -o names it.
    """
    from bladewhirl.postprocess.plotting.files import checked_target
    from bladewhirl.studies.modal import campbell as study
    from bladewhirl.studies.modal.modes import stage_of_file

    folder = output if output or html or json else Path(f"{case.stem}-campbell")
    if html is not None:
        checked_target(html, ".html")
    stage = stage_of_file(case, overrides)
    reference = stage.reference_frequency
    first, last = speeds.values(reference).tolist()
    diagram = study.campbell(
        stage,
        families=families,
        speeds=(first, last),
        operating=tuple(operating.values(reference).tolist()),
    )
    if folder is not None:
        study.draw_campbell(diagram, folder, overwrite=overwrite)
    if html is not None:
        study.write_campbell_page(diagram, html, overwrite=overwrite)
    document = study.coincidence_list(diagram)
    rows = [row for row in document["coincidences"] if first <= row["speed"] <= last]
    title = f"Coincidence speeds from {first:g} to {last:g} ω₁"
    parts = [table(rows, study.COINCIDENCES, title)]
    if "critical_speeds" in document:
        title = f"Critical speeds up to {last:g} ω₁"
        parts.append(table(document["critical_speeds"], study.CRITICAL_SPEEDS, title))
        parts.append(facts(texts(document, SPECIAL_SPEEDS)))
    emit(document, *parts, json=json, written=[folder, html])
