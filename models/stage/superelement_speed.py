"""Speed of rotation that varies over time: matrices, loads and start of a stage of superelements.

Displacements are those from the state of steady rotation at the fastest speed b, in the modes at
this speed. With the symbols of `superelement`, and K(Omega) = K + Omega^2 K_1 + Omega^4 K_2, this
state is the solution u of K(b) u = b^2 F for the centrifugal load F. At another speed the loads are

    (Omega^2 - b^2) (F - K_1 u) + Omega' (E - G u),       E = -M (z x X)

so that a constant speed Omega has the state K(Omega) u = Omega^2 F, but for the part of K_2 u,
which is as small as the squares of strains. The modes leave a part of all static displacements of
the contact nodes to the residual flexibility, which is that of K(Omega),

    C(Omega) = B K(Omega)^-1 B^T - P (P^T K(Omega) P)^-1 P^T

and a part of the change of the steady state and of the displacement by Euler forces, which is added
to the gaps (`ContactNodes.growth`). Both are computed at `SPEEDS` speeds and interpolated.
"""

from dataclasses import replace

import numpy as np
from numpy.polynomial.chebyshev import chebpts1

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.speed_course import SpeedCourse
from bladewhirl.models.stage.cone import compliance_in_wall_axes, in_wall_axes
from bladewhirl.models.stage.contact_problem import ContactProblem, Load
from bladewhirl.models.stage.speed_change import with_drive
from bladewhirl.models.stage.superelement_stage import SuperelementStage
from bladewhirl.models.stage.varying_speed import EndsOverSpeeds, SpeedChange
from bladewhirl.models.superelements.reduction import ReducedSuperelement

SPEEDS = 5  #: number of speeds between which flexibility and growth are interpolated


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
    assert reduced.stiffness_speed is not None
    assert reduced.gyroscopic is not None
    coriolis, (load, euler) = 0.5 * reduced.gyroscopic, reduced.loads
    steady = base**2 * load / reduced.frequency**2
    load = load - reduced.stiffness_speed @ steady
    still = np.zeros(len(problem.casing.frequency))
    by_square = np.tile(load, len(factor))
    by_acceleration = (euler - coriolis @ steady / factor[:, None]).ravel()
    loads = (
        Load(rotor=by_square, casing=still, constant=0.0, by_square=1.0),
        Load(rotor=by_acceleration, casing=still, constant=0.0, by_acceleration=1.0),
    )
    ends = _ends(stage, course, base, load)
    change = SpeedChange(
        course=course,
        stiffening=reduced.stiffness_speed,
        stiffening4=reduced.stiffness_speed4,
        coriolis=coriolis,
        factor=factor,
        ends=ends,
    )
    first = float(course.speed(0.0))
    moved = np.linalg.solve(_stiffness(reduced, base, first), (first**2 - base**2) * load)
    start = problem.start.rotor + (moved / factor[:, None]).ravel()
    rotor, nodes = problem.rotor, problem.rotor.nodes
    assert nodes is not None
    if ends is not None:
        rotor = replace(rotor, nodes=replace(nodes, growth=ends.at(base)[1]))
    return replace(
        problem,
        rotor=rotor,
        loads=(*problem.loads, *loads),
        start=replace(problem.start, rotor=start),
        change=change,
    )


def _stiffness(reduced: ReducedSuperelement, base: float, omega: float) -> FloatArray:
    """Return the stiffness at a speed on the modes at the speed `base` [1/s2], (modes, modes)."""
    change = reduced.change(omega) - reduced.change(base)
    return np.asarray(np.diag(reduced.frequency**2) + change)


def _ends(
    stage: SuperelementStage, course: SpeedCourse, base: float, load: FloatArray
) -> EndsOverSpeeds | None:
    """Return the contact nodes at speeds between those of a course, in the axes of the wall; None
    if the speed is constant.

    Args:
        stage: the stage.
        course: speed over time.
        base: speed of the modes [rad/s].
        load: modal forces by Omega^2 about the steady state at this speed, (modes,).
    """
    low, high = course.range
    if low == high:
        return None
    reduced, factor = stage.reduced, stage.factor[:, None, None]
    grown = base**2 * _displaced(reduced)[0]
    speeds = low + 0.5 * (high - low) * (1.0 + chebpts1(SPEEDS))
    compliance, growth = [], []
    for speed in speeds.tolist():
        at_speed, square = stage.reduced_at(speed), speed**2 - base**2
        modes, stiffness = reduced.contact, _stiffness(reduced, base, speed)
        static = (at_speed.contact / at_speed.frequency**2) @ at_speed.contact.T
        static = static + at_speed.compliance - modes @ np.linalg.solve(stiffness, modes.T)
        whole = _displaced(at_speed)
        by_modes = modes @ np.linalg.solve(stiffness, np.array([load, reduced.loads[1]]).T)
        rest = np.array([(speed**2 * whole[0] - grown) / square, whole[1]]) - by_modes.T
        compliance.append(compliance_in_wall_axes(0.5 * (static + static.T), stage.slope) / factor)
        growth.append(in_wall_axes(rest.T, stage.slope).T[:, None] / factor[:, 0])
    return EndsOverSpeeds(speeds=speeds, compliance=np.array(compliance), growth=np.array(growth))


def _displaced(reduced: ReducedSuperelement) -> FloatArray:
    """Return the static displacements of the contact nodes by the loads of the rotation at 1 rad/s
    and 1 rad/s2 [m s2], (2, 3c)."""
    by_modes = (reduced.loads / reduced.frequency**2) @ reduced.contact.T
    return np.asarray(by_modes + reduced.grown)
