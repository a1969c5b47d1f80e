"""`bladewhirl convergence`: how a march depends on its time step and on its modes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from rich.table import Table

    from bladewhirl.models.case.case import Case
    from bladewhirl.studies.convergence.study import Convergence
    from bladewhirl.studies.sweeps.cache import Progress

RUNS_NAME = "runs"
"""The folder that keeps the marches."""


def convergence(
    case: Annotated[Path, typer.Argument(help="Case file.", show_default=False)],
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
    workers: Annotated[
        int | None, typer.Option(help="Local processes; one a core if none.", min=1)
    ] = None,
    json: Annotated[bool, typer.Option("--json", help="Print one JSON document.")] = False,
    overrides: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="KEY=VALUE", help="Change the case: march.duration=0.3."),
    ] = None,
) -> None:
    """Study how a march depends on its time step and on its modes.

    The case is marched with several time steps, then with several numbers of fixed-interface
    modes: differences of orbit and contact impulse, their order, and the kind of motion, as in
    Section 4.2 of the paper. DIR gets figures with their data, convergence.json and the marches.
    """
    from rich.console import Console

    from bladewhirl.models.case.file import faults_from, read_case
    from bladewhirl.postprocess.plotting.style import save_figure
    from bladewhirl.studies.convergence.figures import plot_modes, plot_time_steps
    from bladewhirl.studies.convergence.study import (
        MODES,
        TIME_STEP,
        Convergence,
        default_modes,
        default_time_steps,
        mode_convergence,
        time_step_convergence,
    )
    from bladewhirl.studies.runs.figures_folder import check_figure_folder, written_to
    from bladewhirl.studies.sweeps.cache import RunStore

    steps, counts = _steps(time_steps), _counts(modes)
    folder = output or Path(f"{case.stem}-convergence")
    check_figure_folder(folder, overwrite=overwrite)
    values = overrides or []
    checked = read_case(case, values)
    _check_values(checked, "--time-steps", TIME_STEP, steps or ())
    _check_values(checked, "--modes", MODES, counts or ())
    store = RunStore(directory=folder / RUNS_NAME, workers=workers)
    with faults_from(case, values), _progress() as progress:
        found = Convergence(
            time_steps=time_step_convergence(
                checked, steps or default_time_steps(checked), store, progress
            ),
            modes=mode_convergence(checked, counts or default_modes(checked), store, progress),
        )
    with written_to(folder):
        save_figure(plot_time_steps(found.time_steps), folder / "time-step", found.time_steps)
        save_figure(plot_modes(found.modes), folder / "modes", found.modes)
        text = _as_text(found)
        (folder / "convergence.json").write_text(text + "\n", encoding="utf-8")
    if json:
        typer.echo(text)
        return
    console = Console()
    for table in _tables(found):
        console.print(table)
    for line in _lines(found):
        typer.echo(line)
    typer.echo(f"Wrote {folder}.")


def _as_text(found: Convergence) -> str:
    import json

    return json.dumps(found.as_json(), indent=2, allow_nan=False)


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
        told = f"{order:.3g}" if order == order else "too few differences to tell"
        yield f"Order in the time step, {name}: {told}."
    same = "the same" if found.modes.attrs["motion_converged"] else "not the same"
    yield f"Kind of motion with all numbers of modes: {same}."


def _steps(text: str | None) -> list[float] | None:
    """Time steps, descending [s].

    Raises:
        UserError: fewer than two different ones, or no times.
    """
    from bladewhirl.models.inputs.errors import UserError
    from bladewhirl.studies.commands.times import parse_time

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
    from bladewhirl.models.inputs.errors import UserError

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
    from bladewhirl.models.inputs.errors import CaseError, UserError

    for value in values:
        try:
            with_values(case, {key: value})
        except CaseError as error:
            raise UserError(f"{option} {value:g}: {error.lines[0]}") from None


@contextmanager
def _progress() -> Iterator[Progress]:
    """Marches done; lines where there is no terminal."""
    from rich.console import Console
    from rich.progress import Progress

    from bladewhirl.studies.commands.progress import ProgressLines

    console = Console(stderr=True)
    with Progress(console=console, transient=True, disable=not console.is_terminal) as bar:
        if not console.is_terminal:
            yield ProgressLines("marches")
            return
        task = bar.add_task("marches")
        yield lambda done, total: bar.update(task, completed=done, total=total)
