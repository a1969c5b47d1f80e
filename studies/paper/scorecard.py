"""Scorecard: verdicts of claims from all repeats, with numbers, as JSON, a table and a page."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Any

from rich import box
from rich import table as rich_table
from rich.markup import escape

from bladewhirl.files import json_text
from bladewhirl.postprocess.reports.page import Page, PageSection, PageTable, ReportFigure
from bladewhirl.studies.paper.claim import VERDICTS, Claim, Finding, Verdict

STYLES: Mapping[Verdict, str] = {
    "holds": "green",
    "partly": "yellow",
    "does not hold": "red",
    "not testable": "dim",
}

PLURALS: Mapping[str, str] = {"holds": "hold", "does not hold": "do not hold"}
"""Verdicts in the plural, if different from the singular."""


def counted(verdict: str, count: int) -> str:
    """Return the number of claims with a verdict, as text."""
    return f"{count} {verdict if count == 1 else PLURALS.get(verdict, verdict)}"


@dataclass(frozen=True, kw_only=True)
class Score:
    """Claim with its findings, one per repeat."""

    claim: Claim
    findings: tuple[Finding, ...]

    @property
    def verdict(self) -> Verdict:
        """Verdict from all repeats; "partly" if the repeats have different verdicts."""
        verdicts = {finding.verdict for finding in self.findings}
        return verdicts.pop() if len(verdicts) == 1 else "partly"

    @property
    def ours(self) -> str:
        """Our value in the first repeat."""
        return self.findings[0].ours

    @property
    def why(self) -> str:
        """Reason for the verdict in one sentence, and how the repeats differ."""
        counts = Counter(finding.verdict for finding in self.findings)
        if len(counts) == 1:
            return self.findings[0].why
        split = ", ".join(f"{name} in {n}" for name, n in counts.items())
        return f"{split} of {len(self.findings)} repeats; first: {self.findings[0].why}"


@dataclass(frozen=True, kw_only=True)
class Scorecard:
    """Scores and the conditions of the runs."""

    scores: tuple[Score, ...]
    conditions: Mapping[str, Any]  #: version, whether quick, repeats, changes of the cases, ...

    @property
    def counts(self) -> dict[Verdict, int]:
        """Number of claims by verdict."""
        counts = Counter(score.verdict for score in self.scores)
        return {verdict: counts[verdict] for verdict in VERDICTS}

    @property
    def summary(self) -> str:
        """Numbers of claims by verdict, as text."""
        named = ", ".join(counted(verdict, count) for verdict, count in self.counts.items())
        return f"{len(self.scores)} claims: {named}"

    def to_json(self) -> str:
        """Return the scorecard as a JSON document."""
        claims = [_entry(score) for score in self.scores]
        return json_text({"conditions": self.conditions, "counts": self.counts, "claims": claims})


def _entry(score: Score) -> dict[str, Any]:
    return {
        "claim": score.claim.number,
        "section": score.claim.section,
        "figures": list(score.claim.figures),
        "text": score.claim.text,
        "paper": score.claim.paper,
        "ours": score.ours,
        "verdict": score.verdict,
        "why": score.why,
        "repeats": [
            {
                "verdict": finding.verdict,
                "ours": finding.ours,
                "checks": [
                    {"text": check.text, "met": bool(check.met)} for check in finding.checks
                ],
                "obstacle": finding.obstacle,
            }
            for finding in score.findings
        ],
    }


def scorecard_table(card: Scorecard) -> rich_table.Table:
    """Return the scorecard as a table for the terminal."""
    quick = ", quick: short marches, coarse sweeps" if card.conditions.get("quick") else ""
    table = rich_table.Table(
        title=f"{card.summary}{quick}", box=box.SIMPLE_HEAD, title_justify="left"
    )
    table.add_column("", justify="right")
    table.add_column("claim", ratio=5, overflow="fold")
    table.add_column("ours", ratio=4, overflow="fold")
    table.add_column("verdict", no_wrap=True)
    for score in card.scores:
        # Criteria that are met are only in the JSON document and on the page.
        why = "" if score.verdict == "holds" else f"\n[dim]{escape(score.why)}[/]"
        table.add_row(
            str(score.claim.number),
            f"{escape(score.claim.text)}{why}",
            f"{escape(score.ours)}\n[dim]paper: {escape(score.claim.paper)}[/]",
            f"[{STYLES[score.verdict]}]{score.verdict}[/]",
        )
    return table


HEAD = ("", "claim", "paper", "ours", "verdict", "why")


def scorecard_page(card: Scorecard, drawn: Mapping[str, Sequence[ReportFigure]]) -> Page:
    """Return the scorecard as a report, with the panels of figures from `figures.draw_figures`."""
    ordered = sorted(card.scores, key=lambda score: (score.claim.place, score.claim.number))
    sections = [
        _section(section, list(scores), drawn)
        for section, scores in groupby(ordered, key=lambda score: score.claim.section)
    ]
    conditions = [(name.replace("_", " "), _text(v)) for name, v in card.conditions.items()]
    table = PageTable(name="conditions-table", title="", rows=conditions)
    return Page(
        title="Claims of the paper",
        subject=f"bladewhirl {card.conditions.get('bladewhirl', '')}".strip(),
        verdict=card.summary,
        tone="open",
        reason="Each claim is compared with the paper by thresholds.",
        warnings=(),
        figures=[(verdict, str(count), "") for verdict, count in card.counts.items()],
        sections=[*sections, PageSection(name="conditions", title="Conditions", blocks=[table])],
    )


def _section(
    section: str, scores: Sequence[Score], drawn: Mapping[str, Sequence[ReportFigure]]
) -> PageSection:
    rows = [
        (str(s.claim.number), s.claim.text, s.claim.paper, s.ours, s.verdict, s.why) for s in scores
    ]
    numbers = {number for score in scores for number in score.claim.figures if number in drawn}
    panels = [panel for number in sorted(numbers, key=int) for panel in drawn[number]]
    table = PageTable(name=f"claims-{section}", title="", head=HEAD, rows=rows)
    return PageSection(
        name=f"section-{section}", title=f"Section {section}", blocks=[table, *panels]
    )


def _text(value: object) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, Mapping):
        return ", ".join(f"{key} = {item}" for key, item in value.items()) or "none"
    return str(value)
