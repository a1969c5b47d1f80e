"""The friction joints of all blades of a stage, for time integration."""

from collections.abc import Iterator
from dataclasses import replace
from typing import cast

import numpy as np
import scipy.sparse as sp

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.excitation import EngineOrder, Excitation
from bladewhirl.models.case.file import case_fault
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.joints.build import overclosures
from bladewhirl.models.joints.pressed import NoStaticForces, pressed
from bladewhirl.models.joints.surfaces import dampers_of, joint_nodes, surfaces_of
from bladewhirl.models.joints.wheel import DIRECTIONS
from bladewhirl.models.modal.stage_arrays import StageArrays
from bladewhirl.models.stage.build import check_start
from bladewhirl.models.stage.cone import in_wall_axes
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.excitations import left_out, modal_loads
from bladewhirl.models.stage.joint_contacts import JointContacts, rows_of
from bladewhirl.models.stage.matrices import Matrices
from bladewhirl.models.stage.modal_loads import Start
from bladewhirl.models.stage.reduced_rotor import ReducedRotor
from bladewhirl.models.stage.stage import Stage


def with_joints(stage: Stage, problem: ContactProblem) -> ContactProblem:
    """Return the contact problem of a stage with its joints. At the start, the static displacements
    by the forces of the joints are added, which are closed and have no tangential force. Nodes of
    joints do not touch the wall.

    Raises:
        CaseError: a march with joints is not possible, a preload is not possible, or nothing holds
            the blades against it.
    """
    case = stage.case
    if not case.joint:
        return problem
    if faults := [case_fault(case, *each) for each in _obstacles(case)]:
        raise CaseError(faults)
    joints, start = _joint_contacts(
        cast(Matrices, stage), problem
    )  # only superelements have joints
    recess = problem.rotor.tip_recess.copy()
    recess[np.unique(joints.ends[joints.ends >= 0])] += 3.0 * problem.displacement_limit
    rotor = replace(problem.rotor, tip_recess=recess)
    problem = replace(problem, rotor=rotor, joints=joints, start=start)
    check_start(stage, problem)
    return problem


def _obstacles(case: Case) -> Iterator[tuple[str, str]]:
    """Yield keys that a march with joints does not allow, and what is expected."""
    march = case.march
    if case.blade_loss is not None:
        yield "blade_loss", "no loss of blades with [[joint]], as pairs of nodes would lose a side"
    if case.shaft.fuse_force is not None:
        yield (
            "shaft.fuse_force",
            "no value with [[joint]], whose flexibility is that of one support",
        )
    if not march.varies:
        return
    if march.drive is not None:
        yield (
            "march.drive",
            "a prescribed speed with [[joint]]: march.speed, speed_table or run_up",
        )
    if case.rotation.effects != "none":
        yield (
            "rotation.effects",
            '"none" in a march with [[joint]] and a speed that varies, which would change the'
            " flexibility of the joints",
        )
    for number, joint in enumerate(case.joint):
        if joint.opening_by_speed:
            yield f"joint.{number}.opening_by_speed", "false with a speed that varies"
        if joint.kind == "wedge":
            yield (
                f"joint.{number}.kind",
                '"shroud" with a speed that varies, as the force on a damper is that of one speed',
            )


def with_joint_arrays(stage: Stage, problem: ContactProblem) -> StageArrays:
    """Return the arrays of a stage in a result with the joints of its contact problem."""
    joints, arrays, given = problem.joints, stage.arrays, stage.case.joint
    if joints is None:
        return arrays
    return replace(
        arrays,
        joint_name=tuple(given[n].name for n in joints.joint),
        joint_blade=joints.blade,
        damper_blade=joints.blade[np.flatnonzero(joints.damper >= 0)[::2]],
        joint_end=joints.ends,
        joint_gap=joints.gap,
        joint_axes=-joints.axes[:, 1],
    )


