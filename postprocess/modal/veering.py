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
from bladewhirl.models.modal.labels import LabelledModes
from bladewhirl.postprocess.plotting.style import COLOURS, SEQUENTIAL, new_figure, styled
from bladewhirl.solvers.stability.veering import ShaftVeering

DIAMETER_AXIS = "nodal diameter k [–]"
FREQUENCY_AXIS = "frequency / ω$_1$ [–]"

FEW = 3
"""Up to so many families are drawn with room for a line between them."""


def families_dataset(
    free: LabelledModes, clamped: LabelledModes, *, families: int, reference: float
) -> xr.Dataset:
    """First families of a bladed disk with a free and with a clamped centre, a pair given once.

    Args:
        free: all modes with a free centre.
        clamped: all modes with a clamped one.
        families: how many, the suspension pair apart.
        reference: frequency that others are divided by [rad/s].
    """
    wanted = {"suspension", *(f"{rank}F" for rank in range(1, families + 1))}
    columns: dict[str, list[object]] = {name: [] for name in ("centre", "family", "k", "frequency")}
    for centre, modes in (("free", free), ("clamped", clamped)):
        for mode in modes.one_a_pair():
            if modes.family[mode] in wanted:
                columns["centre"].append(centre)
                columns["family"].append(modes.family[mode])
                columns["k"].append(int(modes.nodal_diameter[mode]))
                columns["frequency"].append(float(modes.frequency[mode]))
    frequency = np.array(columns["frequency"], dtype=np.float64)
    return xr.Dataset(
        {
            "centre": ("mode", np.array(columns["centre"], dtype=object)),
            "family": ("mode", np.array(columns["family"], dtype=object)),
            "nodal_diameter": ("mode", np.array(columns["k"], dtype=np.int64)),
            "frequency": ("mode", frequency, {"units": "rad/s"}),
            "normalised": ("mode", frequency / reference, {"units": "1"}),
        },
        attrs={"title": "veering diagram", "families": families, "reference_frequency": reference},
    )


def shaft_dataset(veering: ShaftVeering, *, reference: float, given: float) -> xr.Dataset:
    """Modes with one nodal diameter over the stiffness of the shaft.

    Args:
        veering: the modes followed.
        reference: frequency that others are divided by [rad/s].
        given: stiffness of the shaft in the case [N/m].
    """
    plane = ("stiffness", "branch")
    return xr.Dataset(
        {
            "frequency": (plane, veering.frequency, {"units": "rad/s"}),
            "normalised": (plane, veering.frequency / reference, {"units": "1"}),
            "spring_share": (
                plane,
                veering.spring_share,
                {"units": "1", "long_name": "share of the strain energy in the shaft springs"},
            ),
            "clamped": ("branch", veering.clamped, {"units": "rad/s"}),
        },
        coords={"stiffness": ("stiffness", veering.stiffness, {"units": "N/m"})},
        attrs={
            "title": "modes with one nodal diameter over shaft stiffness",
            "reference_frequency": reference,
            "case_stiffness": given,
        },
    )


@styled
def plot_families(data: xr.Dataset, families: int | None = None) -> Figure:
    """Draw frequencies over nodal diameter with a free and a clamped centre, Fig. 7.

    Args:
        data: from `families_dataset`.
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
        data: from `shaft_dataset`.
    """
    figure = new_figure(height=0.07)
    axes = figure.subplots()
    stiffness, reference = data["stiffness"].values, float(data.attrs["reference_frequency"])
    for level in data["clamped"].values / reference:
        axes.axhline(level, color=COLOURS["rest"], linestyle="--", linewidth=0.6, zorder=1)
    for branch in range(data.sizes["branch"]):
        lines = _coloured_line(
            axes,
            stiffness,
            data["normalised"].values[:, branch],
            data["spring_share"].values[:, branch],
        )
    axes.axvline(data.attrs["case_stiffness"], color=COLOURS["k = 1"], linewidth=0.8, zorder=1)
    lowest, highest = data["normalised"].values[0, 0], data["normalised"].values[-1, -1]
    axes.set(
        xscale="log",
        xlim=(stiffness[0], stiffness[-1]),
        yscale="log",
        ylim=(0.8 * lowest, 1.3 * highest),
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
    k, frequency = data["nodal_diameter"].values[here], data["normalised"].values[here]
    order = np.argsort(k, kind="stable")
    return k[order].astype(np.float64), frequency[order]


def _joined(parts: list[tuple[FloatArray, FloatArray]]) -> tuple[FloatArray, FloatArray]:
    return np.concatenate([k for k, _ in parts]), np.concatenate([f for _, f in parts])
