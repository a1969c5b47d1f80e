"""Frequencies of the waves that the modes of a reduced rotor make up with Coriolis forces."""

from __future__ import annotations

import numpy as np

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray, IntArray
from bladewhirl.models.elements.cyclic import is_pair
from bladewhirl.models.rotation.at_speed import TurningDisk
from bladewhirl.models.rotation.eigenproblems import gyroscopic_eigen
from bladewhirl.models.rotation.waves import waves
from bladewhirl.models.stage.contact_problem import ReducedRotor

STANDS = 1e-6
"""Relative excess of one direction that is rounding in a standing motion."""


def wave_frequencies(rotor: ReducedRotor, nodal_diameter: IntArray, sense: float) -> FloatArray:
    """Frequencies of the backward and forward wave of each mode.

    The pairs of modes of one nodal diameter, ascending, go with its waves of each way by rank:
    branches do not cross. Without symmetry a pair goes with the two motions of which it holds
    most, if these turn against each other. What stands, as all does without Coriolis forces, has
    one frequency both ways.

    Args:
        rotor: its modes.
        nodal_diameter: of each mode, (modes,).
        sense: any number of the sign of the speed.

    Returns:
        in the rotating frame [rad/s], (2, modes): positive where the wave travels the way of its
        row; a forward wave past its critical speed is negative.
    """
    frequencies = np.stack([rotor.frequency, rotor.frequency])
    if rotor.by_velocity is None:
        return frequencies
    from scipy.optimize import linear_sum_assignment  # slow to import

    coriolis = (rotor.by_velocity - rotor.by_velocity.T) / 2.0
    signed = np.zeros_like(rotor.frequency)
    diameters = np.unique(nodal_diameter)
    members = [np.flatnonzero(nodal_diameter == k) for k in diameters]
    symmetric = bool(np.all(rotor.column >= 0))
    for block in members if symmetric else [np.arange(len(rotor.column))]:
        stiffness, gyroscopic = np.diag(rotor.stiffness[block]), coriolis[np.ix_(block, block)]
        found_w, fields = gyroscopic_eigen(np.eye(len(block)), stiffness, gyroscopic)
        w, vectors = found_w[: len(block)].real, fields[:, : len(block)]  # the others: conjugate
        mode, motion = linear_sum_assignment(np.abs(vectors) ** 2, maximize=True)
        mode = block[mode]
        way = _ways(rotor, nodal_diameter[mode], rotor.tip_radial[:, block] @ vectors[:, motion])
        signed[mode] = np.sign(sense) * way * w[motion]
        frequencies[:, mode] = w[motion]
    for modes in members:
        ascending = modes[np.argsort(rotor.frequency[modes], kind="stable")]
        ranked = [ascending] if symmetric else np.split(ascending, range(2, len(ascending), 2))
        for some in ranked:  # a complete nodal diameter; without symmetry, pairs if any
            both, half = np.sort(signed[some]), len(some) // 2
            if both.all() and (
                len({*rotor.column[some]}) == 2 if symmetric else both[0] < 0.0 < both[-1]
            ):
                frequencies[0, some] = np.repeat(both[half:], 2)
                frequencies[1, some] = np.repeat(-both[:half][::-1], 2)
    return frequencies


def wave_errors(
    rotor: ReducedRotor, nodal_diameter: IntArray, family: tuple[str, ...], turning: TurningDisk
) -> dict[str, float]:
    """Largest relative error of the frequencies of each family's waves, both ways.

    Args:
        rotor: the reduced bladed disk, of equal sectors.
        nodal_diameter: of each mode, (modes,).
        family: of each mode, (modes,).
        turning: the full bladed disk at speed, with Coriolis forces.
    """
    layout = turning.disk.structure.layout
    assert layout is not None  # it has equal sectors
    frequencies = wave_frequencies(rotor, nodal_diameter, turning.omega)
    errors = dict.fromkeys(family, 0.0)
    for k in np.unique(nodal_diameter):
        w = waves(turning.matrices, int(k), "full").frequencies(abs(turning.omega)).real
        half = len(w) // 2
        exact = np.stack([w[:half][::-1], -w[half:]])
        members = np.flatnonzero(nodal_diameter == k)
        ascending = members[np.argsort(rotor.frequency[members], kind="stable")]
        each = 2 if is_pair(int(k), layout.sectors) else 1
        for rank, modes in enumerate(np.split(ascending, range(each, len(members), each))):
            off = np.abs(frequencies[:, modes[0]] / exact[:, rank] - 1.0).max()
            errors[family[modes[0]]] = max(errors[family[modes[0]]], float(off))
    return errors


def _ways(rotor: ReducedRotor, nodal_diameter: IntArray, tips: ComplexArray) -> FloatArray:
    """Return 1 for motions p exp(i w t) against the numbering of the blades, -1 along it, 0 if
    standing.

    Args:
        rotor: with the places of the tips.
        nodal_diameter: of each motion, (motions,).
        tips: p at the tips, (tips, motions).
    """
    turn = np.exp(1j * np.outer(nodal_diameter, rotor.tip_angle))
    against = np.abs(np.einsum("mt,tm->m", turn.conj(), tips)) ** 2
    along = np.abs(np.einsum("mt,tm->m", turn, tips)) ** 2
    excess = (against - along) / np.maximum(against + along, np.finfo(np.float64).tiny)
    return np.asarray(np.where(np.abs(excess) > STANDS, np.sign(excess), 0.0))
