"""Confidence intervals of the shares of regimes in the random draws of a point."""

import numpy as np
from numpy.typing import NDArray

from bladewhirl.postprocess.fields.kinematics import Array

QUANTILE = 1.959963984540054  #: quantile of the normal distribution for intervals of 95 %


def wilson(hits: Array, draws: Array) -> tuple[Array, Array]:
    """Return the ends of the 95 % interval of a probability (Wilson, 1927), from the numbers of
    hits and of random draws; without draws the interval is [0, 1]."""
    some = np.maximum(draws, 1.0)
    share, square = hits / some, QUANTILE**2 / some
    middle = share + 0.5 * square
    half = QUANTILE * np.sqrt(share * (1.0 - share) / some + 0.25 * square / some)
    low, high = (middle - half) / (1.0 + square), (middle + half) / (1.0 + square)
    none = np.asarray(draws) == 0.0
    return np.where(none, 0.0, np.maximum(low, 0.0)), np.where(none, 1.0, np.minimum(high, 1.0))


def settled(low: Array, high: Array, width: float = 0.0) -> NDArray[np.bool_]:
    """Return true where the outcome is known: the interval of the share of every regime excludes
    one half or is narrower than `width`. `low` and `high` (..., regimes) are from `wilson`."""
    known = (low >= 0.5) | (high <= 0.5) | (high - low < width)
    return np.asarray(known.all(axis=-1))
