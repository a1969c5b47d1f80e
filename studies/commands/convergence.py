"""`bladewhirl convergence`: dependence of a march on its time step and on its modes."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

from bladewhirl.studies.commands import options
from bladewhirl.studies.commands.output import emit, facts, table
from bladewhirl.studies.commands.progress import progress_bar
from bladewhirl.studies.modal.columns import Column, rows_of

TIME_STEP, MODES = Column("time_step", "Δt [µs]", ".4g", 1e6), Column("modes", "modes η", "d")
COLUMNS = (
    Column("regime", "regime"),
    Column("radius_max", "radius [mm]", ".5g", 1e3),
    Column("impulse", "impulse [N s]", ".5g"),
    Column("distance", "orbit [%]", ".3g", 100.0),
    Column("impulse_error", "impulse [%]", ".3g", 100.0),
)
"""Columns of the table; the last two columns are differences from the finest march."""

ORDERS = (
    Column("time_steps.free_until", "first contact [ms]", ".4g", 1e3),
    Column("time_steps.free_order", "order in the time step, before contact", ".3g"),
    Column("time_steps.displacement_order", "order in the time step, displacement", ".3g"),
    Column("time_steps.impulse_order", "order in the time step, contact impulse", ".3g"),
    Column("modes.motion_converged", "same regime with all numbers of modes (1: yes)", "d"),
)
"""Labels of the orders of convergence. A dash stands for an order that cannot be computed, because
there are too few differences, or because the differences are not monotone."""


def convergence(
    case: options.CaseFile,
    time_steps: Annotated[
        Sequence[float] | None,
        options.several(
            "--time-steps",
            "STEP,STEP,...",
            "Time steps in s or with a unit; by default 4, 2, 1, 1/2 times that of the case.",
            options.in_si("s"),
            "times",
        ),
    ] = None,
    modes: Annotated[
        Sequence[int] | None,
        options.several(
            "--modes",
            "COUNT,COUNT,...",
            "Numbers of fixed-interface modes; by default 2 to 6 per blade.",
            int,
            "whole numbers",
        ),
    ] = None,
    output: options.CaseFolder = None,
    overwrite: options.Overwrite = False,
    workers: options.Workers = None,
    json: options.AsJson = False,
    overrides: options.Changes = None,
) -> None:
    """Study how a march depends on its time step and on its modes.

    The case is marched with several time steps, then with several numbers of fixed-interface modes.
    The output lists differences of orbit and contact impulse from the finest march, the orders of
    convergence, and the regimes of motion, as in Section 4.2 of the paper. Figures with their data,
    convergence.json and the marches are written into DIR.
    """
    from bladewhirl.models.case.file import faults_from, read_case
    from bladewhirl.studies.convergence.study import convergence as study

    values = overrides or []
    folder = output or Path(f"{case.stem}-convergence")
    read = read_case(case, values)
    with faults_from(case, values), progress_bar("marches", lines="marches") as update:
        result = study(
            read,
            folder,
            time_steps=time_steps and time_steps[::-1],
            modes=modes,
            overwrite=overwrite,
            workers=workers,
            progress=update,
        )
    document = result.as_json()
    tables = [
        table(rows_of(data, columns), columns, title)
        for data, columns, title in (
            (result.time_steps, (TIME_STEP, *COLUMNS), "Refinement of the time step"),
            (result.modes, (MODES, *COLUMNS), "Refinement of the modes"),
        )
    ]
    orders = {column.heading: column.text(document) for column in ORDERS}
    emit(document, *tables, facts(orders), json=json, written=[folder])
