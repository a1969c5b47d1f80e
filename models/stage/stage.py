"""The stage of a case: finite elements, reduction, modes and their labels."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.case.analysis import MODES
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import case_fault, with_values
from bladewhirl.models.coupling.stage_modes import tip_motion, wall_motion
from bladewhirl.models.elements.bladed_disk import BladedDiskModel
from bladewhirl.models.elements.build import (
    case_bladed_disk,
    lowest_frequency,
    numbers_within_reach,
    tip_in_sector,
)
from bladewhirl.models.elements.cost import stage_cost, tell_cost
from bladewhirl.models.inputs.errors import CaseError, Fault
from bladewhirl.models.modal.describe import stage_arrays
from bladewhirl.models.modal.full_stage import Frequencies, family_errors, lowest_frequencies
from bladewhirl.models.modal.labels import mode_families
from bladewhirl.models.modal.modes import Modes
from bladewhirl.models.modal.reduction import ReducedModes, craig_bampton
from bladewhirl.models.modal.stage_arrays import StageArrays
from bladewhirl.models.modal.suspension import with_sized_shaft
from bladewhirl.models.rotation.at_speed import tip_recess, turning_disk
from bladewhirl.models.stage.contact_problem import ReducedRotor
from bladewhirl.models.stage.export import part_superelement, wheel_superelement
from bladewhirl.models.stage.kept_modes import KeptModes, kept_modes
from bladewhirl.models.stage.reduced import ReducedDisk, reduced_disk
from bladewhirl.models.stage.ring import Ring, stage_casing
from bladewhirl.models.stage.whirl import wave_errors, wave_frequencies
from bladewhirl.models.structure.eigenproblems import modal_damping
from bladewhirl.models.superelements.superelement import Superelement, SuperelementError

FULL_FREQUENCIES = 7
"""Number of frequencies of the full model that are computed per nodal diameter: five families, the
suspension pair, and one more mode."""

ROUNDING = 1e-11
"""Entries of a damping matrix below this share of its largest entry are set to zero."""

MOST_ENTRIES = 5e8  #: largest number of entries in the mode shapes of a reduced model (4 GB)

SHOWN_FAMILIES = ("suspension", "1F", "2F", "3F", "4F", "5F")
"""Families of the bladed disk in the printed form of a stage."""


@dataclass(frozen=True, kw_only=True, repr=False)
class Stage(Ring):
    """A bladed disk and a casing: full models, reduced models and modes with their families."""

    disk: BladedDiskModel  #: bladed disk at the speed of the case; at rest without rotation effects
    disk_frequencies: Frequencies
    """Lowest natural frequencies of the full bladed disk with the shaft of the case [rad/s]."""
    reference_frequency: float
    """Lowest natural frequency of the full bladed disk with a free centre [rad/s]."""
    reduction: ReducedModes  #: modes of the reduced bladed disk
    disk_family: tuple[str, ...]  #: family of each mode of the reduced bladed disk
    frequency_error: dict[str, float]
    """Largest relative frequency error of the reduction, by family. With Coriolis forces and equal
    sectors, these are errors of the frequencies of waves."""
    rotor: ReducedRotor  #: the bladed disk in all modes of `reduction`
    kept: KeptModes  #: the modes selected for time integration

    def __repr__(self) -> str:
        """Return a summary: bodies, symmetry, reduction, families, modes for time integration."""
        sets = [f"{len(dofs)} {name}" for name, dofs in self.boundary_sets.items() if len(dofs)]
        reduced = " + ".join([*sets, f"{self.reduction.kept} fixed-interface"]).replace("_", " ")
        hertz, kept = self.reference_frequency / (2.0 * np.pi), self.kept
        lines = {
            "bladed disk": f"{len(self.rotor.tip_angle)} blades, {self.disk.model.mass:.4g} kg,"
            f" {self.disk.structure.size} degrees of freedom; {self.symmetry['bladed_disk']}",
            "casing": f"{self.casing.mesh.elements} elements, {self.casing.mass:.4g} kg,"
            f" {self.casing.structure.size} degrees of freedom; {self.symmetry['casing']}"
            if self.reduced_casing.is_flexible
            else "rigid",
            "reference": f"{hertz:.4g} Hz, lowest of the bladed disk with a free centre",
            "speed": f"{self.speed:.5g} rad/s, {self.speed / self.reference_frequency:.4g} times"
            " the reference",
            "reduced to": f"{reduced} = {self.reduction.modes.count}",
            **{name: self._family(name) for name in SHOWN_FAMILIES if name in self.disk_family},
            "marched": f"{len(kept.rotor)} modes of the bladed disk, {len(kept.casing)} of the"
            f" casing{', coupled by springs' if kept.springs else ''}",
        }
        rows = [f"{name:<13}{text}" for name, text in lines.items()]
        return "\n  ".join([f'Stage "{self.case.title}"', *rows])

    def _family(self, name: str) -> str:
        """Return as text the frequency range of a family of the reduced model, and the largest
        error of its frequencies."""
        here = np.array(self.disk_family) == name
        hertz = self.reduction.modes.frequency[here] / (2.0 * np.pi)
        low, high = f"{hertz.min():.4g}", f"{hertz.max():.4g}"
        span = f"{low} Hz" if low == high else f"{low} to {high} Hz"
        if hertz.min() < 0.0:
            span += " (negative squares, stabilised by Coriolis forces)"
        error = self.frequency_error.get(name)
        return span if error is None else f"{span}, {100.0 * error:.2g} % off the full model"

    @cached_property
    def reduced(self) -> ReducedDisk:
        """Matrices of the reduced bladed disk with named degrees of freedom."""
        return reduced_disk(self.case, self.disk, self.reduction, self.boundary_sets)

    def to_superelement(self, kind: Literal["wheel", "sector", "blade"] = "wheel") -> Superelement:
        """Return the full model of the bladed disk as a superelement, with the blade tips as
        contact nodes; see `write_superelement`.

        Args:
            kind: "wheel", without the springs of the shaft; "sector", of a disk of beams with equal
                sectors and a clamped centre; "blade", one blade clamped at its root.

        Raises:
            SuperelementError: there is no such sector or blade.
        """
        case = self.case
        if kind == "wheel":
            return wheel_superelement(self.disk, case.shaft.stiffnesses, case.title)
        if self.disk.rotates:
            raise SuperelementError(f'expected rotation.effects = "none" for a {kind}')
        return part_superelement(self.disk, kind, case.title)

    @property
    def speed(self) -> float:
        """Speed of rotation Omega [rad/s], counter-clockwise."""
        return self.case.march.speed.rad_per_s(self.reference_frequency)

    @property
    def displacement_limit(self) -> float:
        """Displacement at which a march ends [m]; by default the length of a blade."""
        return self.case.march.displacement_limit or self.disk.model.blade_length

    @property
    def symmetry(self) -> dict[str, str]:
        """Symmetry of bladed disk and casing, and methods for modes and reduction, in words."""
        symmetry = {"bladed_disk": self.disk.structure.symmetry}
        if self.reduced_casing.is_flexible:
            symmetry["casing"] = self.casing.structure.symmetry
        return symmetry

    @property
    def boundary_sets(self) -> dict[str, IntArray]:
        """Numbers of the boundary degrees of freedom of the bladed disk, by name."""
        return boundary_sets(self.disk)

    @property
    def arrays(self) -> StageArrays:
        """Arrays of the stage for a result, with the modes selected for time integration."""
        modes = self.reduction.modes.take(self.kept.rotor)
        family = tuple(self.disk_family[mode] for mode in self.kept.rotor)
        arrays = stage_arrays(
            self.case,
            self.disk,
            modes,
            family,
            **self.wall_arrays(self.kept.casing),
        )
        rotor = self.rotor.take(self.kept.rotor)
        backward, forward = wave_frequencies(rotor, modes.nodal_diameter, self.speed)
        return replace(arrays, rotor_backward_frequency=backward, rotor_forward_frequency=forward)


def build_stage(case: Case) -> Stage:
    """Build the stage of a case.

    Raises:
        CaseError: there are more fixed-interface modes than internal degrees of freedom, the stage
            is too large for the memory, selected modes do not exist, no springs give the
            suspension frequency, or values are too extreme for finite elements in double
            precision.
    """
    case = with_sized_shaft(case)
    with numbers_within_reach(case):
        tell_cost(stage_cost(case))
        at_rest = case_bladed_disk(case, clamped=case.shaft.clamped)
        case = _with_possible_modes(case, at_rest)
        tip = tip_in_sector(at_rest)
        full = lowest_frequencies(at_rest.structure, FULL_FREQUENCIES)
        reference = _reference_frequency(case, at_rest, full)
        case = case.in_seconds(reference)
        disk = turning_disk(case, at_rest, reference)
        if disk.rotates:
            full = lowest_frequencies(disk.structure, FULL_FREQUENCIES)
        reduction = craig_bampton(
            disk.structure,
            np.concatenate([*boundary_sets(disk).values()]),
            case.reduction.fixed_interface_modes,
            tip,
        )
        lowest_frequency(disk, np.abs(reduction.modes.frequency))  # check against rounding
        ring = stage_casing(case)
        disk_family = mode_families(disk.structure, reduction.modes, tip, "bladed-disk")
    rotor = reduced_rotor(case, disk, reduction.modes, tip_recess(case, disk))
    if disk.rotates:
        _check_clearance(case, rotor.tip_recess)
    if case.rotation.effects != "full" or not disk.structure.is_cyclic:
        errors = family_errors(reduction.modes, list(disk_family), full)
    else:
        errors = wave_errors(rotor, reduction.modes.nodal_diameter, disk_family, disk)
    return Stage(
        **vars(ring),
        disk=disk,
        disk_frequencies=full,
        reference_frequency=reference,
        reduction=reduction,
        disk_family=disk_family,
        frequency_error=errors,
        rotor=rotor,
        kept=kept_modes(
            case,
            tip_motion(disk, reduction.modes, disk_family, lambda i: reduction.modes.shapes[:, i]),
            wall_motion(ring.casing, ring.casing_modes),
        ),
    )


def rotor_at(stage: Stage, omega: float) -> tuple[ReducedRotor, FloatArray]:
    """Return the reduced bladed disk of a stage at another speed of rotation [rad/s], with all of
    its modes, and their fields on the free DoF [kg^-1/2], (size, modes)."""
    disk, case = stage.disk, stage.case
    if not disk.rotates:
        return stage.rotor, stage.reduction.modes.shapes
    structure = disk.structure.still.at(omega, case.rotation.effects)
    disk = replace(disk, structure=structure)
    boundary = np.concatenate([*boundary_sets(disk).values()])
    kept = case.reduction.fixed_interface_modes
    with numbers_within_reach(
        with_values(case, {"march.speed": omega / stage.reference_frequency})
    ):
        modes = craig_bampton(structure, boundary, kept, tip_in_sector(disk)).modes
    return reduced_rotor(case, disk, modes, tip_recess(case, disk)), modes.shapes


def boundary_sets(disk: BladedDiskModel) -> dict[str, IntArray]:
    """Return the degrees of freedom on which casing and shaft act, by name."""
    return {
        "tip_radial": disk.tip_radial,
        "tip_tangential": disk.tip_tangential,
        "centre": disk.centre,
    }


def _reference_frequency(case: Case, disk: BladedDiskModel, full: Frequencies) -> float:
    """Return the lowest natural frequency of the full bladed disk with a free centre [rad/s].

    Raises:
        FloatingPointError: the frequency is lost in rounding.
    """
    if case.shaft.clamped:
        free = case_bladed_disk(case, clamped=False)
        disk, full = free, lowest_frequencies(free.structure, FULL_FREQUENCIES)
    return lowest_frequency(disk, (frequencies[0] for frequencies in full.values()))


def reduced_rotor(
    case: Case, disk: BladedDiskModel, modes: Modes, recess: FloatArray
) -> ReducedRotor:
    """Return a bladed disk at speed in modal coordinates, with a recess of its tips [m],
    (blades,)."""
    centre = np.zeros((2, modes.count))
    centre[: len(disk.centre)] = modes.shapes[disk.centre]  # no rows if clamped
    by_velocity = _by_velocity(case, disk, modes)
    return ReducedRotor(
        frequency=modes.frequency,
        damping_ratio=np.full(modes.count, case.damping.ratio if by_velocity is None else 0.0),
        tip_radial=modes.shapes[disk.tip_radial],
        tip_tangential=modes.shapes[disk.tip_tangential],
        centre=centre,
        tip_angle=disk.tip_angles,
        tip_radius=disk.model.tip_radius,
        tip_recess=recess,
        column=disk.blade_columns(modes.column),
        dampers=np.sqrt(case.shaft.dampings)[:, None] * centre,
        anisotropy=0.0 if case.shaft.clamped else case.shaft.anisotropy,
        by_velocity=by_velocity,
        circulation=(
            case.shaft.damping * disk.speed if case.shaft.damping_frame == "static" else 0.0
        ),
    )


def _by_velocity(case: Case, disk: BladedDiskModel, modes: Modes) -> FloatArray | None:
    """Return the matrix of Coriolis forces and damping on the modes at speed, (modes, modes).

    The damping is the modal damping of the structure at rest. None without Coriolis forces: the
    modes at speed then have modal damping.
    """
    structure, shapes = disk.structure, modes.shapes
    if structure.gyroscopic is None:
        return None
    skew = disk.speed * (shapes.T @ (structure.gyroscopic @ shapes))
    strained = shapes.T @ (structure.elastic @ shapes)
    damping = modal_damping(np.eye(modes.count), strained, case.damping.ratio).real
    damping = (damping + damping.T) / 2.0
    damping[np.abs(damping) < ROUNDING * np.abs(damping).max()] = 0.0
    return np.asarray((skew - skew.T) / 2.0 + damping)


def _check_clearance(case: Case, recess: FloatArray) -> None:
    """Check that the static growth of the tips at speed closes no gap to the casing.

    Raises:
        CaseError: a tip touches the casing; the error names the blade and the overlap.
    """
    smallest_gap = case.casing.clearance_profile.smallest + recess
    if not smallest_gap.min() > 0.0:
        blade = int(smallest_gap.argmin())
        expected = (
            f"room for the growth of the tips at march.speed: the tip of blade {blade} would be"
            f" {-smallest_gap[blade]:.3g} m beyond the casing where it is narrowest"
        )
        raise CaseError([case_fault(case, "casing.clearance", expected)])


def _with_possible_modes(case: Case, disk: BladedDiskModel) -> Case:
    """Return the case with as many fixed-interface modes as the bladed disk has, if the default
    number is larger.

    Raises:
        CaseError: there are more fixed-interface modes than internal degrees of freedom, or the
            model is too large.
    """
    boundary = sum(map(len, boundary_sets(disk).values()))
    internal = disk.structure.size - boundary
    key, requested = "reduction.fixed_interface_modes", case.reduction.fixed_interface_modes
    if MODES == requested > internal:
        requested = internal
        reduction = case.reduction.model_copy(update={"fixed_interface_modes": internal})
        case = case.model_copy(update={"reduction": reduction})
    elif requested > internal:
        expected = (
            f"at most {internal}, the number of internal degrees of freedom of the bladed disk"
        )
        raise CaseError([case_fault(case, key, expected)])
    if disk.structure.size * (boundary + requested) > MOST_ENTRIES:
        expected = (
            f"a bladed disk of fewer degrees of freedom than {disk.structure.size}, or fewer "
            f"fixed-interface modes: at most {MOST_ENTRIES:g} entries in the matrix of mode shapes"
        )
        raise CaseError([Fault(key="bladed_disk", expected=expected)])
    nodal = 4 * case.casing.elements
    if nodal**2 > MOST_ENTRIES:
        expected = f"at most {int(MOST_ENTRIES**0.5) // 4} elements"
        raise CaseError([case_fault(case, "casing.elements", expected)])
    return case
