"""Solvers on arrays: stability of the coupled structures, Floquet analysis."""

from bladewhirl.solvers.floquet import Floquet, floquet
from bladewhirl.solvers.stability import (
    StabilityChart,
    coincidence_speeds,
    eigenvalues,
    growth_rate,
    is_unstable,
    stability_chart,
)
from bladewhirl.solvers.tracking import track
from bladewhirl.solvers.zones import UnstableZones, unstable_zones

__all__ = [
    "Floquet",
    "StabilityChart",
    "UnstableZones",
    "coincidence_speeds",
    "eigenvalues",
    "floquet",
    "growth_rate",
    "is_unstable",
    "stability_chart",
    "track",
    "unstable_zones",
]
