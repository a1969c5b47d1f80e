"""Legends below a figure, and the title above it."""

import textwrap
from collections.abc import Sequence
from typing import NamedTuple, cast

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.legend_handler import HandlerTuple

from bladewhirl.postprocess.plotting.titles import set_title

#: height that a figure reserves for its legends [inch]; the figure grows if legends are higher
HEIGHT = 0.45
MOST_COLUMNS = 6
TITLE_LETTERS = 14  #: largest number of characters of a legend's title per inch


class Group(NamedTuple):
    """Entries of a legend."""

    entries: Sequence[tuple[Artist | tuple[Artist, ...], str]]  #: artists and their labels
    title: str = ""


def entries_of(*panels: Axes) -> list[tuple[Artist, str]]:
    """Return the labelled artists of panels; of artists with the same label only the first."""
    pairs = [zip(*axes.get_legend_handles_labels(), strict=True) for axes in panels]
    named: dict[str, Artist] = {}
    for handle, label in (entry for panel in pairs for entry in panel):
        named.setdefault(label, handle)
    return [(handle, label) for label, handle in named.items()]


def complete(figure: Figure, data: xr.Dataset, shown: str, note: str = "") -> None:
    """Set the title of a figure, see `set_title`, and add a legend of all labelled artists, with a
    `note` as its title. The case is an attribute of the drawn `data`."""
    set_title(figure, str(data.attrs.get("case", "")), shown)
    legends_below(figure, Group(entries_of(*figure.axes), note))


def legends_below(figure: Figure, *groups: Group) -> None:
    """Add a legend for each group that has entries, below a complete figure in constrained layout;
    the first group is uppermost.

    Each legend has as many columns as fit. The figure grows if the legends need more than `HEIGHT`.
    """
    legends = []
    for group in (group for group in groups if group.entries):
        handles, labels = zip(*group.entries, strict=True)
        for columns in range(min(len(handles), MOST_COLUMNS), 0, -1):
            legend = figure.legend(
                handles,
                labels,
                title=textwrap.fill(group.title, int(TITLE_LETTERS * figure.get_figwidth()))
                or None,
                loc="lower center",
                ncols=columns,
                handlelength=3.0,
                borderaxespad=0.0,
                handler_map={tuple: HandlerTuple(ndivide=None)},
            )
            if columns == 1 or legend.get_window_extent().width < 0.98 * figure.bbox.width:
                break
            legend.remove()
        legend.set_in_layout(False)  # the space of legends is reserved below
        legends.append(legend)
    if legends:
        heights = [legend.get_window_extent().height / figure.dpi for legend in legends]  # [inch]
        figure.set_figheight(figure.get_figheight() + max(0.0, sum(heights) - HEIGHT))
        shares = np.array(heights) / figure.get_figheight()
        for legend, bottom in zip(legends, shares.sum() - shares.cumsum(), strict=True):
            legend.set_bbox_to_anchor((0.5, bottom), transform=figure.transFigure)
        rectangle = (0.0, shares.sum(), 1.0, 1.0 - shares.sum())
        cast(ConstrainedLayoutEngine, figure.get_layout_engine()).set(rect=rectangle)
