"""Nodes that move as a rigid body, such as those of ``*COUPLING`` and ``*RIGID BODY`` of a deck."""

from collections.abc import Mapping

import numpy as np
import scipy.sparse as sp
from scipy.linalg import orth

from bladewhirl.meshes.files.volumes import VolumeMesh
from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.solids.groups import invalid
from bladewhirl.models.superelements.hub import tied_rows
from bladewhirl.models.superelements.superelement import FIXED


def free_bodies(
    mesh: VolumeMesh, clamped: IntArray, apart: Mapping[str, IntArray]
) -> list[IntArray]:
    """Return the nodes of each rigid body that is not clamped.

    Args:
        mesh: mesh of a solid.
        clamped: nodes that do not move.
        apart: nodes that have to move by themselves, by the argument that names them.

    Raises:
        CaseError: a body is clamped in part, two bodies share a node, or nodes that have to move by
            themselves belong to a body.
    """
    bodies: list[IntArray] = []
    for keyword, nodes in mesh.rigid:
        held = np.isin(nodes, clamped)
        if held.all():
            continue
        if held.any():
            expected = f"all nodes of {keyword} or none of them; {held.sum()} of {len(nodes)} are"
            raise invalid("clamped", None, expected)
        for key, others in apart.items():
            if within := np.isin(others, nodes).sum():
                expected = f"nodes outside of {keyword}; {within} of {len(others)} belong to it"
                raise invalid(key, None, expected)
        if any(np.isin(nodes, body).any() for body in bodies):
            raise invalid("mesh", mesh.name, f"nodes that belong to one rigid body, see {keyword}")
        bodies.append(nodes)
    return bodies


def free_displacements(
    size: int,
    points: FloatArray,
    clamped: IntArray,
    bodies: list[IntArray],
    hub: FloatArray | None = None,
) -> tuple[IntArray, sp.csr_array]:
    """Return the coordinate of each displacement, (size, 3), `FIXED` for those that are not
    coordinates, and the matrix from the coordinates to all displacements, (3 * size, coordinates).

    The free displacements are the first coordinates, in the order of the nodes. Those of the rigid
    bodies follow, at most six each: factors of orthonormal displacements of their nodes [m]; at the
    end the six of the hub.

    Args:
        size: number of nodes and of internal functions of elements.
        points: positions of the nodes [m], (nodes, 3).
        clamped: nodes that do not move, or are tied to the hub.
        bodies: nodes of each rigid body.
        hub: position of the hub [m], (3,); None without a hub.
    """
    free = np.ones((size, 3), dtype=np.bool_)
    free[np.concatenate([clamped, *bodies])] = False
    dofs = np.where(free, np.cumsum(free).reshape(-1, 3) - 1, FIXED)
    columns = [sp.eye_array(dofs.size, format="csr")[:, np.flatnonzero(free.ravel())]]
    for nodes in bodies:
        arm = points[nodes] - points[nodes].mean(axis=0)
        turns = np.cross(np.eye(3)[:, None], arm / (np.ptp(arm) or 1.0)).reshape(3, -1)
        shifts = np.tile(np.eye(3), len(nodes))
        basis = orth(np.concatenate([shifts, turns]).T, rcond=1e-9)
        rows = np.repeat(_displacements(nodes), basis.shape[1])
        places = np.tile(np.arange(basis.shape[1]), len(basis))
        shape = (dofs.size, basis.shape[1])
        columns.append(sp.csr_array((basis.ravel(), (rows, places)), shape=shape))
    if hub is not None:
        rows = sp.csr_array(tied_rows(points[clamped] - hub))
        columns.append(sp.eye_array(dofs.size, format="csr")[:, _displacements(clamped)] @ rows)
    return dofs, sp.csr_array(sp.hstack(columns, format="csr"))


def _displacements(nodes: IntArray) -> IntArray:
    """Return the numbers of the displacements of nodes, (3n,)."""
    return np.asarray((3 * nodes[:, None] + np.arange(3)).ravel())
