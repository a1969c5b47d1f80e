"""Strain energy of the bladed disk by family and nodal diameter, told in two ways (Figs 17b-22).

* From modal coordinates: every mode carries its own energy (Eq. 22) and the labels of its family
  and nodal diameter, which hold for a stage with like sectors and by majority for another.
* From physical fields: displacements of all nodes are recovered, cut into sectors by turning the
  mesh onto itself, and transformed over the sectors (`models.cyclic.real_dft`). This needs no
  label of a nodal diameter, so it checks them.
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from numpy.typing import NDArray

from bladewhirl.models.elements.cyclic import nodal_diameters
from bladewhirl.postprocess.energy.strain import FIRST_FAMILY, PLOT_DECADES, SUSPENSION
from bladewhirl.postprocess.fields.kinematics import Array, IntArray
from bladewhirl.postprocess.fields.labelled import labelled
from bladewhirl.postprocess.fields.result import portions, reduce_modes
from bladewhirl.postprocess.fields.sectors import sectors
from bladewhirl.postprocess.fields.windows import (
    few_time_ticks,
    in_window,
    span_edges,
    span_means,
    span_starts,
)
from bladewhirl.postprocess.plotting.style import (
    COLOURS,
    SEQUENTIAL,
    new_figure,
    speed_label,
    styled,
)

StrArray = NDArray[np.str_]

PORTION = 1024
"""Records whose fields are recovered at a time."""

SPANS = 300
"""Spans of time that a figure has at most."""

FAMILY_LINES = {
    SUSPENSION: (COLOURS["suspension"], "-"),
    FIRST_FAMILY: (COLOURS["k = 1"], "-"),
    "2F": (COLOURS["k = 0"], "--"),
    "3F": (COLOURS["other k"], "-."),
}
"""Families with a line of their own; the others are drawn together."""


def family_energies(
    result: xr.Dataset, *, start: float | None = None, end: float | None = None
) -> xr.Dataset:
    """Strain energy by the labels of the modes: `energy` (time, family, nodal_diameter) [J].

    Args:
        result: of a run.
        start: of the window [s]; of the run when None.
        end: of the window [s]; of the run when None.

    Example:
        ``family_energies(result)["energy"].sel(family="1F").sum("nodal_diameter").plot()``
    """
    dataset = in_window(result, start, end)
    diameter = dataset["rotor_nodal_diameter"].values
    names, number = _families(dataset)
    diameters, place = np.unique(diameter, return_inverse=True)
    weights = np.zeros((len(names), len(diameters), len(number)))
    weights[number, place, np.arange(len(number))] = 0.5 * dataset["rotor_frequency"].values ** 2
    flat = weights.reshape(-1, len(number))
    energy = reduce_modes(dataset, "rotor_displacement", flat, np.square)
    return _energy_dataset(dataset, energy.reshape(-1, *weights.shape[:2]), names, diameters)


def cyclic_energies(
    result: xr.Dataset, *, start: float | None = None, end: float | None = None
) -> xr.Dataset:
    """Strain energy by a transform of the recovered field: `energy` (time, family,
    nodal_diameter) [J].

    The part of the field with k nodal diameters is brought back to the modes by least squares,
    whose frequencies weigh it. On a stage with like sectors the parts add up to the whole; on
    another, nodal diameters hold energy together too, which belongs to none of them.

    Args:
        result: of a run.
        start: of the window [s]; of the run when None.
        end: of the window [s]; of the run when None.

    Raises:
        ViewError: the mesh has no cyclic symmetry.
    """
    dataset = in_window(result, start, end)
    mesh = sectors(dataset)
    names, number = _families(dataset)
    stiffness = 0.5 * dataset["rotor_frequency"].values ** 2
    in_family = np.eye(len(names))[number] * stiffness[:, None]
    shape = dataset["rotor_shape"].values
    back = np.linalg.pinv(mesh.transform(np.moveaxis(shape, -1, 0)).T)
    rows_of = mesh.nodal_diameter
    diameters = np.array(nodal_diameters(mesh.count))
    energy = np.empty((dataset.sizes["time"], len(names), len(diameters)))
    for portion in portions(dataset, PORTION):
        coordinates = dataset["rotor_displacement"].isel(time=portion).values
        field = coordinates @ shape.reshape(-1, shape.shape[-1]).T
        waves = mesh.transform(field.reshape(-1, *shape.shape[:2]))
        for place, k in enumerate(diameters):
            rows = rows_of == k
            energy[portion, :, place] = (waves[:, rows] @ back[:, rows].T) ** 2 @ in_family
    return _energy_dataset(dataset, energy, names, diameters)


def mean_energies(energies: xr.Dataset, spans: int = SPANS) -> xr.Dataset:
    """Means over up to that many equal spans of time, each at the end of its span.

    Args:
        energies: from `family_energies` or `cyclic_energies`.
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
    """Draw the strain energy by family (lines) and by nodal diameter (map) over time.

    A long run is drawn as means over equal spans of time.

    Args:
        energies: from `family_energies` or `cyclic_energies`.
    """
    energies = mean_energies(energies)
    mean = energies["energy"].values
    edges = np.concatenate([[energies.attrs["begin"]], energies["time"].values])
    figure = new_figure(height=0.095)
    upper, lower = figure.subplots(2, 1, sharex=True)
    by_family = dict(zip(energies["family"].values, mean.sum(axis=2).T, strict=True))
    total = mean.sum(axis=(1, 2))
    other = sum((e for name, e in by_family.items() if name not in FAMILY_LINES), 0.0 * total)
    lines = [("total", total, COLOURS["total"], "-")]
    lines += [(n, by_family[n], *look) for n, look in FAMILY_LINES.items() if n in by_family]
    lines += [("rest", other, COLOURS["rest"], "-")]
    for name, values, colour, style in lines:
        if values.any():
            width = 2.0 if name == "total" else 1.0
            upper.plot(edges[1:], values, style, color=colour, linewidth=width, label=name)
    by_diameter = mean.sum(axis=1)
    top = total.max() or 1.0
    floor = top * 10**-PLOT_DECADES
    upper.set_yscale("log")
    upper.set(ylim=(floor, 3 * top), ylabel="strain energy [J]", title=speed_label(energies))
    picture = lower.pcolormesh(
        edges,
        np.arange(len(energies["nodal_diameter"]) + 1) - 0.5,
        np.maximum(by_diameter.T, floor),
        norm=LogNorm(floor, top),
        cmap=SEQUENTIAL,
        rasterized=True,
    )
    diameters = energies["nodal_diameter"].values
    lower.set_yticks(np.arange(len(diameters))[::2], labels=[str(k) for k in diameters[::2]])
    lower.set(xlabel="time [s]", ylabel="nodal diameter k")
    lower.grid(False)
    few_time_ticks(lower)
    figure.colorbar(picture, ax=lower, label="strain energy [J]", location="bottom", aspect=40)
    figure.legend(*upper.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


def _families(dataset: xr.Dataset) -> tuple[StrArray, IntArray]:
    """Names of the families in order of their lowest mode, and the number of each mode's."""
    names, first, number = np.unique(
        dataset["rotor_family"].values.astype(str), return_index=True, return_inverse=True
    )
    order = np.argsort(first)
    return names[order], np.argsort(order)[number]


def _energy_dataset(
    dataset: xr.Dataset, energy: Array, names: StrArray, diameters: IntArray
) -> xr.Dataset:
    return labelled(
        dataset,
        "strain energy of the bladed disk by family and nodal diameter",
        {"energy": (("time", "family", "nodal_diameter"), energy, "J")},
        {"time": dataset["time"].values, "family": names, "nodal_diameter": diameters},
        begin=float(dataset["time"][0]),
    )
