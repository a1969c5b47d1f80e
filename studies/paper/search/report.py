"""The report of a search: the best sets, those that bridge claims, those that flip each."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path

from bladewhirl.meshes.files.drafts import write_whole
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.postprocess.plotting.style import save_figure
from bladewhirl.studies.paper.claim import CLAIMS, Verdict
from bladewhirl.studies.paper.search.figures import (
    plot_overview,
    plot_sensitivity,
    sensitivity_dataset,
)
from bladewhirl.studies.paper.search.parameters import PARAMETERS, STARTS, UNKNOWNS, ParameterSet
from bladewhirl.studies.paper.search.search import (
    BASES,
    BRIDGE,
    DEFAULT,
    MODAL,
    SCRUTINIES,
    Judged,
    Level,
    Search,
)
from bladewhirl.studies.paper.trials import PERTURBATION
from bladewhirl.studies.runs.figures_folder import written_to

REPORT_NAME = "report.md"

OVERVIEW_NAME = "sensitivity"
"""Picture of all claims and all single changes of the default."""

LISTED = 6
"""Screened sets in each table of the best."""


def write_report(search: Search, directory: Path) -> list[Path]:
    """Write report.md and the sensitivity figures of claims that the default misses.

    There is no figure of a claim for which nothing but the default was tried.

    Raises:
        UserError: the default has not been judged, or the folder can't be written.
    """
    if (STARTS[DEFAULT], "screened") not in search.judged:
        raise UserError(f'{directory}: expected a search from the start "{DEFAULT}", found none')
    verdicts = found_by_claim(search)
    paths = [directory / REPORT_NAME]
    with written_to(directory):
        write_whole(paths[0], report_text(search))
        for claim, found in verdicts.items():
            claims, rows, own = _rows(search, found.level, claim)
            if found.verdict != "holds" and rows:
                data = sensitivity_dataset(claims, rows, own)
                name = f"sensitivity-claim-{claim}"
                paths += save_figure(plot_sensitivity(data), directory / name, data)[:1]
        marched = [
            claim
            for claim, found in verdicts.items()
            if found.level == "screened" or (found.level == "slow" and found.verdict != "holds")
        ]
        claims, rows, own = _rows(search, "screened", *marched)
        if rows:
            data = sensitivity_dataset(claims, rows, own)
            paths += save_figure(plot_overview(data), directory / OVERVIEW_NAME, data)[:1]
    return paths


def report_text(search: Search) -> str:
    """The report as Markdown."""
    screened = [each for each in search.judged.values() if each.level == "screened"]
    faithful = [each for each in screened if each.faithful]
    claims = sorted(screened[0].verdicts)
    confirmed = search.best(len(search.judged), "confirmed")
    how = (
        f" {len(confirmed)} were confirmed at the paper's time step over"
        f" {SCRUTINIES['confirmed'].repeats} repeats whose force differs by {PERTURBATION:g}: there"
        " a claim holds that holds in all of them."
    )
    return "\n".join(
        [
            f"{len(screened)} sets were screened by {len(claims)} claims, {_numbers(claims)};"
            f" {len(faithful)} of them keep every value that the paper gives."
            + (how if confirmed else ""),
            "",
            *_table(search, faithful=True),
            *_table(search, faithful=False),
            *_bridges(screened),
            *_flips(search),
        ]
    )


def _table(search: Search, *, faithful: bool) -> Iterator[str]:
    """The best sets of a group: first those that were confirmed."""
    yield (
        "### Sets that keep every value that the paper gives"
        if faithful
        else ("### Sets that change a value that the paper gives")
    )
    yield ""
    listed = [
        *search.best(len(search.judged), "confirmed", faithful=faithful),
        *search.best(LISTED, faithful=faithful),
    ]
    listed += [
        each
        for start in STARTS.values()
        if (each := search.judged.get((start, "screened")))
        and each.faithful == faithful
        and each not in listed
    ]
    if not listed:
        yield "None was tried."
        yield ""
        return
    shared = _shared([each.values for each in listed])
    yield from ("| | hold | partly | that hold | set |", "|---|---|---|---|---|")
    names = {start: f', "{name}"' for name, start in STARTS.items()}
    for each in listed:
        holds, partly = each.rank
        yield (
            f"| {each.level}{names.get(each.values, '')} | {holds} | {partly} | {_met(each)} |"
            f" {each.values.words(shared)} |"
        )
    yield ""
    if shared:
        yield f"All of them have {listed[0].values.words(set(PARAMETERS) - shared)}."
        yield ""


def _bridges(screened: list[Judged]) -> Iterator[str]:
    """Which sets satisfy the claims that soft and supported casings satisfy by turns."""
    found = [each for each in screened if each.bridges]
    kept = sum(each.faithful for each in found)
    words = f"Claims {_numbers(BRIDGE)} together hold in {len(found)} of the screened sets"
    if not found:
        yield f"{words}."
    else:
        common = [
            name
            for name in found[0].values.departures
            if all(name in each.values.departures for each in found)
        ]
        price = f"; all of them change {' and '.join(common)}" if common else ""
        best = max(found, key=lambda each: each.rank)
        yield (
            f"{words}, {kept} of which keep what the paper gives{price}. The best of them:"
            f" {best.values.words()}."
        )
    yield ""


def _shared(sets: list[ParameterSet]) -> set[str]:
    """Parameters that have the same value in all sets."""
    rows = [asdict(values) for values in sets]
    return {name for name in PARAMETERS if len({row[name] for row in rows}) == 1}


@dataclass(frozen=True, kw_only=True)
class Found:
    """The verdict on the base that is changed one value at a time."""

    verdict: Verdict
    ours: str  #: our value
    level: Level  #: at which that was found


def found_by_claim(search: Search) -> dict[int, Found]:
    """Verdicts of all claims on the bases."""
    found = {
        claim: Found(verdict=verdict, ours=judged.ours[claim], level=level)
        for level, start in BASES.items()
        if (judged := search.judged.get((STARTS[start], level)))
        for claim, verdict in judged.verdicts.items()
    }
    return dict(sorted(found.items()))


HOW: Mapping[Level, str] = {"slow": ", by coarse sweeps and steps of 2 µs"}
"""Words on a level beside our value; nothing of the others."""


def _flips(search: Search) -> Iterator[str]:
    """In words: which values of which parameter meet a claim that the base misses."""
    yield from (
        "What single change of the default of the paper's two cases,"
        f' "{DEFAULT}", turns a claim that it misses (of claims 1 to 5 and 9 to 15: of that of'
        f' modal work, "{MODAL}"):',
        "",
    )
    for claim, missed in found_by_claim(search).items():
        if missed.verdict == "holds":
            continue
        base = STARTS[BASES[missed.level]]
        found = []
        for parameter, values in UNKNOWNS.items():
            met = [v for v in values if _verdict(search, base, parameter, v, claim) == "holds"]
            if met:
                own = asdict(base)[parameter]
                instead = f" instead of {own}" if base.uses(parameter) else ""
                found.append(f"{PARAMETERS[parameter]} {', '.join(map(str, met))}{instead}")
        words = "; ".join(found) or "none that was tried"
        how = HOW.get(missed.level, "")
        yield f"* {claim} ({missed.verdict}: {missed.ours}{how}): {words}."
    yield ""


def _rows(
    search: Search, level: Level, *claims: int
) -> tuple[dict[int, str], dict[str, list[tuple[str, list[str]]]], dict[str, str]]:
    """Claims in words; for each parameter its values with the verdict on each claim; the base.

    Parameters of which no value was tried are left out.
    """
    base = STARTS[BASES[level]]
    rows = {
        PARAMETERS[name]: [
            (_shown(value), [_verdict(search, base, name, value, claim) for claim in claims])
            for value in values
        ]
        for name, values in UNKNOWNS.items()
        if base.uses(name)
        and any(
            _verdict(search, base, name, value, claim)
            for value in values
            if value != asdict(base)[name]
            for claim in claims
        )
    }
    own = {PARAMETERS[name]: _shown(value) for name, value in asdict(base).items()}
    return {claim: CLAIMS[claim].text for claim in claims}, rows, own


def _verdict(search: Search, base: ParameterSet, name: str, value: object, claim: int) -> str:
    """The verdict where one value of a set is another; empty if not tried."""
    values = replace(base, **{name: value})  # type: ignore[arg-type]
    for level in BASES:
        judged = search.judged.get((values, level))
        if judged and claim in judged.verdicts:
            return judged.verdicts[claim]
    return ""


def _shown(value: object) -> str:
    return ("no", "yes")[value] if isinstance(value, bool) else str(value)


def _met(judged: Judged) -> str:
    return _numbers(claim for claim, verdict in judged.verdicts.items() if verdict == "holds")


def _numbers(claims: Iterable[int]) -> str:
    return ", ".join(map(str, claims))
