"""Commands that analyse modes, before a march; each prints what a function of `studies.modal`
computes."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from bladewhirl.models.inputs.errors import UserError
from bladewhirl.studies.commands import options
from bladewhirl.studies.commands.terminal import (
    QUIET,
    emit,
    name_written,
    progress_bar,
)

if TYPE_CHECKING:
    from collections.abc import Mapping

    from bladewhirl.meshes.line_mesh import FloatArray
    from bladewhirl.models.modal.modal_model import ModalModel
    from bladewhirl.studies.modal.study import Study

# Typer parses these defaults.
RESPONSE_SPEEDS: Any = "0.1:2:0.005"
CHART_SPEEDS = "0.6:3:0.004"
LINE_SPEEDS = "0:3:0.03"
CHART_KAPPAS: Any = "0:1000:4"


def modes(
    case: options.CaseFile,
    count: options.Number = 60,
    json: options.AsJson = False,
    output: options.Output = None,
    shapes: Annotated[str | None, typer.Option(metavar="NAMES")] = None,
    animate: Annotated[str | None, typer.Option(metavar="NAMES")] = None,
    wave: str | None = None,
    films: bool = True,
    contact: Annotated[bool, typer.Option("--contact")] = False,
    overwrite: options.Replace = False,
    overrides: options.Changes = None,
) -> None:
    """List natural frequencies of the full bladed disk, with the centre as in the case, and of the
    casing.

    Normalised frequencies are multiples of the lowest frequency with a free centre, ω₁. The column
    "springs" is the share of the shaft springs in the strain energy. Purity is the share of the
    listed nodal diameter in a mode; it is not shown if all blades are equal, because it is 1. At
    speed, the branch with most of its strain energy in the shaft springs is the suspension; the
    column "at rest" gives the name of the same branch at rest. -o DIR writes
    pictures of mode shapes; contact scenarios of the first k = 1 mode at the speed at which it
    coincides with the k = 1 mode of the casing; and films, with a picture of each travelling wave.
    With Coriolis forces, pictures and films show the waves at the speed of the case. A superelement
    is drawn at the points of its file; its films need triangles there.

    Args:
        count: Number of modes of each body, from the lowest on; a pair of equal frequencies has one
            row.
        output: Folder to make for pictures and films.
        shapes: Modes to draw: "1F:0,1F:1,suspension,casing:1F:2"; without ":k", all nodal
            diameters. Where blades differ, all modes of a name are drawn. By default 1F with
            k = 0, 1, ... and the highest k, the suspension, and the lowest modes of the casing.
        animate: Modes to film. By default 1F:1, and suspension if there is one.
        wave: Wave of films: standing, forward or backward. By default the wave that contact
            amplifies: backward on the bladed disk, forward on the casing.
        films: Write films, as GIF and as VTK series.
        contact: List in place of all this, for three families of equal blades: frequencies with
            free tips and with tips held by the wall, the clearance that a mode consumes divided by
            its largest displacement of a tip, and the friction coefficient above which it locks.
    """
    given = {"--shapes": shapes, "--animate": animate, "--wave": wave, "--contact": contact or None}
    if found := _of_line(case, overrides, given, "modes", count=count):
        present(found, case, output, overwrite=overwrite, json=json, unnamed=output is None)
        return
    for name, value in {"--shapes": shapes, "--animate": animate, "--wave": wave}.items():
        if output is None and value is not None:
            raise UserError(f"{name}: needs a folder for the pictures, -o DIR")
    if contact:
        from bladewhirl.studies.modal.contact_modes import contact_modes
        from bladewhirl.studies.modal.contact_modes import report as of_contact

        if output is not None:
            raise UserError("--contact: expected no -o: it draws nothing")
        present(
            of_contact(contact_modes(_model(case, overrides))),
            case,
            None,
            overwrite=False,
            json=json,
        )
        return

    stage = _model(case, overrides, count=2 * count)  # of pairs
    from bladewhirl.studies.modal import modes as study

    if output is not None:
        from bladewhirl.studies.modal.mode_pictures import draw_modes, plan_pictures

        plan = plan_pictures(stage, shapes=shapes, animate=animate if films else "", wave=wave)
    listed = study.mode_lists(stage)
    report, hertz = study.report(listed, count), listed.attrs["reference_frequency_hz"]
    emit(report.document, *report.tables, f"ω₁ = {hertz:.6g} Hz", json=json)
    _print_hints(report)
    if output is not None:
        draw_modes(stage, plan, output, overwrite=overwrite)
        name_written([output], json=json)


def campbell(
    case: options.CaseFile,
    speeds: Annotated[options.Span | None, options.span("--speeds")] = None,
    operating: Annotated[options.Span | None, options.span("--operating")] = None,
    orders: Annotated[str | None, typer.Option(metavar="NUMBERS")] = None,
    families: options.Number = 5,
    output: options.CaseFolder = None,
    html: options.File = None,
    overwrite: options.Replace = False,
    json: options.AsJson = False,
    overrides: options.Changes = None,
) -> None:
    """Find coincidence speeds, and draw a Campbell diagram in the rotating and one in the static
    frame.

    Where k Ω = ω_casing + ω_rotor, Eq. (14), a forward wave on the casing and a backward wave on
    the rotor travel at the same speed in space, and contact amplifies both waves. The table lists
    the coincidence speeds inside --speeds; JSON lists all coincidence speeds, for every nodal
    diameter and family. A second table lists the speeds at which the lobes of the wall and engine
    orders excite the bladed disk, with free and with held tips: the resonance in a rub lies between
    both. With --operating they are sorted by their distance from it, and a last table lists the
    speeds to avoid in and near this range, with cause and margin. With --json or --html a folder is
    made only if -o names it.

    Args:
        speeds: Speeds of the diagrams: multiples of ω₁, or "2000 rpm:9000 rpm"; by default to 3, or
            to thrice the speed of the case if that is lower.
        operating: Operating range to shade and to mark in the table: multiples of ω₁, or
            "40 Hz:60 Hz"; by default none.
        orders: Orders besides those of the case, such as "1,2,6".
        families: Number of families of the bladed disk, without the suspension pair.
        html: Write both diagrams as an interactive page, FILE.html.
    """

    def widest(reference: float) -> FloatArray:
        from bladewhirl.studies.modal.campbell import WIDEST

        return options.Span("--speeds", (0.0, WIDEST)).values(reference)

    given = {"--operating": operating, "--orders": orders, "--html": html}
    of_line = speeds.values if speeds else widest
    if found := _of_line(case, overrides, given, "campbell", speeds=of_line, families=families):
        present(found, case, output, overwrite=overwrite, json=json)
        return
    if html is not None:
        from bladewhirl.postprocess.plotting.files import checked_target

        checked_target(html, ".html")
    stage = _model(case, overrides, speeds, families=families)
    from bladewhirl.studies.modal import campbell as study

    shown, operated = (
        None if given is None else tuple(given.values(stage.reference_frequency).tolist())
        for given in (speeds, operating)
    )
    diagram = study.campbell(
        stage,
        families=families,
        speeds=shown,
        operating=operated,
        orders=_whole_numbers("--orders", orders),
    )
    computed = study.report(diagram, page=html, overwrite=overwrite)
    present(computed, case, output, overwrite=overwrite, json=json)


def veering(
    case: options.CaseFile,
    families: options.Number = 12,
    stiffnesses: options.Stiffnesses = None,
    output: options.CaseFolder = None,
    overwrite: options.Replace = False,
    json: options.AsJson = False,
    overrides: options.Changes = None,
) -> None:
    """Draw frequencies against nodal diameter and against the stiffness of the shaft.

    The first two diagrams show frequencies of the full bladed disk against nodal diameter, with a
    free and with a clamped centre: many families, and the first two families with the suspension
    pair. The third shows the modes with one nodal diameter against the stiffness of the shaft
    springs, where the character of the suspension pair passes from branch to branch. A superelement
    needs the centre of a wheel. With --json and no -o nothing is written.

    Args:
        families: Number of families in the first diagram, without the suspension pair.
    """
    interval = None if stiffnesses is None else stiffnesses.values()
    stage = _model(case, overrides, families=families)
    from bladewhirl.studies.modal import veering as study

    springs = study.spring_stiffnesses(stage.case, interval)
    computed = study.report(study.veering(stage, families=families, stiffnesses=springs))
    present(computed, case, output, overwrite=overwrite, json=json)


def critical_speeds(
    case: options.CaseFile,
    branches: options.Number = 2,
    stiffnesses: options.Stiffnesses = None,
    output: options.CaseFolder = None,
    overwrite: options.Replace = False,
    json: options.AsJson = False,
    overrides: options.Changes = None,
) -> None:
    """Draw the map of critical speeds against the stiffness of the shaft.

    At a critical speed the shaft whirls at the speed of rotation: forward, as an imbalance drives
    it, or backward; on unequal bearings it whirls in an ellipse. The table lists the critical
    speeds with the stiffness of the case. The case needs rotation.effects = "full"; a superelement
    needs the centre of a wheel. With --json and no -o nothing is written.

    Args:
        branches: Number of branches in each direction of whirl.
    """
    given = {"--stiffnesses": stiffnesses}
    if found := _of_line(case, overrides, given, "critical_speeds", branches=branches):
        present(found, case, output, overwrite=overwrite, json=json)
        return
    interval = None if stiffnesses is None else stiffnesses.values()
    model = _model(case, overrides)
    from bladewhirl.studies.modal import critical_speeds as study

    computed = study.report(model, branches, interval)
    present(computed, case, output, overwrite=overwrite, json=json)


def response(
    case: options.CaseFile,
    speeds: options.Speeds = RESPONSE_SPEEDS,
    draws: options.MaybeNumber = None,
    output: options.CaseFolder = None,
    overwrite: options.Replace = False,
    json: options.AsJson = False,
    overrides: options.Changes = None,
) -> None:
    """Compute the steady response to engine-order forces at many speeds, without contact.

    The case needs excitation.type = "engine-order", or unbalances of a shaft line. The equations
    of motion of the time integration, with damping, mistuning and rotation effects, are solved for
    the complex amplitude at each speed. The table lists the peaks of each engine order; the figure
    shows the amplitudes of all blades and of nodal diameters against the speed. A blade with
    several contact nodes moves by their mean. With --draws, the table and the figure show how much
    mistuning amplifies the largest peak of the tuned blades, for random patterns of the stiffness
    of blades (bladed_disk.mistuning.stiffness_spread). With [[joint]] table and figure have the
    linear limits beside each other: joints free, closed without friction, and stuck; bladewhirl
    periodic has the amplitudes with friction. With --json and no -o nothing is written.

    Args:
        speeds: Speeds of rotation: multiples of ω₁, or "2000 rpm:9000 rpm:10 rpm"; the stop is
            included.
        draws: Number of random patterns of the stiffness of blades.
    """
    if line := _of_line(case, overrides, {"--draws": draws}, "response", speeds=speeds.values):
        present(line, case, output, overwrite=overwrite, json=json)
        return
    given, items = speeds.speeds, "speeds" if draws is None else "patterns"
    with (
        options.case_of(case, overrides) as read,
        progress_bar(items, lines=items, quiet=QUIET) as progress,
    ):
        if draws is None:
            from bladewhirl.studies.modal import response as study

            found = study.report(study.response(read, speeds=given, progress=progress))
        else:
            from bladewhirl.studies.modal.amplification import amplification, report

            found = report(amplification(read, draws=draws, speeds=given, progress=progress))
    present(found, case, output, overwrite=overwrite, json=json)


def stability(
    case: options.CaseFile,
    speed: Annotated[Any, options.speed("--speed")] = None,
    kappa: Annotated[float | None, options.stiffness("--kappa")] = None,
    speeds: options.MaybeSpeeds = None,
    kappas: Annotated[
        options.Span, options.span("--kappas", unit="N/m", stepped=True)
    ] = CHART_KAPPAS,
    line: Annotated[float, options.stiffness("--line")] = 500.0,
    modes: str = "six",
    damped: Annotated[bool, typer.Option("--damped")] = False,
    no_pi: Annotated[bool, typer.Option("--no-pi")] = False,
    physical: Annotated[bool, typer.Option("--physical")] = False,
    output: options.CaseFolder = None,
    films: bool = True,
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

    Of a shaft line, the table lists the speeds at which growth by internal damping or by cross
    terms of bearings begins or ends, and the figure shows the largest growth rate over --speeds.

    Args:
        speed: One speed: multiples of ω₁, or text such as "2500 rpm".
        kappa: One coupling stiffness [N/m], together with --speed.
        speeds: Speeds of the chart: multiples of ω₁, or "2000 rpm:9000 rpm:10 rpm"; the stop is
            included. By default 0.6:3:0.004, of a shaft line 0:3:0.03.
        kappas: Stiffnesses of the chart [N/m].
        line: Stiffness [N/m] of the figure of eigenvalues against speed.
        modes: Modes to couple: "six" as in the paper, "all", or a list such as
            "casing:1,1F:1,2F:1,suspension"; without ":k", modes of all nodal diameters.
        damped: Include the damping of the case.
        no_pi: Leave out the factor π of Eq. (8), as in Eq. (9).
        physical: Use the physical amplitude of each mode, not unit amplitudes.
        films: Also write the divergent mode as VTK series and GIF.
    """
    given = {"--speed": speed, "--kappa": kappa}
    of_line = speeds or options.steps("--speeds", LINE_SPEEDS)
    if found := _of_line(case, overrides, given, "stability", speeds=of_line.values):
        present(found, case, output, overwrite=overwrite, json=json)
        return
    if (speed is None) != (kappa is None):
        raise UserError("--speed, --kappa: expected both, for one point, or neither, for a chart")
    stiffnesses, model = kappas.values(), _model(case, overrides)
    from bladewhirl.models.stage.modal import full_models
    from bladewhirl.studies.modal import stability_report as study
    from bladewhirl.studies.modal.coupled_system import couple
    from bladewhirl.studies.modal.stability import NEEDS

    system = couple(
        full_models(model, "stability", NEEDS),
        modes=modes,
        damped=damped,
        with_pi=not no_pi,
        physical=physical,
        chart=speed is None,
    )
    if kappa is not None:
        omega = speed.rad_per_s(system.reference)
        computed = study.point_report(
            system, omega, kappa, output, films=films, overwrite=overwrite
        )
    else:
        charted = speeds or options.steps("--speeds", CHART_SPEEDS)
        omegas = charted.values(system.reference) * system.reference
        with progress_bar("growth rates") as update:
            computed = study.chart_report(system, omegas, stiffnesses, line=line, progress=update)
    present(computed, case, output, overwrite=overwrite, json=json)


