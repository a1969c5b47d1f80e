"""`bladewhirl report`: a run or a sweep as one HTML file."""

from pathlib import Path
from typing import Annotated

import typer

from bladewhirl.studies.commands import options


def report(
    directory: Annotated[
        Path, typer.Argument(metavar="DIR", help="Folder of a run or a sweep, finished or not.")
    ],
    output: Annotated[
        Path | None, options.output("File to write; by default DIR/report.html.", "FILE")
    ] = None,
    overwrite: options.Replace = False,
) -> None:
    """Write a report as one HTML file that any browser shows without a network.

    It contains the regime with its reasons, the figures of `bladewhirl plot` with explanations,
    interactive maps, the numbers, the resolved case and its provenance. An older report of the
    folder is replaced.
    """
    from bladewhirl.studies.runs.report import report as write_report
    from bladewhirl.studies.runs.report import report_target

    target = report_target(directory, output)
    options.claim_output(target, named=output is not None, overwrite=overwrite)
    typer.echo(f"Wrote {write_report(directory, target)}.")
