"""Speed of rotation that varies over time: matrices, loads and start of a stage of superelements.

Displacements are those from the state of steady rotation at the fastest speed b, in the modes at
this speed. With the symbols of `structure.rotating`, and K(Omega) = K + Omega^2 K_1 + Omega^4 K_2,
this state is the solution u of K(b) u = b^2 F for the centrifugal load F. At another speed the
loads are

    (Omega^2 - b^2) (F - K_1 u) - (Omega^4 - b^4) K_2 u + Omega' (E - G u / 2)

so that a constant speed Omega has the state K(Omega) u = Omega^2 F. The modes include the states of
steady rotation, see `further_modes`. They leave a part of the static displacements by contact
forces to the residual flexibility, which is that of K(Omega),

    C(Omega) = B K(Omega)^-1 B^T - P (P^T K(Omega) P)^-1 P^T

It is computed at `SPEEDS` speeds and interpolated.
"""

from dataclasses import fields, replace

import numpy as np
from numpy.polynomial.chebyshev import chebpts1

from bladewhirl.models.case.speed_course import SpeedCourse
from bladewhirl.models.stage.cone import compliance_in_wall_axes
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.speed_change import with_drive, with_rotation
from bladewhirl.models.stage.superelement_stage import SuperelementStage
from bladewhirl.models.stage.varying_speed import ComplianceOverSpeeds, Rotation, SpeedChange
from bladewhirl.models.structure.rotating import Rotating

SPEEDS = 5  #: number of speeds between which the flexibility is interpolated


def with_speed_over_time(stage: SuperelementStage, problem: ContactProblem) -> ContactProblem:
    """Return the contact problem of a stage with the speed over time of its case.

    With rotation effects the march starts from the steady state at the first speed.
    """
    course = stage.case.march.course(stage.reference_frequency)
    if course is None:
        return problem
    if stage.case.rotation.effects == "none":
        drive = stage.case.march.drive
        changed = replace(problem, change=SpeedChange(course=course))
        return changed if drive is None else with_drive(stage.case, changed, drive.inertia)
    reduced, base, factor = stage.reduced, problem.speed, stage.factor
    load, euler = reduced.loads.T
    steady = base**2 * load / reduced.squares
    patterns = {
        "by_square": np.tile(load - reduced.stiffness_speed @ steady, len(factor)),
        "by_acceleration": (euler - reduced.coriolis @ steady / factor[:, None]).ravel(),
    }
    if reduced.stiffness_speed4 is not None:
        patterns["by_fourth"] = np.tile(-reduced.stiffness_speed4 @ steady, len(factor))
    change = SpeedChange(
        course=course,
        rotor=Rotating(**{each.name: getattr(reduced, each.name) for each in fields(Rotating)}),
        factor=factor,
        compliance=_compliance(stage, course),
    )
    moving = with_rotation(problem, change, **patterns)
    first, loads = Rotation(0.0, float(course.speed(0.0)), 0.0), moving.loads[len(problem.loads) :]
    pushed = [each.amplitude(0.0, first, base) * each.rotor for each in loads]
    stiffness = reduced.stiffness_at(first.speed)
    by_copy = problem.rotor.by_copy(np.sum(pushed, axis=0))
    moved = np.linalg.solve(stiffness, by_copy.T).T / factor[:, None]
    start = problem.start.rotor + moved.ravel()
    return replace(moving, start=replace(problem.start, rotor=start))


def _compliance(stage: SuperelementStage, course: SpeedCourse) -> ComplianceOverSpeeds | None:
    """Return the flexibility of massless contact nodes at speeds between those of a course, in the
    axes of the wall; None if it does not change.

    Args:
        stage: the stage.
        course: speed over time.
    """
    low, high = course.range
    if low == high or stage.case.reduction.boundary != "massless":
        return None
    reduced, factor = stage.reduced, stage.factor[:, None, None]
    speeds = low + 0.5 * (high - low) * (1.0 + chebpts1(SPEEDS))
    compliance = []
    for speed in speeds.tolist():
        at_speed, modes = stage.reduced_at(speed), reduced.contact
        by_modes = modes @ np.linalg.solve(reduced.stiffness_at(speed), modes.T)
        static = (at_speed.contact / at_speed.squares) @ at_speed.contact.T
        static = static + at_speed.compliance - by_modes
        compliance.append(compliance_in_wall_axes(0.5 * (static + static.T), stage.slope) / factor)
    return ComplianceOverSpeeds(speeds=speeds, compliance=np.array(compliance))
