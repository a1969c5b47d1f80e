"""Axial and torsional vibration of a shaft line with a wheel of solids.

The wave of nodal diameter 0 of the wheel couples the displacement of its hub along the axis and the
rotation about it. Elements of the shaft are rods, with linear displacements and rotations. The line
is held along z by its axial spring or at the drive, about z at the drive. Rotating and static axes
show the same frequencies.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import scipy.linalg as la

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray, IntArray
from bladewhirl.models.shaft_line.line import LineModel
from bladewhirl.models.shaft_line.whirl import LineModes, conserved
from bladewhirl.models.structure.rotating import Rotating

STRETCH = np.array([[1.0, -1.0], [-1.0, 1.0]])


@dataclass(frozen=True, kw_only=True)
class AxialModes:
    """Modes along and about the axis that vibrate or grow, by rising frequency."""

    eigenvalue: ComplexArray  #: decay rate (negative) plus i times frequency [rad/s], (modes,)
    direction: tuple[str, ...]  #: "axial" or "torsional", whichever has more kinetic energy


@dataclass(frozen=True, kw_only=True)
class SortedModes:
    """Modes that whirl and modes along and about the axis, by rising frequency."""

    eigenvalue: ComplexArray  #: decay rate (negative) plus i times frequency [rad/s], (modes,)
    direction: Any  #: direction of each mode, (modes,), of objects
    row: IntArray
    """Numbers of the modes among those that whirl, and after these among the others, (modes,)."""


def axial_modes(line: LineModel, omega: float) -> AxialModes:
    """Return the modes of a line with a wheel of six unknowns at a speed [rad/s]; none of other
    lines."""
    if all(wheel.axial is None for wheel in line.wheels):
        return AxialModes(eigenvalue=np.zeros(0, np.complex128), direction=())
    structure, along, about, _ = axial_line(line, omega)
    mass, stiffness, drag = structure.mass, structure.stiffness, structure.known("damping")
    one = np.eye(len(mass))
    first = np.block(
        [[0.0 * one, one], [-la.solve(mass, stiffness), -la.solve(mass, drag)]],
    )
    values, vectors = la.eig(first)
    values = conserved(values, drag, stiffness)
    rows = np.flatnonzero((values.imag > 0.0) | ((values.imag == 0.0) & (values.real > 0.0)))
    rows = rows[np.argsort(values[rows].imag, kind="stable")]
    shapes = vectors[: len(mass), rows]
    moved, turned = (
        np.einsum("nm,nk,km->m", shapes[own].conj(), mass[np.ix_(own, own)], shapes[own]).real
        for own in (along, about)
    )
    names = np.where(moved > turned, "axial", "torsional")
    return AxialModes(eigenvalue=values[rows], direction=tuple(names.tolist()))


def with_axial(line: LineModel, modes: LineModes, count: int | None) -> "SortedModes":
    """Return the lowest ones of modes that whirl and of modes along and about the axis."""
    axial = axial_modes(line, modes.speed)
    values = np.concatenate([modes.eigenvalue, axial.eigenvalue])
    order = np.argsort(values.imag, kind="stable")[:count]
    names = np.array([*modes.direction, *axial.direction], dtype=object)
    return SortedModes(eigenvalue=values[order], direction=names[order], row=order)


class AxialLine(NamedTuple):
    """A line along and about the axis without what is held."""

    structure: Rotating[FloatArray]  #: its matrices at a speed, (m, m)
    along: IntArray  #: numbers of the displacements
    about: IntArray  #: numbers of the rotations
    wheels: tuple[FloatArray, ...]
    """Coordinates of each wheel of six unknowns as rows on the unknowns."""


def axial_line(line: LineModel, omega: float) -> AxialLine:
    """Return a line with wheels of six unknowns along and about its axis at a speed [rad/s]."""
    table, count = line.table, len(line.shaft.node)
    waves = [(wheel.node, wheel.axial) for wheel in line.wheels if wheel.axial is not None]
    size = 2 * count + sum(wave.size - 2 for _, wave in waves)
    mass, drag, stiffness = np.zeros((3, size, size))
    mass[: 2 * count, : 2 * count], stiffness[: 2 * count, : 2 * count] = rods(line)
    drag += table.loss_time * stiffness
    first, coordinates = 2 * count, []
    for node, wave in waves:
        amplitudes = np.arange(first, first + wave.size - 2)
        own = np.concatenate([[node, count + node], amplitudes])
        rows = np.ix_(own, own)
        mass[rows] += wave.mass.real
        drag[rows] += wave.drag(omega).real
        stiffness[rows] += wave.stiffness_at(omega).real
        first += wave.size - 2
        coordinates.append(own)
    if table.axial is not None:
        spring = line.node(table.axial.position)
        stiffness[spring, spring] += table.axial.stiffness
    free = np.delete(np.arange(size), held_along(line))
    chosen = np.ix_(free, free)
    return AxialLine(
        structure=Rotating(
            mass=mass[chosen], damping=drag[chosen], stiffness=stiffness[chosen], speed=omega
        ),
        along=np.flatnonzero(free < count),
        about=np.flatnonzero((free >= count) & (free < 2 * count)),
        wheels=tuple(np.eye(size)[own][:, free] for own in coordinates),
    )


def rods(line: LineModel) -> tuple[FloatArray, FloatArray]:
    """Return mass and stiffness of the shaft with its disks for the displacements of the nodes
    along the axis, then their rotations about it, (2 nodes, 2 nodes) each."""
    shaft, count = line.shaft, len(line.shaft.node)
    mass, stiffness = np.zeros((2, 2 * count, 2 * count))
    area = np.pi / 4.0 * (shaft.outer**2 - shaft.inner[:, None] ** 2)
    polar = np.pi / 32.0 * (shaft.outer**4 - shaft.inner[:, None] ** 4)
    parts = (shaft.young_modulus, area), (shaft.torsion_modulus, polar)
    for first, (modulus, section) in zip((0, count), parts, strict=True):
        for element, (left, right) in enumerate(section):
            length, middle = shaft.length[element], (left + right) / 2.0
            ends = first + element + np.arange(2)
            both = np.ix_(ends, ends)
            stiffness[both] += modulus[element] * middle / length * STRETCH
            # linear sections: integrals of products of three linear functions
            spread = np.array(
                [[3.0 * left + right, left + right], [left + right, left + 3.0 * right]]
            )
            mass[both] += shaft.density[element] * length / 12.0 * spread
    for disk in line.table.disks:
        node = line.node(disk.position)
        mass[node, node] += disk.mass
        mass[count + node, count + node] += disk.polar_inertia
    return mass, stiffness


def held_along(line: LineModel) -> list[int]:
    """Return the unknowns of `rods` that the drive holds: the rotation about the axis and, without
    an axial spring, the displacement along it."""
    table = line.table
    drive = line.node(table.start if table.drive_position is None else table.drive_position)
    return [len(line.shaft.node) + drive] + [drive] * (table.axial is None)
