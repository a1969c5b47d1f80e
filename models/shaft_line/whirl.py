"""Whirling modes, critical speeds and steady motions of a shaft line.

Eigenvalues are those of the inverse of the linearised equations, so that rounding is small beside
the lowest ones. A mode moves the unknowns by

    z = f exp(s t) + b exp(conj(s) t)

with the eigenvalue s, whose imaginary part is not negative: f whirls counter-clockwise, b
clockwise.
"""

import warnings
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import scipy.linalg as la

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray, IntArray
from bladewhirl.models.shaft_line.line import LineModel

Direction = Literal["forward", "backward", "planar"]

OVERDAMPED = 0.05
"""Imaginary part of an eigenvalue, as a fraction of its absolute value, below which a motion decays
rather than whirls. Internal damping lets the shortest waves of a shaft decay while they turn with
it."""

SAME = 1e-9  #: relative difference of eigenvalues below which they are a pair

CONSERVATIVE = 1e-13
"""Matrices have damping or circulatory forces if these are a larger fraction of their entries."""

ALIKE = 1e-6  #: relative difference of forward and backward part below which a mode is planar

TRIALS, WIDER = 40, 1.3
"""Largest number of intervals, each larger than the last by this factor, in which the speed is
sought at which a mode whirls with it."""

PRECISION = 1e-12  #: relative precision of a critical speed

JUMP = 1e-6
"""Relative difference of frequency and speed that remains where the number of a mode changes
because another one is overdamped; this is no critical speed."""


@dataclass(frozen=True, kw_only=True)
class LineModes:
    """Whirling modes of a shaft line at a speed, by rising frequency."""

    speed: float  #: speed of rotation [rad/s]
    eigenvalue: ComplexArray  #: decay rate (negative) plus i times frequency [rad/s], (modes,)
    left: ComplexArray  #: counter-clockwise part f of the unknowns, (modes, n)
    right: ComplexArray  #: clockwise part b, (modes, n)

    def take(self, rows: IntArray) -> "LineModes":
        """Return some of the modes."""
        parts = {name: getattr(self, name)[rows] for name in ("eigenvalue", "left", "right")}
        return LineModes(speed=self.speed, **parts)

    @property
    def direction(self) -> tuple[Direction, ...]:
        """Direction in which most of the line whirls, of each mode: that of the rotation is
        forward; at rest, counter-clockwise is."""
        left, right = (np.linalg.norm(each, axis=1) for each in (self.left, self.right))
        ahead, back = (left, right) if self.speed >= 0.0 else (right, left)
        planar = np.abs(ahead - back) <= ALIKE * (ahead + back)
        names = np.where(planar, "planar", np.where(ahead > back, "forward", "backward"))
        return tuple(names.tolist())


def line_modes(line: LineModel, omega: float, count: int | None = None) -> LineModes:
    """Return the lowest modes that whirl, at a speed [rad/s].

    A pair of modes of equal frequency, as of a round line at rest, consists of a forward and a
    backward one.

    Args:
        line: the shaft line.
        omega: speed of rotation [rad/s].
        count: number of modes; all if None.
    """
    motions = all_motions(line, omega)
    found, left = motions.eigenvalue, motions.left
    whirls = np.flatnonzero(found.imag > OVERDAMPED * np.abs(found))
    rows = whirls[np.argsort(found[whirls].imag, kind="stable")]
    for one in np.flatnonzero(
        line.is_round & (np.abs(np.diff(found[rows])) < SAME * np.abs(found[rows[1:]]))
    ):
        rows[one : one + 2] = sorted(rows[one : one + 2], key=lambda row: not left[row].any())
    modes = motions.take(rows[:count])
    return modes if line.is_round else _separated(modes)


def all_motions(line: LineModel, omega: float) -> LineModes:
    """Return all free motions at a speed [rad/s], in no order, with those that decay or grow
    without a whirl."""
    if line.is_round:
        found, vectors = _eigenpairs(line.forms(omega), line.reference_frequency)
        ahead = found.imag > 0.0
        left, right = (np.where(each, vectors, 0.0) for each in (ahead, ~ahead))
        found = np.where(ahead, found, found.conj())
    else:
        found, vectors = _eigenpairs(line.matrices(omega), line.reference_frequency)
        once = found.imag >= 0.0  # of conjugates
        found, (x, y) = found[once], np.split(vectors[:, once], 2)
        left, right = (x + 1j * y) / 2.0, (x.conj() + 1j * y.conj()) / 2.0
    return LineModes(speed=omega, eigenvalue=found, left=left.T, right=right.T)


def _separated(modes: LineModes) -> LineModes:
    """Return modes of which pairs of equal frequency whirl in one direction each, not in both."""
    left, right, s = modes.left.copy(), modes.right.copy(), modes.eigenvalue
    for one in np.flatnonzero(np.abs(np.diff(s)) < SAME * np.abs(s[:-1])):
        both = np.stack([left[one : one + 2], right[one : one + 2].conj()])
        largest = np.abs(both).max(axis=(1, 2))
        if (largest < ALIKE * largest.max()).any():
            continue
        for part, other in ((0, 1), (1, 0)):  # combination without the other part
            weights = la.svd(both[other].T)[2][-1].conj()
            mixed = np.tensordot(weights, both, axes=(0, 1))
            left[one + part], right[one + part] = mixed[0], mixed[1].conj()
    return LineModes(speed=modes.speed, eigenvalue=s, left=left, right=right)


