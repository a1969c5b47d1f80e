"""Amplitude of a run over time, with its growth rate and the uncertainty of the growth rate."""

import textwrap
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from bladewhirl.postprocess.energy.growth_rates import (
    ABOUT_MEAN,
    CERTAINTY,
    growth_windows,
    rate_text,
    ripple_windows,
)
from bladewhirl.postprocess.energy.regimes import classify
from bladewhirl.postprocess.energy.strain import strain_energies
from bladewhirl.postprocess.fields.kinematics import Array, ViewError
from bladewhirl.postprocess.fields.labelled import labelled
from bladewhirl.postprocess.fields.windows import in_window
from bladewhirl.postprocess.plotting.style import COLOURS, new_figure, styled, time_axis
from bladewhirl.postprocess.plotting.titles import head

LETTERS = 50  #: largest number of letters in a line below the figure


def amplitude_growth(
    result: xr.Dataset,
    energies: xr.Dataset | None = None,
    *,
    start: float | None = None,
    end: float | None = None,
) -> xr.Dataset:
    """Compute the amplitude in equal windows of time, and fit an exponential to the last windows.

    Args:
        result: result of a run.
        energies: from `strain.strain_energies`, for the time from start to end; computed when None.
        start, end: limits of the time window [s]; start and end of the run when None.

    Returns:
        Dataset over time, the middle of each window [s]. `energy`: mean strain energy of bladed
        disk and shaft springs [J], the square of the amplitude. `ripple`: mean strain energy of the
        motion about the mean position of each window [J], nan where it cannot be computed.
        `local_rate`: growth rate of the amplitude from one window to the next [1/s]. `fit`: fitted
        energy [J]; `low` and `high`: `fit` with the rate changed by two standard errors; nan before
        the fitted windows, see `growth_rates.growth_windows`. Attributes: growth rate `rate` and
        standard error `error`; `end_rate`, fitted to the last five windows; `ripple_rate` and
        `ripple_error`, nan without ripple, all [1/s]; `residual`, misfit of the logarithm of the
        amplitude; `span`, the fitted time interval in words; `regime`, `reason`.

    Raises:
        ViewError: the history is too short to judge growth, or the stage is at rest.
    """
    dataset = in_window(result, start, end)
    if energies is None:
        energies = strain_energies(result, start=start, end=end)
    energy = energies["total"].values
    windows = growth_windows(dataset, energy)
    regime = classify(dataset, energy)
    if windows is None or regime.growth is None:
        raise ViewError("the history is too short for a growth rate, or nothing moves")
    rate, error = regime.growth.rate, regime.growth.error
    middle = windows.begin + windows.length / 2
    moving = np.where(windows.amplitude > 0.0, windows.amplitude, np.nan)
    late = middle[windows.late :]
    level = np.log(windows.amplitude[windows.late :]).mean()

    def at_late(line: Array) -> tuple[str, Array, str]:
        return "time", np.append(np.full(windows.late, np.nan), line), "J"

    def fitted(slope: float) -> Array:
        return np.asarray(np.exp(2 * (level + slope * (late - late.mean()))))

    slow, fast = fitted(rate - CERTAINTY * error), fitted(rate + CERTAINTY * error)
    return labelled(
        dataset,
        "amplitude of the bladed disk, and its growth",
        {
            "energy": ("time", windows.amplitude**2, "J"),
            "ripple": ("time", _ripple(dataset, energy, middle), "J"),
            "local_rate": ("time", np.gradient(np.log(moving), middle), "1/s"),
            "fit": at_late(fitted(rate)),
            "low": at_late(np.minimum(slow, fast)),
            "high": at_late(np.maximum(slow, fast)),
        },
        {"time": middle},
        rate=rate,
        error=error,
        end_rate=regime.growth.end_rate,
        end_error=regime.growth.end_error,
        slows=int(regime.growth.slows),
        ripple_rate=np.nan if regime.ripple is None else regime.ripple.rate,
        ripple_error=np.nan if regime.ripple is None else regime.ripple.error,
        residual=regime.growth.residual,
        span=regime.growth.span,
        regime=regime.name,
        reason=regime.reason,
        window=windows.length,
    )


def _ripple(dataset: xr.Dataset, energy: Array, middle: Array) -> Array:
    """Return the energy of the ripple [J] at the times `middle` [s], the middles of the windows of
    the motion; nan at times outside the windows of the ripple."""
    windows = ripple_windows(dataset, energy)
    if windows is None:
        return np.full(len(middle), np.nan)
    time = windows.begin + windows.length / 2
    return np.interp(middle, time, windows.amplitude**2, left=np.nan, right=np.nan)


@styled
def plot_growth(growth: xr.Dataset) -> Figure:
    """Draw the mean strain energy over time from `amplitude_growth`, with the exponential fitted to
    the last windows.

    The lower panel shows the deviation of the amplitude from the fit, with a band for the error of
    the rate.
    """
    figure = new_figure(height=0.085)
    axes, misfits = figure.subplots(2, 1, sharex=True, height_ratios=(2.6, 1.0))
    time = growth["time"].values
    means: dict[str, Any] = {"color": COLOURS["rotor"], "markersize": 2.5, "linewidth": 0.6}
    label = f"means over {1e3 * growth.attrs['window']:.3g} ms"
    axes.plot(time, growth["energy"], "o-", label=label, **means)
    axes.plot(time, growth["fit"], color=COLOURS["k = 1"], label=f"fit, {growth.attrs['span']}")
    shown = [growth["energy"].values, growth["ripple"].values]
    if np.isfinite(shown[1]).any():
        axes.plot(time, shown[1], "--", color=COLOURS["suspension"], label=ABOUT_MEAN)
    smallest, largest = np.nanmin(shown), np.nanmax(shown)
    if smallest > 0 and largest > 10 * smallest:
        axes.set_yscale("log")
    else:
        axes.set_ylim(0.0, 1.15 * largest)
    axes.set_ylabel("strain energy [J]")
    misfit, low, high = (
        100 * (np.sqrt(growth[name] / growth["fit"]) - 1) for name in ("energy", "low", "high")
    )
    misfits.fill_between(
        time,
        low,
        high,
        color=COLOURS["k = 1"],
        alpha=0.3,
        linewidth=0,
        label=f"± {CERTAINTY:g} standard errors of the rate",
    )
    misfits.plot(time, misfit, "o-", **means)
    misfits.axhline(0.0, color=COLOURS["k = 1"])
    reach = 1.2 * max(float(abs(line).max()) for line in (misfit, low, high)) or 1.0
    misfits.set(ylabel="misfit [%]", ylim=(-reach, reach))
    time_axis(axes, misfits)
    rates = [("amplitude", "rate", "error"), (ABOUT_MEAN, "ripple_rate", "ripple_error")]
    words = [
        f"growth rate of the {what} {rate_text(growth.attrs[rate], growth.attrs[error])} 1/s"
        for what, rate, error in rates
        if np.isfinite(growth.attrs[rate])
    ]
    if growth.attrs["slows"]:
        end = rate_text(growth.attrs["end_rate"], growth.attrs["end_error"])
        words.append(f"at the end {end} 1/s")
    lines = [textwrap.fill(each, LETTERS) for each in words]
    misfits.set_xlabel("\n".join([misfits.get_xlabel(), *lines]))
    head(figure, growth, growth.attrs["regime"])
    figure.legend(loc="outside lower center", ncols=2)
    return figure
