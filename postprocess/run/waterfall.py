"""Waterfall of a run whose speed varies: spectra of short windows of time over their speeds."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bladewhirl.postprocess.fields import rotation
from bladewhirl.postprocess.fields.by_blade import contact_motion
from bladewhirl.postprocess.fields.kinematics import Array, ViewError
from bladewhirl.postprocess.fields.labelled import labelled
from bladewhirl.postprocess.fields.windows import evenly_spaced
from bladewhirl.postprocess.plotting.axes import draw_decades
from bladewhirl.postprocess.plotting.legends import Group, entries_of, legends_below
from bladewhirl.postprocess.plotting.style import COLOURS, FULL_WIDTH, OUTLINE, new_figure, styled
from bladewhirl.postprocess.plotting.titles import head
from bladewhirl.postprocess.run.sensor_figures import ORDERS, over_time
from bladewhirl.postprocess.run.sensors import shown_unit
from bladewhirl.postprocess.shaft.spectra import DECADES, slices
from bladewhirl.postprocess.shaft.transforms import FEWEST_RECORDS, Complex, phasor

SPEEDS = 80  #: number of columns of a panel
SHAFT_ORDERS = 4.0  #: frequencies of the shaft are drawn up to this multiple of the fastest speed
MOST_LINES = 10  #: largest order whose line is drawn
FRAMES = {"shaft": "static frame", "tip": "tangential, rotating frame"}
"""Axes of the motions that are no signals of sensors."""

SENSES = {1: "rising speed", -1: "falling speed"}
RPM = 30.0 / np.pi


def shaft_waterfall(orbit: xr.Dataset) -> xr.Dataset:
    """Compute the amplitude of the shaft against frequency in windows of time, in static axes.

    The length of a window is that in which the mean change of the frequency of rotation is as large
    as the resolution of the window, twice this because its ends have little weight.

    Args:
        orbit: from `orbits.shaft_orbit`, of a run whose speed varies.

    Returns:
        Dataset over `time` [s], the middle of each window: `shaft` (frequency, time), the amplitude
        [m]; `frequency` [rad/s], forward positive; `speed` [rad/s], the mean speed in a window; and
        `rising`, 1 while the magnitude of the speed rises, -1 while it falls, 0 at constant speed.

    Raises:
        ViewError: there are too few records, or they are not equally spaced.
    """
    even, step = evenly_spaced(orbit, FEWEST_RECORDS)
    return _of_motion(even, "shaft", phasor(even, "static"), step)


def tip_waterfall(result: xr.Dataset) -> xr.Dataset:
    """Compute the amplitude of the tangential displacement of the contact node that swings most,
    in rotating axes; see `shaft_waterfall`.

    Args:
        result: result of a run whose speed varies.

    Returns:
        Dataset as from `shaft_waterfall`, with the amplitude `tip` [m] and frequencies from zero.
    """
    even, step = evenly_spaced(result, FEWEST_RECORDS)
    every = contact_motion(even, 1)
    swing = every[:, int(np.nanargmax(np.ptp(every, axis=0)))]
    return _of_motion(even, "tip", swing - swing.mean(), step)


def _of_motion(even: xr.Dataset, name: str, motion: Array | Complex, step: float) -> xr.Dataset:
    """Return the waterfall of a motion in a plane, or of a real one, whose frequencies are not
    negative.

    Args:
        even: result or orbit with equally spaced records.
        name: name of the amplitude.
        motion: motion at the records [m], (time,).
        step: time between the records [s].
    """
    plane = np.iscomplexobj(motion)
    windows = _windows(even, motion.astype(complex), step, even.variables["time"].values)
    edge = (SHAFT_ORDERS if plane else ORDERS) * np.abs(windows["speed"]).max() / (2.0 * np.pi)
    shown = np.abs(windows["frequency"]) <= edge
    shown &= plane | (windows["frequency"] >= 0.0)
    amplitude = (1.0 if plane else 2.0) * np.abs(windows["amplitude"][:, shown]).T
    return labelled(
        even,
        f"waterfall of the {name}",
        {
            name: (("frequency", "time"), amplitude, "m"),
            "speed": ("time", windows["speed"], "rad/s"),
            "rising": ("time", windows["rising"], "1"),
        },
        {"frequency": 2.0 * np.pi * windows["frequency"][shown], "time": windows["middle"]},
    )


def sensor_waterfall(signals: xr.Dataset, result: xr.Dataset) -> xr.Dataset:
    """Compute the amplitude of each signal against frequency in windows of time.

    Args:
        signals: signals from `sensors`; strains of all blades and tip timing as in
            `sensor_figures.sensor_spectra`.
        result: result of the same run.

    Returns:
        Dataset with the variables NAME (NAME_frequency, NAME_time), in the unit of the signal,
        NAME_speed and NAME_rising (NAME_time,) for each sensor NAME, as in `shaft_waterfall`.

    Raises:
        ViewError: there is no signal over time, or a signal is too short.
    """
    named = labelled(result, "waterfall of sensors", {}, {})
    for name, signal, step in over_time(signals):
        time, values = signal["time"].values, signal.values - signal.values.mean()
        windows = _windows(result, values.astype(complex), step, time)
        edge = ORDERS * float(np.abs(windows["speed"]).max()) / (2.0 * np.pi)
        shown = (windows["frequency"] >= 0.0) & (windows["frequency"] <= edge)
        over = (f"{name}_frequency", f"{name}_time")
        amplitude = 2.0 * np.abs(windows["amplitude"][:, shown]).T
        frequency = 2.0 * np.pi * windows["frequency"][shown]
        named[name] = (over, amplitude, signal.attrs)
        named[f"{name}_speed"] = (over[1], windows["speed"], {"units": "rad/s"})
        named[f"{name}_rising"] = (over[1], windows["rising"], {"units": "1"})
        named.coords[over[0]] = (over[0], frequency, {"units": "rad/s"})
        named.coords[over[1]] = (over[1], windows["middle"], {"units": "s"})
    return named


def _windows(result: xr.Dataset, motion: Complex, step: float, time: Array) -> Mapping[str, Any]:
    """Return spectra of overlapping windows of a motion with their mean speeds.

    Args:
        result: result or orbit with angle and speed.
        motion: samples, (samples,).
        step: time between samples [s].
        time: time of each sample [s], (samples,).

    Returns:
        `frequency` [Hz], ascending; `amplitude` (windows, frequencies); and of each window `middle`
        [s], mean `speed` [rad/s] and `rising`.
    """
    speeds = np.abs(rotation.speed_at(result, time)) / (2.0 * np.pi)
    rate = np.abs(np.diff(speeds)).sum() / (time[-1] - time[0])
    length = min(2.0 / np.sqrt(rate), 0.5 * (time[-1] - time[0])) if rate > 0.0 else None
    period = 2.0 * np.pi / float(result.attrs["reference_frequency"])
    frequency, amplitude, first, size = slices(motion, step, period, length)
    begin, end = time[first], time[first + size - 1]
    turned = rotation.angle_at(result, end) - rotation.angle_at(result, begin)
    gained = np.abs(rotation.speed_at(result, end)) - np.abs(rotation.speed_at(result, begin))
    steady = np.abs(gained) <= 1e-9 * 2.0 * np.pi * speeds.max()
    return {
        "frequency": frequency,
        "amplitude": amplitude,
        "middle": 0.5 * (begin + end),
        "speed": turned / (end - begin),
        "rising": np.where(steady, 0.0, np.sign(gained)),
    }


@styled
def plot_waterfall(data: xr.Dataset) -> Figure:
    """Draw the waterfall of the shaft, of a tip, or of sensors: frequency against speed with
    logarithmic colours, lines of orders and, if the data have them, critical speeds; rising and
    falling speed in panels of their own."""
    names = [str(name) for name, values in data.items() if len(values.dims) == 2]
    senses = [
        sense
        for sense in SENSES
        if any((data[_of(data, name, "rising")].values == sense).sum() > 1 for name in names)
    ]
    if not senses:
        raise ViewError("waterfall: expected a speed that changes over several windows of time")
    figure = new_figure(width=FULL_WIDTH, height=0.02 + 0.07 * len(names))
    panels = figure.subplots(len(names), len(senses), squeeze=False, sharey="row")
    for row, name in zip(panels, names, strict=True):
        speed, rising = (data[_of(data, name, part)].values for part in ("speed", "rising"))
        values, unit, scale = data[name], "mm", 1e3
        if "type" in values.attrs:
            unit, scale = shown_unit(values)
        top = scale * float(values.max()) or 1.0
        hertz = data[values.dims[0]].values / (2.0 * np.pi)
        for axes, sense in zip(row, senses, strict=True):
            chosen = np.flatnonzero(rising == sense)
            _draw(axes, np.abs(speed[chosen]), hertz, scale * values.values[:, chosen], top)
            axes.set_title(f"{name}, {SENSES[sense]}")
            _draw_critical(axes, data)
        row[0].set_ylabel("frequency [Hz]")
        figure.colorbar(row[-1].collections[0], ax=row.tolist(), label=f"amplitude [{unit}]")
    for axes in panels[-1]:
        axes.set_xlabel("speed [rpm]")
    head(figure, data, *(FRAMES[name] for name in names if name in FRAMES))
    legends_below(figure, Group(entries_of(*panels.flat)))
    return figure


def _draw_critical(axes: Axes, data: xr.Dataset) -> None:
    """Draw the critical speeds within the speeds of a panel."""
    low, high = axes.get_xlim()
    for speed in RPM * data["critical_speed"].values if "critical_speed" in data else ():
        if low <= speed <= high:
            look: dict[str, Any] = {"color": COLOURS["suspension"], "path_effects": OUTLINE}
            axes.axvline(speed, label="critical speed", linewidth=0.9, **look)


def _of(data: xr.Dataset, name: str, part: str) -> str:
    return f"{name}_{part}" if f"{name}_{part}" in data else part


def _draw(axes: Axes, speed: Array, hertz: Array, values: Array, top: float) -> None:
    """Draw amplitudes (frequencies, windows) over the speeds of the windows [rad/s]; each column
    shows the window whose speed is nearest."""
    columns = np.linspace(speed.min(), speed.max(), SPEEDS) if len(speed) > 1 else speed
    nearest = np.abs(columns[:, None] - speed).argmin(axis=1)
    draw_decades(axes, RPM * columns, hertz, values[:, nearest], (top, DECADES))
    low, high = hertz[[0, -1]]
    ends = columns[[0, -1]]
    for order in range(-MOST_LINES, MOST_LINES + 1):
        lines = order * ends / (2.0 * np.pi)
        if order and low <= lines[-1] <= high:
            axes.plot(RPM * ends, lines, color="black", linewidth=0.6, linestyle=":")
            axes.annotate(
                f"{order}×".replace("-", "−"),
                (RPM * ends[-1], lines[-1]),
                path_effects=OUTLINE,
                ha="right",
                va="bottom",
            )
    axes.set_ylim(low, high)
