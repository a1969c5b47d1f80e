"""Growth rate of a shaft line over the speed."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from bladewhirl.postprocess.plotting.legends import complete
from bladewhirl.postprocess.plotting.style import COLOURS, COLUMN_WIDTH, new_figure, styled
from bladewhirl.postprocess.shaft_line.shapes import WHIRL


@styled
def plot_line_stability(data: xr.Dataset) -> Figure:
    """Draw the largest growth rate from `bladewhirl.line_stability` and the frequency of this
    motion, coloured by its direction of whirl, with the speeds at which growth begins or ends; a
    dashed line is the frequency of the rotation."""
    figure = new_figure(width=1.3 * COLUMN_WIDTH, height=0.09)
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=[3, 2])
    rpm, rate, hertz = (data[name].values for name in ("speed", "growth_rate", "frequency"))
    for name, colour in WHIRL.items():
        own = data["direction"].values == name
        if own.any():
            style = {"marker": ".", "markersize": 2.0, "linewidth": 1.0, "color": colour}
            above.plot(rpm, np.where(own, rate, np.nan), label=name, **style)
            below.plot(rpm, np.where(own, hertz, np.nan), **style)
    below.plot(rpm, rpm / 60.0, color=COLOURS["rest"], linewidth=0.7, linestyle="--", zorder=0)
    above.axhline(0.0, color=COLOURS["total"], linewidth=0.7)
    above.fill_between(
        rpm, 0.0, rate.clip(0.0), color=COLOURS["k = 1"], alpha=0.2, linewidth=0.0, label="unstable"
    )
    for axes in (above, below):
        for speed in data["border_rpm"].values:
            axes.axvline(speed, color=COLOURS["total"], linewidth=0.7, linestyle=":")
        own = float(data["point_rpm"].item())
        if rpm[0] <= own <= rpm[-1]:
            axes.axvline(own, color=COLOURS["rest"], linewidth=0.8, zorder=0)
    below.set_ylim(0.0, 1.15 * float(hertz.max()) or None)
    above.set_xlim(rpm[0], rpm[-1])
    above.set_ylabel("largest growth rate [1/s]")
    below.set_ylabel("frequency [Hz]")
    below.set_xlabel("speed [rpm]")
    complete(figure, data.assign_attrs(case=data.attrs["title"]), "Growth rate over the speed")
    return figure
