"""Reports as one HTML file: what they are made of, and how that becomes a page.

A page needs no other file and no network, and says so to the browser, which then loads nothing
else (a content security policy): pictures are inside as PNG, and so is what draws the maps.
"""

from __future__ import annotations

import base64
import io
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any, ClassVar

import plotly.graph_objects as go
import xarray as xr
from matplotlib.figure import Figure

from bladewhirl.meshes.files.drafts import write_whole
from bladewhirl.postprocess.fields.kinematics import Array, ViewError
from bladewhirl.postprocess.plotting.files import checked_target, filled_template
from bladewhirl.postprocess.plotting.registry import FigureKind
from bladewhirl.postprocess.plotting.style import styled

DPI = 200
"""Of the pictures: sharp where a column of 8 cm is shown as wide as half a laptop's screen."""


@dataclass(frozen=True, kw_only=True)
class Block:
    """A piece of a section; `kind` is the part of the template that shows it."""

    kind: ClassVar[str]

    name: str
    title: str
    caption: str = ""
    folded: bool = False  #: opened by a click
    wide: bool = True  #: across the page, not half of it


@dataclass(frozen=True, kw_only=True)
class ReportFigure(Block):
    """A figure, or why there is none."""

    kind = "drawing"

    picture: str = ""  #: PNG, as text
    obstacle: str = ""  #: why there is no picture


@dataclass(frozen=True, kw_only=True)
class Table(Block):
    """Rows of words."""

    kind = "table"

    rows: Sequence[Sequence[str]]
    head: Sequence[str] = ()
    numbers: bool = False  #: all but the first column are numbers
    marked: int | None = None  #: row that stands out


@dataclass(frozen=True, kw_only=True)
class Text(Block):
    """Words as they are, in type of one width."""

    kind = "text"

    text: str


@dataclass(frozen=True, kw_only=True)
class Explorer(Block):
    """Plots to point at, side by side."""

    kind = "explorer"

    plots: Sequence[go.Figure]


@dataclass(frozen=True, kw_only=True)
class Instants(Explorer):
    """A machine, an orbit and histories, with a cursor that goes through instants."""

    kind = "instants"

    times: Array  #: of the instants [s]
    first: int  #: number of the instant that is shown first
    words: Sequence[str]  #: what touches at each
    places: Sequence[Array]
    """Of each of the orbit's markers, which are its last traces, at every instant: (instant, 2)."""
    machine: Sequence[Mapping[str, Any]]  #: outlines, lowest first: `colour`, and `places`
    """in 16 bits, (instant, outline, point, 2)."""


@dataclass(frozen=True, kw_only=True)
class Section:
    """A part of a report, with a line in its contents."""

    name: str
    title: str
    blocks: Sequence[Block]
    words: str = ""


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


def report_figures(
    draw: Callable[[str], tuple[Figure, xr.Dataset]], kinds: Iterable[FigureKind]
) -> list[ReportFigure]:
    """Figures of a result with their words, and why there is none where one can't be had.

    Args:
        draw: draws the figure of a name, or raises ViewError.
        kinds: of figures.
    """
    return [_report_figure(draw, kind) for kind in kinds]


def _report_figure(
    draw: Callable[[str], tuple[Figure, xr.Dataset]], kind: FigureKind
) -> ReportFigure:
    picture, obstacle = "", ""
    try:
        picture = _as_png(draw(kind.name)[0])
    except ViewError as error:
        obstacle = str(error)
    return ReportFigure(
        name=kind.name,
        title=kind.title,
        caption=kind.caption,
        picture=picture,
        obstacle=obstacle,
        wide=kind.wide,
    )


@styled
def _as_png(figure: Figure) -> str:
    file = io.BytesIO()
    figure.savefig(file, format="png", dpi=DPI)
    return base64.b64encode(file.getvalue()).decode("ascii")


def page_html(page: Page) -> str:
    """The page as HTML."""
    draws = any(isinstance(block, Explorer) for part in page.sections for block in part.blocks)
    return filled_template(
        "bladewhirl.postprocess.reports",
        "page.html",
        page=page,
        program=_plotly() if draws else "",
    )


def _plotly() -> str:
    """The program that draws maps: five megabytes; Plotly's Python side is not needed."""
    return resources.files("plotly").joinpath("package_data/plotly.min.js").read_text("utf-8")


def write_page(page: Page, path: str | Path) -> Path:
    """Write a page, whole or not at all; returns its path.

    Raises:
        ViewError: the name does not end in .html.
        OSError: it can't be written.
    """
    target = checked_target(path, ".html")
    write_whole(target, page_html(page))
    return target
