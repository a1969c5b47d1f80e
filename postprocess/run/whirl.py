"""Direction and rate of the shaft's whirl as time goes on."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bladewhirl.postprocess.fields.fields import Array, IntArray
from bladewhirl.postprocess.fields.labelled import labelled
from bladewhirl.postprocess.fields.windows import few_time_ticks, span_means, span_starts
from bladewhirl.postprocess.plotting.style import COLOURS, new_figure, speed_label, styled
from bladewhirl.postprocess.plotting.units import length_unit
from bladewhirl.postprocess.run.orbits import CLEAR_SHARE, FRAMES, LEAST_TURN, Frame, shaft_orbit

PERIODS = 2.0
"""Least length of a span, in periods of the reference frequency: ripple is averaged away."""

MOST_SPANS = 40
"""Spans that a run is cut into at most."""

LOOK = {"rotating": ("-", "o", "rotor"), "static": ("--", "s", "casing")}
"""Line, marker and colour of each frame."""


def whirl_history(
    result: xr.Dataset, *, start: float | None = None, end: float | None = None
) -> xr.Dataset:
    """Mean rate and direction of the whirl in equal spans of time, in both frames.

    The rate is that of `orbits.whirl`, the sum of x cross v over the sum of r^2 in the span, and
    so is the rule by which a direction is clear enough to be given.

    Args:
        result: of a run, or its orbit from `orbits.shaft_orbit`.
        start: of the window [s]; of the run when None.
        end: of the window [s]; of the run when None.

    Returns:
        over (frame, time), time being the middle of each span: `rate` [rad/s], positive
        counter-clockwise, nan where the shaft rests; `direction`, 1 forward (in the sense of
        rotation), -1 backward, 0 where the motion hardly goes round; over time: `radius` [m],
        root mean square. Attribute `span`, the length of each [s].

    Example:
        ``whirl_history(result)["rate"].sel(frame="static").plot()``
    """
    orbit = shaft_orbit(result, start=start, end=end)
    time = orbit["time"].values
    period = 2 * np.pi / orbit.attrs["reference_frequency"]
    spans = int(np.clip(np.ptp(time) / (PERIODS * period), 1, MOST_SPANS))
    starts = span_starts(time, spans)
    length = np.ptp(time) / spans
    square = span_means(orbit["radius"].values ** 2, starts)
    found = [_turning(orbit, frame, starts, square, length) for frame in FRAMES]
    sense = -1 if orbit.attrs["speed"] < 0 else 1
    both = ("frame", "time")
    return labelled(
        orbit,
        "whirl of the shaft over time",
        {
            "rate": (both, [rate for rate, _ in found], "rad/s"),
            "direction": (both, [sense * direction for _, direction in found], "1"),
            "radius": ("time", np.sqrt(square), "m"),
        },
        {"time": span_means(time, starts), "frame": [*FRAMES]},
        span=length,
    )


def _turning(
    orbit: xr.Dataset, frame: Frame, starts: IntArray, square: Array, length: float
) -> tuple[Array, IntArray]:
    """Rate and direction, positive counter-clockwise, in each span."""
    (x, y), (u, v) = orbit[frame].values.T, orbit[f"{frame}_velocity"].values.T
    around = span_means(x * v - y * u, starts)
    moved = span_means(np.hypot(x, y) * np.hypot(u, v), starts)
    moving = square > 0
    rate = np.divide(around, square, out=np.full(len(square), np.nan), where=moving)
    turned = np.abs(np.nan_to_num(rate)) * length >= LEAST_TURN * 2 * np.pi
    clear = moving & turned & (np.abs(around) >= CLEAR_SHARE * moved)
    return rate, np.where(clear, np.sign(around), 0.0).astype(np.int64)


@styled
def plot_whirl_history(whirls: xr.Dataset) -> Figure:
    """Draw the whirl in both frames over time in Hz, forward upwards, above the orbit's radius.

    Filled marks have a clear direction. The two lines differ by the speed of rotation.

    Args:
        whirls: from `whirl_history`.
    """
    figure = new_figure(height=0.075)
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(2.2, 1.0))
    time = whirls["time"].values
    for frame in FRAMES:
        _draw_frame(upper, whirls.sel(frame=frame), frame)
    upper.axhline(0.0, color=COLOURS["rotor"], linewidth=0.6)
    upper.set_ylabel("whirl [Hz]\n← backward  forward →")
    upper.margins(y=0.1)
    unit, scale = length_unit(float(whirls["radius"].max()))
    lower.plot(time, scale * whirls["radius"], color=COLOURS["rotor"])
    lower.set(xlabel="time [s]", ylabel=f"radius [{unit}]")
    lower.set_ylim(bottom=0.0)
    few_time_ticks(lower)
    figure.legend(*upper.get_legend_handles_labels(), loc="outside lower center", ncols=2)
    upper.set_title(f"{speed_label(whirls)}, means over {1e3 * whirls.attrs['span']:.3g} ms")
    return figure


def _draw_frame(axes: Axes, whirls: xr.Dataset, frame: Frame) -> None:
    line, marker, key = LOOK[frame]
    sense = -1.0 if whirls.attrs["speed"] < 0 else 1.0
    time, rate = whirls["time"].values, sense * whirls["rate"].values / (2 * np.pi)
    colour = COLOURS[key]
    clear = whirls["direction"].values != 0
    axes.plot(
        time,
        rate,
        line,
        marker=marker,
        color=colour,
        markersize=2.5,
        markerfacecolor="white",
        markeredgewidth=0.6,
        label=f"{frame} frame",
    )
    axes.plot(time[clear], rate[clear], marker, color=colour, markersize=2.5)
