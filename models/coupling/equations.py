"""Equations of motion of modes of bladed disk and casing, coupled by springs: Eqs (8)-(21).

Springs of stiffness kappa per radian connect the casing and the tips of the bladed disk at every
static angle theta = alpha + Omega t.
Their energy kappa/2 int (w - u)^2 dtheta, Eq. (8), splits into nodal diameters k. Let A_k (casing)
and B_k (bladed disk) contain the cosine and the sine part of the radial displacement of each mode,
and let R(k Omega t) be the rotation of these two parts. The equations of motion are

    x'' + (D + Omega G) x' + (diag(omega^2) + Omega^2 K1 + K*(t)) x = 0,
    K*(t) = sum_k f_k kappa C_k^T C_k,    C_k = A_k - R(k Omega t) B_k,

with f_0 = 2 pi and f_k = pi for k > 0. G and K1 are the matrices of the rotation (see
`structure.rotating`) in coordinates of the modes at rest. Stationary shaft springs of unequal
stiffness add `anisotropy` times X^T X - Y^T Y to the stiffness, where X and Y are the displacements
of the centre along the static axes.

For each turn of the rotor, exp(Omega t J) rotates the cosine-sine pairs of the casing by k turns
more than those of the bladed disk. If A_k, B_k, D, G and K1 commute with J and there is no
anisotropy, the frame x = exp(Omega t J) y makes the equations autonomous:

    y'' + (D + Omega (2 J + G)) y' + (K(0) + Omega^2 (J^2 + K1 + G J) + Omega D J) y = 0.

Equation (16) is the frame in which the casing turns by k/2 and the bladed disk by -k/2. The
printed Eq. (9) does not follow from Eq. (8): the printed equation does not couple the two rotor
pairs, has the modal mass of the wrong row in its off-diagonal blocks, and lacks the factor pi,
which is kept here unless `with_pi` is false. In the printed Eq. (18) the gyroscopic block of q5, q6
has the sign of the other blocks; derived from Eq. (16), it has the opposite sign. Modal damping is
added here.
"""

from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray, IntArray
from bladewhirl.meshes.plane import rotate
from bladewhirl.models.structure.rotating import Rotating

Matrix = TypeVar("Matrix", FloatArray, ComplexArray)


