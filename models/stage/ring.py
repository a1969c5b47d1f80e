"""The casing of a stage: a flexible ring in all its modes, or a rigid wall; or a ring for each of
the wheels of a shaft line."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.shaft_line import FurtherWheel
from bladewhirl.models.elements.build import case_casing, case_clearance
from bladewhirl.models.elements.casing import RADIAL, TANGENTIAL, CasingModel
from bladewhirl.models.modal.describe import casing_arrays
from bladewhirl.models.modal.labels import LabelledModes, labelled_modes, no_modes
from bladewhirl.models.stage.wall import ReducedCasing, joined_walls

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
    casing_modes: LabelledModes  #: all modes of the casing, which is not reduced
    reduced_casing: ReducedCasing  #: the casing in all its modes

    @property
    def wall_angle(self) -> FloatArray:
        """Angles at which the clearance is given [rad], (angles,)."""
        return self.reduced_casing.angle

    def wall_arrays(self, modes: IntArray) -> dict[str, Any]:
        """Return the arrays of the casing in a result by name, with chosen modes."""
        wall = {"wall_angle": self.wall_angle, "clearance": self.reduced_casing.clearance[:, 0]}
        if not self.reduced_casing.is_flexible:
            return wall
        return wall | casing_arrays(self.casing, self.casing_modes.take(modes))


@dataclass(frozen=True, kw_only=True)
class Rings(Ring):
    """Flexible rings of equal number of elements around the wheels of a shaft line: the first, with
    the modal model of all of them."""

    each: tuple[Ring, ...]  #: all rings

    def wall_arrays(self, modes: IntArray) -> dict[str, Any]:
        """Return the arrays of all rings by name, one ring after another, with all modes."""
        table = self.case.shaft_line
        assert table is not None
        arrays = [one.wall_arrays(np.arange(one.casing_modes.count)) for one in self.each]
        ends = np.cumsum([one["casing_shape"].shape[2] for one in arrays])
        for one, end in zip(arrays, ends, strict=True):
            own = one["casing_shape"]
            shape = np.zeros((*own.shape[:2], ends[-1]))
            shape[..., end - own.shape[2] : end] = own
            one["casing_shape"] = shape
        first = arrays[0]
        joined = {
            name: np.concatenate([one[name] for one in arrays]) if np.ndim(value) else value
            for name, value in first.items()
        }
        radii = [ring.casing.mesh.radius for ring in self.each]

        def of_wheels(values: Sequence[float], name: str) -> Any:
            return np.repeat(values, [len(one[name]) for one in arrays])

        return joined | {
            "casing_wheel": of_wheels(table.walled, "casing_angle"),
            "ring_radius": of_wheels(radii, "casing_angle"),
            "wall_wheel": of_wheels(table.walled, "wall_angle"),
            "support_wheel": of_wheels(table.walled, "support_angle"),
        }


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
        return flexible_rings(case)
    casing = case_casing(case)
    return Ring(
        case=case,
        casing=casing,
        casing_modes=replace(no_modes(), size=casing.structure.size),
        reduced_casing=rigid_wall(case, casing.mesh.radius),
    )


def flexible_rings(case: Case) -> Ring:
    """Return the flexible casing of a case; of a shaft line with walls around several wheels, all
    of their rings."""
    first = flexible_ring(case)
    walls = case.shaft_line.walls.values() if case.shaft_line else ()
    if not walls:
        return first
    each = first, *(flexible_ring(_around(case, wheel)) for wheel in walls)
    return Rings(
        case=case,
        casing=first.casing,
        casing_modes=first.casing_modes,
        reduced_casing=joined_walls([ring.reduced_casing for ring in each]),
        each=each,
    )


def _around(case: Case, wheel: FurtherWheel) -> Case:
    """Return a case with the ring around a further wheel, and with this wheel."""
    assert wheel.casing is not None
    disk = case.bladed_disk.model_copy(update={"superelement": wheel.superelement})
    own = {"casing": wheel.casing.beside(case.casing), "bladed_disk": disk}
    return case.model_copy(update=own)


def flexible_ring(case: Case) -> Ring:
    """Return the flexible casing around the first wheel of a case."""
    casing = case_casing(case)
    modes = labelled_modes(casing.structure, (RADIAL, TANGENTIAL), "casing")
    shapes = modes.fields(np.arange(modes.count))
    return Ring(
        case=case,
        casing=casing,
        casing_modes=modes,
        reduced_casing=ReducedCasing(
            frequency=modes.frequency,
            damping_ratio=np.full(modes.count, case.damping.ratio),
            nodal=casing.nodal(shapes),
            clearance=case_clearance(case),
            radius=casing.mesh.radius,
            column=modes.column,
            dampers=casing.dampers @ shapes,
        ),
    )
