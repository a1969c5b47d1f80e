"""Axes of figures of sweeps: those of a swept key, and those of growth rates about zero."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

from bladewhirl.models.inputs.units import handy_unit
from bladewhirl.postprocess.energy.growth_rates import CERTAINTY
from bladewhirl.postprocess.fields.kinematics import Array
from bladewhirl.postprocess.plotting.axes import SPEED, rpm_axis
from bladewhirl.postprocess.sweep.quantities import cell_edges

WIDE_RANGE = 50.0
"""Ratio of the largest to the smallest value of a key from which its axis is logarithmic."""

MOST_TICKS = 12
"""Ticks at swept values on an axis as wide as a page; of more than twice as many values, ticks are
where they usually are."""

MARGIN = 0.03
"""Share of the swept range that is left free on both sides of points, so that none is cut."""

CLEAR_RATE_RANGE = 30.0
"""Ratio of the largest rate to what is usual from which a scale is linear about zero only."""

MOST_RATE_TICKS = 3
"""Ticks on each side of zero of a scale that is linear about zero only."""


def in_handy_units(data: xr.Dataset) -> xr.Dataset:
    """Convert the values of swept keys to readable units, speeds to multiples of the reference
    frequency.

    Args:
        data: swept keys, coordinates with a `long_name`, in SI units; attribute `reference_hz`
            where all points share it.
    """
    handy = {}
    reference = 2 * np.pi * float(data.attrs.get("reference_hz", np.nan))
    for name, values in data.coords.items():
        if values.attrs.get("units") == "rad/s" and np.isfinite(reference):
            ratio = values.values / reference
            handy[str(name)] = (values.dims, ratio, {**values.attrs, "units": "1"})
        elif "long_name" in values.attrs and values.dtype.kind == "f" and values.size:
            size = float(np.abs(values.values).max())
            unit, scale = handy_unit(size, str(values.attrs.get("units", "1")))
            rounded = np.round(scale * values.values, 12)  # 0.1 mm, not 0.10000000000000002
            handy[str(name)] = (values.dims, rounded, {**values.attrs, "units": unit})
    return data.assign_coords(handy)


def key_axis(
    axes: Axes,
    data: xr.Dataset,
    *,
    of_y: bool = False,
    key: str = "",
    cells: bool = False,
    share: float = 1.0,
) -> None:
    """Label an axis with a swept key over the whole swept range, with ticks at the values if they
    are few, and make it logarithmic where its values ask for it.

    Args:
        axes: that has it.
        data: with the key.
        of_y: the vertical axis.
        key: other than the one that is gone along.
        cells: reach to the borders of cells around the values, as of maps; else to the values.
        share: of a page's width that the axis takes.
    """
    values = data[key or str(data.attrs["along"])]
    place, wide = values.values, is_wide(values.values)
    axis = axes.yaxis if of_y else axes.xaxis
    if of_y:
        axes.set_yscale("log" if wide else "linear")
    else:
        axes.set_xscale("log" if wide else "linear")
    axis.set_label_text(key_label(values))
    limits = edges_of(place)[[0, -1]] if cells else _around(place, wide)
    (axes.set_ylim if of_y else axes.set_xlim)(*limits)
    most = max(2, int(MOST_TICKS * share))
    if len(place) <= 2 * most:
        axis.set_major_locator(FixedLocator(_spread(place, most, wide).tolist()))
        axis.set_minor_locator(NullLocator())
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:.4g}"))


def rpm_on_top(data: xr.Dataset, *panels: Axes) -> None:
    """Put speeds in rpm on top of panels along the speed.

    Args:
        data: that is drawn, from `in_handy_units`.
        panels: the upper ones of a figure.
    """
    key = data[str(data.attrs["along"])]
    if key_label(key) == SPEED and "reference_hz" in data.attrs:
        for axes in panels:
            rpm_axis(axes, float(data.attrs["reference_hz"]))


def key_edges(one: xr.Dataset) -> Array:
    """Return the borders of cells around the values of the abscissa key, (values + 1,)."""
    return edges_of(one[str(one.attrs["along"])].values)


def edges_of(place: Array) -> Array:
    """Borders of cells around ascending values, (values + 1,), on the scale of their axis."""
    return cell_edges(place, logarithmic=is_wide(place))


def is_wide(values: Array) -> bool:
    """Return whether a logarithmic axis suits the values better."""
    return bool(np.min(values) > 0 and np.max(values) >= WIDE_RANGE * np.min(values))


def key_words(name: str) -> str:
    """A key of a case as words."""
    return name.replace(".", " ").replace("_", " ")


def key_label(values: xr.DataArray) -> str:
    """Return the label of a swept key with its unit."""
    name, units = str(values.attrs["long_name"]), str(values.attrs["units"])
    if name == "march.speed" and units == "1":
        return SPEED
    words = key_words(name)
    return words if units == "1" else f"{words} [{units}]"


def linear_threshold(rate: Array, error: Array) -> float | None:
    """Power of ten below which a scale is to be linear; None where all of it is to be.

    It is above most rates, and above what most of them are uncertain by, so that noise is not
    spread over decades.

    Args:
        rate: nan where there is none, (...).
        error: standard error of each, in the same unit, (...).
    """
    size, doubt = np.abs(rate), CERTAINTY * error[np.isfinite(error)]
    size = size[np.isfinite(size) & (size > 0)]
    if not size.size:
        return None
    usual = max(float(np.median(size)), float(np.median(doubt)) if doubt.size else 0.0)
    if float(size.max()) <= CLEAR_RATE_RANGE * usual:
        return None
    return float(10.0 ** np.ceil(np.log10(usual)))


def threshold_ticks(threshold: float, largest: float) -> list[float]:
    """Return zero and powers of ten on both sides of it, few enough not to overlap.

    Args:
        threshold: from `linear_threshold`.
        largest: amount on the scale.
    """
    first, last = round(np.log10(threshold)), int(np.floor(np.log10(largest)))
    powers = range(last, first - 1, -max(1, -(-(last - first + 1) // MOST_RATE_TICKS)))
    positive = [10.0**power for power in reversed(powers)]
    return [-value for value in reversed(positive)] + [0.0, *positive]


def _around(place: Array, wide: bool) -> Array:
    """Limits a little outside the first and the last value, (2,)."""
    if len(place) == 1:
        return cell_edges(place, logarithmic=wide)
    ends = np.log(place[[0, -1]]) if wide else place[[0, -1]].astype(np.float64)
    free = MARGIN * (ends[1] - ends[0])
    ends = ends + np.array([-free, free])
    return np.asarray(np.exp(ends) if wide else ends)


def _spread(place: Array, most: int, wide: bool) -> Array:
    """Return the values that are far enough apart for a number of ticks."""
    at = np.log(place) if wide else place
    apart = (at[-1] - at[0]) / most
    kept = [0]
    for number in range(1, len(at)):
        if at[number] - at[kept[-1]] >= apart * (1 - 1e-9):
            kept.append(number)
    return np.asarray(place[kept])
