"""Template, buttons and colour bars of the interactive plots."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import plotly.graph_objects as go
from matplotlib.colors import to_hex

from bladewhirl.postprocess.plotting.style import COLOUR_MAPS

FONT = 'system-ui, -apple-system, "Segoe UI", Roboto, "DejaVu Sans", sans-serif'
INK, LINE = "#1c2330", "#dfe3e8"

COLOUR_SCALE = [
    [share, to_hex(COLOUR_MAPS["magnitude"](share))] for share in np.linspace(0.0, 1.0, 16)
]
"""Common colour map of magnitudes, as Plotly takes it."""
FONT_LOOK = {"family": FONT, "size": 13, "color": INK}


def plot(traces: Sequence[Any], **layout: Any) -> go.Figure:
    """Return a plot of traces in the common style."""
    return go.Figure(data=list(traces), layout=layout).update_layout(
        template="plotly_white",
        font=FONT_LOOK,
        hoverlabel_font=FONT_LOOK,
        margin={"l": 64, "r": 16, "t": 48, "b": 52},
        legend={"orientation": "h", "y": -0.16, "yanchor": "top"},
    )


def buttons(labels: Sequence[str], owner: Sequence[int | None]) -> list[dict[str, Any]]:
    """Return a row of buttons above a plot, each of which shows some traces and hides the remaining
    traces; no buttons for a single label. `owner` contains for each trace the number of the button
    that shows it, or None for a trace that is always shown."""
    if len(labels) == 1:
        return []
    shown = [[number in (None, button) for number in owner] for button in range(len(labels))]
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
                {"label": label, "method": "restyle", "args": [{"visible": visible}]}
                for label, visible in zip(labels, shown, strict=True)
            ],
        }
    ]


def colour_bar(title: str) -> dict[str, Any]:
    """Return a colour bar with its title at its side."""
    return {"title": {"text": title, "side": "right"}, "thickness": 14}
