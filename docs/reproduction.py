"""Write the results of `bladewhirl reproduce` into the documentation.

    bladewhirl reproduce -o REPRODUCTION
    python docs/reproduction.py REPRODUCTION

The script replaces the scorecard in reproduction.md, the figures in paper_figures.md and the counts
of verdicts in README.md. reproduction.md names the commit of the checkout, so run the script at the
commit with which REPRODUCTION was computed.
"""

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
"""Pattern of the sentence in README.md that counts the verdicts."""

AFTER_INTRODUCTION = re.compile(r"^## .*", re.DOTALL | re.MULTILINE)
"""Pattern of a page from the first heading of level 2 to the end."""

WIDTH, COLOURS = 1000, 256  #: largest width [pixels] and number of colours of a picture

CARD = re.compile(r"(?<=^## Scorecard\n).*?(?=^## )", re.DOTALL | re.MULTILINE)
"""Pattern of the text of the section "Scorecard"."""


def main(folder: str) -> None:
    """Write scorecard, counts and figures from the folder of a reproduction."""
    card = json.loads((Path(folder) / "scorecard.json").read_text(encoding="utf-8"))
    replace(PAGE, CARD, "\n" + "\n".join(scored(card)) + "\n\n")
    replace(README, COUNT, sentence(card))
    replace(FIGURES, AFTER_INTRODUCTION, "\n".join(figures(Path(folder) / "figures", card)))


def replace(path: Path, part: re.Pattern[str], text: str) -> None:
    """Replace the part of a file that matches a pattern.

    Raises:
        SystemExit: no part of the file matches.
    """
    before = path.read_text(encoding="utf-8")
    match = part.search(before)
    if match is None:
        sys.exit(f"{path}: expected {part.pattern}")
    path.write_text(before[: match.start()] + text + before[match.end() :], encoding="utf-8")


def commit() -> str:
    """Return the abbreviated hash of the commit of the checkout."""
    command = ["git", "-C", str(DOCS), "rev-parse", "--short=10", "HEAD"]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()


def sentence(scorecard: dict[str, Any]) -> str:
    """Return a sentence that counts the claims by verdict."""
    counts = ", ".join(counted(verdict, number) for verdict, number in scorecard["counts"].items())
    return (
        f"`bladewhirl reproduce`: of {len(scorecard['claims'])} claims {counts};"
        " [each of them](docs/reproduction.md)."
    )


def scored(scorecard: dict[str, Any]) -> Iterator[str]:
    """Yield the lines of the scorecard in Markdown."""
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
    """Yield the lines of a Markdown table of claims."""
    yield from ("| | claim | paper | ours | verdict |", "|---|---|---|---|---|")
    for row in claims:
        cells = (row[name].replace("|", "\\|") for name in ("text", "paper", "ours", "verdict"))
        yield f"| {row['claim']} | {' | '.join(cells)} |"


def figures(drawn: Path, scorecard: dict[str, Any]) -> Iterator[str]:
    """Save our versions of the paper's figures; yield Markdown with pictures and their claims."""
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
