"""`bladewhirl show`: properties of a case, and all keys of the case."""

from __future__ import annotations

from math import degrees
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from bladewhirl.models.inputs.errors import CaseError, UserError, writing
from bladewhirl.studies.commands import options
from bladewhirl.studies.commands.terminal import emit
from bladewhirl.studies.runs.columns import Column, facts, table, texts

if TYPE_CHECKING:
    from rich.table import Table

    from bladewhirl.models.case.case import Case

RATES = (
    Column("name", " "),
    Column("normalised", "× reference", ".5g"),
    Column("hz", "[Hz]", ".5g"),
    Column("rpm", "[rpm]", ".5g"),
    Column("rad_per_s", "[rad/s]", ".5g"),
)
NAMES = {
    "reference_frequency": "reference frequency, at rest",
    "speed": "speed",
    "suspension": "suspension modes, reduced model",
    "distortion.frequency": "casing mode loaded",
}
"""Labels of frequencies and speeds by key; `RATES` are the columns of their table."""

MODES = (
    Column("nodal_diameter", "k", "d"),
    Column("frequency.hz", "[Hz]", ".6g"),
    Column("frequency.normalised", "normalised", ".5g"),
    Column("purity", "purity", ".3f"),
)
PROPERTIES = (
    Column("superelement", "superelement"),
    Column("coordinates", "coordinates", "d"),
    Column("copies", "copies", "d"),
    Column("modes", "modes of all copies", "d"),
    Column("frequency_error", "error of the lowest frequencies at this speed", ".1g"),
    Column("stress_points", "points with stress", "d"),
    Column("bladed_disk_mass", "bladed disk [kg]", ".5g"),
    Column("bladed_disk_parts", "parts of the bladed disk [kg]", ".3g"),
    Column("casing_mass", "casing [kg]", ".5g"),
    Column("rotation_effects", "rotation effects, in modes and campbell"),
    Column("shaft_stiffness", "springs of the shaft [N/m]", ".5g"),
    Column("suspension_spring_share", "suspension, strain energy in the springs [%]", ".3g", 100.0),
    Column("imbalance.unbalance", "imbalance [kg m]", ".4g"),
    Column("imbalance.force", "imbalance, force at this speed [N]", ".5g"),
    Column("imbalance.closing", "imbalance, static response / clearance [%]", ".3g", 100.0),
    Column("distortion.static_displacement", "static response of the loaded mode [mm]", ".4g", 1e3),
    Column("smallest_clearance", "smallest clearance [mm]", ".4g", 1e3),
    Column("coating.tracks", "tracks of the coating", "d"),
    Column("coating.rods", "rods of each track", "d"),
    Column("coating.arc", "arc length of a rod [mm]", ".3g", 1e3),
    Column("coating.width", "width of all tracks [mm]", ".3g", 1e3),
    Column("coating.footprint", "arc under a tip [mm]", ".3g", 1e3),
    Column("coating.yield_force", "force at which the coating gives way [N]", ".4g"),
    Column("reduction.modes", "modes of the reduced model", "d"),
    Column("reduction.boundary", "boundary degrees of freedom", "d"),
    Column("reduction.fixed_interface_modes", "fixed-interface modes", "d"),
    Column("reduction.internal", "inner degrees of freedom", "d"),
    Column("reduction.frequency_error", "reduced model, frequency errors [%]", ".2g", 100.0),
    Column("symmetry", "symmetry"),
    Column("reduction.marched", "modes of the march", "d"),
    Column("marched", "method of the march"),
    Column("critical_time_step", "critical time step [s]", ".4g"),
    Column("dt_over_critical", "time step / critical", ".3g"),
    Column("steps", "steps", "d"),
    Column("records", "records", "d"),
    Column("result_bytes", "result.nc, about [MB]", ".3g", 1e-6),
)
"""Columns of the properties of a stage."""

NODES = (
    Column("node", "node", "d"),
    Column("radius", "radius [mm]", ".5g", 1e3),
    Column("angle", "angle [°]", ".4g", degrees(1.0)),
    Column("axial", "axial [mm]", ".4g", 1e3),
    Column("flexibility", "flexibility [m/N]", ".3g"),
    Column("residual", "residual [m/N]", ".3g"),
    Column("locking_friction", "locks above μ", ".3g"),
)
JOINT_NODES = (NODES[0], Column("joint", "joint"), *NODES[1:-1])
LISTS = {"bladed_disk": "Bladed disk", "casing": "Casing"}
"""Titles of the lists of modes by key."""


