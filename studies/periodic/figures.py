"""Figure of periodic motions: gaps and forces over a period, and multipliers."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from bladewhirl.postprocess.plotting.style import COLOURS, FULL_WIDTH, new_figure, styled
from bladewhirl.postprocess.plotting.titles import set_title

SHOWN = 6  #: largest number of speeds that are drawn


@styled
def plot_periodic(data: xr.Dataset) -> Figure:
    """Draw the smallest gap and the radial force on the blade over a period, and the multipliers in
    the unit circle, from `bladewhirl.periodic`; of many speeds, some are drawn."""
    chosen = np.unique(np.linspace(0, data.sizes["speed"] - 1, SHOWN).round().astype(int))
    figure = new_figure(width=FULL_WIDTH, height=0.055)
    gap, force, circle = figure.subplots(1, 3)
    round_trip = np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 181))
    circle.plot(round_trip.real, round_trip.imag, color=COLOURS["rest"], linewidth=0.5)
    for n in chosen.tolist():
        one = data.isel(speed=n)
        share = one["instant"].values
        pushed = -one["contact_force"].sel(direction="radial").sum("node").values
        (line,) = gap.plot(share, 1e6 * one["gap"].min("node").values)
        colour = line.get_color()
        label = f"{float(one['rpm']):.6g} rpm{'' if bool(one['stable']) else ', unstable'}"
        force.plot(share, pushed, color=colour, label=label)
        values = one["multipliers"].values
        circle.plot(values.real, values.imag, ".", color=colour)
    gap.set(xlabel="share of the period", ylabel="smallest gap [µm]")
    force.set(xlabel="share of the period", ylabel="radial force [N]")
    force.legend(loc="upper left")
    circle.set(xlabel="real part", ylabel="imaginary part", aspect="equal")
    set_title(figure, data.attrs["case"], "periodic motions")
    return figure


def drawn(data: xr.Dataset) -> xr.Dataset:
    """Return a Dataset of `bladewhirl.periodic` with real variables only."""
    values = data["multipliers"]
    parts = {"multiplier_real": values.real, "multiplier_imaginary": values.imag}
    return data.drop_vars("multipliers").assign(parts)
