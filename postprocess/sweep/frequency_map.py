"""Frequency map of a sweep: spectrum of the shaft against a swept key (the paper's Figs 15, 19)."""

from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure

from bladewhirl.postprocess.fields.kinematics import Array
from bladewhirl.postprocess.plotting.axes import cell_edges, draw_decades, spaced
from bladewhirl.postprocess.plotting.style import COLOURS, OUTLINE, styled
from bladewhirl.postprocess.shaft.orbits import MILLI
from bladewhirl.postprocess.shaft.spectra import LINE_DASHES
from bladewhirl.postprocess.sweep.drawing import MOST_ROWS, chosen, key_edges
from bladewhirl.postprocess.sweep.quantities import LINE, along, need_a_grid
from bladewhirl.postprocess.sweep.rows import plot_rows

#: largest number of columns of a map; if there are more points, neighbours share a column
MOST_COLUMNS = 1000
DECADES = 4.0  #: number of decades below the largest amplitude in a map
#: highest frequency of a map divided by the highest frequency of the modes that it must include
MARGIN = 1.15
ENGINE_ORDERS = "engine orders"

#: engine orders (multiples of the speed) that are drawn as lines
ORDERS = tuple(order for order in range(-4, 5) if order != 0)
LINES: Mapping[str, tuple[str, Any, bool]] = {
    "suspension": (COLOURS["suspension"], LINE_DASHES["suspension"], True),
    "1F k=1": (COLOURS["k = 1"], LINE_DASHES["1F"], True),
    "casing k=1": (COLOURS["casing"], LINE_DASHES["casing"], False),
}
"""Modes drawn as lines in a map: colour and dashes, as in spectra, and true if the map must include
their frequencies. Engine orders are dotted."""

#: black outline that makes white lines and letters legible on every colour of a map
INSIDE = 0.75  #: engine orders are named within this fraction of the height of the axes
LATE = 0.9  #: a line that stays inside the map is named at this fraction of its length


