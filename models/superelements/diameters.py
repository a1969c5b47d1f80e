"""Modes of a wheel in single nodal diameters.

Equal blades allow modes that have one nodal diameter each. The eigenvalues of different diameters
can lie so near to one another that the rounding of the matrices mixes their modes: by t, if these
move the eigenvalues by t times their distance. The contact nodes show t, and the modes are turned
back by it. Modes of the same frequency, as those of blades on a rigid disk, are any combinations,
and turned first.
"""

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.structure.dft import nodal_diameter_of, real_dft

SAME = 1e-9  #: angles that differ by less are the same [rad]

NEAR = 1e-2  #: relative distance of squared frequencies up to which modes are turned

ROUNDING = 1e-10
"""Change of a squared frequency, as a fraction of it, that rounding of the matrices can explain."""

PURE = 0.99  #: share of one nodal diameter from which a mode is mixed with others by rounding only

FEWEST_BLADES = 3


def blade_numbers(angle: FloatArray) -> list[int]:
    """Return the numbers of blades whose contact nodes can have these angles, largest first.

    The nodes of each blade are those of the first one, turned by its distance.

    Args:
        angle: angle of each contact node, those of a blade one after another [rad], (nodes,).
    """
    nodes, found = len(angle), []
    for blades in range(nodes, FEWEST_BLADES - 1, -1):
        if nodes % blades == 0:
            apart = angle.reshape(blades, -1) - angle[: nodes // blades]
            apart -= 2.0 * np.pi / blades * np.arange(blades)[:, None]
            if np.abs(np.exp(1j * apart) - 1.0).max() < SAME:
                found.append(blades)
    return found


def by_diameter(contact: FloatArray, blades: int) -> tuple[FloatArray, IntArray, IntArray]:
    """Return the displacements of contact nodes in modes by DFT column over the blades, (blades,
    3c / blades, modes); the nodal diameter of each column, (blades,); and of each mode the one in
    which it moves most, (modes,).

    Args:
        contact: displacements of the contact nodes, (3c, modes).
        blades: number of blades.
    """
    moved = contact.reshape(blades, -1, contact.shape[1])
    parts = np.einsum("bc,bim->cim", real_dft(blades), moved)
    of_column = np.array([nodal_diameter_of(column) for column in range(blades)])
    power = np.zeros((blades // 2 + 1, contact.shape[1]))
    np.add.at(power, of_column, (parts**2).sum(axis=1))
    return parts, of_column, power.argmax(axis=0)


def turned_to_diameters(
    squares: FloatArray, shapes: FloatArray, contact: FloatArray, angle: FloatArray
) -> FloatArray:
    """Return modes, those of nearly equal frequency turned to single nodal diameters as far as
    rounding explains their mixture, (n, modes); the given ones without equal blades.

    Args:
        squares: squared frequencies [rad2/s2], (modes,).
        shapes: mass-normalised modes, (n, modes).
        contact: displacements of the contact nodes in the modes, (3c, modes).
        angle: angle of each contact node [rad], (c,).
    """
    for blades in blade_numbers(angle)[:1]:
        turn = _of_equal_frequency(squares, contact, blades)
        if turn is not None:
            shapes, contact = shapes @ turn, contact @ turn
        parts, of_column, diameter = by_diameter(contact, blades)
        distance = np.abs(squares[:, None] - squares)
        scale = np.maximum(np.abs(squares[:, None]), np.abs(squares))
        near, mixed = distance <= NEAR * scale, np.zeros(distance.shape)
        for k in np.unique(diameter):
            field = parts[of_column == k].reshape(-1, len(squares))
            for i in np.flatnonzero(diameter != k):
                own = np.flatnonzero(near[i] & (diameter == k))
                mixed[own, i] = np.linalg.lstsq(field[:, own], field[:, i])[0]
        mixed[np.abs(mixed) * distance > ROUNDING * scale] = 0.0
        return np.asarray(shapes - shapes @ mixed)
    return shapes


def _of_equal_frequency(squares: FloatArray, contact: FloatArray, blades: int) -> FloatArray | None:
    """Return the orthogonal matrix that turns modes of the same frequency which have several nodal
    diameters each to single ones, (modes, modes); None if there are none."""
    parts, of_column, diameter = by_diameter(contact, blades)
    power = (parts**2).sum(axis=1)
    own = np.where(of_column[:, None] == diameter, power, 0.0).sum(axis=0)
    mixed = own < PURE * power.sum(axis=0)
    if not mixed.any():
        return None
    order = np.argsort(squares)
    gaps = np.diff(squares[order]) > ROUNDING * np.abs(squares[order][1:])
    turn = np.eye(len(squares))
    for group in np.split(order, np.flatnonzero(gaps) + 1):
        if mixed[group].any():
            field = parts[:, :, group]
            weighed = of_column[:, None, None] * field
            flat, goal = (each.reshape(-1, len(group)) for each in (field, weighed))
            number = np.linalg.lstsq(flat, goal)[0]  # the nodal diameters, on the modes
            turn[np.ix_(group, group)] = np.linalg.eigh(0.5 * (number + number.T))[1]
    return turn
