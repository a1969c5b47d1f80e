"""Springs between the blades of a superelement and the casing."""

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.meshes.plane import rotate
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import case_fault
from bladewhirl.models.coupling.springs import CouplingSprings
from bladewhirl.models.coupling.stage_modes import ROUNDING, lowest_radial, wall_motion
from bladewhirl.models.elements.cyclic import evenly_spaced, wave_parts
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.stage.ring import Ring


def coupling_springs(
    case: Case, outward: FloatArray, angle: FloatArray, ring: Ring
) -> CouplingSprings:
    """Return the springs of a case between all modes of a superelement and the lowest radial mode
    of the casing of each nodal diameter.

    Args:
        case: the case, with a flexible casing.
        outward: mean radial displacement of the contact nodes of each blade for unit modal
            coordinates [kg^-1/2], (blades, modes).
        angle: angle of each blade at t = 0 [rad], (blades,).
        ring: the casing.

    Raises:
        CaseError: the blades or the casing have no cyclic symmetry.
    """
    order = np.argsort(np.mod(angle, 2.0 * np.pi))
    angle, outward = np.mod(angle, 2.0 * np.pi)[order], outward[order]
    casing, modes = ring.casing, ring.casing_modes
    wall = wall_motion(casing, modes)
    if not (wall.is_cyclic and evenly_spaced(angle)):
        expected = "0, or a casing with cyclic symmetry and blades at equal angles"
        raise CaseError([case_fault(case, "coupling.stiffness", expected)])
    number, amplitude = lowest_radial(wall, np.arange(len(angle) // 2 + 1))
    k, wave = modes.nodal_diameter[number], np.arange(len(number))
    on_casing = np.zeros((len(k), 2, modes.count))
    on_casing[wave, 0, number] = amplitude
    on_casing[wave[k > 0], 1, number[k > 0] + 1] = amplitude[k > 0]  # the sine mode follows
    parts = wave_parts(outward, angle - angle[0], k)
    on_rotor = rotate(parts, np.multiply.outer(k, angle[:1]), axis=1)
    on_rotor[np.abs(on_rotor) <= ROUNDING * np.abs(on_rotor).max()] = 0.0
    return CouplingSprings(
        kappa=case.coupling.stiffness,
        harmonics=k,
        rotor=on_rotor,
        casing=on_casing,
        with_pi=case.coupling.pi,
    )
