"""Frequencies against nodal diameter (the paper's Fig. 7); frequencies and critical speeds against
shaft stiffness."""

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from bladewhirl.meshes.line_mesh import BoolArray, FloatArray
from bladewhirl.postprocess.plotting.axes import (
    AROUND,
    FREQUENCY,
    Labels,
    coloured_line,
    frequency_axis,
    name_ends,
)
from bladewhirl.postprocess.plotting.legends import complete
from bladewhirl.postprocess.plotting.style import (
    COLOURS,
    COLUMN_WIDTH,
    FULL_WIDTH,
    new_figure,
    styled,
)
from bladewhirl.postprocess.plotting.titles import speed_label

DIAMETER_AXIS = "nodal diameter k [–]"

#: largest number of families for which the frequency axis is broken into a part for each family
FEW = 3
#: margin above and below the frequencies in a part of a broken axis, divided by their range
ROOM = 0.12
LOWEST = 0.05
"""Lowest normalised frequency drawn; at a critical speed a frequency is zero, which a logarithmic
axis cannot show."""

#: neighbouring branches of one family share a label up to this ratio of their frequencies
ALIKE = 1.05
FREE, CLAMPED = (
    {way: large if way == "both" else small for way in ("both", "standing", "backward", "forward")}
    for large, small in ((3.0, 2.2), (5.5, 2.8))
)
"""Sizes of marks [points] with a free and with a clamped centre. The marks are smaller if backward
and forward waves are distinguished, because there are more of them."""

ASIDE, CLAMPED_ASIDE = {"backward": -0.14, "forward": 0.14}, {"backward": -0.36, "forward": 0.36}
"""Horizontal offset of the marks of waves from their nodal diameter, with a free and a clamped
centre."""

WAYS = {"both": "o", "standing": "o", "backward": "<", "forward": ">"}
"""Marks of waves, by their direction in the rotating frame."""

WIDTHS = {"forward": 1.6, "backward": 0.7, "elliptic": 1.6}
"""Widths of the lines of critical speeds, by their direction [points]."""


@styled
def plot_families(data: xr.Dataset, families: int | None = None) -> Figure:
    """Draw frequencies from `veering` against nodal diameter, for a free and for a clamped centre
    (the paper's Fig. 7).

    Up to `FEW` families are drawn on an axis that is broken between the families, more families on
    a logarithmic axis. All blade families are drawn when `families` is None.
    """
    families = families or int(data.attrs["families"])
    names = ["suspension", *(f"{rank}F" for rank in range(1, families + 1))]
    names = [name for name in names if (data["family"].values == name).any()]
    lowest = [float(data["normalised_frequency"].values[_is(data, name)].min()) for name in names]
    names = [names[i] for i in np.argsort(lowest)[::-1]]
    broken = families <= FEW
    figure = new_figure(width=COLUMN_WIDTH if _ways(data) == ["both"] else FULL_WIDTH, height=0.1)
    panels = np.atleast_1d(figure.subplots(len(names) if broken else 1, sharex=True))
    reference = float(data.attrs["reference_frequency_hz"])
    last = int(data["nodal_diameter"].values.max())
    for axes, shown in zip(panels, [[name] for name in names] if broken else [names], strict=True):
        for name in shown:
            _draw_family(axes, data, name)
        if broken:
            axes.margins(y=ROOM)
            low, high = axes.get_ylim()
            # The margin prevents rounding errors of equal frequencies from filling the panel.
            least = 0.02 * float(np.mean([low, high]))
            axes.set_ylim(low - least, high + least)
        else:
            axes.set_yscale("log")
            axes.margins(y=0.1)
        frequency_axis(axes, reference)
        axes.set_xlim(-0.5, last + 0.19 * (last + 2.0))
    if broken:
        for axes in panels:
            axes.set_ylabel("")
            axes.child_axes[0].set_ylabel("")
        figure.supylabel(f"{FREQUENCY}, broken axis; right: [Hz]", fontsize=7.5)
    panels[-1].set_xlabel(DIAMETER_AXIS)
    ticks = np.asarray(MaxNLocator(integer=True).tick_values(0, last))
    panels[-1].set_xticks(ticks[ticks <= last])
    complete(figure, data, f"Frequencies by nodal diameter{_at_speed(data)}")
    for axes, shown in zip(panels, [[name] for name in names] if broken else [names], strict=True):
        _name_families(axes, data, shown)
    return figure


