"""Campbell diagram of a shaft line."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from bladewhirl.postprocess.plotting.legends import complete
from bladewhirl.postprocess.plotting.style import COLOURS, COLUMN_WIDTH, new_figure, styled
from bladewhirl.postprocess.shaft_line.shapes import WHIRL


@styled
def plot_line_campbell(diagram: xr.Dataset, critical: xr.Dataset) -> Figure:
    """Draw the frequencies from `bladewhirl.line_campbell` against the speed, coloured by the
    direction of whirl, with the line on which frequency and speed are equal, the critical speeds
    from `bladewhirl.line_critical_speeds` on it, and the speed of the case."""
    figure = new_figure(width=1.3 * COLUMN_WIDTH, height=0.075)
    axes = figure.add_subplot()
    rpm, hertz = diagram["speed"].values, diagram["frequency"].values
    whirl = diagram["whirl"].values
    for name, colour in WHIRL.items():
        only = np.where(whirl == name, hertz, np.nan)
        if np.isfinite(only).any():
            style = {"marker": ".", "markersize": 1.5, "linewidth": 1.0}
            lines = axes.plot(rpm, only, color=colour, **style)  # type: ignore[arg-type]
            lines[0].set_label(name)
    top = 1.05 * float(np.nanmax(hertz))
    axes.plot(
        rpm,
        rpm / 60.0,
        color=COLOURS["total"],
        linewidth=0.7,
        linestyle="--",
        label="speed of rotation",
    )
    at = critical["critical_speed"].values
    if len(at):
        axes.plot(
            at,
            at / 60.0,
            "o",
            mfc="white",
            color=COLOURS["total"],
            markersize=4.0,
            label="critical speed",
            zorder=5,
        )
    own = abs(float(diagram.attrs["case_rpm"]))
    if rpm[0] <= own <= rpm[-1]:
        axes.axvline(own, color=COLOURS["rest"], linewidth=0.8, label="speed of the case", zorder=0)
    axes.set_xlim(rpm[0], rpm[-1])
    axes.set_ylim(0.0, top)
    axes.set_xlabel("speed [rpm]")
    axes.set_ylabel("frequency [Hz]")
    complete(figure, diagram.assign_attrs(case=diagram.attrs["title"]), "Campbell diagram")
    return figure
