"""Strain energy of the bladed disk by groups of modes (the paper's Figs 17b to 22).

The groups are the suspension, the first blade family and all other modes. A mode belongs to a group
by its labels, family and nodal diameter. The labels are exact for a stage with equal sectors;
otherwise they name the largest part of the motion of the mode.
"""

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from bladewhirl.meshes.line_mesh import BoolArray
from bladewhirl.postprocess.fields import windows
from bladewhirl.postprocess.fields.kinematics import Array, IntArray
from bladewhirl.postprocess.fields.labelled import labelled
from bladewhirl.postprocess.fields.lost_blades import lost_blades
from bladewhirl.postprocess.fields.netcdf import has
from bladewhirl.postprocess.fields.result import reduce_modes
from bladewhirl.postprocess.plotting.axes import draw_decades
from bladewhirl.postprocess.plotting.legends import Group, legends_below
from bladewhirl.postprocess.plotting.style import COLOURS, new_figure, styled, time_axis
from bladewhirl.postprocess.plotting.titles import head

SUSPENSION = "suspension"
FIRST_FAMILY = "1F"

SMOOTHED_PERIODS = 30.0
"""The energies of a run longer than this number of periods of the reference frequency are drawn as
means, because the oscillations would fill the figure."""

PLOT_POINTS = 300  #: largest number of drawn means in a curve

SPANS = 300  #: largest number of time spans in the figure by families
NONE = "0.92"  #: grey of cells without energy, or without a mode
ROW = 0.004  #: height of the row of a family in a figure [m]
PLOT_DECADES = 6.0  #: number of decades that the plot shows below the largest energy


def strain_energies(
    result: xr.Dataset, *, start: float | None = None, end: float | None = None
) -> xr.Dataset:
    """Compute the strain energy of the bladed disk with its shaft springs, or of a shaft line with
    its bearings, over time, by groups of modes.

    In mass-normalised modes 1/2 x^T K x = sum of 1/2 omega_i^2 q_i^2 (the paper's Eq. 22), so each
    mode has its own share and the groups add up to the total.

    Args:
        result: result of a run; it is read portion by portion.
        start, end: limits of the time window [s]; start and end of the run when None.

    Returns:
        energies [J] over time: `suspension`, the modes in which the body moves on the shaft
        springs; `rest`, the modes in no other group; `total`. Over (time, nodal_diameter):
        `first_family`, the first blade family, which has no nodal diameter if modes are not named.

    Example:
        ``strain_energies(result)["first_family"].sel(nodal_diameter=1).plot()``
    """
    result = windows.in_window(result, start, end)
    energy, diameters = group_energies(result)
    variables: dict[str, Any] = {
        "suspension": ("time", energy[:, 0], "J"),
        "first_family": (("time", "nodal_diameter"), energy[:, 1:-1], "J"),
        "rest": ("time", energy[:, -1], "J"),
        "total": ("time", energy.sum(axis=1), "J"),
    }
    coordinates = {"time": result["time"].values, "nodal_diameter": diameters}
    title = "strain energy of the bladed disk with its shaft springs"
    return labelled(result, title, variables, coordinates)


def group_energies(result: xr.Dataset) -> tuple[Array, IntArray]:
    """Return the strain energy of each group of modes [J], (time, groups), and the nodal diameters
    of the first blade family, (groups - 2,).

    The first group is the suspension, the last group all other modes: all modes if a stage does not
    name them, and a shaft line with its bearings. Between them the first blade family has a group
    for each nodal diameter. After a loss of blades, or after a support has fused, the
    sum is the strain energy of what remains; the groups are those of the modes before, and the last
    group has the rest.
    """
    stage = result.variables
    family, diameter = stage["rotor_family"].values, stage["rotor_nodal_diameter"].values
    first = family == FIRST_FAMILY
    diameters = np.unique(diameter[first])
    groups = [family == SUSPENSION, *(first & (diameter == k) for k in diameters)]
    groups.append(~np.logical_or.reduce(groups))
    weights = 0.5 * stage["rotor_frequency"].values ** 2 * np.array(groups, dtype=float)
    energy = reduce_modes(result, "rotor_displacement", weights, np.square)
    if has(result, "line"):
        energy[:, -1] = stage["line_energy"].values
    if has(result, "changes"):
        changed = _changed(result)
        total = stage["strain_energy"].values[changed]
        energy[changed, -1] = total - energy[changed, :-1].sum(axis=1)
    return energy, diameters


def _changed(result: xr.Dataset) -> BoolArray:
    """Return whether blades are lost or the support has fused at every record, (time,)."""
    time, lost = result.variables["time"].values, lost_blades(result)
    changed = time > float(result.attrs.get("fuse_time", np.inf))
    return np.asarray(changed if lost is None else changed | lost.gone(time))


def energy_terms(energies: xr.Dataset) -> dict[str, xr.DataArray]:
    """Return the energies that are drawn [J], by their names in `COLOURS`, the total first.

    All nodal diameters of the first family except 0 and 1 are added together. Without families of
    modes there is only the total. `energies` has the variables of `strain_energies`.
    """
    family = energies["first_family"]
    if not family.size:
        return {"total": energies["total"]}
    k = family["nodal_diameter"].values
    members = {"k = 0": k == 0, "k = 1": k == 1, "other k": (k != 0) & (k != 1)}
    return {
        "total": energies["total"],
        "suspension": energies["suspension"],
        **{
            name: family.isel(nodal_diameter=chosen).sum("nodal_diameter")
            for name, chosen in members.items()
        },
        "rest": energies["rest"],
    }


def term_label(name: str) -> str:
    """Return the label of a term of `energy_terms` in a legend."""
    return f"{FIRST_FAMILY}, {name}" if "k" in name.split() else name


