"""Surfaces of joints that touch each other: those of two blades, or of a blade and a damper."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.case.file import case_fault
from bladewhirl.models.case.joint import Joint
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.joints.wheel import DIRECTIONS
from bladewhirl.models.stage.joint_contacts import damper_rows, rows_of
from bladewhirl.models.stage.matrices import Matrices


def axes(normal: Sequence[float] | FloatArray) -> FloatArray:
    """Return the matrix A of a joint, whose columns are the normal and two tangents: radial,
    tangential and axial components, (3, 3)."""
    n = np.asarray(normal, dtype=np.float64)
    first = np.cross([1.0, 0.0, 0.0], n)
    first /= np.linalg.norm(first)
    return np.column_stack([n, first, np.cross(n, first)])


class JointNodes(NamedTuple):
    """Pairs of nodes of joints, which each blade has with the next one."""

    left: IntArray  #: nodes on the clockwise side of a blade, (pairs,)
    right: IntArray  #: nodes on its counter-clockwise side, (pairs,)
    joint: IntArray  #: number of the joint of each pair, (pairs,)
    axes: FloatArray  #: see `axes`, (pairs, 3, 3)


def joint_nodes(stage: Matrices) -> JointNodes:
    """Return the pairs of nodes of the joints of a stage."""
    sides = [stage.table.joint_nodes(joint) for joint in stage.case.joint]
    if not sides:
        none = np.zeros(0, dtype=np.int64)
        return JointNodes(none, none, none, np.zeros((0, DIRECTIONS, DIRECTIONS)))
    left, right = (np.concatenate(each) for each in zip(*sides, strict=True))
    joint = np.repeat(np.arange(len(sides)), [len(side[0]) for side in sides])
    turned = np.stack([axes(each.direction) for each in stage.case.joint])
    return JointNodes(left, right, joint, turned[joint])


class Surfaces(NamedTuple):
    """A pair of surfaces in contact."""

    blade: int  #: blade whose joint it is
    pair: int  #: number of its pair of nodes
    ends: tuple[int, int]  #: see `JointContacts.ends`
    axes: FloatArray  #: normal from the second to the first end, and two tangents, as columns


def surfaces_of(stage: Matrices, pairs: JointNodes) -> list[Surfaces]:
    """Return the pairs of surfaces of all blades, blade by blade."""
    blades = stage.table.copies
    return [each for n in range(blades) for each in _of_blade(stage, pairs, n, blades)]


def _of_blade(stage: Matrices, pairs: JointNodes, blade: int, blades: int) -> list[Surfaces]:
    """Return the pairs of surfaces of a blade in a number of blades."""
    nodes = stage.angle.size // stage.table.copies
    return [
        Surfaces(blade, n, *each)
        for n, joint in enumerate(pairs.joint)
        for each in _touching(stage.case.joint[joint], pairs, n, blade, blades, nodes)
    ]


class SectorContacts(NamedTuple):
    """Pairs of surfaces of the joints of a blade, and its dampers in the directions in which these
    move."""

    rows: FloatArray
    """Displacements (A^T u_left, -A^T u_right), see `wheel`, by those of the nodes of a blade; both
    surfaces of a damper have only one of them, (2 * values, 3 * nodes)."""
    pair: IntArray  #: number of the pair of nodes of each pair of surfaces, (pairs,)
    dampers: FloatArray  #: values for unit displacements of dampers, (values, dampers)
    mass: FloatArray  #: mass of each damper [kg], (dampers,)
    pull: FloatArray  #: centrifugal force on each damper [N], (dampers,)


def sector_contacts(stage: Matrices, pairs: JointNodes) -> SectorContacts:
    """Return the surfaces of the joints of one blade.

    Raises:
        CaseError: a damper has no centrifugal force, or several nodes.
    """
    own = _of_blade(stage, pairs, 0, 2)
    ends = np.array([each.ends for each in own], dtype=np.int64).reshape(-1, 2)
    each_axes = np.array([[each.axes.T, -each.axes.T] for each in own]).reshape(-1, 2, 3, 3)
    pair = np.array([each.pair for each in own], dtype=np.int64)
    given = dampers_of(stage, pairs.joint[pair], ends, pairs)
    mobility = given["mobility"].ravel()
    moving = mobility > 0.0
    both = rows_of(ends, each_axes, 2 * (stage.angle.size // stage.table.copies)).toarray()
    right, left = np.split(both, 2, axis=1)
    return SectorContacts(
        rows=np.vstack([left, right]),
        pair=pair,
        dampers=damper_rows(given["damper"], each_axes)[:, moving],
        mass=1.0 / mobility[moving],
        pull=given["pull"].ravel()[moving],
    )


def _touching(
    joint: Joint, pairs: JointNodes, n: int, blade: int, blades: int, nodes: int
) -> list[tuple[tuple[int, int], FloatArray]]:
    """Return ends and axes of the surfaces of a pair of nodes: one pair, or those of a damper."""
    left, right = nodes * ((blade + 1) % blades) + pairs.left[n], nodes * blade + pairs.right[n]
    if joint.wedge is None:
        return [((left, right), pairs.axes[n])]
    c, s = np.cos(joint.wedge.angle), np.sin(joint.wedge.angle)
    return [((left, -1), axes([s, c, 0.0])), ((right, -1), axes([s, -c, 0.0]))]


def dampers_of(
    stage: Matrices, joint: IntArray, ends: IntArray, pairs: JointNodes
) -> dict[str, Any]:
    """Return the arrays of the dampers of a stage.

    Raises:
        CaseError: a damper has no centrifugal force, or several nodes.
    """
    case, damper = stage.case, np.full(len(joint), -1, dtype=np.int64)
    held = np.flatnonzero(ends[:, 1] < 0)
    damper[held] = np.arange(len(held)) // 2
    mobility, pull = np.zeros((2, len(held) // 2, DIRECTIONS))
    for number, pair in enumerate(held[::2]):
        own, wedge = int(joint[pair]), case.joint[joint[pair]].wedge
        assert wedge is not None
        if not stage.speed or np.count_nonzero(pairs.joint == own) > 1:
            key = "march.speed" if not stage.speed else f"joint.{own}.left"
            expected = "a speed at which the centrifugal force presses the dampers"
            expected = expected if not stage.speed else "one node on each side of a damper"
            raise CaseError([case_fault(case, key, expected)])
        radius = wedge.radius
        if radius is None:
            radius = float(np.resize(stage.part.contact_radius, ends.max() + 1)[ends[pair, 0]])
        field = radius * stage.speed**2
        mass = wedge.mass if wedge.force is None else wedge.force / field
        assert mass is not None
        mobility[number] = 1.0 / mass
        pull[number, 0] = mass * field
        if wedge.axial == "held":
            mobility[number, 2] = 0.0
    return {"damper": damper, "mobility": mobility, "pull": pull, "damper_start": 0.0 * pull}
