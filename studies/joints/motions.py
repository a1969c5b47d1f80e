"""Search of periodic motions of a tuned wheel with friction joints or a rub."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple, cast

import numpy as np

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.excitation import EngineOrder, NoExcitation
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.joints.build import jointed_wheel
from bladewhirl.models.joints.limits import LIMITS
from bladewhirl.models.joints.tips import obstacles
from bladewhirl.models.joints.wheel import JointedWheel
from bladewhirl.models.stage.build import build_stage
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.matrices import Matrices
from bladewhirl.models.stage.modal_loads import NEVER
from bladewhirl.models.stage.stage import Stage
from bladewhirl.solvers.periodic.blade import obstacles_over_time
from bladewhirl.solvers.periodic.contact import NotConverged
from bladewhirl.solvers.periodic.joint_search import joint_motion
from bladewhirl.solvers.periodic.joints import JointGrid, JointMotion, common_order

ALL_BLADES = "one motion for all blades"
"""The kind of motion in messages."""


class Found(NamedTuple):
    """A motion, and the stage and the contact problem that it belongs to."""

    stage: Matrices
    problem: ContactProblem
    motion: JointMotion


def applies(case: Case) -> bool:
    """Return whether motions of a case are those of all blades of a tuned wheel."""
    table = None if case.shaft_line is not None else case.bladed_disk.superelement
    return bool(case.joint) or (table is not None and table.kind != "blade")


def found_at(
    stage: Stage, problem: ContactProblem, speed: str, before: Sequence[Found] = ()
) -> Found:
    """Return a periodic motion of a tuned wheel with joints, or with a wall that it touches.

    Args:
        stage: stage of a superelement.
        problem: its contact problem.
        speed: text of the speed in messages.
        before: motions at other speeds, near the last of which the motion may be.

    Raises:
        CaseError: the preload of a joint is not possible.
        UserError: the method does not apply, or no motion was found.
    """
    check(stage, problem)
    own = cast(Matrices, stage)  # of superelements, see `applies`
    start = before[-1].motion if before else None
    try:
        motion = _motion(own, problem, start)
    except NotConverged as missed:
        raise UserError(f"periodic: no periodic motion was found at {speed}: {missed}") from None
    if not motion.touches and not stage.case.joint:
        raise UserError(
            f"periodic: no contact at {speed}: the smallest gap is"
            f" {1e3 * motion.smallest_gap:.4g} mm"
        )
    if reason := beyond(problem, motion):
        raise UserError(f"periodic: at {speed} {reason}")
    return Found(own, problem, motion)


def stage_of(case: Case, like: Matrices | None = None) -> Matrices:
    """Return the stage of a case with joints; `like`: that of a case that differs only in speed,
    joints and loads."""
    if like is None:
        return cast(Matrices, build_stage(case))  # only superelements have joints
    stage = cast(Matrices, like.with_case(case))
    if case.rotation.effects != "none":
        return like.build(stage.case, like)
    return replace(stage, omega=case.march.speed.rad_per_s(like.reference_frequency))


def _motion(stage: Matrices, problem: ContactProblem, start: JointMotion | None) -> JointMotion:
    """Return a motion, with the wall only if it is touched without it; for errors see `found_at`
    and `joint_motion`."""
    if stage.case.joint and (wheel := jointed_wheel(stage)).varies:
        motion = joint_motion(wheel, start)
        if not reaches(problem, motion):
            return motion
    return joint_motion(rubbing_wheel(stage, problem), start)


def rubbing_wheel(stage: Matrices, problem: ContactProblem) -> JointedWheel:
    """Return the wheel of a stage whose tips touch the wall of its contact problem.

    Raises:
        UserError: the method does not apply.
    """
    for reason in obstacles(problem):
        raise UserError(f"periodic: {ALL_BLADES}: {reason}")
    wheel = jointed_wheel(stage, problem)
    if not wheel.varies:
        raise UserError(
            "periodic: the wall is round and no load varies with time, so that the motion has no"
            " period"
        )
    return wheel


def check(stage: Stage, problem: ContactProblem) -> None:
    """Check that the motions of a stage follow from one blade.

    Raises:
        UserError: they do not.
    """
    if problem.speed == 0.0:
        raise UserError("periodic: march.speed = 0: expected a speed at which the loads vary")
    for reason in obstacles_over_time(problem):
        raise UserError(f"periodic: {reason}")
    for key, load in stage.case.excitations.items():
        if not isinstance(load, EngineOrder | NoExcitation):
            raise UserError(f'periodic: {key}.type = "{load.type}": expected engine orders or none')
    if any(abs(load.rotor).any() for load in problem.loads if load.end != NEVER):
        raise UserError("periodic: a load ends; expected loads without an end")


def reaches(problem: ContactProblem, motion: JointMotion) -> bool:
    """Return whether the tips of a motion without a wall can be beyond it."""
    tips = motion.of_points[:, len(motion.grid.wheel.loaded) :, 0]
    nearest = problem.clearance(NEVER)[:, 0].min() + problem.rotor.tip_recess.min()
    return bool(tips.size and tips.max() > nearest)


def beyond(problem: ContactProblem, motion: JointMotion) -> str:
    """Return why the displacements of a motion are too large; empty if they are not."""
    largest = float(np.abs(motion.of_points).max(initial=0.0))
    if largest <= problem.displacement_limit:
        return ""
    return (
        f"points move by {largest:.4g} m, beyond march.displacement_limit ="
        f" {problem.displacement_limit:.4g} m"
    )


def amplitudes_of(motion: JointMotion) -> ComplexArray:
    """Return the complex amplitudes of the lowest engine order at `JointedWheel.shown` [m],
    (points, 3)."""
    wheel = motion.grid.wheel
    order = wheel.shown_order
    return wheel.at_points(order, motion.of_order(order))[: len(wheel.shown)]


def limits_of(wheel: JointedWheel) -> FloatArray:
    """Return the amplitudes of the same points in the linear limits, (limits, points) [m]."""
    order = wheel.shown_order
    moved = [wheel.limit(order, held)[: len(wheel.shown)] for held in LIMITS.values()]
    return np.asarray(np.linalg.norm(moved, axis=-1))


def alike(found: Sequence[Found]) -> list[JointMotion]:
    """Return motions that all have a wall if one of them touches it."""
    motions = [each.motion for each in found]
    if not any(motion.grid.wheel.rubs for motion in motions):
        return motions
    for n, (stage, problem, motion) in enumerate(found):
        if not motion.grid.wheel.rubs:
            wheel = rubbing_wheel(stage, problem)
            finer = motion.grid.order // common_order(wheel)
            grid = JointGrid(wheel, motion.grid.harmonics * finer)
            motions[n] = replace(motion.on(grid), change=motion.change)
    return motions
