"""Units in which small and large amounts read well, for the labels of figures."""

from __future__ import annotations


def length_unit(length: float) -> tuple[str, float]:
    """Unit in which a length [m] reads well, and how many of it are a metre."""
    return ("mm", 1e3) if length >= 1e-4 or length == 0 else ("µm", 1e6)


def velocity_unit(velocity: float) -> tuple[str, float]:
    """Unit in which a velocity [m/s] reads well, and how many of it are a metre per second."""
    return ("m/s", 1.0) if velocity >= 0.1 or velocity == 0 else ("mm/s", 1e3)
