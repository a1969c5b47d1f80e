"""Commands that check the program: against known results, and against the claims of the paper."""

from pathlib import Path
from typing import Annotated

import typer

from bladewhirl.studies.commands import options
from bladewhirl.studies.commands.terminal import emit, interruptible, progress_bar
from bladewhirl.studies.runs.columns import Column, table

FAILED = 1  #: exit code if the error of a case exceeds its tolerance

FOLDER = Path("reproduction")  #: default folder of the results of `reproduce`


def verify(
    subjects: Annotated[
        list[str] | None, typer.Argument(metavar="SUBJECT", show_default=False)
    ] = None,
    full: Annotated[bool, typer.Option("--full")] = False,
    json: options.AsJson = False,
    markdown: Annotated[bool, typer.Option("--markdown")] = False,
    html: options.File = None,
) -> None:
    """Compute cases with known results and compare the results, to check this installation.

    Each case lists source, quantity, reference value, computed value, error and tolerance.
    All subjects, the default, take about two minutes. The exit code is 1 if any case fails.

    Args:
        subjects: modes, rings, contact, march, results, stability, rotation, whirl, shaft, speed,
            forced, sensors, coating, foreshortening, superelement, periodic or joints.
        full: Include the cases that take long.
        markdown: Print the table as Markdown.
        html: Also write the table as a page.
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


def reproduce(
    claims: Annotated[list[int] | None, typer.Argument(metavar="CLAIM", show_default=False)] = None,
    quick: Annotated[bool, typer.Option("--quick")] = False,
    speed_step: float | None = None,
    output: Annotated[Path, typer.Option("--output", "-o", metavar="DIR")] = FOLDER,
    overrides: options.Changes = None,
    repeats: options.MaybeNumber = None,
    workers: options.Workers = None,
    scheduler: options.Scheduler = None,
    json: options.AsJson = False,
) -> None:
    """Judge the claims of the source paper from marches and sweeps.

    Each claim is compared with the paper by thresholds: it holds, holds partly, does not hold, or
    can't be tested. Claims 1 to 15 are judged with the stage of the paper's modal analysis, the
    others with the two contact cases. All marches are kept in DIR, so that an interrupted
    reproduction can use them again.

    Args:
        claims: Numbers of the claims to judge; by default all.
        quick: Marches of 2.5 s, coarse sweeps, no repeats.
        speed_step: Step of all sweeps over speed; the paper's maps have 0.005. By default 0.01 for
            casing distortion, 0.025 for imbalance, 0.35 for imbalance with six modes.
        output: Folder of marches and scorecard.
        overrides: Change a key in all cases: casing.wall.thickness=8e-3.
        repeats: Number of marches per claim, with forces changed by 1e-7.
    """
    from rich.console import Console

    from bladewhirl.models.case.file import override_values
    from bladewhirl.studies.paper import judge
    from bladewhirl.studies.paper.scorecard import scorecard_table
    from bladewhirl.studies.sweeps.sweep import Watch

    options.refuse_both(scheduler, workers)
    plan = judge.Assessment(
        claims=judge.chosen_claims(claims or []),
        changes=override_values(overrides or []),
        quick=quick,
        repeats=repeats or (1 if quick else judge.REPEATS),
        speed_step=speed_step,
    )
    remedy = f"the same command continues with the marches in {output}"
    with (
        progress_bar("marches") as marches,
        progress_bar("sweep over speed") as points,
        interruptible(remedy, output),
    ):
        watch = Watch(progress=lambda done, failed, total: points(done + failed, total))
        card, evidence = judge.reproduce_claims(
            plan, output, workers=workers, scheduler=scheduler, progress=marches, watch=watch
        )
    with evidence:
        written = judge.write_scorecard(card, evidence, output)
    if json:
        typer.echo(card.to_json(), nl=False)
    else:
        Console().print(scorecard_table(card))
        typer.echo(f"Wrote {' and '.join(map(str, written))}.")
