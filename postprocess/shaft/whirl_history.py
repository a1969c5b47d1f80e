"""Direction and rate of the shaft's whirl over time."""

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from bladewhirl.models.inputs.units import handy_unit
from bladewhirl.postprocess.fields.kinematics import Array, IntArray
from bladewhirl.postprocess.fields.labelled import labelled
from bladewhirl.postprocess.fields.windows import span_means, span_starts
from bladewhirl.postprocess.plotting.style import COLOURS, new_figure, styled, time_axis
from bladewhirl.postprocess.plotting.titles import head
from bladewhirl.postprocess.shaft.orbits import shaft_orbit
from bladewhirl.postprocess.shaft.transforms import Frame
from bladewhirl.postprocess.shaft.whirl import FRAMES, LEAST_TURN, phase, span_rates

#: smallest length of a span [periods of the reference frequency], so that ripple averages out
PERIODS = 2.0
MOST_SPANS = 40  #: largest number of spans of a run
LOOK = {"rotating": ("-", "o", "rotor"), "static": ("--", "s", "casing")}
"""Line, marker and colour of each frame."""


def whirl_history(
    result: xr.Dataset, *, start: float | None = None, end: float | None = None
) -> xr.Dataset:
    """Compute mean rate and direction of the whirl in equal spans of time, in both frames.

    The rate is the slope of the unwrapped angle about the bearing's centre, as in `whirl.whirl`.
    The whirl has a direction in a span if the angle changes by at least a tenth of a turn, and by
    at least one turn for each pair of records between which the path may have passed the centre on
    either side.

    Args:
        result: result of a run, or its orbit from `orbits.shaft_orbit`.
        start, end: limits of the time window [s]; start and end of the run when None.

    Returns:
        Dataset over (frame, time), where time is the middle of each span: `rate` [rad/s], positive
        for forward motion (in the sense of rotation), nan if the shaft is at rest; `direction`, 1
        for forward, -1 for backward, 0 for no clear direction. Over time: `radius` [m], root mean
        square of the displacement. The attribute `span` is the length of a span [s].

    Example:
        ``whirl_history(result)["rate"].sel(frame="static").plot()``
    """
    orbit = shaft_orbit(result, start=start, end=end)
    time = orbit["time"].values
    starts, length = _spans(orbit)
    square = span_means(orbit["radius"].values ** 2, starts)
    turning = [_turning(orbit, frame, starts, square, length) for frame in FRAMES]
    both = ("frame", "time")
    return labelled(
        orbit,
        "whirl of the shaft over time",
        {
            "rate": (both, [rate for rate, _ in turning], "rad/s"),
            "direction": (both, [direction for _, direction in turning], "1"),
            "radius": ("time", np.sqrt(square), "m"),
        },
        {"time": span_means(time, starts), "frame": [*FRAMES]},
        span=length,
    )


def rotating_rates(orbit: xr.Dataset) -> Array:
    """Return the rates of `whirl_history` in rotating axes [rad/s], (span,)."""
    starts, _ = _spans(orbit)
    square = span_means(orbit.variables["radius"].values ** 2, starts)
    return _rates(orbit, phase(orbit, "rotating")[0], starts, square)


def _spans(orbit: xr.Dataset) -> tuple[IntArray, float]:
    """Return the first record of each span, and the length of a span [s]."""
    time = orbit.variables["time"].values
    period = 2 * np.pi / orbit.attrs["reference_frequency"]
    spans = int(np.clip(np.ptp(time) / (PERIODS * period), 1, MOST_SPANS))
    return span_starts(time, spans), float(np.ptp(time) / spans)


def _rates(orbit: xr.Dataset, angle: Array, starts: IntArray, square: Array) -> Array:
    """Return the rate in each span [rad/s], (span,); nan where the shaft is at rest."""
    rate = span_rates(orbit.variables["time"].values, angle, starts)
    return np.where(square > 0, rate, np.nan)


def _turning(
    orbit: xr.Dataset, frame: Frame, starts: IntArray, square: Array, length: float
) -> tuple[Array, IntArray]:
    """Return rate and direction in each span, both positive for forward whirl."""
    angle, doubtful = phase(orbit, frame)
    rate = _rates(orbit, angle, starts, square)
    turns = np.nan_to_num(rate) * length / (2 * np.pi)
    lost = np.add.reduceat(np.append(doubtful, False).astype(np.int64), starts)
    clear = np.abs(turns) >= np.maximum(LEAST_TURN, lost)
    return rate, np.where(clear, np.sign(turns), 0.0).astype(np.int64)


@styled
def plot_whirl_history(whirls: xr.Dataset) -> Figure:
    """Draw the frequency of the whirl from `whirl_history` in both frames over time, forward
    positive, and below it the radius of the orbit.

    Spans with a clear direction have filled marks.
    """
    figure = new_figure(height=0.085)
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(2.2, 1.0))
    time = whirls["time"].values
    for frame, (line, marker, key) in LOOK.items():
        one = whirls.sel(frame=frame)
        rate, clear = one["rate"].values / (2 * np.pi), one["direction"].values != 0
        look: dict[str, Any] = {"marker": marker, "color": COLOURS[key], "markersize": 2.5}
        upper.plot(time, rate, line, mfc="white", mew=0.6, **look)
        upper.plot(time[clear], rate[clear], linestyle="none", **look)
        upper.plot([], [], line, label=f"{frame} frame", **look)
    upper.axhline(0.0, color=COLOURS["rotor"], linewidth=0.6)
    upper.set_ylabel("whirl [Hz]\n← backward  forward →")
    upper.margins(y=0.1)
    unit, scale = handy_unit(float(whirls["radius"].max()), "m")
    lower.plot(time, scale * whirls["radius"], color=COLOURS["rotor"])
    lower.set_ylabel(f"radius [{unit}]")
    lower.set_ylim(bottom=0.0, top=1.12 * scale * float(whirls["radius"].max()) or 1.0)
    time_axis(upper, lower)
    figure.legend(*upper.get_legend_handles_labels(), loc="outside lower center", ncols=2)
    head(figure, whirls, f"means over {1e3 * whirls.attrs['span']:.3g} ms")
    return figure
