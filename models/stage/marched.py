"""The stage that is marched: one type, whatever the bladed disk was built from.

`marched_stage` builds it from a case. The two classes below are the only code that knows whether
a bladed disk consists of beams or is a superelement.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import case_fault
from bladewhirl.models.case.plausibility import probable_cause
from bladewhirl.models.inputs.errors import Fault
from bladewhirl.models.modal.stage_arrays import StageArrays
from bladewhirl.models.rotation.critical_speeds import lowest_critical_speeds
from bladewhirl.models.shaft_line.line import refuse_line
from bladewhirl.models.stage.blade_loss import loss_faults
from bladewhirl.models.stage.blade_stiffness import TunedRotor, tuned_beams, tuned_sectors
from bladewhirl.models.stage.build import contact_problem
from bladewhirl.models.stage.coating import rod_faults, wall_coating
from bladewhirl.models.stage.contact_problem import ContactProblem, WallCoating
from bladewhirl.models.stage.forced import (
    EngineOrders,
    ForcedRotor,
    forced_beams,
    forced_superelement,
)
from bladewhirl.models.stage.hints import stage_hints, superelement_hints
from bladewhirl.models.stage.lost_copies import with_lost_copies
from bladewhirl.models.stage.speed_change import turning_inertia
from bladewhirl.models.stage.stage import Stage, build_stage
from bladewhirl.models.stage.superelement_speed import with_speed_over_time
from bladewhirl.models.stage.superelement_stage import SuperelementStage, superelement_stage


@dataclass(frozen=True)
class MarchedStage(ABC):
    """Stage with all that runs and sweeps need of it."""

    model: Stage | SuperelementStage  #: finite elements and reduction

    @property
    def case(self) -> Case:
        """Case of the stage."""
        return self.model.case

    def with_case(self, case: Case) -> "MarchedStage":
        """Return the stage of a case that differs only in load, contact and march."""
        shaft = self.case.shaft  # its springs can follow from a required frequency
        case = case.model_copy(update={"shaft": shaft}).in_seconds(self.reference_frequency)
        return type(self)(replace(self.model, case=case))

    @property
    def speed(self) -> float:
        """Speed of rotation [rad/s]."""
        return self.model.speed

    @property
    def reference_frequency(self) -> float:
        """Frequency of which speeds are multiples [rad/s]."""
        return self.model.reference_frequency

    @cached_property
    def arrays(self) -> StageArrays:
        """Arrays of the stage in a result."""
        arrays, march = self.model.arrays, self.case.march
        changes = sum(
            each is not None for each in (self.case.blade_loss, self.case.shaft.fuse_force)
        )
        if changes:
            arrays = replace(arrays, sudden_changes=changes)
        if not march.varies:
            return arrays
        arrays = replace(arrays, modes_speed=self.speed, **self.over_speeds)
        if march.drive is not None:
            drive = march.drive
            arrays = replace(arrays, drive_torque=drive.torque, drive_loss=drive.loss)
        return arrays

    @property
    def over_speeds(self) -> dict[str, Any]:
        """Further arrays of a stage whose speed varies, by name."""
        return {}

    @property
    @abstractmethod
    def attributes(self) -> Mapping[str, str | float | int]:
        """Attributes of a result that not every stage has."""

    @property
    def symmetry(self) -> Mapping[str, str]:
        """Symmetry of each body in words; empty if the march does not use it."""
        return {}

    @property
    @abstractmethod
    def coating(self) -> WallCoating | None:
        """Coating of the wall."""

    @abstractmethod
    def contact_problem(self, *, steps: bool = True) -> ContactProblem:
        """Return the contact problem; `steps` is false if no time step is taken.

        Raises:
            CaseError: errors that prevent time integration.
        """

    def faults(self, problem: ContactProblem) -> Iterable[Fault]:
        """Return further errors that prevent the time integration of a problem whose numbers are
        finite."""
        return ()

    @abstractmethod
    def hints(self) -> tuple[str, ...]:
        """Return warnings about implausible values, one line each."""

    @abstractmethod
    def forced(self, loads: EngineOrders, omegas: Sequence[float]) -> Iterator[ForcedRotor]:
        """Yield the bladed disk under engine-order forces at each speed [rad/s].

        Raises:
            UserError: a speed is too high, or the equations depend on time.
        """

    @abstractmethod
    def tuned_rotor(self, loads: EngineOrders, omega: float) -> TunedRotor:
        """Return the bladed disk with equal blades under engine-order forces at a speed [rad/s],
        with the stiffness of each blade.

        Raises:
            UserError: the stiffness of the blades is not known.
        """

    def fields(self, coordinates: FloatArray) -> FloatArray:
        """Return the motion of the bladed disk, given in modal coordinates, in coordinates that do
        not depend on the speed."""
        return coordinates

    def coordinates(self, fields: FloatArray) -> FloatArray:
        """Return the modal coordinates of a motion of the bladed disk, see `fields`."""
        return fields


@dataclass(frozen=True)
class MarchedBeams(MarchedStage):
    """Bladed disk of beams in a flexible casing."""

    model: Stage

    @property
    def attributes(self) -> Mapping[str, str | float | int]:
        strength = self.case.material.lowest_yield_strength
        return {
            **({} if strength is None else {"yield_strength": strength}),
            "casing_radius": self.model.reduced_casing.radius,
            "tip_radius": self.model.rotor.tip_radius,
            "blade_length": self.model.disk.model.blade_length,
            "clamped": int(self.case.shaft.clamped),
        }

    @property
    def over_speeds(self) -> dict[str, Any]:
        arrays: dict[str, Any] = {"rotor_inertia": turning_inertia(self.model)}
        if self.model.disk.rotates:
            speeds, whirls = lowest_critical_speeds(self.case, self.model.disk)
            arrays |= {"critical_speed": speeds, "critical_whirl": whirls}
        return arrays

    @property
    def symmetry(self) -> Mapping[str, str]:
        return self.model.symmetry

    @property
    def coating(self) -> WallCoating | None:
        return wall_coating(self.model)

    def contact_problem(self, *, steps: bool = True) -> ContactProblem:
        return contact_problem(self.model, steps=steps)

    def hints(self) -> tuple[str, ...]:
        return stage_hints(self.model)

    def forced(self, loads: EngineOrders, omegas: Sequence[float]) -> Iterator[ForcedRotor]:
        return forced_beams(self.model, loads, omegas)

    def tuned_rotor(self, loads: EngineOrders, omega: float) -> TunedRotor:
        return tuned_beams(self.model, loads, omega)

    def fields(self, coordinates: FloatArray) -> FloatArray:
        """Return displacements or velocities on the free degrees of freedom, (size,)."""
        return np.asarray(self._shapes @ coordinates)

    def coordinates(self, fields: FloatArray) -> FloatArray:
        """Return the modal coordinates of displacements or velocities, (modes,)."""
        return np.asarray(fields @ (self.model.disk.structure.mass @ self._shapes))

    @property
    def _shapes(self) -> FloatArray:
        return self.model.reduction.modes.shapes[:, self.model.kept.rotor]


@dataclass(frozen=True)
class MarchedNodes(MarchedStage):
    """Superelement with any number of contact nodes, in a rigid wall or a flexible casing."""

    model: SuperelementStage

    @property
    def attributes(self) -> Mapping[str, str | float | int]:
        layer, part = self.coating, self.model.part
        strength = self.case.material.lowest_yield_strength
        worn = {"coating_thickness": "thickness", "coating_removable": "removable"}
        return {
            **({} if layer is None else {key: getattr(layer, name) for key, name in worn.items()}),
            **({} if strength is None else {"yield_strength": strength}),
            "superelement": part.name,
            "boundary": self.case.reduction.boundary,
            "casing_radius": self.model.casing_radius,
            "tip_radius": float(part.contact_radius.max()),
            "blade_length": self.model.blade_length,
        }

    @property
    def coating(self) -> WallCoating | None:
        return self.model.coating

    def contact_problem(self, *, steps: bool = True) -> ContactProblem:
        stage = self.model
        problem = with_speed_over_time(stage, stage.problem_at(stage.speed))
        stage.check_start(problem)
        return with_lost_copies(stage, problem)

    def faults(self, problem: ContactProblem) -> Iterator[Fault]:
        """Yield faults of the time step for the modes and for the coating."""
        case, limit = self.case, problem.critical_time_step
        if not case.march.time_step < limit:
            expected = (
                f"less than the critical step {limit:.6g} s (or fewer"
                ' reduction.free_interface_modes, or reduction.boundary = "massless")'
            )
            yield case_fault(case, "march.time_step", f"{expected}{probable_cause(case)}")
        elif (layer := self.coating) is not None:
            yield from rod_faults(case, layer, self.speed, layer.radius)
        yield from loss_faults(case)

    def hints(self) -> tuple[str, ...]:
        return tuple(superelement_hints(self.model))

    def forced(self, loads: EngineOrders, omegas: Sequence[float]) -> Iterator[ForcedRotor]:
        return forced_superelement(self.model, loads, omegas)

    def tuned_rotor(self, loads: EngineOrders, omega: float) -> TunedRotor:
        return tuned_sectors(self.model, loads, omega)


Marchable = Case | Stage | SuperelementStage | MarchedStage  #: what `marched_stage` accepts


def marched_stage(given: Marchable) -> MarchedStage:
    """Return the stage of a case, or of a model, that is marched.

    Raises:
        CaseError: the stage cannot be built.
    """
    if isinstance(given, MarchedStage):
        return given
    if isinstance(given, Case):
        refuse_line(given)
        beams = given.bladed_disk.superelement is None
        given = build_stage(given) if beams else superelement_stage(given)
    return MarchedBeams(given) if isinstance(given, Stage) else MarchedNodes(given)
