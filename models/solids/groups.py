"""Clamped nodes, contact nodes and faces of a sector among the groups of a mesh."""

import math
from collections.abc import Iterable, Mapping

import numpy as np
from scipy.spatial import cKDTree

from bladewhirl.meshes.coincident import COINCIDENT
from bladewhirl.meshes.files.volumes import VolumeMesh
from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.meshes.plane import rotate
from bladewhirl.models.inputs.errors import CaseError, Fault
from bladewhirl.models.solids.positions import EXAMPLE, nodes_where
from bladewhirl.models.solids.surface import evenly_along_chord
from bladewhirl.models.superelements.contacts import on_next_sector

AXES = {"x": (1, 2, 0), "y": (2, 0, 1), "z": (0, 1, 2)}
"""Coordinates of the mesh that become x, y and z, by the axis of rotation of the mesh."""


def invalid(key: str, value: object, expected: str) -> CaseError:
    """Return the error for an invalid argument."""
    return CaseError([Fault(key=key, value=value, expected=expected)])


MOST_LISTED = 20
"""Largest number of groups in a message."""


def listed(names: Iterable[str]) -> str:
    """Return names in alphabetical order for a message."""
    every = sorted(names)
    more = f" and {len(every) - MOST_LISTED} more" if len(every) > MOST_LISTED else ""
    return (", ".join(every[:MOST_LISTED]) or "there are none") + more


def chosen_nodes(
    groups: Mapping[str, IntArray], name: str, points: FloatArray, axis: str
) -> IntArray | None:
    """Return the nodes of a group, whose name need not match in upper and lower case, or those at
    which a condition holds, see `nodes_where`; None if there is no such group.

    Raises:
        ValueError: the condition is not valid.
    """
    alike = [one for one in groups if one.upper() == name.upper()]
    if name in groups or len(alike) == 1:
        return groups[name if name in groups else alike[0]]
    return nodes_where(name, points, axis)


def group_nodes(mesh: VolumeMesh, key: str, name: str, axis: str) -> IntArray:
    """Return the nodes of a group or at which a condition holds, see `chosen_nodes`.

    Args:
        mesh: mesh with the axis of rotation z.
        key: argument that names the group.
        name: name of the group, or condition.
        axis: axis of rotation in the source of the mesh.

    Raises:
        CaseError: no group has the name, or the group is empty; the error names ``key``.
    """
    in_file = mesh.points[:, np.argsort(AXES[axis])]
    try:
        nodes = chosen_nodes(mesh.groups, name, in_file, axis)
    except ValueError as error:
        raise invalid(key, name, f"{EXAMPLE} ({error})") from None
    if nodes is None:
        expected = f"a group of nodes of {mesh.name}: {listed(mesh.groups)}; or {EXAMPLE}"
        raise invalid(key, name, expected)
    if not len(nodes):
        raise invalid(key, name, "a group with nodes; this group has none")
    return nodes


def cells_of(mesh: VolumeMesh, key: str, name: str) -> IntArray:
    """Return the cells of a group; its name need not match in upper and lower case.

    Raises:
        CaseError: no group of cells has the name; the error names ``key``.
    """
    if name in mesh.cell_groups:
        return mesh.cell_groups[name]
    for group, cells in mesh.cell_groups.items():
        if group.upper() == name.upper():
            return cells
    raise invalid(key, name, f"a group of cells of {mesh.name}: {listed(mesh.cell_groups)}")


