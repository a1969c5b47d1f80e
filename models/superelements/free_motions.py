"""Rigid motions of a free rotor in its modes, whose momentum a march keeps.

The rigid motions B, uniform displacements and tilts, are at rest in static axes if they turn
backward in rotating axes, B R(-psi) with the rotation R by the angle psi in their pairs. With the
symbols of `structure.rotating` and R(psi)' = J R(psi) psi' they satisfy

    (K + Omega^2 K1) B = Omega^2 (M B + G B J) = Omega^2 (P B - M B),   P B = 2 M B + G B J,

with the polar inertia P. Momentum is the product of B R(-psi) with any other motion. Central
differences keep it if they are those of static axes on B, see `shaft_line.reduced`: for the angle a
of a time step

    M' B = M B cos a + P B (a sin a) / 2,   G' B J = -2 M B sin(a) / a + P B cos a,
    K1' B = P B sin(a) / a - 2 M B (1 - cos a) / a^2.

The matrices in the modes are changed on B alone, each by the smallest symmetric or skew matrix. The
changes are of the order a^2, as are the errors of central differences. With K2, B moves the
structure as the rotation deforms it, which follows from the modes.
"""

from typing import Any, NamedTuple

import numpy as np
import scipy.linalg as la

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.structure.rotating import Rotating
from bladewhirl.models.superelements.diameters import turned_to_diameters

SLOWEST = 1e-7
"""Smallest angle of a time step [rad] at which central differences differ from the rotation by more
than rounding."""

DEFORMED = 0.1
"""Largest part of a rigid motion by which the structure is deformed; a larger one is a resonance.
"""


class FreeMotions(NamedTuple):
    """Rigid motions that the modes of a free rotor are to contain."""

    motions: FloatArray
    """Displacements along x and y, then tilts towards x and y if all wheels tilt, (n, 2 or 4)."""
    angle: float  #: angle a by which the rotor turns in a time step [rad]

    def within(
        self, mass: Any, squares: FloatArray, shapes: Any, moved: Any, loads: Any
    ) -> tuple[Any, Any]:
        """Return modes, changed as little as possible to contain the motions, and the static
        displacements under loads without some part in them, (n, m) each.

        Args:
            mass: mass matrix, (n, n).
            squares: squared frequencies of the modes [rad2/s2].
            shapes: mass-normalised modes, (n, modes).
            moved: static displacements under the loads without their part in the modes, (n, loads).
            loads: loads, (n, loads).
        """
        inside = shapes.T @ (mass @ self.motions)
        change = (self.motions - shapes @ inside) @ np.linalg.pinv(inside)
        moved = moved - change @ (shapes.T @ loads / squares[:, None])
        shapes = shapes + change
        lower = np.linalg.cholesky(shapes.T @ (mass @ shapes))
        return la.solve_triangular(lower, shapes.T, lower=True).T, moved

    def settled(
        self, part: Any, shapes: FloatArray, moved: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray, dict[str, FloatArray]]:
        """Return squared frequencies, modes and the static displacements without a part in them,
        and the changes of `gyroscopic` and `stiffness_speed` on the modes, by name.

        Args:
            part: the rotor at a speed, a `Superelement`.
            shapes: shapes that contain the motions, (n, modes).
            moved: static displacements without some part in the shapes, (n, loads).
        """
        omega, stiff = part.speed, part.stiffness @ shapes
        on_shapes = Rotating(
            mass=np.eye(shapes.shape[1]),
            stiffness=shapes.T @ stiff,
            gyroscopic=shapes.T @ (part.gyroscopic @ shapes),
        )
        change = self._change(on_shapes, shapes.T @ (part.mass @ self.motions), omega)
        squares, turn = la.eigh(
            on_shapes.stiffness + omega**2 * change.known("stiffness_speed"),
            on_shapes.mass + change.mass,
        )
        contact = part.contact_rows @ (shapes @ turn)
        turn = turned_to_diameters(squares, turn, contact, part.contact_angle)
        pulled = turn.T @ (stiff.T @ moved) / squares[:, None]
        shapes = shapes @ turn
        changes = change.projected(turn, ("gyroscopic", "stiffness_speed"))
        return squares, shapes, moved - shapes @ pulled, changes

    def _change(
        self, rotor: Rotating[FloatArray], inside: FloatArray, omega: float
    ) -> Rotating[FloatArray]:
        """Return the changes of mass, `gyroscopic` and `stiffness_speed`.

        Args:
            rotor: matrices on the shapes, (m, m).
            inside: the motions as coordinates of the shapes, (m, 2 or 4).
            omega: speed [rad/s].
        """
        spin, stiffness = rotor.known("gyroscopic"), rotor.stiffness
        backward = inside[:, 0::2] + 1j * inside[:, 1::2]
        backward = backward + self._deformed(rotor, backward, omega)
        motions, turned = _pairs(backward), _pairs(-1j * backward)  # B and B J
        polar = 2.0 * motions + spin @ turned
        cosine, sine = np.cos(self.angle), np.sinc(self.angle / np.pi)
        chord = np.sinc(self.angle / (2.0 * np.pi)) ** 2
        mass = cosine * motions + 0.5 * self.angle**2 * sine * polar
        across = -2.0 * sine * motions + cosine * polar
        softer = sine * polar - chord * motions
        return Rotating(
            mass=_smallest(mass - motions, motions, 1.0),
            stiffness=0.0 * stiffness,
            gyroscopic=_smallest(_back(across) - spin @ motions, motions, -1.0),
            stiffness_speed=_smallest(softer - stiffness @ motions / omega**2, motions, 1.0),
        )

    def _deformed(self, rotor: Rotating[FloatArray], backward: Any, omega: float) -> Any:
        """Return by how much the rotation deforms the structure with the motions."""
        size, count = backward.shape
        dynamic = rotor.stiffness - omega**2 * (rotor.mass - 1j * rotor.known("gyroscopic"))
        edge, border = np.zeros((count, count)), omega**2 * backward
        bordered = np.block([[dynamic, border], [border.conj().T, edge]])
        found = np.linalg.solve(bordered, np.vstack([-dynamic @ backward, edge]))[:size]
        return found if la.norm(found) < DEFORMED * la.norm(backward) else np.zeros_like(found)


def _pairs(backward: Any) -> FloatArray:
    """Return real and imaginary parts of columns as pairs of columns."""
    return np.asarray(np.stack([backward.real, backward.imag], axis=2).reshape(len(backward), -1))


def _back(turned: FloatArray) -> FloatArray:
    """Return X for X J."""
    return _pairs(1j * (turned[:, 0::2] + 1j * turned[:, 1::2]))


def _smallest(product: FloatArray, motions: FloatArray, sign: float) -> FloatArray:
    """Return a symmetric (sign 1) or skew (sign -1) matrix with a product with motions."""
    dual = motions @ np.linalg.inv(motions.T @ motions)
    change, twice = product @ dual.T, motions.T @ product
    both = 0.5 * (twice + sign * twice.T)
    return np.asarray(change + sign * change.T - dual @ both @ dual.T)
