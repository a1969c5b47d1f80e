"""The casing of a stage: a flexible ring in all its modes, or a rigid wall."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.elements.build import case_casing, case_clearance
from bladewhirl.models.elements.casing import RADIAL, TANGENTIAL, CasingModel
from bladewhirl.models.modal.describe import casing_arrays
from bladewhirl.models.modal.labels import mode_families
from bladewhirl.models.modal.modes import Modes, structure_modes
from bladewhirl.models.stage.contact_problem import ReducedCasing

GRID = 4096
"""Number of angles at which a rigid wall is tabulated; more if its profile has many points."""

PER_POINT = 8
"""Smallest number of angles at which a rigid wall is tabulated per point of a measured profile."""


@dataclass(frozen=True, kw_only=True)
class Ring:
    """A casing: full model, modes with their families, and modal model. A rigid wall has no modes;
    its full model is only a circle."""

    case: Case
    casing: CasingModel  #: finite element model of the casing
    casing_modes: Modes  #: all modes of the casing, which is not reduced
    casing_family: tuple[str, ...]  #: family of each mode
    reduced_casing: ReducedCasing  #: the casing in all its modes

    @property
    def wall_angle(self) -> FloatArray:
        """Angles at which the clearance is given [rad], (angles,)."""
        wall = self.reduced_casing
        return self.casing.mesh.angles if wall.is_flexible else wall.angle

    def wall_arrays(self, modes: IntArray) -> dict[str, Any]:
        """Return the arrays of the casing in a result by name, with chosen modes."""
        wall = {"wall_angle": self.wall_angle, "clearance": self.reduced_casing.clearance[:, 0]}
        if not self.reduced_casing.is_flexible:
            return wall
        family = tuple(self.casing_family[mode] for mode in modes)
        return wall | casing_arrays(self.casing, self.casing_modes.take(modes), family)


def rigid_wall(case: Case, radius: float) -> ReducedCasing:
    """Return a rigid wall of a radius [m] with the clearance of a case."""
    profile = case.casing.clearance_profile
    count = max(GRID, PER_POINT * len(profile.points))
    angles = 2.0 * np.pi / count * np.arange(float(count))
    clearance = np.column_stack([profile.value(angles), profile.slope(angles) / radius])
    return ReducedCasing.rigid(clearance, radius)


def stage_casing(case: Case) -> Ring:
    """Return the casing of a stage of beams."""
    if case.casing.type == "ring":
        return flexible_ring(case)
    casing = case_casing(case)
    modes = structure_modes(casing.structure, (RADIAL, TANGENTIAL))
    return Ring(
        case=case,
        casing=casing,
        casing_modes=modes.take(np.zeros(0, dtype=np.int64)),
        casing_family=(),
        reduced_casing=rigid_wall(case, casing.mesh.radius),
    )


def flexible_ring(case: Case) -> Ring:
    """Return the flexible casing of a case."""
    casing = case_casing(case)
    modes = structure_modes(casing.structure, (RADIAL, TANGENTIAL))
    return Ring(
        case=case,
        casing=casing,
        casing_modes=modes,
        casing_family=mode_families(casing.structure, modes, (RADIAL, TANGENTIAL), "casing"),
        reduced_casing=ReducedCasing(
            frequency=modes.frequency,
            damping_ratio=np.full(modes.count, case.damping.ratio),
            nodal=casing.nodal(modes.shapes),
            clearance=case_clearance(case),
            radius=casing.mesh.radius,
            column=modes.column,
            dampers=casing.dampers @ modes.shapes,
        ),
    )
