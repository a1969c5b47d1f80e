"""Titles of figures: the case's name, the speed, and what is shown."""

from __future__ import annotations

import textwrap

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties, findfont, get_font

LONGEST_NAME = 80
"""Letters of a case's name in a title, at most."""

LETTERS_PER_INCH = 16.5
"""Letters of a line of a title in an inch of the figure's width, about; longer ones wrap."""

NAME_LETTERS_PER_INCH = 11.5
"""The same for the name of a case, which may consist of wide capitals."""


def speed_label(dataset: xr.Dataset) -> str:
    """Return the speed in multiples of the reference frequency ω₁ and in rpm."""
    speed = float(dataset.attrs["speed"])
    normalised = speed / float(dataset.attrs["reference_frequency"])
    return f"Ω/ω₁ = {normalised:.4g} ({speed * 30 / np.pi:.0f} rpm)"


def head(figure: Figure, data: xr.Dataset, *lines: str) -> None:
    """Set the title: the case's name, the speed with the first line, and the other lines.

    Args:
        figure: drawn in the common style.
        data: dataset with the attributes of `fields.labelled`.
        lines: further text; the first is put beside the speed if both fit.
    """
    speed = speed_label(data)
    fits = lines and len(f"{speed}, {lines[0]}") <= LETTERS_PER_INCH * figure.get_figwidth()
    shown = [f"{speed}, {lines[0]}", *lines[1:]] if fits else [speed, *lines]
    set_title(figure, str(data.attrs.get("case_title", "")), "\n".join(shown))


def set_title(figure: Figure, case: str, shown: str) -> None:
    """Set the title: the case's name and what is shown, wrapped to the width of the figure."""
    in_font = get_font(findfont(FontProperties())).get_char_index
    name = textwrap.shorten(case, LONGEST_NAME, placeholder=" …")
    name = "".join(c if in_font(ord(c)) else "\N{REPLACEMENT CHARACTER}" for c in name)
    inches = figure.get_figwidth()
    lines = [textwrap.fill(name, int(NAME_LETTERS_PER_INCH * inches))] if name else []
    width = int(LETTERS_PER_INCH * inches)
    lines += [textwrap.fill(line, width) for line in shown.splitlines() if line]
    figure.suptitle("\n".join(lines), parse_math=False)
