"""Reports as one HTML file: content, and conversion to a page.

A page needs no other file and no network, and its content security policy forbids loading either:
pictures are embedded as PNG, and the program that draws interactive plots is embedded, too.
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

from bladewhirl.files import write_atomically
from bladewhirl.postprocess.fields.kinematics import Array, ViewError
from bladewhirl.postprocess.plotting.files import checked_target, filled_template
from bladewhirl.postprocess.plotting.registry import FigureKind
from bladewhirl.postprocess.plotting.style import styled

DPI = 200  #: resolution of the pictures: a column of 8 cm is as wide as half a screen [1/inch]


@dataclass(frozen=True, kw_only=True)
class Block:
    """Block of a section; `kind` is the part of the template that shows it."""

    kind: ClassVar[str]

    name: str
    title: str
    caption: str = ""
    folded: bool = False  #: closed until clicked
    wide: bool = True  #: as wide as the page instead of half as wide


@dataclass(frozen=True, kw_only=True)
class ReportFigure(Block):
    """Figure, or the reason why it is missing."""

    kind = "drawing"

    picture: str = ""  #: PNG in base64
    obstacle: str = ""  #: reason why there is no picture


@dataclass(frozen=True, kw_only=True)
class Table(Block):
    """Table of texts."""

    kind = "table"

    rows: Sequence[Sequence[str]]
    head: Sequence[str] = ()
    numbers: bool = False  #: columns after the first are numbers
    marked: int | None = None  #: highlighted row


@dataclass(frozen=True, kw_only=True)
class Text(Block):
    """Preformatted text."""

    kind = "text"

    text: str


@dataclass(frozen=True, kw_only=True)
class Explorer(Block):
    """Interactive plots, side by side."""

    kind = "explorer"

    plots: Sequence[go.Figure]


@dataclass(frozen=True, kw_only=True)
class Instants(Explorer):
    """Machine, orbit and histories with a cursor of instants."""

    kind = "instants"

    times: Array  #: instants [s]
    first: int  #: number of the instant shown first
    words: Sequence[str]  #: text on the contacts at each instant
    places: Sequence[Array]
    """Positions of the markers of the orbit, its last traces, at every instant (instant, 2)."""
    machine: Sequence[Mapping[str, Any]]  #: outlines with `colour` and `places`


@dataclass(frozen=True, kw_only=True)
class Section:
    """Section of a report."""

    name: str
    title: str
    blocks: Sequence[Block]
    words: str = ""


@dataclass(frozen=True, kw_only=True)
class Page:
    """Content of a report."""

    title: str
    subject: str  #: name, program and date
    verdict: str  #: the result in a few words
    tone: str  #: "good", "fair", "bad" or "open"
    reason: str
    warnings: Sequence[str]
    figures: Sequence[tuple[str, str, str]]  #: key figures: name, value, remark
    sections: Sequence[Section]


def report_figures(
    draw: Callable[[str], tuple[Figure, xr.Dataset]], kinds: Iterable[FigureKind]
) -> list[ReportFigure]:
    """Return the figures of a result with captions, or with the reason why the figure is missing.

    Args:
        draw: function that draws the figure of a name, or raises ViewError.
        kinds: entries of the registry.
    """
    figures = []
    for kind in kinds:
        picture, obstacle = "", ""
        try:
            picture = _as_png(draw(kind.name)[0])
        except ViewError as error:
            obstacle = str(error)
        figures.append(
            ReportFigure(
                name=kind.name,
                title=kind.title,
                caption=kind.caption,
                picture=picture,
                obstacle=obstacle,
                wide=kind.wide,
            )
        )
    return figures


@styled
def _as_png(figure: Figure) -> str:
    file = io.BytesIO()
    figure.savefig(file, format="png", dpi=DPI)
    return base64.b64encode(file.getvalue()).decode("ascii")


def page_html(page: Page) -> str:
    """Return the page as HTML."""
    draws = any(isinstance(block, Explorer) for part in page.sections for block in part.blocks)
    plotly = resources.files("plotly").joinpath("package_data/plotly.min.js")
    program = plotly.read_text("utf-8") if draws else ""  # five megabytes
    return filled_template(
        "bladewhirl.postprocess.reports", "page.html", page=page, program=program
    )


def write_page(page: Page, path: str | Path) -> Path:
    """Write a page completely or not at all; return the path.

    Raises:
        ViewError: the path does not end in .html.
        OSError: the file cannot be written.
    """
    target = checked_target(path, ".html")
    write_atomically(target, page_html(page))
    return target
