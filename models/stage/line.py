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
from bladewhirl.models.case.shaft_line import NONE
from bladewhirl.models.elements.build import case_casing
from bladewhirl.models.inputs.errors import CaseError, UserError
from bladewhirl.models.modal.labels import no_modes
from bladewhirl.models.modal.stage_arrays import StageArrays
from bladewhirl.models.shaft_line.line import LineModel, line_model, parts, real_form
from bladewhirl.models.shaft_line.reduced import ReducedLine, reduced_line
from bladewhirl.models.stage.bearings import Bearings, ShaftLineMotion
from bladewhirl.models.stage.contact_problem import ContactProblem, LostBlades
from bladewhirl.models.stage.kept_modes import KeptModes
from bladewhirl.models.stage.modal_loads import Load, Start
from bladewhirl.models.stage.reduced_rotor import ReducedRotor
from bladewhirl.models.stage.stage import Basis, BladeStiffness, Stage, Turning
from bladewhirl.models.stage.varying_speed import FreeSpeed, SpeedChange
from bladewhirl.models.stage.wall import ReducedCasing
from bladewhirl.models.structure.rotating import Rotating

WITHOUT_BLADES = "not allowed here: a shaft line has no blades"


@dataclass(frozen=True, kw_only=True, repr=False)
class LineStage(Stage):
    """A shaft line, reduced; the masses of its supports are the casing."""

    line: LineModel  #: equations in static axes
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
    def bearings(self) -> Bearings:
        """Bearings of the line in the order of the case, then those against tilt, then the springs
        of the supports."""
        line, rows = self.line, list[tuple[ComplexArray, ComplexArray]]()
        matrices = []
        nodes = self.reduced.rows(np.eye(2 * len(line.position)))
        nodes, fixed = nodes.reshape(len(line.position), 2, -1), self._support
        still, ground = np.zeros_like(nodes[0, 0]), np.zeros_like(fixed[0])
        for number, bearing in enumerate(line.table.bearings):
            rows.append((nodes[line.node(bearing.position), 0], fixed[number]))
            matrices.append((bearing.stiffness, bearing.damping))
        for number, bearing in enumerate(line.table.bearings):
            if np.any(bearing.tilt_stiffness):
                rows.append((nodes[line.node(bearing.position), 1], ground))
                matrices.append((bearing.tilt_stiffness, NONE))
            if bearing.support is not None:
                rows.append((still, fixed[number]))
                matrices.append((bearing.support.stiffness, bearing.support.damping))
        rotor, support = (np.array(each) for each in zip(*rows, strict=True))
        stiffness, damping = (
            np.array([parts(each) for each in kind]) for kind in zip(*matrices, strict=True)
        )
        shaft = ShaftLineMotion(
            nodes=nodes,
            stiffness=self.turning.rotor.stiffness_at(0.0),
            bearings=len(line.table.bearings),
        )
        return Bearings(
            rotor=rotor, support=support, stiffness=stiffness, damping=damping, shaft=shaft
        )

    @cached_property
    def _support(self) -> ComplexArray:
        """Displacement x + i y of the support of each bearing for unit modal coordinates, zero
        without a support, (bearings, 2 * supports)."""
        table, place = self.line.table, 0
        rows = np.zeros((len(table.bearings), 2 * table.supports), dtype=np.complex128)
        for row, bearing in zip(rows, table.bearings, strict=True):
            if bearing.support is not None:
                row[place : place + 2] = np.array([1.0, 1.0j]) / np.sqrt(bearing.support.mass)
                place += 2
        return rows

    @cached_property
    def loads(self) -> tuple[Load, ...]:
        """Loads of the unbalances, whose moment about the axis is that of their masses, and of
        gravity."""
        loads, square = list[Load](), self.speed**2
        still, varies = self.casing_rest, self.case.march.varies
        size = 2 * len(self.line.position)
        unbalance = self.line.unbalance_force(self.line.table.unbalance)[:size]
        if unbalance.any() and square > 0.0:
            pattern = square * self.reduced.forces(unbalance)
            by_square = 1.0 / square if varies else 0.0
            loads.append(Load(rotor=pattern, casing=still, by_square=by_square))
        if unbalance.any() and varies:
            aside = self.reduced.forces(1j * unbalance)
            loads.append(Load(rotor=aside, casing=still, constant=0.0, by_acceleration=-1.0))
        if self.case.gravity is None:
            return tuple(loads)
        on_rotor, on_supports = self._weight
        turning = {"order": 1.0} if varies else {"frequency": self.speed}
        for pull, phase in ((on_rotor, 0.0), (-1j * on_rotor, -0.5 * np.pi)):
            pattern = self.reduced.forces(pull)
            loads.append(Load(rotor=pattern, casing=still, phase=phase, **turning))
        if on_supports.any():
            loads.append(Load(rotor=self.rotor_rest, casing=on_supports))
        return tuple(loads)

    @property
    def _weight(self) -> tuple[ComplexArray, FloatArray]:
        """Weight of the shaft, x + i y on its unknowns, and modal forces on the supports."""
        assert self.case.gravity is not None
        size = 2 * len(self.line.position)
        weight = self.line.weight(complex(*self.case.gravity.acceleration)).astype(np.complex128)
        masses = np.diag(self.line.mass)[size:]
        pull = weight[size:] / np.sqrt(masses)
        return weight[:size], np.stack([pull.real, pull.imag], axis=1).ravel()

    @cached_property
    def start(self) -> Start:
        """Static state under gravity at the speed at the start, in static axes; or no displacement
        at all."""
        modes, gravity = len(self.rotor.frequency), self.case.gravity
        if gravity is None or gravity.start == "unbent":
            return Start.of_rotor(self.rotor_rest, self.rotor_rest, len(self.casing_rest))
        course = self.case.march.course(self.reference_frequency)
        omega = self.speed if course is None else float(course.speed(0.0))
        whole = np.eye(modes + len(self.casing_rest))
        moved, still = (np.hsplit(each, [modes]) for each in (whole, 0.0 * whole))
        force = self.bearings.force(0.0, 0.0, (moved[0], still[0]), (moved[1], still[1]))
        pulls = [np.hstack(self.bearings.pulls(0.0, each)) for each in force]
        stiffness = -np.array(pulls).T
        loss = omega * self.reduced.damping[: modes // 2, : modes // 2].astype(np.complex128)
        own = self.turning.rotor.stiffness_at(0.0)
        stiffness[:modes, :modes] += own + real_form(-1j * loss)
        on_rotor, on_supports = self._weight
        weight = np.concatenate([self.reduced.forces(on_rotor), on_supports])
        rotor, casing = np.split(np.linalg.solve(stiffness, weight), [modes])
        x, y = np.split(rotor, 2)
        against = omega * np.concatenate([y, -x])  # the line stands still in static axes
        return Start(
            rotor=rotor,
            rotor_velocity=against,
            casing=casing,
            casing_velocity=np.zeros_like(casing),
        )

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
        along = sum((load.by_square * load.rotor for load in self.loads), still)
        across = sum((-load.by_acceleration * load.rotor for load in self.loads), still)
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
            loads=self.loads,
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
        shapes = self.reduced.shapes
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
            shaft_shape=np.stack([shapes[0::2], shapes[1::2]], axis=1),
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
    for key in ("wheel", "wheels"):
        if getattr(table, key):
            expected = "no wheel in a march: the blades of a wheel on a shaft line are not marched"
            raise CaseError([case_fault(case, f"shaft_line.{key}", expected)])
    line = line_model(case)
    supports = 2 * line.table.supports
    radius = 0.5 * float(line.shaft.outer.max())
    wall = ReducedCasing.rigid(np.zeros((4, 2)), radius)
    wall = replace(
        wall,
        frequency=np.zeros(supports),
        damping_ratio=np.zeros(supports),
        nodal=np.zeros((4, 4, supports)),
        column=np.full(supports, -1),
        dampers=np.zeros((0, supports)),
    )
    omega, case = line.speed, case.in_seconds(line.reference_frequency)
    reduced = reduced_line(line, omega, line.table.modes, case.march.time_step)
    return LineStage(
        case=case,
        casing=case_casing(case),
        casing_modes=no_modes(),
        reduced_casing=wall,
        reference_frequency=line.reference_frequency,
        kept=KeptModes(
            rotor=np.arange(2 * len(reduced.squares)),
            casing=np.arange(supports),
            coupled=None,
            springs=None,
        ),
        blade=np.zeros(0, dtype=np.int64),
        line=line,
        reduced=reduced,
    )
