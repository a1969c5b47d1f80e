"""Interactive plots of a run with a common time cursor: deformed stage, orbit, contact, energy."""

from typing import Any

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from bladewhirl.meshes.plane import directions
from bladewhirl.postprocess.energy.strain import PLOT_DECADES, energy_terms, term_label
from bladewhirl.postprocess.fields.kinematics import Array
from bladewhirl.postprocess.fields.windows import span_means, span_starts
from bladewhirl.postprocess.pictures import appearance as look
from bladewhirl.postprocess.pictures.drawing import Drawing, Picture, arrows
from bladewhirl.postprocess.plotting.style import COLOURS
from bladewhirl.postprocess.reports.interactive import COLOUR_SCALE, INK, buttons, colour_bar, plot
from bladewhirl.postprocess.reports.page import Instants
from bladewhirl.postprocess.run.blade_contact import force_limit
from bladewhirl.postprocess.shaft.orbits import MILLI
from bladewhirl.postprocess.shaft.transforms import Frame

MOST_INSTANTS = 60  #: largest number of instants at which the stage is drawn
#: largest number of coordinates over all instants; it limits the instants of a large stage
MOST_PLACES = 1_000_000
FEWEST_INSTANTS = 10

PIECE = 3  #: stride of the drawn stations along a beam; the stride along the wall is twice as large
ORBIT_POINTS = 5000  #: largest number of points of an orbit; more points make a page slow
#: largest number of points of a curve of energies, which are means over equal time intervals
ENERGY_POINTS = 1000
FULL = 32767  #: largest signed number of 16 bits

#: frames of the orbit; the stage is drawn in the first frame
FRAMES: tuple[Frame, Frame] = ("static", "rotating")
POINTED = (
    "blade %{y}, %{x:.6g} s<br>mean normal force %{customdata[0]:.4g} N<br>"
    "mean friction %{customdata[1]:.4g} N<br>smallest gap %{customdata[2]:.4g} mm<extra></extra>"
)

BOTH_SIGNS = [[0.0, COLOURS["k = 0"]], [0.5, "#ffffff"], [1.0, COLOURS["k = 1"]]]

CAPTION = (
    "Move the cursor, or point at a time in the map below: all plots show that instant, at first "
    "that of the {where}. The stage is drawn in the static frame, {size}; small discs mark the "
    "shaft and blade 0, arrows are contact forces. The orbit is coloured by time, the dashed "
    "circle is the clearance. The map of blades over time shows the mean normal force [N] on each "
    "blade in equal time intervals; buttons switch to the smallest gap [mm] or to friction [N]; "
    "white is no contact. The curves below are strain energies [J]. Drag to zoom in, double-click "
    "to reset. Look for lasting contact, contact that moves from blade to blade, and energy that "
    "grows."
)


def instants(
    dataset: xr.Dataset, maps: xr.Dataset, orbit: xr.Dataset, energy: xr.Dataset
) -> Instants:
    """Return the interactive plots, with the stage at up to `MOST_INSTANTS` equidistant instants
    and at the instant of the largest contact force.

    Args:
        dataset: a result.
        maps: from `blade_contact.contact_maps`.
        orbit: from `orbits.shaft_orbit`.
        energy: from `strain.strain_energies`.
    """
    impulse = dataset["contact_impulse"].values.max(axis=1)
    if impulse.any():
        marked, where = int(impulse.argmax()), "largest contact force"
    else:
        marked = int(orbit["radius"].values.argmax())
        where = "largest recorded displacement of the shaft"
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
            where=where, size=look.enlargement(drawing.exaggeration).replace("\n", " ")
        ),
        plots=[_orbit(orbit), _histories(maps, energy)],
        times=drawing.times,
        first=int(np.searchsorted(records, marked)),
        words=[look.contact_text(picture.blade_forces).replace("\n", ", ") for picture in pictures],
        places=[MILLI * orbit[frame].values[records] for frame in FRAMES],
        machine=_machine(drawing, pictures),
    )


def _machine(drawing: Drawing, pictures: list[Picture]) -> list[dict[str, Any]]:
    """Return the layers of the drawn stage, the lowest layer first: colour and filled outlines
    (instant, outline, point, 2). Coordinates are integers; `FULL` is half the width of the picture.
    """
    reach = look.MARGIN * max(float(np.abs(picture.casing.sides).max()) for picture in pictures)
    longest = look.LONGEST_ARROW * reach / drawing.largest_force if drawing.largest_force else 0.0
    disc = look.HUB * reach * directions(np.linspace(0.0, 2 * np.pi, 13))
    shapes = [
        {
            COLOURS["casing"]: _outlines(picture.casing.sides[:, :: 2 * PIECE]),
            INK: _outlines(picture.rotor.sides[:, ::PIECE]),
            "#ffffff": np.stack([picture.shaft + 0.6 * disc, picture.mark + 0.6 * disc]),
            look.FORCE_COLOUR: arrows(
                picture.tips, picture.forces, longest, look.ARROW_WIDTH * reach
            ),
        }
        for picture in pictures
    ]
    return [
        {
            "colour": colour,
            "places": np.clip(
                np.round(FULL / reach * np.array([shape[colour] for shape in shapes])), -FULL, FULL
            ).astype(np.int16),
        }
        for colour in shapes[0]
    ]


