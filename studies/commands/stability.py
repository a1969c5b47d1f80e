"""`bladewhirl stability`: at which speeds and coupling stiffnesses the stage is unstable."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from bladewhirl.studies.commands.options import (
    AsJson,
    CaseFile,
    Changes,
    Replace,
    Span,
    output_option,
    parse_speed,
    parse_stiffness,
    span_option,
)
from bladewhirl.studies.commands.output import Column, emit, facts, table
from bladewhirl.studies.commands.progress import progress_bar

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rich.table import Table

SPEEDS: Any = "0.6:3:600"
KAPPAS: Any = "0:1000:300"

ZONES = (
    Column("casing", "casing"),
    Column("rotor", "bladed disk"),
    Column("coincidence", "coincidence [ω₁]", ".4f"),
    Column("kappa", "at [N/m]", ".4g"),
    Column("lower", "from [ω₁]", ".4f"),
    Column("upper", "to [ω₁]", ".4f"),
)
"""Columns of the zones."""


def stability(
    case: CaseFile,
    speed: Annotated[
        Any,
        typer.Option(
            parser=partial(parse_speed, "--speed"),
            metavar="SPEED",
            help='One speed: multiples of ω₁, or text such as "2500 rpm".',
        ),
    ] = None,
    kappa: Annotated[
        float | None,
        typer.Option(
            parser=partial(parse_stiffness, "--kappa"),
            metavar="STIFFNESS",
            help="One coupling stiffness [N/m]; with --speed.",
        ),
    ] = None,
    speeds: Annotated[
        Span,
        span_option(
            "--speeds",
            'Speeds of the chart: times ω₁, or "2000 rpm:9000 rpm:600".',
            counted=True,
        ),
    ] = SPEEDS,
    kappas: Annotated[
        Span,
        span_option("--kappas", "Stiffnesses of the chart [N/m].", unit="N/m", counted=True),
    ] = KAPPAS,
    line: Annotated[
        float,
        typer.Option(
            parser=partial(parse_stiffness, "--line"),
            metavar="STIFFNESS",
            help="Stiffness [N/m] along which eigenvalues are drawn.",
        ),
    ] = 500.0,
    modes: Annotated[
        str,
        typer.Option(
            help='Which modes are coupled: "six" as in the paper, "all", or a list such as'
            ' "casing:1,1F:1,2F:1,suspension"; without ":k", of all nodal diameters.'
        ),
    ] = "six",
    damped: Annotated[bool, typer.Option("--damped", help="With the case's damping.")] = False,
    no_pi: Annotated[
        bool, typer.Option("--no-pi", help="Without the factor π of Eq. (8), as in Eq. (9).")
    ] = False,
    physical: Annotated[
        bool, typer.Option("--physical", help="With the modes' own amplitudes, not one for all.")
    ] = False,
    output: Annotated[
        Path | None,
        output_option("Folder to make; for a chart CASE-stability by default."),
    ] = None,
    films: Annotated[
        bool, typer.Option(help="Also the divergent mode as VTK series and GIF.")
    ] = True,
    overwrite: Replace = False,
    json: AsJson = False,
    overrides: Changes = None,
) -> None:
    """Chart growth rates over speed and coupling stiffness, or compute one point.

    Frame and bearings couple bladed disk and casing by springs of stiffness κ. A chart shows the
    unstable zones, their borders by root finding, the eigenvalues along --line and, for
    other modes than the six of the paper, what those six hide. One point (--speed and --kappa)
    gives growth rate and eigenvalues and, with -o, the divergent mode in time. With --json and no
    -o nothing is written. Where blades differ, growth rates are computed with dense matrices: this
    takes --physical, "six" is 1F,suspension,casing:1 with all modes of these families, and a chart
    has no borders of zones. Uneven casings, unequal bearings and, with --damped, dampers are
    analysed at one point only, by the monodromy matrix of a turn.

    With rotation effects modes at rest are coupled by tension, softening and Coriolis forces, too;
    "all" comes nearer to the waves at speed than "six". Past a critical speed, the growth of the
    bladed disk alone by internal damping is listed, and the bearing damping that stabilises it.
    """
    from bladewhirl.models.inputs.errors import UserError
    from bladewhirl.studies.modal import stability_report as study
    from bladewhirl.studies.modal.coupled_system import couple
    from bladewhirl.studies.modal.modes import stage_of_file

    if (speed is None) != (kappa is None):
        raise UserError("--speed, --kappa: expected both, for one point, or neither, for a chart")
    stiffnesses = kappas.values()
    folder = output
    if output is None and speed is None and not json:
        folder = Path(f"{case.stem}-stability")
    system = couple(
        stage_of_file(case, overrides, "the stability of coupled modes", "centrifugal", "full"),
        modes=modes,
        damped=damped,
        with_pi=not no_pi,
        physical=physical,
        chart=speed is None,
    )
    if kappa is not None:
        omega = speed.rad_per_s(system.reference)
        document = study.point_report(
            system, omega, kappa, folder, films=films, overwrite=overwrite
        )
        parts = [_point(document)]
    else:
        omegas = speeds.values(system.reference) * system.reference
        with progress_bar("growth rates") as progress:
            document = study.chart_report(
                system,
                omegas,
                stiffnesses,
                folder,
                line=line,
                overwrite=overwrite,
                progress=progress,
            )
        parts = [*_chart(document)]
    emit(document, *parts, json=json, written=[folder])


def _point(point: dict[str, Any]) -> Table:
    verdict = "unstable" if point["unstable"] else "stable"
    texts = {
        "speed": f"{point['speed']:.6g} ω₁ = {point['speed_rad_per_s']:.6g} rad/s",
        "coupling stiffness": f"{point['kappa']:.6g} N/m",
        "coupled modes": ", ".join(point["modes"]),
        "growth rate": f"{point['growth_rate']:.6g} 1/s ({verdict})",
    }
    if "growth_rate_floquet" in point:
        texts["growth rate, monodromy"] = f"{point['growth_rate_floquet']:.6g} 1/s"
    for name, value in point.get("coupled_mode", {}).items():
        unit = " rad/s" if "speed" in name else "°" if "degrees" in name else ""
        texts[name.removesuffix("_degrees").replace("_", " ")] = f"{value:.6g}{unit}"
    return facts(texts | _rotor_alone(point))


def _chart(chart: dict[str, Any]) -> Iterator[Table]:
    """Yield the zones of a chart at their largest stiffness, and its largest growth rate."""
    if "zones" in chart:
        rows = [
            zone | {key: zone[key][-1] for key in ("kappa", "lower", "upper")}
            for zone in chart["zones"]
        ]
        yield table(rows, ZONES, "Unstable zones")
    place = f"at {chart['at_speed']:.4g} ω₁ and {chart['at_kappa']:.4g} N/m"
    texts = {
        "largest growth rate": f"{chart['largest_growth_rate']:.4g} 1/s {place}",
        "unstable share of the chart": f"{100.0 * chart['unstable_share']:.3g} %",
    }
    yield facts(texts | _rotor_alone(chart))


def _rotor_alone(document: dict[str, Any]) -> dict[str, str]:
    """Return the stability of the bladed disk alone at the speed, or the highest, in texts."""
    if document.get("critical_speed") is None:
        return {}
    texts = {"critical speed": f"{document['critical_speed']:.5g} ω₁"}
    growth, k = document["rotor_growth_rate"], document["rotor_nodal_diameter"]
    if document["rotation_effects"] == "centrifugal":
        texts["note"] = "past it only Coriolis forces, rotation.effects = full, stabilise a rotor"
        return texts
    texts["growth rate, bladed disk alone"] = f"{growth:.4g} 1/s, k = {k}"
    if document["waves_met"]:
        texts["cause"] = "two of its waves have merged; it grows without damping"
    elif growth > 0.0:
        damping = document["holding_damping"]
        texts["cause"] = "internal damping of its forward wave"
        texts["bearing damping that stabilises it"] = (
            "none" if damping is None else f"{damping:.4g} N s/m in each of two static bearings"
        )
    return texts
