"""Modes with one nodal diameter each, coupled by springs: Eqs (4)-(10).

With alpha = theta - Omega t and mass-normalised modes

    w(theta)   = sum_i a_i (v_ci cos k_i theta + v_si sin k_i theta)             on the casing
    u(alpha)   = sum_j a_j (u_cj cos k_j alpha + u_sj sin k_j alpha)             on the rotor

cosines of different k are orthogonal on the circle, so each nodal diameter has its own equations;
see `bladewhirl.models.coupling.equations`. The paper's system, Eq. (9), has one casing and two
rotor pairs, all with k = 1 and a = 1.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from bladewhirl.meshes.line_mesh import BoolArray, ComplexArray, FloatArray, IntArray
from bladewhirl.models.coupling.equations import (
    CoupledEquations,
    spring_stiffness,
    wave_integrals,
)
from bladewhirl.models.structure.rotating import Rotating

SIX_NAMES = ("casing k=1", "1F k=1", "suspension")
"""Names of the modes of the paper's system, which have k = 1."""


@dataclass(frozen=True, kw_only=True)
class CouplingModes:
    """Modes that springs couple; each entry of the arrays is a cosine/sine pair or a single mode.

    The real coordinates are in the order of the entries, cosine before sine. The coordinates of
    the paper's system are (v_c, v_s, u_c, u_s, u_co, u_so), of casing, 1F and suspension. A single
    mode with k > 0 is a mode of the rotor with k = N/2, where N is the number of sectors.
    """

    name: tuple[str, ...]  #: name of each entry for tables and legends
    on_casing: BoolArray  #: true for a mode of the casing, false for the rotor, (entries,)
    nodal_diameter: IntArray  #: k of each entry, (entries,)
    frequency: FloatArray
    """Natural frequency of each entry without the springs [rad/s], (entries,); negative if its
    square is negative, which happens beyond a critical speed."""
    amplitude: FloatArray  #: radial amplitude at the springs [kg^-1/2], (entries,)
    damping_ratio: FloatArray  #: modal damping ratio of each entry, (entries,)
    paired: BoolArray  #: true for a cosine/sine pair, (entries,)
    gyroscopic: FloatArray | None = None
    """G of the coordinates, zero on the casing, (size, size); None if zero, see `equations`."""
    stiffness_speed: FloatArray | None = None  #: K1 of the coordinates, (size, size)
    with_pi: bool = True  #: keep the factor pi of the integral in Eq. (8)

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
        """Number of the entry to which each coordinate belongs, (size,)."""
        return np.repeat(np.arange(self.entries), 1 + self.paired)

    @property
    def is_sine(self) -> BoolArray:
        """Mask of the coordinates that are the sine of a pair, (size,)."""
        return np.asarray(np.arange(self.size) > self.cosine[self.entry])

    @property
    def harmonics(self) -> tuple[int, ...]:
        """Nodal diameters of the entries, ascending; different nodal diameters are not coupled."""
        return tuple(int(k) for k in np.unique(self.nodal_diameter))

    @property
    def damping_rate(self) -> FloatArray:
        """Modal damping 2 xi omega of each entry [1/s], (entries,)."""
        return np.asarray(2.0 * self.damping_ratio * self.frequency)

    @property
    def frame_rate(self) -> FloatArray:
        """Turns of the frame in which the equations of each entry have constant coefficients, per
        turn of the rotor, (entries,)."""
        share = np.where(self.on_casing, 0.5, -0.5)
        single = np.isin(self.nodal_diameter, self.nodal_diameter[~self.paired])
        turned = np.where(single, self.on_casing, share)  # a single mode cannot be turned
        return np.asarray(turned * self.nodal_diameter, dtype=np.float64)

    @cached_property
    def equations(self) -> CoupledEquations:
        """Equations of motion of all coordinates."""
        entry, coordinates = self.entry, np.arange(self.size)
        place = np.searchsorted(self.harmonics, self.nodal_diameter[entry])
        rows = np.zeros((len(self.harmonics), 2, self.size))
        rows[place, self.is_sine.astype(int), coordinates] = self.amplitude[entry]
        casing = self.on_casing[entry]
        turning, cosine = np.zeros((self.size, self.size)), self.cosine[self.paired]
        turning[cosine + 1, cosine] = self.frame_rate[self.paired]
        turning[cosine, cosine + 1] = -self.frame_rate[self.paired]
        return CoupledEquations(
            name=self.name,
            structure=Rotating(
                mass=np.eye(self.size),
                stiffness=np.diag(self.frequency[entry] * np.abs(self.frequency[entry])),
                damping=np.diag(self.damping_rate[entry]),
                gyroscopic=self.gyroscopic,
                stiffness_speed=self.stiffness_speed,
            ),
            harmonics=np.array(self.harmonics),
            casing=np.where(casing, rows, 0.0),
            rotor=np.where(casing, 0.0, rows),
            turning=turning,
            pairs=bool(np.all(self.paired)),
            with_pi=self.with_pi,
        )

    @cached_property
    def blocks(self) -> tuple[CoupledEquations, ...]:
        """Equations of each nodal diameter, which are independent of each other."""
        return tuple(self.harmonic(k).equations for k in self.harmonics)

    def over_entries(self, matrix: FloatArray | None) -> ComplexArray:
        """Convert a real matrix over coordinates, which must commute with J, to a complex matrix
        over entries."""
        if matrix is None:
            return np.zeros((self.entries, self.entries), dtype=np.complex128)
        crossed = matrix[np.ix_(self.cosine + self.paired, self.cosine)]
        return matrix[np.ix_(self.cosine, self.cosine)] + 1j * self.paired[:, None] * crossed

    def take(self, chosen: IntArray | BoolArray | Sequence[int]) -> "CouplingModes":
        """Return the modes of the entries that a mask or positions select."""
        kept = np.arange(self.entries)[np.asarray(chosen)]
        arrays = {item.name: getattr(self, item.name)[kept] for item in fields(self)[1:7]}
        coordinates = [c for i in kept for c in np.flatnonzero(self.entry == i)]
        among = np.ix_(coordinates, coordinates)
        for key in ("gyroscopic", "stiffness_speed"):
            if (matrix := getattr(self, key)) is not None:
                arrays[key] = matrix[among]
        return replace(self, name=tuple(self.name[i] for i in kept), **arrays)

    def harmonic(self, k: int) -> "CouplingModes":
        """Return only the modes of nodal diameter k."""
        return self.take(self.nodal_diameter == k)


