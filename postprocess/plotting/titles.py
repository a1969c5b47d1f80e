"""Titles of figures: name of the case, content of the figure, and speed."""

import re

import numpy as np
import xarray as xr
from matplotlib import rcParams
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties, findfont, get_font
from matplotlib.textpath import TextPath
from matplotlib.ticker import LogFormatter, NullFormatter

from bladewhirl.postprocess.fields.labelled import LOSS, SPEED_RANGE
from bladewhirl.postprocess.plotting.style import styled

MOST_LETTERS = 40  #: largest number of characters of a title per inch of the figure's width
WIDEST = 0.97
"""Largest width of a line of a title, divided by the figure's width."""

LINE = 0.13  #: height of a line of a title [inch]


def speed_label(dataset: xr.Dataset) -> str:
    """Return the speed, or its range, in multiples of the reference frequency ω₁ and in rpm."""
    names = SPEED_RANGE if SPEED_RANGE[0] in dataset.attrs else ("speed",)
    speeds = [float(dataset.attrs[name]) for name in names]
    reference = float(dataset.attrs["reference_frequency"])
    normalised = " to ".join(f"{speed / reference:.4g}" for speed in speeds)
    rpm = " to ".join(f"{speed * 30 / np.pi:.0f}" for speed in speeds)
    return f"Ω/ω₁ = {normalised} ({rpm} rpm)"


def head(figure: Figure, data: xr.Dataset, *words: str) -> None:
    """Set the title of a figure: the name of the case, and a line with the speed.

    Args:
        figure: figure drawn in the common style.
        data: dataset with the attributes of `fields.labelled`.
        words: texts that follow the speed.
    """
    lost = [data.attrs[LOSS]] if LOSS in data.attrs else []
    shown = ", ".join([speed_label(data), *lost, *words])
    set_title(figure, str(data.attrs.get("case_title", "")), shown)


def set_title(figure: Figure, case: str, shown: str) -> None:
    """Set the title of a complete figure: the name of the case, and the lines `shown`; exponents of
    its axes become legible."""
    in_font = get_font(findfont(FontProperties())).get_char_index
    most = int(MOST_LETTERS * figure.get_figwidth())
    name = " ".join(case[:most].split()) + " …" * (len(case) > most)
    name = "".join(c if in_font(ord(c)) else "\N{REPLACEMENT CHARACTER}" for c in name)
    retitle(figure, "\n".join(filter(None, [name, shown])))
    plain_exponents(figure)


@styled
def retitle(figure: Figure, title: str) -> None:
    """Give a figure another title, whose lines are broken at the width of the figure, which becomes
    higher; an empty text removes the title."""
    given = title.splitlines()
    lines = [part for line in given for part in _broken(line, figure)]
    figure.suptitle("\n".join(lines), parse_math=False)
    figure.set_figheight(figure.get_figheight() + LINE * (len(lines) - len(given)))


def plain_exponents(figure: Figure) -> None:
    """Write powers of ten of logarithmic axes as 1e-05, because raised exponents are too small."""
    for axes in [each for panel in figure.axes for each in (panel, *panel.child_axes)]:
        for axis in (axes.xaxis, axes.yaxis):
            old = axis.get_major_formatter()
            if isinstance(old, LogFormatter):
                new = LogFormatter(linthresh=old._linthresh)  # type: ignore[attr-defined]
                axis.set_major_formatter(new)
                axis.set_minor_formatter(NullFormatter())


def _broken(line: str, figure: Figure) -> list[str]:
    """Return the parts of a line of a title that fit into the width of a figure."""
    most = WIDEST * 72.0 * figure.get_figwidth()  # [points]
    size = FontProperties(size=rcParams["figure.titlesize"]).get_size_in_points()
    parts = [""]
    for phrase in re.split(r"(?<=,) ", line):  # a phrase is broken only if it is wider
        fits = _width(f"{parts[-1]} {phrase}", size) <= most
        if not fits and parts[-1] and _width(phrase, size) <= most:
            parts.append("")
        for word in phrase.split(" "):
            longer = f"{parts[-1]} {word}".lstrip()
            if parts[-1] and _width(longer, size) > most:
                parts.append(longer := word)
            while _width(longer, size) > most:  # a word that is wider than the figure
                longer = f"{longer[: int(0.9 * len(longer)) - 1]}…"
            parts[-1] = longer
    return parts


def _width(line: str, size: float) -> float:
    """Return the width of a line of text [points].

    The widest points of letters are ends of their curves, so that the corners of the outline give
    the same width as its curves, in a fraction of the time.
    """
    outline = TextPath((0, 0), line.replace("$", "S"), size=size, usetex=False)
    corners = np.asarray(outline.vertices)[outline.codes != TextPath.CLOSEPOLY]
    return float(np.ptp(corners[:, 0])) if len(corners) else 0.0


def key_words(name: str) -> str:
    """Return the name of a key as words: "march speed" for march.speed."""
    return name.replace(".", " ").replace("_", " ")
