"""The wheel with joints of a stage, for motions that follow one another."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import chain

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray, IntArray
from bladewhirl.meshes.plane import rotate
from bladewhirl.models.case.excitation import EngineOrder
from bladewhirl.models.case.file import case_fault
from bladewhirl.models.case.joint import Joint
from bladewhirl.models.inputs.errors import CaseError, UserError
from bladewhirl.models.joints.wheel import DIRECTIONS, JointedWheel
from bladewhirl.models.stage.forced import ForcedRotor, forced_rotor
from bladewhirl.models.stage.matrices import Matrices

ALIKE = 1e-6  #: largest relative difference of forces on equal blades


def axes(normal: Sequence[float] | FloatArray) -> FloatArray:
    """Return the matrix A of a joint, whose columns are the normal and two tangents: radial,
    tangential and axial components, (3, 3)."""
    n = np.asarray(normal, dtype=np.float64)
    first = np.cross([1.0, 0.0, 0.0], n)
    first /= np.linalg.norm(first)
    return np.column_stack([n, first, np.cross(n, first)])


def jointed_wheel(stage: Matrices) -> JointedWheel:
    """Return the tuned wheel of a case with joints at the speed of the stage.

    Raises:
        CaseError: the preload of a joint is not possible.
        UserError: blades or forces on them differ, or no load varies with time.
    """
    case, table, rotor = stage.case, stage.table, stage.rotor
    own = table.copies if table.kind != "blade" else 1
    pairs = [table.joint_nodes(joint) for joint in case.joint]
    nodes = stage.part.contacts // own
    sides = [list(chain.from_iterable(side)) for side in zip(*pairs, strict=True)]
    turned = la.block_diag(
        *(
            np.kron(np.eye(len(left)), axes(joint.direction).T)
            for joint, (left, _) in zip(case.joint, pairs, strict=True)
        )
    )
    rows = np.zeros((2 * len(turned), DIRECTIONS * nodes))
    for side, part in enumerate(np.split(rows, 2)):
        part[:, _places(sides[side])] = (1.0, -1.0)[side] * turned
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
    tips = _places(np.setdiff1d(np.arange(nodes), np.concatenate(sides)).tolist())
    points = np.vstack([points, rotor.contact[tips]])
    by_force = np.vstack([by_force, rotor.compliance[0][tips]])
    joint = np.repeat(np.arange(len(pairs)), [len(left) for left, _ in pairs])
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
        static={order: rows @ _static(forced, order, nodes) for order in forced.forces},
        points=points,
        loaded=loaded,
        points_by_force=by_force.reshape(len(by_force), own, DIRECTIONS * nodes) @ rows.T,
    )
    return replace(wheel, gap=_gaps(wheel, case.joint, stage))


def _places(nodes: Sequence[int]) -> IntArray:
    """Return the numbers of the displacements of nodes, (3 * nodes,)."""
    return np.asarray((DIRECTIONS * np.asarray(nodes)[:, None] + np.arange(DIRECTIONS)).ravel())


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


def _gaps(wheel: JointedWheel, joints: Sequence[Joint], stage: Matrices) -> FloatArray:
    """Return the gaps at rest of the nodes of joints; each preload is the sum of the forces on the
    nodes of its joint, whose overclosure is the same [m], (nodes,).

    Raises:
        CaseError: a preload is not possible.
    """
    given = [each.gap or -(each.overclosure or 0.0) for each in joints]
    pressed = [n for n, each in enumerate(joints) if each.preload]
    gap = np.array(given)
    if pressed:
        inside = np.isin(wheel.joint, pressed)
        normal = wheel.flexibility(0, 0.0)[::DIRECTIONS, ::DIRECTIONS].real[inside][:, inside]
        member = (wheel.joint[inside][:, None] == pressed).astype(np.float64)
        stiff = np.linalg.solve(normal, member)
        force = np.array([joints[n].preload for n in pressed])
        closing = np.linalg.solve(member.T @ stiff, force)
        gap[pressed] = -closing
        least = stiff @ closing
        for place, n in enumerate(pressed):
            if not (closing[place] > 0.0 and least[wheel.joint[inside] == n].min() >= 0.0):
                expected = (
                    "a force that presses all nodes of the joint; these blades would lift off at"
                    " one of them, so that overclosure has to be given"
                )
                raise CaseError([case_fault(stage.case, f"joint.{n}.preload", expected)])
    return gap[wheel.joint]
