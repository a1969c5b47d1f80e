"""Pages of reports, taken apart for tests."""

import json
import re
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest
from command_line import answer

from bladewhirl.postprocess.reports import page as report_page

PICTURE = "AAAA"
LOADING = {"src", "srcset", "data", "poster", "action", "background", "formaction"}


class Parsed(HTMLParser):
    """What a page refers to, its pictures by figure with the values under the pointer, its film and
    its text."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.references: list[str] = []
        self.pictures: dict[str, str] = {}
        self.tags: list[str] = []
        self.values: dict[str, list[dict[str, Any]]] = {}
        self.film = ""
        self.words = ""
        self.styles = ""
        self._open = ""
        self._figure = self._values = ""
        self.feed(text)
        self.words = " ".join(self.words.split())

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = {name: value or "" for name, value in attrs}
        self.tags.append(tag)
        self._open = given.get("class", tag)
        if tag == "figure":
            self._figure = given["id"]
        self.references += [given[name] for name in LOADING & given.keys()]
        if "href" in given:
            self.references.append(given["href"])
        if tag == "img":
            self.pictures[self._figure] = given["src"]
        if tag == "iframe":
            self.film = given["srcdoc"]
        self._values = given.get("id", "").removesuffix("-values")

    def handle_endtag(self, tag: str) -> None:
        self._open = ""

    def handle_data(self, data: str) -> None:
        if self._open == "script" and self._values:
            self.values[self._values] = json.loads(data)
        elif self._open == "style":
            self.styles += data
        elif self._open != "script":
            self.words += f" {data}"

    def outside(self) -> list[str]:
        """What a browser would have to load from elsewhere."""
        own = r"#[\w-]+$|data:image/png;base64,|histories/point_\d+\.html$"
        loading = [tag for tag in self.tags if tag in ("link", "object", "embed", "base")]
        imported = re.findall(r"url\(|@import", self.styles)
        return [*(text for text in self.references if not re.match(own, text)), *loading, *imported]


def reported(folder: Path) -> Parsed:
    """Return the page that `report` writes for a run or a sweep, with `PICTURE` for all figures."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(report_page, "_as_png", lambda figure: PICTURE)
        done = answer("report", folder)
    assert done.stdout == f"Wrote {folder / 'report.html'}.\n"
    parsed = Parsed((folder / "report.html").read_text(encoding="utf-8"))
    assert parsed.references
    assert parsed.outside() == []
    return parsed
