"""Speed of rotation that varies over time: matrices, loads and start of a stage of beams.

Displacements are those from the state of steady rotation at the fastest speed, `Stage.speed`. At
the speed Omega, the centrifugal and Euler forces on the bladed disk in this state are the loads

    (Omega^2 - speed^2) M_t (X + u) + Omega' (E - G u / 2)

with the static displacement u in this state, and the positions X at rest. The geometric stiffness
acts on the displacements from this state, as at constant speed.
"""

from dataclasses import replace

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.speed_course import SpeedCourse
from bladewhirl.models.elements.bladed_disk import BladedDiskModel
from bladewhirl.models.elements.structure import Structure
from bladewhirl.models.rotation.matrices import rotation_matrices
from bladewhirl.models.stage.contact_problem import ContactProblem, Load
from bladewhirl.models.stage.excitations import felt
from bladewhirl.models.stage.stage import Stage
from bladewhirl.models.stage.varying_speed import FreeSpeed, SpeedChange
from bladewhirl.models.structure.rotating import Rotating


def modes_at_speed(
    structure: Structure, squares: FloatArray, shapes: FloatArray
) -> Rotating[FloatArray]:
    """Return a bladed disk in some modes, with the loads of the rotation of its static state.

    Args:
        structure: the bladed disk at its speed, in its static state, see `Structure.displaced`.
        squares: squared frequencies of the modes [rad2/s2], (modes,).
        shapes: fields of the modes on the free DoF [kg^-1/2], (size, modes).
    """
    fields = structure.on_modes(squares, shapes)
    return Rotating(**fields | {name: felt(fields[name]) for name in Rotating.LOADS})


def with_rotation(
    problem: ContactProblem, change: SpeedChange, **patterns: FloatArray
) -> ContactProblem:
    """Return a contact problem with a speed that varies.

    Args:
        problem: contact problem.
        change: speed over time, and the rotor at the speed of the problem.
        patterns: loads on the rotor for factors of 1, (modes,), by the names of these factors, see
            `Load`.
    """
    still = np.zeros(len(problem.casing.frequency))
    loads = tuple(
        Load(rotor=force, casing=still, constant=0.0, **{name: 1.0})
        for name, force in patterns.items()
    )
    return replace(problem, loads=(*problem.loads, *loads), change=change)


def with_speed_change(stage: Stage, problem: ContactProblem) -> ContactProblem:
    """Return the contact problem of a stage with the speed over time of its case.

    With rotation effects the march starts from the static state at the first speed.
    """
    course = stage.case.march.course(stage.reference_frequency)
    if course is None:
        return problem
    disk = stage.disk
    if not disk.rotates:
        changed = replace(problem, change=SpeedChange(course=course))
        return with_drive(stage.case, changed, turning_inertia(stage))
    shapes = stage.reduction.modes.shapes[:, stage.kept.rotor]
    structure = static_state(disk)
    rotor = modes_at_speed(structure, problem.rotor.stiffness, shapes)
    first = float(course.speed(0.0))
    steady = (first**2 - problem.speed**2) * rotor.loads[:, 0]
    if stage.case.march.drive is not None:  # whose imbalance acts from the start on
        steady = steady + sum(load.constant * load.rotor for load in problem.loads)
    start = problem.start.rotor + np.linalg.solve(rotor.stiffness_at(first), steady)
    problem = replace(problem, start=replace(problem.start, rotor=start))
    problem = with_course(problem, course, rotor)
    return with_drive(stage.case, problem, inertia_of(stage.case, structure))


def with_course(
    problem: ContactProblem, course: SpeedCourse, rotor: Rotating[FloatArray]
) -> ContactProblem:
    """Return a contact problem with the speed over time of beams in their modes, see
    `modes_at_speed`."""
    centrifugal, euler = rotor.loads.T
    change = SpeedChange(course=course, rotor=rotor)
    return with_rotation(problem, change, by_square=centrifugal, by_acceleration=euler)


def static_state(disk: BladedDiskModel) -> Structure:
    """Return the structure of a bladed disk in the static state at its speed."""
    structure = disk.structure
    return structure.displaced(structure.static_displacement(disk.speed))


def turning_inertia(stage: Stage) -> float:
    """Return the moment of inertia about the axis of all that turns [kg m2], in the state of steady
    rotation at `Stage.speed`."""
    disk = stage.disk
    return inertia_of(stage.case, static_state(disk) if disk.rotates else rotation_matrices(disk))


def inertia_of(case: Case, structure: Structure) -> float:
    """Return the moment of inertia of all that turns [kg m2]."""
    drive = case.march.drive
    return structure.inertia + (0.0 if drive is None else drive.inertia)


def with_drive(case: Case, problem: ContactProblem, inertia: float) -> ContactProblem:
    """Return the contact problem with the drive of its case, if it has one; `inertia` is that of
    all that turns [kg m2]."""
    given, change, shaft = case.march.drive, problem.change, case.shaft
    if given is None:
        return problem
    drive = FreeSpeed(inertia=inertia, torque=given.torque, loss=given.loss)
    if change is not None and change.rotor is not None:
        still = np.zeros(len(problem.rotor.frequency))
        static = shaft.damping_frame == "static" and not shaft.clamped
        drive = replace(
            drive,
            damping=shaft.damping if static else 0.0,
            along=sum((load.by_square * load.rotor for load in problem.loads), still),
            across=sum((-load.by_acceleration * load.rotor for load in problem.loads), still),
        )
    return replace(problem, drive=drive)
