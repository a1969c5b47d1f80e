"""Units in which small and large amounts read well, for the labels of figures."""

from __future__ import annotations

HANDY: dict[str, tuple[tuple[float, str, float], ...]] = {
    "m": ((1e-4, "mm", 1e3), (0.0, "µm", 1e6)),
    "m/s": ((0.1, "m/s", 1.0), (0.0, "mm/s", 1e3)),
    "s": ((0.1, "s", 1.0), (1e-4, "ms", 1e3), (0.0, "µs", 1e6)),
    "N/m": ((1e9, "GN/m", 1e-9), (1e6, "MN/m", 1e-6), (0.0, "N/m", 1.0)),
    "Pa": ((1e9, "GPa", 1e-9), (1e6, "MPa", 1e-6), (0.0, "Pa", 1.0)),
}
"""By SI unit: the amount from which a unit reads better than the next, and how many are one SI."""


def handy_unit(amount: float, unit: str) -> tuple[str, float]:
    """Unit in which an amount reads well, and how many of it are one of its SI unit.

    Args:
        amount: zero or positive, in the SI unit.
        unit: the SI unit; one that is not in `HANDY` stays.
    """
    for least, handy, scale in HANDY.get(unit, ()):
        if amount >= least or (amount == 0 and scale >= 1):
            return handy, scale
    return unit, 1.0


def length_unit(length: float) -> tuple[str, float]:
    """Unit in which a length [m] reads well, and how many of it are a metre."""
    return handy_unit(length, "m")
