"""A quantity around a ring: a mean or stations, and lobes on top."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.inputs.fields import Angle, LengthOrZero, count
from bladewhirl.models.inputs.table import Table

FINE = 7200
"""Angles at which the smallest value is looked for: a twentieth of a degree apart."""


class Lobe(Table):
    """Waves around the ring: amplitude * cos(lobes * (angle - phase)); 2 lobes are an ellipse."""

    lobes: Annotated[int, count(1)]
    """Number of waves around the ring."""
    amplitude: LengthOrZero
    """Height of a crest [m]."""
    phase: Angle = 0.0
    """Angle of a crest from the x axis [rad]."""


@dataclass(frozen=True, kw_only=True)
class RingProfile:
    """A function of the angle: linear between stations, or constant, plus lobes."""

    mean: float  #: where there are no stations
    lobes: tuple[Lobe, ...] = ()
    stations: tuple[tuple[float, float], ...] = ()  #: angle [rad] and value; replace the mean

    def value(self, angle: ArrayLike) -> FloatArray:
        """Values at angles [rad], of their shape."""
        theta = np.asarray(angle, dtype=np.float64)
        total = np.full(theta.shape, self.mean)
        if self.stations:
            places, values = np.array(self.stations).T
            total = np.interp(theta, places, values, period=2.0 * np.pi)
        for wave in self.lobes:
            total = total + wave.amplitude * np.cos(wave.lobes * (theta - wave.phase))
        return np.asarray(total)

    def lobe_slope(self, angle: ArrayLike) -> FloatArray:
        """Derivative of the lobes by the angle, at angles [rad]."""
        theta = np.asarray(angle, dtype=np.float64)
        slope = np.zeros(theta.shape)
        for wave in self.lobes:
            slope -= wave.amplitude * wave.lobes * np.sin(wave.lobes * (theta - wave.phase))
        return slope

    @property
    def smallest(self) -> float:
        """Smallest value on the ring, to the second order of a twentieth of a degree."""
        return float(self.value(np.linspace(0.0, 2.0 * np.pi, FINE, endpoint=False)).min())
