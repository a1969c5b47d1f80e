"""`bladewhirl modes`: natural frequencies by nodal diameter and family, and mode shapes."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from bladewhirl.models.inputs.errors import UserError
from bladewhirl.studies.commands import options
from bladewhirl.studies.commands.output import emit, table
from bladewhirl.studies.commands.progress import reduction_bar
from bladewhirl.studies.modal.columns import rows_of

if TYPE_CHECKING:
    from rich.table import Table


def modes(
    case: options.CaseFile,
    count: Annotated[
        int,
        typer.Option(
            help="Number of modes of each body, from the lowest on; a pair of equal frequencies"
            " has one row.",
            min=1,
        ),
    ] = 60,
    json: options.AsJson = False,
    output: Annotated[Path | None, options.output("Folder to make for pictures and films.")] = None,
    shapes: Annotated[
        str | None,
        typer.Option(
            metavar="NAMES",
            help='Modes to draw: "1F:0,1F:1,suspension,casing:1F:2"; without ":k", all nodal'
            " diameters. Where blades differ, all modes of a name are drawn. By default 1F with"
            " k = 0, 1, ... and the highest k, the suspension, and the lowest modes of the casing.",
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
            help="Wave of films: standing, forward or backward. By default the wave that"
            " contact amplifies: backward on the bladed disk, forward on the casing."
        ),
    ] = None,
    films: Annotated[bool, typer.Option(help="Write films, as GIF and as VTK series.")] = True,
    overwrite: options.Replace = False,
    overrides: options.Changes = None,
) -> None:
    """List natural frequencies of the full bladed disk, with the centre as in the case, and of the
    casing.

    Normalised frequencies are multiples of the lowest frequency with a free centre, ω₁. The column
    "springs" is the share of the shaft springs in the strain energy. Purity is the share of the
    listed nodal diameter in a mode; it is not shown if all blades are equal, because it is 1. At
    speed, the branch with most of its strain energy in the shaft springs is the suspension; the
    column "at rest" gives the name of the same branch at rest. -o DIR writes
    pictures of mode shapes; contact scenarios of the first k = 1 mode at the speed at which it
    coincides with the k = 1 mode of the casing; and films, with a picture of each travelling wave.
    With Coriolis forces, pictures and films show the waves at the speed of the case.
    """
    from bladewhirl.models.case.file import faults_from, read_case
    from bladewhirl.studies.modal import modes as study
    from bladewhirl.studies.modal.mode_pictures import draw_modes, plan_pictures
    from bladewhirl.studies.modal.superelement import MODES, superelement_modes

    unused = {"--shapes": shapes, "--animate": animate, "--wave": wave}
    for name, value in unused.items():
        if output is None and value is not None:
            raise UserError(f"{name}: needs a folder for the pictures, -o DIR")
    checked = read_case(case, overrides or [])
    if checked.bladed_disk.superelement is not None:
        if output is not None:
            raise UserError(
                "--output: not allowed for a superelement; bladewhirl run makes its pictures"
            )
        with faults_from(case, overrides or []), reduction_bar():
            document = superelement_modes(checked, count)
        rows = document["bladed_disk"]
        emit(document, table(rows, MODES, "Superelement without contact"), json=json)
        return
    stage = study.stage_of_file(case, overrides)
    if output is not None:
        plan = plan_pictures(stage, shapes=shapes, animate=animate if films else "", wave=wave)
    computed = study.modes(stage)
    lists = study.mode_lists(computed, count)
    centre, hertz = (computed.attrs[key] for key in ("centre", "reference_frequency_hz"))
    waves = "wave" in computed["pattern"].values
    columns = (*study.COLUMNS, *study.AT_SPEED) if waves else study.COLUMNS

    def lowest(title: str, **body: str) -> Table:
        """Return the table of a body, with one row for both modes of a pair; the columns "purity"
        and "at rest" are left out if they contain no information."""
        data = computed.sel(body).isel(mode=slice(count))
        single = data.isel(mode=(data["pattern"] != "sine").values)
        plain = {
            "purity": bool((single["purity"] > 0.9995).all()),
            "family_at_rest": bool((single["family"] == single["family_at_rest"]).all()),
        }
        shown = [column for column in columns if not plain.get(column.key, False)]
        return table(rows_of(single, shown), shown, title)

    tables = (
        lowest(f"Bladed disk, {centre} centre", body="bladed-disk", centre=centre),
        lowest("Casing", body="casing"),
    )
    if output is not None:
        draw_modes(stage, plan, output, overwrite=overwrite)
    emit(lists, *tables, f"ω₁ = {hertz:.6g} Hz", json=json, written=[output])
