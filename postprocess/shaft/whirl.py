"""Whirl of the shaft: net turns about the bearing's centre.

The rate of a whirl is the slope of the unwrapped angle of the shaft about the bearing's centre. It
differs from the mean of x cross v divided by the mean of r^2: this quotient is the mean of the
rates of all circular components of the motion, weighted by their squared amplitudes, so that a
small, fast component changes it. Rates and frequencies are positive for forward motion, in the
sense of rotation (+theta at standstill).
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial
from typing import Literal

import numpy as np
import xarray as xr

from bladewhirl.meshes.line_mesh import BoolArray, ComplexArray
from bladewhirl.postprocess.energy.growth_rates import CERTAINTY
from bladewhirl.postprocess.fields import rotation
from bladewhirl.postprocess.fields.kinematics import Array, IntArray
from bladewhirl.postprocess.fields.windows import span_starts
from bladewhirl.postprocess.shaft.transforms import (
    LOBE,
    Frame,
    SpectralLine,
    phasor,
    strongest_lines,
)

Direction = Literal["forward", "backward", "none"]
FRAMES: tuple[Frame, Frame] = ("rotating", "static")

LEAST_TURN = 0.1  #: a whirl has a direction if it makes at least this many turns about the origin
LEAST_CERTAIN = 10.0  #: number of standard errors that the rate of a whirl must exceed
#: a whirl has a single frequency if its spectral line has at least this share of the mean square
LARGEST_SHARE = 0.5
SPANS = 10  #: number of spans whose rates give the standard error of the rate
STILL = 0.05
"""A shaft rests in a frame if the root mean square of its motion about the mean position is at most
this fraction of the mean displacement."""
ROUNDING = 1e-9
"""A shaft rests if its radius is at most this fraction of the clearance."""
DOUBTFUL = 0.5 * np.pi
"""If the angle changes by more than this between two records [rad], it is uncertain on which side
the path has passed the centre."""


@dataclass(frozen=True, kw_only=True)
class Whirl:
    """Net turns of an orbit about the bearing's centre; forward is positive."""

    rate: float  #: slope of the unwrapped angle [rad/s]; nan at rest
    error: float  #: standard error of `rate` [rad/s]; nan if the motion is too short
    goes_round: bool  #: true if there is a single whirl frequency, see `whirl`
    rests: bool  #: true if the position does not change in the frame, see `STILL`

    @property
    def direction(self) -> Direction:
        """Direction of the whirl; forward is the sense of rotation."""
        if not self.goes_round:
            return "none"
        return "forward" if self.rate > 0 else "backward"

    @property
    def frequency(self) -> float | None:
        """Net turns per second [Hz], forward positive; None if there is no single whirl
        frequency."""
        return self.rate / (2 * np.pi) if self.goes_round else None

    @property
    def text(self) -> str:
        """Direction and frequency with `CERTAINTY` standard errors, or that the shaft rests."""
        if self.rests:
            return "at rest"
        if self.frequency is None:
            return "no single frequency"
        wide = CERTAINTY * self.error / (2 * np.pi)
        error = f" ± {float(f'{wide:.1g}'):g}" if wide > 5e-4 * abs(self.frequency) else ""
        return f"{self.direction}, {abs(self.frequency):.3g}{error} Hz"


def whirl(orbit: xr.Dataset, frame: Frame) -> Whirl:
    """Compute the net turns about the bearing's centre over all records of an orbit from
    `orbits.shaft_orbit`.

    The rate is the slope of a straight line fitted to the unwrapped angle; the rates in the two
    frames differ exactly by the speed. The error is the standard error of the mean of the slopes in
    ten equal spans of time. It measures the variation of the rate.

    There is a single whirl frequency if four conditions hold. The fitted angle changes by a tenth
    of a turn or more. It changes by more than the angle oscillates about the fitted line; this
    excludes orbits that do not enclose the centre, such as a ripple about a steady position. The
    rate is larger than ten standard errors. The spectrum has a line at the rate with half of the
    mean square or more; otherwise the rate is only a mean of the rates of several circular motions.
    If the position turns by more than a quarter turn between two records, the path may have passed
    the centre on either side: each such pair of records adds one turn to the oscillation.
    """
    return whirls(orbit)[frame]


def whirls(orbit: xr.Dataset) -> dict[Frame, Whirl]:
    """Compute the net turns in both frames, see `whirl`."""
    time = orbit.variables["time"].values
    if len(time) < 2 or centre_rests(orbit):
        still = Whirl(rate=float("nan"), error=float("nan"), goes_round=False, rests=True)
        return dict.fromkeys(FRAMES, still)
    angle, doubtful = phase(orbit, "rotating")
    lost, turned = 2 * np.pi * np.count_nonzero(doubtful), _turned(orbit)
    place = phasor(orbit, "rotating")
    lines = cache(partial(strongest_lines, orbit, "rotating"))  # of both frames
    return {
        "rotating": _whirl(time, angle, lost, 0.0, lines, rests=_rests(place)),
        "static": _whirl(
            time,
            angle + turned,
            lost,
            rotation.mean_speed(orbit),
            lines,
            rests=_rests(place * np.exp(1j * turned)),
        ),
    }


