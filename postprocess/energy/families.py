"""Strain energy of the bladed disk by family and nodal diameter (Figs 17b-22).

Every mode carries its own energy (Eq. 22) and the labels of its family and nodal diameter, which
hold for a stage with like sectors and by majority for another.
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from bladewhirl.postprocess.energy.strain import PLOT_DECADES
from bladewhirl.postprocess.fields.labelled import labelled
from bladewhirl.postprocess.fields.result import reduce_modes
from bladewhirl.postprocess.fields.windows import (
    in_window,
    late_part,
    span_edges,
    span_means,
    span_starts,
    window_label,
)
from bladewhirl.postprocess.plotting.legends import Group, legends_below
from bladewhirl.postprocess.plotting.style import SEQUENTIAL, new_figure, styled, time_axis
from bladewhirl.postprocess.plotting.titles import head

SPANS = 300  #: spans of time that a figure has at most
NONE = "0.92"  #: grey where there is no energy at all, or no such mode


def family_energies(
    result: xr.Dataset, *, start: float | None = None, end: float | None = None
) -> xr.Dataset:
    """Strain energy by the labels of the modes: `energy` (time, family, nodal_diameter) [J].

    Args:
        result: of a run.
        start, end: limits of the window [s]; those of the run when None.

    Example:
        ``family_energies(result)["energy"].sel(family="1F").sum("nodal_diameter").plot()``
    """
    dataset = in_window(result, start, end)
    names, first, number = np.unique(
        dataset["rotor_family"].values.astype(str), return_index=True, return_inverse=True
    )
    order = np.argsort(first)  # of their lowest modes
    diameters, place = np.unique(dataset["rotor_nodal_diameter"].values, return_inverse=True)
    weights = np.zeros((len(names), len(diameters), len(number)))
    weights[np.argsort(order)[number], place, np.arange(len(number))] = (
        0.5 * dataset["rotor_frequency"].values ** 2
    )
    flat = weights.reshape(-1, len(number))
    energy = reduce_modes(dataset, "rotor_displacement", flat, np.square)
    cells = energy.reshape(-1, *weights.shape[:2])
    return labelled(
        dataset,
        "strain energy of the bladed disk by family and nodal diameter",
        {"energy": (("time", "family", "nodal_diameter"), cells, "J")},
        {"time": dataset["time"].values, "family": names[order], "nodal_diameter": diameters},
        begin=float(dataset["time"][0]),
    )


def mean_energies(energies: xr.Dataset, spans: int = SPANS) -> xr.Dataset:
    """Means over up to that many equal spans of time, each at the end of its span.

    Args:
        energies: from `family_energies`.
        spans: at most; the records themselves where they are fewer.
    """
    time = energies["time"].values
    starts = span_starts(time, spans)
    means = span_means(energies["energy"].values, starts)
    ends = span_edges(time, starts, energies.attrs["begin"])[1:]
    thinned = energies.isel(time=slice(len(ends))).assign_coords(
        time=("time", ends, energies["time"].attrs)
    )
    return thinned.assign(energy=(energies["energy"].dims, means, {"units": "J"}))


@styled
def plot_family_energies(energies: xr.Dataset) -> Figure:
    """Draw the strain energy by nodal diameter over time, and by family over nodal diameter, mean
    over the last third.

    A long run is drawn as means over equal spans of time.

    Args:
        energies: from `family_energies`.
    """
    energies = mean_energies(energies)
    late = late_part(energies)
    by_diameter = energies["energy"].sum("family")
    by_both = late["energy"].mean("time")
    diameters, families = energies["nodal_diameter"].values, energies["family"].values
    columns, rows = np.arange(len(diameters)), np.arange(len(families))
    top = float(by_diameter.max()) or 1.0
    look = {"norm": LogNorm(top * 10**-PLOT_DECADES, top), "cmap": SEQUENTIAL}
    figure = new_figure(height=0.1)
    upper, lower = figure.subplots(2, 1)
    edges = np.concatenate([[energies.attrs["begin"]], energies["time"].values])
    place = np.arange(len(diameters) + 1) - 0.5
    drawn = upper.pcolormesh(edges, place, _shown(by_diameter.values.T), rasterized=True, **look)
    upper.set_ylabel("nodal diameter k")
    upper.set_yticks(columns[::2], labels=[str(k) for k in diameters[::2]])
    time_axis(upper)
    lower.pcolormesh(columns, rows, _shown(by_both.values), **look)
    lower.set(xlabel="nodal diameter k", title=f"by family, mean over {window_label(late)}")
    lower.set_xticks(columns, labels=[str(k) for k in diameters])
    lower.set_yticks(rows, labels=list(families))
    for axes in (upper, lower):
        axes.grid(False)
        axes.set_facecolor(NONE)
    figure.colorbar(
        drawn,
        ax=[upper, lower],
        label="strain energy [J]",
        location="bottom",
        aspect=40,
        extend="min",
    )
    head(figure, energies)
    if min(float(by_diameter.min()), float(by_both.min())) <= 0.0:
        legends_below(
            figure, Group([(Patch(facecolor=NONE, edgecolor="0.6"), "none, or no such mode")])
        )
    return figure


def _shown(energy: np.ndarray) -> np.ndarray:
    """Mask values that a logarithmic scale cannot show."""
    return np.ma.masked_less_equal(energy, 0.0)
