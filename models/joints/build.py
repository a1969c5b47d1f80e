"""The wheel with joints of a stage, for motions that follow one another."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp
from scipy.sparse.linalg import spsolve

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray, IntArray
from bladewhirl.meshes.plane import rotate
from bladewhirl.models.case.excitation import EngineOrder
from bladewhirl.models.case.file import case_fault
from bladewhirl.models.inputs.errors import CaseError, UserError
from bladewhirl.models.joints.surfaces import (
    JointNodes,
    SectorContacts,
    joint_nodes,
    sector_contacts,
)
from bladewhirl.models.joints.tips import at_wall, wall_contact, with_tips
from bladewhirl.models.joints.wheel import DIRECTIONS, JointedWheel
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.forced import ForcedRotor, forced_rotor
from bladewhirl.models.stage.matrices import Matrices
from bladewhirl.models.superelements.cyclic import transformation
from bladewhirl.models.superelements.reduction import rigid_limit

ALIKE = 1e-6  #: largest relative difference of forces on equal blades


def jointed_wheel(stage: Matrices, wall: ContactProblem | None = None) -> JointedWheel:
    """Return the tuned wheel of a case with joints at the speed of the stage, whose tips touch the
    wall of a contact problem if it is given.

    Raises:
        CaseError: the preload of a joint is not possible.
        UserError: blades or forces on them differ, or no load varies with time.
    """
    case, table, rotor = stage.case, stage.table, stage.rotor
    own = table.copies if table.kind != "blade" else 1
    nodes = stage.part.contacts // own
    pairs = joint_nodes(stage)
    surfaces = sector_contacts(stage, pairs)
    rows, joint = surfaces.rows, pairs.joint[surfaces.pair]
    given = rows
    if wall is not None:
        at_tips = wall_contact(stage, wall)
        rows, given = with_tips(rows, at_tips)
    assert rotor.compliance is not None  # the case has a massless boundary
    modes = rotor.contact.shape[1]
    contact = rotor.contact.reshape(own, DIRECTIONS * nodes, modes)
    flexible = rotor.compliance[0].reshape(own, DIRECTIONS * nodes, own, DIRECTIONS * nodes)
    loads = [load for load in case.excitations.values() if isinstance(load, EngineOrder)]
    softness = rotor.by_copy(rotor.stiffness)[0]
    _check_alike(
        stage, loads, flexible + np.einsum("aim,m,bjm->aibj", contact, 1.0 / softness, contact)
    )
    forced = forced_rotor(stage, loads)
    loaded = tuple(dict.fromkeys(number for load in loads for number in load.points))
    points, by_force = _points(stage, loaded)
    tips = np.setdiff1d(np.arange(nodes), np.concatenate([pairs.left, pairs.right]))
    points = np.vstack([points, rotor.contact[_places(tips)]])
    by_force = np.vstack([by_force, rotor.compliance[0][_places(tips)]])
    wheel = JointedWheel(
        names=tuple(each.name for each in case.joint),
        joint=joint,
        friction=np.array([each.friction for each in case.joint])[joint],
        gap=np.zeros(len(joint)),
        speed=stage.speed,
        blades=table.copies,
        stiffness=rotor.by_copy(rotor.stiffness),
        damping=rotor.velocity_forces,
        contact=rows @ contact,
        compliance=np.einsum("ip,apbq,jq->aibj", rows, flexible, rows, optimize=True),
        loads={order: force[:modes] for order, force in forced.forces.items()},
        static={order: given @ _static(forced, order, nodes) for order in forced.forces},
        points=points,
        loaded=loaded,
        tips=tuple(tips.tolist()),
        points_by_force=by_force.reshape(len(by_force), own, DIRECTIONS * nodes) @ rows.T,
    )
    wheel = replace(wheel, gap=overclosures(stage, pairs)[surfaces.pair])
    if len(surfaces.pull):
        wheel = _with_dampers(wheel, surfaces)
    return wheel if wall is None else at_wall(wheel, at_tips)


def _with_dampers(wheel: JointedWheel, surfaces: SectorContacts) -> JointedWheel:
    """Return a wheel with the dampers of its joints as further modes of each copy."""
    own, (values, dampers) = len(wheel.contact), surfaces.dampers.shape
    added = own * dampers
    contact = np.pad(wheel.contact, ((0, 0), (0, 0), (0, added)))
    for blade, place in enumerate(np.split(np.arange(-added, 0), own)):
        contact[blade, -values:, place] = (surfaces.dampers / np.sqrt(surfaces.mass)).T
    return replace(
        wheel,
        dampers=surfaces.dampers,
        pull=surfaces.pull,
        contact=contact,
        stiffness=np.pad(wheel.stiffness, ((0, 0), (0, added))),
        damping=np.pad(wheel.damping, ((0, 0), (0, added), (0, added))),
        loads={order: np.pad(force, (0, added)) for order, force in wheel.loads.items()},
        points=np.pad(wheel.points, ((0, 0), (0, added))),
    )


def _rows(pairs: JointNodes, nodes: int) -> FloatArray:
    """Return the matrix from the displacements of the nodes of a blade to (A^T u_left, -A^T
    u_right), see `wheel`, (2 * values, 3 * nodes)."""
    turned = la.block_diag(np.zeros((0, 0)), *pairs.axes.swapaxes(1, 2))
    rows = np.zeros((2 * len(turned), DIRECTIONS * nodes))
    for sign, side, part in zip((1.0, -1.0), pairs[:2], np.split(rows, 2), strict=True):
        part[:, _places(side)] = sign * turned
    return rows


def _places(nodes: IntArray) -> IntArray:
    """Return the numbers of the displacements of nodes, (3 * nodes,)."""
    return np.asarray((DIRECTIONS * nodes[:, None] + np.arange(DIRECTIONS)).ravel())


def _static(forced: ForcedRotor, order: int, nodes: int) -> ComplexArray:
    """Return the displacements of the nodes of the first blade due to the modes that are left out,
    by an engine order [m], (3 * nodes,)."""
    if order not in forced.static:
        return np.zeros(DIRECTIONS * nodes, dtype=np.complex128)
    return forced.static[order][0, : DIRECTIONS * nodes]


def _points(stage: Matrices, numbers: Sequence[int]) -> tuple[FloatArray, FloatArray]:
    """Return the radial, tangential and axial displacements of points of the file by the modes of a
    copy [kg^-1/2], (3 * points, modes), and by forces on its contact nodes without their part in
    the modes [m/N], (3 * points, 3 * nodes)."""
    reduced = stage.reduced
    if not numbers:
        return np.zeros((0, len(reduced.squares))), np.zeros((0, DIRECTIONS * stage.part.contacts))
    place = np.searchsorted(stage.shown, numbers)
    assert stage.part.points is not None  # the case has points of the file only
    x, y, _ = stage.part.points[place].T
    own = np.arctan2(y, x)
    ways = rotate(np.eye(3), own[:, None])  # (points, directions, components)
    row = np.repeat(np.arange(DIRECTIONS * len(place)), 3)
    column = np.repeat((3 * place[:, None] + np.arange(3))[:, None], DIRECTIONS, axis=1)
    size = DIRECTIONS * len(place), 3 * stage.part.point_count
    rows = sp.csr_array((ways.ravel(), (row, column.ravel())), shape=size)
    return np.asarray(rows @ reduced.points), reduced.points_by_force(rows)


def _check_alike(stage: Matrices, loads: Sequence[EngineOrder], flexible: FloatArray) -> None:
    """Check that blades and forces on them follow one another.

    Args:
        stage: the stage.
        loads: forces of engine order.
        flexible: static displacements of the contact nodes by forces on them [m/N], (blades of a
            copy, values, blades of a copy, values).

    Raises:
        UserError: they do not.
    """
    if stage.case.bladed_disk.mistuning.is_given(stage.table.copies):
        raise UserError("joints: the blades differ; expected no bladed_disk.mistuning")
    if any(load.factors or not isinstance(load.phase, float) for load in loads):
        raise UserError(
            "joints: the forces on the blades differ; expected excitation.factors and a phase for"
            " each blade not given"
        )
    ahead = np.roll(flexible, (1, 1), axis=(0, 2))
    if np.abs(ahead - flexible).max() > ALIKE * np.abs(flexible).max():
        raise UserError(
            "joints: the blades of the wheel differ, or its contact nodes are not listed blade by"
            " blade in the same order"
        )


def overclosures(stage: Matrices, pairs: JointNodes) -> FloatArray:
    """Return the gaps of the nodes of joints without displacements from the state of steady
    rotation; each preload is the sum of the forces on the nodes of its joint at rest, whose
    overclosure is the same [m], (nodes,).

    Args:
        stage: stage with joints.
        pairs: its pairs of nodes.

    Raises:
        CaseError: a preload is not possible, or the file does not tell the opening by the speed.
    """
    joints, joint = stage.case.joint, pairs.joint
    gap = np.array([each.gap or -(each.overclosure or 0.0) for each in joints])
    pressed = [n for n, each in enumerate(joints) if each.preload]
    if pressed:
        inside = np.isin(joint, pressed)
        normal = _alike(stage, pairs)[::DIRECTIONS, ::DIRECTIONS][inside][:, inside]
        member = (joint[inside][:, None] == pressed).astype(np.float64)
        stiff = np.linalg.solve(normal, member)
        force = np.array([joints[n].preload for n in pressed])
        closing = np.linalg.solve(member.T @ stiff, force)
        gap[pressed] = -closing
        least = stiff @ closing
        for place, n in enumerate(pressed):
            if not (closing[place] > 0.0 and least[joint[inside] == n].min() >= 0.0):
                expected = (
                    "a force that presses all nodes of the joint; these blades would lift off at"
                    " one of them, so that overclosure has to be given"
                )
                raise CaseError([case_fault(stage.case, f"joint.{n}.preload", expected)])
    opens = np.array([each.opening_by_speed for each in joints])[joint]
    return np.asarray(gap[joint] + np.where(opens, _opening(stage, pairs), 0.0))


def _alike(stage: Matrices, pairs: JointNodes) -> FloatArray:
    """Return the static displacements of the nodes of a joint by forces on them, the same on all
    blades, which are as stiff as the file [m/N], (values, values)."""
    reduced, own = stage.reduced, stage.blade_angle.shape[1]
    left, right = np.split(_rows(pairs, stage.part.contacts // own), 2)
    rows = np.tile(left + right, own)
    static = reduced.compliance + (reduced.contact / reduced.squares) @ reduced.contact.T
    return np.asarray(rows @ static @ rows.T / own)


def _opening(stage: Matrices, pairs: JointNodes) -> FloatArray:
    """Return the static opening of the nodes of joints by the rotation [m], (nodes,); zero if it is
    not needed.

    Raises:
        CaseError: the file does not tell it.
    """
    case, table = stage.case, stage.table
    wanted = [n for n, each in enumerate(case.joint) if each.opening_by_speed]
    if not wanted:
        return np.zeros(len(pairs.joint))
    own = table.copies if table.kind == "wheel" else 1
    part = stage.part if table.kind == "wheel" else stage.given  # a wheel on its supports
    if part.centrifugal_load is None or stage.reduced.squares.min() <= rigid_limit(stage.part):
        expected = (
            "false, or a supported structure with centrifugal_load in the file, which beams have"
            " with rotation.effects"
        )
        raise CaseError([case_fault(case, f"joint.{wanted[0]}.opening_by_speed", expected)])
    if case.rotation.effects != "none":
        part = part.at(stage.speed, case.rotation.effects)
    tie = sp.eye_array(part.size, format="csr")
    if table.kind == "sector":
        tie = transformation(part, table.copies, 0)
    stiffness = sp.csc_array(tie.T @ sp.csr_array(part.stiffness) @ tie)
    moved = tie @ spsolve(stiffness, stage.speed**2 * (tie.T @ part.centrifugal_load))
    left, right = np.split(_rows(pairs, part.contacts // own), 2)
    of_blade = (part.contact_rows @ moved).reshape(own, -1).mean(axis=0)
    return np.asarray(((left + right) @ of_blade)[::DIRECTIONS])
