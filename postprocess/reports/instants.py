"""A run at one instant: the machine, the shaft's orbit, contact and energy under one cursor."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from bladewhirl.postprocess.energy.strain import PLOT_DECADES
from bladewhirl.postprocess.fields.kinematics import Array
from bladewhirl.postprocess.fields.windows import span_means, span_starts
from bladewhirl.postprocess.pictures.appearance import (
    ARROW_WIDTH,
    FORCE_COLOUR,
    HUB,
    LONGEST_ARROW,
    MARGIN,
    contact_words,
    enlargement,
)
from bladewhirl.postprocess.pictures.drawing import Drawing, Picture, arrows
from bladewhirl.postprocess.plotting.style import COLOURS
from bladewhirl.postprocess.reports.interactive import (
    COLOUR_SCALE,
    INK,
    LEGEND_BELOW,
    Plot,
    buttons,
    colour_bar,
    plain_layout,
)
from bladewhirl.postprocess.reports.page import Instants
from bladewhirl.postprocess.run.blade_contact import force_limit
from bladewhirl.postprocess.shaft.orbits import MILLI
from bladewhirl.postprocess.shaft.whirl import Frame

MOST_INSTANTS = 60
"""Instants of the machine at most, which the cursor goes through."""

MOST_PLACES = 1_000_000
"""Drawn places of all instants at most [numbers]: a stage of many beams has fewer instants."""

FEWEST_INSTANTS = 10

PIECE = 3
"""Of a beam's drawn stations each so many-th is kept; of the wall's twice as many."""

ORBIT_POINTS = 5000
"""Points of an orbit at most: more make a page slow."""

ENERGY_POINTS = 1000
"""Points of a line of energy at most: means over equal spans of time."""

FULL = 32767  #: of a signed number of 16 bits

LOOK: tuple[Frame, Frame] = ("static", "rotating")
"""Frames of the orbit; the first is shown, and that of the machine."""

POINTED = (
    "blade %{y}, %{x:.6g} s<br>mean normal force %{customdata[0]:.4g} N<br>"
    "mean friction %{customdata[1]:.4g} N<br>smallest gap %{customdata[2]:.4g} mm<extra></extra>"
)

BOTH_SIGNS = [[0.0, COLOURS["k = 0"]], [0.5, "#ffffff"], [1.0, COLOURS["k = 1"]]]

CAPTION = (
    "Move the cursor, or point at the histories: all of them show that instant. It begins {where}. "
    "The machine is seen by an observer at rest, {size}; the disc on it turns with blade 0, arrows "
    "are contact forces. The orbit is coloured by time, the dashed circle is the clearance. Blades "
    "over time: mean normal force [N] on each blade, or by the button smallest gap [mm] or "
    "friction [N], in equal spans of time; white is no contact. Below, the strain energy [J]. Drag "
    "to zoom in, double-click to see all. Look for blades that stay in contact, contact that "
    "wanders from blade to blade, and energy that goes on growing."
)


def instants(
    dataset: xr.Dataset, maps: xr.Dataset, orbit: xr.Dataset, energy: xr.Dataset
) -> Instants:
    """The run at up to `MOST_INSTANTS` instants, evenly spread, and at one that tells most.

    Args:
        dataset: a result.
        maps: from `blade_contact.contact_maps`.
        orbit: from `orbits.shaft_orbit`, of the same time.
        energy: from `strain.strain_energies`, of the same time.
    """
    marked, where = _telling(dataset, orbit)
    beams = dataset.sizes["rotor_line"]
    count = int(np.clip(MOST_PLACES / (24 * beams), FEWEST_INSTANTS, MOST_INSTANTS))
    even = np.linspace(0, dataset.sizes["time"] - 1, count).round().astype(np.int64)
    records = np.unique(np.append(even, marked))
    drawing = Drawing(dataset, records)
    pictures = [drawing.picture(index) for index in range(len(records))]
    return Instants(
        name="instants",
        title="The run at one instant",
        caption=CAPTION.format(
            where=where, size=enlargement(drawing.exaggeration).replace("\n", " ")
        ),
        plots=[_orbit(orbit), _histories(maps, energy)],
        times=drawing.times,
        first=int(np.searchsorted(records, marked)),
        words=[contact_words(each.forces).replace("\n", ", ") for each in pictures],
        places=[MILLI * orbit[frame].values[records] for frame in LOOK],
        machine=_machine(drawing, pictures),
    )


def _telling(dataset: xr.Dataset, orbit: xr.Dataset) -> tuple[int, str]:
    """Record of the largest contact force, else of the largest displacement; and which in words."""
    impulse = dataset["contact_impulse"].values.max(axis=1)
    if impulse.any():
        return int(impulse.argmax()), "where a contact force is largest"
    return int(orbit["radius"].values.argmax()), "where the shaft is farthest out"


def _machine(drawing: Drawing, pictures: list[Picture]) -> list[dict[str, Any]]:
    """Filled outlines of the machine, lowest first: colour and places (instant, outline, point, 2)
    in shares of half the picture.
    """
    reach = MARGIN * max(float(np.abs(each.casing.sides).max()) for each in pictures)
    longest = LONGEST_ARROW * reach / drawing.largest_force if drawing.largest_force else 0.0
    turn = np.linspace(0.0, 2 * np.pi, 13)
    disc = HUB * reach * np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    shapes = [
        {
            COLOURS["casing"]: _outlines(each.casing.sides[:, :: 2 * PIECE]),
            INK: _outlines(each.rotor.sides[:, ::PIECE]),
            "#ffffff": np.stack([each.shaft + 0.6 * disc, each.mark + 0.6 * disc]),
            FORCE_COLOUR: arrows(each.tips, each.forces, longest, ARROW_WIDTH * reach),
        }
        for each in pictures
    ]
    return [
        {
            "colour": colour,
            "places": np.clip(
                np.round(FULL / reach * np.array([each[colour] for each in shapes])), -FULL, FULL
            ).astype(np.int16),
        }
        for colour in shapes[0]
    ]


def _outlines(sides: Array) -> Array:
    """Outlines of ribbons, (line, point, 2): along one side and back along the other."""
    return np.concatenate([sides[:, :, 0], sides[:, ::-1, 1]], axis=1)


def _histories(maps: xr.Dataset, energy: xr.Dataset) -> Plot:
    """Contact over blade and time, and below it energy, with a line for the cursor."""
    force, friction = maps["force"].values.T, maps["friction"].values.T
    gap, touched = MILLI * np.maximum(maps["gap"].values.T, 0.0), maps["share"].values.T > 0
    drag = float(np.abs(friction).max()) or 1.0
    shown = {
        "normal force": (np.where(touched, force, np.nan), "mean normal force [N]"),
        "gap": (gap, "smallest gap [mm]"),
        "friction": (np.where(touched, friction, np.nan), "mean friction [N]"),
    }
    colours: dict[str, dict[str, Any]] = {
        "normal force": {"zmin": 0.0, "zmax": force_limit(force)},
        "gap": {"zmin": 0.0},
        "friction": {"zmin": -drag, "zmax": drag, "colorscale": BOTH_SIGNS},
    }
    numbers = np.stack([force, friction, gap], axis=-1)
    heat = [
        {
            "type": "heatmap",
            "x": maps["time"].values,
            "y": maps["blade"].values,
            "z": values,
            "customdata": numbers,
            "hovertemplate": POINTED,
            "colorscale": COLOUR_SCALE,
            "colorbar": {**colour_bar(title), "y": 0.7, "len": 0.62},
            "visible": name == "normal force",
            **colours[name],
        }
        for name, (values, title) in shown.items()
    ]
    lines = _energies(energy)
    top = float(energy["total"].max()) or 1.0
    axis = plain_layout(xaxis={}, yaxis={})["yaxis"]
    return Plot(
        traces=[*heat, *lines],
        layout=plain_layout(
            xaxis={"title": {"text": "time [s]"}, "showgrid": False, "anchor": "y2"},
            yaxis={
                "title": {"text": "blade"},
                "showgrid": False,
                "zeroline": False,
                "domain": [0.42, 1.0],
            },
            yaxis2={
                **axis,
                "title": {"text": "strain energy [J]"},
                "type": "log",
                "range": np.log10([top * 10**-PLOT_DECADES, 3 * top]).tolist(),
                "domain": [0.0, 0.36],
                "exponentformat": "power",
            },
            shapes=[
                {
                    "type": "line",
                    "x0": 0.0,
                    "x1": 0.0,
                    "yref": "paper",
                    "y0": 0.0,
                    "y1": 1.0,
                    "line": {"color": COLOURS["contact"], "width": 2},
                }
            ],
            legend=LEGEND_BELOW,
            updatemenus=buttons(list(shown), [0, 1, 2, *[None] * len(lines)]),
        ),
    )


def _energies(energy: xr.Dataset) -> list[dict[str, Any]]:
    """Lines of the strain energy; parts that stay zero are left out."""
    starts = span_starts(energy["time"].values, ENERGY_POINTS)
    time = span_means(energy["time"].values, starts)
    family = energy["first_family"]
    own = family["nodal_diameter"].values == 1
    parts: Mapping[str, tuple[str, Array]] = {
        "total": ("total", energy["total"].values),
        "suspension": ("suspension", energy["suspension"].values),
        "1F, k = 1": ("k = 1", family.values[:, own].sum(axis=1)),
        "1F, other k": ("other k", family.values[:, ~own].sum(axis=1)),
        "rest": ("rest", energy["rest"].values),
    }
    return [
        {
            "type": "scatter",
            "x": time,
            "y": span_means(values, starts),
            "yaxis": "y2",
            "mode": "lines",
            "name": name,
            "line": {"color": COLOURS[colour], "width": 2.5 if name == "total" else 1.5},
            "hovertemplate": f"%{{x:.6g}} s<br>{name} %{{y:.4g}} J<extra></extra>",
        }
        for name, (colour, values) in parts.items()
        if values.any()
    ]


def _orbit(orbit: xr.Dataset) -> Plot:
    """Path of the shaft in each of `LOOK`, with a marker each for the cursor at the end."""
    thinned = orbit.isel(time=span_starts(orbit["time"].values, ORBIT_POINTS))
    time = thinned["time"].values
    clearance = MILLI * float(orbit.attrs["smallest_clearance"])
    turn = np.linspace(0.0, 2 * np.pi, 181)
    circle = {
        "type": "scatter",
        "x": clearance * np.cos(turn),
        "y": clearance * np.sin(turn),
        "mode": "lines",
        "line": {"color": COLOURS["casing"], "dash": "dash", "width": 1.5},
        "hoverinfo": "skip",
    }
    paths, markers = [], []
    for frame in LOOK:
        place = (MILLI * thinned[frame].values).astype(np.float32)
        path = {
            "type": "scatter",
            "x": place[:, 0],
            "y": place[:, 1],
            "customdata": np.column_stack([time, MILLI * thinned["radius"].values]),
            "mode": "markers+lines",
            "line": {"color": "#c9ced6", "width": 0.6},
            "marker": {"size": 3, "color": time, "colorscale": COLOUR_SCALE},
            "hovertemplate": (
                "%{customdata[0]:.6g} s<br>x %{x:.4g} mm, y %{y:.4g} mm<br>"
                f"radius %{{customdata[1]:.4g}} mm<extra>{frame} frame</extra>"
            ),
            "visible": frame == LOOK[0],
        }
        marker = {
            "type": "scatter",
            "x": place[-1:, 0],
            "y": place[-1:, 1],
            "mode": "markers",
            "marker": {"size": 12, "color": COLOURS["contact"], "line": {"color": INK, "width": 1}},
            "hoverinfo": "skip",
            "visible": frame == LOOK[0],
        }
        paths.append(path)
        markers.append(marker)
    edge = 1.1 * max(MILLI * float(orbit["radius"].max()), clearance) or 1.0
    axis = {"range": [-edge, edge], "constrain": "domain"}
    layout = plain_layout(
        xaxis={"title": {"text": "x [mm]"}, **axis},
        yaxis={"title": {"text": "y [mm]"}, "scaleanchor": "x", **axis},
        showlegend=False,
        updatemenus=buttons([f"{frame} frame" for frame in LOOK], [None, 0, 1, 0, 1]),
    )
    return Plot(traces=[circle, *paths, *markers], layout=layout)
