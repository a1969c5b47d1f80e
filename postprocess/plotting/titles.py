"""Titles of figures: name of the case, content of the figure, and speed."""

import re

import numpy as np
import xarray as xr
from matplotlib import rcParams
from matplotlib.axes._secondary_axes import SecondaryAxis
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties, findfont, get_font
from matplotlib.textpath import TextPath
from matplotlib.ticker import LogFormatter, LogLocator, NullFormatter

from bladewhirl.postprocess.fields.labelled import LOSS, SPEED_RANGE
from bladewhirl.postprocess.plotting.style import styled

MOST_LETTERS = 40  #: largest number of characters of a title per inch of the figure's width
WIDEST = 0.97
"""Largest width of a line of a title, divided by the figure's width."""

SMALLEST = 1e-300  #: keeps logarithms finite
BETWEEN = (2.0, 5.0)  #: ticks between powers of ten on an axis with fewer than two of these

LINE = 0.13  #: height of a line of a title [inch]


def speed_label(dataset: xr.Dataset) -> str:
    """Return the speed, or its range, in multiples of the reference frequency ω₁ and in rpm."""
    names = SPEED_RANGE if SPEED_RANGE[0] in dataset.attrs else ("speed",)
    speeds = [float(dataset.attrs[name]) for name in names]
    reference = float(dataset.attrs["reference_frequency"])
    normalised = " to ".join(f"{speed / reference:.4g}" for speed in speeds)
    rpm = " to ".join(f"{speed * 30 / np.pi:.0f}" for speed in speeds)
    return f"Ω/ω₁ = {normalised} ({rpm} rpm)"


def about_run(data: xr.Dataset) -> list[str]:
    """Return the speed, see `speed_label`, and the loss of a blade if there is one."""
    return [speed_label(data), *([str(data.attrs[LOSS])] if LOSS in data.attrs else [])]


def head(figure: Figure, data: xr.Dataset, *words: str) -> None:
    """Set the title of a figure: the name of the case, and a line with the speed.

    Args:
        figure: figure drawn in the common style.
        data: dataset with the attributes of `fields.labelled`.
        words: texts that follow the speed.
    """
    set_title(figure, str(data.attrs.get("case_title", "")), ", ".join([*about_run(data), *words]))


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


LOGARITHMIC = ("log", "functionlog")  #: scales of axes, and of secondary axes
LONGEST = 1e9  #: from this number on, ticks of logarithmic axes have an exponent


class PlainLog(LogFormatter):
    """Numbers of logarithmic axes as 0.01, 100,000 and 1e-05, because raised exponents are too
    small."""

    def __call__(self, x: float, pos: int | None = None) -> str:
        """Return the text of a tick; an empty one for ticks without a number."""
        if not super().__call__(x, pos):
            return ""
        return f"{x:,.0f}" if 1e4 <= abs(x) < LONGEST else f"{x:.5g}"


def plain_exponents(figure: Figure) -> None:
    """Give logarithmic axes the numbers of `PlainLog`; also between powers of ten if the axis has
    fewer than two of these."""
    for axes in [each for panel in figure.axes for each in (panel, *panel.child_axes)]:
        if isinstance(axes, SecondaryAxis):
            axes._set_lims()  # type: ignore[attr-defined]  # otherwise only when drawn
        for axis in (axes.xaxis, axes.yaxis):
            old = axis.get_major_formatter()
            if isinstance(old, LogFormatter):
                thresholds = old._linthresh  # type: ignore[attr-defined]
                axis.set_major_formatter(PlainLog(linthresh=thresholds))
                low, high = np.log10(np.maximum(axis.get_view_interval(), SMALLEST))
                few = np.floor(high) - np.ceil(low) < 1.0 and axis.get_scale() in LOGARITHMIC
                if few:
                    axis.set_minor_locator(LogLocator(subs=BETWEEN))
                between = PlainLog(labelOnlyBase=False, minor_thresholds=(np.inf, np.inf))
                axis.set_minor_formatter(between if few else NullFormatter())


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
    """Return the name of a key as words: "casing clearance" for casing.clearance, and "speed" for
    march.speed, as on all axes."""
    return name.removeprefix("march.").replace(".", " ").replace("_", " ")
