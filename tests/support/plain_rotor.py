"""A wheel on a shaft, assembled whole and unreduced in rotating axes with plain NumPy.

Unknowns of a node of the shaft are the displacements along x, y and z and the rotations about x, y
and z; the slopes of the axis are p_x = theta_y and p_y = -theta_x. Bearings are round.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import eigs, spsolve

Array = np.ndarray[Any, Any]

E, NU, RHO = 2.1e11, 0.3, 7800.0
SPIN = np.array([[0.0, -1.0], [1.0, 0.0]])


@dataclass(frozen=True, kw_only=True)
class Shaft:
    """A shaft of equal elements from z = 0."""

    length: float
    diameter: float
    elements: int
    bearings: tuple[tuple[int, float, float], ...]  #: node, stiffness and damping
    axial: tuple[int, float] | None = None  #: node and stiffness
    hub: int = 0  #: node of the wheel


def beam(length: float, diameter: float) -> tuple[Array, Array, Array]:
    """Stiffness, mass of deflections and rotary inertia of w, w' at both ends (Przemieniecki)."""
    area, inertia = np.pi * diameter**2 / 4.0, np.pi * diameter**4 / 64.0
    kappa = 6.0 * (1.0 + NU) / (7.0 + 6.0 * NU)
    shear = 12.0 * E * inertia / (kappa * E / (2.0 + 2.0 * NU) * area * length**2)
    el = length
    stiffness = (
        E
        * inertia
        / (el**3 * (1.0 + shear))
        * np.array(
            [
                [12.0, 6.0 * el, -12.0, 6.0 * el],
                [6.0 * el, (4.0 + shear) * el**2, -6.0 * el, (2.0 - shear) * el**2],
                [-12.0, -6.0 * el, 12.0, -6.0 * el],
                [6.0 * el, (2.0 - shear) * el**2, -6.0 * el, (4.0 + shear) * el**2],
            ]
        )
    )
    points, weights = np.polynomial.legendre.leggauss(6)
    translation, rotation = np.zeros((2, 4, 4))
    for x, weight in zip((points + 1.0) / 2.0, weights * el / 2.0, strict=True):
        f = shear
        w = np.array(
            [
                1.0 - 3.0 * x**2 + 2.0 * x**3 + f * (1.0 - x),
                el * (x - 2.0 * x**2 + x**3 + f / 2.0 * (x - x**2)),
                3.0 * x**2 - 2.0 * x**3 + f * x,
                el * (-(x**2) + x**3 - f / 2.0 * (x - x**2)),
            ]
        ) / (1.0 + f)
        turn = np.array(
            [
                6.0 / el * (-x + x**2),
                1.0 - 4.0 * x + 3.0 * x**2 + f * (1.0 - x),
                6.0 / el * (x - x**2),
                -2.0 * x + 3.0 * x**2 + f * x,
            ]
        ) / (1.0 + f)
        translation += weight * RHO * area * np.outer(w, w)
        rotation += weight * RHO * inertia * np.outer(turn, turn)
    return stiffness, translation, rotation


