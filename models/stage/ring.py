"""The flexible casing of a stage in all its modes."""

from dataclasses import dataclass

import numpy as np

from bladewhirl.models.case.case import Case
from bladewhirl.models.elements.build import case_casing, case_clearance
from bladewhirl.models.elements.casing import RADIAL, TANGENTIAL, CasingModel
from bladewhirl.models.modal.labels import mode_families
from bladewhirl.models.modal.modes import Modes, structure_modes
from bladewhirl.models.stage.contact_problem import ReducedCasing


@dataclass(frozen=True, kw_only=True)
class Ring:
    """A flexible casing: full model, modes with their families, and modal model."""

    case: Case
    casing: CasingModel  #: finite element model of the casing
    casing_modes: Modes  #: all modes of the casing, which is not reduced
    casing_family: tuple[str, ...]  #: family of each mode
    reduced_casing: ReducedCasing  #: the casing in all its modes


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
