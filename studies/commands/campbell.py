"""`bladewhirl campbell`: at which speeds waves on rotor and casing coincide."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from bladewhirl.studies.commands.options import (
    AsJson,
    CaseFile,
    Changes,
    Overwrite,
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
    overwrite: Overwrite = False,
    json: AsJson = False,
    overrides: Changes = None,
) -> None:
    """Find coincidence speeds and draw Campbell diagrams, in the rotating and the static frame.

    Where k Ω = ω_casing + ω_rotor, Eq. (14), a wave that travels forward on the casing keeps pace
    with one that travels backward on the rotor, and contact feeds both. The table has the speeds
    inside --speeds; JSON has those of every nodal diameter and family. With --json and no -o
    nothing is written.
    """
    from bladewhirl.models.inputs.errors import UserError
    from bladewhirl.studies.modal import campbell as study
    from bladewhirl.studies.modal.modes import stage_of_file
    from bladewhirl.studies.runs.figures_folder import check_figure_folder

    shown = parse_speed_interval("--speeds", speeds)
    operated = parse_speed_interval("--operating", operating)
    if families < 1:
        raise UserError(f"--families {families}: expected a whole number of one or more")
    folder = output if output is not None or json else Path(f"{case.stem}-campbell")
    check_figure_folder(folder, overwrite=overwrite)
    stage = stage_of_file(case, overrides, "a Campbell diagram", "centrifugal", "full")
    reference = stage.reference_frequency
    found = study.campbell(
        stage, families=families, speeds=shown(reference), operating=operated(reference)
    )
    if folder is not None:
        study.draw_campbell(found, folder)
    if json:
        print_json(study.coincidence_list(found))
        return
    study.print_coincidences(found)
    typer.echo(f"Wrote {folder}.")
