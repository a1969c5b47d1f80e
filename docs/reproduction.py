"""Writes what `bladewhirl reproduce` found into the pages and README.md.

    bladewhirl reproduce -o REPRODUCTION
    python docs/reproduction.py REPRODUCTION

These are the scorecard of reproduction.md, paper_figures.md with its pictures, and the count in
README.md; the rest of a page is left as it is. reproduction.md names the commit that the checkout
is at, which has to be the one that REPRODUCTION was made from.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pictures import keep

from bladewhirl.studies.paper.figures import PAPER_FIGURES
from bladewhirl.studies.paper.scorecard import counted

DOCS = Path(__file__).parent
PAGE, README = DOCS / "reproduction.md", DOCS.parent / "README.md"
FIGURES, PICTURES = DOCS / "paper_figures.md", "paper_figures"
COUNT = re.compile(r"(?<=<!-- scorecard -->\n).*?(?=\n<!-- scorecard end -->)", re.DOTALL)
"""The sentence of README.md on the scorecard."""

AFTER_INTRODUCTION = re.compile(r"^## .*", re.DOTALL | re.MULTILINE)
"""All of a page from its first heading on."""

WIDTH, COLOURS = 1000, 256  #: of a picture [pixels], of its palette

CARD = re.compile(r"(?<=^## Scorecard\n).*?(?=^## )", re.DOTALL | re.MULTILINE)
"""What stands below the page's first heading."""


def main(folder: str) -> None:
    """Write them all."""
    card = json.loads((Path(folder) / "scorecard.json").read_text(encoding="utf-8"))
    replace(PAGE, CARD, "\n" + "\n".join(scored(card)) + "\n\n")
    replace(README, COUNT, sentence(card))
    replace(FIGURES, AFTER_INTRODUCTION, "\n".join(figures(Path(folder) / "figures", card)))


def replace(path: Path, part: re.Pattern[str], text: str) -> None:
    """Write another text into a part of a file.

    Raises:
        SystemExit: the file has no such part.
    """
    before = path.read_text(encoding="utf-8")
    match = part.search(before)
    if match is None:
        sys.exit(f"{path}: expected {part.pattern}")
    path.write_text(before[: match.start()] + text + before[match.end() :], encoding="utf-8")


def commit() -> str:
    """Name of the commit that the checkout is at."""
    command = ["git", "-C", str(DOCS), "rev-parse", "--short=10", "HEAD"]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()


def sentence(scorecard: dict[str, Any]) -> str:
    """The count in words."""
    counts = ", ".join(counted(verdict, number) for verdict, number in scorecard["counts"].items())
    return (
        f"`bladewhirl reproduce`: of {len(scorecard['claims'])} claims {counts};"
        " [each of them](docs/reproduction.md)."
    )


def scored(scorecard: dict[str, Any]) -> Iterator[str]:
    """The scorecard as Markdown."""
    yield from (sentence(scorecard).split(";")[0] + ".", "")
    yield from ("| condition | |", "|---|---|", f"| commit | {commit()} |")
    for name, value in scorecard["conditions"].items():
        yield f"| {name.replace('_', ' ')} | {value if value != {} else 'none'} |"
    yield from ("", *table(scorecard["claims"]))
    yield from ("", "Why a claim does not hold, or holds in part:", "")
    for row in scorecard["claims"]:
        if row["verdict"] != "holds":
            yield f"* {row['claim']}, {row['verdict']}: {row['why']}"


def table(claims: list[dict[str, Any]]) -> Iterator[str]:
    """Claims of the scorecard as a Markdown table."""
    yield from ("| | claim | paper | ours | verdict |", "|---|---|---|---|---|")
    for row in claims:
        cells = (row[name].replace("|", "\\|") for name in ("text", "paper", "ours", "verdict"))
        yield f"| {row['claim']} | {' | '.join(cells)} |"


def figures(drawn: Path, scorecard: dict[str, Any]) -> Iterator[str]:
    """Our pictures like the paper's figures, kept small, with the claims that they bear on."""
    for number, figure in PAPER_FIGURES.items():
        yield from (f"## Figure {number}: {figure.caption}", "")
        for panel in figure.panels:
            name = f"{PICTURES}/{panel.folder}-{panel.name}.png"
            keep(drawn / panel.folder / f"{panel.name}.png", name, COLOURS, widest=WIDTH)
            yield from (f"![{panel.caption}]({name})", "", f"*{panel.caption}*", "")
        claims = [claim for claim in scorecard["claims"] if number in claim["figures"]]
        if claims:
            yield from (*table(claims), "")


if __name__ == "__main__":
    main(*sys.argv[1:])
