"""`bladewhirl veering`: frequencies against nodal diameter, and against shaft stiffness."""

from pathlib import Path
from typing import Annotated

import typer

from bladewhirl.studies.commands import options
from bladewhirl.studies.commands.output import emit, facts


def veering(
    case: options.CaseFile,
    families: Annotated[
        int,
        typer.Option(
            help="Number of families in the first diagram, without the suspension pair.", min=1
        ),
    ] = 12,
    stiffnesses: options.Stiffnesses = None,
    output: options.CaseFolder = None,
    overwrite: options.Replace = False,
    json: options.AsJson = False,
    overrides: options.Changes = None,
) -> None:
    """Draw frequencies against nodal diameter and against the stiffness of the shaft.

    The first two diagrams show frequencies of the full bladed disk against nodal diameter, with a
    free and with a clamped centre: many families, and the first two families with the suspension
    pair. The third shows the modes with one nodal diameter against the stiffness of the shaft
    springs, where the character of the suspension pair passes from branch to branch. With --json
    and no -o nothing is written.
    """
    from bladewhirl.studies.modal import veering as study
    from bladewhirl.studies.modal.modes import stage_of_file

    interval = None if stiffnesses is None else stiffnesses.values()
    folder = output if output is not None or json else Path(f"{case.stem}-veering")
    stage = stage_of_file(case, overrides)
    springs = study.spring_stiffnesses(stage.case, interval)
    diagrams = study.veering(stage, families=families, stiffnesses=springs)
    if folder is not None:
        study.draw_veering(diagrams, folder, overwrite=overwrite)
    document = study.veering_document(diagrams)
    emit(document, facts(study.veering_facts(diagrams)), json=json, written=[folder])
