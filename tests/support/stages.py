"""Finite element stages that several test modules look at, and the numbers known of them."""

from __future__ import annotations

import json
from functools import cache
from typing import Any, Literal

import numpy as np
from places import DATA

from bladewhirl.meshes.line_mesh import FloatArray, LineMesh
from bladewhirl.meshes.ring_mesh import RingMesh
from bladewhirl.models.case.file import case_from
from bladewhirl.models.elements.bladed_disk import BladedDiskModel, assemble_bladed_disk
from bladewhirl.models.elements.build import case_bladed_disk
from bladewhirl.models.elements.casing import CasingModel, assemble_casing
from bladewhirl.models.geometry.beam_model import BeamModel
from bladewhirl.models.modal.modes import Modes, structure_modes
from bladewhirl.models.sections.rectangular import QUANTITIES, LineProperties, Section
from bladewhirl.models.sections.wall import Wall

CASING_REFERENCE = (2, 0)
"""Radial and tangential displacement of a casing node among its four DoF (u, u', w, w')."""


@cache
def oracle(name: str) -> Any:
    """Independent results; each file says how they were made."""
    return json.loads((DATA / f"{name}.json").read_text())


def steel(thickness: float, width: float = 0.1) -> Section:
    """Rectangular section of the steel that all reference results are for."""
    return Section(width=width, thickness=thickness, young_modulus=2.1e11, density=7800.0)


def line_properties(mesh: LineMesh, sections: dict[str, Section]) -> LineProperties:
    """Sections, given by line set, of all lines of a mesh."""
    table = np.full((len(QUANTITIES), len(mesh.lines)), np.nan)
    for name, section in sections.items():
        table[:, mesh.line_sets[name]] = [[getattr(section, each)] for each in QUANTITIES]
    return LineProperties(**dict(zip(QUANTITIES, table, strict=True)))


def with_sections(mesh: LineMesh, disk_thickness: float, *, clamped: bool) -> BladedDiskModel:
    """Bladed disk of a mesh with 10 mm blades, on the shaft of the reference results."""
    disk = steel(disk_thickness)
    properties = line_properties(mesh, {"blades": steel(0.01), "spokes": disk, "rim": disk})
    model = BeamModel(mesh=mesh, properties=properties, tip_radius=0.5)
    return assemble_bladed_disk(model, shaft_stiffness=3.4e7, clamped=clamped)


@cache
def bladed_disk(
    blades: int = 22, elements: int = 10, disk_thickness: float = 0.01, clamped: bool = False
) -> BladedDiskModel:
    """The stage of the paper's Table 1: literally, or with thicker beams for the disk."""
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


def tip_reference(disk: BladedDiskModel) -> tuple[int, int]:
    """Positions of the tip's radial and tangential displacement among a sector's DoF."""
    layout = disk.structure.layout
    assert layout is not None
    first = layout.sector_dofs[0].tolist()
    return first.index(disk.tip_radial[0]), first.index(disk.tip_tangential[0])


def disk_modes(disk: BladedDiskModel, count: int | None = None) -> Modes:
    """Modes of a bladed disk, phases fixed at the tips."""
    return structure_modes(disk.structure, tip_reference(disk), count)


@cache
def casing(
    elements: int = 40,
    support: float = 0.0,
    curvature: Literal["exact", "shallow"] = "exact",
    rotation: Literal["free", "fixed"] = "free",
) -> CasingModel:
    """Ring of the reference results: 0.501 m, 100 x 10 mm."""
    ring = RingMesh(elements=elements, radius=0.501)
    return assemble_casing(
        ring, Wall(section=steel(0.01)), curvature=curvature, support=support, rotation=rotation
    )


@cache
def casing_modes(
    elements: int = 40,
    support: float = 0.0,
    curvature: Literal["exact", "shallow"] = "exact",
    rotation: Literal["free", "fixed"] = "free",
) -> Modes:
    """All modes of that ring."""
    return structure_modes(
        casing(elements, support, curvature, rotation).structure, CASING_REFERENCE
    )


def hertz(modes: Modes) -> FloatArray:
    """Frequencies in Hz."""
    return np.asarray(modes.frequency / (2.0 * np.pi))


def observed_order(errors: FloatArray, ratio: float = 2.0) -> FloatArray:
    """Order of convergence between successive refinements by that ratio."""
    errors = np.abs(errors)
    return np.asarray(np.log(errors[:-1] / errors[1:]) / np.log(ratio))
