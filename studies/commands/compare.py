"""`bladewhirl compare`: one case, every contact scheme."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from bladewhirl.studies.commands.options import AsJson, CaseFile, Changes, Overwrite, print_json
from bladewhirl.studies.commands.progress import progress_bar


def compare(
    case: CaseFile,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Folder to make for a figure.")
    ] = None,
    overwrite: Overwrite = False,
    json: AsJson = False,
    overrides: Changes = None,
) -> None:
    """March a case with every contact scheme, side by side.

    Displacement, impulses, energy and cost of central differences with multipliers, of Moreau and
    Jean's impacts with friction that sticks, and of a penalty: see march.scheme. Distance is that
    of the tips from the first scheme. The last two cost fifty to a hundred times as much a step,
    so take a short march: --set march.duration=0.05.
    """
    from rich import box
    from rich.console import Console
    from rich.table import Table

    from bladewhirl.models.case.file import faults_from, read_case
    from bladewhirl.studies.convergence.schemes import compare_schemes, schemes_document

    values = overrides or []
    with faults_from(case, values), progress_bar("marching") as update:
        data = compare_schemes(
            read_case(case, values), output, overwrite=overwrite, progress=update
        )
    document = schemes_document(data)
    if json:
        print_json(document)
        return
    table = Table(box=box.SIMPLE_HEAD, title=document["title"], title_justify="left")
    table.add_column("quantity")
    for row in document["schemes"]:
        table.add_column(row["scheme"], justify="right", no_wrap=True)
    for key, (heading, scale) in ROWS.items():
        told = (row[key] for row in document["schemes"])
        table.add_row(heading, *("–" if n is None else f"{scale * n:.4g}" for n in told))
    Console().print(table)
    if output is not None:
        typer.echo(f"Wrote {output}.")


ROWS = {
    "end_time": (r"end \[ms]", 1e3),
    "tip_displacement": (r"largest tip displacement \[mm]", 1e3),
    "distance": (r"distance of the tips \[%]", 1e2),
    "impulse": (r"normal impulse \[N s]", 1.0),
    "friction_impulse": (r"friction impulse \[N s]", 1.0),
    "friction_work": (r"work of friction \[J]", 1.0),
    "energy": (r"energy at the end \[J]", 1.0),
    "ledger": ("energy less work, over the largest term", 1.0),
    "penetration": (r"deepest penetration \[µm]", 1e6),
    "step_cost": (r"cost of a step \[µs]", 1e6),
}
"""Rows of the table: heading, and what SI values are multiplied by."""
