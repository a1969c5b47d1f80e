"""`bladewhirl stability`: speeds and coupling stiffnesses at which the stage is unstable."""

from pathlib import Path
from typing import Annotated, Any

import typer

from bladewhirl.studies.commands import options
from bladewhirl.studies.commands.output import emit, facts, table
from bladewhirl.studies.commands.progress import progress_bar
from bladewhirl.studies.modal.columns import texts

SPEEDS: Any = "0.6:3:600"
KAPPAS: Any = "0:1000:300"


def stability(
    case: options.CaseFile,
    speed: Annotated[
        Any, options.speed("--speed", 'One speed: multiples of ω₁, or text such as "2500 rpm".')
    ] = None,
    kappa: Annotated[
        float | None,
        options.stiffness("--kappa", "One coupling stiffness [N/m], together with --speed."),
    ] = None,
    speeds: Annotated[
        options.Span,
        options.span(
            "--speeds",
            'Speeds of the chart: multiples of ω₁, or "2000 rpm:9000 rpm:600".',
            counted=True,
        ),
    ] = SPEEDS,
    kappas: Annotated[
        options.Span,
        options.span("--kappas", "Stiffnesses of the chart [N/m].", unit="N/m", counted=True),
    ] = KAPPAS,
    line: Annotated[
        float,
        options.stiffness("--line", "Stiffness [N/m] of the figure of eigenvalues against speed."),
    ] = 500.0,
    modes: Annotated[
        str,
        typer.Option(
            help='Modes to couple: "six" as in the paper, "all", or a list such as'
            ' "casing:1,1F:1,2F:1,suspension"; without ":k", modes of all nodal diameters.'
        ),
    ] = "six",
    damped: Annotated[
        bool, typer.Option("--damped", help="Include the damping of the case.")
    ] = False,
    no_pi: Annotated[
        bool, typer.Option("--no-pi", help="Leave out the factor π of Eq. (8), as in Eq. (9).")
    ] = False,
    physical: Annotated[
        bool,
        typer.Option(
            "--physical", help="Use the physical amplitude of each mode, not unit amplitudes."
        ),
    ] = False,
    output: options.CaseFolder = None,
    films: Annotated[
        bool, typer.Option(help="Also write the divergent mode as VTK series and GIF.")
    ] = True,
    overwrite: options.Replace = False,
    json: options.AsJson = False,
    overrides: options.Changes = None,
) -> None:
    """Chart growth rates against speed and coupling stiffness, or compute one point.

    Bladed disk and casing are coupled by springs of stiffness κ, which represent frame and
    bearings. A chart shows the unstable zones, with borders by root finding, and the eigenvalues
    along --line. If --modes is not "six", a figure shows zones that the six modes of the paper
    miss. One point (--speed and --kappa) gives growth rate and eigenvalues and, with -o, the
    divergent mode in time. With --json and no -o nothing is written. If blades differ, growth rates
    are computed with dense matrices: --physical is required, "six" means 1F,suspension,casing:1
    with all modes of these families, and a chart has no borders of zones. With an uneven casing,
    unequal bearings or, with --damped, dampers, only one point can be analysed, by the monodromy
    matrix of a turn.

    With rotation effects the modes at rest are also coupled by tension, softening and Coriolis
    forces; "all" represents the waves at speed more accurately than "six". Above a critical speed,
    the growth rate of the uncoupled bladed disk by internal damping is listed, and the bearing
    damping that stabilises it.
    """
    from bladewhirl.models.inputs.errors import UserError
    from bladewhirl.studies.modal import stability_report as study
    from bladewhirl.studies.modal.coupled_system import couple
    from bladewhirl.studies.modal.modes import stage_of_file

    if (speed is None) != (kappa is None):
        raise UserError("--speed, --kappa: expected both, for one point, or neither, for a chart")
    stiffnesses = kappas.values()
    folder = output if output or kappa is not None or json else Path(f"{case.stem}-stability")
    system = couple(
        stage_of_file(case, overrides),
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
        verdict = "unstable" if document["unstable"] else "stable"
        values = texts(document | {"stability": verdict}, (*study.POINT, *study.MOTION))
        tables = []
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
        values = texts(document, study.CHART)
        zones = [
            zone | {column.key: zone[column.key][-1] for column in study.BORDERS}
            for zone in document.get("zones", [])
        ]
        tables = [table(zones, study.ZONES, "Unstable zones")] if "zones" in document else []
    values |= texts(document | _cause(document), study.ROTOR_ALONE)
    emit(document, *tables, facts(values), json=json, written=[folder])


def _cause(document: dict[str, Any]) -> dict[str, str]:
    """Return the cause of growth of the uncoupled bladed disk above a critical speed, if any."""
    if document.get("critical_speed") is None:
        return {}
    if document["rotation_effects"] == "centrifugal":
        return {"cause": "no Coriolis forces; only rotation.effects = full stabilises a rotor"}
    if document["waves_met"]:
        return {"cause": "two waves of the bladed disk have merged; they grow without damping"}
    if document["rotor_growth_rate"] <= 0.0:
        return {}
    limit = ", which no bearing damping stabilises" if document["holding_damping"] is None else ""
    return {"cause": f"internal damping of the forward wave{limit}"}
