"""What a search found: the best sets, what bridges the paper's claims, what flips each claim."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, replace
from pathlib import Path

from bladewhirl.models.faults import UserError
from bladewhirl.postprocess.sensitivity_figures import plot_sensitivity, sensitivity_dataset
from bladewhirl.postprocess.style import save_figure
from bladewhirl.studies.claim import CLAIMS
from bladewhirl.studies.figure_folder import written_to
from bladewhirl.studies.laboratory import PERTURBATION
from bladewhirl.studies.parameter_search import (
    BRIDGE,
    CONTACT_CLAIMS,
    MODAL_CLAIMS,
    Judged,
    Search,
)
from bladewhirl.studies.parameter_sets import PARAMETERS, STARTS, UNKNOWNS, ParameterSet
from bladewhirl.studies.sweep_store import write_whole

REPORT_NAME = "report.md"

LISTED = 8
"""Sets in the table of the best."""


def write_report(search: Search, directory: Path) -> list[Path]:
    """Write report.md and the sensitivity figures of claims that the best set misses.

    Raises:
        UserError: nothing has been judged, or the folder can't be written.
    """
    screened = search.best(LISTED)
    if not screened:
        raise UserError(f"{directory}: expected sets that have been judged, found none")
    best = screened[0]
    paths = [directory / REPORT_NAME]
    with written_to(directory):
        write_whole(paths[0], report_text(search))
        for claim in missed(best):
            data = sensitivity_dataset(*_rows(search, best, claim))
            paths += save_figure(
                plot_sensitivity(data), directory / f"sensitivity-claim-{claim}", data
            )[:1]
    return paths


def report_text(search: Search) -> str:
    """The report as Markdown."""
    screened, confirmed = search.best(LISTED), search.best(LISTED, confirmed=True)
    best = screened[0]
    judged = [each for each in search.judged.values() if not each.confirmed]
    bridging = [each for each in judged if each.bridges]
    listed = [("confirmed", each) for each in confirmed]
    listed += [("screened", each) for each in screened]
    listed += [
        (f'screened, "{name}"', search.judged[start, False])
        for name, start in STARTS.items()
        if (start, False) in search.judged
    ]
    shared = _shared([each.values for _, each in listed])
    claims = (*MODAL_CLAIMS, *CONTACT_CLAIMS)
    lines = [
        f"{len(judged)} sets were screened by {len(claims)} claims, {_numbers(claims)};"
        f" {len(confirmed)} were confirmed at the paper's time step over repeats whose force"
        f" differs by {PERTURBATION:g}.",
        "",
        f"Claims {_numbers(BRIDGE)} together hold in {len(bridging)} of the screened sets"
        + (f", the best of them: {max(bridging, key=_rank).values.words()}." if bridging else "."),
        "",
        "| | hold | partly | that hold | set |",
        "|---|---|---|---|---|",
        *(_row(name, each, shared) for name, each in listed),
        "",
        f"All of them have {best.values.words(set(PARAMETERS) - shared)}." if shared else "",
        "",
        "What single change of the best screened set turns a claim that it misses:",
        "",
        *(_flips(search, best, claim) for claim in missed(best)),
    ]
    return "\n".join(lines) + "\n"


def _shared(sets: list[ParameterSet]) -> set[str]:
    """Parameters that have the same value in all sets."""
    rows = [asdict(values) for values in sets]
    return {name for name in PARAMETERS if len({row[name] for row in rows}) == 1}


def missed(judged: Judged) -> list[int]:
    """Claims that a set does not meet in full."""
    return [claim for claim, verdict in judged.verdicts.items() if verdict != "holds"]


def _flips(search: Search, best: Judged, claim: int) -> str:
    """In words: which values of which parameter meet a claim."""
    found = []
    for name, values in UNKNOWNS.items():
        met = [value for value in values if _verdict(search, best, name, value, claim) == "holds"]
        if met:
            own = asdict(best.values)[name]
            found.append(f"{PARAMETERS[name]} {', '.join(map(str, met))} instead of {own}")
    verdict = best.verdicts[claim]
    words = "; ".join(found) or "none that was tried"
    return f"* {claim} ({verdict}: {best.ours[claim]}): {words}."


def _rows(
    search: Search, best: Judged, claim: int
) -> tuple[str, dict[str, list[tuple[str, str]]], dict[str, str]]:
    rows = {
        PARAMETERS[name]: [
            (str(value), _verdict(search, best, name, value, claim)) for value in values
        ]
        for name, values in UNKNOWNS.items()
    }
    base = {PARAMETERS[name]: str(value) for name, value in asdict(best.values).items()}
    return f"Claim {claim}: {CLAIMS[claim].text}", rows, base


def _verdict(search: Search, best: Judged, name: str, value: object, claim: int) -> str:
    """What a claim says where one value of the best set is another; empty if not tried."""
    values = replace(best.values, **{name: value})  # type: ignore[arg-type]
    judged = search.judged.get((values, False))
    return judged.verdicts[claim] if judged else ""


def _row(name: str, judged: Judged, shared: set[str]) -> str:
    holds, partly = judged.rank
    met = _numbers(claim for claim, verdict in judged.verdicts.items() if verdict == "holds")
    return f"| {name} | {holds} | {partly} | {met} | {judged.values.words(shared)} |"


def _rank(judged: Judged) -> tuple[int, int]:
    return judged.rank


def _numbers(claims: Iterable[int]) -> str:
    return ", ".join(map(str, claims))
