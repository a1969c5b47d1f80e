"""Strain energy by family and nodal diameter over a swept key."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from numpy.typing import NDArray

from bladewhirl.postprocess.plotting.legends import Group, legends_below, set_title
from bladewhirl.postprocess.plotting.style import (
    COLOURS,
    FULL_WIDTH,
    SEQUENTIAL,
    new_figure,
    styled,
)
from bladewhirl.postprocess.run.energies import FIRST_FAMILY, PLOT_DECADES
from bladewhirl.postprocess.sweep.axes import in_handy_units, is_wide, key_axis
from bladewhirl.postprocess.sweep.blades import MOST_ROWS
from bladewhirl.postprocess.sweep.dataset import GROUP
from bladewhirl.postprocess.sweep.drawing import (
    DASHES,
    MARKS,
    chosen,
    left_out_note,
    panel_titles,
    panels_note,
)
from bladewhirl.postprocess.sweep.quantities import LINE, along, cell_edges

DIAMETER = "nodal_diameter"


def point_energies(dataset: xr.Dataset, key: str) -> xr.Dataset:
    """Mean strain energy [J] of the bladed disk over the window of the spectra.

    Args:
        dataset: from `open_sweep`.
        key: dimension to go along.

    Returns:
        over (line, key): `suspension`; `first_family` (..., nodal_diameter); `rest`; `total`. A
        nodal diameter that a point's stage has not is nan.
    """
    found = along(dataset, key, ["energy_mean"])
    energy = found["energy_mean"]
    names = energy[GROUP].values.astype(str)
    family = np.char.startswith(names, f"{FIRST_FAMILY} k=")
    diameters = [int(name.partition("=")[2]) for name in names[family]]
    first = energy.isel({GROUP: family}).rename({GROUP: DIAMETER})
    done = found["state"] == "done"
    parts = {
        "suspension": energy.sel({GROUP: "suspension"}, drop=True),
        "first_family": first.assign_coords({DIAMETER: diameters}),
        "rest": energy.sel({GROUP: "rest"}, drop=True),
        "total": energy.sum(GROUP).where(done),
    }
    joule = {"units": "J"}
    return (
        found.drop_vars(["energy_mean", GROUP])
        .assign({name: values.assign_attrs(joule) for name, values in parts.items()})
        .assign_attrs(
            title="mean strain energy of the bladed disk with its shaft springs",
            window=dataset.attrs["window"],
        )
    )


@styled
def plot_point_energies(found: xr.Dataset) -> Figure:
    """Draw energies of suspension, first family and rest, and the first family by nodal diameter.

    Args:
        found: from `point_energies`.
    """
    found = in_handy_units(found)
    titles = panel_titles(found)
    shown = chosen(found.sizes[LINE], MOST_ROWS)
    top = float(found["total"].max()) or 1.0
    floor = top * 10**-PLOT_DECADES
    figure = new_figure(width=FULL_WIDTH, height=0.02 + 0.05 * len(shown))
    figure.set_layout_engine("constrained", wspace=0.08)
    rows = figure.subplots(len(shown), 2, sharex=True, sharey="col", squeeze=False)
    for number, (left, right) in zip(shown, rows, strict=True):
        one = found.isel({LINE: number})
        _draw_lines(left, one)
        left.set_yscale("log")
        left.set(ylim=(floor, 3 * top), ylabel="strain energy [J]")
        picture = _draw_diameters(right, one, floor, top)
        if titles[number]:
            left.set_title(titles[number], loc="left")
    for axes in rows[-1]:
        key_axis(axes, found, cells=True, share=0.5)
    figure.colorbar(picture, ax=rows[:, 1].tolist(), label=f"{FIRST_FAMILY} [J]", pad=0.02)
    note = left_out_note(found.sizes[LINE], MOST_ROWS) + panels_note(found, "rows")
    set_title(figure, found.attrs["title"] + note)
    entries = zip(*rows[0, 0].get_legend_handles_labels(), strict=True)
    legends_below(figure, Group(list(entries)))
    return figure


def _draw_lines(axes: Axes, one: xr.Dataset) -> None:
    place = one[str(one.attrs["along"])].values
    family = one["first_family"]
    diameter = family[DIAMETER].values

    def of(own: NDArray[np.bool_]) -> NDArray[np.float64]:
        return np.asarray(np.nansum(family.values[:, own], axis=1))

    lines = [("total", "total", one["total"].values)]
    lines += [("suspension", "suspension", one["suspension"].values)]
    lines += [(f"{FIRST_FAMILY}, k = {k}", f"k = {k}", of(diameter == k)) for k in (0, 1)]
    lines += [(f"{FIRST_FAMILY}, other k", "other k", of(diameter > 1))]
    lines += [("rest", "rest", one["rest"].values)]
    for (label, colour, energy), dash, mark in zip(
        lines, DASHES[: len(lines)], MARKS[: len(lines)], strict=True
    ):
        axes.plot(
            place,
            np.where(energy > 0, energy, np.nan),
            linestyle=dash,
            marker=mark,
            color=COLOURS[colour],
            linewidth=2.0 if label == "total" else 1.0,
            markersize=4.5 if label == "total" else 3,
            label=label,
        )


def _draw_diameters(axes: Axes, one: xr.Dataset, floor: float, top: float) -> QuadMesh:
    place = one[str(one.attrs["along"])].values
    edges = cell_edges(place, logarithmic=is_wide(place))
    diameters = one[DIAMETER].values
    energy = one["first_family"].values.T
    axes.grid(False)
    axes.set(ylabel="nodal diameter k")
    axes.locator_params(axis="y", integer=True)
    return axes.pcolormesh(
        edges,
        np.append(diameters, len(diameters)) - 0.5,
        np.maximum(energy, floor),
        norm=LogNorm(floor, top),
        cmap=SEQUENTIAL,
        rasterized=True,
    )
