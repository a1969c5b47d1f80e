"""`bladewhirl stability`: at which speeds and coupling stiffnesses the stage is unstable."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from bladewhirl.studies.commands.options import (
    AsJson,
    CaseFile,
    Changes,
    Replace,
    not_negative,
    parse_range,
    parse_speed_range,
)


def stability(
    case: CaseFile,
    speed: Annotated[
        str | None,
        typer.Option(help='One speed: multiples of ω₁, or text such as "2500 rpm".'),
    ] = None,
    kappa: Annotated[
        float | None, typer.Option(help="One coupling stiffness [N/m]; with --speed.")
    ] = None,
    speeds: Annotated[
        str,
        typer.Option(
            metavar="START:STOP:COUNT",
            help='Speeds of the chart: times ω₁, or "2000 rpm:9000 rpm:600".',
        ),
    ] = "0.6:3:600",
    kappas: Annotated[
        str, typer.Option(metavar="START:STOP:COUNT", help="Stiffnesses of the chart [N/m].")
    ] = "0:1000:300",
    line: Annotated[
        float, typer.Option(help="Stiffness [N/m] along which eigenvalues are drawn.")
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
        typer.Option(
            "--output", "-o", help="Folder to make; for a chart CASE-stability by default."
        ),
    ] = None,
    films: Annotated[
        bool, typer.Option(help="Also the divergent mode as VTK series and GIF.")
    ] = True,
    overwrite: Replace = False,
    json: AsJson = False,
    overrides: Changes = None,
) -> None:
    """Chart growth rates over speed and coupling stiffness, or look at one point.

    Frame and bearings couple bladed disk and casing by springs of stiffness κ. A chart shows the
    unstable zones, their borders found by root finding, the eigenvalues along --line and, for
    other modes than the six of the paper, what those six hide. One point (--speed and --kappa)
    gives growth rate and eigenvalues and, with -o, the divergent mode in time. With --json and no
    -o nothing is written. Where blades differ, growth rates are found by dense matrices: this
    takes --physical, "six" is 1F,suspension,casing:1 with all modes of these families, and a chart
    has no borders of zones. Uneven casings, unequal bearings and, with --damped, dampers are
    looked at one point at a time, by the monodromy matrix of a turn.

    With rotation effects modes at rest are coupled by tension, softening and Coriolis forces, too;
    "all" comes nearer to the waves at speed than "six". Past a critical speed it is told where
    internal damping feeds the bladed disk, and the bearing damping that holds it.
    """
    from bladewhirl.models.inputs.errors import UserError
    from bladewhirl.studies.modal.coupled_system import couple
    from bladewhirl.studies.modal.modes import stage_of_file
    from bladewhirl.studies.modal.stability import given_speed
    from bladewhirl.studies.modal.stability_report import report_chart, report_point

    if (speed is None) != (kappa is None):
        raise UserError("--speed, --kappa: expected both, for one point, or neither, for a chart")
    speed_range = parse_speed_range("--speeds", speeds)
    kappa_range = parse_range("--kappas", kappas, "N/m")
    not_negative("--line", line)
    not_negative("--kappa", kappa or 0.0)
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
    if speed is not None and kappa is not None:
        omega = given_speed(speed).rad_per_s(system.reference)
        drawn = {"films": films, "overwrite": overwrite}
        report_point(system, omega, kappa, folder, as_json=json, **drawn)
    else:
        omegas = speed_range(system.reference) * system.reference
        report_chart(
            system, omegas, kappa_range, folder, line=line, overwrite=overwrite, as_json=json
        )
