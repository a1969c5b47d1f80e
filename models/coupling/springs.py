"""Springs between rotor and casing, for the frame and the bearings: Eqs (4)-(10).

A spring of stiffness kappa per radian joins casing and rotor at every static angle theta. With

    w(theta)   = sum_i a_i (v_ci cos k_i theta + v_si sin k_i theta)             on the casing
    u(alpha)   = sum_j a_j (u_cj cos k_j alpha + u_sj sin k_j alpha)             on the rotor

alpha = theta - Omega t and mass-normalised modes, the energy kappa/2 int (w - u)^2 dtheta of
Eq. (8) splits into nodal diameters, since cosines of different k are orthogonal on the circle:

    K*(t) = sum_k f_k kappa C_k(t)^T C_k(t),    f_0 = 2 pi, f_k = pi otherwise,

where the two rows of C_k give the cos k theta and sin k theta part of w - u. The paper's system,
Eq. (9), is the case of one casing and two rotor pairs, all with k = 1 and a = 1 (`paper_modes`).

We differ from the printed Eq. (9) where it does not follow from Eq. (8): as printed it does not
couple the two rotor pairs, has the modal mass of the wrong row in its off-diagonal blocks, and
lacks the factor pi, which we keep unless `with_pi` is false.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from bladewhirl.meshes.line_mesh import BoolArray, FloatArray, IntArray
from bladewhirl.models.coupling.turning_rotor import TurningRotor

ANGLES = 181
"""Angles at which springs are looked at where their stiffness changes as the rotor turns."""


@dataclass(frozen=True, kw_only=True)
class CouplingModes:
    """Modes that the springs couple: each entry is a cosine/sine pair or a single mode.

    The real coordinates stand entry by entry, cosine before sine, so that the paper's system is
    (v_c, v_s, u_c, u_s, u_co, u_so). Arrays are made read-only.

    Raises:
        ValueError: arrays of different length, non-finite or negative values, a pair with k = 0,
            or single modes on both bodies with the same k > 0 (no frame makes these autonomous).
    """

    name: tuple[str, ...]  #: what to call each entry, for tables and legends
    on_casing: BoolArray  #: body of each entry: casing, otherwise rotor, (entries,)
    nodal_diameter: IntArray  #: k of each entry, (entries,)
    frequency: FloatArray
    """Natural frequency of each entry, uncoupled [rad/s], (entries,); negative where its square
    is, past a critical speed."""
    amplitude: FloatArray  #: radial amplitude at the springs [kg^-1/2], (entries,)
    damping_ratio: FloatArray  #: modal damping ratio of each entry, (entries,)
    paired: BoolArray  #: whether the entry is a cosine/sine pair, (entries,)
    turning: TurningRotor | None = None  #: what rotation adds; None without its effects

    def __post_init__(self) -> None:
        kinds: dict[str, Any] = {"on_casing": bool, "paired": bool, "nodal_diameter": np.int64}
        object.__setattr__(self, "name", tuple(self.name))
        for item in fields(self)[1:-1]:
            array = np.array(getattr(self, item.name), dtype=kinds.get(item.name, np.float64))
            if array.shape != (len(self.name),):
                expected = f"one value for each of {len(self.name)} entries"
                raise ValueError(f"{item.name}: expected {expected}, got shape {array.shape}")
            if not np.all(np.isfinite(array)):
                raise ValueError(f"{item.name}: values must be finite")
            array.setflags(write=False)
            object.__setattr__(self, item.name, array)
        for name in ("nodal_diameter", "damping_ratio"):
            if np.any(getattr(self, name) < 0):
                raise ValueError(f"{name}: values must not be negative")
        if np.any(self.paired & (self.nodal_diameter == 0)):
            raise ValueError("paired: a mode with nodal diameter 0 has no partner")
        for k in self.harmonics:
            single = ~self.paired & (self.nodal_diameter == k)
            if k and np.any(single & self.on_casing) and np.any(single & ~self.on_casing):
                raise ValueError(f"paired: single modes on both bodies with nodal diameter {k}")

    @property
    def entries(self) -> int:
        """Number of entries."""
        return len(self.name)

    @property
    def size(self) -> int:
        """Number of real coordinates: two for a pair, one for a single mode."""
        return int(self.cosine[-1] + 1 + self.paired[-1]) if self.entries else 0

    @property
    def cosine(self) -> IntArray:
        """Position of each entry's cosine (or only) coordinate, (entries,); the sine follows."""
        return np.asarray(np.cumsum(1 + self.paired) - (1 + self.paired), dtype=np.int64)

    @property
    def entry(self) -> IntArray:
        """Entry of each coordinate, (size,)."""
        return np.repeat(np.arange(self.entries), 1 + self.paired)

    @property
    def is_sine(self) -> BoolArray:
        """Whether each coordinate is the sine of a pair, (size,)."""
        return np.asarray(np.arange(self.size) > self.cosine[self.entry])

    @property
    def harmonics(self) -> tuple[int, ...]:
        """Nodal diameters present, ascending; entries of different ones do not couple."""
        return tuple(int(k) for k in np.unique(self.nodal_diameter))

    @property
    def damping_rate(self) -> FloatArray:
        """Modal damping 2 xi omega of each entry [1/s], (entries,)."""
        return np.asarray(2.0 * self.damping_ratio * self.frequency)

    @property
    def frame_rate(self) -> FloatArray:
        """Turns r of each entry's invariant coordinates per turn of the rotor, (entries,)."""
        rate = np.where(self.on_casing, 0.5, -0.5) * self.nodal_diameter
        for k in self.harmonics:
            here = self.nodal_diameter == k
            if np.all(self.paired[here]):
                continue
            kept = bool(np.any(self.on_casing[here & ~self.paired]))  # the body that keeps r = 0
            rate[here] = np.where(self.on_casing[here] == kept, 0.0, 2.0 * rate[here])
        return np.asarray(rate, dtype=np.float64)

    def take(self, chosen: IntArray | BoolArray | Sequence[int]) -> CouplingModes:
        """Keep some entries, by a mask or by positions."""
        kept = np.arange(self.entries)[np.asarray(chosen)]
        arrays = {item.name: getattr(self, item.name)[kept] for item in fields(self)[1:-1]}
        turning = None if self.turning is None else self.turning.take(kept)
        return CouplingModes(name=tuple(self.name[i] for i in kept), turning=turning, **arrays)

    def with_unit_amplitudes(self) -> CouplingModes:
        """Give every mode amplitude one, as the paper does, in the phase that it has."""
        return replace(self, amplitude=np.sign(self.amplitude))

    def harmonic(self, k: int) -> CouplingModes:
        """Keep the entries of nodal diameter k."""
        return self.take(self.nodal_diameter == k)


