"""Campbell diagrams (Fig. 8): in the rotating frame, and as seen from the casing."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Literal

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from bladewhirl.meshes.line_mesh import BoolArray, FloatArray
from bladewhirl.postprocess.plotting.axes import AROUND, Labels, frequency_axis, speed_axis
from bladewhirl.postprocess.plotting.legends import Group, legends_below
from bladewhirl.postprocess.plotting.style import COLOURS, FULL_WIDTH, new_figure, styled
from bladewhirl.postprocess.plotting.titles import set_title
from bladewhirl.solvers.stability.coincidence import frequency_in_other_frame

Frame = Literal["rotating", "static"]

DRAWN_FAMILIES = ("1F", "suspension")
"""Families of the bladed disk that are drawn even where nothing coincides."""

SHADE = "#F0F0F0"
"""Of the operating range."""

RING: dict[str, Any] = {
    "linestyle": "none",
    "marker": "o",
    "markersize": 4.0,
    "markerfacecolor": "white",
}
"""Mark of a coincidence."""

CROSS: dict[str, Any] = {
    "linestyle": "none",
    "marker": "X",
    "markersize": 6.0,
    "color": COLOURS["contact"],
    "markeredgecolor": "white",
    "markeredgewidth": 0.4,
}
"""Mark of a critical speed."""

RAYS: Mapping[Frame, str] = {
    "rotating": "Of casing waves those are drawn that travel forward in the static frame and"
    " backward in this one.",
    "static": "Rays are waves that travel backward on the bladed disk and forward here;",
}
"""What of the waves that move in a frame is drawn."""

FINE = 2001
"""Speeds of a line that is curved on its axes."""

ENDS = 0.9
"""Share of the axes from which engine orders are named, where they have room."""

HEADROOM = 1.18
"""Highest frequency shown over the highest coincidence or mode of interest."""


def drawn_part(data: xr.Dataset) -> xr.Dataset:
    """Modes and coincidences of a diagram: families of the bladed disk that coincide with the
    casing in the operating range, `DRAWN_FAMILIES` whether they do or not, and the casing's lowest
    mode of each nodal diameter from 1 to the highest of those families.

    Args:
        data: from `campbell`.
    """
    operated = data["in_operating_range"].values.astype(bool) & in_diagram(data)
    families = [*DRAWN_FAMILIES, *data["family"].values[operated]]
    on_rotor = data["mode_body"].values == "bladed-disk"
    k, frequency = data["mode_nodal_diameter"].values, data["mode_frequency"].values
    rotor = on_rotor & np.isin(data["mode_family"].values, families)
    lowest = {
        int(number): frequency[~on_rotor & (k == number)].min()
        for number in np.unique(k[~on_rotor])
        if 1 <= number <= k[rotor].max()
    }
    casing = ~on_rotor & [frequency[i] == lowest.get(int(k[i])) for i in range(len(k))]
    met = [lowest.get(int(number)) for number in data["nodal_diameter"].values]
    shown = {
        "mode": rotor | casing,
        "coincidence": np.isin(data["family"].values, families)
        & (data["casing_frequency"].values == met),
    }
    if "branch" in data.dims:
        shown["branch"] = np.isin(data["branch_family"].values, families)
    return data.isel(shown)


def in_diagram(data: xr.Dataset) -> BoolArray:
    """Return which coincidences lie inside the speeds of the diagrams."""
    first, last = data.attrs["speeds"]
    speed = data["normalised_speed"].values
    return np.asarray((first <= speed) & (speed <= last), dtype=np.bool_)


@styled
def plot_campbell(data: xr.Dataset, frame: Frame) -> Figure:
    """Draw a Campbell diagram: the modes of one body as levels, the other's waves as rays.

    In the rotating frame the bladed disk's frequencies are constant and a wave that travels
    forward on the casing has k Omega - omega, backward where that is positive, as drawn. In the
    static frame it is the other way round: rays are waves that travel backward on the rotor, on a
    logarithmic axis. Where a ray would fall below zero, its wave travels the other way: that part
    is left out. Circles with their k mark coincidences; the caption counts those left out.

    A bladed disk that feels that it turns has branches instead: waves that travel backward at rest
    full, forward ones dashed, in the static frame those with one nodal diameter only. Dotted lines
    are multiples of the speed, crosses critical speeds.

    Args:
        data: from `campbell`, of which `drawn_part` is drawn.
        frame: whose view.
    """
    whole, data = data, drawn_part(data)
    figure = new_figure(width=FULL_WIDTH, height=0.105)
    axes = figure.subplots()
    reference = float(data.attrs["reference_frequency_hz"])
    meets = met_frequencies(data, frame)
    shown = in_diagram(data)
    axes.axvspan(*data.attrs["operating_range"], color=SHADE, zorder=0)
    axes.set(xlim=data.attrs["speeds"])
    if frame == "static":
        axes.set_yscale("log")
    axes.set_ylim(*frequency_limits(data, frame))
    turns = "branch" in data.dims
    named = [
        *(_draw_branches(axes, data, frame) if turns else ()),
        *_draw_modes(axes, data, frame),
        *_draw_engine_orders(axes, data, frame),
    ]
    if turns:
        _mark_critical(axes, data, frame)
    _mark_coincidences(axes, data, meets, shown)
    speed_axis(axes, reference)
    frequency_axis(axes, reference, f"frequency / ω₁, {frame} frame [–]")
    set_title(figure, data.attrs["case"], f"Campbell diagram, {frame} frame")
    entries = [entry for entry in _legend(data, frame) if _is_drawn(axes, entry[0])]
    note = f"{_left_out(whole, data)} {RAYS[frame]}"
    if frame == "static":
        which = "of its other waves those with k = 1 are drawn" if turns else "no others are drawn"
        note += f" {which}."
    if turns:
        note += " Branches are named by the way that they have at rest."
    legends_below(figure, Group(entries, note))
    labels = Labels(axes)
    labels.keep_free(data["normalised_speed"].values[shown], meets[shown])
    for k, speed, frequency in zip(
        data["nodal_diameter"].values[shown],
        data["normalised_speed"].values[shown],
        meets[shown],
        strict=True,
    ):
        labels.add(speed, frequency, str(k), COLOURS["total"], AROUND)
    for x, y, name, colour in named:
        labels.add(x[::-1], y[::-1], name, colour)
    return figure


def met_frequencies(data: xr.Dataset, frame: Frame) -> FloatArray:
    """Normalised frequency in a frame at which each coincidence happens."""
    met = data["rotor_frequency" if frame == "rotating" else "casing_frequency"].values
    return np.asarray(met / data.attrs["reference_frequency_hz"], dtype=np.float64)


def frequency_limits(data: xr.Dataset, frame: Frame) -> tuple[float, float]:
    """Lowest and highest frequency shown of a `drawn_part`, normalised."""
    level = "bladed-disk" if frame == "rotating" else "casing"
    modes, met = data["normalised_mode_frequency"].values, met_frequencies(data, frame)
    frequencies = modes[(data["mode_body"].values == level) & (modes > 0.0)]
    highest = float(met[in_diagram(data)].max(initial=1.0))
    if frame == "static":
        return 0.6 * float(frequencies.min(initial=1.0)), 1.5 * highest
    return 0.0, HEADROOM * max(float(frequencies.max(initial=1.0)), highest)


NamedLine = tuple[FloatArray, FloatArray, str, str]
"""Points of a line, x and y, with its name and the colour of that."""


def _draw_branches(axes: Axes, data: xr.Dataset, frame: Frame) -> Iterator[NamedLine]:
    """Draw the waves of a bladed disk with rotation effects over the speed."""
    speeds = data["line_speed"].values
    speed = np.linspace(speeds[0], speeds[-1], FINE)
    signed = data["branch_frequency"].values / data.attrs["reference_frequency_hz"]
    for values, growth, k, family, way in zip(
        signed,
        data["branch_growth"].values,
        data["branch_nodal_diameter"].values,
        data["branch_family"].values,
        data["branch_direction"].values,
        strict=True,
    ):
        row, grows = (np.interp(speed, speeds, each) for each in (values, growth > 0.0))
        first, forward = int(k) == 1, way == "forward"
        if forward and not first and frame == "static":
            continue
        colour = wave_colour("bladed-disk", str(family), int(k))
        y = np.abs(row if frame == "rotating" else row - k * speed)
        if frame == "static" and not first:  # where it travels forward, as casing waves do
            y = np.where(row < k * speed, y, np.nan)
        axes.plot(
            speed,
            y,
            color=colour,
            linestyle=(0, (5, 2)) if forward else "-",
            linewidth=1.2 if first else 0.6,
            zorder=3 if first else 2,
        )
        if growth.any():  # met, and unstable
            axes.plot(
                speed,
                np.where(grows == 1.0, y, np.nan),
                color=COLOURS["contact"],
                linewidth=4.0,
                alpha=0.5,
                zorder=1,
            )
            if not forward:
                yield speed, np.where(grows == 1.0, y, np.nan), "met: unstable", "black"
        if first:
            name = "suspension" if family == "suspension" else f"{family}, k = 1"
            yield speed, y, f"{name}, {way}", colour


def _draw_modes(axes: Axes, data: xr.Dataset, frame: Frame) -> Iterator[NamedLine]:
    """Levels of one body and rays of the other, with their nodal diameters or families."""
    level = "bladed-disk" if frame == "rotating" else "casing"
    body, k = data["mode_body"].values, data["mode_nodal_diameter"].values
    modes, family = data["normalised_mode_frequency"].values, data["mode_family"].values
    first_speed, last_speed = data.attrs["speeds"]
    speed = np.linspace(first_speed, last_speed, FINE)
    # Rays first, and of each body those with one nodal diameter last, so that they lie on top.
    order = np.lexsort((k == 1, body == level))
    for mode in order[np.argsort(k[order] != 1, kind="stable")]:
        on_disk = body[mode] == "bladed-disk"
        if "branch" in data.dims and on_disk:
            continue
        y = np.full_like(speed, modes[mode])
        if body[mode] != level:
            y = frequency_in_other_frame(modes[mode], k[mode], speed)
            y = np.where(y > 0.0, y, np.nan)
        colour = wave_colour(str(body[mode]), str(family[mode]), int(k[mode]))
        first = int(k[mode]) == 1
        axes.plot(
            speed,
            y,
            color=colour,
            linestyle="-" if on_disk else "--",
            linewidth=1.2 if first else 0.6,
            zorder=3 if first else 2,
        )
        if on_disk and first:
            yield speed, y, str(family[mode]), colour
        elif not on_disk:
            yield speed, y, f"k = {k[mode]}", COLOURS["k = 0"]


def _draw_engine_orders(axes: Axes, data: xr.Dataset, frame: Frame) -> Iterator[NamedLine]:
    """Multiples of the speed, in the static frame the speed itself."""
    first, last = data.attrs["speeds"]
    speed = np.linspace(first, last, 201)
    for order in _engine_orders(data, frame):
        axes.plot(speed, order * speed, ":", color="#777777", linewidth=0.6, zorder=1)
        y = order * speed
        end = y > ENDS * axes.get_ylim()[1] if frame == "rotating" else speed > ENDS * last
        yield speed[end], y[end], f"{order}Ω" if order > 1 else "Ω", "#555555"


def _engine_orders(data: xr.Dataset, frame: Frame) -> list[int]:
    k = data["mode_nodal_diameter"].values
    return [int(each) for each in np.unique(k[k > 0])] if frame == "rotating" else [1]


def _mark_critical(axes: Axes, data: xr.Dataset, frame: Frame) -> None:
    """Draw critical speeds, where a wave is stationary in the rotating frame, and the legend."""
    speeds, k = data["critical_speed"].values, data["critical_nodal_diameter"].values
    height = speeds * k if frame == "static" else np.zeros(len(speeds))
    if len(speeds):
        axes.plot(speeds, height, clip_on=False, zorder=6, **CROSS)


def _mark_coincidences(axes: Axes, data: xr.Dataset, meets: FloatArray, shown: BoolArray) -> None:
    speeds, k = data["normalised_speed"].values, data["nodal_diameter"].values
    for here, colour in ((shown & (k != 1), "other k"), (shown & (k == 1), "k = 1")):
        if here.any():  # an empty line that is not clipped would stretch the layout
            ring: dict[str, Any] = {"color": COLOURS[colour], "clip_on": False, "zorder": 5}
            axes.plot(speeds[here], meets[here], **ring, **RING)


def wave_colour(body: str, family: str, k: int) -> str:
    """Return the colour of a wave, by its body, k = 1 and the suspension."""
    if family == "suspension":
        return COLOURS["suspension"]
    if body == "bladed-disk":
        return COLOURS["k = 1" if k == 1 else "other k"]
    return COLOURS["k = 0" if k == 1 else "casing"]


def _left_out(whole: xr.Dataset, drawn: xr.Dataset) -> str:
    """Return a note on waves outside the diagram."""
    every, kept = np.count_nonzero(in_diagram(whole)), np.count_nonzero(in_diagram(drawn))
    if every == kept:
        return f"All {kept} coincidences at these speeds are shown, each with its k."
    return (
        f"{kept} of {every} coincidences at these speeds are shown, each with its k. Left out:"
        " families that meet outside the operating range only, and higher casing modes."
    )


def _is_drawn(axes: Axes, handle: Line2D | Patch) -> bool:
    """Return whether a legend entry is visible in a diagram; areas always are."""
    if isinstance(handle, Patch):
        return True
    low, high = axes.get_ylim()
    look = handle.get_marker(), handle.get_linestyle()
    any_colour = handle.get_color() == COLOURS["total"]
    return any(
        (line.get_marker(), line.get_linestyle()) == look
        and (any_colour or line.get_color() == handle.get_color())
        and bool(np.any((low <= (y := np.asarray(line.get_ydata()))) & (y <= high)))
        for line in axes.get_lines()
    )


def _legend(data: xr.Dataset, frame: Frame) -> list[tuple[Line2D | Patch, str]]:
    turning = "branch" in data.dims
    multiples = _engine_orders(data, frame)
    orders = f"orders, Ω to {multiples[-1]}Ω" if len(multiples) > 1 else "order 1, Ω"

    def line(name: str, style: Any, width: float, colour: str = "") -> Line2D:
        return Line2D([], [], color=colour or COLOURS[name], linestyle=style, linewidth=width)

    entries: list[tuple[Line2D | Patch, str]] = [
        (line("k = 1", "-", 1.2), "bladed disk, k = 1"),
        (line("other k", "-", 0.7), "bladed disk, other k"),
        (line("k = 0", "--", 1.2), "casing, k = 1"),
        (line("casing", "--", 0.7), "casing, other k"),
        (Line2D([], [], color=COLOURS["total"], **RING), "coincidence of waves with k"),
        (Patch(color=SHADE), "operating range"),
        (line("rest", ":", 0.7, "#777777"), f"engine {orders}"),
    ]
    if "suspension" in data["mode_family"].values:
        entries.insert(2, (line("suspension", "-", 1.2), "suspension"))
    if turning:
        which = "forward wave" if frame == "rotating" else "forward wave, k = 1"
        dashed = line("total", (0, (5, 2)), 0.8)
        entries.append((dashed, which))
        if critical := ", ".join(f"{speed:.4g}" for speed in data["critical_speed"].values):
            entries.append((Line2D([], [], **CROSS), f"critical speed, {critical} ω₁"))
    return entries
