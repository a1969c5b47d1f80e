"""Finite element stages that several test modules look at, and the numbers known of them."""

from functools import cache

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.file import loads
from bladewhirl.models.elements.bladed_disk import BladedDiskModel
from bladewhirl.models.elements.build import tip_in_sector
from bladewhirl.models.elements.casing import RADIAL, TANGENTIAL, CasingModel
from bladewhirl.models.stage.beams import Beams
from bladewhirl.models.stage.build_beams import build_beams
from bladewhirl.studies.verification.case import reference as oracle
from bladewhirl.studies.verification.stages import (
    CASING_REFERENCE,
    RADIUS,
    beam,
    bladed_disk,
    casing,
    casing_modes,
    clamped,
    disk_modes,
    hertz,
    natural_frequencies,
    observed_order,
    ring,
    steel,
)

__all__ = [
    "CASING_REFERENCE",
    "RADIUS",
    "SMALL",
    "beam",
    "bladed_disk",
    "casing",
    "casing_modes",
    "clamped",
    "disk_modes",
    "hertz",
    "natural_frequencies",
    "observed_order",
    "oracle",
    "ring",
    "ring_moved",
    "stage",
    "steel",
    "tip_in_sector",
    "translation",
]


SMALL = (
    "bladed_disk.blades=6",
    "bladed_disk.elements_per_blade=3",
    "casing.elements=16",
    "reduction.fixed_interface_modes=20",
)
"""Changes that make the default case a small one."""


@cache
def stage(*overrides: str) -> Beams:
    """Beams of the default case with changes as `--set` takes them."""
    return build_beams(loads("", overrides=overrides))


def translation(disk: BladedDiskModel, x: float, y: float) -> FloatArray:
    """Field that moves every free node alike; no node is held."""
    axes = disk.mesh.node_axes
    field = np.zeros(disk.structure.size)
    leads = disk.structure.node_dofs[:, 0] >= 0
    first, second = disk.structure.node_dofs[leads, :2].T
    field[first] = (np.cos(axes) * x + np.sin(axes) * y)[leads]
    field[second] = (np.cos(axes) * y - np.sin(axes) * x)[leads]
    return field


def ring_moved(casing: CasingModel, x: float, y: float, turn: float) -> FloatArray:
    """Field of a ring moved as a whole, by Hermite's nodal values."""
    angle, radius = casing.mesh.angles, casing.mesh.radius
    cos, sin = np.cos(angle), np.sin(angle)
    actual = np.zeros(casing.structure.size)
    nodes = casing.structure.node_dofs.T
    actual[nodes[RADIAL]], actual[nodes[TANGENTIAL]] = x * cos + y * sin, y * cos - x * sin
    actual[nodes[TANGENTIAL]] += radius * turn
    actual[nodes[RADIAL + 1]] = (y * cos - x * sin) / radius
    actual[nodes[TANGENTIAL + 1]] = -(x * cos + y * sin) / radius
    return actual
