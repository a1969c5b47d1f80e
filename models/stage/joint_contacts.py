"""Friction joints between the blades of a contact problem."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from bladewhirl.meshes.line_mesh import FloatArray, IntArray


@dataclass(frozen=True, kw_only=True)
class JointContacts:
    """Pairs of contact nodes of neighbouring blades, blade by blade. Values of a pair are those
    along its normal and its two tangents, see `models.joints.wheel`."""

    joint: IntArray  #: number of the joint of each pair, (pairs,)
    ends: IntArray
    """Contact nodes of each pair: the left node of the next blade and the right node of a blade,
    (pairs, 2)."""
    axes: FloatArray
    """Values of each pair for unit displacements of both nodes in the axes of the wall, (pairs, 2,
    3, 3)."""
    friction: FloatArray  #: friction coefficient of each pair, (pairs,)
    gap: FloatArray  #: gap without displacements, negative if surfaces overlap [m], (pairs,)
    compliance: FloatArray  #: values for unit forces within a step [m/N], (3 pairs, 3 pairs)
    by_load: FloatArray
    """Values by the load patterns and the modes that are left out [m], (patterns, 3 pairs)."""
    start: FloatArray  #: values at the start without loads [m], (3 pairs,)
    start_force: FloatArray  #: forces at the start [N], (3 pairs,)

    def rows(self, nodes: int) -> sp.csr_array:
        """Return the matrix from the displacements of a number of nodes to the values of all pairs,
        (3 pairs, 3 nodes)."""
        return rows_of(self.ends, self.axes, nodes)


def rows_of(ends: IntArray, axes: FloatArray, nodes: int) -> sp.csr_array:
    """Return `JointContacts.rows` of pairs with given ends and axes."""
    pairs, way = len(ends), np.arange(3)
    row = (3 * np.arange(pairs)[:, None] + way)[:, None, :, None]
    column = (3 * ends[..., None] + way)[:, :, None, :]
    places = np.broadcast_to(row, axes.shape).ravel(), np.broadcast_to(column, axes.shape).ravel()
    return sp.csr_array((axes.ravel(), places), shape=(3 * pairs, 3 * nodes))
