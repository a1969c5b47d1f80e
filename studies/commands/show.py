"""`bladewhirl show`: what follows from a case, and the case in full."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from bladewhirl.models.inputs.errors import CaseError, UserError, writing
from bladewhirl.studies.commands.options import (
    AsJson,
    CaseFile,
    Changes,
    Replace,
    claim_output,
    print_json,
)

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rich.table import Table

    from bladewhirl.models.stage.stage import Stage
    from bladewhirl.studies.runs.properties import Mode, Rate, StageProperties


NO_DIAMETER = 10**9
"""Sorts what has no nodal diameter last."""

PURE = 0.9995
"""Purity from which a mode has one nodal diameter."""


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
        typer.Option("--output", "-o", help="File of the drawing; the case's name.png if none."),
    ] = None,
    overwrite: Replace = False,
) -> None:
    """Print the figures that follow from a case, and with --case every key of it.

    Figures are masses, lowest frequencies of the full model, the speed in rpm, the critical time
    step, the load of an imbalance, what the reduction kept and how well, and the size of a run.
    """
    from dataclasses import asdict

    from rich.console import Console

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
    if json:
        tables = checked.model_dump(mode="json", exclude_none=True)
        document = {"case": tables, "derived": asdict(properties)}
        print_json(document)
        return
    console = Console()
    console.print(_figures(properties), _frequencies(properties), sep="\n")
    if with_case:
        typer.echo(f"\n{dumps_case(checked)}", nl=False)


def _draw(stage: Stage, target: Path) -> None:
    """Draw the stage and say so, beside what is printed."""
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


def _figures(properties: StageProperties) -> Table:
    from rich.table import Table

    table = Table(show_header=False, box=None, pad_edge=False)
    table.add_column(style="cyan", no_wrap=True)
    table.add_column(overflow="fold")
    for name, text in _rows(properties):
        table.add_row(name, text)
    return table


def _rows(properties: StageProperties) -> Iterator[tuple[str, str]]:
    from bladewhirl.models.inputs.units import handy
    from bladewhirl.studies.runs.properties import MARCHES

    reduction = properties.reduction
    parts = properties.bladed_disk_parts
    listed = ", ".join(f"{name} {mass:.3g} kg" for name, mass in parts.items())
    told = f": {listed}" if len(parts) > 1 else ""
    yield "bladed disk", f"{properties.bladed_disk_mass:.5g} kg{told}"
    yield "casing", f"{properties.casing_mass:.5g} kg"
    yield "reference frequency", _text(properties.reference_frequency)
    yield "speed", _text(properties.speed)
    if properties.rotation_effects != "none":
        turning = properties.rotation_effects == "full"
        coriolis = ", without Coriolis forces (modes and campbell have them)" if turning else ""
        yield (
            f'rotation.effects = "{properties.rotation_effects}"',
            "frequencies below are at this speed, in rotating axes"
            f"{coriolis}; the reference is at rest",
        )
    if properties.shaft_stiffness is not None:
        springs = dict.fromkeys(handy(each, "N/m") for each in properties.shaft_stiffness)
        yield "springs of the shaft", " and ".join(springs)
    if properties.suspension is not None:
        share = f"{100.0 * (properties.suspension_spring_share or 0.0):.3g} %"
        frequency = _text(properties.suspension)
        soft = " (negative: its square is, softened by rotation)" if frequency[0] in "-−" else ""
        yield (
            "suspension modes, reduced model",
            f"{frequency}{soft}, {share} of their strain energy in the springs",
        )
    if properties.imbalance is not None:
        load = properties.imbalance
        yield (
            "imbalance",
            f"{load.unbalance:.4g} kg m, {load.force:.5g} N at this speed, whose static answer"
            f" closes {100.0 * load.closing:.3g} % of the clearance",
        )
    if properties.distortion is not None:
        answer = 1e3 * properties.distortion.static_displacement
        yield "casing mode loaded", _text(properties.distortion.frequency)
        yield "its static answer", f"{answer:.4g} mm"
    more = reduction.fixed_interface_modes - reduction.wanted
    pair = f", {more} more than asked, which completes a pair" if more else ""
    sets = ", ".join(f"{size} {name}" for name, size in reduction.boundary.items())
    yield (
        "reduced model",
        f"{reduction.modes} modes: {sets}, {reduction.fixed_interface_modes} fixed-interface"
        f" of {reduction.internal}{pair}",
    )
    yield (
        "its errors against the full model",
        ", ".join(f"{name} {100 * error:.2g} %" for name, error in _families(properties)),
    )
    for body, found in properties.symmetry.items():
        yield f"symmetry, {body.replace('_', ' ')}", found
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


def _families(properties: StageProperties) -> list[tuple[str, float]]:
    """Errors of the suspension pair and the first five families."""
    errors = properties.reduction.frequency_error
    shown = ("suspension", *(f"{rank}F" for rank in range(1, 6)))
    return [(name, errors[name]) for name in shown if name in errors]


def _frequencies(properties: StageProperties) -> Table:
    """Lowest frequencies by nodal diameter, side by side."""
    from rich.table import Table

    title = "lowest frequencies, full model"
    if _mixed(properties):
        title = (
            f"lowest {len(properties.bladed_disk)} frequencies, full model; k and purity of the"
            " reduced one (bladewhirl modes: all, of the full one)"
        )
    table = Table(box=None, pad_edge=False, title=title, title_justify="left")
    table.add_column("k", justify="right", style="cyan")
    for body in ("bladed disk", "casing"):
        table.add_column(f"{body} [Hz]", justify="right")
        table.add_column("normalised", justify="right")
        if _mixed(properties):
            table.add_column("purity", justify="right")
    columns = (_by_diameter(properties.bladed_disk), _by_diameter(properties.casing))
    for key in sorted({*columns[0], *columns[1]}):
        found = [column.get(key) for column in columns]
        table.add_row(
            str(key[0]) if key[0] < NO_DIAMETER else "–",
            *(text for mode in found for text in _cells(mode, mixed=_mixed(properties))),
        )
    return table


def _mixed(properties: StageProperties) -> bool:
    """Whether modes of unlike sectors hold more than one nodal diameter."""
    return any(mode.purity < PURE for mode in (*properties.bladed_disk, *properties.casing))


def _cells(mode: Mode | None, *, mixed: bool) -> tuple[str, ...]:
    if mode is None:
        return ("", "", "") if mixed else ("", "")
    cells = f"{mode.frequency.hz:.6g}", f"{mode.frequency.normalised:.5g}"
    return (*cells, f"{mode.purity:.3f}") if mixed else cells


def _by_diameter(modes: tuple[Mode, ...]) -> dict[tuple[int, int], Mode]:
    """Modes by nodal diameter and rank; those without one come last."""
    found: dict[tuple[int, int], Mode] = {}
    for mode in modes:
        key = mode.nodal_diameter if mode.nodal_diameter >= 0 else NO_DIAMETER
        rank = sum(diameter == key for diameter, _ in found)
        found[key, rank] = mode
    return found


def _text(rate: Rate) -> str:
    return (
        f"{rate.normalised:.5g} × reference = {rate.hz:.5g} Hz = {rate.rpm:.5g} rpm"
        f" = {rate.rad_per_s:.5g} rad/s"
    )
