"""Contact over blade and time to point at, beside the shaft's orbit at the same instant."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from bladewhirl.postprocess.fields.fields import Array
from bladewhirl.postprocess.fields.windows import span_starts
from bladewhirl.postprocess.plotting.style import COLOURS, SEQUENTIAL
from bladewhirl.postprocess.reports.page import Explorer
from bladewhirl.postprocess.run.blade_contact import force_limit
from bladewhirl.postprocess.run.orbits import FRAMES, MILLI

if TYPE_CHECKING:
    import plotly.graph_objects as go

ORBIT_POINTS = 5000
"""Points of an orbit at most: more make a page slow."""

FONT = 'system-ui, -apple-system, "Segoe UI", Roboto, "DejaVu Sans", sans-serif'
INK, LINE = "#1c2330", "#dfe3e8"

POINTED = (
    "blade %{y}, %{x:.6g} s<br>mean normal force %{customdata[0]:.4g} N<br>"
    "mean friction %{customdata[1]:.4g} N<br>smallest gap %{customdata[2]:.4g} mm<extra></extra>"
)

CAPTION = (
    "Blades over time: the mean normal force [N] between blade and casing, or, by the button, the "
    "smallest gap [mm] or the friction [N], in equal spans of time; white is no contact. Point at "
    "it for the numbers, drag to zoom in, double-click to see all. The orbit beside it shows where "
    "the shaft was at that instant; its points are coloured by time, and the dashed circle is the "
    "clearance. Look for blades that stay in contact, those that come and go, and contact that "
    "wanders from blade to blade."
)


def contact_explorer(maps: xr.Dataset, orbit: xr.Dataset) -> Explorer:
    """Map and orbit of a run, to point at.

    Args:
        maps: from `blade_contact.contact_maps`.
        orbit: from `orbits.shaft_orbit`, of the same time.
    """
    record = np.searchsorted(orbit["time"].values, maps["time"].values)
    record = np.minimum(record, orbit.sizes["time"] - 1)
    return Explorer(
        name="explorer",
        title="Contact over blade and time, and the shaft at that instant",
        caption=CAPTION,
        plots=[_map(maps), _orbit(orbit)],
        marked=[_rounded(MILLI * orbit[frame].values[record]) for frame in FRAMES],
    )


def plain_layout(**more: Any) -> dict[str, Any]:
    """What all plots of a report share: fonts, colours, margins."""
    axis = {"gridcolor": LINE, "zerolinecolor": LINE, "linecolor": INK, "ticks": "outside"}
    shared: dict[str, Any] = {
        "font": {"family": FONT, "size": 13, "color": INK},
        "paper_bgcolor": "#ffffff",
        "plot_bgcolor": "#ffffff",
        "margin": {"l": 64, "r": 16, "t": 48, "b": 52},
        "hoverlabel": {"font": {"family": FONT, "size": 13}},
    }
    for key, value in more.items():
        shared[key] = {**axis, **value} if key in ("xaxis", "yaxis") else value
    return shared


def buttons(labels: list[str], shown: list[list[bool]], **more: Any) -> dict[str, Any]:
    """A row of buttons above a plot, each of which shows some of its traces."""
    return {
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
        **more,
    }


def _map(maps: xr.Dataset) -> go.Figure:
    import plotly.graph_objects as go

    force, friction = maps["force"].values.T, maps["friction"].values.T
    gap, touched = MILLI * np.maximum(maps["gap"].values.T, 0.0), maps["touched"].values.T
    pointed = _rounded(np.stack([force, friction, gap], axis=-1))
    common = {
        "x": maps["time"].values,
        "y": maps["blade"].values,
        "customdata": pointed,
        "hovertemplate": POINTED,
        "colorscale": SEQUENTIAL,
    }

    def scale(title: str) -> dict[str, Any]:
        return {"title": {"text": title, "side": "right"}, "thickness": 14}

    top = force_limit(force)
    drag = float(np.abs(friction).max()) or 1.0
    nothing = np.full(force.shape, np.nan)
    traces = [
        go.Heatmap(
            z=np.where(touched, force, nothing),
            zmin=0.0,
            zmax=top,
            colorbar=scale("mean normal force [N]"),
            **common,
        ),
        go.Heatmap(z=gap, zmin=0.0, visible=False, colorbar=scale("smallest gap [mm]"), **common),
        go.Heatmap(
            z=np.where(touched, friction, nothing),
            zmin=-drag,
            zmax=drag,
            visible=False,
            colorbar=scale("mean friction [N]"),
            **{**common, "colorscale": "RdBu"},
        ),
    ]
    shown = [[number == own for number in range(3)] for own in range(3)]
    return go.Figure(
        traces,
        plain_layout(
            xaxis={"title": {"text": "time [s]"}, "showgrid": False},
            yaxis={"title": {"text": "blade"}, "showgrid": False, "zeroline": False},
            updatemenus=[buttons(["normal force", "gap", "friction"], shown)],
            template=None,
        ),
    )


def _orbit(orbit: xr.Dataset) -> go.Figure:
    import plotly.graph_objects as go

    thinned = orbit.isel(time=span_starts(orbit["time"].values, ORBIT_POINTS))
    time = thinned["time"].values
    clearance = MILLI * float(orbit.attrs["smallest_clearance"])
    turn = np.linspace(0.0, 2 * np.pi, 181)
    circle = go.Scatter(
        x=clearance * np.cos(turn),
        y=clearance * np.sin(turn),
        mode="lines",
        line={"color": COLOURS["casing"], "dash": "dash", "width": 1.5},
        hoverinfo="skip",
    )
    paths, markers = [], []
    for frame in FRAMES:
        place = MILLI * thinned[frame].values
        paths.append(
            go.Scatter(
                x=place[:, 0].astype(np.float32),
                y=place[:, 1].astype(np.float32),
                customdata=_rounded(np.column_stack([time, MILLI * thinned["radius"].values])),
                mode="markers+lines",
                line={"color": "#c9ced6", "width": 0.6},
                marker={"size": 3, "color": time.astype(np.float32), "colorscale": SEQUENTIAL},
                hovertemplate=(
                    "%{customdata[0]:.6g} s<br>x %{x:.4g} mm, y %{y:.4g} mm<br>"
                    f"radius %{{customdata[1]:.4g}} mm<extra>{frame} frame</extra>"
                ),
                visible=frame == FRAMES[0],
            )
        )
        markers.append(
            go.Scatter(
                x=place[-1:, 0],
                y=place[-1:, 1],
                mode="markers",
                marker={"size": 12, "color": COLOURS["k = 1"], "line": {"color": INK, "width": 1}},
                hoverinfo="skip",
                visible=frame == FRAMES[0],
            )
        )
    edge = 1.1 * max(MILLI * float(orbit["radius"].max()), clearance) or 1.0
    shown = [[True, *[frame == own for own in FRAMES] * 2] for frame in FRAMES]
    return go.Figure(
        [circle, *paths, *markers],
        plain_layout(
            xaxis={"title": {"text": "x [mm]"}, "range": [-edge, edge], "constrain": "domain"},
            yaxis={
                "title": {"text": "y [mm]"},
                "range": [-edge, edge],
                "scaleanchor": "x",
                "constrain": "domain",
            },
            showlegend=False,
            updatemenus=[buttons([f"{frame} frame" for frame in FRAMES], shown)],
            template=None,
        ),
    )


def _rounded(values: Array) -> Any:
    """Five digits, as lists: enough to read, and half the size of a page."""
    size = np.abs(values)
    digits = 10.0 ** (4 - np.floor(np.log10(size, out=np.zeros(size.shape), where=size > 0)))
    return (np.round(values * digits) / digits).tolist()
