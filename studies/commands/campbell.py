"""`bladewhirl campbell`: at which speeds waves on rotor and casing coincide."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from bladewhirl.studies.commands.options import (
    AsJson,
    CaseFile,
    Changes,
    Replace,
    parse_speed_interval,
    print_json,
)


def campbell(
    case: CaseFile,
    speeds: Annotated[
        str,
        typer.Option(
            metavar="START:STOP", help='Speeds of the diagrams: times ω₁, or "2000 rpm:9000 rpm".'
        ),
    ] = "0:3",
    operating: Annotated[
        str,
        typer.Option(
            metavar="START:STOP", help='Operating range to shade: times ω₁, or "40 Hz:60 Hz".'
        ),
    ] = "0.6:2",
    families: Annotated[
        int, typer.Option(help="Families of the bladed disk, the suspension pair apart.")
    ] = 5,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="Folder to make; CASE-campbell by default."),
    ] = None,
    html: Annotated[
        Path | None,
        typer.Option(
            help="Page to write with both diagrams to point at, FILE.html.", metavar="FILE"
        ),
    ] = None,
    overwrite: Replace = False,
    json: AsJson = False,
    overrides: Changes = None,
) -> None:
    """Find coincidence speeds and draw Campbell diagrams, in the rotating and the static frame.

    Where k Ω = ω_casing + ω_rotor, Eq. (14), a wave that travels forward on the casing keeps pace
    with one that travels backward on the rotor, and contact feeds both. The table has the speeds
    inside --speeds; JSON has those of every nodal diameter and family. With --json or --html the
    folder is made only if -o names one.
    """
    from bladewhirl.models.inputs.errors import UserError
    from bladewhirl.postprocess.plotting.files import checked_target
    from bladewhirl.studies.modal import campbell as study
    from bladewhirl.studies.modal.modes import stage_of_file

    shown = parse_speed_interval("--speeds", speeds)
    operated = parse_speed_interval("--operating", operating)
    if families < 1:
        raise UserError(f"--families {families}: expected a whole number of one or more")
    folder = output
    if output is None and html is None and not json:
        folder = Path(f"{case.stem}-campbell")
    if html is not None:
        checked_target(html, ".html")
    stage = stage_of_file(case, overrides, "a Campbell diagram", "centrifugal", "full")
    reference = stage.reference_frequency
    found = study.campbell(
        stage, families=families, speeds=shown(reference), operating=operated(reference)
    )
    if folder is not None:
        study.draw_campbell(found, folder, overwrite=overwrite)
    if html is not None:
        study.write_campbell_page(found, html, overwrite=overwrite)
    if json:
        print_json(study.coincidence_list(found))
        return
    study.print_coincidences(found)
    for written in filter(None, (folder, html)):
        typer.echo(f"Wrote {written}.")
