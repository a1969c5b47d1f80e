"""Gaps and contact forces of all blades over time (Fig. 21 of the paper), and contact classes."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from bladewhirl.meshes.line_mesh import BoolArray
from bladewhirl.models.inputs.units import handy_unit
from bladewhirl.postprocess.fields import windows
from bladewhirl.postprocess.fields.by_blade import of_blades
from bladewhirl.postprocess.fields.enlarged import rounded_up
from bladewhirl.postprocess.fields.kinematics import Array
from bladewhirl.postprocess.fields.labelled import labelled
from bladewhirl.postprocess.fields.lost_blades import masked
from bladewhirl.postprocess.fields.netcdf import has
from bladewhirl.postprocess.plotting.axes import blade_axis, draw_decades, draw_map
from bladewhirl.postprocess.plotting.style import (
    COLOUR_MAPS,
    COLOURS,
    new_figure,
    styled,
    time_axis,
)
from bladewhirl.postprocess.plotting.titles import head

PERMANENT = 0.99  #: a blade with at least this share of the time in contact is "permanent"
COLUMNS = 600  #: largest number of time spans of a map; more spans could not be seen
FORCE_DECADES = 3.0  #: number of decades that colours distinguish below the largest force
FEW_PERCENT = 40.0
"""If no share of the time in contact exceeds this [%], its axis, or its scale of colours, is
shortened."""

#: if contact takes up at most this fraction of the time, time axes only show the time of contact
BRIEF = 0.5
BRIEF_MARGIN = 0.1  #: margin of these axes at both ends, as a fraction of the time of contact

CLASS_COLOURS: Mapping[str, str] = {
    "permanent": COLOURS["contact"],
    "intermittent": COLOURS["k = 0"],
    "free": COLOURS["rest"],
}

CLASS_HATCHES: Mapping[str, str] = {"permanent": "////", "intermittent": "....", "free": ""}


def contact_maps(result: xr.Dataset, columns: int = COLUMNS) -> xr.Dataset:
    """Compute gaps and forces of every blade in equal spans of time.

    The gap is the smallest gap of all time steps in a span; the force is the impulse in the span
    divided by the length of the span. With several contact nodes on a blade, the gap is the
    smallest, the force the sum, and the share the largest of all nodes.

    Args:
        result: result of a run.
        columns: largest number of spans; if there are fewer records, each record has its own span.

    Returns:
        Dataset over (time, blade): `gap` [m], the smallest gap, nan for a lost blade; `force` [N],
        mean normal force, positive if the casing pushes the tip inward; `friction` [N], mean
        friction force, positive if it drags the tip towards -theta; `share` [1], share of the time
        steps in contact. `time`
        [s] is the end of each span, `edge` (edge,) [s] are the limits of all spans.

    Raises:
        ViewError: there are fewer than two records.
    """
    dataset = windows.select_window(result)
    begin = float(dataset["time"][0])
    dataset = dataset.isel(time=slice(1, None))  # each record covers the time since the one before
    time = dataset["time"].values
    starts = windows.span_starts(time, columns)
    edges = windows.span_edges(time, starts, begin)
    length = np.diff(edges)[:, None]
    plane = ("time", "blade")

    def total(name: str, choice: np.ufunc = np.add) -> Array:
        return of_blades(dataset, np.add.reduceat(dataset[name].values, starts, axis=0), choice)

    gaps = masked(dataset, dataset["gap"].values)
    gap = of_blades(dataset, np.fmin.reduceat(gaps, starts, axis=0), np.minimum)
    return labelled(
        dataset,
        "gaps and contact forces of the blades",
        {
            "gap": (plane, gap, "m"),
            "force": (plane, total("contact_impulse") / length, "N"),
            "friction": (plane, total("friction_impulse") / length, "N"),
            "share": (plane, _share(total("contact_steps", np.maximum), length, dataset), "1"),
        },
        {"time": edges[1:], "edge": edges, "blade": np.arange(gap.shape[1])},
        to=" to metal" if has(result, "coating") else "",
    )


def contact_classes(
    result: xr.Dataset, *, start: float | None = None, end: float | None = None
) -> xr.Dataset:
    """Compute the share of time steps at which each blade is in contact, and its contact class.

    The class is *permanent* for a share of 99 % or more, *free* without contact, and *intermittent*
    otherwise. The share of a blade is the largest of its contact nodes.

    Args:
        result: result of a run with at least two records.
        start, end: limits of the time window [s]; start and end of the run when None.

    Returns:
        Dataset over blade: `share` [1] and `contact_class`. The attribute `first_contact` [s] is
        the time of the first contact of the run; nan if this time is not within the window.

    Raises:
        ViewError: there are fewer than two records.

    Example:
        ``contact_classes(result, start=2.0)["share"].sel(blade=3)``
    """
    dataset = windows.select_window(result, start, end)
    share = of_blades(dataset, contact_share(dataset), np.maximum)
    time = dataset["time"].values
    names = np.select([share >= PERMANENT, share > 0], ["permanent", "intermittent"], "free")
    touched = result["time"].values[(result["contact_steps"].values > 0).any(axis=1)]
    first = float(touched[0]) if len(touched) else np.inf
    return labelled(
        dataset,
        "share of the time in contact",
        {"share": ("blade", share, "1"), "contact_class": ("blade", names, "1")},
        {"blade": np.arange(len(share))},
        window=windows.window_label(dataset),
        first_contact=first if time[0] < first <= time[-1] else np.nan,
    )


def contact_share(dataset: xr.Dataset) -> Array:
    """Return the share of time steps at which each contact node is in contact, (contact_node,);
    there must be at least two records."""
    time = dataset.variables["time"].values
    # Each record counts the steps with contact since the previous record.
    touching = dataset.variables["contact_steps"][1:].values.sum(axis=0)
    return _share(touching, time[-1] - time[0], dataset)


@styled
def plot_gaps(maps: xr.Dataset) -> Figure:
    """Draw the gap of every blade over time from `contact_maps` and, where a blade touches, the
    share of the time in contact."""
    figure, axes = _map_axes()
    unit, scale = handy_unit(float(maps["gap"].max(skipna=True)), "m")
    gap = np.maximum(scale * maps["gap"].values.T, 0.0)
    label = f"smallest gap{maps.attrs['to']} [{unit}]"
    if len(gap) == 1:
        return _draw_alone(figure, axes, maps, gap[0], label)
    axes.patch.set(hatch="////", edgecolor=COLOURS["rest"])  # lost blades
    picture = draw_map(axes, maps["edge"], maps["blade"], gap, vmin=0.0, cmap=COLOUR_MAPS["gap"])
    if maps["share"].any():
        limit = share_limit(maps["share"])
        touching = draw_share(axes, maps["edge"], maps["blade"], maps["share"], limit)
        words = share_label("time in contact [%]", limit)
        figure.colorbar(touching, ax=axes, label=words, pad=0.02)
    figure.colorbar(picture, ax=axes, label=label, pad=0.02)
    time_axis(axes)
    head(figure, maps)
    return figure


@styled
def plot_forces(maps: xr.Dataset) -> Figure:
    """Draw the mean normal force on every blade over time from `contact_maps`, with logarithmic
    colours."""
    figure, axes = _map_axes()
    force = maps["force"].values
    top = float(force.max()) or 1.0
    unit, scale = ("kN", 1e-3) if top >= 1e3 else ("N", 1.0)
    if force.shape[1] == 1:
        return _draw_alone(figure, axes, maps, scale * force[:, 0], f"mean normal force [{unit}]")
    span = float(np.diff(maps["edge"]).max())
    small, larger = handy_unit(span, "s")
    length = f"{larger * span:.2g} {small}"
    positive = np.ma.masked_less_equal(scale * force.T, 0.0)
    levels = scale * top, FORCE_DECADES
    picture = draw_decades(
        axes, maps["edge"], maps["blade"], positive, levels, cmap=COLOUR_MAPS["contact"]
    )
    figure.colorbar(picture, ax=axes, label=f"normal force [{unit}]", extend="min")
    axes.set_xlim(*contact_span(maps["edge"].values, np.any(force > 0.0, axis=1)))
    time_axis(axes)
    axes.set_xlabel(f"{axes.get_xlabel()}, means over {length}")
    head(figure, maps)
    return figure


@styled
def plot_contact_classes(classes: xr.Dataset) -> Figure:
    """Draw the share of the time that each blade is in contact, coloured by class, from
    `contact_classes`."""
    figure = new_figure(height=0.06)
    axes = figure.add_subplot()
    blade, share = classes["blade"].values, 100 * classes["share"].values
    for name, colour in CLASS_COLOURS.items():
        members = classes["contact_class"].values == name
        label = f"{name}: {np.count_nonzero(members)}"
        height = np.where(members, share, 0.0)
        axes.bar(blade, height, color=colour, hatch=CLASS_HATCHES[name], label=label)
    top = 1.1 * share.max() if 0 < share.max() < FEW_PERCENT else 102.0
    axes.set(ylabel="time in contact [%]", ylim=(0, top))
    blade_axis(axes, len(blade))
    head(figure, classes, classes.attrs["window"])
    figure.legend(loc="outside lower center", ncols=3)
    return figure


def _share(steps: Array, time: Array | float, dataset: xr.Dataset) -> Array:
    """Return the share of time steps in contact, from the number `steps` of time steps in contact
    in an interval of length `time` [s]."""
    return np.asarray(steps / np.maximum(np.round(time / dataset.attrs["time_step"]), 1.0))


def contact_span(edge: Array, touching: BoolArray) -> tuple[float, float]:
    """Return the limits of a time axis [s]: the time of contact with margins if contact is brief,
    see `BRIEF`; otherwise the complete time.

    Args:
        edge: limits of the spans of time [s], (span + 1,).
        touching: true for spans with contact, (span,).
    """
    spans = np.flatnonzero(touching)
    begin, end = float(edge[0]), float(edge[-1])
    if not len(spans):
        return begin, end
    first, last = float(edge[spans[0]]), float(edge[spans[-1] + 1])
    if last - first > BRIEF * (end - begin):
        return begin, end
    margin = BRIEF_MARGIN * (last - first)
    return max(begin, first - margin), min(end, last + margin)


def share_limit(*shares: xr.DataArray) -> float:
    """Return the share of the time in contact [%] that has the darkest colour: 100 or, if all
    shares are below `FEW_PERCENT`, the least of 1, 2, 5, 10, ... that no share exceeds."""
    largest = 100.0 * max(float(share.max()) for share in shares)
    return rounded_up(largest) if 0.0 < largest < FEW_PERCENT else 100.0


def share_label(words: str, limit: float) -> str:
    """Return the label of a scale of shares that ends at `limit` [%]; if the scale does not end at
    100 %, the label states its end."""
    return words if limit == 100.0 else f"{words}\nscale ends at {limit:g} %"


def draw_share(
    axes: Axes, across: ArrayLike, up: ArrayLike, share: xr.DataArray, limit: float
) -> QuadMesh:
    """Draw shares (time, row) of the time in contact in percent. The share `limit` [%] has the
    darkest colour, see `share_limit`."""
    percent = np.ma.masked_less_equal(100.0 * np.nan_to_num(share.values.T), 0.0)
    return draw_map(axes, across, up, percent, cmap=COLOUR_MAPS["contact"], vmin=0.0, vmax=limit)


def _map_axes() -> tuple[Figure, Axes]:
    figure = new_figure(height=0.06)
    axes = figure.add_subplot()
    axes.set_ylabel("blade")
    axes.locator_params(axis="y", integer=True)
    return figure, axes


def _draw_alone(figure: Figure, axes: Axes, maps: xr.Dataset, values: Array, label: str) -> Figure:
    """Draw values (span,) of the only blade as a line over time, with marks of contact."""
    edge, touched = maps["edge"].values, maps["share"].values[:, 0] > 0.0
    axes.stairs(values, edge, baseline=None, color=COLOURS["rotor"])
    at = 0.5 * (edge[1:] + edge[:-1])[touched]
    label_of = "contact with the coating" if maps.attrs["to"] else "contact"
    look: Any = {"transform": axes.get_xaxis_transform(), "color": COLOURS["contact"]}
    axes.plot(at, np.full(len(at), 0.02), "|", markersize=4.0, label=label_of, **look)
    axes.set(ylabel=label, ylim=(0.0, None), xlim=contact_span(edge, touched))
    if touched.any():
        figure.legend(loc="outside lower center")
    time_axis(axes)
    head(figure, maps)
    return figure