def rotor(shaft: Shaft, wheel: Any, omega: float) -> tuple[sp.csc_array, ...]:
    """Return mass, damping and stiffness in rotating axes; the last unknowns are those of the
    shaft, six a node, without its rotation about z at the first node."""
    nodes, size = shaft.elements + 1, wheel.size - 6
    count = size + 6 * nodes
    mass, drag, stiffness = (sp.lil_array((count, count)) for _ in range(3))
    el = shaft.length / shaft.elements
    k, m_t, m_r = beam(el, shaft.diameter)
    area, polar = np.pi * shaft.diameter**2 / 4.0, np.pi * shaft.diameter**4 / 32.0
    rod = np.array([[1.0, -1.0], [-1.0, 1.0]]) / el
    even = np.array([[2.0, 1.0], [1.0, 2.0]]) * el / 6.0
    for element in range(shaft.elements):
        one = size + 6 * element
        two = one + 6
        in_x, in_y = [one, one + 4, two, two + 4], [one + 1, one + 3, two + 1, two + 3]
        sign = np.diag([1.0, -1.0, 1.0, -1.0])  # p_y = -theta_x
        for rows, turn in ((in_x, np.eye(4)), (in_y, sign)):
            mass[np.ix_(rows, rows)] += turn @ (m_t + m_r) @ turn
            stiffness[np.ix_(rows, rows)] += turn @ (k - omega**2 * (m_t - m_r)) @ turn
        across = -2.0 * omega * m_t @ sign
        drag[np.ix_(in_x, in_y)] += across
        drag[np.ix_(in_y, in_x)] -= across.T
        for first, elastic, inert in ((2, E * area, RHO * area), (5, E / 2.6 * polar, RHO * polar)):
            rows = [one + first, two + first]
            stiffness[np.ix_(rows, rows)] += elastic * rod
            mass[np.ix_(rows, rows)] += inert * even
    for node, spring, damper in shaft.bearings:
        rows = [size + 6 * node, size + 6 * node + 1]
        stiffness[np.ix_(rows, rows)] += spring * np.eye(2) + omega * damper * SPIN
        drag[np.ix_(rows, rows)] += damper * np.eye(2)
    if shaft.axial is not None:
        node, spring = shaft.axial
        stiffness[size + 6 * node + 2, size + 6 * node + 2] += spring
    inner = np.setdiff1d(np.arange(wheel.size), wheel.hub_dofs)
    place = np.empty(wheel.size, dtype=int)
    place[inner], place[wheel.hub_dofs] = np.arange(size), size + 6 * shaft.hub + np.arange(6)
    spread = sp.csr_array(
        (np.ones(wheel.size), (np.arange(wheel.size), place)), shape=(wheel.size, count)
    )
    turning = wheel.at(omega)
    mass = mass + spread.T @ turning.mass @ spread
    drag = drag + omega * spread.T @ turning.gyroscopic @ spread
    stiffness = stiffness + spread.T @ turning.stiffness @ spread
    held = [size + 5] + ([] if shaft.axial else [size + 2])
    free = np.delete(np.arange(count), held)
    return tuple(
        sp.csc_array(sp.csr_array(each)[free][:, free]) for each in (mass, drag, stiffness)
    )


def eigenvalues(
    shaft: Shaft, wheel: Any, omega: float, near: complex, count: int
) -> list[tuple[str, complex]]:
    """Return eigenvalues of the rotor near a number as those of static axes, each with the kind of
    motion of the node of the wheel: "forward" or "backward" as seen in static axes, or "axial"
    along and about z; those in which this node is at rest are left out."""
    mass, drag, stiffness = rotor(shaft, wheel, omega)
    one = sp.eye_array(mass.shape[0], format="csc")
    first = sp.block_array([[None, one], [-stiffness, -drag]], format="csc")
    second = sp.block_array([[one, None], [None, mass]], format="csc")
    values, vectors = eigs(first.astype(complex), count, second.astype(complex), sigma=near)
    size, found = wheel.size - 6, []
    held = 1 if shaft.axial else 2  # of the first node, before that of the wheel
    at = size + 6 * shaft.hub - held
    for value, vector in zip(values, vectors[: mass.shape[0]].T, strict=True):
        for _ in range(3):  # inverse iteration of the quadratic problem
            dynamic = sp.csc_array(stiffness + value * drag + value**2 * mass)
            step = spsolve(dynamic, (drag + 2.0 * value * mass) @ vector)
            value -= (vector.conj() @ vector) / (vector.conj() @ step)
            vector = step / np.linalg.norm(step)
        x, y, z = vector[at : at + 3]
        turn = vector[at + 5]
        ahead, back, axial = abs(x + 1j * y), abs(x - 1j * y), np.hypot(abs(z), 0.1 * abs(turn))
        largest = max(ahead, back, axial)
        if value.imag < 0.0 or largest < 1e-7 * abs(vector).max():
            continue
        if axial == largest:
            found.append(("axial", complex(value)))
            continue
        static = value + 1j * omega if ahead > back else value - 1j * omega
        static = static if ahead > back else np.conj(static)  # of u_x + i u_y
        whirl = "forward" if static.imag > 0.0 else "backward"
        found.append((whirl, complex(static.real, abs(static.imag))))
    return found
