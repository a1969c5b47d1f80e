"""The casing unrolled: clearance left, contact force and wear by angle and axial position."""

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from bladewhirl.models.inputs.units import handy_unit
from bladewhirl.models.stage.coating import axial_tracks, track_edges
from bladewhirl.postprocess.fields import rotation
from bladewhirl.postprocess.fields.by_blade import blade_count
from bladewhirl.postprocess.fields.kinematics import Array, IntArray
from bladewhirl.postprocess.fields.labelled import labelled
from bladewhirl.postprocess.fields.lost_blades import masked
from bladewhirl.postprocess.fields.netcdf import has
from bladewhirl.postprocess.fields.windows import select_window, span_edges, span_starts
from bladewhirl.postprocess.plotting.axes import cell_edges, draw_map
from bladewhirl.postprocess.plotting.style import (
    COLOUR_MAPS,
    COLOURS,
    FULL_WIDTH,
    INCH,
    is_narrow,
    new_figure,
    styled,
)
from bladewhirl.postprocess.plotting.titles import head
from bladewhirl.postprocess.run.wear import coating_of

MOST_SECTORS = 360  #: largest number of sectors of the casing
MOST_SPANS = 60  #: largest number of spans of time, each of a revolution or more
LEAST = 1e-3  #: value that chooses the unit of values that are all zero
ROW = 0.036  #: height of a row of panels [m]
QUANTITIES = {"gap": "smallest gap", "force": "largest force", "wear": "removed depth"}
"""Quantities by the names of their variables in `unrolled`."""

MAPS = {"gap": "gap", "force": "contact", "wear": "wall"}
"""Names of the colour maps of these quantities."""


def unrolled(result: xr.Dataset) -> xr.Dataset:
    """Compute what every place of the casing, and every blade, has seen in spans of time.

    A record counts for the sector of the casing in which a contact node is in the middle of the
    time since the last record; sectors are as wide as this motion, or wider.

    Args:
        result: result of a run.

    Returns:
        Dataset over (span, axial, sector), static frame: `gap` [m], the smallest gap, and `force`
        [N], the largest mean normal force on a contact node between two records, nan where no node
        passed; over (span, axial, blade), rotating frame: `blade_gap` and `blade_force`, nan for a
        lost blade; with a coating over (span, axial, rod) `wear` [m], the depth removed at the end
        of the span. `time` (span,) [s] is its end, `axial` [m] are the axial positions of contact
        nodes, `sector_edge` and `rod_edge` [rad] limits of sectors and rods.

    Raises:
        ViewError: there are fewer than two records.
    """
    dataset = select_window(result)
    time = dataset["time"].values
    axial, track = axial_tracks(dataset["axial_position"].values, dataset["contact_radius"].values)
    travel = float(np.median(np.abs(np.diff(rotation.angles(dataset)))))
    sectors = int(np.clip(2 * np.pi / travel, 4, MOST_SECTORS)) if travel else MOST_SECTORS
    turned = float(rotation.turns(dataset)[-1] - rotation.turns(dataset)[0])
    starts = span_starts(time[1:], int(np.clip(turned, 1, MOST_SPANS)))
    span = np.repeat(np.arange(len(starts)), np.diff(starts, append=len(time) - 1))
    middle = 0.5 * (time[1:] + time[:-1])
    angle = dataset["tip_angle"].values + rotation.angle_at(dataset, middle)[:, None]
    sector = (np.mod(angle, 2 * np.pi) * sectors / (2 * np.pi)).astype(np.int64) % sectors
    blade = np.broadcast_to(dataset["blade"].values, sector.shape)
    gap = np.maximum(masked(dataset, dataset["gap"].values)[1:], 0.0)
    force = dataset["contact_impulse"].values[1:] / np.diff(time)[:, None]
    force = np.where(np.isnan(gap), np.nan, force)
    rows = span[:, None] * len(axial) + track
    values: dict[str, tuple[tuple[str, ...], Array, str]] = {}
    for place, name, count, prefix in (
        (sector, "sector", sectors, ""),
        (blade, "blade", blade_count(dataset), "blade_"),
    ):
        over, shape = ("span", "axial", name), (len(starts), len(axial), count)
        for kind, given, choice, unit in (
            ("gap", gap, np.fmin, "m"),
            ("force", force, np.fmax, "N"),
        ):
            values[prefix + kind] = over, _extreme(given, rows * count + place, shape, choice), unit
    ends = span_edges(time[1:], starts, float(time[0]))[1:]
    coordinates: dict[str, Any] = {"axial": axial, "blade": np.arange(blade_count(dataset))}
    coordinates["sector_edge"] = np.linspace(0.0, 2 * np.pi, sectors + 1)
    if has(dataset, "coating"):
        profile = np.searchsorted(dataset["wear_time"].values, ends, side="right") - 1
        depth = coating_of(dataset).thickness * dataset["coating_strain"].values[profile]
        values["wear"] = ("span", "axial", "rod"), depth, "m"
        coordinates["rod_edge"] = np.linspace(0.0, 2 * np.pi, depth.shape[2] + 1)
    found = labelled(dataset, "the casing unrolled", values, coordinates)
    return found.assign_coords(time=("span", ends, {"units": "s"}))


