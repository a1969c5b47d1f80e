"""Commands that make the input of a march: case files, meshes, superelements."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from bladewhirl.models.inputs.errors import UserError, writing
from bladewhirl.studies.commands import options
from bladewhirl.studies.commands.solids import DIAMETERS, GROUPS, contact_table, list_solids
from bladewhirl.studies.commands.terminal import emit
from bladewhirl.studies.runs.columns import facts, table

if TYPE_CHECKING:
    from bladewhirl.meshes.files.groups import GroupedLines
    from bladewhirl.meshes.files.volumes import VolumeMesh
    from bladewhirl.models.imports.inspection import Inspection
    from bladewhirl.models.superelements.superelement import Superelement


RIGID = 6  #: number of rigid modes of a free part

ELASTIC = 1e-3
"""Frequencies below this fraction of a higher one are those of rigid modes."""


def new(
    path: Annotated[Path | None, typer.Argument()] = None,
    part: Annotated[Path | None, typer.Option("--from", metavar="PART")] = None,
    speeds: Annotated[options.Span | None, options.span("--speeds")] = None,
    output: options.OutputFile = None,
    force: options.Force = False,
) -> None:
    """Write a case file with every key, its default and its meaning; or one for a superelement.

    With --from the case is short: speed, clearance, steps and records follow from the lowest
    frequency and the radius of the superelement, friction from what locks its contact nodes.

    Args:
        path: File to write; by default case.toml.
        part: File of a superelement, .npz or .mat.
        speeds: Range of speeds for --from. Default: about a quarter of the lowest frequency.
        output: The file to write, as for other commands.
    """
    from bladewhirl.files import write_atomically
    from bladewhirl.models.case.template import template

    if part is None:
        options.omitted("a case without --from", {"--speeds": speeds})
    if path is not None:
        options.omitted("another file to write", {"--output": output})
    path = path or output or Path("case.toml")
    options.refuse_existing(path, force=force)
    text = template() if part is None else _case_of(part, speeds, path)
    with writing(path):
        path.parent.stat()  # an error if the folder does not exist
        write_atomically(path, text)
    typer.echo(f"Wrote {path}{'' if part is None else ', which begins with commands for it'}.")


def _case_of(file: Path, speeds: options.Span | None, case: Path) -> str:
    """Return the text of a case for a superelement."""
    import os
    from math import pi

    from bladewhirl.models.case.part_template import modes_of, part_template
    from bladewhirl.models.superelements.critical_step import limits_of
    from bladewhirl.models.superelements.file import read_superelement
    from bladewhirl.models.superelements.frequencies import (
        frequencies_by_diameter,
        frequencies_of_wheel,
    )

    part = read_superelement(file)
    found = frequencies_of_wheel(part) or [
        *frequencies_by_diameter(part, RIGID + 1, range(DIAMETERS))
    ]
    limit = ELASTIC * max(own.max() for own in found)
    lowest = [2.0 * pi * float(own[own > limit].min()) for own in found]
    ends = None if speeds is None else min(lowest) * speeds.values(min(lowest))
    limits = limits_of(part, modes_of(part))
    return part_template(os.path.relpath(file, case.parent), part, lowest, limits, ends, case)


def mesh(
    source: Path,
    output: options.OutputFile = None,
    overrides: options.Changes = None,
    force: options.Force = False,
) -> None:
    """List the groups of a mesh, and write a mesh of lines in another format.

    The mesh of a case is the undeformed bladed disk, in metres, with its sets as groups and its
    sections, materials, masses, springs and links as data: the key [bladed_disk.mesh] of a case
    can read the written file. A mesh file is converted without changes, in its own units.

    Of a mesh of solids the elements, groups and materials are listed, and the command mesh3d that
    makes a superelement of it; values that the mesh does not tell are question marks.

    Args:
        source: Case file, or a mesh file: .msh of Gmsh, .vtu, .inp of Abaqus or CalculiX.
        output: Mesh file to write: .vtu, .msh or .inp.
    """
    from bladewhirl.meshes.files.groups import MeshFileError
    from bladewhirl.meshes.files.registry import left_out, write_line_mesh
    from bladewhirl.meshes.files.volumes import VolumeMesh

    if output is not None:
        options.refuse_existing(output, force=force)
    lines = _content(source, overrides or [])
    if isinstance(lines, VolumeMesh):
        if output is not None:
            raise UserError(f"{output}: expected a mesh of lines to write; {source} has solids")
        list_solids(lines, source)
        return
    low, high = lines.points.min(axis=0), lines.points.max(axis=0)
    size = (
        f"{len(lines.points)} nodes, {len(lines.lines)} lines,"
        f" x {low[0]:.6g} to {high[0]:.6g}, y {low[1]:.6g} to {high[1]:.6g}"
    )
    rows = [
        {"name": name, "kind": kind, "members": len(members)}
        for kind, groups in (("nodes", lines.node_groups), ("lines", lines.line_groups))
        for name, members in groups.items()
    ]
    data = [f"{name} (nodes)" for name in lines.node_data]
    data += [f"{name} (lines)" for name in lines.line_data]
    listed = [f"data: {', '.join(data)}"] if data else []
    listed += [f"not read: {', '.join(lines.ignored)}"] if lines.ignored else []
    emit(None, size, table(rows, GROUPS), *listed, json=False)
    if output is None:
        return
    try:
        with writing(output):
            write_line_mesh(output, lines)
    except MeshFileError as error:
        raise UserError(f"{output}: expected {error}") from None
    missing = left_out(output, lines)
    if missing:
        typer.echo(f"{output} does not contain {', '.join(missing)}; .vtu and .msh do.", err=True)
    typer.echo(f"Wrote {output}.")


def _content(source: Path, overrides: list[str]) -> GroupedLines | VolumeMesh:
    """Return the line mesh of a case file, or the mesh of lines or solids in a mesh file."""
    from bladewhirl.meshes.files.formats import OTHERS, format_of
    from bladewhirl.meshes.files.groups import MeshFileError, OtherCellsError
    from bladewhirl.meshes.files.registry import read_line_mesh
    from bladewhirl.meshes.files.volumes import READERS, read_volume_mesh
    from bladewhirl.models.elements.build import case_beam_model
    from bladewhirl.models.geometry.from_mesh import grouped_lines

    if format_of(source) not in (*READERS, *OTHERS):
        with options.case_of(source, overrides) as case:
            return grouped_lines(case_beam_model(case))
    if overrides:
        raise UserError(f"--set {overrides[0]}: expected a case file to change, not {source}")
    try:
        return read_line_mesh(source)
    except MeshFileError as error:
        try:
            return read_volume_mesh(source)
        except MeshFileError as reason:
            both = dict.fromkeys((str(error), str(reason)))
            solids = isinstance(error, OtherCellsError) and not isinstance(reason, OtherCellsError)
            if solids or format_of(source) in OTHERS:
                both = {str(reason): None}
            raise UserError(f"{source}: expected {'; or '.join(both)}") from None


def import_(
    source: Path,
    contact: str | None = None,
    clamped: str | None = None,
    hub: str | None = None,
    contacts: options.MaybeNumber = None,
    mass: Path | None = None,
    nodes: Path | None = None,
    left: str | None = None,
    right: str | None = None,
    copies: int | None = None,
    length_unit: str | None = None,
    mass_unit: str | None = None,
    axis: str | None = None,
    speed: str | None = None,
    at: Annotated[list[str] | None, typer.Option(metavar="SPEED:FILE")] = None,
    name: str | None = None,
    outside_files: Annotated[bool, typer.Option("--outside-files")] = False,
    output: options.OutputFile = None,
    force: options.Force = False,
) -> None:
    """Make a superelement from the matrices of another finite element code.

    The matrices are checked: the mass and the stiffness must be symmetric and not indefinite, the
    nodes known and the first frequency plausible. The superelement is in SI units, and its axis of
    rotation is z.

    CalculiX writes .sti, .mas and .dof beside its input in a step with *FREQUENCY,
    SOLVER=MATRIXSTORAGE. Matrix Market needs --mass and --nodes, .mat with M and K needs --nodes,
    .op4 needs .asm and .pch beside it.

    Args:
        source: CalculiX .inp, Nastran .op4, stiffness in Matrix Market, .mat or .npz.
        contact: Contact nodes: a group, numbers of nodes such as 12,15,18, outermost, or a
            condition such as "r > 299 mm".
        clamped: Nodes to hold, if the matrices contain them.
        hub: Nodes tied to a hub that moves and tilts with a shaft line.
        contacts: Number of contact nodes, spread along the chord of --contact.
        mass: Mass in Matrix Market.
        nodes: Table of nodes: a CSV file with a first line node,x,y,z.
        left: Nodes of the clockwise face of a sector.
        right: Nodes of the counter-clockwise face of a sector.
        copies: Number of sectors of the wheel.
        length_unit: Unit of positions; the unit of time is s. Default: m.
        mass_unit: Unit of mass, such as t for N, mm and s. Default: kg.
        axis: Axis of rotation: x, y or z. Default: z.
        speed: Speed to which the stiffness belongs, such as 9000rpm. Default: unknown.
        at: Stiffness at a further speed, such as 9000rpm:k9.mtx; at most twice.
        name: Name of the superelement.
        outside_files: Read files that the input of CalculiX names also outside its folder.
        output: File of the superelement to write, .npz.
    """
    from bladewhirl.models.imports.importing import imported
    from bladewhirl.models.superelements.file import write_superelement

    options.refuse_existing(output, force=force)
    part, inspection, total = imported(
        source,
        mass=mass,
        nodes=nodes,
        speed=speed,
        at=dict(map(_speed_and_file, at or ())),
        outside_files=outside_files,
        contact=contact,
        clamped=clamped,
        hub=hub,
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
    emit(None, facts(_facts(part, inspection, total, given)), *contact_table(part), json=False)
    for hint in inspection.hints:
        typer.echo(f"Hint: {hint}.", err=True)
    if output is not None:
        with writing(output):
            write_superelement(output, part)
        typer.echo(f"Wrote {output}.")


def _speed_and_file(text: str) -> tuple[str, str]:
    """Return speed and file of SPEED:FILE."""
    speed, colon, file = text.partition(":")
    if not (speed and colon and file):
        raise UserError(f"--at {text}: expected SPEED:FILE, such as 9000rpm:k9.mtx")
    return speed, file


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
