"""The stage of beams with friction joints: a wheel whose tips and ends of cut rings are massless
contact nodes."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import faults_at
from bladewhirl.models.elements.bladed_disk import BladedDiskModel
from bladewhirl.models.elements.cut_rings import WheelOfBeams
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.rotation.at_speed import tip_recess
from bladewhirl.models.stage.build_beams import build_beams
from bladewhirl.models.stage.build_matrices import other_speeds
from bladewhirl.models.stage.kept_modes import KeptModes
from bladewhirl.models.stage.matrices import Matrices
from bladewhirl.models.stage.ring import Ring
from bladewhirl.models.stage.superelement_structure import on_springs
from bladewhirl.models.superelements.reduction import (
    ReducedSuperelement,
    Root,
    massless,
    root_at_rest,
)
from bladewhirl.models.superelements.superelement import Superelement, SuperelementError


@dataclass(frozen=True, kw_only=True, repr=False)
class JointedBeams(Matrices):
    """A bladed disk of beams with joints, reduced to free-interface modes."""

    disk: BladedDiskModel  #: bladed disk at the speed of the stage
    wheel: WheelOfBeams  #: the same at rest

    @property
    def table(self) -> WheelOfBeams:
        return self.wheel

    def to_superelement(self, kind: Literal["wheel", "sector", "blade"] = "wheel") -> Superelement:
        """Return the wheel, see `WheelOfBeams.part`, without the springs of the shaft.

        Raises:
            SuperelementError: the kind is not "wheel".
        """
        if kind != "wheel":
            raise SuperelementError(f"expected no [[joint]] for a {kind} of beams")
        return self.wheel.part

    @property
    def over_many_speeds(self) -> "JointedBeams":
        return self

    @property
    def blade_length(self) -> float:
        return self.disk.model.blade_length

    @property
    def recess(self) -> FloatArray:
        return self._at_tips(tip_recess(self.case, self.disk))

    def recess_at(self, speed: float) -> FloatArray:
        return self._at_tips(tip_recess(self.case, self.disk, speed))

    def _at_tips(self, values: FloatArray) -> FloatArray:
        """Return values of the tips, and zero for other contact nodes, (nodes,)."""
        found = np.zeros(self.part.contacts)
        found[self.tips] = values
        return found

    @property
    def basis_error(self) -> None:
        return None

    @property
    def own_properties(self) -> dict[str, Any]:
        model = self.disk.model
        return {
            **super().own_properties,
            "bladed_disk_mass": model.mass,  # kg
            "bladed_disk_parts": model.part_masses,  # beams by part, point masses [kg]
        }


def build_jointed_beams(case: Case, ring: Ring | None = None) -> JointedBeams:
    """Return the stage of a case of beams with joints.

    Args:
        case: the case.
        ring: its casing, if it is known.

    Raises:
        CaseError: as for `build_beams`, or there are too many modes.
    """
    beams = build_beams(case)
    ring, case, disk = ring or beams, beams.case, beams.disk
    rings = tuple(joint.cut_ring for joint in case.joint)
    wheel = WheelOfBeams.of(disk, rings, case.title)
    reduced_at = partial(_reduced_at, case, wheel)
    at_rest = beams.reference_frequency if disk.rotates else None
    try:
        held, reduced = reduced_at(beams.speed, other_speeds(case, at_rest))
    except SuperelementError as error:
        raise CaseError(faults_at(case, "reduction.free_interface_modes", error)) from None
    return JointedBeams(
        case=case,
        casing=ring.casing,
        casing_modes=ring.casing_modes,
        reduced_casing=ring.reduced_casing,
        reference_frequency=beams.reference_frequency,
        part=held,
        given=held,
        shown=np.arange(held.point_count),
        reduced=reduced,
        blade=np.arange(held.contacts) // (held.contacts // wheel.copies),
        reduced_at=lambda speed: reduced_at(speed)[1],
        build=build_jointed_beams,
        kept=KeptModes(
            rotor=np.arange(reduced.size),
            casing=np.arange(len(ring.reduced_casing.frequency)),
            coupled=None,
            springs=None,
        ),
        disk=disk,
        wheel=wheel,
    )


def _reduced_at(
    case: Case, wheel: WheelOfBeams, omega: float, others: Sequence[float] = ()
) -> tuple[Superelement, ReducedSuperelement]:
    """Return a wheel at a speed [rad/s] with its supports, and its reduction, which may also have
    modes at other speeds [rad/s], see `massless`.

    Raises:
        SuperelementError: as for `massless`.
    """
    effects = case.rotation.effects

    def supported(part: Superelement) -> Superelement:
        return part if part.centre_dofs is None else on_springs(case, part)

    def at(speed: float) -> Superelement:
        return supported(wheel.part if effects == "none" else wheel.part.at(speed, effects))

    held, modes = at(omega), case.reduction.free_interface_modes
    root = _root(supported(wheel.in_plane)) if effects == "full" else None
    return held, massless(held, modes, root, [at(each) for each in others])


def _root(flat: Superelement) -> Root:
    """Return the root of the stiffness at rest on shapes with axial displacements, too."""
    of_plane = root_at_rest(flat)
    return lambda shapes: of_plane(shapes[: flat.size])
