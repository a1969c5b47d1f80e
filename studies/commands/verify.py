"""`bladewhirl verify`: compare computed results with known results."""

from pathlib import Path
from typing import Annotated

import typer

from bladewhirl.studies.commands import options
from bladewhirl.studies.commands.output import emit, table
from bladewhirl.studies.commands.progress import progress_bar
from bladewhirl.studies.modal.columns import Column

FAILED = 1
"""Exit code if the error of a case exceeds its tolerance."""


def verify(
    subjects: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="SUBJECT",
            help="modes, rings, contact, schemes, march, results, stability, rotation, whirl,"
            " forced, sensors or coating.",
            show_default=False,
        ),
    ] = None,
    full: Annotated[bool, typer.Option("--full", help="Include the cases that take long.")] = False,
    json: options.AsJson = False,
    markdown: Annotated[
        bool, typer.Option("--markdown", help="Print the table as Markdown.")
    ] = False,
    html: Annotated[
        Path | None, typer.Option("--html", metavar="FILE", help="Also write the table as a page.")
    ] = None,
) -> None:
    """Compute cases with known results and compare the results, to check this installation.

    Each case lists source, quantity, reference value, computed value, error and tolerance.
    All subjects, the default, take about two minutes. The exit code is 1 if any case fails.
    """
    from bladewhirl.models.inputs.errors import UserError, writing
    from bladewhirl.postprocess.plotting.files import checked_target
    from bladewhirl.postprocess.reports.page import write_page
    from bladewhirl.studies.verification.table import HEAD, SUBJECTS, cells
    from bladewhirl.studies.verification.table import verify as run_cases

    if json and markdown:
        raise UserError("--json, --markdown: omit one of them")
    if html is not None:
        checked_target(html, ".html")
    with progress_bar("cases") as progress:
        done = run_cases(subjects or (), full=full, progress=progress)
    if json:
        typer.echo(done.to_json(), nl=False)
    elif markdown:
        typer.echo(done.to_markdown(), nl=False)
    else:
        columns = [Column(name, name) for name in ("quantity", *HEAD[4:])]
        columns.append(Column("", "verdict"))
        for subject, outcomes in done.by_subject().items():
            rows = [dict(zip(HEAD, cells(outcome), strict=True)) for outcome in outcomes]
            for row in rows:
                row["quantity"] += f"\n  {row['source']}"
            emit(None, table(rows, columns, SUBJECTS[subject]), json=False)
        typer.echo(done.summary)
    if html is not None:
        with writing(html):
            typer.echo(f"Wrote {write_page(done.page(), html)}.", err=json or markdown)
    if not done.passed:
        raise typer.Exit(FAILED)
