"""Tips of a blade that can touch a rigid wall, as nodes of the wheel of `wheel`."""

from collections.abc import Iterable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import scipy.linalg as la

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray, IntArray
from bladewhirl.models.joints.wheel import JointedWheel
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.matrices import Matrices
from bladewhirl.models.stage.modal_loads import NEVER
from bladewhirl.models.stage.wall import harmonics_around

WALL = "casing wall"
"""Name of the wall among the joints of a wheel, which no joint of a case can have."""


class WallContact(NamedTuple):
    """Tips of a blade at a wall."""

    nodes: IntArray  #: numbers of the tips among the contact nodes of a blade, (tips,)
    axes: FloatArray
    """Normal from the wall into the blade, tangent along the rotation, and generator of the wall:
    radial, tangential and axial components as columns, (tips, 3, 3)."""
    gap: FloatArray  #: mean gap over the rotation [m], (tips,)
    varying: dict[int, ComplexArray]  #: see `JointedWheel.wall`, (tips,)
    radius: FloatArray  #: radius of the tips [m], (tips,)
    friction: float  #: friction coefficient
    permanent: bool  #: see `JointedWheel.permanent`


def wall_contact(stage: Matrices, problem: ContactProblem) -> WallContact:
    """Return the tips of the first blade of a stage at the wall of its contact problem, whose
    closure has its final value."""
    rotor = problem.rotor
    nodes = len(rotor.tip_angle) // stage.table.copies
    tips = np.setdiff1d(np.arange(nodes), rotor.joined % nodes)
    slope = np.resize(np.asarray(stage.slope, dtype=np.float64), nodes)[tips]
    clearance = problem.clearance(NEVER)[:, 0]
    part = rotor.normal_part[tips]
    turned = rotor.tip_angle[tips]
    return WallContact(
        nodes=tips,
        axes=np.stack([_axes(each) for each in slope]),
        gap=part * clearance.mean() + rotor.tip_recess[tips],
        varying={
            order: amplitude * part * np.exp(1j * order * turned)
            for order, amplitude in harmonics_around(clearance).items()
        },
        radius=np.resize(rotor.contact_radius, nodes)[tips],
        friction=problem.friction,
        permanent=problem.sliding != "full",
    )


def _axes(slope: float) -> FloatArray:
    """Return the axes of a tip under a wall of a slope [rad], (3, 3)."""
    c, s = np.cos(slope), np.sin(slope)
    return np.array([[-c, 0.0, s], [0.0, 1.0, 0.0], [s, 0.0, c]])


def with_tips(rows: FloatArray, contact: WallContact) -> tuple[FloatArray, FloatArray]:
    """Return the matrix from the displacements of the nodes of a blade to the left and the right
    parts of the joints and tips, (2 * values, 3 * nodes), from that of the joints; and the same for
    displacements by modes that are left out, which tips do not have, as in time integration."""
    own = np.zeros((3 * len(contact.nodes), rows.shape[1]))
    place = (3 * contact.nodes[:, None] + np.arange(3)).ravel()
    none, turned = own.copy(), la.block_diag(*contact.axes.swapaxes(1, 2))
    own[:, place] = turned
    left, right = np.split(rows, 2)
    return np.vstack([left, none, right, own]), np.vstack([left, none, right, none])


def at_wall(wheel: JointedWheel, contact: WallContact) -> JointedWheel:
    """Return a wheel of which the last nodes are the tips, with its wall."""
    tips, joints = len(contact.nodes), len(wheel.joint)
    none = np.zeros(joints)
    return replace(
        wheel,
        names=(*wheel.names, WALL),
        joint=np.append(wheel.joint, np.full(tips, len(wheel.names))),
        friction=np.append(wheel.friction, np.full(tips, contact.friction)),
        gap=np.append(wheel.gap, contact.gap),
        wall={order: np.append(none, gap) for order, gap in contact.varying.items()},
        radius=np.append(none, contact.radius),
        permanent=contact.permanent,
    )


def obstacles(problem: ContactProblem) -> Iterable[str]:
    """Yield reasons why the rub of all blades does not follow from that of one."""
    if problem.casing.is_flexible:
        yield (
            'expected casing.type = "rigid": the waves of a flexible casing are not included; use'
            " bladewhirl run or sweep"
        )
    if problem.coating is not None:
        yield "the coating wears, so that no motion is periodic; remove casing.coating"
    if problem.tip_rotation:
        yield "contact.tip_rotation = true is not included"
    if problem.springs is not None or problem.rotor.anisotropy:
        yield "springs in the static frame couple harmonics"
