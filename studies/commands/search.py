"""`bladewhirl search`: look for the parameters that the source paper leaves out."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from bladewhirl.studies.commands.exits import interruptible
from bladewhirl.studies.commands.options import Scheduler, Workers, refuse_both

if TYPE_CHECKING:
    from bladewhirl.studies.paper.search.search import Judged

FOLDER = Path("parameter-search")
"""Folder of the results if none is named."""


def search(
    starts: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="START",
            help="soft, supported, light or heavy; all if none.",
            show_default=False,
        ),
    ] = None,
    rounds: Annotated[
        int, typer.Option(help="Steps from each start to a better neighbour.", min=0)
    ] = 1,
    faithful: Annotated[
        bool, typer.Option("--faithful", help="Keep every value that the paper gives.")
    ] = False,
    every_claim: Annotated[
        bool,
        typer.Option(
            "--every-claim",
            help="Judge all claims but 16; those that the examples miss also on what differs from"
            " them in one value.",
        ),
    ] = False,
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="DIR", help="Folder of all that is judged.")
    ] = FOLDER,
    report: Annotated[
        bool, typer.Option("--report", help="March nothing, write up what DIR has.")
    ] = False,
    workers: Workers = None,
    scheduler: Scheduler = None,
) -> None:
    """Judge sets of the parameters that the source paper leaves out, and report the best.

    From each START the search tries every set that differs in one value, and goes to the best.
    The best, of those that keep every value that the paper gives and of the others, are judged
    again over repeats with a slightly different force. DIR gets search.json, report.md, and for
    each claim that the examples' set misses a figure that shows which value would meet it. An
    interrupted search goes on where it was.
    """
    from dask.system import CPU_COUNT

    from bladewhirl.studies.paper.search.parameters import STARTS
    from bladewhirl.studies.paper.search.report import write_report
    from bladewhirl.studies.paper.search.search import open_search, search_parameters

    refuse_both(scheduler, workers)
    if not report:
        goes_on = f"the same command goes on with what is in {output}"
        with interruptible(goes_on), _scheduler(scheduler, workers or CPU_COUNT) as address:
            found = open_search(output, scheduler=address, faithful=faithful, told=_tell)
            kept = [name for name, start in STARTS.items() if not (faithful and start.departures)]
            search_parameters(found, starts or kept, rounds, every_claim=every_claim)
    for path in write_report(open_search(output), output):
        typer.echo(f"Wrote {path}.")


@contextmanager
def _scheduler(address: str | None, workers: int) -> Iterator[str | None]:
    """The address of the scheduler, one of this machine if none is named; none for one process."""
    from bladewhirl.studies.sweeps.cluster import local_cluster

    if address is not None or workers == 1:
        yield address
        return
    with local_cluster(workers) as cluster:
        yield cluster.scheduler_address


def _tell(judged: Judged) -> None:
    holds, partly = judged.rank
    typer.echo(f"{holds} hold, {partly} partly, {judged.level}: {judged.values.words()}")
