"""`bladewhirl import`: a superelement from the matrices of another finite element code."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from bladewhirl.models.inputs.errors import UserError, writing
from bladewhirl.studies.commands import options
from bladewhirl.studies.commands.output import emit, facts, table
from bladewhirl.studies.modal.columns import Column

if TYPE_CHECKING:
    from bladewhirl.models.imports.inspection import Inspection
    from bladewhirl.models.superelements.superelement import Superelement

NODES = (
    Column("node", "contact node", "d"),
    Column("radius", "radius [mm]", ".5g", scale=1e3),
    Column("angle", "angle [deg]", ".4f"),
    Column("z", "z [mm]", ".5g", scale=1e3),
)

MOST_NODES = 30
"""Largest number of contact nodes that are listed."""


def import_(
    source: Annotated[
        Path,
        typer.Argument(
            help="CalculiX .inp, Nastran .op4, stiffness in Matrix Market, .mat or .npz."
        ),
    ],
    contact: Annotated[
        str | None,
        typer.Option(help="Contact nodes: a group, or numbers of nodes such as 12,15,18."),
    ] = None,
    clamped: Annotated[
        str | None, typer.Option(help="Nodes to hold, if the matrices contain them.")
    ] = None,
    contacts: Annotated[
        int | None,
        typer.Option(min=1, help="Number of contact nodes, spread along the chord of --contact."),
    ] = None,
    mass: Annotated[Path | None, typer.Option(help="Mass in Matrix Market.")] = None,
    nodes: Annotated[
        Path | None,
        typer.Option(help="Table of nodes: a CSV file with a first line node,x,y,z."),
    ] = None,
    left: Annotated[
        str | None, typer.Option(help="Nodes of the clockwise face of a sector.")
    ] = None,
    right: Annotated[
        str | None, typer.Option(help="Nodes of the counter-clockwise face of a sector.")
    ] = None,
    copies: Annotated[int | None, typer.Option(help="Number of sectors of the wheel.")] = None,
    length_unit: Annotated[
        str | None, typer.Option(help="Unit of positions; the unit of time is s. Default: m.")
    ] = None,
    mass_unit: Annotated[
        str | None,
        typer.Option(help="Unit of mass, such as t for N, mm and s. Default: kg."),
    ] = None,
    axis: Annotated[
        str | None, typer.Option(help="Axis of rotation: x, y or z. Default: z.")
    ] = None,
    name: Annotated[str | None, typer.Option(help="Name of the superelement.")] = None,
    output: Annotated[
        Path | None, options.output("File of the superelement to write, .npz.", "FILE")
    ] = None,
    force: options.Force = False,
) -> None:
    """Make a superelement from the matrices of another finite element code.

    The matrices are checked: the mass and the stiffness must be symmetric and not indefinite, the
    nodes known and the first frequency plausible. The superelement is in SI units, and its axis of
    rotation is z.

    CalculiX writes .sti, .mas and .dof beside its input in a step with *FREQUENCY,
    SOLVER=MATRIXSTORAGE. Matrix Market needs --mass and --nodes, .mat with M and K needs --nodes,
    .op4 needs .asm and .pch beside it.
    """
    from bladewhirl.models.imports.importing import imported
    from bladewhirl.models.superelements.file import write_superelement

    if output is not None and output.exists() and not force:
        raise UserError(f"{output}: already exists; --force overwrites it")
    part, inspection, total = imported(
        source,
        mass=mass,
        nodes=nodes,
        contact=contact,
        clamped=clamped,
        contacts=contacts,
        left=left,
        right=right,
        copies=copies,
        length_unit=length_unit,
        mass_unit=mass_unit,
        axis=axis,
        name=name,
    )
    given = f"{length_unit or 'm'}, {mass_unit or 'kg'}, s"
    emit(None, facts(_facts(part, inspection, total, given)), *_contacts(part), json=False)
    if output is not None:
        with writing(output):
            write_superelement(output, part)
        typer.echo(f"Wrote {output}.")


def _facts(part: Superelement, inspection: Inspection, total: Any, units: str) -> dict[str, str]:
    shown = {"name": part.name, "source": part.source, "coordinates": str(part.size)}
    if total is not None:
        shown["units"] = f"{units}, converted to m, kg, s"
        values = ", ".join(f"{value:.6g}" for value in total)
        shown["mass along x, y, z"] = f"{values} kg, without fixed nodes"
    if part.left_dofs is not None:
        shown["faces of the sector"] = f"{len(part.left_dofs)} nodes each, free below"
    shown["rigid modes"] = str(inspection.rigid_modes)
    frequencies = ", ".join(f"{value:.6g}" for value in inspection.frequencies)
    shown["first frequencies"] = f"{frequencies} Hz" if frequencies else "none"
    return {key: value for key, value in shown.items() if value}


def _contacts(part: Superelement) -> list[Any]:
    import numpy as np

    rows = [
        {"node": node, "radius": radius, "angle": angle, "z": z}
        for node, (radius, angle, z) in enumerate(
            zip(
                part.contact_radius.tolist(),
                np.degrees(part.contact_angle).tolist(),
                part.contact_position[:, 2].tolist(),
                strict=True,
            )
        )
    ]
    more = len(rows) - MOST_NODES
    shown = [table(rows[:MOST_NODES], NODES)]
    return [*shown, f"and {more} more contact nodes"] if more > 0 else shown
