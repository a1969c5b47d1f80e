"""Axes of swept keys in figures of sweeps."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

from bladewhirl.models.inputs.units import handy_unit
from bladewhirl.postprocess.energy.growth_rates import CERTAINTY
from bladewhirl.postprocess.fields.kinematics import Array
from bladewhirl.postprocess.plotting.axes import SPEED, rpm_axis
from bladewhirl.postprocess.sweep.quantities import cell_edges

#: the axis is logarithmic if the largest value of a key is at least this many times the smallest
WIDE_RANGE = 50.0
MOST_TICKS = 12
"""Largest number of ticks at swept values on an axis as wide as a page. If there are more than
twice as many values, matplotlib chooses the ticks."""


def in_handy_units(data: xr.Dataset) -> xr.Dataset:
    """Convert the values of swept keys to convenient units, and speeds to multiples of the
    reference frequency.

    Args:
        data: Dataset with swept keys in SI units, as coordinates with a `long_name`, and the
            attribute `reference_hz` if all points have the same reference frequency.
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
    axes: Axes, data: xr.Dataset, *, of_y: bool = False, key: str = "", share: float = 1.0
) -> None:
    """Set label, limits, scale and ticks of an axis for a swept key; few values get a tick each.

    The axis is logarithmic if the range of the values is wide, see `is_wide`.

    Args:
        axes: the panel.
        data: Dataset with the key.
        of_y: true for the vertical axis, false for the horizontal axis.
        key: name of the key; the key of the horizontal axis by default.
        share: width of the axis, relative to the width of a page.
    """
    values = data[key or str(data.attrs["along"])]
    place, way = values.values, "y" if of_y else "x"
    axes.set(
        **{
            f"{way}scale": "log" if is_wide(place) else "linear",
            f"{way}label": key_label(values),
            f"{way}lim": edges_of(place)[[0, -1]],
        }
    )
    most = max(2, int(MOST_TICKS * share))
    if len(place) <= 2 * most:
        axis = axes.yaxis if of_y else axes.xaxis
        axis.set_major_locator(FixedLocator(place.tolist(), nbins=most))
        axis.set_minor_locator(NullLocator())
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:.4g}"))


def rpm_on_top(data: xr.Dataset, *panels: Axes) -> None:
    """Add an axis in rpm on top of the uppermost panels of a figure if their abscissa is the speed.
    The drawn `data` are from `in_handy_units`."""
    key = data[str(data.attrs["along"])]
    if key_label(key) == SPEED and "reference_hz" in data.attrs:
        for axes in panels:
            rpm_axis(axes, float(data.attrs["reference_hz"]))


def key_edges(one: xr.Dataset) -> Array:
    """Return the borders of cells around the values of the horizontal key, (values + 1,)."""
    return edges_of(one[str(one.attrs["along"])].values)


def edges_of(place: Array) -> Array:
    """Return the borders of cells around ascending values, (values + 1,), midway between the values
    on a linear or, for a wide range, on a logarithmic scale."""
    return cell_edges(place, logarithmic=is_wide(place))


def is_wide(values: Array) -> bool:
    """Return true if the values are positive and their range is wide: use a logarithmic axis."""
    return bool(np.min(values) > 0 and np.max(values) >= WIDE_RANGE * np.min(values))


def key_words(name: str) -> str:
    """Return the name of a key as words: "march speed" for march.speed."""
    return name.replace(".", " ").replace("_", " ")


def key_label(values: xr.DataArray) -> str:
    """Return the label of a swept key with its unit."""
    name, units = str(values.attrs["long_name"]), str(values.attrs["units"])
    if name == "march.speed" and units == "1":
        return SPEED
    words = key_words(name)
    return words if units == "1" else f"{words} [{units}]"


def linear_threshold(rate: Array, error: Array) -> float | None:
    """Return the power of ten [1/s] up to which an axis of growth rates is linear, and logarithmic
    above; None if the entire axis is linear.

    The returned rate exceeds the medians of rates and uncertainties, so that noise is in the linear
    part of the axis. `rate` contains growth rates [1/s], NaN for points without a growth rate, and
    `error` the standard error of each rate [1/s].
    """
    usual = max(np.nanmedian(np.abs(rate)), CERTAINTY * np.nanmedian(error), 1e-12)
    threshold = float(10.0 ** np.ceil(np.log10(usual)))
    return threshold if np.nanmax(np.abs(rate)) > threshold else None
