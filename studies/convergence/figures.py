"""Figures of convergence in the time step and the modes."""

from collections.abc import Mapping

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bladewhirl.postprocess.fields.kinematics import Array
from bladewhirl.postprocess.plotting.style import COLOURS, new_figure, styled
from bladewhirl.postprocess.plotting.titles import head

REGIME_MARKERS = {"divergent": "^", "sustained": "o", "damped": "v", "no-contact": "s"}
"""Marker of each regime."""

PERCENT, MILLI = 100.0, 1e3


@styled
def plot_time_steps(data: xr.Dataset) -> Figure:
    """Draw the changes from each time step to the next finer time step, with observed orders, from
    a Dataset of `time_step_convergence`."""
    step = data["time_step"].values

    def with_order(label: str, name: str) -> str:
        order = float(data.attrs[name])
        return f"{label}, order {order:.2g}" if np.isfinite(order) else label

    lines = {
        "free_step_distance": (with_order("motion to first contact", "free_order"), "k = 0"),
        "step_distance": (with_order("motion", "displacement_order"), "rotor"),
        "step_impulse_error": (with_order("contact impulse", "impulse_order"), "contact"),
    }
    figure, axes = _plot_errors(data, step, lines, slopes=True)
    axes.set_xscale("log")
    axes.set_xticks(step, [f"{1e6 * size:.3g}" for size in step])
    axes.minorticks_off()
    axes.set(xlabel="time step [µs]", ylabel="change to the next finer step [%]")
    return figure


@styled
def plot_modes(data: xr.Dataset) -> Figure:
    """Draw differences from the march with the most modes, and the error of the frequencies, from a
    Dataset of `mode_convergence`."""
    lines = {
        "distance": ("motion, against most modes", "rotor"),
        "impulse_error": ("contact impulse, against most modes", "contact"),
        "frequency_error": ("frequencies 1F to 5F", "k = 0"),
    }
    figure, axes = _plot_errors(data, data["kept"].values, lines)
    axes.set_xticks(data["kept"].values)
    axes.set(xlabel=f"modes ({data.attrs['key']})", ylabel="relative error [%]")
    return figure


def _plot_errors(
    data: xr.Dataset, x: Array, lines: Mapping[str, tuple[str, str]], *, slopes: bool = False
) -> tuple[Figure, Axes]:
    """Draw lines through the errors above zero, with markers for the regimes, in a new figure.
    `lines` contains the label and the colour of each error; with `slopes` reference slopes are
    drawn."""
    figure = new_figure(height=0.078)
    axes, regime = figure.add_subplot(), data["regime"].values
    for name, (label, key) in lines.items():
        colour, error = COLOURS[key], PERCENT * data[name].values
        positive = error > 0.0  # False for NaN
        if positive.any():
            axes.plot(x[positive], error[positive], color=colour, label=label)
        for place, value, kind in zip(x[positive], error[positive], regime[positive], strict=True):
            axes.plot(place, value, REGIME_MARKERS[kind], color=colour, markersize=4)
    if slopes:
        _reference_slopes(axes, x)
    if axes.lines:
        axes.set_yscale("log")
    for kind in dict.fromkeys(regime):
        axes.plot([], [], REGIME_MARKERS[kind], color=COLOURS["rest"], markersize=4, label=kind)
    head(figure, data, f"{MILLI * data.attrs['end']:.4g} ms")
    # one column, because labels are long
    figure.legend(loc="outside lower center", ncols=1)
    return figure, axes


def _reference_slopes(axes: Axes, step: Array) -> None:
    """Draw lines of first- and second-order slope through the geometric mean of drawn values."""
    drawn = [line.get_ydata() for line in axes.lines]
    if not drawn:
        return
    middle = np.exp(np.log(np.concatenate(drawn)).mean())
    for order, dashes in ((1, (0, (4, 2))), (2, (0, (1, 1.5)))):
        slope = middle * (step / np.sqrt(step[0] * step[-1])) ** order
        label = f"slope of order {order}"
        axes.plot(step, slope, color=COLOURS["rest"], linewidth=0.8, linestyle=dashes, label=label)
