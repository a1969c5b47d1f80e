"""Conversion between mesh files and beam models.

A line of a mesh file is one of three kinds:

* a beam, with the data ``width``, ``thickness``, ``young_modulus`` and ``density`` at its middle.
  If its section varies, ``width_change`` and so on are the changes from its first to its second
  node;
* a spring, with ``spring_radial``, ``spring_tangential`` and ``spring_rotation``;
* a rigid link from the leader to the led node, with ``rigid`` = 1.

A node may have ``mass`` and ``inertia``. A spring between a node and the rotating frame is given by
``ground_radial``, ``ground_tangential`` and ``ground_rotation`` of the node. All data are in SI
units. Data that do not apply to a line or node are NaN.
"""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from bladewhirl.meshes.files.groups import RIGID, SPRING, GroupedLines
from bladewhirl.meshes.line_mesh import FloatArray, IntArray, LineMesh
from bladewhirl.meshes.symmetry import rotational_sectors, symmetric_points
from bladewhirl.models.case.mesh_file import KEY, SAME_PLACE, MeshTable
from bladewhirl.models.geometry.beam_model import (
    AT_ORIGIN,
    GROUND,
    BeamModel,
    NodeSprings,
    PointMasses,
    RigidLinks,
    check_model,
)
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.sections.rectangular import (
    CHANGES,
    QUANTITIES,
    LineProperties,
    Material,
    along,
)

MASSES = ("mass", "inertia")
GROUNDED = tuple(name.replace("spring", "ground") for name in SPRING)


def grouped_lines(model: BeamModel) -> GroupedLines:
    """Convert a beam model to the contents of a mesh file, with sets as groups."""
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
    on_nodes = {name: (model.masses.node, getattr(model.masses, name)) for name in MASSES}
    for name, stiffness in zip(GROUNDED, springs.stiffness[grounded].T, strict=True):
        on_nodes[name] = (springs.node[grounded], stiffness)
    return GroupedLines(
        points=mesh.points,
        lines=np.vstack([mesh.lines, joints, rigid]),
        node_groups=mesh.node_sets,
        line_groups=mesh.line_sets,
        node_data=_summed(len(mesh.points), on_nodes),
        line_data=_summed(count, data),
    )


def point_masses(mesh: GroupedLines) -> PointMasses:
    """Return the point masses that the node data of a mesh describe.

    Raises:
        ValueError: a mass is negative.
    """
    node, (mass, inertia) = _table(mesh.node_data, MASSES, len(mesh.points))
    return PointMasses(node=node, mass=mass, inertia=inertia)


