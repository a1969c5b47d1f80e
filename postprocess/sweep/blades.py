"""Contact of each blade over a swept key, and the number of blades in permanent contact."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure

from bladewhirl.postprocess.plotting.axes import draw_map
from bladewhirl.postprocess.plotting.style import styled
from bladewhirl.postprocess.run.blade_contact import CLASS_COLOURS, CLASS_HATCHES, PERMANENT
from bladewhirl.postprocess.sweep.axes import key_edges
from bladewhirl.postprocess.sweep.drawing import two_columns
from bladewhirl.postprocess.sweep.quantities import along
from bladewhirl.postprocess.sweep.regimes import HATCH


def blade_contacts(dataset: xr.Dataset, key: str) -> xr.Dataset:
    """Share of the last third in contact of each blade, and how many blades are of each class.

    Args:
        dataset: from `open_sweep`.
        key: dimension to go along.

    Returns:
        over (line, key): `late_contact_share` (..., blade), nan for blades that a point has not;
        `permanent` (99 % or more), `intermittent` and `free` (never), numbers of blades.
    """
    data = along(dataset, key, ["late_contact_share"])
    share = data["late_contact_share"]
    classes = {
        "permanent": share >= PERMANENT,
        "intermittent": (share > 0) & (share < PERMANENT),
        "free": share == 0,
    }
    counts = {
        name: members.sum("blade").where(data["state"] == "done").assign_attrs(units="1")
        for name, members in classes.items()
    }
    return data.assign(counts).assign_attrs(
        title="contact of the blades in the last third of each march"
    )


@styled
def plot_blade_contacts(data: xr.Dataset) -> Figure:
    """Draw each blade's share of the time in contact, white for zero, and the number of blades of
    each class.

    Args:
        data: from `blade_contacts`.
    """
    return two_columns(data, _draw_line, coloured=0, label="time in contact [%], white: none")


def _draw_line(left: Axes, right: Axes, one: xr.Dataset) -> QuadMesh:
    _draw_counts(right, one)
    return _draw_shares(left, one)


def _draw_shares(axes: Axes, one: xr.Dataset) -> QuadMesh:
    edges = key_edges(one)
    blades = np.arange(one.sizes["blade"] + 1) - 0.5
    share = 100 * one["late_contact_share"].values.T
    axes.set(ylabel="blade, by its number")
    axes.locator_params(axis="y", integer=True)
    free = np.ma.masked_not_equal(share, 0.0)
    draw_map(axes, edges, blades, free, cmap=ListedColormap(["white"]))
    axes.patch.set(hatch=HATCH, edgecolor=CLASS_COLOURS["free"])  # where there is no result
    touching = np.ma.masked_equal(share, 0.0)
    return draw_map(axes, edges, blades, touching, vmin=0.0, vmax=100.0)


def _draw_counts(axes: Axes, one: xr.Dataset) -> None:
    """Numbers of blades, stacked; a gap where a point has no result."""
    edges = key_edges(one)
    below = np.zeros(len(edges) - 1)
    for name, colour in CLASS_COLOURS.items():
        count = one[name].fillna(0.0).values
        axes.bar(
            edges[:-1],
            count,
            np.diff(edges),
            below,
            align="edge",
            color=colour,
            hatch=CLASS_HATCHES[name],
            edgecolor="white",
            linewidth=0.0,
            label=name,
        )
        below = below + count
    axes.set(ylabel="number of blades", ylim=(0, one.sizes["blade"]))
    axes.locator_params(axis="y", integer=True)
    axes.grid(False)
