"""Response to engine-order forces: amplitudes by blade and nodal diameter against speed."""

from collections.abc import Sequence
from itertools import cycle
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from bladewhirl.models.inputs.units import handy_unit
from bladewhirl.postprocess.plotting.style import (
    COLOURS,
    FULL_WIDTH,
    new_figure,
    rows_of_panels,
    styled,
)
from bladewhirl.postprocess.plotting.titles import set_title

SHOWN = 4  #: largest number of nodal diameters drawn in colour: those with the largest peaks

OTHER_COLOURS = [COLOURS[name] for name in ("suspension", "contact", "casing", "rest")]
"""Colours of nodal diameters above 1."""

LIMIT_COLOURS = [COLOURS[name] for name in ("rest", "k = 0", "contact")]
"""Colours of the linear limits of joints: free, closed without friction, stuck."""

LOWEST = 1e-4  #: smallest amplitude that is drawn, divided by the largest amplitude


def amplitude(data: xr.Dataset) -> xr.DataArray:
    """Return the largest displacement of each tip in a period [m], from `bladewhirl.response`."""
    distance: xr.DataArray = largest_in_period(data["tip_tangential"], data["tip_radial"])
    return distance.assign_attrs(units="m", long_name="amplitude of the tip")


def largest_in_period(tangential: Any, radial: Any) -> Any:
    """Return the largest distance from rest in a period of motions with complex components, arrays
    of equal shape."""
    square = abs(tangential) ** 2 + abs(radial) ** 2
    return (0.5 * (square + abs(tangential**2 + radial**2))) ** 0.5


def at_peaks(data: xr.Dataset, order: int) -> xr.Dataset:
    """Return the motions at the peaks of an engine order, over their speeds, from
    `bladewhirl.response`."""
    own = data.isel(peak=np.flatnonzero(data["peak_order"].values == order))
    names: dict[Any, Any] = {
        "peak_tip_tangential": "tip_tangential",
        "peak_tip_radial": "tip_radial",
    }
    chosen = own[[*names]].reset_coords(drop=True).rename(peak="speed", **names)
    return chosen.assign_coords(
        speed=own["peak_speed"].values, rpm=("speed", own["peak_rpm"].values)
    )


def by_nodal_diameter(data: xr.Dataset) -> xr.DataArray:
    """Return the amplitude of the tangential displacement of the tips by nodal diameter [m], from
    `bladewhirl.response`.

    The backward and the forward wave of a nodal diameter are added as the root of the sum of their
    squares. The squares of all nodal diameters add up to the mean square over the blades.
    """
    tips = data["tip_tangential"].transpose(..., "blade")
    blades = tips.sizes["blade"]
    half = blades // 2 + 1
    power = np.abs(np.fft.fft(tips.values) / blades) ** 2
    both = power[..., :half].copy()
    pairs = (blades - 1) // 2
    both[..., 1 : pairs + 1] += power[..., :0:-1][..., :pairs]
    dims = [*tips.dims[:-1], "nodal_diameter"]
    coords: dict[Any, Any] = {name: tips[name] for name in dims if name in tips.coords}
    coords["nodal_diameter"] = np.arange(half)
    name = {"units": "m", "long_name": "amplitude of the nodal diameter"}
    return xr.DataArray(np.sqrt(both), dims=dims, coords=coords, attrs=name)


def joined_limits(found: Sequence[xr.Dataset], names: Sequence[str]) -> xr.Dataset:
    """Return the responses of linear limits of joints with the dimension `limit`; peaks have the
    coordinate `peak_limit` in its place."""
    at_speeds = [one.drop_dims("peak") for one in found]
    peaks = [
        one[[name for name in one.data_vars if "peak" in one[name].dims]].assign_coords(
            peak_limit=("peak", [limit] * one.sizes["peak"])
        )
        for one, limit in zip(found, names, strict=True)
    ]
    grid = xr.concat(at_speeds, xr.Variable("limit", list(names)), coords="minimal")
    return grid.merge(xr.concat(peaks, "peak"))


def by_limit(data: xr.Dataset) -> dict[str, xr.Dataset]:
    """Return the response of each linear limit of joints; without joints one without a name."""
    if "limit" not in data.dims:
        return {"": data}
    return {
        name: data.sel(limit=name).isel(peak=np.flatnonzero(data["peak_limit"].values == name))
        for name in data["limit"].values.tolist()
    }


def drawn_amplitudes(data: xr.Dataset) -> xr.Dataset:
    """Return the real amplitudes that `plot_response` draws, from `bladewhirl.response`: those at
    the given speeds and at all peaks."""
    if "limit" in data.dims:
        each = {name: drawn_amplitudes(one) for name, one in by_limit(data).items()}
        at = xr.Variable("limit", [*each])
        found = xr.concat([*each.values()], at, join="outer", coords="minimal", compat="override")
        return found.assign_attrs(data.attrs)
    every = data if "order" in data.dims else data.expand_dims("order")
    parts = []
    for order in every["order"].values.tolist():
        both = [every.sel(order=order), at_peaks(data, order)]
        drawn = [
            xr.Dataset(
                {
                    "amplitude": amplitude(each),
                    "amplitude_by_nodal_diameter": by_nodal_diameter(each),
                }
            )
            for each in both
        ]
        together = xr.concat(drawn, "speed", coords="minimal", compat="override")
        parts.append(together.drop_duplicates("speed").sortby("speed"))
    at = xr.Variable("order", every["order"].values)
    return xr.concat(parts, at, join="outer").assign_attrs(data.attrs)