def show(
    case: options.CaseFile,
    overrides: options.Changes = None,
    json: options.AsJson = False,
    with_case: Annotated[bool, typer.Option("--case")] = False,
    png: Annotated[bool, typer.Option("--png")] = False,
    output: options.Output = None,
    overwrite: options.Replace = False,
) -> None:
    """Print the properties of a case, and with --case all keys of the case.

    Properties are masses, lowest frequencies of the full model, the speed in rpm, the critical time
    step, the load of an imbalance, size and errors of the reduced model, and the size of result.nc.

    Args:
        with_case: Print every key of the case after the properties.
        png: Draw the stage: parts, sets, springs, supports; or the shaft line with its bearings.
        output: File of the drawing; by default the name of the case with .png.
    """
    if output is not None and not png:
        raise UserError("--output: allowed only with --png, the option that draws the stage")
    with options.case_of(case, overrides) as checked:
        if checked.shaft_line is not None:
            from bladewhirl.studies.shaft_line.properties import draw, properties

            emit(*_document(checked, *properties(checked), with_case=with_case), json=json)
            if png:
                target = output or Path(f"{case.stem}.png")
                options.claim_output(target, named=True, overwrite=overwrite)
                with writing(target):
                    draw(checked, target)
                typer.echo(f"Wrote {target}.", err=True)
            return
        from bladewhirl.models.case.plausibility import speed_hint
        from bladewhirl.models.stage.build import build_stage, time_step_faults
        from bladewhirl.models.stage.hints import stage_hints
        from bladewhirl.studies.runs.properties import stage_properties

        stage = build_stage(checked)
        if faults := list(time_step_faults(stage)):
            raise CaseError(faults)
        derived = stage_properties(stage)
        for hint in filter(None, (*stage_hints(stage), speed_hint(stage.case, stage.speed))):
            typer.echo(f"Hint: {hint}.", err=True)
        if png:
            from bladewhirl.postprocess.pictures.stage import draw_stage, stage_at_rest

            target = output or Path(f"{case.stem}.png")
            options.claim_output(target, named=True, overwrite=overwrite)
            at_rest = stage_at_rest(stage.arrays, stage.attributes, title=checked.title)
            with writing(target):
                draw_stage(at_rest, target, node_sets=stage.node_sets)
            typer.echo(f"Wrote {target}.", err=True)
    emit(*_document(checked, derived, _tables(derived), with_case=with_case), json=json)


def _document(
    case: Case, derived: dict[str, Any], tables: list[Table], *, with_case: bool
) -> tuple[Any, ...]:
    """Return the JSON document, then what is printed."""
    from bladewhirl.models.case.template import dumps_case

    document = {"case": case.model_dump(mode="json", exclude_none=True), "derived": derived}
    full = (f"\n{dumps_case(case)}".removesuffix("\n"),) if with_case else ()
    return document, *tables, *full


def _tables(derived: dict[str, Any]) -> list[Table]:
    """Return the printed tables of the properties of a stage."""
    from bladewhirl.studies.runs.properties import MARCHES

    marched = {body: MARCHES[cyclic] for body, cyclic in derived["cyclic"].items()}
    rates = [
        {"name": name} | rate
        for key, name in NAMES.items()
        if (rate := Column(key).value(derived)) is not None
    ]
    tables = [
        facts(texts(derived | {"marched": marched}, PROPERTIES)),
        table(rates, RATES, "Frequencies and speed"),
    ]
    for key, title in LISTS.items():
        if listed := derived.get(key):  # not of a rigid wall
            rows = sorted(listed, key=lambda mode: mode["nodal_diameter"])
            tables.append(table(rows, MODES, f"{title}, full model"))
    if nodes := derived.get("contact_nodes"):
        equal = derived["copies"] > 1 and not derived["copies_differ"]
        of_copy = " of a copy" * equal
        tips = [node for node in nodes if node["joint"] is None]
        ends = [node for node in nodes if node["joint"] is not None]
        if tips:
            tables.append(table(tips, NODES, f"Contact nodes{of_copy}"))
        if ends:
            tables.append(table(ends, JOINT_NODES, f"Ends of joints{of_copy}"))
    return tables