@dataclass(frozen=True, kw_only=True)
class CoupledEntries:
    """Coupled modes, and the number of each mode among all modes of its body (rotor or casing)."""

    modes: CouplingModes
    number: IntArray  #: number of the (cosine) mode among the modes of its body, (entries,)

    @property
    def numbers(self) -> IntArray:
        """Number of the mode of each coordinate among the modes of its body, (size,)."""
        return self.number[self.modes.entry] + self.modes.is_sine

    def coordinates(self, *, on_casing: bool) -> tuple[IntArray, IntArray]:
        """Return the coordinates of the rotor or of the casing, and the numbers of their modes."""
        coordinates = np.flatnonzero(self.modes.on_casing[self.modes.entry] == on_casing)
        return coordinates, self.numbers[coordinates]

    @property
    def radial(self) -> dict[int, IntArray]:
        """Numbers of the casing's coupled modes by nodal diameter."""
        return {
            int(self.modes.nodal_diameter[i]): self.number[i] + np.arange(1 + self.modes.paired[i])
            for i in np.flatnonzero(self.modes.on_casing)
        }

    def among(self, on_rotor: IntArray, on_casing: IntArray) -> IntArray:
        """Return the positions of the entries that belong to the given rotor or casing modes."""
        there = np.isin(self.number, on_rotor), np.isin(self.number, on_casing)
        return np.flatnonzero(np.where(self.modes.on_casing, there[1], there[0]))

    def take(self, chosen: IntArray | Sequence[int]) -> Self:
        """Return the chosen entries; `chosen` contains positions."""
        return replace(self, modes=self.modes.take(chosen), number=self.number[chosen])

    def with_unit_amplitudes(self) -> Self:
        """Replace every amplitude by 1, as in the paper, or by -1 if the amplitude is negative."""
        return replace(self, modes=replace(self.modes, amplitude=np.sign(self.modes.amplitude)))

    def six_modes(self) -> Self:
        """Return only the k = 1 pairs of the paper, in the order casing, 1F, suspension (Eqs 4-9).

        Raises:
            ValueError: a pair is missing. With a clamped centre there is no suspension pair.
        """
        for name in SIX_NAMES:
            if name not in self.modes.name:
                raise ValueError(
                    f"the stage has no pair of {name.split()[0]} modes with one nodal diameter"
                )
        return self.take([self.modes.name.index(name) for name in SIX_NAMES])

    def springs(self, kappa: float, rotor_modes: int, casing_modes: int) -> "CouplingSprings":
        """Return springs between these modes.

        Args:
            kappa: stiffness of the springs [N/m] per radian.
            rotor_modes: number of all modes of the rotor.
            casing_modes: number of all modes of the casing.
        """
        equations, ends = self.modes.equations, []
        bodies = (False, rotor_modes, equations.rotor), (True, casing_modes, equations.casing)
        for on_casing, modes, rows in bodies:
            coordinates, numbers = self.coordinates(on_casing=on_casing)
            ends.append(np.zeros((len(equations.harmonics), 2, modes)))
            ends[-1][..., numbers] = rows[..., coordinates]
        return CouplingSprings(
            kappa=kappa,
            harmonics=equations.harmonics,
            rotor=ends[0],
            casing=ends[1],
            with_pi=equations.with_pi,
        )


