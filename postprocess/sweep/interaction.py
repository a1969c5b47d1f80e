"""Interaction map of a sweep: force, stress and wear over two swept keys, with the speeds at which
engine orders excite natural frequencies."""

from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from bladewhirl.meshes.line_mesh import BoolArray
from bladewhirl.models.inputs.units import handy_unit
from bladewhirl.postprocess.fields.by_blade import aliased
from bladewhirl.postprocess.fields.kinematics import Array, ViewError
from bladewhirl.postprocess.fields.netcdf import has
from bladewhirl.postprocess.plotting import style
from bladewhirl.postprocess.plotting.axes import Labels
from bladewhirl.postprocess.plotting.legends import Group
from bladewhirl.postprocess.sweep import drawing
from bladewhirl.postprocess.sweep.dataset import swept
from bladewhirl.postprocess.sweep.maps import draw_cells
from bladewhirl.postprocess.sweep.quantities import LINE, as_lines, in_order, need_a_grid

MOST_ORDER = 8  #: highest engine order whose resonances are drawn
MOST_MODES = 3  #: largest number of natural frequencies of a superelement, the lowest ones
MODES = ("1F k=1", "2F k=1")
"""Modes of blades of beams by their names in a sweep; superelements have natural frequencies."""


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
        `wear_volume` [m3], as far as points have them. If the key is the speed, over resonance:
        `resonance_at`, the value of the key at which an engine order, `resonance_order`, has the
        natural frequency `resonance_frequency` [Hz] without contact, mean over the other keys.

    Raises:
        ViewError: only one key is swept, no point is finished, or there is a table of points.
    """
    need_a_grid(dataset)
    others = [name for name in swept(dataset) if name != key]
    if not others:
        raise ViewError("an interaction map needs two swept keys, but this sweep has only one")
    across, *lines = others
    modes = "natural_frequency" if has(dataset, "nodes") else "mode_frequency"
    data = in_order(dataset, [*(set(QUANTITIES) & set(dataset)), modes, "rotation_speed"])
    shown = [name for name in QUANTITIES if name in data and np.isfinite(data[name]).any()]
    chosen = {"mode": list(MODES)} if modes == "mode_frequency" else {}
    frequency = data[modes].sel(chosen)[..., :MOST_MODES]
    speed, mean = (
        each.mean(others).transpose(key, ...).values for each in (data["rotation_speed"], frequency)
    )
    orders = np.arange(1, MOST_ORDER + 1)
    excited = np.full((len(orders), mean.shape[1]), True)
    if chosen:
        diameter = [int(name.rpartition("=")[2]) for name in MODES]
        excited = aliased(orders, dataset.sizes["blade"])[:, None] == diameter
    at, order, hertz = _resonances(data[key].values, speed, mean, excited).T
    if key != "march_speed":
        at, order, hertz = at[:0], order[:0], hertz[:0]
    return (
        as_lines(data[[*shown, "state"]], lines)
        .transpose(LINE, across, key)
        .assign_attrs(title="interaction map", along=key, across=across)
        .assign(
            resonance_at=("resonance", at),
            resonance_order=("resonance", order.astype(np.int64)),
            resonance_frequency=("resonance", hertz, {"units": "Hz"}),
        )
    )


def _resonances(key: Array, speed: Array, frequency: Array, excited: BoolArray) -> Array:
    """Return the value of the key, the order and the frequency [Hz] where an engine order meets a
    natural frequency between two points, (resonance, 3).

    Args:
        key: values of the swept key (point,).
        speed: speeds (point,) [rad/s].
        frequency: natural frequencies (point, mode) [Hz].
        excited: whether each order from 1 on excites each mode (order, mode).
    """
    found: list[tuple[float, int, float]] = []
    for order, meant in enumerate(excited, 1):
        apart = order * np.abs(speed)[:, None] / (2 * np.pi) - frequency
        for left, mode in np.argwhere(((apart[:-1] <= 0.0) != (apart[1:] <= 0.0)) & meant):
            here, there = apart[left : left + 2, mode]
            share = here / (here - there)
            at, hertz = (
                (1.0 - share) * each[left] + share * each[left + 1]
                for each in (key, frequency[:, mode])
            )
            found.append((at, order, hertz))
    return np.array(found).reshape(-1, 3)


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
        note = "Dotted lines: engine orders at natural frequencies without contact."
    drawing.title_figure(figure, data, Group(entries, note), most=drawing.MOST_ROWS)
    factor = float(data[along].values[-1] / given[along].values[-1]) if given.sizes[along] else 1.0
    for axes in rows.ravel():
        _draw_resonances(axes, given, factor)
    return figure


def _draw_resonances(axes: Axes, given: xr.Dataset, factor: float) -> None:
    """Draw the speeds at which engine orders meet natural frequencies, with their orders where
    there is space; `factor` is that from the unit of the key to that of the axis."""
    places, orders = factor * given["resonance_at"].values, given["resonance_order"].values
    for place in places:
        axes.axvline(place, color="white", linewidth=1.8, alpha=0.7)
        axes.axvline(place, color=style.COLOURS["total"], linestyle=":", linewidth=0.9)
    if not len(places):
        return
    labels, top = Labels(axes), axes.get_ylim()[1]
    for order, place in sorted(zip(orders.tolist(), places.tolist(), strict=True)):
        labels.add(place, top, f"{order}Ω", style.COLOURS["total"], [(0, -2)])