@styled
def plot_shaft_veering(data: xr.Dataset) -> Figure:
    """Draw the modes with one nodal diameter from `veering` against the stiffness of the shaft.

    The colour is the share of the shaft springs in the strain energy of a mode. Where two branches
    veer, the suspension mode passes from one branch to the other. A branch has the name of its
    mode at the stiffness of the case. Dashed lines are the frequencies with a clamped centre, which
    the branches approach as the stiffness increases. With Coriolis forces the lines of forward
    waves are thin.
    """
    ways = data["branch_direction"].values
    turns = "forward" in ways  # backward and forward waves have different branches
    figure = new_figure(width=FULL_WIDTH if turns else COLUMN_WIDTH, height=0.095)
    frequency, share = (
        data[name].values for name in ("normalised_branch_frequency", "branch_spring_share")
    )
    lowest = max(0.7 * frequency[frequency > 0.0].min(), LOWEST)
    axes, stiffness, own = _stiffness_axes(figure, data, lowest, 1.4 * frequency.max())
    frequency_axis(axes, float(data.attrs["reference_frequency_hz"]))
    look: dict[str, Any] = {"linewidth": 0.8, "zorder": 1}
    at_case: dict[str, Any] = {
        "color": COLOURS["total"],
        "linestyle": ":",
        "label": "the case, black names",
    }
    axes.axvline(own, **at_case, **look)
    for branch, way in enumerate(ways):
        width = 0.7 if way == "forward" else 1.4
        lines = coloured_line(axes, stiffness, frequency[:, branch], share[:, branch], width)
    for level in data["normalised_clamped_frequency"].values:
        label = "clamped centre, grey names"
        axes.axhline(level, color=COLOURS["rest"], linestyle="--", label=label, **look)
    figure.colorbar(
        lines, ax=axes, label="share of energy in the springs [–]", location="top", aspect=30
    )
    if turns:
        for name, width in (("backward", 1.4), ("forward", 0.7)):
            label = f"{name} waves on stiff springs"
            axes.plot([], [], color=COLOURS["total"], linewidth=width, label=label)
    complete(figure, data, f"Modes with k = 1{_at_speed(data)}")
    labels = Labels(axes)
    case = np.clip(own, stiffness[0], stiffness[-1])
    near = np.argsort(np.abs(np.log(stiffness / case)), kind="stable")
    last = "", 0.0
    for branch in np.argsort(frequency[near[0]]):
        named = str(data["branch_family"].values[branch]), float(frequency[near[0], branch])
        if named[0] != last[0] or named[1] > ALIKE * last[1]:
            labels.add(stiffness[near], frequency[near, branch], named[0], COLOURS["total"])
        last = named
    for branch, level in enumerate(data["normalised_clamped_frequency"].values):
        if ways[branch] == "forward":  # close to the backward wave
            continue
        rank = int(np.count_nonzero(ways[:branch] == ways[branch])) + 1
        labels.add(stiffness[::-1], np.full_like(stiffness, level), f"{rank}F", "#555555")
    return figure


@styled
def plot_critical_speeds(data: xr.Dataset) -> Figure:
    """Draw the critical speeds from `bladewhirl.critical_speeds` against the shaft stiffness.

    Colours show the share of the shaft springs in the strain energy. If this share is large, the
    disk moves on its springs, and the critical speed increases with the root of the stiffness; if
    the share is small, the blades bend. Grey lines are stiffness and speed of the case.
    """
    figure = new_figure(width=COLUMN_WIDTH, height=0.09)
    low, high = float(data["critical_speed"].min()), float(data["critical_speed"].max())
    axes, stiffness, own = _stiffness_axes(figure, data, 0.8 * low, 1.25 * high)
    axes.set_ylabel("critical speed [rpm]")
    grey: Any = {"color": COLOURS["rest"], "linewidth": 0.8, "zorder": 1}
    axes.axvline(own, label="stiffness and speed of the case", **grey)
    if data.attrs["case_speed"] > 0.0:
        axes.axhline(data.attrs["case_speed"], **grey)
    for direction in data["direction"].values:
        width = WIDTHS[str(direction)]
        axes.plot([], [], color=COLOURS["total"], linewidth=width, label=direction)
        for branch in data["branch"].values:
            line = {"direction": direction, "branch": branch}
            speed, share = (
                data[name].sel(line).values for name in ("critical_speed", "spring_share")
            )
            if np.isfinite(speed).sum() > 1:
                lines = coloured_line(axes, stiffness, speed, share, width)
    figure.colorbar(
        lines, ax=axes, label="share of energy in the shaft springs [–]", location="top", aspect=30
    )
    complete(figure, data, "Critical speeds against shaft stiffness")
    return figure


