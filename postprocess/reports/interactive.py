"""Plots to point at that maps of runs and sweeps share: layout, buttons, bars of colours."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from bladewhirl.postprocess.plotting.style import SEQUENTIAL

FONT = 'system-ui, -apple-system, "Segoe UI", Roboto, "DejaVu Sans", sans-serif'
INK, LINE = "#1c2330", "#dfe3e8"


@dataclass(frozen=True, kw_only=True)
class Plot:
    """A plot that the program inside a page draws: Plotly's traces and layout, arrays as such."""

    traces: Sequence[Mapping[str, Any]]
    layout: Mapping[str, Any]


COLOUR_SCALE = SEQUENTIAL.capitalize()
"""The common colour map by its name in Plotly."""

LEGEND_BELOW = {"orientation": "h", "y": -0.16, "yanchor": "top"}


def plain_layout(**more: Any) -> dict[str, Any]:
    """Layout of all plots of a report: fonts, colours, margins."""
    axis = {"gridcolor": LINE, "zerolinecolor": LINE, "linecolor": INK, "ticks": "outside"}
    shared: dict[str, Any] = {
        "font": {"family": FONT, "size": 13, "color": INK},
        "paper_bgcolor": "#ffffff",
        "plot_bgcolor": "#ffffff",
        "margin": {"l": 64, "r": 16, "t": 48, "b": 52},
        "hoverlabel": {"font": {"family": FONT, "size": 13}},
    }
    more["xaxis"], more["yaxis"] = axis | more["xaxis"], axis | more["yaxis"]
    return shared | more | {"template": None}


def buttons(labels: Sequence[str], owner: Sequence[int | None]) -> list[dict[str, Any]]:
    """A row of buttons above a plot, each of which shows its traces; none for a single label.

    Args:
        labels: of the buttons.
        owner: number of the button that shows each trace; None for one that is always shown.
    """
    if len(labels) == 1:
        return []
    shown = [[own in (None, number) for own in owner] for number in range(len(labels))]
    return [
        {
            "type": "buttons",
            "direction": "right",
            "x": 0.0,
            "xanchor": "left",
            "y": 1.02,
            "yanchor": "bottom",
            "pad": {"t": 0, "b": 4},
            "bgcolor": "#f5f7f9",
            "bordercolor": LINE,
            "font": {"size": 12},
            "buttons": [
                {"label": label, "method": "restyle", "args": [{"visible": which}]}
                for label, which in zip(labels, shown, strict=True)
            ],
        }
    ]


def colour_bar(title: str) -> dict[str, Any]:
    """A bar of colours with its title along it."""
    return {"title": {"text": title, "side": "right"}, "thickness": 14}
