"""Command that computes periodic motions without time integration."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from bladewhirl.models.inputs.errors import UserError
from bladewhirl.studies.commands import options
from bladewhirl.studies.commands.modal import present
from bladewhirl.studies.commands.terminal import emit, interruptible, progress_bar

if TYPE_CHECKING:
    from bladewhirl.models.case.case import Case


def periodic(
    context: typer.Context,
    case: options.NewCase = None,
    speeds: Annotated[Any, options.speeds("--speeds")] = None,
    over: Annotated[str | None, typer.Option(metavar="KEY=START:STOP")] = None,
    blade: Annotated[int, typer.Option(min=0)] = 0,
    points: Annotated[int | None, typer.Option(min=1)] = None,
    periods: Annotated[int, typer.Option(min=1)] = 1,
    origin: Annotated[Path | None, typer.Option("--from")] = None,
    resume: options.Resume = None,
    output: options.CaseFolder = None,
    overwrite: options.Replace = False,
    json: options.AsJson = False,
    overrides: options.Changes = None,
) -> None:
    """Compute periodic motions of a 3D blade that rubs on a wall, without time integration.

    The motion has the period of the wall and of engine orders, a turn divided by their common
    number of lobes. The table lists its stability: a multiplier is the factor by which a small
    deviation grows in a period; the motion is stable if all are less than 1 in magnitude. There can
    be more than one periodic motion, and the one that is found is not always that of a march from
    rest. A speed without contact, or at which no motion is found, is reported after the others, and
    the exit code is 2. The case needs a superelement with massless contact nodes in a rigid wall,
    or one of the kind "blade" in a uniform flexible casing, in which equal blades follow one
    another. With --json and no -o nothing is written.

    With an imbalance and a round wall, rigid or flexible, the contact of any bladed disk is
    constant in rotating axes, also above critical speeds and with dampers in the static frame; its
    forces, the radius of the shaft and its stability are computed. There can be several such states
    at a speed, which are all listed. So is that of a wheel on a shaft line with equal bearings, an
    unbalance and no weight.

    With [[joint]], and with a sector or a wheel, the motion is that of all blades of a tuned wheel,
    which touch each other in friction joints and a rigid wall, under engine orders; it is computed
    from one blade or sector. The table lists amplitudes, forces, states and work of the joints and
    of the wall, and stability over deviations of all blades. With --over march.speed,
    joint.NAME.preload, joint.NAME.friction, casing.clearance or excitation.amplitude the motion is
    followed over the key; the figure marks the smallest amplitude. With --over and --speeds, the
    table and the figure are the design curve of the joints: the largest amplitude over the speeds
    at each value of the key, with those of joints that are free, closed without friction and
    stuck, and the value with the smallest one.

    With one speed the folder also has a turn of the motion as a run, result.nc, of which
    bladewhirl render, export and plot make films, series for ParaView and figures; not where the
    motion is that of all blades of a tuned wheel, of which bladewhirl run makes such a record.

    With --over the motion is followed over a key of the case through folds, at which marches jump.
    The table lists folds, period doublings and Neimark-Sacker bifurcations (quasi-periodic
    motions), each confirmed with twice as many instants. branch.nc is written point by point, and
    --resume DIR continues it after an interruption; not with [[joint]] or constant contact, where
    it is written at the end.

    Args:
        speeds: Speeds of rotation: multiples of ω₁, or such as "5000 rpm,5200 rpm"; by default the
            speed of the case; also "5000 rpm:6000 rpm:50 rpm".
        over: Key of the case and its range, such as march.speed=5000rpm:9000rpm or
            "casing.clearance=0.4 mm:0.3 mm"; the branch begins at START.
        blade: Number of the blade; in a rigid wall blades do not influence each other, in a
            flexible casing all have the same motion one after another.
        points: Number of the longest steps from START to STOP, 50 by default; steps are shorter
            where forces change. With --speeds, the number of values of the key, 12 by default.
        periods: Number of periods of the wall and the engine orders in a period of the motion: 2
            for motions after a period doubling.
        origin: Folder of a run, whose last period begins the search at each speed or the branch,
            or of a branch, whose last point does.
        resume: Continue the branch in this folder.
    """
    if resume is not None:
        options.only(context, "--resume", "resume", "json")
        _resume(resume, json=json)
        return
    if case is None:
        raise UserError("periodic: expected either CASE or --resume DIR")
    if over is not None:
        folder = output if json or output is not None else Path(f"{case.stem}-periodic")
        with options.case_of(case, overrides) as read:
            if not read.joint:
                options.omitted("--over without [[joint]]", {"--speeds": speeds})
            _branch(
                read,
                over,
                speeds,
                blade,
                points,
                periods,
                origin,
                folder,
                overwrite=overwrite,
                json=json,
            )
        return
    options.omitted("speeds", {"--points": points})

    with options.case_of(case, overrides) as read, progress_bar("speeds") as progress:
        from bladewhirl.studies.periodic import motions as study

        given = None if speeds is None else [each.given for each in speeds]
        data = study.periodic(
            read, speeds=given, blade=blade, periods=periods, origin=origin, progress=progress
        )
    folder = output if json or output is not None else Path(f"{case.stem}-periodic")
    present(study.report(data), case, output, overwrite=overwrite, json=json)
    failures = study.failures(data)
    if folder is not None and len(set(data["speed"].values)) == 1 and "joint" not in data.dims:
        from bladewhirl.models.inputs.errors import CaseError
        from bladewhirl.postprocess.fields.kinematics import ViewError
        from bladewhirl.studies.periodic.records import record_motion

        try:
            record_motion(read, data, folder, overwrite=True)
        except (ViewError, CaseError) as reason:  # of the march, which no result depends on
            typer.echo(f"Hint: no record for films: {reason.lines[0]}.", err=True)
    if failures:
        raise UserError(*failures)


def _branch(
    case: Case,
    over: str,
    speeds: Any,
    blade: int,
    points: int | None,
    periods: int,
    origin: Path | None,
    folder: Path | None,
    *,
    overwrite: bool,
    json: bool,
) -> None:
    """Follow a branch and print it."""
    from bladewhirl.postprocess.periodic.dataset import BRANCH_NAME
    from bladewhirl.studies.joints.motions import applies
    from bladewhirl.studies.periodic import branches as study

    key, start, stop = study.parse_over(over)
    remedy = f"bladewhirl periodic --resume {folder} continues"
    kept = None if folder is None else folder / BRANCH_NAME  # not written on the way by all studies
    with progress_bar("branch") as update, interruptible(remedy, kept, new=True):
        data = study.branch(
            case,
            key,
            start,
            stop,
            blade=blade,
            points=points,
            speeds=None if speeds is None else [each.given for each in speeds],
            periods=periods,
            origin=origin,
            directory=None if applies(case) else folder,
            overwrite=overwrite,
            progress=lambda share, done: update(int(share * 100), 100, text=f"{done} points"),
        )
    _present(data, folder, json=json)


def _resume(folder: Path, *, json: bool) -> None:
    """Continue a branch and print it."""
    from bladewhirl.studies.periodic import branches as study

    remedy = f"bladewhirl periodic --resume {folder} continues"
    with progress_bar("branch") as update, interruptible(remedy, folder):
        data = study.resume_branch(
            folder,
            progress=lambda share, done: update(int(share * 100), 100, text=f"{done} points"),
        )
    _present(data, folder, json=json)


def _present(data: Any, folder: Path | None, *, json: bool) -> None:
    """Draw and print a branch.

    Raises:
        UserError: the branch was lost or stopped.
    """
    from bladewhirl.studies.periodic import branches as study

    computed = study.report(data)
    if folder is not None:
        computed.draw(folder, overwrite=True)
    emit(computed.document, *computed.tables, json=json, written=[folder])
    if computed.hints:
        typer.echo(f"Hint: {computed.hints}.", err=True)
    ended = str(data.attrs["ended"])
    if ended.startswith(study.FAILED):
        raise UserError(f"branch {ended}")
    if not json:
        typer.echo(f"The branch {ended}.")
