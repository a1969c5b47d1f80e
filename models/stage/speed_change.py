"""Speed of rotation that varies over time: matrices, loads and start of a stage.

Displacements are those from the state of steady rotation at the fastest speed b, `Stage.speed`, in
the modes at this speed. Of beams, the geometric stiffness acts on these displacements as at
constant speed, and the loads at the speed Omega are

    (Omega^2 - b^2) M_t (X + u) + Omega' (E - G u / 2)

with the static displacement u in this state, and the positions X at rest. Of a superelement, this
state is the solution u of K(b) u = b^2 F for the centrifugal load F, with the symbols of
`structure.rotating` and K(Omega) = K + Omega^2 K_1 + Omega^4 K_2. The loads

    (Omega^2 - b^2) (F - K_1 u) - (Omega^4 - b^4) K_2 u + Omega' (E - G u / 2)

give the state K(Omega) u = Omega^2 F at a constant speed Omega. The modes include the states of
steady rotation, see `further_modes`. They leave a part of the static displacements by contact
forces to the residual flexibility, which is that of K(Omega),

    C(Omega) = B K(Omega)^-1 B^T - P (P^T K(Omega) P)^-1 P^T

It is computed at `SPEEDS` speeds and interpolated.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.polynomial.chebyshev import chebpts1

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.speed_course import SpeedCourse
from bladewhirl.models.elements.bladed_disk import BladedDiskModel
from bladewhirl.models.elements.structure import Structure
from bladewhirl.models.stage.cone import compliance_in_wall_axes
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.excitations import felt
from bladewhirl.models.stage.modal_loads import Load
from bladewhirl.models.stage.stage import Stage
from bladewhirl.models.stage.varying_speed import (
    ComplianceOverSpeeds,
    FreeSpeed,
    Rotation,
    SpeedChange,
)
from bladewhirl.models.structure.rotating import Rotating
from bladewhirl.models.superelements.reduction import ReducedSuperelement

SPEEDS = 5  #: number of speeds between which the flexibility is interpolated


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


def with_speed_over_time(stage: Stage, problem: ContactProblem) -> ContactProblem:
    """Return the contact problem of a stage with the speed over time of its case.

    With rotation effects the march starts from the steady state at the first speed.
    """
    case = stage.case
    course, drive = case.march.course(stage.reference_frequency), case.march.drive
    if course is None:
        return problem
    if case.effects == "none":
        moving = replace(problem, change=SpeedChange(course=course))
        return moving if drive is None else with_drive(case, moving, stage.inertia)
    turning = stage.turning
    change = SpeedChange(
        course=course,
        rotor=turning.rotor,
        factor=turning.factor,
        compliance=stage.compliance_over(course),
    )
    moving = with_rotation(problem, change, **turning.patterns)
    first, loads = Rotation(0.0, float(course.speed(0.0)), 0.0), moving.loads[len(problem.loads) :]
    pushed = [load.amplitude(0.0, first, problem.speed) * load.rotor for load in loads]
    if drive is not None:  # whose imbalance acts from the start on
        pushed += [load.constant * load.rotor for load in problem.loads]
    by_copy = problem.rotor.by_copy(np.sum(pushed, axis=0))
    moved = np.linalg.solve(turning.rotor.stiffness_at(first.speed), by_copy.T).T
    start = problem.start.rotor + (moved / turning.factor[:, None]).ravel()
    moving = replace(moving, start=replace(problem.start, rotor=start))
    return moving if drive is None else with_drive(case, moving, stage.inertia)


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


def compliance_over_speeds(
    reduced: ReducedSuperelement,
    reduced_at: Callable[[float], ReducedSuperelement],
    factor: FloatArray,
    slope: float | FloatArray,
    course: SpeedCourse,
) -> ComplianceOverSpeeds | None:
    """Return the flexibility of massless contact nodes at speeds between those of a course, in the
    axes of the wall; None if it does not change.

    Args:
        reduced: a copy in its modes.
        reduced_at: function that returns the reduction at a speed [rad/s].
        factor: factor on the stiffness of each copy, (copies,).
        slope: see `Stage.slope`.
        course: speed over time.
    """
    low, high = course.range
    if low == high:
        return None
    speeds = low + 0.5 * (high - low) * (1.0 + chebpts1(SPEEDS))
    compliance = []
    for speed in speeds.tolist():
        at_speed, modes = reduced_at(speed), reduced.contact
        by_modes = modes @ np.linalg.solve(reduced.stiffness_at(speed), modes.T)
        static = (at_speed.contact / at_speed.squares) @ at_speed.contact.T
        static = static + at_speed.compliance - by_modes
        of_one = compliance_in_wall_axes(0.5 * (static + static.T), slope)
        compliance.append(of_one / factor[:, None, None])
    return ComplianceOverSpeeds(speeds=speeds, compliance=np.array(compliance))