def paper_modes(
    *, casing: float, first_flexural: float, suspension: float, damping_ratio: float = 0.0
) -> CouplingModes:
    """Make the paper's six-mode system: three k = 1 pairs of unit amplitude (Eqs 4-9).

    Args:
        casing: frequency of the casing's k = 1 pair [rad/s].
        first_flexural: frequency of the bladed disk's 1F, k = 1 pair [rad/s].
        suspension: frequency of the suspension pair [rad/s].
        damping_ratio: modal damping ratio of all three.
    """
    return CouplingModes(
        name=("casing", "1F", "suspension"),
        on_casing=np.array([True, False, False]),
        nodal_diameter=np.ones(3, dtype=np.int64),
        frequency=np.array([casing, first_flexural, suspension]),
        amplitude=np.ones(3),
        damping_ratio=np.full(3, damping_ratio),
        paired=np.ones(3, dtype=np.bool_),
    )


def spring_factor(k: int, *, with_pi: bool = True) -> float:
    """Factor f_k of the modal spring stiffness: int cos^2(k theta) dtheta, or that over pi."""
    return (np.pi if with_pi else 1.0) * (2.0 if k == 0 else 1.0)


def stretch_rows(modes: CouplingModes, k: int, angle: ArrayLike) -> FloatArray:
    """Rows C_k of the springs' stretch w - u: its cos k theta and sin k theta parts.

    Args:
        modes: the coupled modes.
        k: nodal diameter.
        angle: Omega t [rad], any shape (...).

    Returns:
        (..., 2, size) [kg^-1/2], to be multiplied by the coordinates u.
    """
    angle = np.asarray(angle, dtype=np.float64)
    rows = np.zeros((*angle.shape, 2, modes.size))
    cos, sin = np.cos(k * angle), np.sin(k * angle)
    for i in np.flatnonzero(modes.nodal_diameter == k):
        amplitude, first = modes.amplitude[i], modes.cosine[i]
        if modes.on_casing[i]:
            turned = np.broadcast_to(np.array([amplitude, 0.0]), (*angle.shape, 2))
        else:
            turned = -amplitude * np.stack([cos, sin], axis=-1)
        rows[..., first] = turned
        if modes.paired[i]:
            rows[..., 0, first + 1] = -turned[..., 1]
            rows[..., 1, first + 1] = turned[..., 0]
    return rows


