"""Engine-order forces on the blades of a wheel that moves its shaft line.

The force F cos(r (Omega t + theta_n) + phi) on blade n of N has the nodal diameter r modulo N. One
of diameter 0 moves the line along and about the axis with the frequency r Omega; one of diameter 1
moves it sideways, in static axes at (r + 1) Omega if r + 1 is a multiple of N, and at -(r - 1)
Omega if r - 1 is. Other orders move the blades only.
"""

from dataclasses import dataclass

import numpy as np

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.models.case.excitation import EngineOrder
from bladewhirl.models.shaft_line.axial import axial_line
from bladewhirl.models.shaft_line.hub_waves import HubWave
from bladewhirl.models.shaft_line.line import LineModel
from bladewhirl.models.shaft_line.whirl import driven, solved


@dataclass(frozen=True, kw_only=True)
class OrderMotion:
    """Steady motion of a line by forces of an engine order."""

    tip: ComplexArray
    """Mean tangential and radial displacement of the contact nodes of the first blade: amplitudes
    of exp(i r Omega t) and, on unequal bearings, of another frequency [m], (2, 2)."""
    forward: ComplexArray  #: counter-clockwise part of the deflections of the nodes [m], (nodes,)
    backward: ComplexArray  #: clockwise part [m], (nodes,)
    axial: complex  #: displacement of the hub along the axis [m]
    torsion: complex  #: rotation of the hub about the axis [rad]


def moves_line(line: LineModel, order: int) -> bool:
    """Return whether forces of an engine order on the blades move the line."""
    blades = _blades(line)
    sideways = (order + 1) % blades == 0 or (order - 1) % blades == 0
    return sideways or (order % blades == 0 and line.wheels[0].axial is not None)


def order_motion(line: LineModel, omega: float, load: EngineOrder, order: int) -> OrderMotion:
    """Return the motion by forces of an engine order on the wheel of [bladed_disk] that move the
    line, at a speed [rad/s].

    Raises:
        LinAlgError: their frequency is that of a mode without damping.
    """
    wheel = line.wheels[0]
    assert isinstance(load.phase, float)
    blades, nodes = _blades(line), slice(0, 2 * len(line.position), 2)
    still = np.zeros(len(line.position), np.complex128)
    if order % blades == 0:
        axial = wheel.axial
        assert axial is not None
        rows, force = _forces(line, axial, load, order, sign=1)
        structure, _, _, wheels = axial_line(line, omega)
        rate = order * omega
        dynamic = structure.stiffness + 1j * rate * structure.known("damping")
        own = wheels[0] @ solved(dynamic - rate**2 * structure.mass, wheels[0].T @ force)
        tip = np.stack([rows @ own, np.zeros(2)])
        return OrderMotion(
            tip=tip, forward=still, backward=still, axial=complex(own[0]), torsion=complex(own[1])
        )
    sign = 1 if (order + 1) % blades == 0 else -1
    rows, own_force = _forces(line, wheel.whirling, load, order, sign=sign)
    force = np.zeros(line.size, np.complex128)
    force[wheel.unknowns] = own_force / 2.0
    ahead, back = driven(line, omega, (sign * order + 1) * omega, force)
    tip = np.stack([rows @ each[wheel.unknowns] for each in (ahead, back)])
    left, right = ahead[nodes], back[nodes]
    if sign * order + 1 < 0:
        left, right = right, left
    return OrderMotion(tip=tip, forward=left, backward=right, axial=0.0, torsion=0.0)


def _blades(line: LineModel) -> int:
    return line.wheels[0].source.blades


def _forces(
    line: LineModel, wave: HubWave, load: EngineOrder, order: int, *, sign: int
) -> tuple[ComplexArray, ComplexArray]:
    """Return the radial and the tangential displacement of the first blade as rows on the
    coordinates of a wave, (2, m), and the forces on these, (m,), for the time factor exp(i sign r
    Omega t)."""
    part, blades, turn, _ = line.wheels[0].source
    count = 1 if part.left_dofs is not None else blades
    moved = wave.contact.reshape(count, -1, 3, wave.size).mean(axis=1)
    x, y = part.contact_position[:, :2].reshape(count, -1, 2).mean(axis=1).T
    angle: FloatArray = np.arctan2(y, x) + turn
    direction = np.array([np.cos(load.inclination), np.sin(load.inclination)])
    phase = sign * (order * angle + load.phase)
    along = np.einsum("ncm,c->nm", moved[:, :2].conj(), direction)
    force = load.amplitude * blades / count * (np.exp(1j * phase) @ along)
    return moved[0, :2], np.asarray(force)
