"""`bladewhirl sweep`: march a case at many points, on all cores or a cluster."""

from __future__ import annotations

from collections.abc import Iterable
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from bladewhirl.models.inputs.errors import UserError
from bladewhirl.studies.commands.exits import ALL_FAILED, interruptible
from bladewhirl.studies.commands.options import (
    AsJson,
    Changes,
    Scheduler,
    Workers,
    print_json,
    refuse_both,
)
from bladewhirl.studies.commands.progress import progress_bar

if TYPE_CHECKING:
    from bladewhirl.studies.sweeps.plan import Plan
    from bladewhirl.studies.sweeps.sweep import Sweep


class StopWhen(StrEnum):
    """What a march ends early for."""

    DAMPED = "damped"


SHOWN_FAILURES = 10
"""Failed points that are listed on screen; failures.json lists all."""


def sweep(
    case: Annotated[
        Path | None, typer.Argument(help="Case file; none with --resume.", show_default=False)
    ] = None,
    over: Annotated[
        list[str] | None,
        typer.Option(
            "--over",
            metavar="KEY=VALUES",
            help="A number of the case and what it runs over: march.speed=0.95:2:0.005"
            " (start:stop:step, the stop included) or contact.friction=0.05,0.1; units as in the"
            ' case file, "casing.clearance=0.5 mm,1 mm". Several: all combinations.',
        ),
    ] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="DIR", help="Folder to make.")
    ] = None,
    overrides: Changes = None,
    scheduler: Scheduler = None,
    workers: Workers = None,
    histories: Annotated[
        bool, typer.Option("--histories", help="Keep the full history of every point.")
    ] = False,
    stop_when: Annotated[
        StopWhen | None,
        typer.Option(
            "--stop-when",
            help="End a march early when its answer is known: damped, free motion that has too"
            " little energy left to touch again.",
        ),
    ] = None,
    resume: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Finish the sweep in this folder.")
    ] = None,
    yes: Annotated[
        bool, typer.Option("--yes", help="Run more than 100,000 points, or 1e9 steps of one.")
    ] = False,
    dashboard: Annotated[
        bool,
        typer.Option(
            "--dashboard", help="Show dask's page of local workers at http://127.0.0.1:8787."
        ),
    ] = False,
    json: AsJson = False,
) -> None:
    """March a case at every point of a range, or of several.

    DIR gets sweep.nc (netCDF, opens with xarray): spectra, energies, regimes and thinned
    histories of every point over the swept keys; and figures, of which `bladewhirl plot DIR` draws
    more: whirl, contacts, energies, bifurcations, maps over two keys. Points that fail are listed
    in failures.json. A sweep that is interrupted or killed is finished by --resume DIR, with the
    same bits.
    """
    from bladewhirl.models.case.file import read_case
    from bladewhirl.studies.sweeps.axes import parse_over
    from bladewhirl.studies.sweeps.sweep import Watch, resume_sweep, run_sweep

    refuse_both(scheduler, workers)
    goes_on = f"bladewhirl sweep --resume {resume or output} finishes it"
    with progress_bar("sweeping", lines="points") as update, interruptible(goes_on):

        def progress(done: int, failed: int, points: int) -> None:
            update(done + failed, points, told=f"{done} of {points} done", failed=failed)

        watch = Watch(planned=_tell_plan, progress=progress)
        if resume is not None:
            anew: dict[str, object] = {"CASE": case, "--over": over, "--output": output}
            anew |= {"--set": overrides, "--histories": histories}
            anew["--stop-when"] = stop_when
            if any(anew.values()):
                given = ", ".join(name for name, value in anew.items() if value)
                raise UserError(
                    f"--resume {resume}: expected no {given}; the folder knows its sweep"
                )
            done = resume_sweep(
                resume, scheduler=scheduler, workers=workers, dashboard=dashboard, watch=watch
            )
        elif case is None or not over or output is None:
            raise UserError("sweep: expected CASE, --over KEY=VALUES and -o DIR, or --resume DIR")
        else:
            values = parse_over(over)
            _refuse_both(values, overrides or [])
            done = run_sweep(
                read_case(case, overrides or []),
                values,
                output,
                scheduler=scheduler,
                workers=workers,
                histories=histories,
                large=yes,
                stop_when=None if stop_when is None else "damped",
                dashboard=dashboard,
                watch=watch,
            )
    _report(done, as_json=json)
    if not done.done:
        raise typer.Exit(ALL_FAILED)


def _refuse_both(over: Iterable[str], overrides: Iterable[str]) -> None:
    """See that no key is both swept and set.

    Raises:
        UserError: naming both options and the key.
    """
    swept = set(over)
    for override in overrides:
        key = override.partition("=")[0].strip()
        if key in swept:
            raise UserError(
                f"--over {key}, --set {override}: expected one of them; --over gives {key} its"
                " value at every point"
            )


def _report(done: Sweep, *, as_json: bool) -> None:
    """Print what came out."""
    if as_json:
        document = {
            "directory": str(done.directory),
            "points": done.points,
            "done": done.done,
            "failed": done.failed,
            "marched": done.marched,
            "wall_time": done.wall_time,
            "failures": [
                {"point": point, **done.grid.values(point), "reason": reason}
                for point, reason in sorted(done.failures.items())
            ],
        }
        print_json(document)
    else:
        names = ", ".join(sorted(path.name for path in done.directory.iterdir()))
        typer.echo(
            f"{done.done} of {done.points} points done, {done.failed} failed;"
            f" {done.marched} marched in {done.wall_time:.3g} s\n{done.directory}: {names}"
        )
    for point, reason in sorted(done.failures.items())[:SHOWN_FAILURES]:
        typer.echo(f"failed: {done.grid.label(point)}: {reason}", err=True)
    for name, reason in done.left_out.items():
        typer.echo(f"{name} left out: {reason}", err=True)
    if done.failed > SHOWN_FAILURES:
        typer.echo(f"failed: {done.failed - SHOWN_FAILURES} more, see failures.json", err=True)


def _tell_plan(plan: Plan) -> None:
    """Hints at the case, and how large the sweep is."""
    from bladewhirl.models.case.plausibility import case_hints

    for hint in case_hints(plan.case):
        typer.echo(f"Hint: {hint}.", err=True)
    full = f", full histories {plan.history_bytes / 1e6:.3g} MB" if plan.histories else ""
    typer.echo(
        f"{plan.grid.size} points, {plan.steps:.3g} steps in all;"
        f" sweep.nc {plan.dataset_bytes / 1e6:.3g} MB{full}",
        err=True,
    )
