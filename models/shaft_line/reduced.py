"""A shaft line on a few modes in rotating axes, without its bearings.

Deflections and slopes of a round line are zeta = Phi (q_x + i q_y) in rotating axes, with the same
real shapes Phi in both planes. At the speed Omega, with the symbols of `line`,

    M (zeta'' + 2 i Omega zeta' + (i Omega' - Omega^2) zeta) - i P (Omega zeta' + (Omega'/2 + i
    Omega^2) zeta) + t K_s zeta' + K_s zeta = f

so that Coriolis and Euler forces are -2 Omega G q' - Omega' G q with G = i (M - P/2). The Euler
part takes half of the polar inertia times the acceleration, as solids in rotating axes do: the
moment of the drive then has half of its direction from the shaft's own axis and half from the fixed
one, see the documentation.

Central differences of these equations do not keep the momentum of a free line. They do if they are
those in static axes, where z_{n+1} = zeta_{n+1} exp(i (psi + a)) with the angle a = Omega h in a
time step h; written in zeta they have the matrices

    M cos a + P (a sin a) / 2,  2 i M sin(a) / a - i P cos a,  P sin(a) / a - 2 M (1 - cos a) / a^2

in place of M, of 2 i M - i P with Omega, and of P - M with Omega^2, which a zero step leaves.
"""

from dataclasses import dataclass

import numpy as np
import scipy.linalg as la

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.models.shaft_line.line import LineModel, real_form

DEPENDENT = 1e-9
"""A shape is left out if the part of it that others do not contain is a smaller fraction of it."""

LEVELS = 6
"""Modes at rest in which those at speed are computed, as a multiple of the modes of a plane; those
of a line of many nodes hardly contain higher ones."""

LOW = 1e-2
"""Static shapes of an unheld line are those on an elastic support of its masses that gives this
fraction of the reference frequency."""


@dataclass(frozen=True, kw_only=True)
class ReducedLine:
    """A shaft line on modes at a speed, those of the plane x before those of the plane y."""

    speed: float  #: speed [rad/s]
    squares: FloatArray  #: squared frequencies in rotating axes [rad2/s2], (modes of a plane,)
    shapes: FloatArray  #: deflection and slope of each node in a plane, (n, modes of a plane)
    gyroscopic: FloatArray  #: skew matrix 2 G, for a speed of 1 rad/s, (modes, modes)
    stiffness_speed: FloatArray  #: increase of the stiffness by Omega^2, (modes, modes)
    damping: FloatArray  #: internal damping [1/s], (modes, modes)

    def rows(self, unknowns: FloatArray) -> ComplexArray:
        """Return displacements x + i y for unit modal coordinates, (rows, modes), from rows on the
        unknowns of the shaft in a plane."""
        plane = unknowns @ self.shapes
        return np.hstack([plane, 1j * plane])

    def forces(self, force: ComplexArray) -> FloatArray:
        """Return the modal forces of forces x + i y on the unknowns of the shaft, (modes,)."""
        plane = self.shapes.T @ force
        return np.concatenate([plane.real, plane.imag])

    def coordinates(self, unknowns: ComplexArray) -> FloatArray:
        """Return the modal coordinates of displacements x + i y of the shaft, (modes,): those with
        the smallest difference."""
        plane = la.lstsq(self.shapes, unknowns)[0]
        return np.concatenate([plane.real, plane.imag])


