"""Arrays of the abradable coating."""

import numpy as np

from bladewhirl.meshes.hermite import cubic_weights
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.solvers.kernel.structs import Struct, aligned, lib


def pack_coating(problem: ContactProblem) -> Struct | None:
    """Return the coating; None if the casing has none."""
    coating, casing = problem.coating, problem.casing
    if coating is None:
        return None
    rods = len(coating.strain)
    per_element = rods / len(casing.nodal)
    at = (np.arange(rods) + 0.5) / per_element
    element = np.floor(at).astype(np.int64)
    hermite = aligned((4, rods + lib.HALF))  # registers extend beyond the last rod
    hermite[:, :rods] = cubic_weights(at - element, casing.element_length)
    return Struct(
        "Coating",
        hermite=hermite,
        element=element,
        until=np.searchsorted(element, element, side="right"),
        half=coating.footprint / coating.arc / 2.0,
        rods_per_element=per_element,
        area=coating.area,
        **{
            name: getattr(coating, name)
            for name in (
                *("thickness", "young_modulus", "yield_stress"),
                *("hardening", "limit", "friction"),
            )
        },
    )
