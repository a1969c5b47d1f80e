"""Make the contact problem of a stage, and report faults that only a built stage reveals."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from bladewhirl.models.case.file import case_fault
from bladewhirl.models.case.plausibility import probable_cause
from bladewhirl.models.elements.build import numbers_within_reach
from bladewhirl.models.elements.foreshortening import blade_beams, drawback, fewest_terms
from bladewhirl.models.inputs.errors import CaseError, Fault
from bladewhirl.models.stage.blade_loss import loss_faults, with_blade_loss
from bladewhirl.models.stage.coating import coating_faults, wall_coating
from bladewhirl.models.stage.contact_problem import (
    ContactNodes,
    ContactProblem,
    Foreshortening,
    ReducedCasing,
    ReducedRotor,
    WallClosure,
    critical_time_step,
)
from bladewhirl.models.stage.fused_support import with_fused_support
from bladewhirl.models.stage.loads import excitation_loads, initial_state
from bladewhirl.models.stage.speed_change import with_speed_change
from bladewhirl.models.stage.stage import Stage


def contact_problem(stage: Stage, *, steps: bool = True) -> ContactProblem:
    """Return the contact problem of a stage; `steps` is false if no time step is taken.

    Raises:
        CaseError: time integration is not possible; the error lists all faults of `march_faults`.
            Also raised if loads exceed the range of floating-point numbers.
    """
    faults = list(march_faults(stage, steps=steps))
    if faults:
        raise CaseError(faults)
    case, kept = stage.case, stage.kept
    with numbers_within_reach(case):
        rotor, casing = marched_bodies(stage)
        if case.contact.sliding == "full":
            rotor = with_contact_nodes(rotor)
        problem = ContactProblem(
            rotor=rotor,
            casing=casing,
            speed=stage.speed,
            friction=case.wall_friction,
            sliding=case.contact.sliding,
            tip_rotation=case.contact.tip_rotation,
            displacement_limit=stage.displacement_limit,
            loads=tuple(load.take(kept.rotor, kept.casing) for load in excitation_loads(stage)),
            start=initial_state(stage).take(kept.rotor, kept.casing),
            springs=kept.springs,
            closure=WallClosure.around(
                case.casing.closure, stage.wall_angle, stage.casing.mesh.radius
            ),
            coating=wall_coating(stage),
            foreshortening=foreshortening(stage),
        )
        turning = with_speed_change(stage, problem)
        if turning.drive is not None and (gap := turning.initial_gap()).min() < 0.0:
            expected = (
                "all tips inside the wall at t = 0: with march.drive the imbalance acts from the"
                f" start on; tip {int(gap.argmin())} would be {-gap.min():.4g} m beyond the wall"
            )
            raise CaseError([case_fault(case, "casing.clearance", expected)])
        return with_fused_support(stage, with_blade_loss(stage, problem, turning))


def with_contact_nodes(rotor: ReducedRotor) -> ReducedRotor:
    """Return a rotor of beams whose tips, which do not move along the axis, are contact nodes."""
    nodes = ContactNodes(
        axial=np.zeros_like(rotor.tip_radial),
        radius=rotor.tip_radius - rotor.tip_recess,
        compliance=None,
    )
    return replace(rotor, nodes=nodes)


def marched_bodies(stage: Stage) -> tuple[ReducedRotor, ReducedCasing]:
    """Return bladed disk and casing in the modes of `reduction.modes`."""
    return stage.rotor.take(stage.kept.rotor), stage.reduced_casing.take(stage.kept.casing)


def march_faults(stage: Stage, *, steps: bool = True) -> Iterator[Fault]:
    """Yield all faults that prevent time integration, without `steps` only those of the stage."""
    flexible = stage.reduced_casing.is_flexible
    if not len(stage.kept.rotor) or (flexible and not len(stage.kept.casing)):
        expected = "modes of the bladed disk and of the casing"
        yield case_fault(stage.case, "reduction.modes", expected)
    if steps:
        yield from time_step_faults(stage)
    yield from foreshortening_faults(stage)
    yield from coating_faults(stage)
    yield from _load_faults(stage)
    yield from _start_faults(stage)
    yield from loss_faults(stage.case)


def time_step_faults(stage: Stage) -> Iterator[Fault]:
    """Yield faults if the time step is not below the stability limit, or not below the time in
    which a tip passes an element of the casing."""
    case, step = stage.case, stage.case.march.time_step
    with numbers_within_reach(case):
        bodies = marched_bodies(stage)
        limit = critical_time_step(*bodies, stage.kept.springs)
        alone = critical_time_step(*bodies, None)
    if limit <= step < alone:
        # The largest omega^2 is a convex function of the stiffness, so it is below its chord.
        share = (step**-2 - alone**-2) / (limit**-2 - alone**-2)
        expected = (
            f"less than {share * case.coupling.stiffness:.4g} N/m, the limit for march.time_step ="
            f" {step:.6g} s (or a time step less than {limit:.6g} s)"
        )
        yield case_fault(case, "coupling.stiffness", expected)
    elif not step < limit:
        expected = (
            f"less than the critical step {limit:.6g} s = 2/omega_max (or fewer"
            " casing.elements, bladed_disk.elements_per_blade or"
            f" reduction.fixed_interface_modes){probable_cause(case)}"
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


def _load_faults(stage: Stage) -> Iterator[Fault]:
    """Yield a fault if the load is orthogonal to all selected modes."""
    case, kept = stage.case, stage.kept
    loads = excitation_loads(stage)
    felt = [load.take(kept.rotor, kept.casing) for load in loads]
    if loads and not any(load.rotor.any() or load.casing.any() for load in felt):
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
    for blade, (radial, _) in enumerate(rows):
        if radial > clearance[blade]:
            expected = (
                f"tips inside the casing: blade {blade} starts {radial:.6g} m outward, but its"
                f" clearance is {clearance[blade]:.6g} m"
            )
            yield case_fault(case, "initial.tip_displacement", expected)
            break
    limit = stage.displacement_limit
    for key in ("tip_displacement", "centre_displacement"):
        largest = np.abs(getattr(case.initial, key) or 0.0).max()
        if largest > limit:
            expected = f"displacements up to march.displacement_limit = {limit:.6g} m"
            yield case_fault(case, f"initial.{key}", expected)


NEGLECTED = 1e-6
"""Terms of a quadratic form are neglected if they are below this fraction of the largest term when
all modes have the same energy."""


def foreshortening(stage: Stage) -> Foreshortening | None:
    """Return the foreshortening of the blades in the modes of `reduction.modes`; None if the case
    has none. See `models.elements.foreshortening` for the quadratic form."""
    if not stage.case.contact.foreshortening:
        return None
    modes = stage.reduction.modes.take(stage.kept.rotor)
    frequency = np.abs(modes.frequency)
    weight = np.maximum(frequency, 0.01 * np.median(frequency))
    around = stage.case.contact.tip_rotation
    forms = [
        fewest_terms(*drawback(stage.disk, modes.shapes, blade, around=around), weight, NEGLECTED)
        for blade in range(len(stage.disk.model.tips))
    ]
    terms = max(len(signs) for _, signs, _ in forms)
    rows, sign = np.zeros((len(forms), terms, modes.count)), np.zeros((len(forms), terms))
    for blade, (row, signs, _) in enumerate(forms):
        rows[blade, : len(signs)], sign[blade, : len(signs)] = row, signs
    return Foreshortening(rows=rows, sign=sign, frequency=max(each for *_, each in forms))


def foreshortening_faults(stage: Stage) -> Iterator[Fault]:
    """Yield a fault if no beam ends at a tip."""
    case, model = stage.case, stage.disk.model
    if not case.contact.foreshortening:
        return
    for blade, tip in enumerate(model.tips):
        if not len(blade_beams(model, int(tip)).lines):
            expected = f"false, because no beam ends at the tip of blade {blade}"
            yield case_fault(case, "contact.foreshortening", expected)
            break