def springs(mesh: GroupedLines) -> NodeSprings:
    """Return the springs that the line data and the node data of a mesh describe.

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


def _summed(size: int, data: Mapping[str, tuple[IntArray, FloatArray]]) -> dict[str, FloatArray]:
    """Return for each name an array in which values with the same index are added. Entries without
    a value are NaN; names without values are left out."""
    arrays = {name: np.full(size, np.nan) for name, (places, _) in data.items() if len(places)}
    for name, array in arrays.items():
        places, values = data[name]
        array[places] = 0.0
        np.add.at(array, places, values)
    return arrays


def _table(
    data: Mapping[str, FloatArray], names: Sequence[str], size: int
) -> tuple[IntArray, FloatArray]:
    """Return the positions at which any of the data is not zero, and the data at these positions,
    (names, positions)."""
    rows = [np.nan_to_num(data.get(name, np.zeros(size))) for name in names]
    table = np.stack(rows)
    if table.size and table.min() < 0.0:
        name = names[int(np.unravel_index(table.argmin(), table.shape)[0])]
        raise ValueError(f"{name} of zero or more, not {table.min():g}")
    nonzero = np.flatnonzero(table.any(axis=0))
    return nonzero, table[:, nonzero]


TIP_RADII = (1e-3, 10.0)
"""Smallest and largest accepted tip radius [m]; other values are due to a wrong unit of length."""


def mesh_beam_model(table: MeshTable, material: Material) -> BeamModel:
    """Make a beam model of the mesh file of a case.

    Nodes and lines keep the order of the file. A mesh that is rotationally symmetric with a
    relative tolerance of 1e-6 gets sectors, and its points are made exactly symmetric.

    Args:
        table: mesh file and the meaning of its groups.
        material: material of the case, with the named materials. Lines without a material in the
            file have this material.

    Raises:
        CaseError: the file cannot be read, the table does not match the file, or the resulting
            model is not a valid bladed disk.
    """
    mesh = table.lines()
    points = mesh.points * table.metres
    faults = [*_double_parts(mesh)]
    if faults:
        raise CaseError(table.fault("file", expected) for expected in faults)
    tips = table.tip_nodes(mesh)
    centre = table.group_nodes(mesh, "centre")
    hung = _hung(table, mesh)
    beams = mesh.beams()
    tip_radius = float(np.linalg.norm(points[tips], axis=1).max())
    if not TIP_RADII[0] <= tip_radius <= TIP_RADII[1]:
        low, high = TIP_RADII
        expected = f"a unit that puts the tips at {low:g} m to {high:g} m, not at {tip_radius:g} m"
        raise CaseError([table.fault("unit", expected)])
    sectors = None
    if len(centre) == 1 and np.linalg.norm(points[centre[0]]) <= AT_ORIGIN * tip_radius:
        points[centre[0]] = 0.0
        sectors = rotational_sectors(points, mesh.lines, tips, int(centre[0]))
    if sectors is not None:
        points = symmetric_points(points, sectors)
    axes = np.arctan2(points[:, 1], points[:, 0])
    axes[centre] = 0.0
    properties = _properties(table, beams, material)
    last = {name: beams.line_groups[name] for name in table.sections}
    model = BeamModel(
        mesh=LineMesh(
            points=points,
            lines=beams.lines,
            node_axes=axes,
            node_sets=_without(mesh.node_groups, table.tips, table.centre)
            | {"tips": tips, "centre": centre},
            # Where groups overlap, a line belongs to the group with its section.
            line_sets=_without(beams.line_groups, *last) | last,
            sectors=sectors,
        ),
        properties=properties,
        **hung,
        tip_radius=table.tip_radius or float(np.linalg.norm(points[tips], axis=1).max()),
    )
    check_model(model, KEY)
    return model


def _double_parts(mesh: GroupedLines) -> Iterator[str]:
    """Yield texts about duplicate nodes and lines, which complete "expected ..."."""
    size = float(np.ptp(mesh.points, axis=0).max())
    from scipy.spatial import KDTree  # not loaded where no mesh is read

    pairs = KDTree(mesh.points).query_pairs(SAME_PLACE * size, output_type="ndarray")
    joints = np.sort(mesh.lines[~mesh.is_beam], axis=1)
    pairs = np.array([pair for pair in pairs if not (joints == np.sort(pair)).all(axis=1).any()])
    if len(pairs):
        x, y = mesh.points[pairs[0, 0]].tolist()
        yield (
            f"at most one node at each place; {len(pairs)} pairs of nodes coincide, the first at"
            f" ({x:g}, {y:g}): merge them in the mesh generator"
        )
        return
    lines, times = np.unique(np.sort(mesh.lines[mesh.is_beam], axis=1), axis=0, return_counts=True)
    loops, twice = lines[lines[:, 0] == lines[:, 1]], lines[times > 1]
    for what, faulty in (("no lines of zero length", loops), ("each line only once", twice)):
        if len(faulty):
            x, y = mesh.points[faulty[0, 0]].tolist()
            yield f"{what}; {len(faulty)} violate this, the first at ({x:g}, {y:g})"


def _properties(table: MeshTable, mesh: GroupedLines, material: Material) -> LineProperties:
    count = len(mesh.lines)
    values = np.full((len(QUANTITIES), count), np.nan)
    changes = np.zeros_like(values)
    if table.metres == 1.0:  # with another unit of length, the unit of moduli would be unclear
        for row, name in zip(changes, CHANGES, strict=True):
            row[:] = np.nan_to_num(mesh.line_data.get(name, row))
        for row, name in zip(values, QUANTITIES, strict=True):
            line_values = mesh.line_data.get(name, row)
            row[:] = np.where(
                np.isfinite(line_values), line_values, getattr(material, name, np.nan)
            )
    given = Counter[int]()
    for name, section in table.sections.items():
        lines = mesh.line_groups[name]
        given.update(lines.tolist())
        changes[:, lines] = 0.0
        values[:, lines] = along(material.section(section), np.zeros(1))
    twice = [line for line, times in given.items() if times > 1]
    if twice:
        groups = [k for k in table.sections if twice[0] in mesh.line_groups[k]]
        both = " and ".join(map(repr, groups))
        expected = f"at most one section for each line; {both} have {len(twice)} lines in common"
        raise CaseError([table.fault("sections", expected)])
    thin = np.flatnonzero((np.abs(changes) >= 2.0 * values).any(axis=0) & (values > 0).all(axis=0))
    if len(thin):
        quantity = int(np.argmax(np.abs(changes[:, thin[0]]) / values[:, thin[0]]))
        name, change = CHANGES[quantity], changes[quantity, thin[0]]
        middle, noun = values[quantity, thin[0]], QUANTITIES[quantity]
        expected = (
            f"{name} smaller than twice {noun}, so that neither end vanishes; line {thin[0]} has"
            f" {noun} = {middle:g} and {name} = {change:g}"
        )
        raise CaseError([table.fault("file", expected)])
    bare = np.flatnonzero(~(np.isfinite(values) & (values > 0.0)).all(axis=0))
    if len(bare):
        groups = [k for k, lines in mesh.line_groups.items() if np.isin(bare, lines).any()]
        named = f", in {', '.join(map(repr, groups))}" if groups else ", in no group"
        expected = (
            f"a section for all lines; {len(bare)} of {len(mesh.lines)} have none{named} (sections"
            ' in the file itself are in SI units and are used only if unit is "m")'
        )
        raise CaseError([table.fault("sections", expected)])
    names = (*QUANTITIES, *CHANGES)
    return LineProperties(**dict(zip(names, np.vstack([values, changes]), strict=True)))


def _hung(table: MeshTable, mesh: GroupedLines) -> dict[str, Any]:
    """Return the masses, springs and links of a mesh, as keyword arguments of `BeamModel`."""
    try:
        masses, joints = point_masses(mesh), springs(mesh)
    except ValueError as error:
        raise CaseError([table.fault("file", str(error))]) from None
    for name, count in (("point masses", len(masses.node)), ("springs", len(joints.node))):
        if count and table.metres != 1.0:
            expected = (
                f'"m", because {table.file_name} contains {name}, which are always read in SI units'
            )
            raise CaseError([table.fault("unit", expected)])
    leader, led = mesh.lines[mesh.is_rigid].T
    return {"masses": masses, "springs": joints, "links": RigidLinks(led=led, leader=leader)}


def _without(groups: Mapping[str, IntArray], *names: str) -> dict[str, IntArray]:
    return {name: members for name, members in groups.items() if name not in names}
