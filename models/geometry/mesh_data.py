"""Conversion between beam models and lines with groups and data, the content of mesh files.

Lines are beams, with the data ``width``, ``thickness``, ``young_modulus`` and ``density`` at their
middle and, where sections change along lines, ``width_change`` and so on from the first node of a
line to its second; or springs, with ``spring_radial``, ``spring_tangential`` and
``spring_rotation``; or rigid links from leader to led node, with ``rigid`` = 1. Nodes have ``mass``
and ``inertia`` and, where a spring leads to the rotating frame, ``ground_radial``,
``ground_tangential``, ``ground_rotation``. All are SI; what a line or node has not is not a number.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from bladewhirl.meshes.files.groups import RIGID, SPRING, GroupedLines
from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.geometry.beam_model import (
    GROUND,
    BeamModel,
    NodeSprings,
    PointMasses,
    RigidLinks,
)
from bladewhirl.models.sections.rectangular import CHANGES, QUANTITIES

MASSES = ("mass", "inertia")
GROUNDED = tuple(name.replace("spring", "ground") for name in SPRING)


def grouped_lines(model: BeamModel) -> GroupedLines:
    """Convert a beam model to the content of a mesh file: sets as groups, the rest as data."""
    mesh, springs, links = model.mesh, model.springs, model.links
    acts = springs.stiffness.any(axis=1)
    between, grounded = acts & (springs.other != GROUND), acts & (springs.other == GROUND)
    joints = np.column_stack([springs.node, springs.other])[between]
    rigid = np.column_stack([links.leader, links.led])
    beams = np.arange(len(mesh.lines))
    data = {name: (beams, getattr(model.properties, name)) for name in QUANTITIES}
    for name in CHANGES:
        if getattr(model.properties, name).any():
            data[name] = (beams, getattr(model.properties, name))
    joint_lines = len(beams) + np.arange(len(joints))
    for name, stiffness in zip(SPRING, springs.stiffness[between].T, strict=True):
        data[name] = (joint_lines, stiffness)
    data[RIGID] = (len(beams) + len(joints) + np.arange(len(rigid)), np.ones(len(rigid)))
    count = len(beams) + len(joints) + len(rigid)
    on_nodes = {
        **{name: (model.masses.node, getattr(model.masses, name)) for name in MASSES},
        **{
            name: (springs.node[grounded], stiffness)
            for name, stiffness in zip(GROUNDED, springs.stiffness[grounded].T, strict=True)
        },
    }
    return GroupedLines(
        points=mesh.points,
        lines=np.vstack([mesh.lines, joints, rigid]),
        node_groups=mesh.node_sets,
        line_groups=mesh.line_sets,
        node_data={
            name: _summed(len(mesh.points), *values)
            for name, values in on_nodes.items()
            if len(values[0])
        },
        line_data={
            name: _summed(count, *values) for name, values in data.items() if len(values[0])
        },
    )


def point_masses(mesh: GroupedLines) -> PointMasses:
    """Point masses among the data of a mesh.

    Raises:
        ValueError: a mass is negative.
    """
    node, (mass, inertia) = _table(mesh.node_data, MASSES, len(mesh.points))
    return PointMasses(node=node, mass=mass, inertia=inertia)


def springs(mesh: GroupedLines) -> NodeSprings:
    """Springs among the lines and the data of a mesh.

    Raises:
        ValueError: a stiffness is negative.
    """
    line, between = _table(mesh.line_data, SPRING, len(mesh.lines))
    node, grounded = _table(mesh.node_data, GROUNDED, len(mesh.points))
    return NodeSprings(
        node=np.append(mesh.lines[line, 0], node),
        other=np.append(mesh.lines[line, 1], np.full(len(node), GROUND)),
        stiffness=np.hstack([between, grounded]).T,
    )


def rigid_links(mesh: GroupedLines) -> RigidLinks:
    """Rigid links among the lines of a mesh."""
    leader, led = mesh.lines[mesh.is_rigid].T
    return RigidLinks(led=led, leader=leader)


def _summed(size: int, places: IntArray, values: FloatArray) -> FloatArray:
    """Return one number per node, summed over coincident ones; NaN where there is none."""
    data = np.full(size, np.nan)
    data[places] = 0.0
    np.add.at(data, places, values)
    return data


def _table(
    data: Mapping[str, FloatArray], names: Sequence[str], size: int
) -> tuple[IntArray, FloatArray]:
    """Return the positions with non-zero data and all data there, (names, positions)."""
    rows = [np.nan_to_num(data.get(name, np.zeros(size))) for name in names]
    table = np.stack(rows)
    if table.size and table.min() < 0.0:
        name = names[int(np.unravel_index(table.argmin(), table.shape)[0])]
        raise ValueError(f"{name} of zero or more, not {table.min():g}")
    nonzero = np.flatnonzero(table.any(axis=0))
    return nonzero, table[:, nonzero]