@styled
def plot_energy(energies: xr.Dataset) -> Figure:
    """Draw the strain energies over time on a logarithmic axis, from `strain_energies`.

    All nodal diameters except 0 and 1 are added together, as in the paper's Figs 17(b) and 22. Long
    runs are drawn as means over a period of the reference frequency or more; the title states the
    averaging time. The axis begins a decade below the smallest median of all terms, at most six
    decades below the largest energy; smaller terms are left out.
    """
    terms = {name: energy.values for name, energy in energy_terms(energies).items()}
    time = energies["time"].values
    periods = np.ptp(time) / (2 * np.pi / energies.attrs["reference_frequency"])
    means = int(min(periods, PLOT_POINTS)) if periods > SMOOTHED_PERIODS else len(time)
    first = windows.span_starts(time, means)  # the first record of each drawn point
    figure = new_figure(height=0.062)
    axes = figure.add_subplot()
    top = float(terms["total"].max())
    usual = [float(np.median(energy)) for energy in terms.values()]
    floor = max([top * 10**-PLOT_DECADES, 0.1 * min([top, *filter(None, usual)])])
    for name, energy in terms.items():
        if energy.max() > floor:
            axes.plot(
                windows.span_means(time, first),
                windows.span_means(energy, first),
                color=COLOURS[name],
                linewidth=2.0 if name == "total" else 1.0,
                label=term_label(name),
            )
    if top > 0:
        axes.set_yscale("log")
        axes.set_ylim(floor, top * 3)
        figure.legend(loc="outside lower center", ncols=3)
    axes.set_ylabel("strain energy [J]")
    time_axis(axes)
    mean = f"means over {1e3 * np.ptp(time) / len(first):.3g} ms"
    head(figure, energies, *([mean] if len(first) < len(time) else []))
    return figure


def family_energies(
    result: xr.Dataset, *, start: float | None = None, end: float | None = None
) -> xr.Dataset:
    """Compute the strain energy of the bladed disk, `energy` (time, family, nodal_diameter) [J];
    nan after the loss of blades, or after a support has fused, as the families are those of the
    modes before.

    Args:
        result: result of a run.
        start, end: limits of the time window [s]; start and end of the run when None.

    Example:
        ``family_energies(result)["energy"].sel(family="1F").sum("nodal_diameter").plot()``
    """
    dataset = windows.in_window(result, start, end)
    names, first, number = np.unique(
        dataset["rotor_family"].values.astype(str), return_index=True, return_inverse=True
    )
    order = np.argsort(first)  # families in the order of their lowest modes
    diameters, place = np.unique(dataset["rotor_nodal_diameter"].values, return_inverse=True)
    weights = np.zeros((len(names), len(diameters), len(number)))
    weights[np.argsort(order)[number], place, np.arange(len(number))] = (
        0.5 * dataset["rotor_frequency"].values ** 2
    )
    flat = weights.reshape(-1, len(number))
    energy = reduce_modes(dataset, "rotor_displacement", flat, np.square)
    cells = energy.reshape(-1, *weights.shape[:2])
    cells[_changed(dataset)] = np.nan
    return labelled(
        dataset,
        "strain energy of the bladed disk by family and nodal diameter",
        {"energy": (("time", "family", "nodal_diameter"), cells, "J")},
        {"time": dataset["time"].values, "family": names[order], "nodal_diameter": diameters},
        begin=float(dataset["time"][0]),
    )


def mean_energies(result: xr.Dataset) -> xr.Dataset:
    """Compute the means of `family_energies` over up to `SPANS` equal spans of time; `time` is the
    end of each span. Up to `SPANS` records are not averaged."""
    energies = family_energies(result)
    time = energies["time"].values
    starts = windows.span_starts(time, SPANS)
    means = windows.span_means(energies["energy"].values, starts)
    ends = windows.span_edges(time, starts, energies.attrs["begin"])[1:]
    thinned = energies.isel(time=slice(len(ends))).assign_coords(
        time=("time", ends, energies["time"].attrs)
    )
    return thinned.assign(energy=(energies["energy"].dims, means, {"units": "J"}))


@styled
def plot_family_energies(energies: xr.Dataset) -> Figure:
    """Draw two maps of the strain energy from `mean_energies`: by time and nodal diameter, and by
    family and nodal diameter. The second map shows the mean over the last third of the time with
    known energies."""
    late = windows.late_part(energies.dropna("time"))
    by_diameter = energies["energy"].sum("family")
    by_both = late["energy"].mean("time")
    diameters, families = energies["nodal_diameter"].values, energies["family"].values
    columns, rows = np.arange(len(diameters)), np.arange(len(families))
    scale = float(by_diameter.max()) or 1.0, PLOT_DECADES
    figure = new_figure(height=0.075 + ROW * len(rows))
    upper, lower = figure.subplots(2, 1, height_ratios=[0.03, ROW * len(rows)])
    edges = np.concatenate([[energies.attrs["begin"]], energies["time"].values])
    positive = [np.ma.masked_less_equal(e.values, 0.0) for e in (by_diameter, by_both)]
    drawn = draw_decades(upper, edges, columns, positive[0].T, scale)
    upper.set_ylabel("nodal diameter k")
    upper.set_yticks(columns[::2], labels=[str(k) for k in diameters[::2]])
    time_axis(upper)
    draw_decades(lower, columns, rows, positive[1], scale)
    lower.set(xlabel="nodal diameter k", title=f"by family, mean over {windows.window_label(late)}")
    lower.set_xticks(columns, labels=[str(k) for k in diameters])
    lower.set_yticks(rows, labels=list(families))
    for axes in (upper, lower):
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
