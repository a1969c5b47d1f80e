"""Units in which small and large amounts read well, for the labels of figures."""

from __future__ import annotations

LARGE = (("G", 1e9), ("M", 1e6))
"""Prefixes of stiffnesses and pressures, and the amounts from which they read better."""


def length_unit(length: float) -> tuple[str, float]:
    """Unit in which a length [m] reads well, and how many of it are a metre."""
    return ("mm", 1e3) if length >= 1e-4 or length == 0 else ("µm", 1e6)


def velocity_unit(velocity: float) -> tuple[str, float]:
    """Unit in which a velocity [m/s] reads well, and how many of it are a metre per second."""
    return ("m/s", 1.0) if velocity >= 0.1 or velocity == 0 else ("mm/s", 1e3)


def time_unit(time: float) -> tuple[str, float]:
    """Unit in which a time [s] reads well, and how many of it are a second."""
    if time >= 0.1 or time == 0:
        return "s", 1.0
    return ("ms", 1e3) if time >= 1e-4 else ("µs", 1e6)


def handy_unit(amount: float, unit: str) -> tuple[str, float]:
    """Unit in which an amount reads well, and how many of it are one of its SI unit.

    Args:
        amount: zero or positive, in the SI unit.
        unit: the SI unit; any but those of lengths, velocities, times, stiffnesses and pressures
            stays.
    """
    if unit == "m":
        return length_unit(amount)
    if unit == "m/s":
        return velocity_unit(amount)
    if unit == "s":
        return time_unit(amount)
    if unit in ("N/m", "Pa"):
        for prefix, size in LARGE:
            if amount >= size:
                return prefix + unit, 1.0 / size
    return unit, 1.0
