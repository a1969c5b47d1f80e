"""Sections of the verification manual: a table and figures of each subject, computed now.

`python verified.py PAGE FOLDER` draws into the folder and prints a JSON list with the Markdown.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

from matplotlib.figure import Figure
from pictures_of_the_model import BLUE, INK
from refinements import REFINEMENTS, Refinement, measured, picture

import bladewhirl as bw
from bladewhirl.studies.verification.case import Outcome
from bladewhirl.studies.verification.table import SUBJECTS, Verification

SMALLEST = 1e-8
"""Share of the tolerance at the edge of the figures; smaller errors are shown there."""

SPELLED = {"craig bampton": "Craig-Bampton", "mathieu": "Mathieu's", "nafems": "NAFEMS"} | {
    "opensees": "OpenSees",
    "runge kutta": "Runge-Kutta",
    "coriolis": "Coriolis",
}
"""Names in those of cases, as they are written."""


def sections(folder: Path) -> Iterator[str]:
    """Text of each subject; its figures go to the folder."""
    for subject, outcomes in bw.verify().by_subject().items():
        head, _, table = Verification(outcomes=tuple(outcomes)).to_markdown().partition("\n\n")
        _save(margins(SUBJECTS[subject], outcomes), folder, subject)
        drawn = f"![{SUBJECTS[subject]}: error over tolerance](built/verification/{subject}.svg)"
        yield f"{head}\n\n{drawn}\n\n{{.cases}}\n{table}"
        refined = [one for one in REFINEMENTS if one.subject == subject]
        if refined:
            yield f"### {SUBJECTS[subject]}: how errors fall\n\n{{.refinements}}"
            yield "\n".join(_refined(one, folder) for one in refined) + "\n"


def _refined(one: Refinement, folder: Path) -> str:
    errors = one.errors()
    name = f"{one.subject}-{one.name}"
    _save(picture(one, errors), folder, name)
    orders = ", ".join(f"{order:.2f}" for order in measured(one.sizes, errors))
    expected = "" if one.order is None else f", expected {one.order:.3g}"
    return (
        f"- ![{one.title}: error over {one.size}](built/verification/{name}.svg)"
        f" {one.title}: measured order {orders}{expected} ({one.because})."
    )


def margins(title: str, outcomes: Sequence[Outcome]) -> Figure:
    """A dot for each case at its error over what is allowed, a line for cases of one kind."""
    shares: dict[str, list[float]] = {}
    for outcome in outcomes:
        share = outcome.error / outcome.tolerance if outcome.error else 0.0
        kind = outcome.name.partition(".")[2].partition("[")[0].replace("_", " ")
        for plain, name in SPELLED.items():
            kind = kind.replace(plain, name)
        shares.setdefault(kind, []).append(share)
    figure = Figure(figsize=(6.0, 0.9 + 0.22 * len(shares)), layout="constrained")
    axes = figure.add_subplot()
    for row, values in enumerate(shares.values()):
        inside = [share for share in values if share > SMALLEST]
        axes.plot(inside, [row] * len(inside), "o", color=BLUE, ms=5, alpha=0.7)
        if len(inside) < len(values):
            axes.plot(SMALLEST, row, "<", color=BLUE, mfc="white", ms=6, clip_on=False, zorder=3)
    axes.axvline(1.0, color=INK, ls="--", lw=1)
    axes.set_yticks(range(len(shares)), list(shares), fontsize=8)
    axes.set(xscale="log", xlim=(SMALLEST, 10.0), ylim=(len(shares) - 0.4, -0.6))
    axes.set_xlabel("error over tolerance (1: what is allowed; ◁: smaller, or none)", fontsize=9)
    axes.set_title(f"{title}: {len(outcomes)} cases", fontsize=10)
    axes.grid(axis="x", alpha=0.3)
    return figure


def _save(figure: Figure, folder: Path, name: str) -> None:
    figure.savefig(folder / f"{name}.svg", metadata={"Date": None})


def main(folder: str) -> None:
    """Draw, and print the text."""
    place = Path(folder)
    place.mkdir(parents=True, exist_ok=True)
    print(json.dumps(["\n".join(sections(place))]))


if __name__ == "__main__":
    main(sys.argv[2])
