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
"""Share by which one way may exceed the other in a motion that stands but for rounding."""


def wave_frequencies(rotor: ReducedRotor, nodal_diameter: IntArray, sense: float) -> FloatArray:
    """Frequencies of the backward and of the forward wave that each mode goes with.

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
    found = np.stack([rotor.frequency, rotor.frequency])
    if rotor.by_velocity is None:
        return found
    from scipy.optimize import linear_sum_assignment  # takes long to load

    coriolis = (rotor.by_velocity - rotor.by_velocity.T) / 2.0
    signed = np.zeros_like(rotor.frequency)
    diameters = np.unique(nodal_diameter)
    own = [np.flatnonzero(nodal_diameter == k) for k in diameters]
    symmetric = bool(np.all(rotor.column >= 0))
    for block in own if symmetric else [np.arange(len(rotor.column))]:
        stiffness, gyroscopic = np.diag(rotor.stiffness[block]), coriolis[np.ix_(block, block)]
        found_w, fields = gyroscopic_eigen(np.eye(len(block)), stiffness, gyroscopic)
        w, vectors = found_w[: len(block)].real, fields[:, : len(block)]  # the others: conjugate
        mode, motion = linear_sum_assignment(np.abs(vectors) ** 2, maximize=True)
        mode = block[mode]
        way = _ways(rotor, nodal_diameter[mode], rotor.tip_radial[:, block] @ vectors[:, motion])
        signed[mode] = np.sign(sense) * way * w[motion]
        found[:, mode] = w[motion]
    for modes in own:
        ascending = modes[np.argsort(rotor.frequency[modes], kind="stable")]
        ranked = [ascending] if symmetric else np.split(ascending, range(2, len(ascending), 2))
        for some in ranked:  # a whole nodal diameter; without symmetry pairs, as far as they are
            both, half = np.sort(signed[some]), len(some) // 2
            if both.all() and (
                len({*rotor.column[some]}) == 2 if symmetric else both[0] < 0.0 < both[-1]
            ):
                found[0, some] = np.repeat(both[half:], 2)
                found[1, some] = np.repeat(-both[:half][::-1], 2)
    return found


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
    found = wave_frequencies(rotor, nodal_diameter, turning.omega)
    errors = dict.fromkeys(family, 0.0)
    for k in np.unique(nodal_diameter):
        w = waves(turning.matrices, int(k), "full").frequencies(abs(turning.omega)).real
        half = len(w) // 2
        exact = np.stack([w[:half][::-1], -w[half:]])
        own = np.flatnonzero(nodal_diameter == k)
        ascending = own[np.argsort(rotor.frequency[own], kind="stable")]
        each = 2 if is_pair(int(k), layout.sectors) else 1
        for rank, modes in enumerate(np.split(ascending, range(each, len(own), each))):
            off = np.abs(found[:, modes[0]] / exact[:, rank] - 1.0).max()
            errors[family[modes[0]]] = max(errors[family[modes[0]]], float(off))
    return errors


def _ways(rotor: ReducedRotor, nodal_diameter: IntArray, tips: ComplexArray) -> FloatArray:
    """1 for motions p exp(i w t) that turn against the blades' numbers, -1 along, 0 if they stand.

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
