"""Solvers on arrays: coincidence, stability, coupled modes, contact scenarios, Floquet analysis."""

from bladewhirl.solvers.coincidence import (
    Coincidences,
    coincidences,
    frequency_in_other_frame,
)
from bladewhirl.solvers.coupled_modes import (
    CoupledMode,
    CoupledMotion,
    RadialShapes,
    coupled_modes,
    coupled_motion,
)
from bladewhirl.solvers.floquet import Floquet, coupled_floquet, floquet
from bladewhirl.solvers.scenario import (
    Scenario,
    mode_scenario,
    motion_scenario,
    smallest_clearance_angle,
)
from bladewhirl.solvers.stability import (
    StabilityChart,
    coincidence_speeds,
    eigenvalues,
    growth_rate,
    is_unstable,
    stability_chart,
)
from bladewhirl.solvers.tracking import track
from bladewhirl.solvers.veering import ShaftVeering, shaft_veering
from bladewhirl.solvers.zones import UnstableZones, unstable_zones

__all__ = [
    "Coincidences",
    "CoupledMode",
    "CoupledMotion",
    "Floquet",
    "RadialShapes",
    "Scenario",
    "ShaftVeering",
    "StabilityChart",
    "UnstableZones",
    "coincidence_speeds",
    "coincidences",
    "coupled_floquet",
    "coupled_modes",
    "coupled_motion",
    "eigenvalues",
    "floquet",
    "frequency_in_other_frame",
    "growth_rate",
    "is_unstable",
    "mode_scenario",
    "motion_scenario",
    "shaft_veering",
    "smallest_clearance_angle",
    "stability_chart",
    "track",
    "unstable_zones",
]
