"""`bladewhirl modes`: natural frequencies by nodal diameter and family, and how modes look."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from bladewhirl.studies.commands.options import AsJson, CaseFile, Changes, Replace, print_json


def modes(
    case: CaseFile,
    count: Annotated[int, typer.Option(help="How many of the lowest modes of each body.")] = 60,
    json: AsJson = False,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Folder to make for pictures and films.")
    ] = None,
    shapes: Annotated[
        str | None,
        typer.Option(
            metavar="NAMES",
            help='Modes to picture: "1F:0,1F:1,suspension,casing:1F:2"; without ":k", of all nodal'
            " diameters. Where blades differ, every mode of that name. By default k = 0, 1, ... and"
            " the highest of 1F, the suspension, and the lowest of the casing.",
        ),
    ] = None,
    animate: Annotated[
        str | None,
        typer.Option(
            metavar="NAMES", help="Modes to film. By default 1F:1, and suspension if there is one."
        ),
    ] = None,
    wave: Annotated[
        str | None,
        typer.Option(
            help="What films show: standing, forward or backward. By default the wave that"
            " contact feeds: backward on the bladed disk, forward on the casing."
        ),
    ] = None,
    films: Annotated[bool, typer.Option(help="Films, as GIF and VTK series.")] = True,
    overwrite: Replace = False,
    overrides: Changes = None,
) -> None:
    """List natural frequencies of the full bladed disk, its centre as in the case, and casing.

    Normalised frequencies are multiples of the lowest one with a free centre, ω₁. Purity is the
    share of a mode that its nodal diameter holds: 1 where blades are alike. With -o: mode shapes,
    contact scenarios of the first k = 1 mode at the speed at which it coincides with the casing's,
    and films with a picture of each travelling wave; with Coriolis forces of waves as they travel
    at speed. With --json and no -o nothing is written.
    """
    from bladewhirl.models.inputs.errors import UserError
    from bladewhirl.studies.modal import modes as study
    from bladewhirl.studies.modal.mode_pictures import draw_modes, plan_pictures

    if count < 1:
        raise UserError(f"--count {count}: expected a whole number of one or more")
    given = {"--shapes": shapes, "--animate": animate, "--wave": wave}
    unused = [name for name, value in given.items() if value is not None]
    if output is None and unused:
        raise UserError(f"{unused[0]}: for pictures; expected a folder for them, -o DIR")
    stage = study.stage_of_file(case, overrides, "modes", "centrifugal", "full")
    if output is not None:
        plan = plan_pictures(stage, shapes=shapes, animate=animate if films else "", wave=wave)
    found = study.modes(stage)
    if json:
        print_json(study.mode_lists(found, count))
    else:
        study.print_modes(found, count)
    if output is not None:
        draw_modes(stage, plan, output, overwrite=overwrite)
        typer.echo(f"Wrote {output}.", err=json)
