"""Reproduction of the paper: selection of claims, their marches and sweeps, and verdicts."""

from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from bladewhirl.files import write_atomically
from bladewhirl.models.inputs.errors import UserError, writing
from bladewhirl.postprocess.reports.page import write_page
from bladewhirl.studies.paper import (  # noqa: F401 -- each module registers its claims
    claims_marches,
    claims_modal,
    claims_sweeps,
)
from bladewhirl.studies.paper.claim import CLAIMS, Claim
from bladewhirl.studies.paper.figures import draw_figures
from bladewhirl.studies.paper.scorecard import Score, Scorecard, scorecard_page
from bladewhirl.studies.paper.trials import (
    PERTURBATION,
    SURVEYS,
    TRIALS,
    Evidence,
    NotTestableError,
)
from bladewhirl.studies.runs import folder as run_directory
from bladewhirl.studies.sweeps.cache import Progress, RunStore
from bladewhirl.studies.sweeps.sweep import Watch

RUNS_NAME, FIGURES_NAME = "runs", "figures"
"""Names of the folders of single marches, and of pictures."""

CASES_IN_WORDS = "claims 1 to 15: fan_stage; claims 16 to 46: casing_distortion, imbalance"
"""Examples from which the claims are judged; the examples can have different stages."""

SMALLEST_STEP = 1e-4  #: smallest step of a sweep over speed, which gives 10,500 speeds

REPEATS = 3  #: number of times that a march is judged, each time with a slightly different force


@dataclass(frozen=True, kw_only=True)
class Assessment:
    """Claims to judge, and the conditions of the runs."""

    claims: tuple[Claim, ...]
    changes: Mapping[str, Any]  #: changes of all cases, by dotted key
    quick: bool
    repeats: int
    speed_step: float | None = None  #: step of all sweeps over speed; None: step of each survey

    def __post_init__(self) -> None:
        """Check that the speed step is positive and not larger than the narrowest range.

        Raises:
            UserError: the step is invalid; the message contains the permitted values.
        """
        widest = min(last - first for first, last in (s.speeds for s in SURVEYS.values()))
        if self.speed_step is not None and not SMALLEST_STEP <= self.speed_step <= widest:
            raise UserError(
                f"--speed-step {self.speed_step:g}: expected {SMALLEST_STEP:g} to {widest:g},"
                " multiples of the reference frequency"
            )

    @property
    def sweeps(self) -> str:
        """Number and range of the speeds of each sweep, as text."""
        named = []
        for name in needed(self.claims, "sweeps"):
            speeds, *others = SURVEYS[name].axes(coarse=self.quick, step=self.speed_step).values()
            lines = f", {len(others[0])} coupling stiffnesses" if others else ""
            named.append(f"{name}: {len(speeds)} from {speeds[0]:g} to {speeds[-1]:g}{lines}")
        return "; ".join(named) or "none"


def chosen_claims(numbers: Sequence[int]) -> tuple[Claim, ...]:
    """Return claims by number in ascending order; all claims if no number is given.

    Raises:
        UserError: a claim does not exist.
    """
    unknown = [number for number in numbers if number not in CLAIMS]
    if unknown:
        listed = ", ".join(map(str, unknown))
        raise UserError(f"claim {listed}: expected numbers from {min(CLAIMS)} to {max(CLAIMS)}")
    return tuple(CLAIMS[number] for number in sorted(set(numbers) or CLAIMS))


def reproduce_claims(
    plan: Assessment,
    directory: Path,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: Progress | None = None,
    watch: Watch | None = None,
) -> tuple[Scorecard, Evidence]:
    """Judge claims; marches and sweeps that exist in the folder are used again.

    Args:
        plan: claims and conditions.
        directory: folder of marches and sweeps.
        workers: number of processes that march; one per core when None.
        scheduler: address of an existing dask scheduler.
        progress: called with the numbers of finished marches and of all marches.
        watch: callbacks on the progress of sweeps.

    Returns:
        the scorecard, and the evidence of the first repeat, which the caller closes after drawing.

    Raises:
        UserError: the folder cannot be written, or the scheduler does not answer.
    """
    store = RunStore(directory=directory / RUNS_NAME, workers=workers, scheduler=scheduler)
    repeats = [
        Evidence(
            directory=directory,
            store=store,
            changes=plan.changes,
            quick=plan.quick,
            speed_step=plan.speed_step,
            repeat=repeat,
        )
        for repeat in range(plan.repeats)
    ]
    first, *others = repeats
    names = needed(plan.claims, "trials")
    store.make([case for evidence in repeats for case in map(evidence.case, names)], progress)
    for name in needed(plan.claims, "sweeps"):
        with suppress(NotTestableError):  # reported by the claims that need it
            first.sweep(name, watch)
    findings = {claim: [claim.judge(first)] for claim in plan.claims}
    for evidence in others:
        with evidence:
            for claim in plan.claims:
                if any(TRIALS[name].repeated for name in claim.trials):
                    findings[claim].append(claim.judge(evidence))
    card = Scorecard(
        scores=tuple(Score(claim=claim, findings=tuple(f)) for claim, f in findings.items()),
        conditions={
            run_directory.PACKAGE: run_directory.version(),
            "cases": CASES_IN_WORDS,
            "quick": plan.quick,
            "speeds": plan.sweeps,
            "repeats": plan.repeats,
            "perturbation": PERTURBATION,
            "changes": dict(plan.changes),
        },
    )
    return card, first


def needed(claims: Iterable[Claim], kind: Literal["trials", "sweeps"]) -> list[str]:
    """Return the names of the marches or sweeps by which claims are judged, each once."""
    return list(dict.fromkeys(name for claim in claims for name in getattr(claim, kind)))


def write_scorecard(card: Scorecard, evidence: Evidence, directory: Path) -> list[Path]:
    """Write scorecard.json and scorecard.html, with the figures of the claims in figures/.

    Raises:
        UserError: a file cannot be written.
    """
    cited = {number for score in card.scores for number in score.claim.figures}
    document, page = directory / "scorecard.json", directory / "scorecard.html"
    with writing(directory):
        directory.mkdir(parents=True, exist_ok=True)
        drawn = draw_figures(evidence, sorted(cited, key=int), directory / FIGURES_NAME)
        write_atomically(document, card.to_json())
        write_page(scorecard_page(card, drawn), page)
    return [document, page]
