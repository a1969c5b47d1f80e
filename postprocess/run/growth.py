"""The amplitude over time, and the growth rate that a regime is judged by with its uncertainty."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from bladewhirl.postprocess.fields.fields import Array, ViewError
from bladewhirl.postprocess.fields.labelled import labelled
from bladewhirl.postprocess.fields.windows import few_time_ticks, in_window
from bladewhirl.postprocess.plotting.style import COLOURS, new_figure, speed_label, styled
from bladewhirl.postprocess.run.energies import strain_energies
from bladewhirl.postprocess.run.regimes import CERTAINTY, classify, growth_windows, rate_text


def amplitude_growth(
    result: xr.Dataset, *, start: float | None = None, end: float | None = None
) -> xr.Dataset:
    """The amplitude in equal windows, and the exponential fitted to the last of them.

    Args:
        result: of a run.
        start: of the window [s]; of the run when None.
        end: of the window [s]; of the run when None.

    Returns:
        over time, the middle of each window [s]: `amplitude`, root of the mean strain energy of
        bladed disk and shaft springs [J^0.5]; `fit` with `low` and `high`, two standard errors of
        the rate from it, nan before the windows fitted to, see `regimes.growth_windows`.
        Attributes `rate` and `error`, its standard error [1/s], `span`, the time fitted over in
        words, `regime` and `reason`.

    Raises:
        ViewError: too short a history to judge growth by, or at rest.
    """
    dataset = in_window(result, start, end)
    energy = strain_energies(dataset)["total"].values
    windows = growth_windows(dataset, energy)
    regime = classify(dataset, energy)
    if windows is None or regime.growth is None:
        raise ViewError("too short a history to judge growth, or at rest")
    rate, error = regime.growth.rate, regime.growth.error
    middle = windows.begin + windows.length / 2
    late = middle[windows.late :]
    level = np.log(windows.amplitude[windows.late :]).mean()

    def at_late(line: Array) -> tuple[str, Array, str]:
        return "time", np.append(np.full(windows.late, np.nan), line), "J^0.5"

    def fitted(slope: float) -> Array:
        return np.asarray(np.exp(level + slope * (late - late.mean())))

    slow, fast = fitted(rate - CERTAINTY * error), fitted(rate + CERTAINTY * error)
    return labelled(
        dataset,
        "amplitude of the bladed disk, and its growth",
        {
            "amplitude": ("time", windows.amplitude, "J^0.5"),
            "fit": at_late(fitted(rate)),
            "low": at_late(np.minimum(slow, fast)),
            "high": at_late(np.maximum(slow, fast)),
        },
        {"time": middle},
        rate=rate,
        error=error,
        span=regime.growth.span,
        regime=regime.name,
        reason=regime.reason,
        window=windows.length,
    )


@styled
def plot_growth(growth: xr.Dataset) -> Figure:
    """Draw the amplitude over time, and over its last windows the fitted growth with its band.

    Args:
        growth: from `amplitude_growth`.
    """
    figure = new_figure(height=0.06)
    axes = figure.add_subplot()
    time = growth["time"].values
    axes.plot(
        time,
        growth["amplitude"],
        "o-",
        color=COLOURS["rotor"],
        markersize=2.5,
        linewidth=0.6,
        label=f"means over {1e3 * growth.attrs['window']:.3g} ms",
    )
    axes.fill_between(
        time,
        growth["low"],
        growth["high"],
        color=COLOURS["k = 1"],
        alpha=0.3,
        linewidth=0,
        label=f"± {CERTAINTY:g} standard errors",
    )
    axes.plot(time, growth["fit"], color=COLOURS["k = 1"], label=f"fit, {growth.attrs['span']}")
    largest = float(growth["amplitude"].max())
    if float(growth["amplitude"].min()) > 0 and largest > 10 * float(growth["amplitude"].min()):
        axes.set_yscale("log")
    else:
        axes.set_ylim(0.0, 1.15 * largest)
    axes.set(xlabel="time [s]", ylabel="root of strain energy [J$^{1/2}$]")
    few_time_ticks(axes)
    rate = rate_text(growth.attrs["rate"], growth.attrs["error"])
    axes.set_title(f"{growth.attrs['regime']}, growth rate {rate} 1/s\n{speed_label(growth)}")
    figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure
