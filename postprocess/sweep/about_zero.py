"""Scales of rates on both sides of zero, of which a few may be far larger than the rest."""

from __future__ import annotations

import numpy as np

from bladewhirl.postprocess.fields.fields import Array
from bladewhirl.postprocess.run.regimes import CERTAINTY

CLEAR_RANGE = 30.0
"""Ratio of the largest rate to what is usual from which a scale is linear about zero only."""

MOST_TICKS = 3
"""Ticks on each side of zero of a scale that is linear about zero only."""


def linear_threshold(rate: Array, error: Array) -> float | None:
    """Power of ten below which a scale is to be linear; None where all of it is to be.

    It is above most rates, and above what most of them are uncertain by, so that noise is not
    spread over decades.

    Args:
        rate: nan where there is none, (...).
        error: standard error of each, in the same unit, (...).
    """
    size, doubt = np.abs(rate), CERTAINTY * error[np.isfinite(error)]
    size = size[np.isfinite(size) & (size > 0)]
    if not size.size:
        return None
    usual = max(float(np.median(size)), float(np.median(doubt)) if doubt.size else 0.0)
    if float(size.max()) <= CLEAR_RANGE * usual:
        return None
    return float(10.0 ** np.ceil(np.log10(usual)))


def threshold_ticks(threshold: float, largest: float) -> list[float]:
    """Zero, and powers of ten on both sides of it, few enough to stay apart.

    Args:
        threshold: from `linear_threshold`.
        largest: amount on the scale.
    """
    first, last = round(np.log10(threshold)), int(np.floor(np.log10(largest)))
    powers = range(last, first - 1, -max(1, -(-(last - first + 1) // MOST_TICKS)))
    positive = [10.0**power for power in reversed(powers)]
    return [-value for value in reversed(positive)] + [0.0, *positive]
