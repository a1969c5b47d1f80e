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
    blade: IntArray  #: blade of each pair, which it joins to the next one, (pairs,)
    ends: IntArray
    """Contact nodes of each pair: the left node of the next blade and the right node of a blade; or
    one of them and -1 for a damper, (pairs, 2)."""
    axes: FloatArray
    """Values of each pair for unit displacements of both nodes in the axes of the wall, or of a
    damper in radial, tangential and axial direction, (pairs, 2, 3, 3)."""
    friction: FloatArray  #: friction coefficient of each pair, (pairs,)
    gap: FloatArray  #: gap without displacements, negative if surfaces overlap [m], (pairs,)
    compliance: FloatArray  #: values for unit forces within a step [m/N], (3 pairs, 3 pairs)
    by_load: FloatArray
    """Values by the load patterns and the modes that are left out [m], (patterns, 3 pairs)."""
    start: FloatArray  #: values at the start without loads [m], (3 pairs,)
    start_force: FloatArray  #: forces at the start [N], (3 pairs,)
    damper: IntArray  #: damper of each pair, -1 for none, (pairs,)
    mobility: FloatArray
    """Inverse of the mass of each damper in radial, tangential and axial direction, 0 if it is held
    [1/kg], (dampers, 3)."""
    pull: FloatArray  #: centrifugal force on each damper [N], (dampers, 3)
    damper_start: FloatArray  #: displacement of each damper at the start [m], (dampers, 3)

    @property
    def damper_rows(self) -> FloatArray:
        """Matrix from the displacements of all dampers to the values of all pairs, (3 pairs,
        3 dampers)."""
        return damper_rows(self.damper, self.axes)

    def rows(self, nodes: int) -> sp.csr_array:
        """Return the matrix from the displacements of a number of nodes to the values of all pairs,
        (3 pairs, 3 nodes)."""
        return rows_of(self.ends, self.axes, nodes)


def damper_rows(damper: IntArray, axes: FloatArray) -> FloatArray:
    """Return `JointContacts.damper_rows` of pairs with given dampers and axes."""
    rows = np.zeros((3 * len(damper), 3 * (int(damper.max(initial=-1)) + 1)))
    for pair in np.flatnonzero(damper >= 0):
        own = 3 * damper[pair]
        rows[3 * pair : 3 * pair + 3, own : own + 3] = axes[pair, 1]
    return rows


def rows_of(ends: IntArray, axes: FloatArray, nodes: int) -> sp.csr_array:
    """Return `JointContacts.rows` of pairs with given ends and axes."""
    pairs, way = len(ends), np.arange(3)
    row = (3 * np.arange(pairs)[:, None] + way)[:, None, :, None]
    column = (3 * ends[..., None] + way)[:, :, None, :]
    known = np.broadcast_to((ends >= 0)[:, :, None, None], axes.shape)
    places = [np.broadcast_to(each, axes.shape)[known] for each in (row, column)]
    return sp.csr_array((axes[known], places), shape=(3 * pairs, 3 * nodes))
