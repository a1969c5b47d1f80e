"""`bladewhirl mesh3d`: superelements of meshes of solids, and what `bladewhirl mesh` lists."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from bladewhirl.models.inputs.errors import UserError, writing
from bladewhirl.studies.commands import options
from bladewhirl.studies.commands.terminal import emit, hints_at_once, progress_bar
from bladewhirl.studies.runs.columns import Column, facts, table

if TYPE_CHECKING:
    from rich.table import Table

    from bladewhirl.meshes.files.volumes import VolumeMesh
    from bladewhirl.models.superelements.superelement import Superelement

GROUPS = (Column("name", "group"), Column("kind", "kind"), Column("members", "members", "d"))

MATERIALS = (
    Column("group", "elements of"),
    Column("material", "material"),
    Column("young_modulus", "Young's modulus", ".6g"),
    Column("poisson_ratio", "Poisson's ratio", ".6g"),
    Column("density", "density", ".6g"),
)

NODES = (
    Column("node", "contact node", "d"),
    Column("radius", "radius [mm]", ".5g", scale=1e3),
    Column("angle", "angle [deg]", ".4f"),
    Column("z", "z [mm]", ".5g", scale=1e3),
)

MOST_NODES = 30  #: largest number of contact nodes that are listed

DIAMETERS, FAMILIES = 6, 4
"""Number of nodal diameters whose frequencies are listed, and of frequencies of each."""

NONE = "none"  #: text for a part that is not clamped, and for no stiffness at speed

COPIES = (
    "a whole number, of the sectors of the wheel or of the blades of a wheel in one piece; a"
    " question mark stands for a number that the mesh does not tell: bladewhirl mesh says why"
)
"""Values that --copies expects."""

Copies = Annotated[int | None, options.option("--copies", "INTEGER", int, COPIES)]
Values = Annotated[list[str] | None, typer.Option(metavar="VALUE|GROUP=VALUE")]


def mesh3d(
    source: Path,
    young_modulus: Values = None,
    poisson_ratio: Values = None,
    density: Values = None,
    clamped: str = "root",
    hub: str | None = None,
    hub_at: str | None = None,
    contact: str = "tip",
    contacts: options.MaybeNumber = None,
    joint_left: str | None = None,
    joint_right: str | None = None,
    joint_nodes: options.MaybeNumber = None,
    blade: str | None = None,
    lost: str | None = None,
    left: str | None = None,
    right: str | None = None,
    copies: Copies = None,
    length_unit: str = "m",
    mass_unit: str | None = None,
    axis: str = "z",
    speed: str | None = None,
    mass_quadrature: str | None = None,
    merge: str | None = None,
    stiffening: str = "prestress",
    coriolis: Annotated[bool, typer.Option("--coriolis")] = False,
    stress: Annotated[bool, typer.Option("--stress/--no-stress")] = True,
    name: str | None = None,
    outside_files: Annotated[bool, typer.Option("--outside-files")] = False,
    output: options.OutputFile = None,
    force: options.Force = False,
) -> None:
    """Make a superelement of a blade, a sector or a wheel from a mesh of solids.

    Groups are those of the mesh; in their place a condition such as "r < 210 mm" chooses nodes by
    position. bladewhirl mesh proposes this command for a mesh. The axis of rotation of the
    superelement is z.

    Args:
        source: Mesh or deck: .inp, .cdb, .bdf, .nas, .dat, .med, .msh or .vtu.
        young_modulus: Young's modulus, such as "210 GPa", of the elements without material in the
            file; or GROUP=VALUE for those of a group, which replaces that of the file.
        poisson_ratio: Poisson's ratio in the same way.
        density: Density, such as "7.8 g/cm3", in the same way.
        clamped: Group of the nodes to hold, or condition; "none" for a free part.
        hub: Group of the nodes tied to a hub that moves and tilts with a shaft line; or condition.
        hub_at: Position of the hub along the axis, such as "12 mm". Default: mean of the nodes.
        contact: Group of the contact nodes, condition, or outermost.
        contacts: Number of contact nodes, spread along the chord of --contact; of each blade with
            --copies.
        joint_left: Group, or condition, of the clockwise surface that touches the blade before in a
            [[joint]], such as that of a shroud.
        joint_right: Group, or condition, of the counter-clockwise surface of this joint.
        joint_nodes: Number of pairs of nodes of the joint, far from each other. Default: all.
        blade: Group of the blade of a sector, whose stiffness mistuning changes.
        lost: Group of blades that a wheel with a hub has lost, for [blade_loss]; or condition.
        left: Group of the clockwise face of a sector; with --copies alone faces are found.
        right: Group of the counter-clockwise face of a sector.
        copies: Number of sectors of the wheel, or of blades of a wheel in one piece.
        length_unit: Unit of length of the mesh.
        mass_unit: Unit of mass of the materials in the file, such as t for N, mm and s.
        axis: Axis of rotation of the mesh: x, y or z.
        speed: Speed, such as 9000rpm, if the stiffness is to be that at one speed only.
        mass_quadrature: full or reduced. Default: that of each element.
        merge: Distance up to which nodes become one node. Default: 1e-5 of the size.
        stiffening: Change of the stiffness with the speed: prestress, stress or none.
        coriolis: Add the matrix of Coriolis forces.
        stress: Add the recovery of stress at the surface.
        name: Name of the superelement.
        outside_files: Read files that an .inp file names also outside its folder.
        output: File of the superelement to write, .npz; a picture of the part is drawn beside it.
    """
    from dataclasses import replace

    from bladewhirl.models.solids.blade import mesh3d as made_of
    from bladewhirl.models.superelements.file import write_superelement

    options.refuse_existing(output, force=force)
    usual: dict[str, Any] = made_of.__kwdefaults__ or {}
    given: dict[str, Any] = {
        key: value
        for key, value in locals().items()
        if key in usual and value is not None and value != usual[key]
    }
    command = command_line(source, given, output)
    for key in ("young_modulus", "poisson_ratio", "density"):
        given[key] = _by_group(key, given.get(key))
    given |= {key: None for key in ("clamped", "stiffening") if given.get(key) == NONE}
    with hints_at_once():
        part = replace(made_of(source, **given), command=command)
    emit(None, facts(_facts(part)), *contact_table(part), json=False)
    emit(None, _frequencies(part), json=False)
    if output is None:
        return
    from bladewhirl.postprocess.pictures.part import draw_part

    with writing(output):
        write_superelement(output, part)
    typer.echo(f"Wrote {output}.")
    picture = draw_part(part, output.with_suffix(".png"))
    typer.echo(f"Wrote {picture}.")
    case = str(output.with_suffix(".toml"))
    typer.echo(f"To make a case: {shlex.join(['bladewhirl', 'new', case, '--from', str(output)])}")


def command_line(source: Path, given: Mapping[str, Any], output: Path | None) -> str:
    """Return the command mesh3d with arguments by name as text for a shell."""
    words = ["bladewhirl", "mesh3d", str(source)]
    for key, value in given.items():
        option = f"--{key.replace('_', '-')}"
        if isinstance(value, bool):
            words.append(option if value else option.replace("--", "--no-", 1))
            continue
        for each in value if isinstance(value, list) else [value]:
            words += [option, str(each)]
    return shlex.join([*words, *(["-o", str(output)] if output is not None else [])])


def _by_group(key: str, values: list[str] | None) -> Any:
    """Return a value, or values by the name of a group, of texts VALUE or GROUP=VALUE."""
    if not values:
        return None
    pairs = [text.rpartition("=") for text in values]
    if len(pairs) == 1 and not pairs[0][1]:
        return _number(pairs[0][2])
    if bare := [text for text, pair in zip(values, pairs, strict=True) if not pair[1]]:
        option = f"--{key.replace('_', '-')}"
        raise UserError(f"{option} {bare[0]}: expected one value, or GROUP=VALUE for each group")
    return {group: _number(value) for group, _, value in pairs}


def _number(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text


def _facts(part: Superelement) -> dict[str, str]:
    import numpy as np

    points = part.contact_position if part.points is None else part.points
    ends = [(values.min(), values.max()) for values in (np.hypot(*points.T[:2]), points[:, 2])]
    radius, axial = (f"{1e3 * low:.6g} to {1e3 * high:.6g} mm" for low, high in ends)
    shown = {"name": part.name, "source": part.source, "coordinates": str(part.size)}
    if part.whole_mass is not None:
        shown["mass"] = f"{part.whole_mass:.6g} kg"
    if part.joint_left is not None:
        shown["joints"] = f"{len(part.joint_left)} pairs of contact nodes with neighbouring blades"
    shown |= {"radius": radius, "along the axis z": axial}
    if part.left_dofs is not None:
        shown["sectors"] = f"{part.sectors}, with {len(part.left_dofs)} free nodes on each cut face"
    elif part.sectors:
        shown["blades"] = f"{part.sectors}, with {part.contacts // part.sectors} contact nodes each"
    return shown


def _frequencies(part: Superelement) -> Table:
    """Return a table of the lowest frequencies at rest, for a sector by nodal diameter."""
    from bladewhirl.models.superelements.frequencies import frequencies_by_diameter

    rows, sector = [], part.left_dofs is not None
    with progress_bar("frequencies at rest") as update:
        for k, own in enumerate(frequencies_by_diameter(part, FAMILIES, range(DIAMETERS))):
            rows.append({"k": k} | {str(n): one for n, one in enumerate(own)})
            update(k + 1, DIAMETERS if sector else 1)
    columns = [Column("k", "nodal diameter", "d")] if sector else []
    columns += [Column(str(n), str(n + 1), ".6g") for n in range(FAMILIES)]
    return table(rows, columns, "First frequencies at rest [Hz]")


def contact_table(part: Superelement) -> list[Any]:
    """Return the table of the contact nodes of a superelement, and a line about those left out."""
    import numpy as np

    places = np.column_stack(
        [part.contact_radius, np.degrees(part.contact_angle), part.contact_position[:, 2]]
    )
    rows = [
        {"node": node, "radius": radius, "angle": angle, "z": z}
        for node, (radius, angle, z) in enumerate(places.tolist())
    ]
    more = len(rows) - MOST_NODES
    shown = [table(rows[:MOST_NODES], NODES)]
    return [*shown, f"and {more} more contact nodes"] if more > 0 else shown


def list_solids(mesh: VolumeMesh, source: Path) -> None:
    """Print elements, groups and materials of a mesh of solids, and how it becomes a
    superelement."""
    from bladewhirl.models.solids.listing import solid_listing
    from bladewhirl.models.solids.proposal import UNKNOWN

    listing = solid_listing(mesh)
    groups = [table([*listing.groups], GROUPS)] if listing.groups else []
    materials = [table([*listing.materials], MATERIALS)] if listing.materials else []
    given, notes = listing.proposal
    unknown = [f"--{key.replace('_', '-')}" for key, value in given.items() if value == UNKNOWN]
    target = Path(f"{source.stem}.npz")
    command = command_line(source, given, target)
    lines = ["To make a superelement:", *(f"  {note}" for note in notes), "", command]
    if unknown:
        lines += ["", f"Replace the question marks of {', '.join(unknown)}, which are not known."]
    emit(None, listing.size, *groups, *materials, *lines, json=False)
