"""Speed of rotation that varies over time: matrices, loads and start of a stage of beams.

Displacements are those from the state of steady rotation at the fastest speed, `Stage.speed`. At
the speed Omega, the centrifugal and Euler forces on the bladed disk in this state are the loads

    (Omega^2 - speed^2) M_t (X + u) - Omega' G (X + u)

with the static displacement u in this state, and the positions X at rest. The geometric stiffness
acts on the displacements from this state, as at constant speed.
"""

from dataclasses import replace

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.rotation.at_speed import TurningDisk, static_displacement
from bladewhirl.models.rotation.matrices import rotation_matrices
from bladewhirl.models.stage.contact_problem import (
    ContactProblem,
    FreeSpeed,
    Load,
    SpeedChange,
)
from bladewhirl.models.stage.excitations import felt
from bladewhirl.models.stage.stage import Stage


def with_speed_change(stage: Stage, problem: ContactProblem) -> ContactProblem:
    """Return the contact problem of a stage with the speed over time of its case.

    With rotation effects the march starts from the static state at the first speed.
    """
    course = stage.case.march.course(stage.reference_frequency)
    if course is None:
        return problem
    turning = stage.turning
    if turning is None:
        return _with_drive(stage, replace(problem, change=SpeedChange(course=course)))
    shapes = stage.reduction.modes.shapes[:, stage.kept.rotor]
    matrices = turning.matrices
    stiffening = shapes.T @ ((matrices.geometric - matrices.mass) @ shapes)
    stiffening = 0.5 * (stiffening + stiffening.T)
    coriolis = shapes.T @ (matrices.coriolis @ shapes)
    coriolis = 0.5 * (coriolis - coriolis.T)
    change = SpeedChange(course=course, stiffening=stiffening, coriolis=coriolis)
    centrifugal, euler = (felt(shapes.T @ load) for load in _loads_in_steady_state(turning))
    still = np.zeros(len(problem.casing.frequency))
    loads = (
        Load(rotor=centrifugal, casing=still, constant=0.0, by_square=1.0),
        Load(rotor=euler, casing=still, constant=0.0, by_acceleration=-1.0),
    )
    square = float(course.speed(0.0)) ** 2 - problem.speed**2
    stiffness = np.diag(problem.rotor.stiffness) + square * stiffening
    steady = square * centrifugal
    if stage.case.march.drive is not None:  # whose imbalance acts from the start on
        steady = steady + sum(load.constant * load.rotor for load in problem.loads)
    start = problem.start.rotor + np.linalg.solve(stiffness, steady)
    problem = replace(
        problem,
        loads=(*problem.loads, *loads),
        start=replace(problem.start, rotor=start),
        change=change,
    )
    return _with_drive(stage, problem)


def turning_inertia(stage: Stage) -> float:
    """Return the moment of inertia about the axis of all that turns [kg m2], in the state of steady
    rotation at `Stage.speed`."""
    drive, turning = stage.case.march.drive, stage.turning
    own = 0.0 if drive is None else drive.inertia
    if turning is None:
        return own + rotation_matrices(stage.disk).inertia
    matrices, grown = turning.matrices, static_displacement(turning.matrices, turning.omega)
    return float(own + matrices.inertia + grown @ (2.0 * matrices.load + matrices.mass @ grown))


def _with_drive(stage: Stage, problem: ContactProblem) -> ContactProblem:
    """Return the contact problem with the drive of its case, if it has one."""
    given, change, shaft = stage.case.march.drive, problem.change, stage.case.shaft
    if given is None:
        return problem
    drive = FreeSpeed(inertia=turning_inertia(stage), torque=given.torque, loss=given.loss)
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


def _loads_in_steady_state(turning: TurningDisk) -> tuple[FloatArray, FloatArray]:
    """Return the loads for Omega^2 = 1 rad2/s2 and for Omega' = -1 rad/s2 on the free DoF."""
    matrices = turning.matrices
    grown = static_displacement(matrices, turning.omega)
    centrifugal = matrices.load + matrices.mass @ grown
    return centrifugal, matrices.euler + matrices.coriolis @ grown
