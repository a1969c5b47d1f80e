"""Legends below a figure that stay on it, however many entries they have and how long these are."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import NamedTuple

from matplotlib.artist import Artist
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.legend import Legend
from matplotlib.legend_handler import HandlerTuple

ROOM = 0.45
"""Height that a figure has for its legends [inch]: it grows by what they need beyond."""

WIDEST = 0.98
"""Share of a figure's width that a legend takes at most."""

MOST_COLUMNS = 6
"""Columns of a legend at most: more are hard to follow."""

TITLE_LETTERS = 98
"""Letters that a line of a title has at the full width of a page."""


class Group(NamedTuple):
    """Entries of a legend that belong together."""

    entries: Sequence[tuple[Artist | tuple[Artist, ...], str]]  #: what is drawn, and its name
    title: str = ""


def legends_below(figure: Figure, *groups: Group) -> None:
    """Put a legend for each group that has entries below a figure, one under the other.

    Each has as many columns as fit; the figure grows by what they need beyond `ROOM`.

    Args:
        figure: in constrained layout, all else being drawn.
        groups: from the top.
    """
    legends = [_fitting(figure, group) for group in groups if group.entries]
    heights = [legend.get_window_extent().height / figure.dpi for legend in legends]
    total = sum(heights)
    figure.set_figheight(figure.get_figheight() + max(0.0, total - ROOM))
    high = figure.get_figheight()
    top = total
    for legend, height in zip(legends, heights, strict=True):
        legend.set_bbox_to_anchor((0.5, (top - height) / high), transform=figure.transFigure)
        top -= height
    engine = figure.get_layout_engine()
    if isinstance(engine, ConstrainedLayoutEngine) and legends:
        engine.set(rect=(0.0, total / high, 1.0, 1.0 - total / high))


def _fitting(figure: Figure, group: Group) -> Legend:
    """A legend with as many columns as fit."""
    handles, labels = zip(*group.entries, strict=True)
    columns = min(len(handles), MOST_COLUMNS)
    while True:
        legend = figure.legend(
            handles,
            labels,
            title=textwrap.fill(group.title, TITLE_LETTERS) or None,
            loc="lower center",
            ncols=columns,
            handlelength=3.0,
            borderaxespad=0.0,
            handler_map={tuple: HandlerTuple(ndivide=None)},
        )
        legend.set_in_layout(False)  # its room is kept by the rectangle of the layout
        if columns == 1 or legend.get_window_extent().width <= WIDEST * figure.bbox.width:
            return legend
        legend.remove()
        columns -= 1
