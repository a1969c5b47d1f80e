"""Figure of a branch of periodic motions."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from bladewhirl.postprocess.plotting.style import COLOURS, FULL_WIDTH, new_figure, styled
from bladewhirl.postprocess.plotting.titles import set_title
from bladewhirl.solvers.periodic.bifurcation import KINDS

MARKS = dict(zip(KINDS, "osD", strict=True))


@styled
def plot_branch(data: xr.Dataset) -> Figure:
    """Draw the impulse over the key and over the multipliers, of `bladewhirl.branch`.

    Stable parts are solid, unstable ones dashed. On the right are the multipliers of all points in
    the unit circle.
    """
    figure = new_figure(width=FULL_WIDTH, height=0.07)
    impulse, size, circle = figure.subplots(1, 3)
    value, stable = data["parameter"].values, data["stable"].values
    moved = data["contact_displacement"].sel(direction="radial")
    swing = 1e3 * (moved.max("instant") - moved.min("instant")).max("node").values / 2.0
    for axes, drawn in ((impulse, data["impulse_per_revolution"].values), (size, swing)):
        for part, style in ((stable, "-"), (~stable, "--")):
            near = part | np.append(part[1:], False) & np.append(~part[1:], False)
            axes.plot(value, np.where(near, drawn, np.nan), style, color=COLOURS["rotor"])
        for number, (kind, mark) in enumerate(MARKS.items(), 1):
            there = data["kind"].values == number
            if there.any():
                axes.plot(value[there], drawn[there], mark, color=COLOURS["casing"], label=kind)
        axes.set_xlabel(f"{data.attrs['key']} [{data.attrs['unit'] or '–'}]")
    impulse.set_ylabel("impulse per revolution [N s]")
    size.set_ylabel("largest radial amplitude [mm]")
    if (data["kind"] > 0).any():
        impulse.legend(loc="best")
    turn = np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 181))
    circle.plot(turn.real, turn.imag, color=COLOURS["rest"], linewidth=0.5)
    shown = np.hypot(data["multiplier_real"], data["multiplier_imaginary"]) < 3.0
    circle.plot(
        data["multiplier_real"].where(shown).values.ravel(),
        data["multiplier_imaginary"].where(shown).values.ravel(),
        ".",
        markersize=2,
        color=COLOURS["rotor"],
    )
    circle.set(xlabel="real part", ylabel="imaginary part", aspect="equal")
    set_title(figure, data.attrs["case"], "branch of periodic motions")
    return figure
