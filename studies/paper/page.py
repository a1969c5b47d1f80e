"""The scorecard as a page: claims by section of the paper, with its figures side by side."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import groupby

from bladewhirl.postprocess.reports.page import Page, ReportFigure, Section, Table
from bladewhirl.studies.paper.scorecard import Score, Scorecard

HEAD = ("", "claim", "paper", "ours", "verdict", "why")


def scorecard_page(card: Scorecard, drawn: Mapping[str, Sequence[ReportFigure]]) -> Page:
    """Return the scorecard as a report.

    Args:
        card: the scorecard.
        drawn: panels of each figure of the paper, from `figures.draw_figures`.
    """
    ordered = sorted(card.scores, key=lambda score: (_place(score), score.claim.number))
    sections = [
        _section(section, list(scores), drawn)
        for section, scores in groupby(ordered, key=lambda score: score.claim.section)
    ]
    conditions = [(name.replace("_", " "), _text(v)) for name, v in card.conditions.items()]
    table = Table(name="conditions-table", title="", rows=conditions)
    return Page(
        title="What holds of the paper",
        subject=f"bladewhirl {card.conditions.get('bladewhirl', '')}".strip(),
        verdict=card.summary,
        tone="open",
        reason="Each claim is compared with the paper by thresholds.",
        warnings=(),
        figures=[(verdict, str(count), "") for verdict, count in card.counts.items()],
        sections=[*sections, Section(name="conditions", title="Conditions", blocks=[table])],
    )


def _section(
    section: str, scores: Sequence[Score], drawn: Mapping[str, Sequence[ReportFigure]]
) -> Section:
    rows = [
        (str(s.claim.number), s.claim.text, s.claim.paper, s.ours, s.verdict, s.why) for s in scores
    ]
    numbers = {number for score in scores for number in score.claim.figures if number in drawn}
    panels = [panel for number in sorted(numbers, key=int) for panel in drawn[number]]
    table = Table(name=f"claims-{section}", title="", head=HEAD, rows=rows)
    return Section(name=f"section-{section}", title=f"Section {section}", blocks=[table, *panels])


def _place(score: Score) -> tuple[int, ...]:
    return tuple(int(part) for part in score.claim.section.split("."))


def _text(value: object) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, Mapping):
        return ", ".join(f"{key} = {item}" for key, item in value.items()) or "none"
    return str(value)