def _of_line(
    case: Path,
    overrides: list[str] | None,
    given: Mapping[str, object],
    name: str,
    **arguments: Any,
) -> Study | None:
    """Return a study of the shaft line of a case file with changes; None if it has a bladed disk.

    Args:
        case: case file.
        overrides: changes.
        given: options that a shaft line does not have, by name.
        name: function of `studies.shaft_line.reports`.
        arguments: its arguments.
    """
    with options.case_of(case, overrides) as read:
        if read.shaft_line is None:
            return None
        from bladewhirl.studies.shaft_line import reports

        options.omitted("[shaft_line]", given)
        study: Study = getattr(reports, name)(read, **arguments)
        return study


def _whole_numbers(name: str, given: str | None) -> tuple[int, ...]:
    """Return the positive whole numbers of a list with commas."""
    words = [] if given is None else given.replace(",", " ").split()
    if not all(word.isdecimal() and int(word) for word in words):
        raise UserError(f'{name} {given}: expected whole numbers of 1 or more, such as "1,2,6"')
    return tuple(map(int, words))


def _model(
    case: Path, overrides: list[str] | None, speeds: options.Span | None = None, **numbers: int
) -> ModalModel:
    """Return bladed disk and casing of a case file with changes, in their modes, for the speeds of
    an option; `numbers` are those of `modal_model`."""
    with options.case_of(case, overrides) as read:
        from bladewhirl.models.case.plausibility import speed_hint
        from bladewhirl.models.stage.modal import modal_model

        model = modal_model(read, **numbers)
        reference = model.reference_frequency
        highest = 0.0 if speeds is None else speeds.values(reference)[-1] * reference
        model = model.covering(float(highest))
    if hint := speed_hint(model.case, model.speed):
        typer.echo(f"Hint: {hint}.", err=True)
    return model


def present(
    study: Study,
    case: Path,
    output: Path | None,
    *,
    overwrite: bool,
    json: bool,
    unnamed: bool = False,
) -> None:
    """Print the tables or the JSON document of a study; then draw its figures into the folder that
    the user named, or into CASE-COMMAND if nothing else is written and `unnamed` is false."""
    unnamed = unnamed or json or study.figures is None or study.page is not None
    folder = output if output is not None or unnamed else Path(f"{case.stem}-{study.name}")
    emit(study.document, *study.tables, json=json)
    _print_hints(study)
    if folder is not None:
        study.draw(folder, overwrite=overwrite)
    name_written([folder, study.page], json=json)


def _print_hints(study: Study) -> None:
    if study.hints:
        typer.echo(f"Hint: {study.hints}.", err=True)
