"""Solvers on arrays: stability and modes of the coupled structures, Floquet analysis."""

from bladewhirl.solvers.coupled_modes import (
    CoupledMode,
    CoupledMotion,
    RadialShapes,
    coupled_modes,
    coupled_motion,
)
from bladewhirl.solvers.floquet import Floquet, coupled_floquet, floquet
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
    "CoupledMode",
    "CoupledMotion",
    "Floquet",
    "RadialShapes",
    "StabilityChart",
    "UnstableZones",
    "coincidence_speeds",
    "coupled_floquet",
    "coupled_modes",
    "coupled_motion",
    "eigenvalues",
    "floquet",
    "growth_rate",
    "is_unstable",
    "stability_chart",
    "track",
    "unstable_zones",
]
