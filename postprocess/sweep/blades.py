"""Which blades touch how often over a swept key, and how many are in permanent contact."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure

from bladewhirl.postprocess.plotting.legends import Group, legends_below, set_title
from bladewhirl.postprocess.plotting.style import FULL_WIDTH, SEQUENTIAL, new_figure, styled
from bladewhirl.postprocess.run.blade_contact import CLASS_COLOURS, CLASS_HATCHES, PERMANENT
from bladewhirl.postprocess.sweep.axes import in_handy_units, is_wide, key_axis
from bladewhirl.postprocess.sweep.drawing import chosen, left_out_note, panel_titles, panels_note
from bladewhirl.postprocess.sweep.quantities import LINE, along, cell_edges

MOST_ROWS = 4
"""Lines in a figure that has a row for each."""


def blade_contacts(dataset: xr.Dataset, key: str) -> xr.Dataset:
    """Share of the last third in contact of each blade, and how many blades are of each class.

    Args:
        dataset: from `open_sweep`.
        key: dimension to go along.

    Returns:
        over (line, key): `late_contact_share` (..., blade), nan for blades that a point has not;
        `permanent` (99 % or more), `intermittent` and `free` (never), numbers of blades.
    """
    found = along(dataset, key, ["late_contact_share"])
    share = found["late_contact_share"]
    classes = {
        "permanent": share >= PERMANENT,
        "intermittent": (share > 0) & (share < PERMANENT),
        "free": share == 0,
    }
    counts = {
        name: own.sum("blade").where(found["state"] == "done").assign_attrs(units="1")
        for name, own in classes.items()
    }
    return found.assign(counts).assign_attrs(
        title="contact of the blades in the last third of each march"
    )


@styled
def plot_blade_contacts(found: xr.Dataset) -> Figure:
    """Draw each blade's share of the time in contact, grey where it is none, and the
    numbers of blades of each class.

    Args:
        found: from `blade_contacts`.
    """
    found = in_handy_units(found)
    titles = panel_titles(found)
    shown = chosen(found.sizes[LINE], MOST_ROWS)
    figure = new_figure(width=FULL_WIDTH, height=0.02 + 0.05 * len(shown))
    figure.set_layout_engine("constrained", wspace=0.08)
    rows = figure.subplots(len(shown), 2, sharex=True, sharey="col", squeeze=False)
    for number, (left, right) in zip(shown, rows, strict=True):
        one = found.isel({LINE: number})
        picture = _draw_shares(left, one)
        _draw_counts(right, one)
        if titles[number]:
            left.set_title(titles[number], loc="left")
    for axes in rows[-1]:
        key_axis(axes, found, cells=True, share=0.5)
    figure.colorbar(picture, ax=rows[:, 0].tolist(), label="time in contact [%]", pad=0.02)
    note = left_out_note(found.sizes[LINE], MOST_ROWS) + panels_note(found, "rows")
    set_title(figure, found.attrs["title"] + note)
    entries = zip(*rows[0, 1].get_legend_handles_labels(), strict=True)
    legends_below(figure, Group(list(entries)))
    return figure


def _draw_shares(axes: Axes, one: xr.Dataset) -> QuadMesh:
    place = one[str(one.attrs["along"])].values
    edges = cell_edges(place, logarithmic=is_wide(place))
    blades = np.arange(one.sizes["blade"] + 1) - 0.5
    share = 100 * one["late_contact_share"].values.T
    axes.grid(False)
    axes.set(ylabel="blade")
    axes.locator_params(axis="y", integer=True)
    free = np.ma.masked_not_equal(share, 0.0)
    grey = ListedColormap([CLASS_COLOURS["free"]])
    axes.pcolormesh(edges, blades, free, cmap=grey, rasterized=True)
    return axes.pcolormesh(
        edges,
        blades,
        np.ma.masked_equal(share, 0.0),
        cmap=SEQUENTIAL,
        vmin=0.0,
        vmax=100.0,
        rasterized=True,
    )


def _draw_counts(axes: Axes, one: xr.Dataset) -> None:
    """Numbers of blades, stacked; a gap where a point has no result."""
    place = one[str(one.attrs["along"])].values
    edges = cell_edges(place, logarithmic=is_wide(place))
    below = np.zeros(len(place))
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
    axes.set(ylabel="blades", ylim=(0, one.sizes["blade"]))
    axes.locator_params(axis="y", integer=True)
    axes.grid(False)
