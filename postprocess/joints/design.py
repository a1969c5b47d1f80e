"""Figure of a design curve of joints: amplitudes over the speed, and their peaks over a key."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from bladewhirl.models.inputs.units import handy_unit
from bladewhirl.postprocess.joints.curves import DASHES, some_of
from bladewhirl.postprocess.plotting.legends import Group, entries_of, legends_below
from bladewhirl.postprocess.plotting.style import (
    COLOURS,
    FULL_WIDTH,
    new_figure,
    side_by_side,
    styled,
)
from bladewhirl.postprocess.plotting.titles import set_title

SHOWN = 6  #: largest number of values whose amplitudes over the speed are drawn


@styled
def plot_design(data: xr.Dataset) -> Figure:
    """Draw the amplitudes over the speed at values of a key with the linear limits, and the peaks
    over the key with the smallest one and the peaks of the limits."""
    figure = new_figure(width=FULL_WIDTH, height=0.075)
    curves, peaks = side_by_side(figure, 2)
    values, key, unit = data["value"].values, data.attrs["key"], data.attrs["unit"]
    limits = data["linear_limit"]
    length, scale = handy_unit(float(data["peak_amplitude"].max()), "m")
    chosen = some_of(len(values), SHOWN)
    for n, shade in chosen:
        label = f"{values[n]:.4g} {unit}".rstrip()
        curves.plot(data["rpm"], scale * data["amplitude"].values[n], color=shade, label=label)
    for name, dashes in zip(data["limit"].values.tolist(), DASHES, strict=True):
        curve = scale * limits.sel(limit=name).values
        curves.plot(data["rpm"], curve, dashes, color=COLOURS["rest"], zorder=1)
        label = f"{name}: {curve.max():.4g} {length}"
        peaks.axhline(curve.max(), ls=dashes, color=COLOURS["rest"], zorder=1, label=label)
    height = scale * data["peak_amplitude"].values
    least = int(height.argmin())
    peaks.plot(values, height, ".-", color=COLOURS["total"], label="largest over the speed")
    label = f"smallest: {height[least]:.4g} {length} at {values[least]:.4g} {unit}".rstrip()
    peaks.plot(values[least], height[least], "o", color=COLOURS["k = 1"], ms=5, label=label)
    if data.attrs["by_ratio"]:
        peaks.set_xscale("log")
    for axes in (curves, peaks):
        axes.set(yscale="log", ylabel=f"amplitude [{length}]")
    lowest = np.nanmin(data["amplitude"].values[[n for n, _ in chosen]])
    curves.set_ylim(0.5 * scale * lowest, 1.5 * scale * float(limits.max()))
    curves.set_xlabel("speed [rpm]")
    peaks.set_xlabel(f"{key} [{unit or '–'}]")
    set_title(figure, str(data.attrs["case"]), "design curve of joints")
    legends_below(figure, *(Group(entries_of(axes)) for axes in (curves, peaks)))
    return figure
