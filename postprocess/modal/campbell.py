"""Campbell diagrams (Fig. 8): in the rotating frame, and as seen from the casing."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from bladewhirl.meshes.line_mesh import BoolArray, FloatArray, IntArray
from bladewhirl.postprocess.plotting.style import COLOURS, new_figure, styled
from bladewhirl.solvers.stability.coincidence import frequency_in_other_frame

Frame = Literal["rotating", "static"]

DRAWN_FAMILIES = ("1F", "suspension")
"""Families of the bladed disk that are drawn even where nothing coincides."""

SPEED_AXIS = "rotational speed Ω / ω$_1$ [–]"
SHADE = "#F0F0F0"
"""Of the operating range."""

RING: dict[str, Any] = {
    "linestyle": "none",
    "marker": "o",
    "markersize": 3.6,
    "markerfacecolor": "white",
}
"""Mark of a coincidence."""

MOST_NUMBERED = 12
"""Highest nodal diameter whose coincidences get their number."""

DIGIT_ROOM, NUMBER_ROOM = 0.014, np.array([0.02, 0.05])
"""Shares of the axes that a number takes, width by the digit; one that would cover another is
left out."""

HEADROOM = 1.15
"""Highest frequency shown over the highest coincidence or mode of interest."""


def drawn_part(data: xr.Dataset) -> xr.Dataset:
    """Modes and coincidences of a diagram: families of the bladed disk that coincide with the
    casing inside it, `DRAWN_FAMILIES` whether they do or not, and the casing's lowest mode of each
    nodal diameter from 1 to the highest of those families.

    Args:
        data: from `campbell`.
    """
    first, last = data.attrs["speeds"]
    speed = data["normalised_speed"].values
    seen = (first <= speed) & (speed <= last)
    families = [*DRAWN_FAMILIES, *data["family"].values[seen]]
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


@styled
def plot_campbell(data: xr.Dataset, frame: Frame) -> Figure:
    """Draw a Campbell diagram: the modes of one body as levels, the other's waves as rays.

    In the rotating frame the bladed disk's frequencies are constant and a wave that travels
    forward on the casing has k Omega - omega, backward where that is positive, as drawn. In the
    static frame it is the other way round: rays are waves that travel backward on the rotor.
    Where a ray would fall below zero, its wave travels the other way: that part is left out in the
    rotating frame, as in Fig. 8, and faint in the static one. Circles mark coincidences, those of
    the first family and the suspension with their k.

    A bladed disk that feels that it turns has branches instead: waves that travel backward at rest
    full, forward ones thin. Dotted lines are multiples of the speed, crosses critical speeds.

    Args:
        data: from `campbell`, of which `drawn_part` is drawn.
        frame: whose view.
    """
    data = drawn_part(data)
    figure = new_figure(height=0.088)
    axes = figure.subplots()
    first, last = data.attrs["speeds"]
    axes.axvspan(*data.attrs["operating_range"], color=SHADE, zorder=0)
    level = "bladed-disk" if frame == "rotating" else "casing"
    meets = data["rotor_frequency" if frame == "rotating" else "casing_frequency"].values
    meets = meets / data.attrs["reference_frequency_hz"]
    met_at = data["normalised_speed"].values
    seen = (met_at >= first) & (met_at <= last)
    modes = data["normalised_mode_frequency"].values
    body, k = data["mode_body"].values, data["mode_nodal_diameter"].values
    turning = "branch" in data.dims
    highest = modes[body == level].max() if frame == "rotating" else meets[seen].max(initial=1.0)
    top = HEADROOM * float(highest)
    axes.set(xlim=(first, last), ylim=(0.0, top))
    speed = np.linspace(first, last, 2001)
    # Rays first, and of each body those with one nodal diameter last, so that they lie on top.
    if turning:
        _draw_branches(axes, data, frame)
        orders = np.unique(k[body != "casing"])
        _draw_engine_orders(axes, data, orders[orders > 0], frame)
    for mode in np.lexsort((k == 1, body == level)):
        if turning and body[mode] != "casing":
            continue
        y = np.full_like(speed, modes[mode])
        if body[mode] != level:
            y = frequency_in_other_frame(modes[mode], k[mode], speed)
        _draw_mode(axes, speed, y, data.isel(mode=mode), turned=frame == "static")
    _mark_coincidences(axes, data, meets, seen & (meets <= top))
    axes.set(xlim=(first, last), ylim=(0.0, top))
    axes.set(xlabel=SPEED_AXIS, ylabel=f"frequency / ω$_1$, {frame} frame [–]")
    figure.legend(
        handles=_legend(data, frame), loc="outside upper center", ncols=3, columnspacing=1.0
    )
    return figure


def _draw_branches(axes: Axes, data: xr.Dataset, frame: Frame) -> None:
    """Waves on a bladed disk that feels that it turns, over the speed."""
    speed = data["line_speed"].values
    signed = data["branch_frequency"].values / data.attrs["reference_frequency_hz"]
    for row, k, family, way in zip(
        signed,
        data["branch_nodal_diameter"].values,
        data["branch_family"].values,
        data["branch_direction"].values,
        strict=True,
    ):
        first = int(k) == 1
        name = "suspension" if family == "suspension" else ("k = 1" if first else "other k")
        axes.plot(
            speed,
            np.abs(row if frame == "rotating" else row - k * speed),
            color=COLOURS[name],
            linewidth=(1.2 if first else 0.7) * (1.0 if way == "backward" else 0.6),
            alpha=1.0 if way == "backward" else 0.6,
            zorder=3 if first else 2,
        )


def _draw_engine_orders(axes: Axes, data: xr.Dataset, orders: IntArray, frame: Frame) -> None:
    """Multiples of the speed in the rotating frame, and critical speeds."""
    speed, critical = data["line_speed"].values, data["critical_speed"].values
    height = np.zeros(len(critical))
    if frame == "static":
        height = critical * data["critical_nodal_diameter"].values
    for order in orders if frame == "rotating" else ():
        axes.plot(speed, order * speed, ":", color=COLOURS["rest"], linewidth=0.5, zorder=1)
    axes.plot(critical, height, "x", color=COLOURS["contact"], clip_on=False, zorder=6)


def _mark_coincidences(axes: Axes, data: xr.Dataset, meets: FloatArray, shown: BoolArray) -> None:
    speeds, k = data["normalised_speed"].values, data["nodal_diameter"].values
    for here, colour in ((shown & (k != 1), "other k"), (shown & (k == 1), "k = 1")):
        axes.plot(speeds[here], meets[here], color=COLOURS[colour], clip_on=False, zorder=5, **RING)
    numbered = shown & (k <= MOST_NUMBERED) & np.isin(data["family"].values, DRAWN_FAMILIES)
    size = np.array([np.ptp(axes.get_xlim()), np.ptp(axes.get_ylim())])
    placed: dict[bool, FloatArray] = {}  # the last number above a level, and below one
    for i in np.flatnonzero(numbered):
        here = np.array([speeds[i], meets[i]])
        width, height = NUMBER_ROOM
        room = size * np.array([width + DIGIT_ROOM * len(str(k[i])), height])
        # Number 1 stands below, where its neighbours have none, if there is room.
        below = bool(k[i] == 1 and meets[i] > room[1])
        if below in placed and (np.abs(here - placed[below]) < room).all():
            continue
        placed[below] = here
        offset = (3.0, -9.0) if below else (-4.0, 3.5)
        axes.annotate(str(k[i]), tuple(here), xytext=offset, textcoords="offset points")


def _draw_mode(
    axes: Axes, speed: FloatArray, y: FloatArray, mode: xr.Dataset, *, turned: bool
) -> None:
    """A level or a ray; where `turned`, faint where it would fall below zero."""
    first, on_rotor = int(mode["mode_nodal_diameter"]) == 1, mode["mode_body"] == "bladed-disk"
    if mode["mode_family"] == "suspension":
        name = "suspension"
    elif on_rotor:
        name = "k = 1" if first else "other k"
    else:
        name = "k = 0" if first else "casing"
    parts: list[tuple[FloatArray, float, float | None]] = [
        (np.where(y >= 0.0, y, np.nan), 1.2 if first else 0.7, None)
    ]
    if turned:
        parts.append((np.where(y < 0.0, -y, np.nan), 0.4, 0.35))
    for shown, width, alpha in parts:
        axes.plot(
            speed,
            shown,
            color=COLOURS[name],
            linestyle="-" if on_rotor else "--",
            linewidth=width,
            alpha=alpha,
            zorder=3 if first else 2,
        )


def _legend(data: xr.Dataset, frame: Frame) -> list[Line2D | Patch]:
    lines: list[tuple[str, Literal["-", "--"], float, str]] = [
        ("k = 1", "-", 1.2, "disk, k = 1"),
        ("other k", "-", 0.7, "disk, other k"),
        ("suspension", "-", 1.2, "suspension"),
        ("k = 0", "--", 1.2, "casing, k = 1"),
        ("casing", "--", 0.7, "casing, other k"),
    ]
    if "suspension" not in data["mode_family"].values:
        del lines[2]
    turning: list[Line2D | Patch] = []
    if "branch" in data.dims:
        order = Line2D([], [], color=COLOURS["rest"], linestyle=":", label="engine order")
        turning = [
            Line2D([], [], color=COLOURS["other k"], linewidth=0.5, alpha=0.6, label="forward"),
            *([order] if frame == "rotating" else []),
            Line2D(
                [], [], color=COLOURS["contact"], linestyle="none", marker="x", label="critical"
            ),
        ]
    return [
        *(
            Line2D([], [], color=COLOURS[name], linestyle=style, linewidth=width, label=label)
            for name, style, width, label in lines
        ),
        Line2D([], [], color=COLOURS["total"], label="coincidence of k", **RING),
        Patch(color=SHADE, label="operating range"),
        *turning,
    ]