def _outlines(sides: Array) -> Array:
    """Return outlines (line, point, 2) of ribbons: along the right side, back along the left."""
    return np.concatenate([sides[:, :, 0], sides[:, ::-1, 1]], axis=1)


def _histories(maps: xr.Dataset, energy: xr.Dataset) -> go.Figure:
    """Plot a map of the contact of all blades over time, energies below it, and the cursor."""
    force, friction = maps["force"].values.T, maps["friction"].values.T
    gap, touched = MILLI * np.maximum(maps["gap"].values.T, 0.0), maps["share"].values.T > 0
    drag = float(np.abs(friction).max()) or 1.0
    shown: dict[str, tuple[str, Array, dict[str, Any]]] = {
        "normal force": (
            "mean normal force [N]",
            np.where(touched, force, np.nan),
            {"zmin": 0.0, "zmax": force_limit(force), "colorscale": COLOUR_SCALE},
        ),
        "gap": ("smallest gap [mm]", gap, {"zmin": 0.0, "colorscale": COLOUR_SCALE}),
        "friction": (
            "mean friction [N]",
            np.where(touched, friction, np.nan),
            {"zmin": -drag, "zmax": drag, "colorscale": BOTH_SIGNS},
        ),
    }
    heat = [
        go.Heatmap(
            x=maps["time"].values,
            y=maps["blade"].values,
            z=values.astype(np.float32),
            customdata=np.stack([force, friction, gap], axis=-1).astype(np.float32),
            hovertemplate=POINTED,
            colorbar={**colour_bar(title), "y": 0.7, "len": 0.62},
            visible=name == "normal force",
            **colours,
        )
        for name, (title, values, colours) in shown.items()
    ]
    lines = _energies(energy)
    top = float(energy["total"].max()) or 1.0
    return plot(
        [*heat, *lines],
        xaxis={"title_text": "time [s]", "showgrid": False, "anchor": "y2"},
        yaxis={"title_text": "blade", "showgrid": False, "zeroline": False, "domain": [0.42, 1.0]},
        yaxis2={
            "title_text": "strain energy [J]",
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
        updatemenus=buttons(list(shown), [0, 1, 2, *[None] * len(lines)]),
    )


def _energies(energy: xr.Dataset) -> list[go.Scatter]:
    """Return the curves of the strain energies; energies that are always zero are left out."""
    starts = span_starts(energy["time"].values, ENERGY_POINTS)
    return [
        go.Scatter(
            x=span_means(energy["time"].values, starts),
            y=span_means(values.values, starts),
            yaxis="y2",
            mode="lines",
            name=term_label(name),
            line={"color": COLOURS[name], "width": 2.5 if name == "total" else 1.5},
            hovertemplate=f"%{{x:.6g}} s<br>{term_label(name)} %{{y:.4g}} J<extra></extra>",
        )
        for name, values in energy_terms(energy).items()
        if values.any()
    ]


def _orbit(orbit: xr.Dataset) -> go.Figure:
    """Plot the orbit of the shaft in each of `FRAMES`; the last traces are the markers at the
    instant of the cursor."""
    thinned = orbit.isel(time=span_starts(orbit["time"].values, ORBIT_POINTS))
    time = thinned["time"].values
    clearance = MILLI * float(orbit.attrs["smallest_clearance"])
    x, y = clearance * directions(np.linspace(0.0, 2 * np.pi, 181)).T
    circle = go.Scatter(
        x=x,
        y=y,
        mode="lines",
        line={"color": COLOURS["casing"], "dash": "dash", "width": 1.5},
        hoverinfo="skip",
    )
    paths, markers, outline = [], [], {"color": INK, "width": 1}
    for frame in FRAMES:
        x, y = (MILLI * thinned[frame].values).astype(np.float32).T
        paths.append(
            go.Scatter(
                x=x,
                y=y,
                customdata=np.column_stack([time, MILLI * thinned["radius"].values]),
                mode="markers+lines",
                line={"color": "#c9ced6", "width": 0.6},
                marker={"size": 3, "color": time, "colorscale": COLOUR_SCALE},
                hovertemplate="%{customdata[0]:.6g} s<br>x %{x:.4g} mm, y %{y:.4g} mm<br>"
                f"radius %{{customdata[1]:.4g}} mm<extra>{frame} frame</extra>",
                visible=frame == FRAMES[0],
            )
        )
        markers.append(
            go.Scatter(
                x=x[-1:],
                y=y[-1:],
                mode="markers",
                marker={"size": 12, "color": COLOURS["contact"], "line": outline},
                hoverinfo="skip",
                visible=frame == FRAMES[0],
            )
        )
    edge = 1.1 * max(MILLI * float(orbit["radius"].max()), clearance) or 1.0
    axis = {"range": [-edge, edge], "constrain": "domain"}
    return plot(
        [circle, *paths, *markers],
        xaxis={"title_text": "x [mm]", **axis},
        yaxis={"title_text": "y [mm]", "scaleanchor": "x", **axis},
        showlegend=False,
        updatemenus=buttons([f"{frame} frame" for frame in FRAMES], [None, 0, 1, 0, 1]),
    )