@dataclass(frozen=True, kw_only=True)
class CouplingSprings:
    """Springs between rotor and casing: their stiffness, and the radial waves of both ends."""

    kappa: float  #: stiffness [N/m] per radian
    harmonics: IntArray  #: nodal diameters k of the waves, (harmonics,)
    rotor: FloatArray
    """B_k: cosine and sine part at the tips, in rotating axes, for unit modal coordinates
    [kg^-1/2], (harmonics, 2, rotor modes)."""
    casing: FloatArray
    """A_k: the same of the wall [kg^-1/2], (harmonics, 2, casing modes); pairs of modes if k > 0,
    with one frequency."""
    with_pi: bool = True  #: keep the factor pi of the integral in Eq. (8)

    @property
    def factors(self) -> FloatArray:
        """Modal spring stiffness f_k kappa of each nodal diameter [N/m], (harmonics,)."""
        return self.kappa * wave_integrals(self.harmonics, with_pi=self.with_pi)

    @property
    def places(self) -> IntArray:
        """Numbers of the coupled modes among all modes, of the rotor and then of the casing."""
        rows = np.concatenate([self.rotor, self.casing], axis=-1)
        return np.flatnonzero(rows.any(axis=(0, 1)))

    def stiffness(self, *, angle: ArrayLike) -> FloatArray:
        """Return K* of the coupled modes at an angle Omega t [rad], (..., coupled, coupled)
        [1/s^2]."""
        empty = np.zeros_like(self.rotor), np.zeros_like(self.casing)
        casing = np.concatenate([empty[0], self.casing], axis=-1)[..., self.places]
        rotor = np.concatenate([self.rotor, empty[1]], axis=-1)[..., self.places]
        return spring_stiffness(casing, rotor, self.harmonics, self.factors, angle)

    def highest_frequency(self, rotor: FloatArray, casing: FloatArray) -> float:
        """Return the highest frequency of the coupled modes at any angle [rad/s], for squared
        frequencies without the springs, (rotor modes,) and (casing modes,).

        The angle does not change the frequencies: it only rotates the pairs of modes of the wall.
        """
        alone = np.diag(np.concatenate([rotor, casing])[self.places])
        return float(np.sqrt(np.linalg.eigvalsh(alone + self.stiffness(angle=0.0))[-1]))