def coupling_stiffness(
    modes: CouplingModes, *, kappa: float, angle: ArrayLike, with_pi: bool = True
) -> FloatArray:
    """Stiffness K* of the springs in mass-normalised coordinates, by integration of Eq. (8).

    Args:
        modes: the coupled modes.
        kappa: spring stiffness [N/m] per radian.
        angle: Omega t [rad], any shape (...).
        with_pi: keep the factor pi of the integral; false gives the paper's eps = kappa / m.

    Returns:
        symmetric, (..., size, size) [1/s^2].
    """
    shape = (*np.shape(angle), modes.size, modes.size)
    stiffness = np.zeros(shape)
    for k in modes.harmonics:
        rows = stretch_rows(modes, k, angle)
        stiffness += spring_factor(k, with_pi=with_pi) * kappa * np.swapaxes(rows, -1, -2) @ rows
    return stiffness


@dataclass(frozen=True, kw_only=True)
class CouplingSprings:
    """Springs between two modal bodies: which of their modes they couple, and how stiffly."""

    modes: CouplingModes
    number: IntArray  #: of each entry's mode among those of its body; a sine follows, (entries,)
    kappa: float  #: stiffness [N/m] per radian
    with_pi: bool = True  #: keep the factor pi of the integral in Eq. (8)

    @property
    def factors(self) -> FloatArray:
        """Modal spring stiffness f_k kappa of each nodal diameter [N/m], (harmonics,)."""
        factors = [spring_factor(k, with_pi=self.with_pi) for k in self.modes.harmonics]
        return self.kappa * np.array(factors)

    @property
    def highest_frequency(self) -> float:
        """Highest frequency of the coupled modes at any angle [rad/s].

        Turning the rotor only turns the coordinates of its pairs, which leaves the frequencies as
        they are; single modes don't turn, and with these a circle of angles is looked at.
        """
        highest = 0.0
        for k in self.modes.harmonics:
            part = self.modes.harmonic(k)
            angles = np.linspace(0.0, 2.0 * np.pi, 1 if np.all(part.paired) else ANGLES)
            whole = periodic_stiffness(
                part, kappa=self.kappa, angle=angles / max(k, 1), with_pi=self.with_pi
            )
            highest = max(highest, float(np.linalg.eigvalsh(whole).max()))
        return float(np.sqrt(highest))

    def coordinates(self, *, on_casing: bool) -> tuple[IntArray, IntArray]:
        """Coordinates that belong to one body, and the numbers of their modes on it."""
        return body_coordinates(self.modes, self.number, on_casing=on_casing)

    def stiffness(self, *, angle: ArrayLike) -> FloatArray:
        """K* of the coupled coordinates at an angle Omega t [rad], (..., size, size) [1/s^2]."""
        return coupling_stiffness(self.modes, kappa=self.kappa, angle=angle, with_pi=self.with_pi)


def body_coordinates(
    modes: CouplingModes, number: IntArray, *, on_casing: bool
) -> tuple[IntArray, IntArray]:
    """Coordinates that belong to one body, and the numbers of their modes on it.

    Args:
        modes: the coupled modes.
        number: of each entry's mode among those of its body; a sine follows, (entries,).
        on_casing: which body.
    """
    coordinates = np.flatnonzero(modes.on_casing[modes.entry] == on_casing)
    return coordinates, (number[modes.entry] + modes.is_sine)[coordinates]


def periodic_stiffness(
    modes: CouplingModes, *, kappa: float, angle: ArrayLike, with_pi: bool = True
) -> FloatArray:
    """Whole stiffness diag(omega^2) + K* of Eq. (9), corrected, (..., size, size) [1/s^2]."""
    uncoupled = np.diag((modes.frequency * np.abs(modes.frequency))[modes.entry])
    return uncoupled + coupling_stiffness(modes, kappa=kappa, angle=angle, with_pi=with_pi)