def _extreme(values: Array, cell: IntArray, shape: tuple[int, ...], choice: np.ufunc) -> Array:
    """Return the smallest or largest of the values in each cell; nan for a cell without one."""
    found = np.full(np.prod(shape), np.nan)
    choice.at(found, cell.ravel(), values.ravel())
    return found.reshape(shape)


def whole_run(data: xr.Dataset) -> xr.Dataset:
    """Return what was seen in the whole run, from `unrolled`, without its spans."""
    least, most = data.min("span"), data.max("span")
    extremes = {name: (least if "gap" in str(name) else most)[name] for name in data.data_vars}
    return data.drop_dims("span").assign(
        {name: each.assign_attrs(data[name].attrs) for name, each in extremes.items()}
    )


@styled
def plot_unrolled(data: xr.Dataset) -> Figure:
    """Draw the casing unrolled in the whole run, from `unrolled`: in the static frame by angle, in
    the rotating frame by blade; as maps over the axial position, if there are several. Without
    contact there is no panel of the force."""
    seen = whole_run(data)
    shown = [name for name in QUANTITIES if name in seen]
    if not seen["force"].any():
        shown.remove("force")
    by_blade = [name for name in shown if f"blade_{name}" in seen]
    if data.sizes["axial"] == data.sizes["blade"] == 1:
        by_blade = []
    figure = new_figure(width=FULL_WIDTH, height=0.02 + ROW * len(shown))
    if is_narrow(figure):  # one panel below another
        figure.set_figheight((0.02 + ROW * (len(shown) + len(by_blade))) / INCH)
        panels = figure.subplots(len(shown) + len(by_blade), 1, squeeze=False)[:, 0]
        static, turning = panels[: len(shown)], panels[len(shown) :]
    else:
        grid = figure.subplots(len(shown), 2, squeeze=False, width_ratios=[2.2, 1.0])
        static, turning = grid[:, 0], grid[: len(by_blade), 1]
        for axes in grid[len(by_blade) :, 1]:
            axes.remove()
    for axes, name in zip(static, shown, strict=True):
        edges = np.degrees(seen["rod_edge" if name == "wear" else "sector_edge"].values)
        _draw(axes, seen, name, edges)
        axes.set(xticks=np.arange(0, 361, 90), xlim=(0, 360))
    for axes, name in zip(turning, by_blade, strict=True):
        _draw(axes, seen, f"blade_{name}", None)
        if seen.sizes["blade"] > 1:
            axes.xaxis.set_major_locator(MaxNLocator(6, integer=True))
    static[-1].set_xlabel("angle on the casing, static frame [°]")
    if by_blade and seen.sizes["blade"] > 1:
        turning[-1].set_xlabel("blade, rotating frame")
    head(figure, data)
    return figure


def _draw(axes: Axes, seen: xr.Dataset, name: str, edges: Array | None) -> None:
    """Draw a quantity over places with limits `edges`: a map over several axial positions; a line,
    or bars of blades without limits, for a single one; the profile of a single blade."""
    kind = name.removeprefix("blade_")
    values, axial = seen[name].values, seen["axial"].values
    both = [float(seen[each].max()) for each in (kind, name)]
    unit, scale = handy_unit(max(both) or LEAST, seen[kind].attrs["units"])
    words = QUANTITIES[kind]
    if kind == "gap" and "wear" in seen:
        words += "\nto metal"
    label = f"{words} [{unit}]"
    length, larger = handy_unit(float(np.abs(axial).max()), "m")
    if len(axial) > 1:
        axes.set_ylabel(f"axial position [{length}]")
    else:
        axes.set(ylabel=label, ylim=(0, 1.05 * scale * max(both) or 1.0))
    if len(axial) > 1 < values.shape[1]:
        up = larger * track_edges(axial)
        across = cell_edges(seen["blade"].values, logarithmic=False) if edges is None else edges
        look = {"vmin": 0.0, "vmax": scale * max(both) or 1.0, "cmap": COLOUR_MAPS[MAPS[kind]]}
        shown = np.ma.masked_where(values == 0.0, scale * values)  # zero is white
        draw_map(axes, across, up, shown, label=label, **look)
    elif len(axial) > 1:
        axes.plot(scale * values[:, 0], larger * axial, ".-", color=COLOURS["total"])
        axes.set(xlabel=label, xlim=(0, 1.05 * scale * max(both) or 1.0))
    elif edges is None:
        place, height = seen["blade"].values, scale * values[0]
        axes.bar(place, height, color=COLOURS["k = 0"])
        axes.plot(place, height, "_", color=COLOURS["k = 0"], clip_on=False, zorder=3)  # of zero
    else:
        line: dict[str, Any] = {"baseline": None, "clip_on": False, "zorder": 3}
        axes.stairs(scale * values[0], edges, color=COLOURS["total"], **line)
    if not np.nan_to_num(values).any():
        axes.annotate("zero everywhere", (0.5, 0.5), None, "axes fraction", ha="center")
