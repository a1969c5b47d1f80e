"""Speed of rotation that varies over time: matrices, loads and start of a stage of beams.

Displacements are those from the state of steady rotation at the fastest speed, `Stage.speed`. At
the speed Omega, the centrifugal and Euler forces on the bladed disk in this state are the loads

    (Omega^2 - speed^2) M_t (X + u) - Omega' G (X + u)

with the static displacement u in this state, and the positions X at rest. The geometric stiffness
acts on the displacements from this state, as at constant speed.
"""

from dataclasses import dataclass, replace

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.speed_course import SpeedCourse
from bladewhirl.models.rotation.at_speed import static_displacement
from bladewhirl.models.rotation.matrices import RotationMatrices, rotation_matrices
from bladewhirl.models.stage.contact_problem import ContactProblem, Load
from bladewhirl.models.stage.excitations import felt
from bladewhirl.models.stage.stage import Stage
from bladewhirl.models.stage.varying_speed import FreeSpeed, SpeedChange


@dataclass(frozen=True, kw_only=True)
class TurningModes:
    """Rotation of a bladed disk in modal coordinates, for displacements from a static state."""

    stiffening: FloatArray  #: see `SpeedChange`, (modes, modes)
    coriolis: FloatArray  #: see `SpeedChange`, (modes, modes)
    centrifugal: FloatArray  #: load for Omega^2 = 1 rad2/s2 [N s2 kg^-1/2], (modes,)
    euler: FloatArray  #: load for Omega' = -1 rad/s2 [N s2 kg^-1/2], (modes,)

    @classmethod
    def of(
        cls, matrices: RotationMatrices, shapes: FloatArray, grown: FloatArray
    ) -> "TurningModes":
        """Return the rotation of a bladed disk in some modes.

        Args:
            matrices: matrices of the bladed disk.
            shapes: fields of the modes on the free DoF [kg^-1/2], (size, modes).
            grown: displacement in the static state [m], (size,).
        """
        stiffening = shapes.T @ ((matrices.geometric - matrices.mass) @ shapes)
        coriolis = shapes.T @ (matrices.coriolis @ shapes)
        centrifugal = matrices.load + matrices.mass @ grown
        euler = matrices.euler + matrices.coriolis @ grown
        return cls(
            stiffening=0.5 * (stiffening + stiffening.T),
            coriolis=0.5 * (coriolis - coriolis.T),
            centrifugal=felt(shapes.T @ centrifugal),
            euler=felt(shapes.T @ euler),
        )

    def in_problem(self, problem: ContactProblem, course: SpeedCourse) -> ContactProblem:
        """Return a contact problem of these modes with a speed that varies."""
        still = np.zeros(len(problem.casing.frequency))
        loads = (
            Load(rotor=self.centrifugal, casing=still, constant=0.0, by_square=1.0),
            Load(rotor=self.euler, casing=still, constant=0.0, by_acceleration=-1.0),
        )
        change = SpeedChange(course=course, stiffening=self.stiffening, coriolis=self.coriolis)
        return replace(problem, loads=(*problem.loads, *loads), change=change)


def with_speed_change(stage: Stage, problem: ContactProblem) -> ContactProblem:
    """Return the contact problem of a stage with the speed over time of its case.

    With rotation effects the march starts from the static state at the first speed.
    """
    course = stage.case.march.course(stage.reference_frequency)
    if course is None:
        return problem
    turning = stage.turning
    if turning is None:
        changed = replace(problem, change=SpeedChange(course=course))
        return with_drive(stage.case, changed, turning_inertia(stage))
    shapes = stage.reduction.modes.shapes[:, stage.kept.rotor]
    grown = static_displacement(turning.matrices, turning.omega)
    modes = TurningModes.of(turning.matrices, shapes, grown)
    square = float(course.speed(0.0)) ** 2 - problem.speed**2
    stiffness = np.diag(problem.rotor.stiffness) + square * modes.stiffening
    steady = square * modes.centrifugal
    if stage.case.march.drive is not None:  # whose imbalance acts from the start on
        steady = steady + sum(load.constant * load.rotor for load in problem.loads)
    start = problem.start.rotor + np.linalg.solve(stiffness, steady)
    problem = replace(problem, start=replace(problem.start, rotor=start))
    return with_drive(stage.case, modes.in_problem(problem, course), turning_inertia(stage))


def turning_inertia(stage: Stage) -> float:
    """Return the moment of inertia about the axis of all that turns [kg m2], in the state of steady
    rotation at `Stage.speed`."""
    turning = stage.turning
    if turning is None:
        return inertia_of(stage.case, rotation_matrices(stage.disk), 0.0)
    grown = static_displacement(turning.matrices, turning.omega)
    return inertia_of(stage.case, turning.matrices, grown)


def inertia_of(case: Case, matrices: RotationMatrices, grown: FloatArray | float) -> float:
    """Return the moment of inertia of all that turns in a static state [kg m2], see
    `TurningModes.of`."""
    drive = case.march.drive
    own = 0.0 if drive is None else drive.inertia
    if isinstance(grown, float):
        return own + matrices.inertia
    return float(own + matrices.inertia + grown @ (2.0 * matrices.load + matrices.mass @ grown))


def with_drive(case: Case, problem: ContactProblem, inertia: float) -> ContactProblem:
    """Return the contact problem with the drive of its case, if it has one; `inertia` is that of
    all that turns [kg m2]."""
    given, change, shaft = case.march.drive, problem.change, case.shaft
    if given is None:
        return problem
    drive = FreeSpeed(inertia=inertia, torque=given.torque, loss=given.loss)
    if change is not None and change.coriolis is not None:
        still = np.zeros(len(problem.rotor.frequency))
        static = shaft.damping_frame == "static" and not shaft.clamped
        drive = replace(
            drive,
            damping=shaft.damping if static else 0.0,
            along=sum((load.by_square * load.rotor for load in problem.loads), still),
            across=sum((-load.by_acceleration * load.rotor for load in problem.loads), still),
        )
    return replace(problem, drive=drive)
