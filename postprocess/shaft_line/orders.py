"""Response of a shaft line to engine orders: tips and hub over the speed."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from bladewhirl.models.inputs.units import handy_unit
from bladewhirl.postprocess.plotting.style import COLUMN_WIDTH, LINES, new_figure, styled
from bladewhirl.postprocess.plotting.titles import set_title


@styled
def plot_line_orders(data: xr.Dataset) -> Figure:
    """Draw the amplitude of a blade tip, and the largest deflection of the shaft, for each engine
    order of `bladewhirl.line_order_response`."""
    figure = new_figure(width=1.3 * COLUMN_WIDTH, height=0.09)
    panels = figure.subplots(2, 1, sharex=True)
    tip = np.hypot(data["tip_radial"].values, data["tip_tangential"].values)
    deflection = np.maximum(data["deflection"].values.max(axis=2), data["axial"].values)
    names = ("blade tip", "shaft")
    for axes, amplitude, name in zip(panels, (tip, deflection), names, strict=True):
        unit, scale = handy_unit(float(amplitude.max()), "m")
        for row, order in enumerate(data["order"].values):
            colour = LINES[row % len(LINES)]
            axes.plot(
                data["speed"], scale * amplitude[row], color=colour, label=f"engine order {order}"
            )
        axes.set_yscale("log")
        axes.set_ylabel(f"{name} [{unit}]")
    panels[0].legend()
    panels[1].set_xlabel("speed [rpm]")
    set_title(figure, str(data.attrs["title"]), "Response to engine orders")
    return figure
