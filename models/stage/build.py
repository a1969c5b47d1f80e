"""Build the stage of a case and its contact problem, and report faults that only a built stage
reveals."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import case_fault
from bladewhirl.models.case.plausibility import probable_cause
from bladewhirl.models.elements.build import numbers_within_reach
from bladewhirl.models.inputs.errors import CaseError, Fault
from bladewhirl.models.inputs.mode_names import ALL
from bladewhirl.models.stage.blade_loss import loss_faults
from bladewhirl.models.stage.build_beams import build_beams
from bladewhirl.models.stage.build_matrices import build_matrices
from bladewhirl.models.stage.coating import rod_faults
from bladewhirl.models.stage.cone import wall_share
from bladewhirl.models.stage.contact_problem import ContactProblem, critical_time_step
from bladewhirl.models.stage.excitations import excitation_loads
from bladewhirl.models.stage.fused_support import with_fused_support
from bladewhirl.models.stage.jointed_beams import build_jointed_beams
from bladewhirl.models.stage.line import LineStage, build_line
from bladewhirl.models.stage.loads import initial_state
from bladewhirl.models.stage.modal_loads import Load
from bladewhirl.models.stage.rotor_on_line import build_rotor_on_line
from bladewhirl.models.stage.speed_change import with_speed_over_time
from bladewhirl.models.stage.stage import Stage
from bladewhirl.models.stage.wall import WallClosure

Buildable = Case | Stage  #: what `build_stage` accepts

BEYOND = 1e-9
"""A gap at the start may be negative by this fraction of the clearance, by rounding."""


def build_stage(given: Buildable, *, blades: bool = False) -> Stage:
    """Build the stage of a case, of beams or of a superelement; a stage is returned as it is.

    Args:
        given: a case, or its stage.
        blades: whether the stiffness of each of the equal blades of sectors is needed.

    Raises:
        CaseError: there are more modes requested than possible, the stage is too large for the
            memory, selected modes do not exist, no springs give the suspension frequency, values
            are too extreme for finite elements in double precision, or the matrices of a file
            cannot be reduced as the case demands.
    """
    if not isinstance(given, Case):
        return given
    if given.shaft_line is not None and given.shaft_line.wheel is None:
        return build_line(given)
    if given.bladed_disk.superelement is not None:
        on_line = given.shaft_line is not None
        return build_rotor_on_line(given) if on_line else build_matrices(given, blades=blades)
    if given.shaft_line is not None:
        expected = "a wheel of solids in a march: beams have no displacements along the axis"
        raise CaseError([case_fault(given, "shaft_line.wheel", expected)])
    return build_jointed_beams(given) if given.joint else build_beams(given)


def contact_problem(stage: Stage, *, steps: bool = True) -> ContactProblem:
    """Return the contact problem of a stage; `steps` is false if no time step is taken.

    Raises:
        CaseError: time integration is not possible; the error lists all faults of `march_faults`.
            Also raised if loads exceed the range of floating-point numbers.
    """
    if isinstance(stage, LineStage):
        return _line_problem(stage, steps=steps)
    case, loads = stage.case, _kept_loads(stage)
    if faults := list(march_faults(stage, loads, steps=steps)):
        raise CaseError(faults)
    with numbers_within_reach(case):
        steady = _steady_problem(stage, loads)
        problem = with_speed_over_time(stage, steady)
        check_start(stage, problem)
        if case.blade_loss is not None:
            problem = replace(problem, loss=stage.without_blades(steady, problem))
        return with_fused_support(stage, problem)


def _line_problem(stage: LineStage, *, steps: bool) -> ContactProblem:
    """Return the contact problem of a shaft line.

    Raises:
        CaseError: the time step is not below the stability limit.
    """
    problem, step = stage.problem, stage.case.march.time_step
    limit = problem.critical_time_step
    if steps and step >= limit:
        expected = (
            f"less than the critical step {limit:.6g} s = 2/omega_max (or {stage.fewer_modes})"
        )
        raise CaseError([case_fault(stage.case, "march.time_step", expected)])
    return problem


def steady_problem(stage: Stage) -> ContactProblem:
    """Return the contact problem at the constant speed `Stage.speed`, without sudden changes and
    without checks."""
    return _steady_problem(stage, _kept_loads(stage))


def _kept_loads(stage: Stage) -> tuple[Load, ...]:
    """Return the loads of a case on the modes of `Stage.kept`."""
    kept = stage.kept
    loads = (*excitation_loads(stage), *stage.own_loads)
    return tuple(load.take(kept.rotor, kept.casing) for load in loads)


def _steady_problem(stage: Stage, loads: tuple[Load, ...]) -> ContactProblem:
    case, kept = stage.case, stage.kept
    rotor, casing = stage.bodies
    return ContactProblem(
        rotor=rotor,
        casing=casing,
        speed=stage.speed,
        friction=case.wall_friction,
        sliding=case.contact.sliding,
        tip_rotation=case.contact.tip_rotation,
        displacement_limit=stage.displacement_limit,
        loads=loads,
        start=(stage.start or initial_state(stage)).take(kept.rotor, kept.casing),
        springs=kept.springs,
        bearings=stage.bearings,
        closure=WallClosure.around(case.casing.closure, casing, wall_share(stage.slope)),
        coating=stage.coating,
        foreshortening=stage.foreshortening,
        slope=stage.slope,
    )


def check_start(stage: Stage, problem: ContactProblem) -> None:
    """Check the gaps at the start of a contact problem of a stage; nodes in joints have none.

    Raises:
        CaseError: a tip is beyond the wall.
    """
    gap = problem.initial_gap()
    problem.rotor.by_copy(gap)[:, problem.rotor.joined] = np.inf
    if problem.coating is not None:
        gap = gap - problem.coating.removable
    if gap.min() < -BEYOND * stage.case.casing.clearance:
        copy, node = divmod(int(gap.argmin()), len(stage.blade))
        blade = copy * stage.blade_angle.shape[1] + int(stage.blade[node])
        turned = "" if problem.drive is None else " (the imbalance acts from the start)"
        expected = (
            f"all contact nodes inside the wall at t = 0{turned}: node {node} of blade {blade}"
            f" would be {-gap.min():.4g} m beyond the wall; use a larger clearance, another phase"
            " of its lobes, or casing.closure, which moves the wall inward later"
        )
        raise CaseError([case_fault(stage.case, stage.clearance_key(node), expected)])


def march_faults(stage: Stage, loads: tuple[Load, ...], *, steps: bool = True) -> Iterator[Fault]:
    """Yield all faults that prevent time integration under some loads, without `steps` only those
    of the stage."""
    case, kept, flexible = stage.case, stage.kept, stage.reduced_casing.is_flexible
    if not len(kept.rotor) or (flexible and not len(kept.casing)):
        expected = "modes of the bladed disk and of the casing"
        yield case_fault(case, "reduction.modes", expected)
    if steps:
        yield from time_step_faults(stage)
    yield from stage.own_faults()
    if stage.coating is not None:
        yield from rod_faults(case, stage.coating, stage.speed)
    yield from _load_faults(case, loads)
    yield from _start_faults(stage)
    yield from loss_faults(case)


def time_step_faults(stage: Stage) -> Iterator[Fault]:
    """Yield faults if the time step is not below the stability limit, or not below the time in
    which a tip passes an element of the casing."""
    case, step = stage.case, stage.case.march.time_step
    with numbers_within_reach(case):
        bodies = stage.bodies
        limit = critical_time_step(*bodies, stage.kept.springs, stage.bearings)
        alone = critical_time_step(*bodies, None)
    if limit <= step < alone:
        # The largest omega^2 is a convex function of the stiffness, so it is below its chord.
        share = (step**-2 - alone**-2) / (limit**-2 - alone**-2)
        expected = (
            f"less than {share * case.coupling.stiffness:.4g} N/m, the limit for march.time_step ="
            f" {step:.6g} s (or a time step less than {limit:.6g} s)"
        )
        yield case_fault(case, "coupling.stiffness", expected)
    elif step >= limit:
        expected = (
            f"less than the critical step {limit:.6g} s = 2/omega_max (or"
            f" {stage.fewer_modes}){probable_cause(case)}"
        )
        yield case_fault(case, "march.time_step", expected)
    element = 2.0 * np.pi / case.casing.elements
    if stage.reduced_casing.is_flexible and not abs(stage.speed) * step < element:
        fastest = element / step / stage.reference_frequency
        expected = (
            f"less than {fastest:.6g}, at which a tip passes one casing element in every step"
        )
        speed = case.march.speed
        if speed.kind == "normalised":
            expected += (
                "; a number is a multiple of the reference frequency,"
                f' text such as "{speed.given:g} rpm" is absolute'
            )
        yield case_fault(case, "march.speed", expected)


def _load_faults(case: Case, loads: tuple[Load, ...]) -> Iterator[Fault]:
    """Yield a fault if the load is orthogonal to all selected modes."""
    all_kept = case.reduction.modes == ALL  # a load of zero is no fault
    if loads and not (all_kept or any(load.rotor.any() or load.casing.any() for load in loads)):
        expected = (
            "a load that excites at least one mode kept by"
            f" reduction.modes = {case.reduction.modes!r}"
        )
        key = "excitation" if isinstance(case.excitation, tuple) else "excitation.type"
        yield case_fault(case, key, expected)


def _start_faults(stage: Stage) -> Iterator[Fault]:
    """Yield faults for tips that start beyond the inner face of the casing, and for initial
    displacements above the limit."""
    case, rows = stage.case, stage.case.initial.tip_displacement or ()
    rotor = stage.rotor
    clearance = case.casing.clearance_profile.value(rotor.tip_angle) + rotor.tip_recess
    if case.casing.closure is not None:
        lost = case.casing.closure.value(0.0) * case.casing.closure.around.value(rotor.tip_angle)
        clearance = clearance - lost
        if lost.any() and not clearance.min() > 0.0:
            expected = (
                "a closure at t = 0 that is smaller than the clearance of every tip; its largest"
                f" value at a tip is {lost.max():.6g} m"
            )
            yield case_fault(case, "casing.closure.table", expected)
    of_blade = clearance.reshape(stage.blade_angle.size, -1).min(axis=1)
    for blade, (radial, _) in enumerate(rows):
        if radial > of_blade[blade]:
            expected = (
                f"tips inside the casing: blade {blade} starts {radial:.6g} m outward, but its"
                f" clearance is {of_blade[blade]:.6g} m"
            )
            yield case_fault(case, "initial.tip_displacement", expected)
            break
    limit = stage.displacement_limit
    for key in ("tip_displacement", "centre_displacement"):
        largest = np.abs(getattr(case.initial, key) or 0.0).max()
        if largest > limit:
            expected = f"displacements up to march.displacement_limit = {limit:.6g} m"
            yield case_fault(case, f"initial.{key}", expected)
