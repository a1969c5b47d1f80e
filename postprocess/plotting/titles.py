"""Titles of figures: the case's name, the speed in one convention, and what is shown of them."""

from __future__ import annotations

import textwrap

import numpy as np
import xarray as xr
from matplotlib import rcParams
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties, findfont, get_font
from matplotlib.textpath import text_to_path

NAME_LINES = 2
"""Lines that the name of a case takes at most: what it has more is left out."""

WIDEST = 0.95
"""Share of a figure's width that a line of its title takes at most."""

POINTS = 72.0  #: in an inch


def speed_label(dataset: xr.Dataset) -> str:
    """The speed in words: in multiples of the reference frequency ω₁, and in rpm."""
    speed = float(dataset.attrs["speed"])
    normalised = speed / float(dataset.attrs["reference_frequency"])
    return f"Ω/ω₁ = {normalised:.4g} ({speed * 30 / np.pi:.0f} rpm)"


def head(figure: Figure, data: xr.Dataset, *words: str) -> None:
    """Title a figure by the case's name, the speed, and words in lines of their own.

    Args:
        figure: drawn in the common style.
        data: with the attributes of `fields.labelled`.
        words: as many lines as are wanted; the first goes beside the speed where both fit.
    """
    first = ", ".join([speed_label(data), *words[:1]])
    beside = [first] if len(_wrapped(figure, first)) == 1 else [speed_label(data), *words[:1]]
    set_title(figure, str(data.attrs.get("case_title", "")), "\n".join([*beside, *words[1:]]))


def set_title(figure: Figure, case: str, shown: str) -> None:
    """Title a figure by the case's name and what is shown, in as many lines as that takes."""
    name = _wrapped(figure, case, most_lines=NAME_LINES)
    rest = [line for text in shown.splitlines() for line in _wrapped(figure, text)]
    figure.suptitle("\n".join([*name, *rest]), parse_math=False)


def _wrapped(figure: Figure, text: str, *, most_lines: int | None = None) -> list[str]:
    """Lines of a text that fit the width of a figure, of letters that the font has."""
    font = FontProperties(size=rcParams["figure.titlesize"])
    letters = get_font(findfont(font))
    shown = "".join(
        each if letters.get_char_index(ord(each)) else "\N{REPLACEMENT CHARACTER}"
        for each in " ".join(text.split())
    )
    width, _, _ = text_to_path.get_text_width_height_descent(shown, font, ismath=False)
    room = WIDEST * figure.get_figwidth() * POINTS
    fitting = max(1, int(room * len(shown) / width)) if width > room else max(1, len(shown))
    return textwrap.wrap(shown, fitting, max_lines=most_lines, placeholder=" …")
