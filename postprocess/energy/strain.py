"""Strain energy of the bladed disk: in suspension, first blade family, the rest."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from bladewhirl.postprocess.fields.kinematics import Array, IntArray
from bladewhirl.postprocess.fields.labelled import labelled
from bladewhirl.postprocess.fields.result import reduce_modes
from bladewhirl.postprocess.fields.windows import in_window, span_means, span_starts
from bladewhirl.postprocess.plotting.style import COLOURS, new_figure, styled, time_axis
from bladewhirl.postprocess.plotting.titles import head

SUSPENSION = "suspension"
FIRST_FAMILY = "1F"

SMOOTHED_PERIODS = 30.0
"""Number of reference periods above which means are drawn: the ripple would fill the figure."""

PLOT_POINTS = 300  #: points of a line of means at most

PLOT_DECADES = 6.0  #: decades below the largest energy that the plot shows


def strain_energies(
    result: xr.Dataset, *, start: float | None = None, end: float | None = None
) -> xr.Dataset:
    """Strain energy of the bladed disk with its shaft springs over time, by groups of modes.

    In mass-normalised modes 1/2 x^T K x = sum of 1/2 omega_i^2 q_i^2 (the paper's Eq. 22), so each
    mode has its own share and the groups add up to the whole.

    Args:
        result: of a run; it is read portion by portion.
        start, end: limits of the window [s]; those of the run when None.

    Returns:
        [J] over time: `suspension`, the modes that the shaft springs hold; `rest`, all that are in
        no other group; `total`. Over (time, nodal_diameter): `first_family`, the first blade
        family.

    Example:
        ``strain_energies(result)["first_family"].sel(nodal_diameter=1).plot()``
    """
    result = in_window(result, start, end)
    family = result["rotor_family"].values
    diameter = result["rotor_nodal_diameter"].values
    first = family == FIRST_FAMILY
    diameters = np.unique(diameter[first])
    groups = [family == SUSPENSION, *(first & (diameter == k) for k in diameters)]
    groups.append(~np.logical_or.reduce(groups))
    weights = 0.5 * result["rotor_frequency"].values ** 2 * np.array(groups, dtype=float)
    energy = reduce_modes(result, "rotor_displacement", weights, np.square)
    return labelled(
        result,
        "strain energy of the bladed disk with its shaft springs",
        {
            "suspension": ("time", energy[:, 0], "J"),
            "first_family": (("time", "nodal_diameter"), energy[:, 1:-1], "J"),
            "rest": ("time", energy[:, -1], "J"),
            "total": ("time", energy.sum(axis=1), "J"),
        },
        {"time": result["time"].values, "nodal_diameter": diameters},
    )


@styled
def plot_energy(energies: xr.Dataset) -> Figure:
    """Draw the strain energies over time on a logarithmic axis, from `strain_energies`.

    All nodal diameters but 0 and 1 are added together, as in the paper's Figs 17(b) and 22. A
    long run is drawn as means over a period of the reference frequency, which the title says.
    The axis ends a decade below the least of the terms' medians; what stays below is left out.
    """
    family = energies["first_family"]
    terms = {"total": energies["total"].values, "suspension": energies["suspension"].values}
    for k in family["nodal_diameter"].values:
        name = f"k = {k}" if k in (0, 1) else "other k"
        terms[name] = terms.get(name, 0.0) + family.sel(nodal_diameter=k).values
    terms["rest"] = energies["rest"].values

    time = energies["time"].values
    first = _drawn_starts(time, 2 * np.pi / energies.attrs["reference_frequency"])
    figure = new_figure(height=0.062)
    axes = figure.add_subplot()
    top = float(terms["total"].max())
    usual = [float(np.median(energy)) for energy in terms.values()]
    floor = max([top * 10**-PLOT_DECADES, 0.1 * min([top, *filter(None, usual)])])
    for name, energy in terms.items():
        if energy.max() > floor:
            axes.plot(
                span_means(time, first),
                span_means(energy, first),
                color=COLOURS[name],
                linewidth=2.0 if name == "total" else 1.0,
                label=f"1F, {name}" if "k" in name.split() else name,
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


def _drawn_starts(time: Array, period: float) -> IntArray:
    """First record of each drawn point: of every record in a short run, else of equal spans."""
    periods = np.ptp(time) / period
    if periods <= SMOOTHED_PERIODS:
        return np.arange(len(time))
    return span_starts(time, int(min(periods, PLOT_POINTS)))