def _eigenpairs(
    matrices: tuple[ComplexArray | FloatArray, ...], scale: float
) -> tuple[ComplexArray, ComplexArray]:
    """Return the eigenvalues of mass, damping and stiffness, (n, n) each, and their vectors as
    columns, (n, modes); `scale` is a frequency that makes velocities comparable [rad/s]."""
    mass, damping, stiffness = matrices
    factor, one = la.lu_factor(stiffness), np.eye(len(mass))
    inverse, vectors = la.eig(
        np.block(
            [
                [-la.lu_solve(factor, damping), -la.lu_solve(factor, mass) * scale],
                [one / scale, np.zeros_like(one)],
            ]
        )
    )
    found = np.abs(inverse) > 0.0
    values = conserved(1.0 / inverse[found], damping, stiffness)
    return values, vectors[: len(mass), found]


def conserved(
    values: ComplexArray, damping: ComplexArray | FloatArray, stiffness: ComplexArray | FloatArray
) -> ComplexArray:
    """Return eigenvalues without real parts that are rounding errors, because the matrices, (n, n)
    each, have only gyroscopic and conservative forces."""
    lost, driven = damping + damping.conj().T, stiffness - stiffness.conj().T
    for part, whole in ((lost, damping), (driven, stiffness)):
        if abs(part).max() > CONSERVATIVE * abs(whole).max():
            return values
    still = np.abs(values.real) < SAME * np.abs(values)
    return np.where(still, 0.0 + 1j * values.imag, values)


@dataclass(frozen=True, kw_only=True)
class LineCriticalSpeeds:
    """Speeds at which a mode whirls with the rotation, ascending."""

    speed: FloatArray  #: speed of rotation [rad/s], (speeds,)
    modes: tuple[LineModes, ...]  #: the mode at each speed

    @property
    def decay(self) -> FloatArray:
        """Real part of the eigenvalue at each speed [1/s], (speeds,)."""
        return np.array([each.eigenvalue[0].real for each in self.modes])

    @property
    def direction(self) -> tuple[Direction, ...]:
        """Direction of whirl at each speed."""
        return tuple(each.direction[0] for each in self.modes)


def line_critical_speeds(line: LineModel, count: int) -> LineCriticalSpeeds:
    """Return the lowest speeds at which the frequency of a mode equals the speed of rotation.

    The modes are numbered by their frequency, which depends on the speed continuously for each
    number. A mode whose frequency rises as fast as the speed has no critical speed.

    Args:
        line: the shaft line.
        count: number of modes at rest that are followed.
    """

    from scipy.optimize import brentq  # long to load

    def apart(omega: float, number: int) -> float:
        return float(line_modes(line, omega, number + 1).eigenvalue[-1].imag - omega)

    speeds: list[tuple[float, int]] = []
    for number, start in enumerate(line_modes(line, 0.0, count).eigenvalue.imag):
        low, high = 0.0, float(start) * (1.0 + 1e-6)
        for _ in range(TRIALS):
            if apart(high, number) <= 0.0:
                found = brentq(apart, low, high, (number,), PRECISION * high, 4e-16 + PRECISION)
                if abs(apart(found, number)) < JUMP * found:
                    speeds.append((float(found), number))
                break
            low, high = high, high * WIDER
    speeds.sort()
    at = tuple(line_modes(line, omega, n + 1).take(np.array([n])) for omega, n in speeds)
    return LineCriticalSpeeds(speed=np.array([omega for omega, _ in speeds]), modes=at)


def unbalance_response(line: LineModel, omega: float) -> tuple[ComplexArray, ComplexArray]:
    """Return the parts f and b of the motion z = f exp(i Omega t) + b exp(-i Omega t) that the
    unbalances of the case cause at a speed [rad/s], (n,) each.

    Raises:
        LinAlgError: the speed is a critical speed of a line without damping.
    """
    force = omega**2 * line.unbalance_force(line.table.unbalance)
    return driven(line, omega, omega, force)


def driven(
    line: LineModel, omega: float, rate: float, force: ComplexArray
) -> tuple[ComplexArray, ComplexArray]:
    """Return the parts f and b of the motion z = f exp(i w t) + b exp(-i w t) under forces F exp(i
    w t), (n,) each.

    Args:
        line: the shaft line.
        omega: speed of rotation [rad/s].
        rate: w [rad/s], of any sign.
        force: F [N, N m], (n,).

    Raises:
        LinAlgError: w is the frequency of a mode without damping.
    """
    mass, damping, stiffness = line.matrices(omega)
    dynamic = stiffness + 1j * rate * damping - rate**2 * mass
    x, y = np.split(solved(dynamic, np.concatenate([force, -1j * force])), 2)
    return (x + 1j * y) / 2.0, (x.conj() + 1j * y.conj()) / 2.0


def solved(dynamic: Any, force: Any) -> ComplexArray:
    """Return the solution of linear equations.

    Raises:
        LinAlgError: they are singular to rounding.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("error", la.LinAlgWarning)
        try:
            return np.asarray(la.solve(dynamic, force))
        except la.LinAlgWarning:
            raise la.LinAlgError("the matrix is singular to rounding") from None


def sag(line: LineModel, omega: float) -> ComplexArray:
    """Return the static unknowns under gravity at a speed of rotation [rad/s], (n,).

    Only internal damping makes them depend on the speed.
    """
    assert line.case.gravity is not None
    force = line.weight(complex(*line.case.gravity.acceleration))
    stiffness = line.matrices(omega)[2]
    x, y = np.split(la.solve(stiffness, np.concatenate([force.real, force.imag])), 2)
    return np.asarray(x + 1j * y)
