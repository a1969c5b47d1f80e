"""The stage of beams: finite elements, reduction, modes and their labels."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.case.excitation import EngineOrder
from bladewhirl.models.case.file import with_values
from bladewhirl.models.elements.bladed_disk import BladedDiskModel
from bladewhirl.models.elements.build import (
    numbers_within_reach,
    tip_in_sector,
)
from bladewhirl.models.elements.cyclic import NO_COLUMN
from bladewhirl.models.elements.export import part_superelement, wheel_superelement
from bladewhirl.models.elements.structure import Structure
from bladewhirl.models.geometry.beam_model import BeamModel
from bladewhirl.models.inputs.errors import Fault
from bladewhirl.models.modal.describe import stage_arrays
from bladewhirl.models.modal.frequencies import Frequencies, family_errors
from bladewhirl.models.modal.reduction import ReducedModes, craig_bampton
from bladewhirl.models.modal.stage_arrays import StageArrays
from bladewhirl.models.rotation.at_speed import check_stable, tip_answer, tip_recess
from bladewhirl.models.rotation.critical_speeds import lowest_critical_speeds
from bladewhirl.models.rotation.matrices import rotation_matrices
from bladewhirl.models.stage.beam_rotor import boundary_sets, reduced_rotor, stiffness_of_blades
from bladewhirl.models.stage.bending import foreshortening, foreshortening_faults
from bladewhirl.models.stage.blade_loss import beams_after_loss
from bladewhirl.models.stage.coating import beam_footprint
from bladewhirl.models.stage.contact_problem import ContactProblem, LostBlades
from bladewhirl.models.stage.engine_order import unit_forces
from bladewhirl.models.stage.foreshortening import Foreshortening
from bladewhirl.models.stage.reduced import ReducedDisk, reduced_disk
from bladewhirl.models.stage.reduced_rotor import ReducedRotor
from bladewhirl.models.stage.speed_change import inertia_of, modes_at_speed, static_state
from bladewhirl.models.stage.stage import LOWEST, Basis, BladeStiffness, Stage, Turning
from bladewhirl.models.stage.whirl import wave_errors, wave_frequencies
from bladewhirl.models.superelements.superelement import Superelement, SuperelementError

SHOWN_FAMILIES = ("suspension", "1F", "2F", "3F", "4F", "5F")
"""Families of the bladed disk in the printed form of a stage."""


TIP_SHARE = 0.9
"""A free end is reported as a possible tip if its radius is at least this fraction of the smallest
tip radius."""


@dataclass(frozen=True, kw_only=True, repr=False)
class Beams(Stage):
    """A bladed disk of beams: full model, reduced model, and modes with their families."""

    disk: BladedDiskModel  #: bladed disk at `speed`; at rest without rotation effects
    disk_frequencies: Frequencies
    """Lowest natural frequencies of the full bladed disk with the shaft of the case [rad/s]."""
    reduction: ReducedModes  #: modes of the reduced bladed disk
    disk_family: tuple[str, ...]  #: family of each mode of the reduced bladed disk

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
        case = self.case
        if kind == "wheel":
            return wheel_superelement(self.disk, case.title)
        if self.disk.rotates:
            raise SuperelementError(f'expected rotation.effects = "none" for a {kind}')
        return part_superelement(self.disk, kind, case.title)

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

    @cached_property
    def frequency_error(self) -> dict[str, float]:
        """Largest relative frequency error of the reduction, by family. With Coriolis forces and
        equal sectors, these are errors of the frequencies of waves."""
        disk, modes = self.disk, self.reduction.modes
        if self.case.rotation.effects != "full" or not disk.structure.is_cyclic:
            return family_errors(modes, list(self.disk_family), self.disk_frequencies)
        return wave_errors(self.rotor, modes.nodal_diameter, self.disk_family, disk)

    @cached_property
    def rotor(self) -> ReducedRotor:
        return reduced_rotor(
            self.case, self.disk, self.reduction.modes, tip_recess(self.case, self.disk)
        )

    def at(self, omega: float) -> "Beams":
        if not self.disk.rotates:
            return self
        case, disk = self.case, self.disk
        structure = disk.structure.still.at(omega, case.rotation.effects)
        disk = replace(disk, structure=structure)
        boundary = np.concatenate([*boundary_sets(disk).values()])
        kept = case.reduction.fixed_interface_modes
        with numbers_within_reach(
            with_values(case, {"march.speed": omega / self.reference_frequency})
        ):
            reduction = craig_bampton(structure, boundary, kept, tip_in_sector(disk))
        return replace(self, omega=omega, disk=disk, reduction=reduction)

    def check_speed(self, omega: float) -> None:
        if self.disk.rotates:
            reference = self.reference_frequency
            own = with_values(self.case, {"march.speed": omega / reference})
            check_stable(own, self.disk.structure, omega, reference)

    @property
    def blade_length(self) -> float:
        return self.disk.model.blade_length

    @property
    def blade_angle(self) -> FloatArray:
        return self.disk.tip_angles[None]

    @property
    def axial_position(self) -> FloatArray:
        return np.zeros(len(self.blade))

    def footprint(self) -> FloatArray:
        return beam_footprint(self.case, self.shown_arrays)

    def recess_at(self, speed: float) -> FloatArray:
        return tip_recess(self.case, self.disk, speed)

    def answer(self, along: FloatArray, speed: float) -> FloatArray:
        if not self.disk.rotates:
            return super().answer(along, speed)
        pushed = [along[k] * tip_answer(self.disk, k, speed) for k in (0, 1)]
        return np.asarray(pushed[0] + pushed[1])

    def unit_forces(self, load: EngineOrder) -> FloatArray:
        forces = unit_forces(self.case, self.disk, load)
        return np.asarray(forces @ self.reduction.modes.shapes)

    @property
    def steady_centre(self) -> FloatArray:
        disk, place = self.disk, np.zeros(2)
        if disk.rotates:
            place = disk.structure.static_displacement(disk.speed)[disk.centre]
        return place

    @cached_property
    def _steady(self) -> Structure:
        """Structure in the state of steady rotation."""
        return static_state(self.disk) if self.disk.rotates else rotation_matrices(self.disk)

    @property
    def inertia(self) -> float:
        return inertia_of(self.case, self._steady)

    @property
    def turning(self) -> Turning:
        squares = self.rotor.take(self.kept.rotor).stiffness
        rotor = modes_at_speed(self._steady, squares, self._shapes)
        centrifugal, euler = rotor.loads.T
        return Turning(rotor=rotor, patterns={"by_square": centrifugal, "by_acceleration": euler})

    @property
    def foreshortening(self) -> Foreshortening | None:
        return foreshortening(self.case, self.disk, self.reduction.modes.take(self.kept.rotor))

    def without_blades(self, given: ContactProblem, turning: ContactProblem) -> LostBlades:
        return beams_after_loss(self, self.disk, self._shapes, given)

    def blade_stiffness(self, omega: float) -> tuple[Stage, BladeStiffness]:
        own = self.at(omega)
        shapes, at_rest = own.reduction.modes.shapes, None
        slope = np.zeros((shapes.shape[1], shapes.shape[1]))
        if self.disk.rotates:
            still = self.disk.structure.still
            if self.case.rotation.effects == "full":
                at_rest = np.asarray(shapes.T @ (still.stiffness @ shapes))
            slope = np.asarray(shapes.T @ (still.slope(omega) @ shapes))
        blades = [shapes.T @ (each @ shapes) for each in stiffness_of_blades(self.disk)]
        return own, BladeStiffness(blades=np.array(blades), slope=slope, at_rest=at_rest)

    def own_faults(self) -> Iterator[Fault]:
        return foreshortening_faults(self.case, self.disk.model)

    @property
    def fewer_modes(self) -> str:
        return (
            "fewer casing.elements, bladed_disk.elements_per_blade or"
            " reduction.fixed_interface_modes"
        )

    @property
    def basis(self) -> Basis:
        return Basis("reduction.fixed_interface_modes", self.reduction.kept)

    def own_hints(self) -> Iterator[str]:
        return _free_ends(self.disk.model)

    @property
    def own_properties(self) -> dict[str, Any]:
        modes, parts = self.reduction.modes, self.disk.model.part_masses
        pair = [mode for mode, name in enumerate(self.disk_family) if name == "suspension"]
        return {
            "bladed_disk_mass": self.disk.model.mass,  # kg
            "bladed_disk_parts": parts,  # beams by part, point masses [kg]
            # The lowest mode of each nodal diameter; with unequal sectors the lowest modes.
            "bladed_disk": self._lowest_modes(),
            # The lower frequency of the pair; at speed, of the branch with most spring energy.
            "suspension": self.rate(modes.frequency[pair[0]]) if pair else None,
            "suspension_spring_share": float(modes.spring_share[pair[0]]) if pair else None,
            "reduction": self._reduction_numbers(),
        }

    def _lowest_modes(self) -> list[dict[str, Any]]:
        """Return the lowest modes of the full model. If sectors differ, nodal diameters and
        purities are taken from the modes of the reduced model."""
        frequencies, modes = self.disk_frequencies, self.reduction.modes
        if NO_COLUMN not in frequencies:
            return [self.listed(k, values[0], 1.0) for k, values in frequencies.items()]
        lowest = frequencies[NO_COLUMN]
        return [
            self.listed(int(modes.nodal_diameter[i]), lowest[i], float(modes.purity[i]))
            for i in range(min(LOWEST, modes.count, len(lowest)))
        ]

    def _reduction_numbers(self) -> dict[str, Any]:
        """Return size and accuracy of the Craig-Bampton reduction."""
        boundary = {name: len(dofs) for name, dofs in self.boundary_sets.items()}
        return {
            "boundary": boundary,  # numbers of boundary degrees of freedom, by node set
            # With complete pairs, possibly one more than requested.
            "fixed_interface_modes": self.reduction.kept,
            "wanted": self.case.reduction.fixed_interface_modes,
            "internal": self.disk.structure.size - sum(boundary.values()),
            "modes": self.reduction.modes.count,
            "marched": {"bladed_disk": len(self.kept.rotor), "casing": len(self.kept.casing)},
            "frequency_error": self.frequency_error,  # largest relative error, by family
        }

    @property
    def node_sets(self) -> Mapping[str, IntArray]:
        return self.disk.mesh.node_sets

    @property
    def attributes(self) -> Mapping[str, str | float | int]:
        return {**super().attributes, "clamped": int(self.case.shaft.clamped)}

    @cached_property
    def shown_arrays(self) -> StageArrays:
        modes = self.reduction.modes.take(self.kept.rotor)
        family = tuple(self.disk_family[mode] for mode in self.kept.rotor)
        walls = self.wall_arrays(self.kept.casing)
        arrays = stage_arrays(self.case, self.disk, modes, family, **walls)
        rotor = self.rotor.take(self.kept.rotor)
        backward, forward = wave_frequencies(rotor, modes.nodal_diameter, self.speed)
        return replace(arrays, rotor_backward_frequency=backward, rotor_forward_frequency=forward)

    @property
    def over_speeds(self) -> dict[str, Any]:
        arrays: dict[str, Any] = {"rotor_inertia": self.inertia}
        if self.disk.rotates:
            speeds, whirls = lowest_critical_speeds(self.case, self.disk)
            arrays |= {"critical_speed": speeds, "critical_whirl": whirls}
        return arrays

    def fields(self, coordinates: FloatArray) -> FloatArray:
        """Return displacements or velocities on the free degrees of freedom, (size,)."""
        return np.asarray(self._shapes @ coordinates)

    def coordinates(self, fields: FloatArray) -> FloatArray:
        """Return the modal coordinates of displacements or velocities, (modes,)."""
        return np.asarray(fields @ (self.disk.structure.mass @ self._shapes))

    @property
    def _shapes(self) -> FloatArray:
        return self.reduction.modes.shapes[:, self.kept.rotor]


def _free_ends(model: BeamModel) -> Iterator[str]:
    """Yield a warning about free ends at the radius of the tips that are not in the set `tips`."""
    points = model.mesh.points
    joined = np.bincount(model.joints.ravel(), minlength=len(points))
    ends = np.setdiff1d(np.flatnonzero(joined == 1), [*model.tips, model.centre, *model.links.led])
    radii = np.linalg.norm(points, axis=1)
    ends = ends[radii[ends] >= TIP_SHARE * radii[model.tips].min()]
    if len(ends):
        x, y = np.round(points[ends[0]], 9) + 0.0  # no rounding, no -0
        free = "1 free end" if len(ends) == 1 else f"{len(ends)} free ends"
        yield (
            f"{free} at the radius of the {len(model.tips)} tips but not in their set, the first at"
            f" ({x:.4g}, {y:.4g}) m: contact is not computed there"
        )