@dataclass(frozen=True, kw_only=True)
class CoupledEquations:
    """Mass-normalised equations of motion of modes that are coupled by springs."""

    name: tuple[str, ...]  #: names for tables; modes may share a name
    structure: Rotating[FloatArray]
    """Both bodies without the springs, in mass-normalised modes, (modes, modes)."""
    harmonics: IntArray  #: nodal diameters k of the radial waves, (harmonics,)
    casing: FloatArray  #: A_k: cosine, sine part on the casing [kg^-1/2], (harmonics, 2, modes)
    rotor: FloatArray  #: B_k: cosine, sine part at tips in rotating axes, (harmonics, 2, modes)
    turning: FloatArray | None  #: J, (modes, modes); None if no autonomous frame exists
    centre: FloatArray | None = None
    """x and y of the centre in rotating axes [kg^-1/2], (2, modes); used by the anisotropy only."""
    anisotropy: float = 0.0  #: half the difference of the stationary shaft springs [N/m]
    pairs: bool = False
    """True if modes are pairs, cosine before sine, and all matrices commute with J."""
    with_pi: bool = True
    """Keep the factor pi of the integral in Eq. (8); false gives the paper's eps = kappa / m."""

    @property
    def blocks(self) -> tuple["CoupledEquations", ...]:
        """Independent sets of equations; here a single set with all equations."""
        return (self,)

    def drag(self, speed: ArrayLike) -> FloatArray:
        """Return D + Omega G at speeds [rad/s] of any shape (...): (..., modes, modes) [1/s]."""
        return self.structure.drag(np.asarray(speed)[..., None, None])

    @property
    def factors(self) -> FloatArray:
        """Integrals of cos^2(k theta) over a turn, (harmonics,); divided by pi if not `with_pi`."""
        return wave_integrals(self.harmonics, with_pi=self.with_pi)

    def springs(self, angle: ArrayLike, kappa: float) -> FloatArray:
        """Return K* at angles Omega t of any shape (...), as (..., modes, modes) [1/s^2].

        Args:
            angle: Omega t [rad].
            kappa: stiffness of the springs between the bodies [N/m] per radian.
        """
        rows = self.casing, self.rotor
        return spring_stiffness(*rows, self.harmonics, kappa * self.factors, angle)

    def stiffness(self, angle: ArrayLike, kappa: float, *, speed: ArrayLike = 0.0) -> FloatArray:
        """Return the stiffness matrix of the coordinates x; see `springs` for the arguments.

        ``speed``, Omega [rad/s], only scales the change of the stiffness, Omega^2 K1.
        """
        stiffness = self.springs(angle, kappa) + self.structure.stiffness_at(np.asarray(speed))
        if self.centre is not None:
            stiffness += self.anisotropy * difference_of_axes(self.centre, angle)
        return stiffness

    def autonomous(self, speed: ArrayLike, kappa: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return the matrices of y' and y in the frame that makes the equations autonomous.

        Args:
            speed: Omega [rad/s].
            kappa: spring stiffness [N/m]; broadcasts with speed to the shape (...).

        Returns:
            the matrix of y' [1/s] and the matrix of y [1/s^2], (..., modes, modes) each.

        Raises:
            ValueError: no frame makes the equations autonomous, and the speed is not zero.
        """
        speed, kappa = np.broadcast_arrays(speed, kappa)
        omega = np.asarray(speed, dtype=np.float64)[..., None, None]
        if self.turning is None and np.any(speed):
            raise ValueError("no frame makes the equations of this stage autonomous")
        structure = self.structure
        turn = np.zeros_like(structure.mass) if self.turning is None else self.turning
        unit_springs = self.springs(0.0, 1.0)
        stiffness = self.stiffness(0.0, 0.0, speed=omega) + kappa[..., None, None] * unit_springs
        # The frame turns: (D + Omega G) Omega J and Omega^2 J^2 act on y.
        stiffness = stiffness + omega**2 * (turn @ turn) + omega * (structure.drag(omega) @ turn)
        return self.drag(speed) + 2.0 * omega * turn, stiffness

    def state_matrix(self, speed: ArrayLike, kappa: ArrayLike) -> FloatArray:
        """Return the matrix of the first-order system for (y, y'), (..., 2 * modes, 2 * modes).

        This is the negative of A in Eq. (21), so that a positive real part means growth.
        """
        drag, stiffness = self.autonomous(speed, kappa)
        return companion(-stiffness, -drag)

    def whirl_matrix(self, speed: ArrayLike, kappa: ArrayLike) -> FloatArray | ComplexArray:
        """Return the matrix of half size for cosine-sine pairs, (..., modes, modes) [rad/s].

        The eigenvalues are the mu of z = y_c + i y_s = X exp(i mu t), and the first half of each
        eigenvector is X. The matrix is real if there is no damping and the bladed disk has mirror
        symmetry.
        """
        drag, stiffness = (
            np.asarray(part[..., ::2, ::2] + 1j * part[..., 1::2, ::2], dtype=np.complex128)
            for part in self.autonomous(speed, kappa)
        )
        unit = float(np.sqrt(np.abs(np.diag(self.structure.stiffness)).max())) or 1.0
        matrix = companion(stiffness, np.asarray(1j * drag, dtype=np.complex128), unit)
        return matrix if matrix.imag.any() else matrix.real

    def in_body_axes(
        self, y: FloatArray, rate: FloatArray, *, speed: float, time: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return x and dx/dt from the coordinates y of the autonomous frame, (times, modes) each.

        Args:
            y: coordinates in the autonomous frame, (times, modes).
            rate: dy/dt.
            speed: Omega [rad/s].
            time: instants [s], (times,).
        """
        turn = np.zeros_like(self.structure.mass) if self.turning is None else speed * self.turning
        phase = np.multiply.outer(time, np.sqrt(-np.diag(turn @ turn)))
        cosine, quarter = np.cos(phase), time[:, None] * np.sinc(phase / np.pi)
        x, rotated = (cosine * part + quarter * (part @ turn.T) for part in (y, rate))
        return x, rotated + x @ turn.T


def companion(by_position: Matrix, by_rate: Matrix, unit: float = 1.0) -> Matrix:
    """Return the first-order matrix of x'' = by_position x + by_rate x', (..., 2 n, 2 n).

    The state is (unit x, x').

    Args:
        by_position: matrix that multiplies x, (..., n, n).
        by_rate: matrix that multiplies x', (..., n, n), broadcast with `by_position`.
        unit: a typical frequency [rad/s], so that both halves of the state have similar sizes.
    """
    n = by_position.shape[-1]
    state = np.zeros((*by_position.shape[:-2], 2 * n, 2 * n), dtype=by_position.dtype)
    state[..., :n, n:] = unit * np.eye(n)
    state[..., n:, :n] = by_position / unit
    state[..., n:, n:] = by_rate
    return state


def wave_integrals(harmonics: IntArray, *, with_pi: bool) -> FloatArray:
    """Return the integral f_k of cos^2(k theta) over a turn for nodal diameters k, (harmonics,);
    divided by pi if not `with_pi`."""
    return (np.pi if with_pi else 1.0) * np.where(harmonics == 0, 2.0, 1.0)


def spring_stiffness(
    casing: FloatArray,
    rotor: FloatArray,
    harmonics: IntArray,
    factors: FloatArray,
    angle: ArrayLike,
) -> FloatArray:
    """Return K* at angles Omega t of any shape (...), as (..., modes, modes) [1/s^2].

    Args:
        casing: A_k of all modes [kg^-1/2], (harmonics, 2, modes).
        rotor: B_k of all modes [kg^-1/2], (harmonics, 2, modes).
        harmonics: nodal diameters k, (harmonics,).
        factors: f_k kappa [N/m], (harmonics,).
        angle: Omega t [rad].
    """
    angle = np.asarray(angle, dtype=np.float64)
    turn = np.multiply.outer(angle, harmonics)
    stretch = casing - rotate(np.eye(2), -turn[..., None]) @ rotor
    rows = (np.sqrt(factors)[:, None, None] * stretch).reshape(
        *angle.shape, 2 * len(harmonics), casing.shape[-1]
    )
    return np.asarray(np.swapaxes(rows, -1, -2) @ rows)


def difference_of_axes(centre: FloatArray, angle: ArrayLike) -> FloatArray:
    """Return X^T X - Y^T Y, where the rows X and Y are the displacements of the centre along the
    static axes in each mode, (..., modes, modes) [1/kg].

    Args:
        centre: x and y of the centre in rotating axes [kg^-1/2], (2, modes).
        angle: Omega t [rad], any shape (...).
    """
    moved = rotate(np.eye(2), -np.asarray(angle, dtype=np.float64)[..., None]) @ centre
    squares = moved[..., :, None] * moved[..., None, :]
    return np.asarray(squares[..., 0, :, :] - squares[..., 1, :, :])
