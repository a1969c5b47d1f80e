"""Interaction map of a sweep: force, stress and wear over two swept keys, with the speeds at which
engine orders excite natural frequencies."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from bladewhirl.models.inputs.units import handy_unit
from bladewhirl.postprocess.fields.kinematics import Array, ViewError
from bladewhirl.postprocess.plotting import style
from bladewhirl.postprocess.plotting.axes import Labels
from bladewhirl.postprocess.plotting.legends import Group
from bladewhirl.postprocess.sweep import drawing
from bladewhirl.postprocess.sweep.dataset import swept
from bladewhirl.postprocess.sweep.drawing import edges_of
from bladewhirl.postprocess.sweep.maps import draw_cells
from bladewhirl.postprocess.sweep.quantities import LINE, as_lines, in_order, need_a_grid
from bladewhirl.postprocess.sweep.resonances import NATURAL_MODES, resonances

ORDERS = range(1, 9)  #: engine orders whose resonances are drawn
LINES: Mapping[str, Any] = {"color": style.COLOURS["total"], "linestyle": ":", "linewidth": 0.9}


class Quantity(NamedTuple):
    """A quantity of the map."""

    label: str
    unit: str
    factor: float  #: from the SI unit to `unit`; a prefix is chosen for N and Pa
    colours: str  #: name of the colour map


QUANTITIES = {
    "contact_force_max": Quantity("largest force", "N", 1.0, "contact"),
    "stress_max": Quantity("largest stress", "Pa", 1.0, "magnitude"),
    "wear_volume": Quantity("worn volume", "mm³", 1e9, "wall"),
}
"""Quantities by the names of their variables."""


def interaction(dataset: xr.Dataset, key: str) -> xr.Dataset:
    """Return force, stress and wear over two swept keys, and resonances.

    Args:
        dataset: from `open_sweep`, with two or more swept keys.
        key: swept key on the horizontal axis; the first other key is on the vertical axis.

    Returns:
        Dataset over (line, vertical key, key): `contact_force_max` [N], `stress_max` [Pa],
        `wear_volume` [m3], as far as points have them. If the key is the speed, over resonance the
        variables of `resonances`, with the place along the vertical axis as `resonance_across`.

    Raises:
        ViewError: only one key is swept, no point is finished, or there is a table of points.
    """
    need_a_grid(dataset)
    others = [name for name in swept(dataset) if name != key]
    if not others:
        raise ViewError("an interaction map needs two swept keys, but this sweep has only one")
    across, *lines = others
    chosen = [*(set(QUANTITIES) & set(dataset)), *NATURAL_MODES, "rotation_speed"]
    data = as_lines(in_order(dataset, chosen), lines)
    orders = ORDERS if key == "march_speed" else ()
    met = resonances(data, key, dataset.sizes["blade"], orders)
    shown = [name for name in QUANTITIES if name in data and np.isfinite(data[name]).any()]
    return (
        data[[*shown, "state"]]
        .transpose(LINE, across, key)
        .assign_attrs(title="interaction map", along=key, across=across)
        .assign(met.rename({f"resonance_{across}": "resonance_across"}))
    )


@style.styled
def plot_interaction(data: xr.Dataset) -> Figure:
    """Draw the map from `interaction`: a row of panels for each line of the Dataset."""
    given, data = data, drawing.in_handy_units(data)
    names, along = [name for name in QUANTITIES if name in data], str(data.attrs["along"])
    height = 0.045 + 0.055 * min(data.sizes[LINE], drawing.MOST_ROWS)
    figure, shown, rows = drawing.grid_of_panels(data, [1.0] * len(names), height, sharey=True)
    bars = {}
    for column, name in enumerate(names):
        quantity, panels = QUANTITIES[name], rows[:, column]
        values = data[name].values
        unit, scale = quantity.unit, quantity.factor
        if unit in ("N", "Pa"):
            unit, scale = handy_unit(float(np.nanmax(values)), unit)
        top = scale * float(np.nanmax(values)) or 1.0
        look: dict[str, Any] = {"cmap": style.COLOUR_MAPS[quantity.colours], "rasterized": True}
        for number, axes in zip(shown, panels, strict=True):
            cells = scale * values[number]
            none = np.ma.masked_where(cells != 0.0, cells)
            draw_cells(axes, data, none, cmap=ListedColormap(["white"]), rasterized=True)
            some = np.ma.masked_where(~(cells > 0.0), cells)
            drawn = draw_cells(axes, data, some, norm=Normalize(0.0, top), **look)
        bars[column] = drawn, f"{quantity.label} [{unit}]"
    drawing.finish_maps(data, rows, bars)
    entries = [(Patch(facecolor="white", edgecolor="#777777"), "white: none")]
    note = ""
    if given.sizes["resonance"]:
        note = "Dotted: engine orders at frequencies of the nodal diameter that they excite."
    drawing.title_figure(figure, data, Group(entries, note), most=drawing.MOST_ROWS)
    factor = float(data[along].values[-1] / given[along].values[-1]) if given.sizes[along] else 1.0
    for number, panels in zip(shown, rows, strict=True):
        here = given.isel(resonance=given["resonance_line"].values == number)
        for axes in panels:
            _draw_resonances(axes, here, edges_of(data[str(data.attrs["across"])].values), factor)
    return figure


def _draw_resonances(axes: Axes, given: xr.Dataset, edges: Array, factor: float) -> None:
    """Draw the speeds at which engine orders meet natural frequencies within each row of cells,
    with their orders where there is space.

    Args:
        axes: the panel.
        given: resonances of the panel.
        edges: borders of the rows.
        factor: from the unit of the key to that of the axis.
    """
    places, orders = factor * given["resonance_at"].values, given["resonance_order"].values
    if not len(places):
        return
    row = given["resonance_across"].values
    for look in ({"color": "white", "linewidth": 1.8, "alpha": 0.7}, LINES):
        axes.vlines(places, edges[row], edges[row + 1], **look)
    labels, top = Labels(axes), row == row.max()
    for order, place in sorted(zip(orders[top].tolist(), places[top].tolist(), strict=True)):
        labels.add(place, edges[-1], f"{order}Ω", style.COLOURS["total"], [(0, -2)])
