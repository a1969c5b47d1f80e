"""Frequencies over nodal diameter (Fig. 7) and over the stiffness of the shaft."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.postprocess.plotting.style import COLOURS, SEQUENTIAL, new_figure, styled

DIAMETER_AXIS = "nodal diameter k [–]"
FREQUENCY_AXIS = "frequency / ω$_1$ [–]"

FEW = 3
"""Up to so many families are drawn with room for a line between them."""


@styled
def plot_families(data: xr.Dataset, families: int | None = None) -> Figure:
    """Draw frequencies over nodal diameter with a free and a clamped centre, Fig. 7.

    Args:
        data: from `veering`.
        families: how many of those it has; the suspension pair is drawn where it lies below the
            highest of them. All when None.
    """
    families = families or int(data.attrs["families"])
    figure = new_figure(height=0.065 if families <= FEW else 0.08)
    axes = figure.subplots()
    names = [f"{rank}F" for rank in range(1, families + 1)]
    for name in names:
        free = _chosen(data, "free", name)
        axes.plot(*free, "-", color=COLOURS["rest"], linewidth=0.6, zorder=1)
    every = [_chosen(data, "free", name) for name in names]
    top = max(float(frequency.max(initial=0.0)) for _, frequency in every)
    dot: Mapping[str, Any] = {"linestyle": "none", "markersize": 3.0}
    axes.plot(*_joined(every), "o", color=COLOURS["total"], label="free centre", **dot)
    clamped = _joined([_chosen(data, "clamped", name) for name in names])
    ring: Mapping[str, Any] = {"linestyle": "none", "markersize": 5.0, "markerfacecolor": "none"}
    axes.plot(*clamped, "o", color=COLOURS["k = 1"], label="clamped centre", **ring)
    suspension = _chosen(data, "free", "suspension")
    if suspension[1].size and suspension[1].min() < top:
        if families <= FEW:
            axes.axhline(suspension[1][0], color=COLOURS["suspension"], linestyle="--", zorder=1)
        axes.plot(*suspension, "s", color=COLOURS["suspension"], label="suspension", **dot)
    axes.set(xlabel=DIAMETER_AXIS, ylabel=FREQUENCY_AXIS, ylim=(-0.03 * top, 1.06 * top))
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    figure.legend(loc="outside upper center", ncols=3)
    return figure


@styled
def plot_shaft_veering(data: xr.Dataset) -> Figure:
    """Draw the modes with one nodal diameter over the stiffness of the shaft.

    Colours show how much of a mode's energy the springs hold: the suspension mode hands its
    character from branch to branch where they veer. Dashes are the frequencies of a clamped
    centre, which each branch approaches.

    Args:
        data: from `veering`.
    """
    figure = new_figure(height=0.07)
    axes = figure.subplots()
    stiffness = data["stiffness"].values
    frequency, share = (
        data[name].values for name in ("normalised_branch_frequency", "branch_spring_share")
    )
    for level in data["normalised_clamped_frequency"].values:
        axes.axhline(level, color=COLOURS["rest"], linestyle="--", linewidth=0.6, zorder=1)
    for branch in range(data.sizes["branch"]):
        lines = _coloured_line(axes, stiffness, frequency[:, branch], share[:, branch])
    axes.axvline(data.attrs["case_stiffness"], color=COLOURS["k = 1"], linewidth=0.8, zorder=1)
    axes.set(
        xscale="log",
        xlim=(stiffness[0], stiffness[-1]),
        yscale="log",
        ylim=(0.8 * frequency[0, 0], 1.3 * frequency[-1, -1]),
        xlabel="stiffness of each shaft spring [N/m]",
        ylabel=FREQUENCY_AXIS,
    )
    figure.colorbar(lines, ax=axes, label="energy in the springs [–]", pad=0.02)
    handles = [
        Line2D([], [], color=COLOURS["k = 1"], linewidth=0.8, label="the case"),
        Line2D([], [], color=COLOURS["rest"], linestyle="--", label="clamped centre"),
    ]
    figure.legend(handles=handles, loc="outside upper center", ncols=2)
    return figure


def _coloured_line(axes: Axes, x: FloatArray, y: FloatArray, value: FloatArray) -> LineCollection:
    points = np.column_stack([x, y])
    lines = LineCollection(
        [*np.stack([points[:-1], points[1:]], axis=1)],
        cmap=SEQUENTIAL,
        norm=Normalize(0.0, 1.0),
        linewidth=1.4,
        capstyle="round",
    )
    lines.set_array(0.5 * (value[1:] + value[:-1]))
    axes.add_collection(lines)
    return lines


def _chosen(data: xr.Dataset, centre: str, family: str) -> tuple[FloatArray, FloatArray]:
    """Nodal diameters and normalised frequencies of a family, in ascending nodal diameter."""
    here = (data["centre"].values == centre) & (data["family"].values == family)
    k, frequency = data["nodal_diameter"].values[here], data["normalised_frequency"].values[here]
    order = np.argsort(k, kind="stable")
    return k[order].astype(np.float64), frequency[order]


def _joined(parts: list[tuple[FloatArray, FloatArray]]) -> tuple[FloatArray, FloatArray]:
    return np.concatenate([k for k, _ in parts]), np.concatenate([f for _, f in parts])
