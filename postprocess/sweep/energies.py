"""Strain energy by family and nodal diameter over a swept key."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure

from bladewhirl.postprocess.energy.strain import (
    FIRST_FAMILY,
    PLOT_DECADES,
    energy_terms,
    term_label,
)
from bladewhirl.postprocess.plotting.axes import decades, draw_map
from bladewhirl.postprocess.plotting.style import COLOURS, styled
from bladewhirl.postprocess.sweep.axes import key_edges
from bladewhirl.postprocess.sweep.dataset import GROUP
from bladewhirl.postprocess.sweep.drawing import DASHES, MARKS, two_columns
from bladewhirl.postprocess.sweep.quantities import along

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
    data = along(dataset, key, ["energy_mean"])
    energy = data["energy_mean"]
    names = energy[GROUP].values.astype(str)
    family = np.char.startswith(names, f"{FIRST_FAMILY} k=")
    diameters = [int(name.partition("=")[2]) for name in names[family]]
    first = energy.isel({GROUP: family}).rename({GROUP: DIAMETER})
    done = data["state"] == "done"
    parts = {
        "suspension": energy.sel({GROUP: "suspension"}, drop=True),
        "first_family": first.assign_coords({DIAMETER: diameters}),
        "rest": energy.sel({GROUP: "rest"}, drop=True),
        "total": energy.sum(GROUP).where(done),
    }
    joule = {"units": "J"}
    return (
        data.drop_vars(["energy_mean", GROUP])
        .assign({name: values.assign_attrs(joule) for name, values in parts.items()})
        .assign_attrs(
            title="mean strain energy of the bladed disk with its shaft springs",
            window=dataset.attrs["window"],
        )
    )


@styled
def plot_point_energies(data: xr.Dataset) -> Figure:
    """Draw energies of suspension, first family and the other modes, and the first family by nodal
    diameter.

    Args:
        data: from `point_energies`.
    """
    top = float(data["total"].max()) or 1.0
    floor = top * 10**-PLOT_DECADES

    def draw_line(left: Axes, right: Axes, one: xr.Dataset) -> QuadMesh:
        _draw_lines(left, one)
        left.set_yscale("log")
        left.set(ylim=(floor, 3 * top), ylabel="strain energy [J]")
        return _draw_diameters(right, one, top)

    return two_columns(data, draw_line, coloured=1, label=f"{FIRST_FAMILY} [J]")


def _draw_lines(axes: Axes, one: xr.Dataset) -> None:
    place = one[str(one.attrs["along"])].values
    for (name, energy), dash, mark in zip(energy_terms(one).items(), DASHES, MARKS, strict=False):
        axes.plot(
            place,
            energy.where(energy > 0),
            linestyle=dash,
            marker=mark,
            color=COLOURS[name],
            linewidth=2.0 if name == "total" else 1.0,
            markersize=3,
            label=term_label(name),
        )


def _draw_diameters(axes: Axes, one: xr.Dataset, top: float) -> QuadMesh:
    diameters = one[DIAMETER].values
    axes.set(ylabel="nodal diameter k")
    axes.locator_params(axis="y", integer=True)
    rows = np.append(diameters, len(diameters)) - 0.5
    energy = np.maximum(one["first_family"].values.T, top * 10**-PLOT_DECADES)
    return draw_map(axes, key_edges(one), rows, energy, norm=decades(top, PLOT_DECADES))
