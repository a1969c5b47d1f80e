"""Support that fuses: springs at the centre whose stiffness falls when their force passes a limit.

In modal coordinates the stiffness changes by C^T dK C with the motion C of the centre. The
coordinates after the change are the modes with this stiffness; the motion is the same in both. The
springs count displacements from the same state as before, so that the static displacement u_s of
the centre adds the load -dK u_s. The damping of the structure stays as it is.
"""

from dataclasses import replace

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.file import case_fault
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.stage.contact_problem import ContactProblem, FusedSupport, LostBlades
from bladewhirl.models.stage.modal_loads import Load
from bladewhirl.models.stage.reduced_rotor import ReducedRotor
from bladewhirl.models.stage.stage import Stage
from bladewhirl.models.structure.rotating import of_modes


def with_fused_support(stage: Stage, problem: ContactProblem) -> ContactProblem:
    """Return the contact problem of a stage with the support of its case that fuses, if it has one.

    Raises:
        CaseError: the support fuses at the start.
    """
    shaft = stage.case.shaft
    if shaft.fuse_force is None:
        return problem
    assert shaft.fused_stiffness is not None
    before, after = np.array(shaft.stiffnesses), np.full(2, shaft.fused_stiffness)
    fused = with_fuse(problem, before, after, stage.steady_centre, shaft.fuse_force)
    assert fused.fuse is not None
    start = fused.fuse.constant + fused.fuse.force @ problem.start.rotor
    if not np.hypot(*start) < shaft.fuse_force:
        expected = f"more than {np.hypot(*start):.4g} N, the force at the start"
        raise CaseError([case_fault(stage.case, "shaft.fuse_force", expected)])
    return fused


def with_fuse(
    problem: ContactProblem,
    before: FloatArray,
    after: FloatArray,
    place: FloatArray,
    limit: float,
) -> ContactProblem:
    """Return a contact problem, before and after a loss of blades, with a support that fuses.

    Args:
        problem: contact problem.
        before: stiffness along x and y before [N/m], (2,).
        after: stiffness after [N/m], (2,).
        place: displacement of the centre in the static state [m], (2,).
        limit: force at which the support fuses [N].
    """
    centre, loss = problem.rotor.centre, problem.loss
    square, ways = np.linalg.eigh(
        np.diag(problem.rotor.stiffness) + centre.T @ ((after - before)[:, None] * centre)
    )
    still = np.zeros(len(problem.casing.frequency))
    lacking = Load(rotor=-centre.T @ ((after - before) * place), casing=still)
    loads = (*problem.loads, lacking) if lacking.rotor.any() else problem.loads
    fused = _in_modes(replace(problem, loads=loads), square, ways)
    if loss is not None:
        remains = with_fuse(loss.after, before, after, place, limit)
        assert remains.fuse is not None
        other = remains.fuse.extension
        lost = LostBlades(
            time=loss.time,
            after=remains.fuse.after,
            restriction=other.T @ loss.restriction @ ways,
            extension=ways.T @ loss.extension @ other,
            tips=loss.tips,
            reach=loss.reach,
        )
        fused = replace(fused, loss=lost)
        problem = replace(problem, loss=replace(loss, after=remains))
    support = FusedSupport(
        after=fused,
        restriction=ways.T,
        extension=ways,
        force=before[:, None] * centre,
        constant=before * place,
        limit=limit,
    )
    return replace(problem, fuse=support)


def _in_modes(problem: ContactProblem, square: FloatArray, ways: FloatArray) -> ContactProblem:
    """Return a contact problem in other coordinates of the rotor, in which its stiffness is
    diagonal.

    Args:
        problem: contact problem.
        square: stiffness in these coordinates [rad2/s2], (modes,).
        ways: old coordinates for unit new ones, orthogonal, (modes, modes).
    """
    rotor, change, drive = problem.rotor, problem.change, problem.drive
    bending = problem.foreshortening
    if bending is not None:
        bending = replace(bending, rows=bending.rows @ ways)
    if change is not None and change.rotor is not None:
        turned = replace(change.rotor.on(ways), **of_modes(square))
        change = replace(change, rotor=turned)
    if drive is not None and len(drive.along):
        drive = replace(drive, along=ways.T @ drive.along, across=ways.T @ drive.across)
    start = problem.start
    return replace(
        problem,
        rotor=_rotor_in_modes(rotor, square, ways),
        loads=tuple(replace(load, rotor=ways.T @ load.rotor) for load in problem.loads),
        start=replace(
            start,
            rotor=ways.T @ start.rotor,
            rotor_velocity=ways.T @ start.rotor_velocity,
        ),
        foreshortening=bending,
        change=change,
        drive=drive,
        loss=None,
        fuse=None,
    )


def _rotor_in_modes(rotor: ReducedRotor, square: FloatArray, ways: FloatArray) -> ReducedRotor:
    """Return a rotor in other coordinates, see `_in_modes`."""
    rates = np.diag(2.0 * rotor.damping_ratio * np.abs(rotor.frequency))
    damping = rates if rotor.by_velocity is None else rates + rotor.by_velocity
    return replace(
        rotor,
        frequency=np.sign(square) * np.sqrt(np.abs(square)),
        damping_ratio=np.zeros(len(square)),
        contact=rotor.contact @ ways,
        centre=rotor.centre @ ways,
        column=np.full(len(square), -1),
        dampers=rotor.dampers @ ways,
        by_velocity=ways.T @ damping @ ways,
    )
