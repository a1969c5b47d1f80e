"""`bladewhirl show`: properties of a case, and all keys of the case."""

from pathlib import Path
from typing import Annotated

import typer

from bladewhirl.models.inputs.errors import CaseError, UserError, writing
from bladewhirl.studies.commands import options
from bladewhirl.studies.commands.output import emit, facts, table
from bladewhirl.studies.commands.progress import reduction_bar
from bladewhirl.studies.modal.columns import Column, texts

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
    Column("coating.rods", "rods of the coating", "d"),
    Column("coating.arc", "arc length of a rod [mm]", ".3g", 1e3),
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


def show(
    case: options.CaseFile,
    overrides: options.Changes = None,
    json: options.AsJson = False,
    with_case: Annotated[
        bool, typer.Option("--case", help="Print every key of the case after the properties.")
    ] = False,
    png: Annotated[
        bool, typer.Option("--png", help="Draw the stage: parts, sets, springs, supports.")
    ] = False,
    output: Annotated[
        Path | None,
        options.output("File of the drawing; by default the name of the case with .png."),
    ] = None,
    overwrite: options.Replace = False,
) -> None:
    """Print the properties of a case, and with --case all keys of the case.

    Properties are masses, lowest frequencies of the full model, the speed in rpm, the critical time
    step, the load of an imbalance, size and errors of the reduced model, and the size of result.nc.
    """
    from bladewhirl.models.case.file import faults_from, read_case
    from bladewhirl.models.case.template import dumps_case
    from bladewhirl.models.stage.build import time_step_faults
    from bladewhirl.models.stage.hints import stage_hints, superelement_hints
    from bladewhirl.models.stage.stage import build_stage
    from bladewhirl.models.stage.superelement_stage import superelement_stage
    from bladewhirl.studies.modal.superelement import (
        NODES,
        superelement_properties,
    )
    from bladewhirl.studies.modal.superelement import PROPERTIES as SUPERELEMENT
    from bladewhirl.studies.runs.properties import MARCHES, stage_properties
    from bladewhirl.studies.runs.superelement_picture import draw_superelement

    if output is not None and not png:
        raise UserError("--output: allowed only with --png, the option that draws the stage")
    values = overrides or []
    checked = read_case(case, values)
    if checked.bladed_disk.superelement is not None:
        with faults_from(case, values), reduction_bar():
            built = superelement_stage(checked)
            derived = superelement_properties(built)
        for hint in superelement_hints(built):
            typer.echo(f"Hint: {hint}.", err=True)
        if png:
            target = output or Path(f"{case.stem}.png")
            options.claim_output(target, named=True, overwrite=overwrite)
            with faults_from(case, values), writing(target):
                draw_superelement(built, target)
            typer.echo(f"Wrote {target}.", err=True)
        document = {"case": checked.model_dump(mode="json", exclude_none=True), "derived": derived}
        tables = [
            facts(texts(derived, SUPERELEMENT)),
            table(derived["contact_nodes"], NODES, "Contact nodes of a copy"),
        ]
        full = (f"\n{dumps_case(checked)}".removesuffix("\n"),) if with_case else ()
        emit(document, *tables, *full, json=json)
        return
    with faults_from(case, values):
        stage = build_stage(checked)
        faults = list(time_step_faults(stage))
        if faults:
            raise CaseError(faults)
        derived = stage_properties(stage)
    for hint in stage_hints(stage):
        typer.echo(f"Hint: {hint}.", err=True)
    if png:
        from bladewhirl.postprocess.pictures.stage import draw_stage, stage_at_rest

        target = output or Path(f"{case.stem}.png")
        options.claim_output(target, named=True, overwrite=overwrite)
        at_rest = stage_at_rest(
            stage.arrays,
            title=stage.case.title,
            tip_radius=stage.rotor.tip_radius,
            casing_radius=stage.reduced_casing.radius,
            clamped=stage.case.shaft.clamped,
        )
        with writing(target):
            draw_stage(at_rest, target, node_sets=stage.disk.mesh.node_sets)
        typer.echo(f"Wrote {target}.", err=True)
    document = {"case": checked.model_dump(mode="json", exclude_none=True), "derived": derived}
    marched = {body: MARCHES[cyclic] for body, cyclic in derived["cyclic"].items()}
    derived = derived | {"marched": marched}
    rates = [
        {"name": name} | rate
        for key, name in NAMES.items()
        if (rate := Column(key).value(derived)) is not None
    ]
    tables = [facts(texts(derived, PROPERTIES)), table(rates, RATES, "Frequencies and speed")]
    for body, title in (("bladed_disk", "Bladed disk"), ("casing", "Casing")):
        modes = sorted(derived[body], key=lambda mode: mode["nodal_diameter"])
        tables.append(table(modes, MODES, f"{title}, full model"))
    full = (f"\n{dumps_case(checked)}".removesuffix("\n"),) if with_case else ()
    emit(document, *tables, *full, json=json)
