"""`bladewhirl reproduce`: judge the claims of the source paper."""

from pathlib import Path
from typing import Annotated

import typer

from bladewhirl.studies.commands import options
from bladewhirl.studies.commands.exits import interruptible
from bladewhirl.studies.commands.progress import progress_bar

FOLDER = Path("reproduction")
"""Default folder of the results."""


def reproduce(
    claims: Annotated[
        list[int] | None,
        typer.Argument(
            metavar="CLAIM",
            help="Numbers of the claims to judge; by default all.",
            show_default=False,
        ),
    ] = None,
    quick: Annotated[
        bool, typer.Option("--quick", help="Marches of 2.5 s, coarse sweeps, no repeats.")
    ] = False,
    speed_step: Annotated[
        float | None,
        typer.Option(
            "--speed-step",
            help="Step of all sweeps over speed; the paper's maps have 0.005. By default 0.01 for"
            " casing distortion, 0.025 for imbalance, 0.35 for imbalance with six modes.",
        ),
    ] = None,
    output: Annotated[Path, options.output("Folder of marches and scorecard.", "DIR")] = FOLDER,
    overrides: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="KEY=VALUE",
            help="Change a key in all cases: casing.wall.thickness=8e-3.",
        ),
    ] = None,
    repeats: Annotated[
        int | None,
        typer.Option(help="Number of marches per claim, with forces changed by 1e-7.", min=1),
    ] = None,
    workers: options.Workers = None,
    scheduler: options.Scheduler = None,
    json: options.AsJson = False,
) -> None:
    """Judge the claims of the source paper from marches and sweeps.

    Each claim is compared with the paper by thresholds: it holds, holds partly, does not hold, or
    can't be tested. Claims 1 to 15 are judged with the stage of the paper's modal analysis, the
    others with the two contact cases. All marches are kept in DIR, so that an interrupted
    reproduction can use them again.
    """
    from rich.console import Console

    from bladewhirl.models.case.file import override_values
    from bladewhirl.studies.paper import judge
    from bladewhirl.studies.paper.scorecard import scorecard_table
    from bladewhirl.studies.sweeps.sweep import Watch

    options.refuse_both(scheduler, workers)
    plan = judge.Plan(
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
        interruptible(remedy),
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