def _stiffness_axes(
    figure: Figure, data: xr.Dataset, low: float, high: float
) -> tuple[Axes, FloatArray, float]:
    """Return logarithmic axes against the stiffness of the shaft, the stiffness, and that of the
    case [MN/m]."""
    axes, stiffness = figure.subplots(), 1e-6 * data["stiffness"].values
    axes.set(
        xscale="log",
        xlim=(stiffness[0], stiffness[-1]),
        yscale="log",
        ylim=(low, high),
        xlabel="stiffness of each shaft spring [MN/m]",
    )
    return axes, stiffness, 1e-6 * float(data.attrs["case_stiffness"])


def _at_speed(data: xr.Dataset) -> str:
    """Return the speed as text for the title if the modes depend on the speed; otherwise ""."""
    return f"\nat {speed_label(data)}, rotating frame" if data.attrs["speed"] else ""


def _is(data: xr.Dataset, family: str) -> BoolArray:
    return np.asarray(data["family"].values == family, dtype=np.bool_)


def _draw_family(axes: Axes, data: xr.Dataset, family: str) -> None:
    """Draw frequencies of a family against nodal diameter, with a free and a clamped centre."""
    suspension = family == "suspension"
    for way in _ways(data):
        of_way, thin = ("", 1.0) if way == "both" else (f", {way}", 0.6)
        k, frequency = _chosen(data, "free", family, way)
        x = k + ASIDE.get(way, 0.0)
        if way != "standing":  # only k = 0 and k = half the blades are standing: no line between
            axes.plot(x, frequency, "-", color=COLOURS["rest"], linewidth=0.6, zorder=1)
        mark = "s" if suspension and way == "both" else WAYS[way]
        colour, label = ("suspension", family) if suspension else ("total", f"free{of_way}")
        axes.plot(x, frequency, mark, color=COLOURS[colour], markersize=FREE[way], label=label)
        if not suspension:
            k, frequency = _chosen(data, "clamped", family, way)
            axes.plot(
                k + CLAMPED_ASIDE.get(way, 0.0),
                frequency,
                WAYS[way],
                color=COLOURS["k = 1"],
                markerfacecolor="none",
                markersize=CLAMPED[way],
                markeredgewidth=thin,
                label="clamped centre",
            )


def _name_families(axes: Axes, data: xr.Dataset, families: list[str]) -> None:
    """Name families to the right of the largest nodal diameter, and the suspension at its mark."""
    largest = float(data["nodal_diameter"].values.max())
    heights = {}
    for family in families:
        k = data["nodal_diameter"].values[_is(data, family)]
        frequency = data["normalised_frequency"].values[_is(data, family)]
        last = np.lexsort((-frequency, k))[-1]
        if family == "suspension":
            labels = Labels(axes)
            labels.keep_free(k, frequency)
            labels.add(float(k[last]), float(frequency[last]), family, COLOURS[family], AROUND)
        else:
            heights[family] = float(frequency[last])
    name_ends(axes, largest, [*heights.values()], [*heights], COLOURS["total"], right=True)


def _ways(data: xr.Dataset) -> list[str]:
    """Return the directions of waves to distinguish; "both" alone without Coriolis forces."""
    whirls = "direction" in (data.indexes["mode"].names if "mode" in data.indexes else ())
    return ["backward", "forward", "standing"] if whirls else ["both"]


def _chosen(data: xr.Dataset, centre: str, family: str, way: str) -> tuple[FloatArray, FloatArray]:
    """Return nodal diameters, ascending, and normalised frequencies of a family, for a free or
    clamped centre and one direction of waves."""
    here = (data["centre"].values == centre) & _is(data, family)
    if way != "both":
        here &= data["direction"].values == way
    k, frequency = data["nodal_diameter"].values[here], data["normalised_frequency"].values[here]
    order = np.argsort(k, kind="stable")
    return k[order].astype(np.float64), frequency[order]
