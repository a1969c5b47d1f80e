"""Motion of a shaft line over time: forces of its bearings, orbits at bearings, deflection."""

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.figure import Figure

from bladewhirl.models.inputs.units import handy, handy_unit
from bladewhirl.postprocess.fields import rotation
from bladewhirl.postprocess.fields.labelled import labelled
from bladewhirl.postprocess.plotting.style import (
    COLOURS,
    FULL_WIDTH,
    new_figure,
    styled,
    time_axis,
)
from bladewhirl.postprocess.plotting.titles import head

TURNS = 2.0  #: number of turns of the rotor that are drawn black
COLUMNS = 3  #: number of orbits in a row


def line_bearing_forces(result: xr.Dataset) -> xr.Dataset:
    """Compute the forces of the bearings on a shaft line, with the reaction to its weight.

    Args:
        result: result of a run with a shaft line.

    Returns:
        Dataset over (time, bearing, axis): `static`, the components in static axes [N]; over (time,
        bearing): `force`, the magnitude [N].
    """
    force = result["bearing_force"].values
    return labelled(
        result,
        "forces of the bearings",
        {
            "static": (("time", "bearing", "axis"), force, "N"),
            "force": (("time", "bearing"), np.hypot(force[..., 0], force[..., 1]), "N"),
        },
        {
            "time": result["time"].values,
            "bearing": result["bearing_name"].values,
            "axis": ["x", "y"],
        },
    )


@styled
def plot_line_bearing_forces(data: xr.Dataset) -> Figure:
    """Draw the force of each bearing and its components over time, from `line_bearing_forces`."""
    count = data.sizes["bearing"]
    figure = new_figure(height=0.03 + 0.04 * count)
    panels = figure.subplots(count, 1, sharex=True, squeeze=False)[:, 0]
    time, force = data["time"].values, data["force"].values
    unit, scale = handy_unit(float(force.max()), "N")
    for number, axes in enumerate(panels):
        for name, colour in (("x", COLOURS["k = 0"]), ("y", COLOURS["other k"])):
            component = scale * data["static"].isel(bearing=number).sel(axis=name).values
            axes.plot(time, component, color=colour, label=f"along {name}")
        axes.plot(time, scale * force[:, number], color=COLOURS["rotor"], label="magnitude")
        axes.set_title(f"bearing {data['bearing'].values[number]}")
        axes.set_ylabel(f"force [{unit}]")
    time_axis(panels[-1])
    entries = panels[0].get_legend_handles_labels()
    figure.legend(*entries, loc="outside lower center", ncols=3)
    record, worst = np.unravel_index(force.argmax(), force.shape)
    most = f"at most {handy(force[record, worst], 'N', 4)} at {handy(time[record], 's', 4)}"
    head(figure, data, most)
    return figure


def line_orbits(result: xr.Dataset) -> xr.Dataset:
    """Compute the orbits of a shaft line at its bearings.

    Args:
        result: result of a run with a shaft line.

    Returns:
        Dataset over (time, bearing, axis): `shaft` and `support`, displacements in static axes [m];
        over time: `turn`, the number of turns of the rotor.
    """
    nodes = result["bearing_node"].values
    moved = result["shaft_displacement"].values[:, nodes, :2]
    over = ("time", "bearing", "axis")
    return labelled(
        result,
        "orbits at the bearings",
        {
            "shaft": (over, moved, "m"),
            "support": (over, result["support_displacement"].values, "m"),
            "turn": ("time", rotation.turns(result), "1"),
        },
        {
            "time": result["time"].values,
            "bearing": result["bearing_name"].values,
            "axis": ["x", "y"],
        },
    )


@styled
def plot_line_orbits(data: xr.Dataset) -> Figure:
    """Draw the orbits at the bearings, from `line_orbits`; the last two turns of the rotor are
    black."""
    count = data.sizes["bearing"]
    columns = min(count, COLUMNS)
    rows = -(-count // columns)
    figure = new_figure(width=FULL_WIDTH, height=0.02 + 0.06 * rows)
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    late = data["turn"].values >= data["turn"].values[-1] - TURNS
    unit, scale = handy_unit(float(np.abs(data["shaft"].values).max()), "m")
    for axes, number in zip(panels, range(count), strict=False):
        shaft, support = (scale * data[name].values[:, number].T for name in ("shaft", "support"))
        axes.plot(*shaft, color=COLOURS["rest"], linewidth=0.4, label="whole motion")
        axes.plot(*shaft[:, late], color=COLOURS["rotor"], label="last two turns")
        if support.any():
            axes.plot(*support[:, late], color=COLOURS["casing"], label="support, last two turns")
        axes.set_title(f"bearing {data['bearing'].values[number]}")
        axes.set(aspect="equal", xlabel=f"x [{unit}]", ylabel=f"y [{unit}]")
        axes.locator_params(nbins=5)
    for axes in panels[count:]:
        axes.set_visible(False)
    known = dict[str, Artist]()
    for axes in panels[:count]:
        known |= dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
    figure.legend(list(known.values()), list(known), loc="outside lower center", ncols=3)
    head(figure, data)
    return figure
