"""Unbalance response of a shaft line: amplitude and phase over the speed."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.ticker import MultipleLocator

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.inputs.units import handy_unit
from bladewhirl.postprocess.plotting.legends import Group, entries_of, legends_below
from bladewhirl.postprocess.plotting.style import COLUMN_WIDTH, LINES, new_figure, styled
from bladewhirl.postprocess.plotting.titles import set_title
from bladewhirl.postprocess.shaft_line.shapes import WHIRL

DECADES = 1e4  #: largest ratio of drawn amplitudes


def drawn_response(data: xr.Dataset, places: FloatArray, critical: xr.Dataset) -> xr.Dataset:
    """Return what `plot_line_response` draws at some positions [m]: `amplitude` [m] and the `phase`
    of x relative to the x axis of the shaft [rad], from `bladewhirl.line_response`; and the speeds
    from `bladewhirl.line_critical_speeds`."""
    own = data.sel(position=places, method="nearest")
    phase = np.unwrap(np.angle(own["x"].values), axis=0)
    drawn = own[["amplitude", "bearing_force"]]
    phases = {"phase": (own["x"].dims, phase, {"units": "rad"})}
    return drawn.assign(phases).merge(critical[["critical_speed", "whirl"]])


@styled
def plot_line_response(data: xr.Dataset) -> Figure:
    """Draw amplitude and phase at some positions from `drawn_response`, and bearing forces, with
    the critical speeds in the range of speeds."""
    figure = new_figure(width=1.3 * COLUMN_WIDTH, height=0.125)
    panels = figure.subplots(3, 1, sharex=True, height_ratios=[3, 2, 3])
    rpm, amplitude = data["speed"].values, data["amplitude"].values
    unit, scale = handy_unit(float(amplitude.max()), "m")
    of_force, by = handy_unit(float(data["bearing_force"].max()), "N")
    bearings = [*zip(*(data.attrs[key] for key in ("bearing_position", "bearings")), strict=True)]
    for n, place in enumerate(data["position"].values):
        label = "".join(f"bearing {name}, " for at, name in bearings if np.isclose(at, place))
        label += f"{place:.4g} m"
        colour = LINES[n % len(LINES)]
        panels[0].plot(rpm, scale * amplitude[:, n], color=colour, label=label)
        panels[1].plot(rpm, np.degrees(data["phase"].values[:, n]), color=colour)
    for n, name in enumerate(data["bearing"].values):
        force = by * data["bearing_force"].values[:, n]
        panels[2].plot(rpm, force, color=LINES[n % len(LINES)], label=f"bearing {name}")
    for axes, drawn in ((panels[0], amplitude * scale), (panels[2], data["bearing_force"] * by)):
        axes.set_yscale("log")
        axes.set_ylim(bottom=max(float(np.min(drawn)), float(np.max(drawn)) / DECADES))
    critical = [*zip(data["critical_speed"].values, data["whirl"].values, strict=True)]
    for at, whirl in critical:
        for axes in panels if rpm[0] <= at <= rpm[-1] else []:
            label = f"critical speed, {whirl}" if axes is panels[0] else "_"
            axes.axvline(at, color=WHIRL[whirl], linestyle=":", linewidth=1.0, label=label)
    panels[0].set_ylabel(f"amplitude [{unit}]")
    panels[1].set_ylabel("phase of x [°]")
    turns = np.ptp(np.degrees(data["phase"].values)) / 360.0
    panels[1].yaxis.set_major_locator(MultipleLocator(90.0 * max(1.0, np.ceil(turns))))
    panels[2].set_ylabel(f"force [{of_force}]")
    panels[2].set_xlabel("speed [rpm]")
    set_title(figure, str(data.attrs["title"]), "Response to unbalance")
    legends_below(figure, *(Group(entries_of(axes)) for axes in (panels[0], panels[2])))
    return figure
