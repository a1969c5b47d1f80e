"""`bladewhirl veering`: frequencies over nodal diameter, and over the stiffness of the shaft."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from bladewhirl.studies.commands.options import (
    AsJson,
    CaseFile,
    CaseFolder,
    Changes,
    Replace,
    Span,
    span_option,
)
from bladewhirl.studies.commands.output import emit, facts


def veering(
    case: CaseFile,
    families: Annotated[
        int,
        typer.Option(
            help="Number of families in the first diagram, without the suspension pair.", min=1
        ),
    ] = 12,
    stiffnesses: Annotated[
        Span | None,
        span_option(
            "--stiffnesses",
            "Stiffness of each shaft spring, N/m or '1 kN/mm:1 MN/mm'; by default a thousandth"
            " to a thousand times that of the case.",
            unit="N/m",
        ),
    ] = None,
    output: CaseFolder = None,
    overwrite: Replace = False,
    json: AsJson = False,
    overrides: Changes = None,
) -> None:
    """Draw frequencies over nodal diameter and over the stiffness of the shaft.

    The first two diagrams show frequencies of the full bladed disk over nodal diameter, with a free
    and with a clamped centre: many families, and the first two families with the suspension pair.
    The third shows the modes with one nodal diameter over the stiffness of the shaft springs, where
    the character of the suspension pair passes from branch to branch. With --json and no -o nothing
    is written.
    """
    from bladewhirl.models.inputs.errors import UserError
    from bladewhirl.studies.modal import veering as study
    from bladewhirl.studies.modal.modes import stage_of_file

    interval = None if stiffnesses is None else tuple(stiffnesses.values().tolist())
    if interval is not None and not interval[0] > 0.0:
        raise UserError(f"--stiffnesses {interval[0]:g}: expected a START above zero")
    folder = output if output is not None or json else Path(f"{case.stem}-veering")
    stage = stage_of_file(case, overrides)
    springs = study.spring_stiffnesses(stage.case, interval)
    diagrams = study.veering(stage, families=families, stiffnesses=springs)
    if folder is not None:
        study.draw_veering(diagrams, folder, overwrite=overwrite)
    document = study.veering_document(diagrams)
    emit(document, facts(study.veering_facts(diagrams)), json=json, written=[folder])