def contact_nodes(
    points: FloatArray,
    nodes: IntArray,
    count: int | None,
    clamped: IntArray,
    sector: tuple[str, str, int] | None = None,
) -> IntArray:
    """Return the contact nodes: all given nodes, or some that are evenly spaced on their chord.

    Nodes of a sector that are also nodes of the next sector are left out.

    Args:
        points: positions of all nodes [m], (n, 3).
        nodes: nodes of the group.
        count: number of contact nodes; None for all.
        clamped: nodes that do not move.
        sector: faces and number of sectors, see `sector_faces`; None for a blade.

    Raises:
        CaseError: there are too few nodes, or some are clamped.
    """
    both = np.intersect1d(nodes, clamped)
    if len(both):
        where = ", ".join(f"{value:.6g}" for value in points[both[0]])
        raise invalid(
            *("contact", None),
            f"nodes that are not clamped; {len(both)} of {len(nodes)} are, such as that at "
            f"({where}) m",
        )
    twice = np.zeros(len(nodes), dtype=np.bool_)
    if sector is not None:
        twice = on_next_sector(points[nodes], sector[2])
    single = nodes[~twice]
    if count is None:
        return single
    if isinstance(count, bool) or not isinstance(count, int) or not 1 <= count <= len(single):
        raise invalid("contacts", count, f"a whole number from 1 to {len(single)}, all nodes")
    if len(single) < len(nodes):  # the chord goes on in the next sector
        chosen = evenly_along_chord(points, nodes, count + 1)
        chosen = chosen[np.isin(chosen, single)]
        if len(chosen) == count:
            return chosen
    return evenly_along_chord(points, single, count)


def sector_faces(
    left: str | None, right: str | None, copies: int | None
) -> tuple[str, str, int] | None:
    """Return the names of the faces of a sector and the number of sectors; None for a blade.

    Raises:
        CaseError: one or two of the arguments are missing, or copies is not a number of sectors.
    """
    given = {"left": left, "right": right, "copies": copies}
    if left is None or right is None or copies is None:
        absent = [key for key, value in given.items() if value is None]
        if len(absent) < len(given):
            raise invalid(absent[0], None, "left, right and copies together, or none of them")
        return None
    if isinstance(copies, bool) or not isinstance(copies, int) or copies < 2:
        raise invalid("copies", copies, "a whole number of sectors, 2 or more")
    return left, right, copies


def matching_faces(
    points: FloatArray, left: IntArray, right: IntArray, copies: int
) -> tuple[IntArray, IntArray]:
    """Return the nodes of the two faces of a sector in the same order.

    Args:
        points: positions of all nodes [m], (n, 3).
        left: nodes of the clockwise face.
        right: nodes of the counter-clockwise face.
        copies: number of sectors of the wheel.

    Raises:
        CaseError: the left face turned counter-clockwise by one pitch is not the right face.
    """
    angle = 2.0 * math.pi / copies
    size = float(np.ptp(points, axis=0).max())
    tree = cKDTree(points[right])
    distance, order = tree.query(rotate(points[left], angle))
    if len(left) == len(right) and distance.max() > COINCIDENT * size:
        backward = tree.query(rotate(points[left], -angle))[0].max() <= COINCIDENT * size
        reason = (
            "left and right are interchanged"
            if backward
            else f"nodes are up to {distance.max():.3g} m away; are there {copies} copies?"
        )
        raise invalid(
            *("right", None),
            "the nodes of the left face turned counter-clockwise about the axis by "
            f"1/{copies} of a turn; {reason}",
        )
    if len(left) != len(right) or len(np.unique(order)) < len(order):
        numbers = f"{len(left)} on the left and {len(right)} on the right"
        raise invalid("right", None, f"one node for each node of the left face; {numbers}")
    return left, right[order]


def clamped_on_both(left: IntArray, right: IntArray, clamped: IntArray) -> tuple[IntArray, str]:
    """Return the clamped nodes and their partners on the other face of a sector, and a note of the
    number of those that are added, for `source`.

    A deck with cyclic ties clamps nodes of one face only, on which those of the other depend.

    Args:
        left: nodes of the clockwise face.
        right: their partners on the counter-clockwise face.
        clamped: nodes that do not move.
    """
    held = np.isin(left, clamped) | np.isin(right, clamped)
    both = np.union1d(clamped, np.concatenate([left[held], right[held]]))
    added = len(both) - len(np.unique(clamped))
    return both, f", {added} nodes clamped like their partners on the other face" if added else ""


def free_faces(left: IntArray, right: IntArray, clamped: IntArray) -> dict[str, IntArray]:
    """Return the nodes of both faces that are not clamped, by the key of their degrees of freedom
    in a superelement."""
    free = ~np.isin(left, clamped)
    return {"left_dofs": left[free], "right_dofs": right[free]}
