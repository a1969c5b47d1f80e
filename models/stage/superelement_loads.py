"""Forces of engine orders on a superelement, and its initial motion."""

from typing import Literal

import numpy as np
import scipy.sparse as sp

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray, IntArray
from bladewhirl.meshes.plane import rotate
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.excitation import EngineOrder
from bladewhirl.models.case.file import case_fault
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.superelements.reduction import ReducedSuperelement

RANK, SAME = 1e-10, 1e-6
"""Flexibilities below the first fraction of the largest count as zero; the initial motion may have
errors up to the second fraction."""


def centre_rows(reduced: ReducedSuperelement, turned: float) -> FloatArray:
    """Return x and y of the centre of a superelement that is turned about the axis by an angle
    [rad], for unit modal coordinates [kg^-1/2], (2, modes)."""
    return rotate(np.eye(2), -turned) @ reduced.centre


def blade_angles(angle: FloatArray, blade: IntArray) -> FloatArray:
    """Return the mean angle of the contact nodes of each blade [rad], (copies, blades of a copy).

    Args:
        angle: angle of each contact node at t = 0 [rad], (copies, nodes).
        blade: blade of each contact node of a copy, (nodes,).
    """
    return np.asarray(np.angle(np.exp(1j * angle) @ blade_means(blade).T))


def mean_along(
    load: EngineOrder, blade: IntArray, angle: FloatArray, number: IntArray, count: int
) -> sp.csr_array:
    """Return the mean displacement of the places of each blade of a copy along the direction of a
    load, as rows on the displacements of nodes or points, (blades, 3 * count).

    Args:
        load: the excitation.
        blade: blade of each place, (places,).
        angle: angle of the radial direction of each place in the axes of the displacements [rad],
            (places,).
        number: number of the node or the point at each place, (places,).
        count: number of nodes or points.
    """
    direction = [np.cos(load.inclination), np.sin(load.inclination), 0.0]
    shares = rotate(direction, angle) / np.bincount(blade)[blade][:, None]
    places = np.repeat(blade, 3), (3 * number[:, None] + np.arange(3)).ravel()
    return sp.csr_array((shares.ravel(), places), shape=(int(blade.max()) + 1, 3 * count))


def engine_order_forces(
    acting: FloatArray, middle: FloatArray, load: EngineOrder
) -> list[tuple[int, ComplexArray]]:
    """Return for each engine order r the complex forces for the time factor exp(i r Omega t) on
    the modes [kg^1/2 m/s2], (copies * modes,).

    The force on blade n is F cos(r (Omega t + theta_n) + phase), with equal parts on its places;
    theta_n is the angle of the blade.

    Args:
        acting: `mean_along` for unit modal coordinates [kg^-1/2], (blades of a copy, modes). For
            unit forces on the contact nodes in their place [m/N], (blades of a copy, 3c), the
            result has the displacements of these nodes [m].
        middle: angle of each blade at t = 0 [rad], (copies, blades of a copy).
        load: the excitation.
    """
    factors = np.broadcast_to(np.asarray(load.factors or 1.0), middle.size).reshape(middle.shape)
    phases = np.broadcast_to(np.asarray(load.phase), middle.size).reshape(middle.shape)
    forces = (
        (order, load.amplitude * factors * np.exp(1j * (order * middle + phases)))
        for order in load.order
    )
    return [(order, (force @ acting).ravel()) for order, force in forces]


def blade_means(blade: IntArray) -> FloatArray:
    """Return the matrix from values at the contact nodes to their means on each blade of a copy,
    (blades, nodes)."""
    member = (blade == np.arange(int(blade.max()) + 1)[:, None]).astype(float)
    return np.asarray(member / member.sum(axis=1, keepdims=True))


def static_shapes(
    case: Case,
    key: Literal["displacement", "velocity"],
    reduced: ReducedSuperelement,
    blade: IntArray,
    copies: int,
) -> FloatArray:
    """Return the modal coordinates of least strain energy for the initial motion of the tips and of
    the centre, (copies * modes,). The motion of a tip is the mean of the contact nodes of a blade.

    Args:
        case: case whose table `initial` gives the motion.
        key: quantity of the motion that is used.
        reduced: the reduced superelement.
        blade: blade of each contact node of a copy, (nodes,).
        copies: number of copies.

    Raises:
        CaseError: the modes cannot move in this way, or one of them is rigid.
    """
    tips, centre = getattr(case.initial, f"tip_{key}"), getattr(case.initial, f"centre_{key}")
    if tips is None and not any(centre):
        return np.zeros(copies * len(reduced.frequency))
    name = f"initial.{'centre' if tips is None else 'tip'}_{key}"
    if reduced.frequency.min() <= RANK * reduced.frequency.max():
        expected = "not allowed for a superelement with rigid modes; remove this key"
        raise CaseError([case_fault(case, name, expected)])
    member = blade_means(blade)
    rows = np.stack([member @ reduced.contact[0::3], member @ reduced.contact[1::3]], axis=1)
    rows = rows.reshape(-1, rows.shape[-1])
    values = np.zeros((copies, len(rows)))
    if tips is not None:
        values = np.reshape(tips, values.shape)
    if reduced.centre.any():
        table = case.bladed_disk.superelement
        assert table is not None
        rows = np.vstack([rows, centre_rows(reduced, table.angle)])
        values = np.column_stack([values, np.tile(centre, (copies, 1))])
    flexible = rows / reduced.squares
    forces = np.linalg.lstsq(flexible @ rows.T, values.T, rcond=RANK)[0]
    moved = np.asarray(forces.T @ flexible)
    if np.abs(moved @ rows.T - values).max() > SAME * np.abs(values).max():
        expected = (
            'a motion that the modes can have; use more modes, or reduction.boundary = "consistent"'
        )
        raise CaseError([case_fault(case, name, expected)])
    return moved.ravel()
