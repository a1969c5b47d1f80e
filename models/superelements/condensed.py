"""A small superelement that stands for a large one over a range of speeds."""

from dataclasses import replace

import numpy as np
import scipy.linalg as la

from bladewhirl.models.superelements.joined import joined
from bladewhirl.models.superelements.reduction import modes_and_static
from bladewhirl.models.superelements.stresses import load_columns
from bladewhirl.models.superelements.superelement import FIXED, Superelement

FURTHER_MODES = 10  #: number of modes at each of three speeds, besides those of the reduction


def condensed(part: Superelement, highest: float, modes: int) -> Superelement:
    """Return a superelement whose motions are the lowest modes and the static displacements by
    forces on contact nodes and centre and by the loads of the rotation, at rest, at half and at all
    of the highest speed.

    Its first coordinates are the displacements of contact nodes and centre. It has dense matrices
    and is reduced at a speed in between in milliseconds, with almost the frequencies and the
    flexibilities of the large one.

    Args:
        part: superelement with stiffness_speed, not a sector.
        highest: highest speed [rad/s].
        modes: number of modes of a reduction.

    Raises:
        SuperelementError: a matrix is indefinite at one of the speeds.
    """
    ends = part.contact_dofs.ravel()
    if part.centre_dofs is not None:
        ends = np.append(ends, part.centre_dofs)
    ends = np.unique(ends[ends != FIXED])
    loads = np.zeros((part.size, len(ends)))
    loads[ends, np.arange(len(ends))] = 1.0
    loads = load_columns(part, loads)
    fields = []
    for state in (part, part.at(0.5 * highest), part.at(highest)):
        _, shapes, moved = modes_and_static(state, min(modes + FURTHER_MODES, part.size - 1), loads)
        fields += [shapes, moved]
    basis = joined(part, fields)
    at_ends = basis[ends]
    turn = np.hstack([la.pinv(at_ends), la.null_space(at_ends)])
    basis = basis @ turn
    place = np.full(part.size + 1, FIXED)  # the last entry is that of a fixed component
    place[ends] = np.arange(len(ends))
    changes = {"contact_dofs": place[part.contact_dofs], **part.projected(basis)}
    if part.centre_dofs is not None:
        changes["centre_dofs"] = place[part.centre_dofs]
    return replace(part, **changes)
