"""The friction joints of all blades of a stage, for time integration."""

from dataclasses import replace

import numpy as np
import scipy.sparse as sp

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.excitation import EngineOrder, Excitation
from bladewhirl.models.case.file import case_fault
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.joints.build import axes, joint_nodes, overclosures
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

STEPS = 100  #: largest number of changes of the closed pairs at the start


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
    assert isinstance(stage, Matrices)  # only superelements have joints
    for key, given in (
        ("march.speed", case.march.varies),
        ("blade_loss", case.blade_loss is not None),
        ("shaft.fuse_force", case.shaft.fuse_force is not None),
    ):
        if given:
            expected = "a constant speed" if key == "march.speed" else "not allowed"
            raise CaseError([case_fault(case, key, f"{expected} in a march with [[joint]]")])
    joints, start = _joint_contacts(stage, problem)
    recess = problem.rotor.tip_recess.copy()
    recess[np.unique(joints.ends)] += 3.0 * problem.displacement_limit
    rotor = replace(problem.rotor, tip_recess=recess)
    problem = replace(problem, rotor=rotor, joints=joints, start=start)
    check_start(stage, problem)
    return problem


def with_joint_arrays(stage: Stage, problem: ContactProblem) -> StageArrays:
    """Return the arrays of a stage in a result with the joints of its contact problem."""
    joints, arrays, given = problem.joints, stage.arrays, stage.case.joint
    if joints is None:
        return arrays
    return replace(
        arrays,
        joint_name=tuple(given[n].name for n in joints.joint),
        joint_blade=arrays.blade[joints.ends[:, 1]],
        joint_end=joints.ends,
        joint_gap=joints.gap,
        joint_axes=np.stack([axes(given[n].direction).T for n in joints.joint]),
    )


def _joint_contacts(stage: Matrices, problem: ContactProblem) -> tuple[JointContacts, Start]:
    """Return the joints of a stage, and the start of its contact problem with them."""
    rotor, start = problem.rotor, problem.start
    case, blades, pairs = stage.case, stage.table.copies, joint_nodes(stage)
    count = len(stage.angle.ravel())  # of all nodes
    number = np.arange(blades)[:, None]
    first, second = count // blades * ((number + 1) % blades), count // blades * number
    ends = np.stack([first + pairs.left, second + pairs.right], axis=2).reshape(-1, 2)
    turned = np.tile(np.stack([pairs.axes, -pairs.axes], axis=1), (blades, 1, 1, 1))
    of_wall = turned.swapaxes(2, 3)
    slope = np.resize(np.asarray(stage.slope, dtype=np.float64), count)[ends]
    still = rows_of(ends, of_wall, count)
    if slope.any():
        along = in_wall_axes(turned.reshape(-1, 3), slope.ravel())
        of_wall = along.reshape(turned.shape).swapaxes(2, 3)
    rows = rows_of(ends, of_wall, count)
    assert rotor.compliance is not None  # the case has a massless boundary
    moved = [still @ each for load in case.excitations.values() for each in _left_out(load, stage)]
    found = JointContacts(
        joint=np.tile(pairs.joint, blades),
        ends=ends,
        axes=of_wall,
        friction=np.tile(np.array([each.friction for each in case.joint])[pairs.joint], blades),
        gap=np.tile(overclosures(stage, pairs), blades),
        compliance=((rows @ sp.block_diag(rotor.compliance, format="csr")) @ rows.T).toarray(),
        by_load=np.reshape(moved, (len(problem.loads), rows.shape[0])),
        start=np.zeros(0),
        start_force=np.zeros(0),
    )
    return _pressed(stage, rotor, found, rows, start)


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
        CaseError: nothing holds the blades against the forces.
    """
    modes = rows @ rotor.all_contact
    force, normal = np.zeros(rows.shape[0]), slice(None, None, DIRECTIONS)
    squares, moved = rotor.stiffness, np.zeros(rotor.stiffness.size)
    if (found.gap < 0.0).any():
        if not squares.min() > 0.0:
            expected = "no preload or overclosure, as nothing holds the bladed disk against it"
            raise CaseError([case_fault(stage.case, "joint", expected)])
        across = modes[normal].toarray()
        flexible = found.compliance[normal, normal] + (across / squares) @ across.T
        force[normal] = pressed(flexible, found.gap)
        moved = (modes.T @ force) / squares
    at_rest = (start.rotor.ravel() + moved).reshape(start.rotor.shape)
    place = modes @ at_rest.ravel() + found.compliance @ force
    at_nodes = (rows.T @ force).reshape(-1, DIRECTIONS)
    return (
        replace(found, start=place, start_force=force),
        replace(start, rotor=at_rest, contact_force=at_nodes),
    )


def pressed(flexible: FloatArray, gap: FloatArray) -> FloatArray:
    """Return the normal forces that close gaps: 0 <= l, flexible l + gap >= 0, of which one is zero
    for each node [N], (nodes,), by a semismooth Newton method.

    Args:
        flexible: static displacements by normal forces [m/N], (nodes, nodes), positive definite.
        gap: gaps without forces [m], (nodes,).
    """
    force, closed = np.zeros(len(gap)), gap < 0.0
    for _ in range(STEPS):
        force = np.zeros(len(gap))
        force[closed] = np.linalg.solve(flexible[np.ix_(closed, closed)], -gap[closed])
        after = force - (flexible @ force + gap) / np.diag(flexible) > 0.0
        if (after == closed).all():
            break
        closed = after
    return force