def frequency_map(dataset: xr.Dataset, key: str) -> xr.Dataset:
    """Return spectra of the shaft along a swept key, with frequencies of modes and engine orders.

    Args:
        dataset: from `open_sweep`.
        key: swept key, as a dimension of the sweep.

    Returns:
        Dataset over (line, key), with up to `MOST_ROWS` elements of `line`, one for each
        combination of the other swept keys: `amplitude` (line, key, frequency) [m]; `mode_line`
        (line, key, mode, direction), frequencies of modes; `engine_order` (line, key, order),
        frequencies of engine orders. All frequencies are in the rotating frame, forward positive,
        in multiples of the reference frequency if all points have the same one, otherwise in Hz.
        For waves on the casing, which have one nodal diameter, the speed is subtracted from the
        signed frequency in the static frame. With more than `MOST_COLUMNS` points neighbours share
        a column, which has their largest amplitudes.

    Raises:
        ViewError: no point is finished, or the sweep is over a table of points.
    """
    need_a_grid(dataset)
    names = ["rotation_speed", "reference_frequency", "mode_frequency", "mode_forward_frequency"]
    points = along(dataset, key, names)
    with_points = np.flatnonzero((points["state"] == "done").any(key).values)
    drawn = with_points[chosen(len(with_points), MOST_ROWS)]
    points = points.isel({LINE: drawn})
    reference = points["reference_frequency"].values / (2 * np.pi)
    known = reference[np.isfinite(reference)]
    unit, units = (float(known[0]), "1") if np.all(known == known[0]) else (1.0, "Hz")
    lines = _mode_lines(points)
    reach = _reach(lines, float(dataset["frequency"][-1]))
    inside = dataset.sel(frequency=slice(-reach, np.nextafter(reach, np.inf)))
    spectra = along(inside, key, ["spectrum"])["spectrum"].isel({LINE: drawn})
    group = -(-points.sizes[key] // MOST_COLUMNS)
    amplitude = spectra.coarsen({key: group}, boundary="pad", coord_func="min").max()
    speed = np.abs(points["rotation_speed"]) / (2 * np.pi)
    orders = speed * xr.DataArray(list(ORDERS), dims="order", coords={"order": list(ORDERS)})
    maps = points.assign(mode_line=lines / unit, engine_order=orders / unit)
    maps = maps.isel({key: slice(None, None, group)}).drop_vars([*names, "state"])
    for name in ("mode_line", "engine_order"):
        maps[name].attrs = {"units": units}
    resolution = float(np.diff(dataset["frequency"].values[:2]).sum())
    cells = amplitude.astype(np.float64).transpose(LINE, key, "frequency").values
    return (
        maps.assign(amplitude=((LINE, key, "frequency"), cells, {"units": "m"}))
        .assign_coords(frequency=("frequency", inside["frequency"].values / unit, {"units": units}))
        .assign_attrs(
            title=f"spectra of the shaft, rotating frame, resolution {resolution:.3g} Hz",
            lines=len(with_points),
            window=dataset.attrs["window"],
            points_per_column=group,
        )
    )


def _mode_lines(points: xr.Dataset) -> xr.DataArray:
    """Return the frequencies [Hz] of the modes `LINES` in the rotating frame, (line, key, mode,
    direction)."""
    ways = [points[name] for name in ("mode_frequency", "mode_forward_frequency")]
    frequencies = xr.concat(ways, "direction").sel(mode=list(LINES))
    speed = np.abs(points["rotation_speed"]) / (2 * np.pi)
    on_casing = frequencies["mode"].astype(str).str.startswith("casing")
    sign = xr.DataArray([-1.0, 1.0], [("direction", ["backward", "forward"])])
    return (frequencies * sign - speed * on_casing).transpose(LINE, ..., "mode", "direction")


def _reach(lines: xr.DataArray, available: float) -> float:
    """Return the largest frequency of a map [Hz]."""
    names = [name for name, (*_, reached) in LINES.items() if reached]
    outermost = np.nanmax(np.abs(lines.sel(mode=names).values), initial=0.0)
    return float(min(MARGIN * outermost, available)) if outermost > 0.0 else available


@styled
def plot_frequency_map(maps: xr.Dataset) -> Figure:
    """Draw maps from `frequency_map`: the amplitude against the swept key and the frequency, which
    is positive for forward motion. Dotted lines are engine orders, dashed lines are modes. Points
    without a result are left white."""
    top = np.nanmax(MILLI * maps["amplitude"].values, initial=0.0) or 1.0
    unit = "/ ω₁ [–]" if maps["frequency"].attrs["units"] == "1" else "[Hz]"
    return plot_rows(
        maps,
        [partial(_draw_map, top=top)],
        label="amplitude of the shaft [mm]",
        left=f"frequency {unit}, forward positive",
        lines=int(maps.attrs["lines"]),
    )


def _draw_map(axes: Axes, one: xr.Dataset, top: float) -> QuadMesh:
    """Draw one map and return its image for the colour bar."""
    key = str(one.attrs["along"])
    edges = key_edges(one)
    heights = cell_edges(one["frequency"].values, logarithmic=False)
    amplitude = MILLI * one["amplitude"].values.T
    picture = draw_decades(axes, edges, heights, amplitude, (top, DECADES))
    limit = float(np.abs(heights).max())
    axes.set(xlim=edges[[0, -1]], ylim=(-limit, limit))
    # Points without a result are skipped, so that they do not interrupt the lines.
    one = one.isel({key: np.flatnonzero(np.isfinite(one["engine_order"][:, 0].values))})
    place = one[key].values
    for name, (colour, dashes, _) in LINES.items():
        look: dict[str, Any] = {"linestyle": dashes, "color": colour, "path_effects": OUTLINE}
        for level in one["mode_line"].sel(mode=name).transpose("direction", key).values:
            if np.nanmin(np.abs(level), initial=np.inf) <= limit:
                axes.plot(place, level, label=spaced(name), **look)
    for order in ORDERS:
        _draw_order(axes, place, one["engine_order"].sel(order=order).values, order, limit)
    axes.plot([], [], color="grey", linestyle=":", linewidth=0.8, label=ENGINE_ORDERS)
    return picture


def _draw_order(axes: Axes, place: Array, level: Array, order: int, limit: float) -> None:
    """Draw the line of an engine order, with its name near the point where the line leaves the
    map."""
    seen = np.flatnonzero(np.isfinite(level) & (np.abs(level) <= INSIDE * limit))
    if not seen.size:
        return
    axes.plot(place, level, color="black", linestyle=":", linewidth=0.8, path_effects=OUTLINE)
    height = np.abs(level)
    leaves = seen[-1] + 1 < len(place)
    ends = slice(seen[-1], seen[-1] + 2)
    late = seen[int(LATE * (len(seen) - 1))]
    at = np.interp(INSIDE * limit, height[ends], place[ends]) if leaves else place[late]
    axes.annotate(
        f"{order:+d}Ω".replace("+1Ω", "+Ω").replace("-1Ω", "-Ω").replace("-", "−"),
        (at, np.sign(order) * INSIDE * limit if leaves else level[late]),
        color="black",
        ha="center",
        va="center",
        path_effects=OUTLINE,
    )
