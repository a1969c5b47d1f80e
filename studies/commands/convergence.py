"""`bladewhirl convergence`: dependence of a march on its time step and on its modes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from bladewhirl.studies.commands.options import (
    AsJson,
    CaseFile,
    CaseFolder,
    Changes,
    Overwrite,
    Workers,
    parse_number,
    parse_several,
)
from bladewhirl.studies.commands.output import emit, facts, table
from bladewhirl.studies.commands.progress import progress_bar
from bladewhirl.studies.modal.columns import Column

if TYPE_CHECKING:
    from rich.table import Table

COLUMNS = (
    Column("regime", "regime"),
    Column("radius_max", "radius [mm]", ".5g", 1e3),
    Column("impulse", "impulse [N s]", ".5g"),
    Column("distance", "orbit [%]", ".3g", 100.0),
    Column("impulse_error", "impulse [%]", ".3g", 100.0),
)
"""The last two are differences from the finest march."""


def convergence(
    case: CaseFile,
    time_steps: Annotated[
        Sequence[float] | None,
        typer.Option(
            parser=partial(
                parse_several, "--time-steps", read=partial(parse_number, unit="s"), name="times"
            ),
            metavar="STEP,STEP,...",
            help="Time steps, s or with a unit; 4, 2, 1 and 1/2 times the case's if none.",
        ),
    ] = None,
    modes: Annotated[
        Sequence[int] | None,
        typer.Option(
            parser=partial(parse_several, "--modes", read=int, name="whole numbers"),
            metavar="COUNT,COUNT,...",
            help="Numbers of fixed-interface modes; 2 to 6 a blade if none.",
        ),
    ] = None,
    output: CaseFolder = None,
    overwrite: Overwrite = False,
    workers: Workers = None,
    json: AsJson = False,
    overrides: Changes = None,
) -> None:
    """Study how a march depends on its time step and on its modes.

    The case is marched with several time steps, then with several numbers of fixed-interface
    modes: differences of orbit and contact impulse, their order, and the kind of motion, as in
    Section 4.2 of the paper. DIR gets figures with their data, convergence.json and the marches.
    """
    from bladewhirl.models.case.file import faults_from, read_case
    from bladewhirl.studies.convergence.study import convergence as study

    values = overrides or []
    folder = output or Path(f"{case.stem}-convergence")
    with faults_from(case, values), progress_bar("marches", lines="marches") as update:
        result = study(
            read_case(case, values),
            folder,
            time_steps=time_steps and time_steps[::-1],
            modes=modes,
            overwrite=overwrite,
            workers=workers,
            progress=update,
        )
    document = result.as_json()
    emit(document, *_tables(document), json=json, written=[folder])


def _tables(document: dict[str, Any]) -> Iterator[Table]:
    """Yield the tables of both refinements, and the orders."""
    steps, modes = document["time_steps"], document["modes"]
    for data, refined, title in (
        (steps, Column("time_step", "Δt [µs]", ".4g", 1e6), "Refinement of the time step"),
        (modes, Column("modes", "modes η", "d"), "Refinement of the modes"),
    ):
        columns = (refined, *COLUMNS)
        keys = [column.key for column in columns]
        rows = [
            dict(zip(keys, row, strict=True))
            for row in zip(*(data[key] for key in keys), strict=True)
        ]
        yield table(rows, columns, title)
    order = "order in the time step"
    yield facts(
        {
            f"{order}, before contact (to {1e3 * steps['free_until']:.4g} ms)": _order(
                steps, "free"
            ),
            f"{order}, displacement": _order(steps, "displacement"),
            f"{order}, contact impulse": _order(steps, "impulse"),
            "same regime with all numbers of modes": "yes" if modes["motion_converged"] else "no",
        }
    )


def _order(steps: dict[str, Any], kind: str) -> str:
    order = steps[f"{kind}_order"]
    return "none: too few differences, or not monotone" if order is None else f"{order:.3g}"