def _joint_contacts(stage: Matrices, problem: ContactProblem) -> tuple[JointContacts, Start]:
    """Return the joints of a stage, and the start of its contact problem with them."""
    rotor, start = problem.rotor, problem.start
    case, pairs = stage.case, joint_nodes(stage)
    count = stage.angle.size  # of all nodes
    gaps, surfaces = overclosures(stage, pairs), surfaces_of(stage, pairs)
    ends = np.array([each.ends for each in surfaces])
    number = np.array([each.pair for each in surfaces])
    still = np.array([[each.axes, -each.axes] for each in surfaces])
    joint = pairs.joint[number]
    turned, slope = still.copy(), np.resize(np.asarray(stage.slope, dtype=np.float64), count)[ends]
    if slope.any():
        slope[ends < 0] = 0.0
        turned = in_wall_axes(still.reshape(-1, 3), slope.ravel()).reshape(still.shape)
    still, turned = still.swapaxes(2, 3), turned.swapaxes(2, 3)
    matrix, rigid = rows_of(ends, turned, count), rows_of(ends, still, count)
    assert rotor.compliance is not None  # the case has a massless boundary
    moved = [rigid @ each for load in case.excitations.values() for each in _left_out(load, stage)]
    found = JointContacts(
        joint=joint,
        blade=np.array([each.blade for each in surfaces]),
        ends=ends,
        axes=turned,
        friction=np.array([each.friction for each in case.joint])[joint],
        gap=gaps[number],
        compliance=((matrix @ sp.block_diag(rotor.compliance, format="csr")) @ matrix.T).toarray(),
        by_load=np.reshape(moved, (len(problem.loads), matrix.shape[0])),
        start=np.zeros(0),
        start_force=np.zeros(0),
        **dampers_of(stage, joint, ends, pairs),
    )
    return _pressed(stage, rotor, found, matrix, start)


def _left_out(load: Excitation, stage: Matrices) -> list[FloatArray]:
    """Return the displacements of the contact nodes by the modes that are left out, for each load
    pattern of an excitation [m], (3 * nodes,)."""
    patterns = len(modal_loads(load, stage))
    moved = left_out(load, stage).values() if isinstance(load, EngineOrder) else ()
    parts = [part for each in moved for part in (each.real, each.imag)]
    return parts[:patterns] or [np.zeros(3 * stage.angle.size)] * patterns


def _pressed(
    stage: Matrices, rotor: ReducedRotor, found: JointContacts, rows: sp.csr_array, start: Start
) -> tuple[JointContacts, Start]:
    """Return joints with their forces at the start, and the start with the displacements by them.

    Raises:
        CaseError: nothing holds the blades against the forces, or these do not converge.
    """
    modes = rows @ rotor.all_contact
    force, normal = np.zeros(rows.shape[0]), slice(None, None, DIRECTIONS)
    squares, moved = rotor.stiffness, np.zeros(rotor.stiffness.size)
    tied = found.damper < 0
    if (found.gap < 0.0).any() or not tied.all():
        if not squares.min() > 0.0:
            expected = "no preload or damper, as nothing holds the bladed disk against it"
            raise CaseError([case_fault(stage.case, "joint", expected)])
        across = modes[normal].toarray()
        flexible = found.compliance[normal, normal] + (across / squares) @ across.T
        pushed, outward = np.zeros(len(tied)), found.axes[~tied, 0, 0, 0]
        pushed[~tied] = found.pull[found.damper[~tied], 0] / (2.0 * outward)
        opened = (found.gap + flexible @ pushed)[tied]
        try:
            pushed[tied] = pressed(flexible[np.ix_(tied, tied)], opened)
        except NoStaticForces as error:
            expected = f"joints whose nodes have a static state at the start; {error}"
            raise CaseError([case_fault(stage.case, "joint", expected)]) from error
        force[normal] = pushed
        moved = (modes.T @ force) / squares
    at_rest = (start.rotor.ravel() + moved).reshape(start.rotor.shape)
    place = modes @ at_rest.ravel() + found.compliance @ force
    dampers = np.zeros(found.pull.shape)
    for number in range(len(dampers)):
        own = np.flatnonzero(found.damper == number)
        faces = -found.axes[own, 1, 0, :2]  # normals
        dampers[number, :2] = np.linalg.solve(faces, place[DIRECTIONS * own])
    found = replace(found, damper_start=dampers)
    place = place + found.damper_rows @ dampers.ravel()
    at_nodes = (rows.T @ force).reshape(-1, DIRECTIONS)
    return (
        replace(found, start=place, start_force=force),
        replace(start, rotor=at_rest, contact_force=at_nodes),
    )
