"""Writes reproduction.md, and the count in README.md, from what the two commands left.

    bladewhirl reproduce -o REPRODUCTION
    bladewhirl search -o SEARCH
    python docs/reproduction.py REPRODUCTION SEARCH

Without SEARCH the page has the scorecard alone.
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

DOCS = Path(__file__).parent
PAGE, README = DOCS / "reproduction.md", DOCS.parent / "README.md"
COUNT = re.compile(r"(?<=<!-- scorecard -->\n).*?(?=\n<!-- scorecard end -->)", re.DOTALL)
"""What README.md says of the scorecard."""


def main(arguments: list[str]) -> None:
    """Write both."""
    scorecard = json.loads((Path(arguments[0]) / "scorecard.json").read_text(encoding="utf-8"))
    search = [(Path(folder) / "report.md").read_text("utf-8") for folder in arguments[1:]]
    PAGE.write_text("\n".join([*page(scorecard), *found(search)]) + "\n", encoding="utf-8")
    text = README.read_text(encoding="utf-8")
    README.write_text(COUNT.sub(lambda _: sentence(scorecard), text), encoding="utf-8")


def sentence(scorecard: dict[str, Any]) -> str:
    """The count in words."""
    counts = ", ".join(f"{number} {verdict}" for verdict, number in scorecard["counts"].items())
    return (
        f"`bladewhirl reproduce`: of {len(scorecard['claims'])} claims {counts};"
        " [each of them](docs/reproduction.md)."
    )


def page(scorecard: dict[str, Any]) -> Iterator[str]:
    """The scorecard as Markdown."""
    yield from ("# What holds of the paper", "", sentence(scorecard), "", "| | |", "|---|---|")
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


def found(search: list[str]) -> Iterator[str]:
    """The report of a search as a section."""
    for text in search:
        yield from ("", "## Other values of what the paper leaves out", "", text.rstrip())


if __name__ == "__main__":
    main(sys.argv[1:])
