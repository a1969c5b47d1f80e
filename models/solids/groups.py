"""Clamped nodes, contact nodes and faces of a sector among the groups of a mesh."""

import math

import numpy as np
from scipy.spatial import cKDTree

from bladewhirl.meshes.files.volumes import VolumeMesh
from bladewhirl.meshes.line_mesh import IntArray
from bladewhirl.models.inputs.errors import CaseError, Fault
from bladewhirl.models.solids.surface import evenly_along_chord

MATCHING = 1e-5
"""Largest distance of matching nodes on the two faces of a sector, as a share of its size."""


def invalid(key: str, value: object, expected: str) -> CaseError:
    """Return the error for an invalid argument."""
    return CaseError([Fault(key=key, value=value, expected=expected)])


def group_nodes(mesh: VolumeMesh, key: str, name: str) -> IntArray:
    """Return the nodes of a group; its name need not match in upper and lower case.

    Raises:
        CaseError: no group has the name, or the group is empty; the error names ``key``.
    """
    alike = [one for one in mesh.groups if one.upper() == name.upper()]
    chosen = name if name in mesh.groups else alike[0] if len(alike) == 1 else None
    if chosen is None:
        listed = ", ".join(sorted(mesh.groups)) or "there are none"
        raise invalid(key, name, f"a group of nodes of {mesh.name}: {listed}")
    if not len(mesh.groups[chosen]):
        raise invalid(key, name, "a group with nodes; this group has none")
    return mesh.groups[chosen]


def contact_nodes(mesh: VolumeMesh, name: str, count: int | None, clamped: IntArray) -> IntArray:
    """Return the contact nodes: all nodes of a group, or some that are evenly spaced on its chord.

    Raises:
        CaseError: the group is missing, is too small, or has clamped nodes.
    """
    nodes = group_nodes(mesh, "contact", name)
    both = np.intersect1d(nodes, clamped)
    if len(both):
        where = ", ".join(f"{value:.6g}" for value in mesh.points[both[0]])
        raise invalid(
            *("contact", name),
            f"nodes that are not clamped; {len(both)} of {len(nodes)} are, such as that at "
            f"({where}) m",
        )
    if count is None:
        return nodes
    if isinstance(count, bool) or not isinstance(count, int) or not 1 <= count <= len(nodes):
        raise invalid("contacts", count, f"a whole number from 1 to {len(nodes)}, all of {name!r}")
    return evenly_along_chord(mesh.points, nodes, count)


def matching_faces(
    mesh: VolumeMesh, left: str, right: str, copies: int, clamped: IntArray
) -> dict[str, IntArray]:
    """Return the nodes of the two faces of a sector in the same order, without clamped nodes.

    Raises:
        CaseError: a group is missing, the left face turned counter-clockwise by one pitch is not
            the right face, or a node is clamped on one of them only.
    """
    faces = group_nodes(mesh, "left", left), group_nodes(mesh, "right", right)
    angle = 2.0 * math.pi / copies
    c, s = math.cos(angle), math.sin(angle)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    size = float(np.ptp(mesh.points, axis=0).max())
    tree = cKDTree(mesh.points[faces[1]])
    distance, order = tree.query(mesh.points[faces[0]] @ turn.T)
    if len(faces[0]) == len(faces[1]) and distance.max() > MATCHING * size:
        backward = tree.query(mesh.points[faces[0]] @ turn)[0].max() <= MATCHING * size
        reason = (
            "left and right are interchanged"
            if backward
            else f"nodes are up to {distance.max():.3g} m away; are there {copies} copies?"
        )
        raise invalid(
            *("right", right),
            f"the nodes of {left!r} turned counter-clockwise about the axis by 1/{copies} of a "
            f"turn; {reason}",
        )
    if len(faces[0]) != len(faces[1]) or len(np.unique(order)) < len(order):
        numbers = f"{len(faces[0])} on the left and {len(faces[1])} on the right"
        raise invalid("right", right, f"one node for each node of {left!r}; there are {numbers}")
    first, second = faces[0], faces[1][order]
    fixed = np.isin(first, clamped)
    if np.any(fixed != np.isin(second, clamped)):
        raise invalid("clamped", None, "the same clamped nodes on both faces of the sector")
    return {"left_dofs": first[~fixed], "right_dofs": second[~fixed]}
