"""Stability of a shaft line: its fastest growing motion, and the speeds at which growth begins.

In static axes the matrices of a round shaft with bearings and the waves of nodal diameter 0 and 1
of its wheels are constant, so that eigenvalues decide.
"""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from bladewhirl.models.shaft_line.axial import axial_modes
from bladewhirl.models.shaft_line.line import LineModel
from bladewhirl.models.shaft_line.whirl import all_motions

GROWS = 1e-9
"""Growth or decay rate, as a fraction of the absolute value of the eigenvalue, below which it is a
rounding error."""

NEAR, FINE = 1e-4, 1e-12
"""Relative precision of a speed at which growth begins or ends, before and after one motion is
followed."""


@dataclass(frozen=True, kw_only=True)
class Growth:
    """The motion of a line that grows fastest, or decays slowest."""

    speed: float  #: speed of rotation [rad/s]
    eigenvalue: complex  #: growth rate plus i times frequency [rad/s]
    direction: str  #: forward, backward, planar, axial or torsional

    @property
    def grows(self) -> bool:
        """Whether the motion grows by more than rounding errors."""
        return self.eigenvalue.real > 0.0


def growth(line: LineModel, omega: float) -> Growth:
    """Return the fastest growing motion of a line at a speed [rad/s]; rates within rounding errors
    are zero."""
    free = _free_motions(line, omega)
    values = np.array([each.eigenvalue for each in free])
    rates = np.where(np.abs(values.real) > GROWS * np.abs(values), values.real, 0.0)
    most = int(rates.argmax())
    return replace(free[most], eigenvalue=complex(rates[most], values[most].imag))


def _free_motions(line: LineModel, omega: float) -> list[Growth]:
    """Return all free motions."""
    motions, axial = all_motions(line, omega), axial_modes(line, omega)
    values = np.concatenate([motions.eigenvalue, axial.eigenvalue])
    return [
        Growth(speed=omega, eigenvalue=complex(value), direction=direction)
        for value, direction in zip(values, (*motions.direction, *axial.direction), strict=True)
    ]


def borders(line: LineModel, growths: list[Growth]) -> list[Growth]:
    """Return the speeds at which growth begins or ends, with the motion that grows there.

    Args:
        line: the shaft line.
        growths: growth at ascending speeds; a range between two of them that begins and ends is not
            found.
    """
    return [
        _border(line, *((one, other) if other.grows else (other, one)))
        for one, other in pairwise(growths)
        if one.grows != other.grows
    ]


def _border(line: LineModel, stable: Growth, unstable: Growth) -> Growth:
    """Return the speed between two at which growth begins or ends."""
    while abs(unstable.speed - stable.speed) > NEAR * unstable.speed:
        middle = growth(line, (stable.speed + unstable.speed) / 2.0)
        stable, unstable = (stable, middle) if middle.grows else (middle, unstable)

    def followed(omega: float) -> Growth:
        free = _free_motions(line, omega)
        return min(free, key=lambda each: abs(each.eigenvalue - unstable.eigenvalue))

    def rate(omega: float) -> float:
        return followed(omega).eigenvalue.real

    low, high = stable.speed - NEAR * unstable.speed, unstable.speed
    if rate(low) < 0.0 < rate(high):
        from scipy.optimize import brentq  # long to load

        unstable = followed(float(brentq(rate, low, high, xtol=FINE * high, rtol=FINE)))
    return unstable