@styled
def plot_response(data: xr.Dataset) -> Figure:
    """Draw the amplitudes of the tips from `bladewhirl.response` against the speed.

    Each engine order has a row. The left panel shows all blades, with the blade of the largest
    amplitude in colour; the right panel shows the nodal diameters with the largest amplitudes. Of
    linear limits of joints, one panel shows the largest amplitude of a blade.
    """
    if "limit" in data.dims:
        return _plot_limits(data)
    drawn = drawn_amplitudes(data)
    orders = drawn["order"].values
    figure = new_figure(width=FULL_WIDTH, height=0.035 + 0.05 * len(orders))
    panels = rows_of_panels(figure, len(orders), [1.0, 1.0], sharex=True)
    unit, scale = handy_unit(float(drawn["amplitude"].max()), "m")
    for row, order in zip(panels, orders, strict=True):
        own = drawn.sel(order=order).dropna("speed")
        speed = own["speed"].values
        tips = scale * own["amplitude"].transpose("speed", "blade").values
        diameters = own["amplitude_by_nodal_diameter"]
        waves = scale * diameters.transpose("speed", "nodal_diameter").values
        most = int(tips.max(axis=0).argmax())
        row[0].plot(speed, tips, color=COLOURS["rest"], linewidth=0.5)
        alike = np.allclose(tips, tips[:, [most]], rtol=1e-6)
        label = "all blades" if alike else f"blade {most}"
        row[0].plot(speed, tips[:, most], color=COLOURS["total"], label=label)
        largest, others = waves.max(axis=0), iter(OTHER_COLOURS)
        most_moved = np.argsort(-largest, kind="stable")[:SHOWN].tolist()
        shown = [k for k in most_moved if largest[k] > LOWEST * largest.max()]
        for k in shown:
            colour = COLOURS[f"k = {k}"] if k < 2 else next(others)
            row[1].plot(speed, waves[:, k], color=colour, label=f"k = {k}")
        for axes, what in zip(row, ("blades", "nodal diameters"), strict=True):
            axes.set_yscale("log")
            axes.set_title(f"engine order {order}, {what}")
            axes.legend()
        top = float(tips.max())
        low = 0.5 * min(float(tips.min()), *largest[shown].tolist())
        for axes in row:
            axes.set_ylim(max(LOWEST * top, low), 2.0 * top)
        row[0].set_ylabel(f"amplitude of the tips [{unit}]")
    for axes in panels[-1]:
        axes.set_xlabel("speed Ω / ω₁ [–]")
    set_title(figure, str(data.attrs["case"]), "Response to engine-order forces, without contact")
    return figure


def _plot_limits(data: xr.Dataset) -> Figure:
    """Draw the largest amplitude of a blade in each linear limit of joints, and its peaks."""
    figure = new_figure(width=FULL_WIDTH, height=0.035 + 0.05 * data["order"].size)
    panels = figure.subplots(data["order"].size, 1, sharex=True, squeeze=False)[:, 0]
    each = {name: drawn_amplitudes(one) for name, one in by_limit(data).items()}
    unit, scale = handy_unit(max(float(one["amplitude"].max()) for one in each.values()), "m")
    for axes, order in zip(panels, np.atleast_1d(data["order"].values), strict=True):
        for (name, drawn), colour in zip(each.items(), LIMIT_COLOURS, strict=True):
            own = drawn["amplitude"].sel(order=order).dropna("speed").max("blade")
            values, most = scale * own.values, int(own.values.argmax())
            label = f"{name}: {values[most]:.4g} {unit} at {float(own['rpm'][most]):.6g} rpm"
            axes.plot(own["rpm"], values, color=colour, label=label)
            axes.plot(own["rpm"][most], values[most], "o", color=colour, ms=4)
        axes.set(yscale="log", ylabel=f"amplitude of the tips [{unit}]")
        axes.set_title(f"engine order {order}, largest blade")
        axes.legend()
    panels[-1].set_xlabel("speed [rpm]")
    set_title(figure, str(data.attrs["case"]), "Response with joints in their linear limits")
    return figure


@styled
def plot_amplification(data: xr.Dataset) -> Figure:
    """Draw the share of the patterns whose amplification exceeds a value, from
    `bladewhirl.amplification`: a line for each engine order, with Whitehead's bound."""
    figure = new_figure(width=FULL_WIDTH, height=0.075)
    axes = figure.subplots()
    colours = [COLOURS["total"], COLOURS["k = 1"], *OTHER_COLOURS]
    for order, colour in zip(data["order"].values.tolist(), cycle(colours)):
        one = data.sel(order=order)
        values = np.sort(one["amplification"].values)
        at = 60.0 * float(data.attrs["reference_frequency_hz"]) * float(one["tuned_speed"])
        label = f"engine order {order}, tuned peak at {at:.0f} rpm"
        share = 1.0 - np.arange(len(values)) / len(values)
        axes.step(values, share, where="pre", color=colour, label=label)
    bound = float(data.attrs["whitehead_bound"])
    axes.axvline(bound, color=COLOURS["rest"], linestyle="--", label=f"Whitehead, {bound:.3g}")
    axes.set(
        yscale="log",
        xlabel="amplification by mistuning [–]",
        ylabel="share of patterns above [–]",
    )
    axes.legend()
    spread = 100.0 * float(data.attrs["stiffness_spread"])
    words = f"{data.sizes['draw']} patterns, stiffness of blades with a deviation of {spread:.3g} %"
    set_title(figure, str(data.attrs["case"]), f"Amplification by mistuning: {words}")
    return figure
