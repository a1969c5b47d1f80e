"""`bladewhirl convergence`: how a march depends on its time step and on its modes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from bladewhirl.models.inputs.errors import CaseError, UserError
from bladewhirl.studies.commands.options import (
    AsJson,
    CaseFile,
    Changes,
    Workers,
    parse_time,
    print_json,
)
from bladewhirl.studies.commands.progress import progress_bar

if TYPE_CHECKING:
    from rich.table import Table

    from bladewhirl.models.case.case import Case
    from bladewhirl.studies.convergence.study import Convergence


def convergence(
    case: CaseFile,
    time_steps: Annotated[
        str | None,
        typer.Option(
            metavar="STEP,STEP,...",
            help="Time steps, s or with a unit; 4, 2, 1 and 1/2 times the case's if none.",
        ),
    ] = None,
    modes: Annotated[
        str | None,
        typer.Option(
            metavar="COUNT,COUNT,...",
            help="Numbers of fixed-interface modes; 2 to 6 a blade if none.",
        ),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="Folder to make; CASE-convergence by default."),
    ] = None,
    overwrite: Annotated[
        bool,
        typer.Option(
            "--overwrite", help="Write into a folder that exists; its marches are used again."
        ),
    ] = False,
    workers: Workers = None,
    json: AsJson = False,
    overrides: Changes = None,
) -> None:
    """Study how a march depends on its time step and on its modes.

    The case is marched with several time steps, then with several numbers of fixed-interface
    modes: differences of orbit and contact impulse, their order, and the kind of motion, as in
    Section 4.2 of the paper. DIR gets figures with their data, convergence.json and the marches.
    """
    from rich.console import Console

    from bladewhirl.models.case.file import faults_from, read_case
    from bladewhirl.studies.convergence.study import MODES, TIME_STEP
    from bladewhirl.studies.convergence.study import convergence as study

    steps, counts = _steps(time_steps), _counts(modes)
    values = overrides or []
    checked = read_case(case, values)
    _check_values(checked, "--time-steps", TIME_STEP, steps or ())
    _check_values(checked, "--modes", MODES, counts or ())
    folder = output or Path(f"{case.stem}-convergence")
    with faults_from(case, values), progress_bar("marches", lines="marches") as update:
        found = study(
            checked,
            folder,
            time_steps=steps,
            modes=counts,
            overwrite=overwrite,
            workers=workers,
            progress=update,
        )
    if json:
        print_json(found.as_json())
        return
    Console().print(*_tables(found))
    for line in _lines(found):
        typer.echo(line)
    typer.echo(f"Wrote {folder}.")


def _tables(found: Convergence) -> Iterator[Table]:
    from rich import box
    from rich.table import Table

    for data, key, heading, unit, scale in (
        (found.time_steps, "time_step", r"Δt \[µs]", "µs", 1e6),
        (found.modes, "modes", "modes η", "modes", 1),
    ):
        table = Table(
            box=box.SIMPLE_HEAD,
            title=f"Differences from {scale * data[key].values[-1]:.4g} {unit}, in %",
            title_justify="left",
            title_style="bold",
        )
        table.add_column(heading, justify="right")
        table.add_column("regime")
        for name in (
            r"radius \[mm]",
            r"impulse \[N s]",
            r"orbit \[%]",
            r"impulse \[%]",
        ):
            table.add_column(name, justify="right", no_wrap=True)
        for row in data[key].values:
            own = data.sel({key: row})
            table.add_row(
                f"{scale * row:.4g}",
                str(own["regime"].item()),
                f"{1e3 * own['radius_max'].item():.5g}",
                f"{own['impulse'].item():.5g}",
                f"{100 * own['distance'].item():.3g}",
                f"{100 * own['impulse_error'].item():.3g}",
            )
        yield table


def _lines(found: Convergence) -> Iterator[str]:
    measured = found.time_steps.attrs
    orders = {
        f"displacement up to {1e3 * measured['free_until']:.4g} ms, before contact": "free",
        "displacement over all": "displacement",
        "contact impulse": "impulse",
    }
    for name, kind in orders.items():
        order = measured[f"{kind}_order"]
        told = f"{order:.3g}" if order == order else "none: too few differences, or not monotone"
        yield f"Order in the time step, {name}: {told}."
    same = "the same" if found.modes.attrs["motion_converged"] else "not the same"
    yield f"Kind of motion with all numbers of modes: {same}."


def _steps(text: str | None) -> list[float] | None:
    """Time steps, descending [s].

    Raises:
        UserError: fewer than two different ones, or no times.
    """
    if text is None:
        return None
    steps = {parse_time("--time-steps", word.strip()) or 0.0 for word in text.split(",")}
    if len(steps) < 2 or not min(steps) > 0.0:
        raise UserError(f"--time-steps {text}: expected two or more different times above zero")
    return sorted(steps, reverse=True)


def _counts(text: str | None) -> list[int] | None:
    """Numbers of modes, ascending.

    Raises:
        UserError: fewer than two different ones, or no whole numbers.
    """
    if text is None:
        return None
    words = [word.strip() for word in text.split(",")]
    counts = {int(word) for word in words if word.isdecimal()}
    if not all(word.isdecimal() for word in words) or len(counts) < 2 or min(counts) < 1:
        raise UserError(f"--modes {text}: expected two or more different whole numbers above zero")
    return sorted(counts)


def _check_values(case: Case, option: str, key: str, values: Sequence[float]) -> None:
    """See that the case takes each value.

    Raises:
        UserError: naming the option, not the key of the case that it does not go with.
    """
    from bladewhirl.models.case.file import with_values

    for value in values:
        try:
            with_values(case, {key: value})
        except CaseError as error:
            raise UserError(f"{option} {value:g}: {error.lines[0]}") from None
