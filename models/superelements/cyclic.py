"""Cyclic symmetry: a wheel from the matrices of one of its sectors.

Sectors are numbered counter-clockwise. In a motion with nodal diameter k each sector moves as the
one before it, turned by one pitch alpha = 2 pi / sectors and multiplied by a phase:
u_{n+1} = exp(i k alpha) R u_n, with the rotation R by alpha about z. The counter-clockwise (right)
face of a sector is the clockwise (left) face of the next one, so u_right = exp(i k alpha) R u_left.
"""

import cmath
import math

import numpy as np
import scipy.sparse as sp

from bladewhirl.models.superelements.superelement import FIXED, Superelement, SuperelementError


def transformation(part: Superelement, sectors: int, k: int) -> sp.csr_array:
    """Return the tie T of a wheel that moves with nodal diameter k, (n, m): the matrix from the m
    coordinates that are not on the right face to those of the sector, u_right = exp(i k alpha) R
    u_left. The motion of sector n is the real part of exp(i k n alpha) R^n T q.

    Args:
        part: sector with left_dofs and right_dofs.
        sectors: number of sectors of the wheel, at least 1.
        k: nodal diameter. With a positive k the motion of sector n + 1 leads that of sector n, so
            with exp(i omega t) the wave travels clockwise.

    Raises:
        SuperelementError: the superelement is not a sector, or different components of the nodes
            are fixed on both faces.
    """
    if part.left_dofs is None or part.right_dofs is None:
        raise SuperelementError(
            f"{part.name}: expected a sector, with left_dofs and right_dofs of its two faces"
        )
    left, right = part.left_dofs, part.right_dofs
    shared = np.intersect1d(left[left != FIXED], right[right != FIXED])
    if len(shared):
        raise SuperelementError(
            f"{part.name}: expected different nodes on both faces; {len(shared)} degrees of"
            " freedom are on both, perhaps of nodes on the axis"
        )
    in_plane = np.sort(left[:, :2] == FIXED, axis=1)
    unequal = (left == FIXED) != (right == FIXED)
    if unequal.any() or (in_plane[:, 0] != in_plane[:, 1]).any():
        row = int(np.flatnonzero(unequal.any(axis=1) | (in_plane[:, 0] != in_plane[:, 1]))[0])
        raise SuperelementError(
            f"{part.name}: expected the same fixed components on both faces, x and y together;"
            f" row {row} has {left[row].tolist()} on the left and {right[row].tolist()} on the"
            " right"
        )
    dependent = right[right != FIXED]
    kept = np.setdiff1d(np.arange(part.size), dependent)
    place = np.full(part.size, FIXED)
    place[kept] = np.arange(len(kept))
    half_turns = 2 * k / sectors
    real = 2 * k % sectors == 0
    phase = math.cos(math.pi * round(half_turns)) if real else cmath.exp(1j * math.pi * half_turns)
    c, s = math.cos(2.0 * math.pi / sectors), math.sin(2.0 * math.pi / sectors)
    rows, columns, values = [kept], [np.arange(len(kept))], [np.ones(len(kept))]
    for to, source, factor in ((0, 0, c), (0, 1, -s), (1, 0, s), (1, 1, c), (2, 2, 1.0)):
        free = right[:, to] != FIXED
        rows.append(right[free, to])
        columns.append(place[left[free, source]])
        values.append(np.full(np.count_nonzero(free), phase * factor))
    entries = np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))
    return sp.csr_array(entries, shape=(part.size, len(kept)))
