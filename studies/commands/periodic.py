"""Command that computes periodic motions without time integration."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from bladewhirl.models.inputs.errors import UserError
from bladewhirl.studies.commands import options
from bladewhirl.studies.commands.modal import present
from bladewhirl.studies.commands.terminal import progress_bar


def periodic(
    case: options.CaseFile,
    speeds: Annotated[Any, options.speeds("--speeds")] = None,
    blade: Annotated[int, typer.Option(min=0)] = 0,
    output: options.CaseFolder = None,
    overwrite: options.Replace = False,
    json: options.AsJson = False,
    overrides: options.Changes = None,
) -> None:
    """Compute periodic motions of a 3D blade that rubs on a rigid wall, without time integration.

    The motion has the period of the wall and of engine orders, a turn divided by their common
    number of lobes. The table lists its stability: a multiplier is the factor by which a small
    deviation grows in a period; the motion is stable if all are less than 1 in magnitude. There can
    be more than one periodic motion, and the one that is found is not always that of a march from
    rest. A speed without contact, or at which no motion is found, is reported after the others, and
    the exit code is 2. The case needs a superelement of the kind "blade" with massless contact
    nodes in a rigid wall. With --json and no -o nothing is written.

    Args:
        speeds: Speeds of rotation: multiples of ω₁, or such as "5000 rpm,5200 rpm"; by default the
            speed of the case.
        blade: Number of the blade; blades do not influence each other.
    """
    from bladewhirl.studies.periodic import motions as study

    with options.case_of(case, overrides) as read, progress_bar("speeds") as progress:
        given = None if speeds is None else [each.given for each in speeds]
        data = study.periodic(read, speeds=given, blade=blade, progress=progress)
    present(study.report(data), case, output, overwrite=overwrite, json=json)
    if failures := study.failures(data):
        raise UserError(*failures)
