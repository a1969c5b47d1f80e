"""`bladewhirl show`: properties of a case, and the case in full."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from bladewhirl.models.inputs.errors import CaseError, UserError, writing
from bladewhirl.studies.commands.options import (
    AsJson,
    CaseFile,
    Changes,
    Replace,
    claim_output,
    output_option,
)
from bladewhirl.studies.commands.output import emit, facts, table
from bladewhirl.studies.modal.columns import Column

if TYPE_CHECKING:
    from collections.abc import Iterator

    from bladewhirl.models.stage.stage import Stage
    from bladewhirl.studies.runs.properties import Mode, Rate, StageProperties

MODES = (
    Column("nodal_diameter", "k", "d"),
    Column("hz", "[Hz]", ".6g"),
    Column("normalised", "normalised", ".5g"),
    Column("purity", "purity", ".3f"),
)


def show(
    case: CaseFile,
    overrides: Changes = None,
    json: AsJson = False,
    with_case: Annotated[
        bool, typer.Option("--case", help="Print every key of the case after the figures.")
    ] = False,
    png: Annotated[
        bool, typer.Option("--png", help="Draw the stage: parts, sets, springs, supports.")
    ] = False,
    output: Annotated[
        Path | None,
        output_option("File of the drawing; the case's name.png if none."),
    ] = None,
    overwrite: Replace = False,
) -> None:
    """Print the properties of a case, and with --case every key of it.

    Properties are masses, lowest frequencies of the full model, the speed in rpm, the critical time
    step, the load of an imbalance, size and errors of the reduced model, and the size of a run.
    """
    from dataclasses import asdict

    from bladewhirl.models.case.file import dumps_case, faults_from, read_case
    from bladewhirl.models.stage.build import time_step_faults
    from bladewhirl.models.stage.hints import stage_hints
    from bladewhirl.models.stage.stage import build_stage
    from bladewhirl.studies.runs.properties import stage_properties

    if output is not None and not png:
        raise UserError("--output: not without --png, which draws")
    values = overrides or []
    checked = read_case(case, values)
    with faults_from(case, values):
        stage = build_stage(checked)
        faults = list(time_step_faults(stage))
        if faults:
            raise CaseError(faults)
        properties = stage_properties(stage)
    for hint in stage_hints(stage):
        typer.echo(f"Hint: {hint}.", err=True)
    if png:
        target = output or Path(f"{case.stem}.png")
        claim_output(target, named=True, overwrite=overwrite)
        _draw(stage, target)
    document = {
        "case": checked.model_dump(mode="json", exclude_none=True),
        "derived": asdict(properties),
    }
    tables = (
        facts(dict(_texts(properties))),
        table(_rows(properties.bladed_disk), MODES, "Bladed disk, full model"),
        table(_rows(properties.casing), MODES, "Casing, full model"),
    )
    texts = (f"\n{dumps_case(checked)}".removesuffix("\n"),) if with_case else ()
    emit(document, *tables, *texts, json=json)


def _draw(stage: Stage, target: Path) -> None:
    """Draw the stage, and name the file on standard error."""
    from bladewhirl.postprocess.pictures.stage import draw_stage, stage_at_rest

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


def _texts(properties: StageProperties) -> Iterator[tuple[str, str]]:
    """Yield names and texts of the properties."""
    from bladewhirl.models.inputs.units import handy
    from bladewhirl.studies.runs.properties import MARCHES

    reduction = properties.reduction
    parts = properties.bladed_disk_parts
    yield "bladed disk", f"{properties.bladed_disk_mass:.5g} kg"
    if len(parts) > 1:
        yield "its parts", ", ".join(f"{name} {mass:.3g} kg" for name, mass in parts.items())
    yield "casing", f"{properties.casing_mass:.5g} kg"
    yield "reference frequency, at rest", _rate(properties.reference_frequency)
    yield "speed", _rate(properties.speed)
    if properties.rotation_effects != "none":
        yield "rotation.effects", f"{properties.rotation_effects}; modes at speed, rotating axes"
        yield "Coriolis forces", "in modes and campbell only"
    if properties.shaft_stiffness is not None:
        springs = dict.fromkeys(handy(value, "N/m") for value in properties.shaft_stiffness)
        yield "springs of the shaft", " and ".join(springs)
    if properties.suspension is not None:
        yield "suspension modes, reduced model", _rate(properties.suspension)
        share = 100.0 * (properties.suspension_spring_share or 0.0)
        yield "their strain energy in the springs", f"{share:.3g} %"
    if properties.imbalance is not None:
        load = properties.imbalance
        yield "imbalance", f"{load.unbalance:.4g} kg m, {load.force:.5g} N at this speed"
        yield "its static answer closes", f"{100.0 * load.closing:.3g} % of the clearance"
    if properties.distortion is not None:
        yield "casing mode loaded", _rate(properties.distortion.frequency)
        yield "its static answer", f"{1e3 * properties.distortion.static_displacement:.4g} mm"
    sets = ", ".join(f"{size} {name}" for name, size in reduction.boundary.items())
    fixed = f"{reduction.fixed_interface_modes} of {reduction.internal} fixed-interface"
    yield "reduced model", f"{reduction.modes} modes: {sets}, {fixed}"
    shown = ("suspension", *(f"{rank}F" for rank in range(1, 6)))
    errors = reduction.frequency_error
    yield (
        "its errors against the full model",
        ", ".join(f"{name} {100 * errors[name]:.2g} %" for name in shown if name in errors),
    )
    for body, symmetry in properties.symmetry.items():
        yield f"symmetry, {body.replace('_', ' ')}", symmetry
    for body, cyclic in properties.cyclic.items():
        count = reduction.marched[body]
        yield f"march, {body.replace('_', ' ')}", f"{count} modes, {MARCHES[cyclic]}"
    yield (
        "critical time step",
        f"{properties.critical_time_step:.4g} s, time step / critical "
        f"{properties.dt_over_critical:.3g}",
    )
    yield "steps", f"{properties.steps}, {properties.records} records"
    yield "result.nc", f"about {properties.result_bytes / 1e6:.3g} MB"


def _rows(modes: tuple[Mode, ...]) -> Iterator[dict[str, Any]]:
    """Yield rows of the table of modes, by nodal diameter."""
    for mode in sorted(modes, key=lambda mode: mode.nodal_diameter):
        yield {
            "nodal_diameter": mode.nodal_diameter,
            "hz": mode.frequency.hz,
            "normalised": mode.frequency.normalised,
            "purity": mode.purity,
        }


def _rate(rate: Rate) -> str:
    return (
        f"{rate.normalised:.5g} × reference = {rate.hz:.5g} Hz = {rate.rpm:.5g} rpm"
        f" = {rate.rad_per_s:.5g} rad/s"
    )
