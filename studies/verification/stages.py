"""Stages, beams and rings of the reference results."""

from collections.abc import Sequence
from functools import cache
from typing import Any, Literal

import numpy as np
import scipy.linalg as la

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.meshes.ring_mesh import RingMesh
from bladewhirl.models.case.case import case_from
from bladewhirl.models.elements.bladed_disk import BladedDiskModel, assemble_bladed_disk
from bladewhirl.models.elements.build import case_bladed_disk, tip_in_sector
from bladewhirl.models.elements.casing import CasingModel, Support, assemble_casing
from bladewhirl.models.geometry.sketch import Sketch
from bladewhirl.models.modal.labels import structure_modes
from bladewhirl.models.modal.modes import Modes
from bladewhirl.models.sections.rectangular import Section
from bladewhirl.models.sections.wall import Wall

CASING_REFERENCE = (2, 0)
"""Indices of radial and tangential displacement among the DoF (u, u', w, w') of a casing node."""


def steel(thickness: float) -> Section:
    """Return a rectangular section of the steel of all reference results."""
    return Section(width=0.1, thickness=thickness, young_modulus=2.1e11, density=7800.0)


def beam(section: Section | Sequence[Section], elements: int, *, length: float = 1.0) -> Sketch:
    """Return a single beam from "clamp" to "end"."""
    sketch = Sketch()
    sketch.node("clamp", 0.0, shared=True)
    sketch.node("end", length)
    sketch.member("beam", "clamp", "end", section, elements=elements)
    sketch.set("centre", "clamp")
    sketch.set("tips", "end")
    return sketch


def clamped(sketch: Sketch) -> BladedDiskModel:
    """Return the sketched structure with a clamped centre."""
    return assemble_bladed_disk(sketch.build(), shaft_stiffness=1.0, clamped=True)


def natural_frequencies(disk: BladedDiskModel) -> FloatArray:
    """Return frequencies of a clamped structure [rad/s], ascending; the lowest frequencies are
    accurate even if some parts are stiff."""
    structure = disk.structure
    inverse = la.eigvalsh(structure.mass.toarray(), structure.stiffness.toarray())
    return np.asarray(1.0 / np.sqrt(inverse[::-1]))


@cache
def bladed_disk(
    blades: int = 22, elements: int = 10, disk_thickness: float = 0.01, clamped: bool = False
) -> BladedDiskModel:
    """Return the stage of the paper's Table 1, by default without changes."""
    case = case_from(
        {
            "bladed_disk": {
                "blades": blades,
                "elements_per_blade": elements,
                "disk": {"thickness": disk_thickness},
            },
            "shaft": {"stiffness": 3.4e7},
        }
    )
    return case_bladed_disk(case, clamped=clamped)


def disk_modes(disk: BladedDiskModel, count: int | None = None) -> Modes:
    """Return the modes of a bladed disk; the phases of pairs are fixed at the tips."""
    return structure_modes(disk.structure, tip_in_sector(disk), count)


RADIUS = 0.501  #: radius of the rings of the reference results [m]


def ring(
    *supports: Support,
    wall: Wall | None = None,
    elements: int = 40,
    radius: float = RADIUS,
    **options: Any,
) -> CasingModel:
    """Return a ring with a section of 100 x 10 mm, free to rotate by default."""
    given: dict[str, Any] = {"curvature": "exact", "support": 0.0, "rotation": "free"}
    return assemble_casing(
        RingMesh(elements=elements, radius=radius),
        wall or Wall(section=steel(0.01)),
        supports=supports,
        **(given | options),
    )


@cache
def casing(
    elements: int = 40,
    support: float = 0.0,
    curvature: Literal["exact", "shallow"] = "exact",
    rotation: Literal["free", "fixed"] = "free",
) -> CasingModel:
    """Return the ring of the reference results."""
    return ring(elements=elements, curvature=curvature, support=support, rotation=rotation)


@cache
def casing_modes(*arguments: Any) -> Modes:
    """Return all modes of the ring `casing(*arguments)`."""
    return structure_modes(casing(*arguments).structure, CASING_REFERENCE)


def hertz(modes: Modes) -> FloatArray:
    """Return the frequencies of modes [Hz]."""
    return np.asarray(modes.frequency / (2.0 * np.pi))


def observed_order(errors: FloatArray, ratio: float = 2.0) -> FloatArray:
    """Return the order of convergence between successive refinements by the factor `ratio`."""
    errors = np.abs(errors)
    return np.asarray(np.log(errors[:-1] / errors[1:]) / np.log(ratio))
