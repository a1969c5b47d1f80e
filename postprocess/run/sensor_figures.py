"""Figures of the signals of sensors, against time, frequency or engine order, and by blade."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bladewhirl.postprocess.fields import rotation
from bladewhirl.postprocess.fields.kinematics import Array, ViewError
from bladewhirl.postprocess.fields.labelled import labelled
from bladewhirl.postprocess.fields.windows import evenly_spaced, span_starts
from bladewhirl.postprocess.plotting.axes import Labels, blade_axis, draw_decades, draw_map
from bladewhirl.postprocess.plotting.legends import entries_of
from bladewhirl.postprocess.plotting.style import (
    COLOUR_MAPS,
    COLOURS,
    FULL_WIDTH,
    is_narrow,
    new_figure,
    rows_of_panels,
    styled,
    time_axis,
)
from bladewhirl.postprocess.plotting.titles import head, plain_exponents
from bladewhirl.postprocess.run.sensors import shown_unit
from bladewhirl.postprocess.shaft.spectra import (
    DECADES,
    MARGIN,
    ORDER,
    WITH_K,
    blackman_harris,
    modal_lines,
    slices,
)
from bladewhirl.postprocess.shaft.transforms import FEWEST_RECORDS, spectrum

MOST_PANELS = 6  #: largest number of sensors in a figure
COLUMNS = 1000  #: largest number of spans of a curve; the extremes of each span are drawn
FAMILIES, DIAMETERS = 3, 7
"""Largest numbers of blade families and of nodal diameters whose frequencies are drawn."""

ORDERS = 10.0  #: a spectrum is drawn at least up to this engine order
#: a revolution is drawn if it has more than this fraction of the largest number of samples
WHOLE = 0.9
PALE = "#B0B0B0"
LABEL = "#1F6E9C"  #: colour of the names of modes, a darker tone of their lines
WORDS = {"m/m": "strain", "m": "displacement", "m/s": "velocity", "m/s2": "acceleration"}


def sensor_spectra(signals: xr.Dataset, result: xr.Dataset) -> xr.Dataset:
    """Compute the amplitude of each signal against frequency, with the frequencies of modes.

    If a strain is recorded on all blades, the blade that vibrates most is taken. Tip timing has no
    spectrum, because it has few samples in a revolution.

    Args:
        signals: signals from `sensors`.
        result: result of the same run.

    Returns:
        Dataset with two variables for each sensor NAME. NAME (NAME_frequency,) is the amplitude, in
        the unit of the signal; the coordinate NAME_frequency is in Hz. NAME_mode (NAME_line, end)
        [Hz] contains the lowest and the highest frequency of each group of modes; the coordinate
        NAME_line contains the names of the groups.

    Raises:
        ViewError: there is no signal over time, or a signal is too short.
    """
    turns = abs(float(signals.attrs["speed"])) / (2.0 * np.pi)
    spectra = labelled(signals, "spectra of sensors", {}, {})
    chosen = [*over_time(signals)]
    modes = [_modes(result, signal.attrs["type"]) for _, signal, _ in chosen]
    top = max([ORDERS * turns, *(high for lines in modes for _, _, high in lines)])
    for (name, signal, step), lines in zip(chosen, modes, strict=True):
        edge = min(0.5 / step, MARGIN * top)
        values = signal.values - signal.values.mean()
        window = blackman_harris(len(values))
        frequency, amplitude = spectrum(values.astype(complex), step, window, padding=4)
        shown = (frequency >= 0.0) & (frequency <= edge)
        along = f"{name}_frequency"
        spectra[name] = (along, 2.0 * np.abs(amplitude[shown]), signal.attrs)
        spectra.coords[along] = (along, frequency[shown], {"units": "Hz"})
        ends = np.array([line[1:] for line in lines]).reshape(-1, 2)
        spectra[f"{name}_mode"] = ((f"{name}_line", "end"), ends, {"units": "Hz"})
        spectra.coords[f"{name}_line"] = (f"{name}_line", [line[0] for line in lines])
    return spectra


def sensor_orders(signals: xr.Dataset, result: xr.Dataset) -> xr.Dataset:
    """Compute the amplitude of each signal against engine order and time, in overlapping slices.

    Args:
        signals: signals from `sensors`; strains of all blades and tip timing as in
            `sensor_spectra`.
        result: result of the same run.

    Returns:
        Dataset with a variable for each sensor NAME: the amplitude NAME (NAME_order, NAME_time), in
        the unit of the signal. NAME_order is the frequency divided by the frequency of rotation,
        NAME_time is the middle of each slice [s]. If the speed varies, the signals are resampled at
        equal angles of the rotor, so that an order stays an order while the speed changes.

    Raises:
        ViewError: the rotor does not turn, or its sense of rotation changes; there is no signal
            over time, or a signal is too short.
    """
    turns = abs(float(signals.attrs["speed"])) / (2.0 * np.pi)
    if turns == 0.0:
        raise ViewError("order tracking: expected a rotor that turns")
    orders = labelled(signals, "engine orders of sensors", {}, {})
    for name, signal, step in over_time(signals):
        top = max([ORDERS * turns, *(high for _, _, high in _modes(result, "strain"))])
        period = 2.0 * np.pi / float(signals.attrs["reference_frequency"])
        place, values = signal["time"].values, signal.values - signal.values.mean()
        step, period = turns * step, turns * period  # revolutions
        if rotation.varies(result):
            clock = _revolutions(result, place)
            even = np.linspace(0.0, clock[-1], len(clock))
            step = even[1]
            place, values = (np.interp(even, clock, each) for each in (place, values))
        order, amplitude, first, size = slices(values.astype(complex), step, period)
        shown = (order >= 0.0) & (order <= MARGIN * top / turns)
        over = (f"{name}_order", f"{name}_time")
        orders[name] = (over, 2.0 * np.abs(amplitude[:, shown]).T, signal.attrs)
        orders.coords[over[0]] = (over[0], order[shown], {"units": "1"})
        middle = np.interp(first + 0.5 * size, np.arange(len(place)), place)
        orders.coords[over[1]] = (over[1], middle, {"units": "s"})
    return orders


def _revolutions(result: xr.Dataset, time: Array) -> Array:
    """Return the revolutions at times [s], ascending.

    Raises:
        ViewError: the sense of rotation changes.
    """
    passed = rotation.angle_at(result, time) / (2.0 * np.pi)
    steps = np.diff(passed)
    if not ((steps > 0.0).all() or (steps < 0.0).all()):
        raise ViewError(
            "order tracking: expected a rotor that turns in one sense and does not stop"
        )
    return np.asarray(np.abs(passed - passed[0]))


def all_blades(signals: xr.Dataset) -> xr.Dataset:
    """Compute the vibration of every blade in every revolution, from gauges on all blades and from
    tip timing.

    Returns:
        For each such sensor NAME: NAME (blade, NAME_turn), half of the range of the strain in each
        revolution, or the deflection at the first probe; NAME_low and NAME_high (blade,), the
        extremes of the signal.

    Raises:
        ViewError: no sensor records all blades, or the rotor does not turn.
    """
    turns = abs(float(signals.attrs["speed"])) / (2.0 * np.pi)
    named = {str(name): signal for name, signal in signals.items() if "type" in signal.attrs}
    chosen = [name for name, signal in named.items() if "blade" in signal.dims][:MOST_PANELS]
    if turns == 0.0:
        raise ViewError("all blades: expected a rotor that turns")
    if not chosen:
        raise ViewError('all blades: expected a gauge with blade = "all", or tip timing')
    blades = labelled(signals, "vibration of all blades", {}, {})
    for name in chosen:
        signal = signals[name]
        if not signal.size:
            raise ViewError(f"all blades: expected a run in which a blade passes {name}")
        if signal.attrs["type"] == "tip-timing":
            moved, number = signal.values[0], signal[f"{name}_revolution"].values
        else:
            passed = np.floor(turns * signal[signal.dims[0]].values + 1e-9)
            number, starts, count = np.unique(passed, return_index=True, return_counts=True)
            high = np.maximum.reduceat(signal.values, starts, axis=0)
            moved = 0.5 * (high - np.minimum.reduceat(signal.values, starts, axis=0)).T
            complete = count > WHOLE * count.max()  # the first and the last may be cut
            number, moved = number[complete], moved[:, complete]
        rest = [dimension for dimension in signal.dims if dimension != "blade"]
        blades[name] = (("blade", f"{name}_turn"), moved, signal.attrs)
        blades.coords[f"{name}_turn"] = (f"{name}_turn", number)
        blades[f"{name}_low"] = ("blade", signal.min(rest).values, signal.attrs)
        blades[f"{name}_high"] = ("blade", signal.max(rest).values, signal.attrs)
    return blades


def over_time(signals: xr.Dataset) -> Iterator[tuple[str, xr.DataArray, float]]:
    """Yield name, signal over the coordinate `time`, and time between samples [s] of the sensors
    that sample in time; if a sensor records all blades, the signal is that of the blade that
    vibrates most.

    Raises:
        ViewError: no sensor samples in time, or a signal is too short.
    """
    kinds = {str(name): signal.attrs.get("type") for name, signal in signals.items()}
    names = [name for name, kind in kinds.items() if kind not in (None, "tip-timing")]
    if not names:
        raise ViewError("expected a sensor with a signal over time; tip timing has none")
    for name in names[:MOST_PANELS]:
        signal = _worst_blade(signals[name])
        over = signal.dims[0]
        alone = signal.to_dataset(name=name).rename({over: "time"} if over != "time" else {})
        even, step = evenly_spaced(alone, FEWEST_RECORDS)
        yield name, even[name], step


def _worst_blade(signal: xr.DataArray) -> xr.DataArray:
    """Return the signal of the blade with the largest standard deviation over time; a signal
    without blades is returned as it is."""
    if "blade" not in signal.dims:
        return signal
    rest = [dimension for dimension in signal.dims if dimension != "blade"]
    blade = int(np.argmax(signal.std(rest).fillna(0.0).values))
    return signal.isel(blade=blade).assign_attrs(blade=blade)


def _modes(result: xr.Dataset, kind: str) -> list[tuple[str, float, float]]:
    """Return name, lowest and highest frequency [Hz] of each group of modes that a sensor of a type
    measures, as far as the stage names its modes. Strain gauges measure the families of the bladed
    disk, wall sensors the lowest casing
    mode of each nodal diameter, centre sensors the modes that move the shaft, in the static
    frame."""
    if kind == "centre":
        lines = modal_lines(result, "static")
        names = [WITH_K.get(str(name), str(name)) for name in lines["mode"].values]
        near = [(name, abs(at), abs(at)) for name, at in zip(names, lines.values, strict=True)]
        near = [line for line in dict.fromkeys(near) if line[0] != ORDER]
    else:
        strain = kind == "strain"
        group = result["rotor_family" if strain else "casing_nodal_diameter"].values
        frequency = result["rotor_frequency" if strain else "casing_frequency"].values
        members = {one: frequency[group == one] for one in np.unique(group) if one != ""}
        near = [
            (str(one) if strain else f"k = {one}", each.min(), each.max() if strain else each.min())
            for one, each in members.items()
        ]
    ordered = sorted(near, key=lambda line: line[1])[: FAMILIES if kind == "strain" else DIAMETERS]
    return [(name, low / (2.0 * np.pi), high / (2.0 * np.pi)) for name, low, high in ordered]


@styled
def plot_sensors(signals: xr.Dataset) -> Figure:
    """Draw the signals from `sensors` over time, in black. If all blades are recorded, the black
    signal is that of the blade that vibrates most; behind it, the range of all blades (for tip
    timing, the points of all blades) is grey."""
    figure, panels = _panels(signals, 0.03)
    for axes, (name, scale) in panels.items():
        signal, worst = signals[name], _worst_blade(signals[name])
        if signal.attrs["type"] == "tip-timing":
            arrival = signals[f"{name}_arrival"]
            at = arrival.sel(blade=worst.attrs["blade"])
            for x, y, colour in ((arrival, signal, PALE), (at, worst, COLOURS["rotor"])):
                axes.plot(x.values.ravel(), scale * y.values.ravel(), ".", color=colour, ms=2.5)
        else:
            time = signal[signal.dims[0]].values
            if "blade" in signal.dims:
                starts = span_starts(time, COLUMNS)
                low = np.minimum.reduceat(signal.min("blade").values, starts)
                high = np.maximum.reduceat(signal.max("blade").values, starts)
                axes.fill_between(time[starts], scale * low, scale * high, color=PALE, linewidth=0)
            axes.plot(*_thinned(time, scale * worst.values), color=COLOURS["rotor"], linewidth=0.6)
    time_axis(*panels)
    figure.align_ylabels([*panels])
    return figure


@styled
def plot_sensor_spectra(spectra: xr.Dataset) -> Figure:
    """Draw amplitudes against frequency from `sensor_spectra`, with the frequencies of modes, and
    with dotted lines at engine orders."""
    turns = abs(float(spectra.attrs["speed"])) / (2.0 * np.pi)
    figure, panels = _panels(spectra, 0.034)
    first = next(iter(panels))
    edge = max(float(spectra[f"{name}_frequency"][-1]) for name, _ in panels.values())
    for axes, (name, scale) in panels.items():
        amplitude = scale * spectra[name].values
        top = float(amplitude.max()) or 1.0
        floor = top * 10**-DECADES
        along = spectra[f"{name}_frequency"]
        axes.semilogy(along, np.maximum(amplitude, floor), color=COLOURS["rotor"])
        axes.set(xlim=(0.0, edge), ylim=(floor, 30.0 * top))
        axes.grid(axis="x", visible=False)
        for low, high in spectra[f"{name}_mode"].values:
            middle, half = 0.5 * (low + high), 0.5 * max(high - low, 2e-3 * edge)
            look: dict[str, Any] = {"color": COLOURS["casing"], "label": "frequencies of modes"}
            axes.axvspan(middle - half, middle + half, alpha=0.5, **look)
        for order in np.arange(1.0, edge / turns) if turns else []:
            look = {"color": COLOURS["rest"], "linestyle": ":", "label": "engine orders"}
            axes.axvline(order * turns, linewidth=0.8, **look)
    if turns:
        functions = (lambda x: np.asarray(x) / turns, lambda x: np.asarray(x) * turns)
        first.secondary_xaxis("top", functions=functions)
        first.set_title("engine order", loc="right")
    axes.set_xlabel("frequency [Hz]")
    plain_exponents(figure)
    if entries := entries_of(*panels):
        figure.legend(*zip(*entries, strict=True), loc="outside lower center", ncols=2)
    figure.align_ylabels([*panels])
    for axes, (name, _) in panels.items():
        labels = Labels(axes, laid_out=axes is not first)
        heights = float(axes.get_ylim()[1]) / np.array([2.5, 15.0, 90.0])
        modes = spectra[f"{name}_line"].values
        for mode, ends in zip(modes, spectra[f"{name}_mode"].values, strict=True):
            labels.add(np.full(len(heights), ends.mean()), heights, str(mode), LABEL)
    return figure


@styled
def plot_sensor_orders(orders: xr.Dataset) -> Figure:
    """Draw amplitudes against engine order and time from `sensor_orders`, with log colours."""
    figure, panels = _panels(orders, 0.045)
    for axes, (name, scale) in panels.items():
        amplitude = scale * orders[name].values
        order, time = (orders[f"{name}_{along}"] for along in ("order", "time"))
        levels = float(amplitude.max()) or 1.0, DECADES
        draw_decades(axes, time, order, amplitude, levels, label=axes.get_ylabel())
        axes.set_ylabel("engine order")
    plain_exponents(figure)
    time_axis(*panels)
    return figure


@styled
def plot_all_blades(blades: xr.Dataset) -> Figure:
    """Draw the vibration of all blades in each revolution from `all_blades`, and the extremes of
    each blade."""
    names = [str(name) for name, moved in blades.items() if f"{name}_low" in blades]
    figure = new_figure(width=FULL_WIDTH, height=0.02 + 0.05 * len(names))
    alone, count = blades.sizes["blade"] == 1, blades.sizes["blade"]
    figure.set_layout_engine("constrained", wspace=0.08)
    rows = rows_of_panels(figure, len(names), [1.0] if alone else [3.0, 1.0])
    for (over_turns, *others), name in zip(rows, names, strict=True):
        unit, scale = shown_unit(blades[name])
        moved, signed = scale * blades[name].values, blades[name].attrs["type"] == "tip-timing"
        reach = float(np.nanmax(np.abs(moved))) or 1.0
        look: dict[str, Any] = {"vmin": 0.0, "vmax": reach}
        if signed:
            look |= {"vmin": -reach, "cmap": COLOUR_MAPS["signed"]}
        number, blade = blades[f"{name}_turn"].values, blades["blade"].values
        word = "deflection" if signed else "half of the range"
        over_turns.set_title(name, loc="left")
        over_turns.locator_params(axis="x", integer=True, nbins=8)
        if alone:
            over_turns.plot(number, moved.ravel(), ".-", color=COLOURS["rotor"], markersize=2.5)
            over_turns.set(ylabel=f"{word} [{unit}]")
            continue
        masked = np.ma.masked_invalid(moved)
        draw_map(over_turns, number, blade, masked, label=f"{word} [{unit}]", **look)
        blade_axis(over_turns, count, of_y=True)
        low, high = (scale * blades[f"{name}_{end}"].values for end in ("low", "high"))
        for extremes in others:
            extremes.set_title(name, loc="left")
            extremes.use_sticky_edges = False
            extremes.bar(blade, high - low, 0.8, low, color=COLOURS["rest"])
            extremes.axhline(0.0, color="black", linewidth=0.6)
            extremes.set(ylabel=f"extremes [{unit}]")
            blade_axis(extremes, count, most=8 if is_narrow(figure) else 3)
        over_turns.set_xlabel("revolution")
    head(figure, blades)
    return figure


def _panels(data: xr.Dataset, height: float) -> tuple[Figure, dict[Axes, tuple[str, float]]]:
    """Return a figure of full width with a panel, `height` [m] high, for each of the first
    `MOST_PANELS` sensors.

    The panels have titles and labels. The dictionary contains for each panel the name of the
    sensor, and the factor from the SI unit to the unit that is shown.
    """
    names = [str(name) for name, signal in data.items() if "type" in signal.attrs]
    shown = names[:MOST_PANELS]
    figure = new_figure(width=FULL_WIDTH, height=0.02 + height * len(shown))
    head(figure, data, "sensors" if shown == names else f"the first {MOST_PANELS} sensors")
    column = figure.subplots(len(shown), 1, squeeze=False, sharex=True)[:, 0]
    panels = {}
    for axes, name in zip(column, shown, strict=True):
        signal = _worst_blade(data[name])
        timing, blade = signal.attrs["type"] == "tip-timing", signal.attrs.get("blade", "all")
        unit, scale = shown_unit(signal)
        axes.set_title(name if blade == "all" else f"{name}, blade {blade}", loc="left")
        axes.set_ylabel(f"{'deflection' if timing else WORDS[signal.attrs['units']]} [{unit}]")
        panels[axes] = name, scale
    return figure, panels


def _thinned(time: Array, values: Array) -> tuple[Array, Array]:
    """Return a curve, or the extremes in each of `COLUMNS` spans of a longer curve."""
    if len(time) <= 2 * COLUMNS:
        return time, values
    starts = span_starts(time, COLUMNS)
    extremes = [ufunc.reduceat(values, starts) for ufunc in (np.minimum, np.maximum)]
    return np.repeat(time[starts], 2), np.stack(extremes, axis=1).ravel()
