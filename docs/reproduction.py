"""Writes reproduction.md with its picture, and the count in README.md, from what commands left.

    bladewhirl reproduce -o REPRODUCTION
    bladewhirl search --faithful --every-claim -o SEARCH
    bladewhirl search heavy --rounds 0 -o SEARCH
    bladewhirl search light --rounds 1 -o SEARCH
    python docs/reproduction.py REPRODUCTION SEARCH

A folder that is left out leaves its part of the page as it is, and the count without REPRODUCTION.
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from shutil import copyfile
from typing import Any

from bladewhirl.studies.paper.scorecard import counted

DOCS = Path(__file__).parent
PAGE, README = DOCS / "reproduction.md", DOCS.parent / "README.md"
COUNT = re.compile(r"(?<=<!-- scorecard -->\n).*?(?=\n<!-- scorecard end -->)", re.DOTALL)
"""The sentence of README.md on the scorecard."""

TITLE, SCORECARD, VALUES = (
    "# What holds of the paper",
    "Scorecard",
    "Values that the paper leaves out",
)
"""Headings of the page."""

ALTERNATIVE = "A row for each claim, a column for each single change of the default: the verdicts"
"""Of the picture of all claims."""


def main(arguments: list[str]) -> None:
    """Write both."""
    parts = present(PAGE.read_text(encoding="utf-8")) if PAGE.exists() else {}
    for folder in map(Path, arguments):
        if (folder / "scorecard.json").exists():
            scorecard = json.loads((folder / "scorecard.json").read_text(encoding="utf-8"))
            parts[SCORECARD] = "\n".join(scored(scorecard))
            text = README.read_text(encoding="utf-8")
            count = COUNT.search(text)
            if count is None:
                sys.exit(f"{README}: expected the marks of the scorecard")
            text = text[: count.start()] + sentence(scorecard) + text[count.end() :]
            README.write_text(text, encoding="utf-8")
        else:
            report = (folder / "report.md").read_text(encoding="utf-8")
            copyfile(folder / "sensitivity.png", PAGE.with_name("sensitivity.png"))
            parts[VALUES] = f"{report.rstrip()}\n\n![{ALTERNATIVE}](sensitivity.png)"
    lines = [
        TITLE,
        *(f"## {name}\n\n{parts[name]}" for name in (SCORECARD, VALUES) if name in parts),
    ]
    PAGE.write_text("\n\n".join(lines) + "\n", encoding="utf-8")


def present(page: str) -> dict[str, str]:
    """Parts of the page by heading."""
    _, *found = re.split(r"^## (.+)\n", page, flags=re.MULTILINE)
    return {name: text.strip() for name, text in zip(found[::2], found[1::2], strict=True)}


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
    yield from ("| condition | |", "|---|---|")
    for name, value in scorecard["conditions"].items():
        yield f"| {name.replace('_', ' ')} | {value if value != {} else 'none'} |"
    yield from ("", "| | claim | paper | ours | verdict |", "|---|---|---|---|---|")
    for row in scorecard["claims"]:
        cells = (row[name].replace("|", "\\|") for name in ("text", "paper", "ours", "verdict"))
        yield f"| {row['claim']} | {' | '.join(cells)} |"
    yield from ("", "Why a claim does not hold, or holds in part:", "")
    for row in scorecard["claims"]:
        if row["verdict"] != "holds":
            yield f"* {row['claim']}, {row['verdict']}: {row['why']}"


if __name__ == "__main__":
    main(sys.argv[1:])
