"""`bladewhirl mesh`: contents of a mesh, and its conversion to other formats."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from bladewhirl.models.inputs.errors import UserError, writing
from bladewhirl.studies.commands import options
from bladewhirl.studies.commands.output import emit, table
from bladewhirl.studies.modal.columns import Column

if TYPE_CHECKING:
    from bladewhirl.meshes.files.groups import GroupedLines

GROUPS = (Column("name", "group"), Column("kind", "kind"), Column("members", "members", "d"))


def mesh(
    source: Annotated[
        Path, typer.Argument(help="Case file, or a mesh file: .msh of Gmsh, .vtu, .inp of Abaqus.")
    ],
    output: Annotated[
        Path | None, options.output("Mesh file to write: .vtu, .msh or .inp.", "FILE")
    ] = None,
    overrides: options.Changes = None,
    force: options.Force = False,
) -> None:
    r"""List the groups of a mesh, and write the mesh in another format.

    The mesh of a case is the undeformed bladed disk, in metres, with its sets as groups and its
    sections, materials, masses, springs and links as data: the key \[bladed_disk.mesh] of a case
    can read the written file. A mesh file is converted without changes, in its own units.
    """
    from bladewhirl.meshes.files.groups import MeshFileError
    from bladewhirl.meshes.files.registry import left_out, write_line_mesh

    lines = _content(source, overrides or [])
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
    emit(None, size, table(rows, GROUPS), *listed, json=False)
    if output is None:
        return
    if output.exists() and not force:
        raise UserError(f"{output}: already exists; --force overwrites it")
    try:
        with writing(output):
            write_line_mesh(output, lines)
    except MeshFileError as error:
        raise UserError(f"{output}: expected {error}") from None
    missing = left_out(output, lines)
    if missing:
        typer.echo(f"{output} does not contain {', '.join(missing)}; .vtu and .msh do.", err=True)
    typer.echo(f"Wrote {output}.")


def _content(source: Path, overrides: list[str]) -> GroupedLines:
    """Return the line mesh of a case file or a mesh file."""
    from bladewhirl.meshes.files.groups import MeshFileError
    from bladewhirl.meshes.files.registry import READERS, read_line_mesh
    from bladewhirl.models.case.file import faults_from, read_case
    from bladewhirl.models.elements.build import case_beam_model
    from bladewhirl.models.geometry.from_mesh import grouped_lines

    if source.suffix.lower() not in READERS:
        case = read_case(source, overrides)
        with faults_from(source, overrides):
            return grouped_lines(case_beam_model(case))
    if overrides:
        raise UserError(f"--set {overrides[0]}: expected a case file to change, not {source}")
    try:
        return read_line_mesh(source)
    except MeshFileError as error:
        raise UserError(f"{source}: expected {error}") from None