def reduced_line(line: LineModel, speed: float, modes: int, time_step: float = 0.0) -> ReducedLine:
    """Return a shaft line on modes.

    The modes contain the static shapes of forces of the bearings, and as many modes of the line
    without bearings as there is room for, at rest and at the speed, the lowest first.

    Args:
        line: the shaft line.
        speed: largest speed [rad/s], to which the modes belong.
        modes: number of modes of a plane; all unknowns of the shaft if there are fewer.
        time_step: time step of a march, in which a free line is to keep its momentum [s].
    """
    size = 2 * len(line.position)
    mass, polar, stiffness = (
        each[:size, :size] for each in (line.mass, line.polar, line.shaft_stiffness)
    )
    basis = np.eye(size)
    if modes < size:
        shapes = _candidates(line, mass, polar, stiffness, speed, LEVELS * modes)
        basis = _independent(shapes, mass, modes)
    angle = speed * time_step
    cosine, sine, chord = float(np.cos(angle)), _sinc(angle), _sinc(angle / 2.0) ** 2
    mass, twice, softer = (
        cosine * mass + 0.5 * angle**2 * sine * polar,
        2.0 * sine * mass - cosine * polar,
        sine * polar - chord * mass,
    )
    bent = _without_rigid(basis.T @ stiffness @ basis, basis, line.position)
    at_speed = bent + speed**2 * (basis.T @ softer @ basis)
    squares, on_basis = la.eigh(at_speed, basis.T @ mass @ basis)
    shapes = basis @ on_basis
    projected = [
        shapes.T @ twice @ shapes,
        shapes.T @ softer @ shapes,
        on_basis.T @ bent @ on_basis,
    ]
    twice, softer, bent = ((each + each.T) / 2.0 for each in projected)  # no damping by rounding
    return ReducedLine(
        speed=speed,
        squares=squares,
        shapes=shapes,
        gyroscopic=real_form(1j * twice),
        stiffness_speed=real_form(softer),
        damping=line.table.loss_time * real_form(bent),
    )


def _without_rigid(stiffness: FloatArray, basis: FloatArray, position: FloatArray) -> FloatArray:
    """Return the stiffness on a basis without the forces on rigid motions that rounding leaves."""
    rigid = np.zeros((len(basis), 2))
    rigid[0::2, 0], rigid[0::2, 1], rigid[1::2, 1] = 1.0, position, 1.0
    own = la.qr(la.lstsq(basis, rigid)[0], mode="economic")[0]
    bending = np.eye(len(own)) - own @ own.T
    return np.asarray(bending @ stiffness @ bending)


def _sinc(angle: float) -> float:
    """Return sin(angle) / angle."""
    return float(np.sinc(angle / np.pi))


def _candidates(
    line: LineModel,
    mass: FloatArray,
    polar: FloatArray,
    stiffness: FloatArray,
    speed: float,
    most: int,
) -> FloatArray:
    """Return shapes in order of their importance, (n, shapes), from at most some modes at rest."""
    size, levels = len(mass), min(most, len(mass))
    squares, free = la.eigh(stiffness, mass, subset_by_index=[0, levels - 1])
    soft = stiffness + (LOW * line.reference_frequency) ** 2 * mass
    held = la.solve(soft, line.bearing_rows[:, :size].T, assume_a="pos")
    frequency = np.sqrt(np.maximum(squares, 0.0))
    turning = speed * free.T @ polar @ free
    none, one = np.zeros_like(turning), np.eye(levels)
    # w (A + w) f = K f for whirl at the frequency w, with the sign of its direction.
    values, vectors = la.eig(np.block([[none, one], [np.diag(frequency**2), turning]]))
    order = np.argsort(np.abs(values))
    whirl = free @ vectors[:levels, order].real
    by_level = np.stack([free, whirl[:, 0::2], whirl[:, 1::2]], axis=2)
    return np.hstack([held, by_level.reshape(size, -1)])


def _independent(shapes: FloatArray, mass: FloatArray, most: int) -> FloatArray:
    """Return the first independent shapes, orthonormal with the mass, (n, most)."""
    chosen = np.zeros((len(mass), 0))
    for shape in shapes.T:
        left = shape / np.sqrt(shape @ mass @ shape)
        for _ in range(2):
            left = left - chosen @ (chosen.T @ (mass @ left))
        own = float(np.sqrt(left @ mass @ left))
        if own > DEPENDENT:
            chosen = np.column_stack([chosen, left / own])
        if chosen.shape[1] == most:
            break
    return chosen
