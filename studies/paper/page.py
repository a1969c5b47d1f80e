"""The scorecard as a page: claims by section of the paper, with its figures side by side."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from html import escape
from itertools import groupby

from bladewhirl.studies.paper.claim import Verdict
from bladewhirl.studies.paper.figures import PAPER_FIGURES, DrawnPanel
from bladewhirl.studies.paper.scorecard import Score, Scorecard

COLOURS: Mapping[Verdict, str] = {
    "holds": "#009E73",
    "partly": "#B87800",
    "does not hold": "#D55E00",
    "not testable": "#666666",
}
"""Colours that colour-blind readers can distinguish, always beside the text."""

STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; max-width: 78rem; margin: 2rem auto; padding: 0 1rem;
  color: #222; background: #fff }
table { border-collapse: collapse; width: 100% }
th, td { text-align: left; vertical-align: top; padding: .4rem .6rem;
  border-bottom: 1px solid #ddd }
td.number { text-align: right; color: #666 }
td.verdict { white-space: nowrap; font-weight: 600 }
.why { color: #666; font-size: .87em }
.panels { display: flex; flex-wrap: wrap; gap: 1rem; align-items: flex-start }
figure { margin: 1.5rem 0 } figure figure { margin: 0; flex: 1 1 22rem; max-width: 48rem }
figure img { width: 100% } figcaption { font-size: .9em } figure > figcaption { font-weight: 600 }
figure figure > figcaption { font-weight: 400; color: #555 }
@media print { body { max-width: none; margin: 0 } figure { break-inside: avoid } }
"""


def scorecard_page(card: Scorecard, drawn: Mapping[str, Sequence[DrawnPanel]]) -> str:
    """A page that needs no other file and no network.

    Args:
        card: the scorecard.
        drawn: panels of each figure of the paper, from `figures.draw_figures`.
    """
    conditions = "".join(
        f"<tr><th>{escape(name.replace('_', ' '))}</th><td>{escape(_words(value))}</td></tr>"
        for name, value in card.conditions.items()
    )
    sections = []
    ordered = sorted(card.scores, key=lambda score: _place(score.claim.section))
    for section, scores in groupby(ordered, key=lambda score: score.claim.section):
        sections.append(_section(section, list(scores), drawn))
    return (
        '<!doctype html>\n<html lang="en">\n<head><meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>What holds of the paper</title>\n<style>{STYLE}</style></head>\n<body>\n"
        f"<h1>What holds of the paper</h1>\n<p>{escape(card.summary)}.</p>\n"
        f"<table>{conditions}</table>\n{''.join(sections)}</body>\n</html>\n"
    )


def _section(
    section: str, scores: Sequence[Score], drawn: Mapping[str, Sequence[DrawnPanel]]
) -> str:
    heads = "".join(f"<th>{name}</th>" for name in ("", "claim", "paper", "ours", "verdict"))
    rows = "\n".join(_row(score) for score in sorted(scores, key=lambda s: s.claim.number))
    numbers = dict.fromkeys(number for score in scores for number in score.claim.figures)
    shown = [number for number in sorted(numbers, key=int) if number in drawn]
    figures = "\n".join(_figure(number, drawn[number]) for number in shown)
    return (
        f"<h2>Section {escape(section)}</h2>\n<table><tr>{heads}</tr>\n{rows}</table>\n{figures}\n"
    )


def _row(score: Score) -> str:
    claim, verdict = score.claim, score.verdict
    return (
        f'<tr id="claim-{claim.number}"><td class="number">{claim.number}</td>'
        f'<td>{escape(claim.text)}<div class="why">{escape(score.why)}</div></td>'
        f"<td>{escape(claim.paper)}</td><td>{escape(score.ours)}</td>"
        f'<td class="verdict" style="color: {COLOURS[verdict]}">{verdict}</td></tr>'
    )


def _figure(number: str, panels: Sequence[DrawnPanel]) -> str:
    title = f"Like Fig. {number}: {PAPER_FIGURES[number].caption}"
    shown = "".join(_panel(panel) for panel in panels)
    caption = f"<figcaption>{escape(title)}</figcaption>"
    return f'<figure>{caption}<div class="panels">{shown}</div></figure>'


def _panel(panel: DrawnPanel) -> str:
    caption = f"<figcaption>{escape(panel.caption)}</figcaption>"
    if panel.picture is None:
        return f"<figure><p>not drawn: {escape(panel.obstacle)}</p>{caption}</figure>"
    data = base64.b64encode(panel.picture.read_bytes()).decode("ascii")
    image = f'<img alt="{escape(panel.caption)}" src="data:image/png;base64,{data}">'
    return f"<figure>{image}{caption}</figure>"


def _place(section: str) -> tuple[int, ...]:
    return tuple(int(part) for part in section.split("."))


def _words(value: object) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, Mapping):
        return ", ".join(f"{key} = {item}" for key, item in value.items()) or "none"
    return str(value)
