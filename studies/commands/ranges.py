"""Numbers and ranges on the command line."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from bladewhirl.models.inputs.errors import UserError

MOST_POINTS = 100_000
"""Longest range: a chart of that many columns is a slip of the pen."""


def parse_range(option: str, text: str) -> NDArray[np.float64]:
    """Evenly spaced values from "START:STOP:COUNT", ends included, (COUNT,).

    Args:
        option: what errors call it, "--speeds".
        text: three numbers with colons between them; START >= 0, STOP > START, COUNT >= 2.

    Raises:
        UserError: anything else.
    """

    def fault(expected: str) -> UserError:
        return UserError(f"{option} {text}: expected {expected}")

    parts = text.split(":")
    try:
        start, stop = (float(part) for part in parts[:2])
        count = int(parts[2])
    except (ValueError, IndexError):
        raise fault("START:STOP:COUNT, two numbers and a whole number") from None
    if len(parts) > 3 or not (math.isfinite(start) and math.isfinite(stop)):
        raise fault("START:STOP:COUNT with finite numbers")
    if start < 0.0:
        raise fault("a START of zero or more")
    if stop <= start:
        raise fault(f"a STOP above the START of {start:g}")
    if not 2 <= count <= MOST_POINTS:
        raise fault(f"a COUNT from 2 to {MOST_POINTS}")
    return np.linspace(start, stop, count)


def parse_interval(option: str, text: str) -> tuple[float, float]:
    """Ends of an interval from "START:STOP".

    Args:
        option: what errors call it, "--speeds".
        text: two numbers with a colon between them; START >= 0, STOP > START.

    Raises:
        UserError: anything else.
    """
    parts = text.split(":")
    try:
        start, stop = (float(part) for part in parts)
    except ValueError:
        raise UserError(f"{option} {text}: expected START:STOP, two numbers") from None
    if not (math.isfinite(start) and math.isfinite(stop)):
        raise UserError(f"{option} {text}: expected START:STOP with finite numbers")
    if start < 0.0:
        raise UserError(f"{option} {text}: expected a START of zero or more")
    if stop <= start:
        raise UserError(f"{option} {text}: expected a STOP above the START of {start:g}")
    return start, stop


def not_negative(option: str, value: float) -> None:
    """Refuse a negative or non-finite number.

    Raises:
        UserError: naming the option and the value.
    """
    if not (math.isfinite(value) and value >= 0.0):
        raise UserError(f"{option} {value:g}: expected a number of zero or more")
