"""Content of reports, and conversion of the content to a page, which is one HTML file.

The page embeds pictures as PNG, with the values that a script shows under the pointer. The content
security policy of the page forbids loading of other files.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from bladewhirl.files import write_atomically
from bladewhirl.postprocess.fields.kinematics import ViewError
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
    links: Mapping[int, str] = field(default_factory=dict)  #: pages of rows by their numbers


@dataclass(frozen=True, kw_only=True)
class Text(Block):
    """Preformatted text."""

    kind = "text"

    text: str


@dataclass(frozen=True, kw_only=True)
class Film(Block):
    """Film of the stage, which can be turned, as a page in the page."""

    kind = "film"

    text: str  #: the page, see `web_page.film_page`


@dataclass(frozen=True, kw_only=True)
class Player(Block):
    """Maps that play over time."""

    kind = "player"

    rows: Sequence[Mapping[str, Any]]
    """Maps: `label`, `top`, the value of the last shade, `shape` (time, row, column), `shades` and
    `colours` in base64."""
    times: Sequence[str]  #: text of each time
    start: int  #: number of the time that is shown first


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
        shown = ReportFigure(
            name=kind.name, title=kind.title, caption=f"{kind.about}.", wide=kind.wide
        )
        try:
            figure, data = figures.draw(kind.name)
            shown = replace(with_picture(shown, figure), caption=kind.caption_of(_contents(data)))
        except ViewError as error:
            shown = replace(shown, obstacle=str(error))
        drawn.append(shown)
    return drawn


def with_picture(block: ReportFigure, figure: Figure) -> ReportFigure:
    """Return a block with the picture of a figure, and the values under the pointer."""
    picture = _as_png(figure)
    return replace(block, picture=picture, hover=hover_data(figure))


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
    package = "bladewhirl.postprocess.reports"
    text = filled_template(package, "page.html", page=page, script=script())
    write_atomically(target, text)
    return target
