"""The wheel of a case on its shaft line."""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
import scipy.linalg as la

from bladewhirl.meshes.line_mesh import IntArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import faults_at
from bladewhirl.models.case.superelement import SOURCE, SuperelementTable
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.shaft_line.hub_waves import HubWave, hub_waves
from bladewhirl.models.superelements.superelement import SuperelementError


@dataclass(frozen=True, kw_only=True)
class WheelOnLine:
    """A wheel of solids on a node of the shaft."""

    node: int  #: number of the node
    whirling: HubWave  #: wave of nodal diameter 1
    unknowns: IntArray  #: unknowns of the line that are its coordinates, (m,)
    axial: HubWave | None
    """Wave of nodal diameter 0; None if the hub does not move along and about the axis."""
    mass: float  #: mass [kg]
    offset: float  #: position of the centre of mass along z, relative to the hub [m]
    polar_inertia: float  #: moment of inertia about the axis [kg m2]
    diametral_inertia: float  #: that about a diameter through the centre of mass [kg m2]


def wheel_on_line(case: Case, highest: float, node: int, following: int) -> WheelOnLine:
    """Return the wheel of a case.

    Args:
        case: case with shaft_line.wheel.
        highest: highest speed [rad/s].
        node: number of the node of its hub.
        following: number of its first unknown that is not one of the node.

    Raises:
        CaseError: the superelement is not a wheel with a hub.
    """
    table = case.bladed_disk.superelement
    assert table is not None
    assert case.shaft_line is not None
    assert case.shaft_line.wheel is not None
    try:
        waves = _waves(table, highest, *table.stamp)
    except SuperelementError as error:
        raise CaseError(faults_at(case, f"{SOURCE}.file", error)) from None
    unknowns, whirling = case.shaft_line.wheel.unknowns, waves[1]
    free = 1 if unknowns == "two" else 2
    kept = np.delete(np.arange(whirling.size), slice(free, 2))
    amplitudes = following + np.arange(whirling.size - 2)
    (mass, arm), (_, tilting) = whirling.mass[:2, :2].real.tolist()
    waves = {k: _damped(wave, case.shaft_line.wheel.damping_ratio) for k, wave in waves.items()}
    whirling = waves[1]
    return WheelOnLine(
        mass=mass,
        offset=arm / mass,
        polar_inertia=float(waves[0].mass[1, 1].real),
        diametral_inertia=tilting - arm**2 / mass,
        node=node,
        whirling=whirling.on(np.eye(whirling.size)[:, kept]),
        unknowns=np.concatenate([2 * node + np.arange(free), amplitudes]),
        axial=waves[0] if unknowns == "six" else None,
    )


def _damped(wave: HubWave, ratio: float) -> HubWave:
    """Return a wave whose modes with a fixed hub at rest have a damping ratio, besides the damping
    matrix of the file."""
    damping = np.zeros(wave.mass.shape, np.complex128)
    mass, stiffness = wave.mass[2:, 2:], wave.stiffness[2:, 2:]
    squares, shapes = la.eigh(stiffness, mass)
    moved = mass @ shapes
    damping[2:, 2:] = (moved * (2.0 * ratio * np.sqrt(squares))) @ moved.conj().T
    return replace(wave, damping=wave.known("damping") + damping) if ratio else wave


@lru_cache(maxsize=4)
def _waves(table: SuperelementTable, highest: float, *stamp: int) -> dict[int, HubWave]:
    """Reduce a file once for all speeds; its stamp makes sure that a changed file is read again."""
    return hub_waves(table.with_hub, highest)
