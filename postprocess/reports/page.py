"""Content of reports, and conversion of the content to a page, which is one HTML file.

The page embeds pictures as PNG and the program that draws interactive plots. The content security
policy of the page forbids loading of other files.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import plotly.graph_objects as go
import xarray as xr
from matplotlib.figure import Figure

from bladewhirl.files import write_atomically
from bladewhirl.postprocess.fields.kinematics import Array, ViewError
from bladewhirl.postprocess.plotting.figures import Figures
from bladewhirl.postprocess.plotting.files import checked_target, filled_template
from bladewhirl.postprocess.plotting.hover import as_png, hover_data, script
from bladewhirl.postprocess.plotting.style import laid_out, styled


@dataclass(frozen=True, kw_only=True)
class Block:
    """Block of a section; `kind` selects the part of the template that shows the block."""

    kind: ClassVar[str]

    name: str
    title: str
    caption: str = ""
    folded: bool = False  #: true for a block that is closed until it is clicked
    wide: bool = True  #: true for the width of the page, false for half of it


@dataclass(frozen=True, kw_only=True)
class ReportFigure(Block):
    """Figure, or the reason why the figure is missing."""

    kind = "drawing"

    picture: str = ""  #: PNG in base64; empty if the figure is missing
    hover: Sequence[Mapping[str, Any]] = ()  #: values under the pointer, see `hover.hover_data`
    obstacle: str = ""  #: reason why there is no picture


@dataclass(frozen=True, kw_only=True)
class PageTable(Block):
    """Table of texts."""

    kind = "table"

    rows: Sequence[Sequence[str]]
    head: Sequence[str] = ()
    numbers: bool = False  #: true if all columns after the first contain numbers
    marked: int | None = None  #: number of the highlighted row


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
    """Plots of stage, orbit and histories at the instant of a time cursor."""

    kind = "instants"

    times: Array  #: instants [s]
    first: int  #: number of the instant shown first
    words: Sequence[str]  #: text about the contact at each instant
    places: Sequence[Array]
    """Positions of the marker in each orbit at every instant (instant, 2), one array per frame."""
    machine: Sequence[Mapping[str, Any]]  #: layers of the stage: `colour`, `places` (outlines)


@dataclass(frozen=True, kw_only=True)
class PageSection:
    """Section of a report."""

    name: str
    title: str
    blocks: Sequence[Block]
    words: str = ""  #: text below the title


@dataclass(frozen=True, kw_only=True)
class Page:
    """Content of a report."""

    title: str
    subject: str  #: name, program and date
    verdict: str  #: the result in a few words
    tone: str  #: class of the verdict, which selects its colour: "good", "fair", "bad" or "open"
    reason: str  #: reason for the verdict
    warnings: Sequence[str]
    figures: Sequence[tuple[str, str, str]]  #: key figures: name, value, remark
    sections: Sequence[PageSection]


def report_figures(
    figures: Figures, section: str, left_out: Collection[str] = ()
) -> list[ReportFigure]:
    """Return the figures of a section with captions, except for those whose names are left out. If
    a figure cannot be drawn, the reason replaces it."""
    drawn = []
    for kind in figures.kinds.values():
        if kind.section != section or kind.name in left_out:
            continue
        picture, obstacle, caption, hover = "", "", f"{kind.about}.", list[dict[str, Any]]()
        try:
            figure, data = figures.draw(kind.name)
            picture, caption = _as_png(figure), kind.caption_of(_contents(data))
            hover = hover_data(figure)
        except ViewError as error:
            obstacle = str(error)
        drawn.append(
            ReportFigure(
                name=kind.name,
                title=kind.title,
                caption=caption,
                picture=picture,
                hover=hover,
                obstacle=obstacle,
                wide=kind.wide,
            )
        )
    return drawn


def _contents(data: xr.Dataset) -> set[str]:
    """Return the names of the variables of a Dataset, and the texts in it and in its attributes."""
    texts = [values.values.astype(str) for values in data.variables.values() if _is_text(values)]
    named = {str(text) for each in texts for text in np.unique(each)}
    return {*map(str, data.variables), *map(str, data.attrs.values()), *named}


def _is_text(values: xr.Variable) -> bool:
    return values.dtype.kind in "OUT"


@styled
def _as_png(figure: Figure) -> str:
    with laid_out(figure):
        return as_png(figure)


def write_page(page: Page, path: str | Path) -> Path:
    """Write a page; return its path. No incomplete file remains if writing fails.

    Raises:
        ViewError: the path does not end in .html.
        OSError: the file cannot be written.
    """
    target = checked_target(path, ".html")
    draws = any(isinstance(block, Explorer) for part in page.sections for block in part.blocks)
    plotly = resources.files("plotly").joinpath("package_data/plotly.min.js")
    program = plotly.read_text("utf-8") if draws else ""  # five megabytes
    package = "bladewhirl.postprocess.reports"
    text = filled_template(package, "page.html", page=page, program=program, hover=script())
    write_atomically(target, text)
    return target
