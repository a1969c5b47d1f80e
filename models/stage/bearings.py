"""Bearings between a rotor and the ground or supports, with springs and dampers in static axes.

Forces and displacements along x and y are the real and the imaginary parts of complex numbers. A
matrix has the parts k_0 and k_2 of K u = k_0 z + k_2 conj(z), see `models.shaft_line.line`. In
rotating axes k_0 is constant, and k_2 is multiplied by exp(-2 i psi) at the angle psi of the rotor.
"""

from dataclasses import dataclass

import numpy as np

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray


@dataclass(frozen=True, kw_only=True)
class ShaftLineMotion:
    """What is recorded of a shaft line in a march."""

    nodes: ComplexArray
    """Deflection and slope of each node for unit modal coordinates, rotating axes [kg^-1/2],
    (nodes, 2, rotor modes)."""
    along: FloatArray
    """Displacement along the axis and rotation about it of each node [kg^-1/2], (nodes, 2, rotor
    modes)."""
    stiffness: FloatArray
    """Stiffness of the shaft without rotation [rad2/s2], (rotor modes, rotor modes)."""
    bearings: int  #: number of bearings of the case, which precede tilt springs and supports

    def displacement(self, angle: FloatArray, rotor: FloatArray) -> FloatArray:
        """Return displacements and rotations of the nodes in static axes [m, rad], (records, nodes,
        6).

        Args:
            angle: angle of the rotor [rad], (records,).
            rotor: modal displacements, (records, rotor modes).
        """
        moved, slope = np.moveaxis(self.nodes @ rotor.T, 0, 2) * np.exp(1j * angle)[:, None]
        along, about = np.moveaxis(self.along @ rotor.T, 0, 2)
        each = (moved.real, moved.imag, along, -slope.imag, slope.real, about)
        return np.stack(each, axis=2)


@dataclass(frozen=True, kw_only=True)
class Bearings:
    """Bearings in modal coordinates; against tilt they have slopes in place of displacements."""

    rotor: ComplexArray
    """Displacement of the rotor for unit modal coordinates, rotating axes [kg^-1/2], (bearings,
    rotor modes)."""
    support: ComplexArray
    """Displacement of the supports, static axes [kg^-1/2], (bearings, casing modes)."""
    stiffness: ComplexArray  #: parts of the stiffness [N/m], (bearings, 2)
    damping: ComplexArray  #: parts of the damping [N s/m], (bearings, 2)
    shaft: "ShaftLineMotion | None" = None  #: what is recorded of a shaft line

    def force(
        self,
        angle: FloatArray | float,
        speed: FloatArray | float,
        rotor: tuple[FloatArray, FloatArray],
        casing: tuple[FloatArray, FloatArray],
    ) -> ComplexArray:
        """Return the forces of the bearings on the rotor in static axes [N], (..., bearings).

        Args:
            angle: angle of the rotor [rad], (...).
            speed: speed of rotation [rad/s], (...).
            rotor: modal displacements and velocities of the rotor, (..., rotor modes) each.
            casing: the same of the casing, (..., casing modes) each.
        """
        (k0, k2), (c0, c2) = self.stiffness.T, self.damping.T
        moved, moves = (self.stretch(angle, rotor[n], casing[n]) for n in range(2))
        turned = 1j * np.asarray(speed) * np.exp(1j * np.asarray(angle))
        moves = moves + turned[..., None] * (rotor[0] @ self.rotor.T)
        return np.asarray(-(k0 * moved + k2 * moved.conj() + c0 * moves + c2 * moves.conj()))

    def stretch(
        self, angle: FloatArray | float, rotor: FloatArray, casing: FloatArray
    ) -> ComplexArray:
        """Return the displacements of the rotor relative to the supports in static axes [m], (...,
        bearings), for modal displacements as in `force`."""
        turn = np.exp(1j * np.asarray(angle))[..., None]
        return np.asarray((rotor @ self.rotor.T) * turn - casing @ self.support.T)

    @property
    def equal(self) -> bool:
        """True if all act alike in all directions, so that they are constant in rotating axes."""
        return not (np.any(self.stiffness[:, 1]) or np.any(self.damping[:, 1]))

    def in_rotating_axes(self, speed: float, supports: int) -> tuple[FloatArray, FloatArray]:
        """Return stiffness [rad2/s2] and damping [1/s] of equal bearings on the rotor modes and, in
        rotating axes, on the last casing modes, which are the supports, (n, n) each.

        Args:
            speed: speed of rotation [rad/s].
            supports: number of supports.
        """
        first = self.support.shape[1] - 2 * supports
        rows = np.hstack([self.rotor, -self.support[:, first:]])
        k0, c0 = self.stiffness[:, 0], self.damping[:, 0]
        both = (k0 + 1j * speed * c0, c0)
        stiffness, damping = ((rows.conj().T * each @ rows).real for each in both)
        return stiffness, damping

    def energy(
        self, angle: FloatArray | float, rotor: FloatArray, casing: FloatArray
    ) -> FloatArray:
        """Return the energy of the springs [J], (...), for modal displacements as in `force`."""
        moved = self.stretch(angle, rotor, casing)
        pull = self.stiffness[:, 0].real * moved + self.stiffness[:, 1] * moved.conj()
        return np.asarray(0.5 * (moved.conj() * pull).real.sum(axis=-1))

    def pulls(self, angle: float, force: ComplexArray) -> tuple[FloatArray, FloatArray]:
        """Return the modal forces on rotor and casing of forces on the rotor in static axes,
        (bearings,)."""
        turned = force * np.exp(-1j * angle)
        return (turned @ self.rotor.conj()).real, -(force @ self.support.conj()).real

    def torque(self, angle: float, rotor: FloatArray, force: ComplexArray) -> float:
        """Return the torque of these forces on the rotation [N m] for modal displacements of the
        rotor, (rotor modes,)."""
        place = (self.rotor @ rotor) * np.exp(1j * angle)
        return float((place.conj() * force).imag.sum())

    def highest_frequency(self, rotor: FloatArray, casing: FloatArray) -> float:
        """Return an upper bound of the frequencies of rotor and casing with the bearings [rad/s],
        for squared frequencies without them, (rotor modes,) and (casing modes,)."""
        rows = np.hstack([self.rotor, -self.support])
        size = self.stiffness[:, 0].real + np.abs(self.stiffness[:, 1])
        stiffness = np.diag(np.concatenate([rotor, casing]))
        stiffness = stiffness + ((rows.conj().T * size) @ rows).real
        return float(np.sqrt(max(np.linalg.eigvalsh(stiffness)[-1], 0.0)))
