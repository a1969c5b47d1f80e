"""The wheels of a case on its shaft line."""

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import scipy.linalg as la

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import faults_at
from bladewhirl.models.case.shaft_line import Wheel
from bladewhirl.models.case.superelement import SOURCE, SuperelementTable
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.shaft_line.beam_wheel import beam_wheel
from bladewhirl.models.shaft_line.hub_waves import HubWave, hub_waves
from bladewhirl.models.superelements.superelement import Superelement, SuperelementError


class WheelPart(NamedTuple):
    """Full matrices of a wheel."""

    part: Superelement  #: the wheel, or its first sector
    blades: int  #: number of blades
    angle: float  #: angle by which the blades of the superelement are turned [rad]
    of_beams: bool  #: whether the wheel consists of beams, so that it tilts as a rigid disk


@dataclass(frozen=True, kw_only=True)
class WheelOnLine:
    """A wheel on a node of the shaft."""

    source: WheelPart
    node: int  #: number of the node
    whirling: HubWave  #: wave of nodal diameter 1
    unknowns: IntArray  #: unknowns of the line that are its coordinates, (m,)
    axial: HubWave | None
    """Wave of nodal diameter 0; None if the hub does not move along and about the axis."""
    mass: float  #: mass [kg]
    offset: float  #: position of the centre of mass along z, relative to the hub [m]
    polar_inertia: float  #: moment of inertia about the axis [kg m2]
    diametral_inertia: float  #: that about a diameter through the centre of mass [kg m2]


def wheels_on_line(
    case: Case, highest: float, nodes: FloatArray, following: int
) -> tuple[WheelOnLine, ...]:
    """Return the wheels of a case, first that of [bladed_disk].

    Args:
        case: case with a shaft line.
        highest: highest speed [rad/s].
        nodes: positions of the nodes of the shaft [m].
        following: number of the first unknown that is not one of a node or a support.

    Raises:
        CaseError: a superelement is not a wheel with a hub.
    """
    line, found = case.shaft_line, list[WheelOnLine]()
    assert line is not None
    tables = [] if line.wheel is None else [(SOURCE, case.bladed_disk.superelement, line.wheel)]
    tables += [
        (f"shaft_line.wheels.{row}.superelement", wheel.superelement, wheel)
        for row, wheel in enumerate(line.wheels)
    ]
    for key, table, wheel in tables:
        try:
            if table is None:
                part, bases = beam_wheel(case)
                source = WheelPart(part, part.sectors or 1, 0.0, True)
                waves = hub_waves(part, highest, bases)
            else:
                source = WheelPart(table.with_hub, table.copies, table.angle, False)
                waves = _waves(table, highest, *table.stamp)
        except SuperelementError as error:
            place = "shaft_line.wheel" if table is None else f"{key}.file"
            raise CaseError(faults_at(case, place, error)) from None
        node = int(np.abs(nodes - wheel.position).argmin())
        found.append(_on_line(wheel, source, waves, node, following))
        following += waves[1].size - 2
    return tuple(found)


def _on_line(
    wheel: Wheel, source: WheelPart, waves: dict[int, HubWave], node: int, following: int
) -> WheelOnLine:
    """Return a wheel on a node, whose amplitudes are the unknowns from a number on."""
    waves = {k: _damped(wave, wheel.damping_ratio) for k, wave in waves.items()}
    unknowns, whirling = wheel.unknowns, waves[1]
    free = 1 if unknowns == "two" else 2
    kept = np.delete(np.arange(whirling.size), slice(free, 2))
    amplitudes = following + np.arange(whirling.size - 2)
    (mass, arm), (_, tilting) = whirling.mass[:2, :2].real.tolist()
    return WheelOnLine(
        source=source,
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
    copies = table.copies if table.copies > 1 or table.kind == "sector" else None
    return hub_waves(replace(table.with_hub, sectors=copies), highest)
