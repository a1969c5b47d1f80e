"""The abradable coating of a contact problem, from the case and the geometry of the blades."""

from collections.abc import Iterator

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.file import case_fault
from bladewhirl.models.inputs.errors import CaseError, Fault
from bladewhirl.models.stage.contact_problem import ReducedCasing, ReducedRotor, WallCoating
from bladewhirl.models.stage.stage import Stage

PER_FOOTPRINT = 4
"""By default, more than this number of rods are under a footprint."""


def wall_coating(stage: Stage) -> WallCoating | None:
    """Return the coating of the casing; None if there is none.

    Raises:
        CaseError: the case has no footprint, and no beam ends at a tip.
    """
    case, coating, radius = stage.case, stage.case.casing.coating, stage.casing.mesh.radius
    if coating is None:
        return None
    footprint = _tip_thickness(stage)
    if coating.footprint is not None:
        footprint = np.full_like(footprint, coating.footprint)
    elif not np.isfinite(footprint).all():
        expected = "a length, because the tips are not ends of beams"
        raise CaseError([case_fault(case, "casing.coating.footprint", expected)])
    around = 2.0 * np.pi * radius
    rods = coating.elements or int(PER_FOOTPRINT * around / footprint.min()) + 1
    made = WallCoating(
        strain=np.zeros(rods),
        footprint=footprint,
        arc=around / rods,
        width=coating.width or case.casing.wall.width,
        thickness=coating.thickness,
        young_modulus=coating.young_modulus,
        yield_stress=coating.yield_stress,
        hardening=coating.slope,
        limit=coating.limit,
        friction=case.contact.friction if coating.friction is None else coating.friction,
    )
    if coating.profile is not None:
        made.strain[:] = coating.profile.recess(made.angle) / coating.thickness
    return made


def coating_faults(stage: Stage, rotor: ReducedRotor, casing: ReducedCasing) -> Iterator[Fault]:
    """Yield faults if the time step is too long for the stiffness of the coating, or for the time
    in which a tip passes a rod."""
    coating, case = wall_coating(stage), stage.case
    if coating is None:
        return
    step = case.march.time_step
    # The forces follow from the motion without them: stable below 4/3 times stiffness over mass.
    mobility = (rotor.tip_radial**2).sum(axis=1).max()
    mobility += (casing.nodal[:, 0] ** 2).sum(axis=1).max()
    longest = float(1.0 / np.sqrt(coating.stiffness * mobility))
    if not step < longest:
        expected = f"less than {longest:.4g} s, the limit for the stiffness of casing.coating"
        yield case_fault(case, "march.time_step", expected)
    if not abs(stage.speed) * step * stage.casing.mesh.radius < coating.arc:
        most = int(2.0 * np.pi / (abs(stage.speed) * step))
        expected = f"at most {most} rods, so that a tip passes less than one rod in a time step"
        yield case_fault(case, "casing.coating.elements", expected)


def _tip_thickness(stage: Stage) -> FloatArray:
    """Return the thickness of each blade at its tip [m], (tips,)."""
    arrays = stage.arrays
    ends = arrays.rotor_thickness[:, None] + arrays.rotor_thickness_change[:, None] * [-0.5, 0.5]
    return np.array(
        [ends[arrays.rotor_line == node].min(initial=np.inf) for node in arrays.tip_node]
    )
