"""The stage of a shaft line without a bladed wheel: modes, bearings, loads and start of a march."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray, IntArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.excitation import EngineOrder
from bladewhirl.models.case.file import case_fault
from bladewhirl.models.elements.build import case_casing
from bladewhirl.models.inputs.errors import CaseError, UserError
from bladewhirl.models.modal.labels import no_modes
from bladewhirl.models.modal.stage_arrays import StageArrays
from bladewhirl.models.shaft_line.line import line_model
from bladewhirl.models.shaft_line.reduced import ReducedLine, reduced_line
from bladewhirl.models.stage.contact_problem import ContactProblem, LostBlades
from bladewhirl.models.stage.excitations import excitation_loads
from bladewhirl.models.stage.kept_modes import KeptModes
from bladewhirl.models.stage.on_line import StageOnLine, with_supports
from bladewhirl.models.stage.reduced_rotor import ReducedRotor
from bladewhirl.models.stage.stage import Basis, BladeStiffness, Stage, Turning
from bladewhirl.models.stage.varying_speed import FreeSpeed, SpeedChange
from bladewhirl.models.stage.wall import ReducedCasing
from bladewhirl.models.structure.rotating import Rotating

WITHOUT_BLADES = "not allowed here: a shaft line has no blades"


@dataclass(frozen=True, kw_only=True, repr=False)
class LineStage(StageOnLine):
    """A shaft line, reduced; the masses of its supports are the casing."""

    reduced: ReducedLine  #: the shaft on modes at `speed`

    def at(self, omega: float) -> "LineStage":
        return replace(
            self,
            omega=omega,
            reduced=reduced_line(
                self.line, omega, self.line.table.modes, self.case.march.time_step
            ),
        )

    @cached_property
    def rotor(self) -> ReducedRotor:
        squares = np.tile(self.reduced.squares, 2)
        none = np.zeros((0, len(squares)))
        return ReducedRotor(
            frequency=np.sign(squares) * np.sqrt(np.abs(squares)),
            damping_ratio=np.zeros(len(squares)),
            contact=none,
            contact_radius=np.zeros(0),
            centre=np.zeros((2, len(squares))),
            tip_angle=np.zeros(0),
            tip_radius=self.shaft_radius,
            tip_recess=np.zeros(0),
            column=np.full(len(squares), -1),
            dampers=none,
            by_velocity=self.reduced.damping + self.speed * self.reduced.gyroscopic,
        )

    @property
    def shaft_radius(self) -> float:
        """Largest outer radius of the shaft [m]."""
        return 0.5 * float(self.line.shaft.outer.max())

    @cached_property
    def line_nodes(self) -> ComplexArray:
        nodes = len(self.line.position)
        return self.reduced.rows(np.eye(2 * nodes)).reshape(nodes, 2, -1)

    @property
    def line_along(self) -> FloatArray:
        return np.zeros(self.line_nodes.shape)

    @property
    def weight_rows(self) -> FloatArray:
        weight = self.line.weight(1.0)[: 2 * len(self.line.position)]
        return np.stack([self.reduced.forces(weight), self.reduced.forces(1j * weight)])

    @cached_property
    def turning(self) -> Turning:
        modes = len(self.rotor.frequency)
        rotor = Rotating(
            mass=np.eye(modes),
            stiffness=np.diag(self.rotor.stiffness),
            gyroscopic=self.reduced.gyroscopic,
            stiffness_speed=self.reduced.stiffness_speed,
            speed=self.speed,
        )
        return Turning(rotor=rotor, patterns={})

    @property
    def inertia(self) -> float:
        drive = self.case.march.drive
        return self.line.polar_inertia + (0.0 if drive is None else drive.inertia)

    @property
    def problem(self) -> ContactProblem:
        """Contact problem with the speed over time of the case."""
        problem = self.steady_problem
        course, given = self.case.march.course(self.reference_frequency), self.case.march.drive
        if course is None:
            return problem
        change = SpeedChange(course=course, rotor=self.turning.rotor)
        moving = replace(problem, change=change)
        if given is None:
            return moving
        still = self.rotor_rest
        along = sum((load.by_square * load.rotor for load in self.own_loads), still)
        across = sum((-load.by_acceleration * load.rotor for load in self.own_loads), still)
        drive = FreeSpeed(
            inertia=self.inertia,
            torque=given.torque,
            loss=given.loss,
            along=np.asarray(along),
            across=np.asarray(across),
        )
        return replace(moving, drive=drive)

    @property
    def steady_problem(self) -> ContactProblem:
        """Contact problem at the constant speed `speed`."""
        return ContactProblem(
            rotor=self.rotor,
            casing=self.reduced_casing,
            speed=self.speed,
            friction=0.0,
            sliding="permanent",
            tip_rotation=False,
            displacement_limit=self.displacement_limit,
            loads=(*excitation_loads(self), *self.own_loads),
            start=self.start,
            bearings=self.bearings,
        )

    @property
    def displacement_limit(self) -> float:
        return self.case.march.displacement_limit or self.shaft_radius

    @property
    def blade_length(self) -> float:
        raise UserError(WITHOUT_BLADES)

    @property
    def blade_angle(self) -> FloatArray:
        return np.zeros((1, 0))

    @property
    def axial_position(self) -> FloatArray:
        return np.zeros(0)

    def footprint(self) -> FloatArray:
        return np.zeros(0)

    def unit_forces(self, load: EngineOrder) -> FloatArray:
        return np.zeros((0, len(self.rotor.frequency)))

    @property
    def has_centre(self) -> bool:
        return False

    def without_blades(self, given: ContactProblem, turning: ContactProblem) -> LostBlades:
        raise UserError(WITHOUT_BLADES)

    def blade_stiffness(self, omega: float) -> tuple[Stage, BladeStiffness]:
        raise UserError(WITHOUT_BLADES)

    @property
    def basis(self) -> Basis:
        modes, of_plane = self.line.table.modes, 2 * len(self.line.position)
        return Basis("shaft_line.modes", min(modes, of_plane))

    @property
    def fewer_modes(self) -> str:
        return "fewer shaft_line.modes"

    @property
    def own_properties(self) -> dict[str, Any]:
        return {}

    @property
    def node_sets(self) -> Mapping[str, IntArray]:
        return {}

    @property
    def attributes(self) -> Mapping[str, str | float | int]:
        radius = self.shaft_radius
        return {
            **self.case.material.lowest_limits,
            "casing_radius": radius,
            "tip_radius": radius,
            "blade_length": radius,
        }

    @property
    def shown_arrays(self) -> StageArrays:
        none, whole = np.zeros(0), np.zeros(0, dtype=np.int64)
        table = self.line.table
        return StageArrays(
            rotor_frequency=self.rotor.frequency,
            blade=whole,
            node=whole,
            tip_angle=none,
            contact_radius=none,
            axial_position=none,
            tip_recess=none,
            wall_angle=none,
            clearance=none,
            shaft_position=self.line.position,
            shaft_radius=self.line.outer_radius,
            bearing_name=table.named(),
            bearing_node=np.array([self.line.node(each.position) for each in table.bearings]),
        )


def build_line(case: Case) -> LineStage:
    """Return the stage of a case with a shaft line.

    Raises:
        CaseError: the bearings do not hold the line, or it has a wheel.
    """
    table = case.shaft_line
    assert table is not None
    if table.wheels:
        expected = "none without shaft_line.wheel, whose blades a march needs"
        raise CaseError([case_fault(case, "shaft_line.wheels", expected)])
    line = line_model(case)
    radius = 0.5 * float(line.shaft.outer.max())
    wall = ReducedCasing.rigid(np.zeros((4, 2)), radius)
    omega, case = line.speed, case.in_seconds(line.reference_frequency)
    reduced = reduced_line(line, omega, line.table.modes, case.march.time_step)
    return LineStage(
        case=case,
        casing=case_casing(case),
        casing_modes=no_modes(),
        reduced_casing=with_supports(wall, line.table.supports),
        reference_frequency=line.reference_frequency,
        kept=KeptModes(
            rotor=np.arange(2 * len(reduced.squares)),
            casing=np.arange(2 * line.table.supports),
            coupled=None,
            springs=None,
        ),
        blade=np.zeros(0, dtype=np.int64),
        line=line,
        reduced=reduced,
    )
