"""Whirl of the shaft: net turns about the bearing's centre.

A whirl has a frequency where its phase has net turns: the slope of the unwrapped angle about the
bearing's centre. The mean of x cross v over that of r^2 is not one: a small fast component enters
it with its own rate times its amplitude squared. Frequencies are positive for forward motion, in
the sense of rotation (+theta at standstill).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import xarray as xr

from bladewhirl.meshes.line_mesh import BoolArray
from bladewhirl.postprocess.energy.growth_rates import CERTAINTY
from bladewhirl.postprocess.fields.kinematics import Array, IntArray
from bladewhirl.postprocess.fields.windows import span_starts
from bladewhirl.postprocess.shaft.transforms import LOBE, Frame, phasor, strongest_lines

Direction = Literal["forward", "backward", "none"]
FRAMES: tuple[Frame, Frame] = ("rotating", "static")

LEAST_TURN = 0.1
"""Turns about the origin that a motion must make before its whirl is given a direction."""

LEAST_CERTAIN = 10.0
"""Standard errors that a rate has to exceed."""

LARGEST_SHARE = 0.5
"""Share of the mean square that the line at the rate must have."""

SPANS = 10  #: spans whose rates give the standard error of the rate
DOUBTFUL = 0.5 * np.pi
"""Angle between two records from which on they may lie on either side of the centre [rad]."""


@dataclass(frozen=True, kw_only=True)
class Whirl:
    """Net turns of an orbit about the bearing's centre; forward is positive."""

    rate: float  #: slope of the unwrapped angle [rad/s]; nan at rest
    error: float  #: standard error of it [rad/s]; nan where too short to tell
    goes_round: bool  #: the rate is one: the angle goes on by more than it swings to and fro

    @property
    def direction(self) -> Direction:
        """Direction of the whirl; forward is the sense of rotation."""
        if not self.goes_round:
            return "none"
        return "forward" if self.rate > 0 else "backward"

    @property
    def frequency(self) -> float | None:
        """Net turns a second [Hz], forward positive; None where no single rate exists."""
        return self.rate / (2 * np.pi) if self.goes_round else None

    @property
    def text(self) -> str:
        """Direction, frequency and `CERTAINTY` standard errors of it, in words."""
        if self.frequency is None:
            return "no single frequency"
        wide = CERTAINTY * self.error / (2 * np.pi)
        error = f" ± {float(f'{wide:.1g}'):g}" if wide > 5e-4 * abs(self.frequency) else ""
        return f"{self.direction}, {abs(self.frequency):.3g}{error} Hz"


def whirl(orbit: xr.Dataset, frame: Frame) -> Whirl:
    """Net turns about the bearing's centre over the records given.

    The rate is the slope of a straight line through the unwrapped angle; between the frames it
    differs by the speed exactly. Its error is that of the mean of the slopes in ten equal spans,
    so it counts how the rate wanders rather than how many records there are. There is no single
    rate where the angle turns on by less than a tenth of a turn, than it swings about that line
    (an orbit that leaves the centre outside, such as a ripple about a steady place), or than ten
    standard errors. A place that turns by more than a quarter turn between two records may have
    passed the centre on either side: each adds a turn to what has to be exceeded. Nor is there one
    where no line of half the mean square lies at the rate: net turns of several circles, none
    larger than all others together, are a mean that nothing turns at.

    Args:
        orbit: from `orbits.shaft_orbit`, of the time considered.
        frame: of the observer.
    """
    time = orbit["time"].values
    if len(time) < 2 or not orbit["radius"].values.any():
        return Whirl(rate=float("nan"), error=float("nan"), goes_round=False)
    angle, doubtful = phase(orbit, frame)
    rate = _slope(time, angle)
    turned = abs(rate) * np.ptp(time)
    swing = np.ptp(angle - rate * time) + 2 * np.pi * np.count_nonzero(doubtful)
    error = _slope_error(time, angle)
    return Whirl(
        rate=rate,
        error=error,
        goes_round=bool(
            turned >= LEAST_TURN * 2 * np.pi
            and turned > swing
            and not abs(rate) <= LEAST_CERTAIN * error
            and _has_line(orbit, frame, rate, error)
        ),
    )


def _has_line(orbit: xr.Dataset, frame: Frame, rate: float, error: float) -> bool:
    """A line of half the mean square lies at the rate, within its width or the error of the rate;
    also where a spectrum says nothing.
    """
    lines = strongest_lines(orbit, "rotating")
    time = orbit["time"].values
    near = max(2 * np.pi * LOBE / np.ptp(time), CERTAINTY * np.nan_to_num(error))
    rotating = rate - (abs(float(orbit.attrs["speed"])) if frame == "static" else 0.0)
    return not lines or any(
        abs(2 * np.pi * line.frequency - rotating) <= near and line.share >= LARGEST_SHARE
        for line in lines
    )


def phase(orbit: xr.Dataset, frame: Frame) -> tuple[Array, BoolArray]:
    """Unwrapped angle about the bearing's centre [rad], forward positive, and where it is in doubt.

    Args:
        orbit: from `orbits.shaft_orbit`.
        frame: of the observer.

    Returns:
        angle (time,); whether the step after each record may go either way round, (time - 1,).
    """
    angle = np.unwrap(np.angle(phasor(orbit, "rotating")))
    doubtful = np.abs(np.diff(angle)) > DOUBTFUL
    speed = abs(float(orbit.attrs["speed"]))
    carried = speed * orbit["time"].values if frame == "static" else 0.0
    return angle + carried, doubtful


def ripple(orbit: xr.Dataset, frame: Frame) -> tuple[float, xr.Dataset]:
    """Motion about its mean place: root mean square [m], and the orbit of it about that place.

    Args:
        orbit: from `orbits.shaft_orbit`, of the time considered.
        frame: in which the place is; the orbit has it as `rotating`.
    """
    place = orbit[frame].values
    about = place - place.mean(axis=0)
    size = float(np.sqrt(np.mean(np.sum(about**2, axis=1))))
    return size, orbit[["radius"]].assign(rotating=(("time", "axis"), about))


def span_rates(time: Array, angle: Array, starts: IntArray) -> Array:
    """Slope of the angle in each span [rad/s]; nan in one of a single record."""
    parts = zip(np.split(time, starts[1:]), np.split(angle, starts[1:]), strict=True)
    return np.array([_slope(t, a) if len(t) > 1 else np.nan for t, a in parts])


def _slope(time: Array, angle: Array) -> float:
    """Return the slope of the straight line fitted to the angle by least squares [rad/s]."""
    covariance = np.cov(time, angle, bias=True)
    return float(covariance[0, 1] / covariance[0, 0])


def _slope_error(time: Array, angle: Array) -> float:
    rates = span_rates(time, angle, span_starts(time, SPANS))
    finite = rates[np.isfinite(rates)]
    return float(finite.std(ddof=1) / np.sqrt(len(finite))) if len(finite) > 1 else float("nan")
