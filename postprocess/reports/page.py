"""Reports as one HTML file: what they are made of, and how that becomes a page.

A page needs no other file and no network, and says so to the browser, which then loads nothing
else (a content security policy): pictures are inside as PNG, and so is what draws the maps.
"""

from __future__ import annotations

import base64
import io
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING

from jinja2 import Environment, StrictUndefined
from matplotlib.figure import Figure

from bladewhirl.postprocess.plotting.files import checked_target, replacing
from bladewhirl.postprocess.plotting.style import styled

if TYPE_CHECKING:
    import plotly.graph_objects as go

DPI = 200
"""Of the pictures: sharp where a column of 8 cm is shown as wide as half a laptop's screen."""

TEMPLATE = "page.html"


@dataclass(frozen=True, kw_only=True)
class ReportFigure:
    """A figure, or why there is none."""

    name: str
    title: str
    caption: str  #: what it shows, in which units, and what to look for
    picture: bytes | None  #: PNG
    obstacle: str = ""  #: why there is no picture
    wide: bool = False  #: across the page, not half of it

    @property
    def data(self) -> str:
        """The picture as text."""
        return base64.b64encode(self.picture or b"").decode("ascii")

    @property
    def kind(self) -> str:
        """Which part of the template shows it."""
        return "drawing"


@dataclass(frozen=True, kw_only=True)
class Table:
    """Rows of words."""

    name: str
    title: str
    rows: Sequence[Sequence[str]]
    head: Sequence[str] = ()
    caption: str = ""
    folded: bool = False  #: opened by a click
    wide: bool = True
    numbers: bool = False  #: all but the first column are numbers
    marked: int | None = None  #: row that stands out

    @property
    def kind(self) -> str:
        """Which part of the template shows it."""
        return "table"


@dataclass(frozen=True, kw_only=True)
class Text:
    """Words as they are, in type of one width."""

    name: str
    title: str
    text: str
    caption: str = ""
    folded: bool = True
    wide: bool = True

    @property
    def kind(self) -> str:
        """Which part of the template shows it."""
        return "text"


@dataclass(frozen=True, kw_only=True)
class Explorer:
    """Plots to point at, side by side; pointing at the first moves the marker of the second."""

    name: str
    title: str
    caption: str
    plots: Sequence[go.Figure]
    marked: Sequence[Sequence[Sequence[float]]] = ()
    """Places of each marker of the second plot, the last traces of it: (marker, column, x y)."""

    @property
    def kind(self) -> str:
        """Which part of the template shows it."""
        return "explorer"

    @property
    def documents(self) -> list[str]:
        """The plots as JSON that may stand in a page."""
        return [plot.to_json().replace("</", "<\\/") for plot in self.plots]


Block = ReportFigure | Table | Text | Explorer


@dataclass(frozen=True, kw_only=True)
class Section:
    """A part of a report, with a line in its contents."""

    name: str
    title: str
    words: str
    blocks: Sequence[Block]


@dataclass(frozen=True, kw_only=True)
class Page:
    """A report."""

    title: str
    subject: str  #: what is reported on, and when and by what it was made
    verdict: str  #: in a word or two
    tone: str  #: of the verdict: "good", "fair", "bad" or "open"
    reason: str
    warnings: Sequence[str]
    figures: Sequence[tuple[str, str, str]]  #: at a glance: name, value, remark
    sections: Sequence[Section]


@styled
def as_png(figure: Figure) -> bytes:
    """A figure as the content of a PNG file."""
    file = io.BytesIO()
    figure.savefig(file, format="png", dpi=DPI)
    return file.getvalue()


def page_html(page: Page) -> str:
    """The page as HTML."""
    # Loaded when used: its maps' program has five megabytes.
    from plotly.offline import get_plotlyjs

    source = resources.files("bladewhirl.postprocess.reports").joinpath(TEMPLATE).read_text("utf-8")
    environment = Environment(
        autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    draws = any(block.kind == "explorer" for part in page.sections for block in part.blocks)
    return environment.from_string(source).render(
        page=page, program=get_plotlyjs() if draws else ""
    )


def write_page(page: Page, path: str | Path) -> Path:
    """Write a page, whole or not at all; returns its path.

    Raises:
        ViewError: the name does not end in .html.
        OSError: it can't be written.
    """
    target = checked_target(path, ".html")
    with replacing(target) as draft:
        draft.write_text(page_html(page), encoding="utf-8")
    return target