def centre_rests(orbit: xr.Dataset) -> bool:
    """Return whether the shaft's centre moves by rounding errors only, see `ROUNDING`."""
    radius = float(orbit.variables["radius"].values.max())
    clearance = float(orbit.attrs.get("smallest_clearance", 0.0))  # a made-up orbit has none
    return radius <= (ROUNDING * clearance if np.isfinite(clearance) else 0.0)


def _rests(place: ComplexArray) -> bool:
    """Return whether a path rests, see `STILL`."""
    return bool(place.std() <= STILL * abs(place.mean()))


def _whirl(
    time: Array,
    angle: Array,
    lost: float,
    speed: float,
    lines: Callable[[], tuple[SpectralLine, ...]],
    *,
    rests: bool,
) -> Whirl:
    """Return the net turns of an unwrapped angle in a frame.

    Args:
        time: times of the records [s], (time,).
        angle: unwrapped angle [rad], (time,).
        lost: angle of the turns that may be missed between records [rad].
        speed: speed of the rotating axes in this frame [rad/s].
        lines: function that returns the spectral lines in rotating axes.
        rests: whether the position is constant in this frame.
    """
    rate, error = _slope(time, angle), _slope_error(time, angle)
    turned = abs(rate) * np.ptp(time)
    return Whirl(
        rate=rate,
        error=error,
        rests=rests,
        goes_round=bool(
            turned >= LEAST_TURN * 2 * np.pi
            and turned > np.ptp(angle - rate * time) + lost
            and not abs(rate) <= LEAST_CERTAIN * error
            and _has_line(lines(), rate - speed, error, float(np.ptp(time)))
        ),
    )


def _has_line(lines: tuple[SpectralLine, ...], rate: float, error: float, length: float) -> bool:
    """Return true if the spectrum of a motion of some length [s] has a line with half of the mean
    square or more at the rate, within the width of the line or the error of the rate. Also return
    true if there is no spectral line, for instance because the motion is too short.
    """
    near = max(2 * np.pi * LOBE / length, CERTAINTY * np.nan_to_num(error))
    return not lines or any(
        abs(2 * np.pi * line.frequency - rate) <= near and line.share >= LARGEST_SHARE
        for line in lines
    )


def phase(orbit: xr.Dataset, frame: Frame) -> tuple[Array, BoolArray]:
    """Return the unwrapped angle of an orbit about the bearing's centre [rad], positive for forward
    motion, and a mask of the steps in which the number of turns is uncertain.

    Returns:
        angle (time,); mask (time - 1,), true if the path may have passed the centre on either side
        between a record and the next record, see `DOUBTFUL`.
    """
    angle = np.unwrap(np.angle(phasor(orbit, "rotating")))
    doubtful = np.abs(np.diff(angle)) > DOUBTFUL
    carried = _turned(orbit) if frame == "static" else 0.0
    return angle + carried, doubtful


def _turned(orbit: xr.Dataset) -> Array:
    """Return the angle of the rotor in its sense of rotation at every record [rad], (time,)."""
    return np.asarray(rotation.angles(orbit) * (-1.0 if orbit.attrs["speed"] < 0.0 else 1.0))


def ripple(orbit: xr.Dataset, frame: Frame) -> tuple[float, xr.Dataset]:
    """Return root mean square [m] and orbit of the ripple, the motion about the mean position. The
    mean position is computed in the given frame. The variable `rotating` of the returned orbit is
    the ripple in this frame."""
    place = orbit[frame].values
    about = place - place.mean(axis=0)
    size = float(np.sqrt(np.mean(np.sum(about**2, axis=1))))
    kept = orbit[["radius", *rotation.histories(orbit)]]
    return size, kept.assign(rotating=(("time", "axis"), about))


def span_rates(time: Array, angle: Array, starts: IntArray) -> Array:
    """Return the slope of the angle in each span [rad/s]; nan for a span with a single record."""
    parts = zip(np.split(time, starts[1:]), np.split(angle, starts[1:]), strict=True)
    return np.array([_slope(t, a) if len(t) > 1 else np.nan for t, a in parts])


def _slope(time: Array, angle: Array) -> float:
    """Return the slope of the straight line fitted to the angle by least squares [rad/s]."""
    about = time - time.mean()
    return float(about @ (angle - angle.mean()) / (about @ about))


def _slope_error(time: Array, angle: Array) -> float:
    rates = span_rates(time, angle, span_starts(time, SPANS))
    finite = rates[np.isfinite(rates)]
    return float(finite.std(ddof=1) / np.sqrt(len(finite))) if len(finite) > 1 else float("nan")
