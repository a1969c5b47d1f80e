"""Frequencies of the waves of a reduced rotor with Coriolis forces."""

import numpy as np

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray, IntArray
from bladewhirl.models.elements.bladed_disk import BladedDiskModel
from bladewhirl.models.elements.cyclic import is_pair
from bladewhirl.models.stage.reduced_rotor import ReducedRotor
from bladewhirl.models.structure.eigenproblems import gyroscopic_eigen

STANDS = 1e-6
"""A motion is standing if its backward and forward parts differ by at most this fraction of their
sum."""


def wave_frequencies(rotor: ReducedRotor, nodal_diameter: IntArray, sense: float) -> FloatArray:
    """Return the frequencies of the backward and the forward wave of each mode.

    With symmetry, the pairs of modes of one nodal diameter are assigned to its waves in each
    direction by rank, because branches do not cross. Without symmetry, a motion at speed consists
    of several modes; a pair of modes gets the frequencies of the two motions to which it
    contributes most, if one of them travels forward and the other backward. The two frequencies of
    a mode are equal for a standing motion, and for every mode without Coriolis forces.

    Args:
        rotor: reduced rotor with its modes.
        nodal_diameter: nodal diameter of each mode, (modes,).
        sense: a number with the sign of the speed.

    Returns:
        frequencies of the backward and of the forward waves in the rotating frame [rad/s],
        (2, modes). A frequency is negative if the wave has changed its direction, as a forward wave
        does past its critical speed.
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
        w, vectors = found_w[: len(block)].real, fields[:, : len(block)]  # without conjugates
        mode, motion = linear_sum_assignment(np.abs(vectors) ** 2, maximize=True)
        mode = block[mode]
        way = _ways(rotor, nodal_diameter[mode], rotor.tip_radial[:, block] @ vectors[:, motion])
        signed[mode] = np.sign(sense) * way * w[motion]
        frequencies[:, mode] = w[motion]
    for modes in members:
        ascending = modes[np.argsort(rotor.frequency[modes], kind="stable")]
        ranked = [ascending] if symmetric else np.split(ascending, range(2, len(ascending), 2))
        for some in ranked:  # all modes of a nodal diameter; without symmetry, two modes at a time
            both, half = np.sort(signed[some]), len(some) // 2
            if both.all() and (
                len({*rotor.column[some]}) == 2 if symmetric else both[0] < 0.0 < both[-1]
            ):
                frequencies[0, some] = np.repeat(both[half:], 2)
                frequencies[1, some] = np.repeat(-both[:half][::-1], 2)
    return frequencies


def wave_errors(
    rotor: ReducedRotor, nodal_diameter: IntArray, family: tuple[str, ...], disk: BladedDiskModel
) -> dict[str, float]:
    """Return the largest relative frequency error of the backward and forward waves of each family.

    Args:
        rotor: the reduced bladed disk, with equal sectors.
        nodal_diameter: nodal diameter of each mode, (modes,).
        family: family of each mode, (modes,).
        disk: the full bladed disk at speed, with Coriolis forces.
    """
    layout = disk.structure.layout
    assert layout is not None  # the sectors are equal
    frequencies = wave_frequencies(rotor, nodal_diameter, disk.speed)
    errors = dict.fromkeys(family, 0.0)
    for k in np.unique(nodal_diameter):
        w = disk.structure.wave(int(k)).frequencies(abs(disk.speed)).real
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
    """Return 1 for motions p exp(i w t) that travel against the numbering of the blades, -1 for
    motions that travel along the numbering, and 0 for standing motions, (motions,).

    Args:
        rotor: reduced rotor with the angles of the tips.
        nodal_diameter: nodal diameter of each motion, (motions,).
        tips: p at the tips, (tips, motions).
    """
    turn = np.exp(1j * np.outer(nodal_diameter, rotor.tip_angle))
    against = np.abs(np.einsum("mt,tm->m", turn.conj(), tips)) ** 2
    along = np.abs(np.einsum("mt,tm->m", turn, tips)) ** 2
    excess = (against - along) / np.maximum(against + along, np.finfo(np.float64).tiny)
    return np.asarray(np.where(np.abs(excess) > STANDS, np.sign(excess), 0.0))
