"""Maps over two swept keys: regime, largest displacement of the shaft, growth rate."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import Collection
from matplotlib.colors import ListedColormap, LogNorm, Normalize, SymLogNorm
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from bladewhirl.models.inputs.units import handy_unit
from bladewhirl.postprocess.energy.growth_rates import CERTAINTY
from bladewhirl.postprocess.fields.kinematics import Array, ViewError
from bladewhirl.postprocess.periodic.dataset import fixed, of_sweep
from bladewhirl.postprocess.plotting import style
from bladewhirl.postprocess.plotting.legends import Group
from bladewhirl.postprocess.sweep import drawing
from bladewhirl.postprocess.sweep.dataset import swept
from bladewhirl.postprocess.sweep.quantities import (
    LINE,
    as_lines,
    in_order,
    largest_motion,
    need_a_grid,
)
from bladewhirl.postprocess.sweep.regimes import (
    HATCH,
    NOT_JUDGED,
    draw_regimes,
    linear_threshold,
    regime_entries,
    regime_names,
)

#: a colour scale is logarithmic if the largest value exceeds this many times the median
CLEAR_RANGE = 30.0
CROSSED: Mapping[str, Any] = {"hatch": "xxx", "edgecolor": "#777777", "linewidth": 0.0}
DOUBTFUL = "growth rate within two standard errors of zero"


def sweep_maps(dataset: xr.Dataset, key: str, branches: Sequence[xr.Dataset] = ()) -> xr.Dataset:
    """Return regime, largest displacement [m] and growth rate [1/s] over two swept keys.

    Args:
        dataset: from `open_sweep`, with two or more swept keys.
        key: swept key on the horizontal axis; the first other key is on the vertical axis.
        branches: branches of periodic motions over one of both keys, from `open_branch`; the value
            of the other key is that of their case.

    Returns:
        Dataset over (line, vertical key, key), with a line for each combination of all further
        keys: `regime`, `shaft_radius_max` (`displacement_max` without a moving shaft),
        `growth_rate` and its standard error `growth_error`; attributes `along`, the horizontal key,
        and `across`, the vertical key.

        With branches over (branch, point): `branch_along`, `branch_across`, `branch_stable` and
        `branch_kind`.

    Raises:
        ViewError: only one key is swept, no point is finished, there is a table of points, or a
            branch is over another key.
    """
    need_a_grid(dataset)
    others = [name for name in swept(dataset) if name != key]
    if not others:
        raise ViewError("maps need two swept keys, but this sweep has only one")
    across, *lines = others
    largest, what = largest_motion(dataset)
    data = in_order(dataset, ["regime", largest, "growth_rate", "growth_error"])
    growth = ", growth" if np.isfinite(data["growth_rate"].values).any() else ""
    if lines and branches:
        raise ViewError("expected a sweep over two keys to lay branches over its maps")
    return (
        as_lines(data, lines)
        .transpose(LINE, across, key)
        .assign_attrs(title=f"regime, displacement of the {what}{growth}")
        .assign_attrs(along=key, across=across, largest=largest)
        .assign(_laid(dataset, branches, key, across))
    )


def _laid(
    dataset: xr.Dataset, branches: Sequence[xr.Dataset], key: str, across: str
) -> dict[str, Any]:
    """Return the variables of branches in maps over two swept keys, see `sweep_maps`."""
    if not branches:
        return {}
    factors = [of_sweep(branch, dataset) for branch in branches]
    most = max(each.sizes["point"] for each in branches)
    rows: dict[str, list[Array]] = {name: [] for name in ("along", "across", "stable", "kind")}
    for branch, factor in zip(branches, factors, strict=True):
        own = str(branch.attrs["key"]).replace(".", "_")
        values = {own: factor * branch["parameter"].values}
        other = key if own == across else across
        values[other] = np.full(branch.sizes["point"], fixed(branch, dataset, other))
        found = {"along": values[key], "across": values[across]}
        found |= {name: branch[name].values.astype(float) for name in ("stable", "kind")}
        for name, each in found.items():
            padded = np.pad(each, (0, most - len(each)), constant_values=np.nan)
            rows[name].append(padded)
    return {f"branch_{name}": (("branch", "point"), np.stack(each)) for name, each in rows.items()}


@style.styled
def plot_sweep_maps(maps: xr.Dataset) -> Figure:
    """Draw maps from `sweep_maps`, with a row of panels for each line of the Dataset.

    Points without contact have the mark of their regime in the map of displacements too. Growth
    rates within `CERTAINTY` standard errors of zero are crossed out. If the growth rate can
    be judged at no point, the map of growth rates is left out.
    """
    given, maps = maps, drawing.in_handy_units(maps)
    along, across = str(maps.attrs["along"]), str(maps.attrs["across"])
    largest = maps[str(maps.attrs["largest"])]
    unit, scale = handy_unit(float(largest.max().fillna(0.0)), "m")
    radius = scale * largest.values
    growth, error = maps["growth_rate"].values, maps["growth_error"].values
    doubtful = np.abs(growth) <= CERTAINTY * error
    label = f"largest recorded displacement [{unit}]"
    pictures = [(radius, label, style.COLOUR_MAPS["magnitude"], _of_magnitudes(radius))]
    if np.isfinite(growth).any():
        top = float(np.nanmax(np.abs(growth))) or 1.0
        threshold = linear_threshold(growth, error)
        norm = SymLogNorm(threshold, vmin=-top, vmax=top) if threshold else Normalize(-top, top)
        pictures.append((growth, "growth rate [1/s]", style.COLOUR_MAPS["signed"], norm))
    height = 0.04 + 0.05 * min(maps.sizes[LINE], drawing.MOST_ROWS)
    columns = [1.0] * (1 + len(pictures))
    figure, shown, rows = drawing.grid_of_panels(maps, columns, height, sharey=True)
    for number, row in zip(shown, rows, strict=True):
        draw_regimes(row[0], maps[along].values, maps[across].values, regime_names(maps)[number])
        drawn = [
            draw_cells(axes, maps, values[number], cmap=colours, norm=norm, rasterized=True)
            for axes, (values, _, colours, norm) in zip(row[1:], pictures, strict=True)
        ]
        if len(pictures) > 1:
            crossed = np.ma.masked_where(~doubtful[number], growth[number])
            draw_cells(row[2], maps, crossed, cmap=ListedColormap(["white"]), **CROSSED)
        free = np.nonzero(regime_names(maps)[number] == "no-contact")
        place = maps[along].values[free[1]], maps[across].values[free[0]]
        mark = drawing.REGIME_MARKS["no-contact"]
        row[1].plot(*place, mark, color="black", markersize=3.0)
        for axes in row:
            _draw_branches(axes, maps, given)
    bars = {n: (drawn[n - 1], label) for n, (_, label, _, _) in enumerate(pictures, 1)}
    drawing.finish_maps(maps, rows, bars)
    entries: list[tuple[Artist | tuple[Artist, ...], str]] = []
    entries += regime_entries(regime_names(maps))
    if doubtful[shown].any():
        entries.append((Patch(facecolor="white", **CROSSED), DOUBTFUL))
    if "branch_along" in given:
        line = Line2D([], [], color="black")
        entries.append((line, "periodic motions (dashed: unstable, dots: bifurcations)"))
    group = Group(entries, "" if len(pictures) > 1 else NOT_JUDGED)
    drawing.title_figure(figure, maps, group, most=drawing.MOST_ROWS)
    return figure


def _draw_branches(axes: Axes, maps: xr.Dataset, given: xr.Dataset) -> None:
    """Draw the branches of maps whose keys have convenient units; `given` has SI units."""
    if "branch_along" not in given:
        return
    place = []
    for name in ("along", "across"):
        key = str(maps.attrs[name])
        largest = int(np.abs(given[key].values).argmax())
        factor = float(maps[key].values[largest] / given[key].values[largest])
        place.append(factor * given[f"branch_{name}"].values)
    for x, y, stable, kind in zip(
        *place, given["branch_stable"].values, given["branch_kind"].values, strict=True
    ):
        for wide, colour in ((2.4, "white"), (1.0, "black")):
            axes.plot(x, np.where(stable == 0.0, y, np.nan), "--", color=colour, linewidth=wide)
            axes.plot(x, np.where(stable == 1.0, y, np.nan), color=colour, linewidth=wide)
        axes.plot(x[kind > 0], y[kind > 0], "ok", mec="white", markersize=3.5)


def draw_cells(axes: Axes, maps: xr.Dataset, values: Array, **look: Any) -> Collection:
    """Draw values (rows, columns); cells without a result are hatched."""
    axes.grid(False)
    axes.patch.set(hatch=HATCH, edgecolor=style.COLOURS["rest"])
    x, y = (drawing.edges_of(maps[str(maps.attrs[name])].values) for name in ("along", "across"))
    return axes.pcolor(x, y, values, **look)


def _of_magnitudes(values: Array) -> Normalize:
    """Return a colour scale for magnitudes, which is logarithmic if the largest value exceeds
    `CLEAR_RANGE` times the median."""
    positive = values[np.isfinite(values) & (values > 0)]
    if not positive.size:
        return Normalize(0.0, 1.0)
    if positive.max() > CLEAR_RANGE * np.median(positive):
        return LogNorm(positive.min(), positive.max())
    return Normalize(0.0, positive.max())
