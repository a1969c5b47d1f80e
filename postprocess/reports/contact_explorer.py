"""Contact over blade and time to point at, beside the shaft's orbit at the same instant."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from bladewhirl.postprocess.fields.windows import span_starts
from bladewhirl.postprocess.plotting.style import COLOURS, SEQUENTIAL
from bladewhirl.postprocess.reports.interactive import (
    INK,
    buttons,
    colour_bar,
    plain_layout,
    rounded,
)
from bladewhirl.postprocess.reports.page import Explorer
from bladewhirl.postprocess.run.blade_contact import force_limit
from bladewhirl.postprocess.shaft.orbits import MILLI
from bladewhirl.postprocess.shaft.whirl import FRAMES

if TYPE_CHECKING:
    import plotly.graph_objects as go

ORBIT_POINTS = 5000
"""Points of an orbit at most: more make a page slow."""

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
        marked=[rounded(MILLI * orbit[frame].values[record]) for frame in FRAMES],
    )


def _map(maps: xr.Dataset) -> go.Figure:
    import plotly.graph_objects as go

    force, friction = maps["force"].values.T, maps["friction"].values.T
    gap, touched = MILLI * np.maximum(maps["gap"].values.T, 0.0), maps["touched"].values.T
    drag = float(np.abs(friction).max()) or 1.0
    shown = {
        "normal force": (np.where(touched, force, np.nan), "mean normal force [N]"),
        "gap": (gap, "smallest gap [mm]"),
        "friction": (np.where(touched, friction, np.nan), "mean friction [N]"),
    }
    colours: dict[str, dict[str, Any]] = {
        "normal force": {"zmin": 0.0, "zmax": force_limit(force)},
        "gap": {"zmin": 0.0},
        "friction": {"zmin": -drag, "zmax": drag, "colorscale": "RdBu"},
    }
    traces = [
        go.Heatmap(
            {
                "x": maps["time"].values,
                "y": maps["blade"].values,
                "z": values,
                "customdata": rounded(np.stack([force, friction, gap], axis=-1)),
                "hovertemplate": POINTED,
                "colorscale": SEQUENTIAL,
                "colorbar": colour_bar(title),
                "visible": name == "normal force",
                **colours[name],
            }
        )
        for name, (values, title) in shown.items()
    ]
    layout = plain_layout(
        xaxis={"title": {"text": "time [s]"}, "showgrid": False},
        yaxis={"title": {"text": "blade"}, "showgrid": False, "zeroline": False},
        updatemenus=buttons(list(shown), range(len(shown))),
    )
    return go.Figure(traces, layout)


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
        path = go.Scatter(
            x=place[:, 0].astype(np.float32),
            y=place[:, 1].astype(np.float32),
            customdata=rounded(np.column_stack([time, MILLI * thinned["radius"].values])),
            mode="markers+lines",
            line={"color": "#c9ced6", "width": 0.6},
            marker={"size": 3, "color": time.astype(np.float32), "colorscale": SEQUENTIAL},
            hovertemplate=(
                "%{customdata[0]:.6g} s<br>x %{x:.4g} mm, y %{y:.4g} mm<br>"
                f"radius %{{customdata[1]:.4g}} mm<extra>{frame} frame</extra>"
            ),
            visible=frame == FRAMES[0],
        )
        marker = go.Scatter(
            x=place[-1:, 0],
            y=place[-1:, 1],
            mode="markers",
            marker={"size": 12, "color": COLOURS["k = 1"], "line": {"color": INK, "width": 1}},
            hoverinfo="skip",
            visible=frame == FRAMES[0],
        )
        paths.append(path)
        markers.append(marker)
    edge = 1.1 * max(MILLI * float(orbit["radius"].max()), clearance) or 1.0
    axis = {"range": [-edge, edge], "constrain": "domain"}
    layout = plain_layout(
        xaxis={"title": {"text": "x [mm]"}, **axis},
        yaxis={"title": {"text": "y [mm]"}, "scaleanchor": "x", **axis},
        showlegend=False,
        updatemenus=buttons([f"{frame} frame" for frame in FRAMES], [None, 0, 1, 0, 1]),
    )
    return go.Figure([circle, *paths, *markers], layout)
