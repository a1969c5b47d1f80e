"""Arrays that define a contact march: two reduced bodies, loads, a contact law, a start.

The rotor lives in its rotating frame, the casing in the static one. Both are mass-normalised
modal models; their rows tell how the tips, the centre and the casing's nodes move. The bodies may
come from any structure: with sectors the DFT columns of their modes let the march use it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.coupling.equations import difference_of_axes
from bladewhirl.models.coupling.springs import CouplingSprings
from bladewhirl.models.elements.cyclic import evenly_spaced

NEVER = np.inf
"""End of a load that stays on."""


@dataclass(frozen=True, kw_only=True)
class ReducedRotor:
    """A bladed disk in modal coordinates, rotating frame."""

    frequency: FloatArray
    """Frequency [rad/s], (modes,); negative where spin softening makes its square negative, see
    `stiffness`."""
    damping_ratio: FloatArray  #: (modes,)
    tip_radial: FloatArray  #: radial displacement of each tip [kg^-1/2], (tips, modes)
    tip_tangential: FloatArray  #: the same towards +theta
    centre: FloatArray  #: x and y of the centre node [kg^-1/2], (2, modes); zero when clamped
    tip_angle: FloatArray  #: of each tip from +x [rad], (tips,)
    tip_radius: float  #: that the clearance counts from [m]
    tip_recess: FloatArray  #: how much nearer to the centre each tip ends at rest [m], (tips,)
    column: IntArray  #: DFT column of each mode over the tips, (modes,); -1 without symmetry
    dampers: FloatArray  #: rows G of the damping G^T G at points [s^-1/2], (dampers, modes)
    anisotropy: float = 0.0
    """Half the difference of the fixed springs under the centre, x less y [N/m]."""
    by_velocity: FloatArray | None = None
    """Coriolis forces 2 Omega G and non-modal damping [1/s], (modes, modes); None without Coriolis
    forces. With it, dampers respond to contact within the step."""
    circulation: float = 0.0
    """Strength of the fixed dampers under the centre times the speed [N/m]: in rotating axes a
    displacement (x, y) gives a force of it times (y, -x)."""

    @property
    def stiffness(self) -> FloatArray:
        """Squared frequencies with their signs [rad2/s2], (modes,)."""
        return self.frequency * np.abs(self.frequency)

    @property
    def damping(self) -> FloatArray:
        """All forces by velocity, Coriolis among them [1/s], (modes, modes)."""
        by_ratio = np.diag(2.0 * self.damping_ratio * np.abs(self.frequency))
        coupled = 0.0 if self.by_velocity is None else self.by_velocity
        return np.asarray(by_ratio + self.dampers.T @ self.dampers + coupled)

    @property
    def circulation_stiffness(self) -> FloatArray:
        """Skew stiffness due to dampers in the static frame [rad2/s2], (modes, modes)."""
        x, y = self.centre
        return np.asarray(self.circulation * (np.outer(y, x) - np.outer(x, y)))

    @property
    def whirl_stiffness(self) -> float:
        """Most that the anisotropy adds to any squared frequency [1/s^2]."""
        largest = np.linalg.eigvalsh(self.centre @ self.centre.T).max()
        return float(abs(self.anisotropy) * largest)

    @property
    def by_harmonics(self) -> bool:
        """Whether a march proceeds by harmonics; with few modes dense products are faster."""
        tips = len(self.tip_angle)
        return (
            3 <= tips < len(self.column)
            and bool(np.all(self.column >= 0))
            and evenly_spaced(self.tip_angle)
        )

    def take(self, modes: IntArray) -> ReducedRotor:
        """Keep some of the modes."""
        return replace(
            self,
            frequency=self.frequency[modes],
            damping_ratio=self.damping_ratio[modes],
            tip_radial=self.tip_radial[:, modes],
            tip_tangential=self.tip_tangential[:, modes],
            centre=self.centre[:, modes],
            column=self.column[modes],
            dampers=self.dampers[:, modes],
            by_velocity=(
                None if self.by_velocity is None else self.by_velocity[np.ix_(modes, modes)]
            ),
        )

    def turning_force(self, displacement: FloatArray, velocity: FloatArray) -> FloatArray:
        """Forces on the modes due to `by_velocity` and, by displacement, to dampers in the static
        frame.

        Args:
            displacement: of the modes, (modes,).
            velocity: theirs.
        """
        force = -self.circulation_stiffness @ displacement
        return force if self.by_velocity is None else force - self.by_velocity @ velocity


@dataclass(frozen=True, kw_only=True)
class ReducedCasing:
    """A casing in modal coordinates, static frame."""

    frequency: FloatArray  #: [rad/s], (modes,)
    damping_ratio: FloatArray  #: (modes,)
    nodal: FloatArray  #: w, dw/ds, u, du/ds of each node [kg^-1/2], (nodes, 4, modes)
    clearance: FloatArray  #: clearance and its slope along s at each node [m, 1], (nodes, 2)
    radius: float  #: [m]
    column: IntArray  #: DFT column of each mode over the nodes, (modes,); -1 without symmetry
    dampers: FloatArray  #: rows G of the damping G^T G at points [s^-1/2], (dampers, modes)

    @property
    def element_length(self) -> float:
        """Arc length of one element [m]."""
        return 2.0 * np.pi * self.radius / len(self.nodal)

    @property
    def by_harmonics(self) -> bool:
        """Whether a march proceeds by harmonics; with few modes dense products are faster."""
        return len(self.column) > len(self.nodal) and bool(np.all(self.column >= 0))

    def take(self, modes: IntArray) -> ReducedCasing:
        """Keep some of the modes."""
        return replace(
            self,
            frequency=self.frequency[modes],
            damping_ratio=self.damping_ratio[modes],
            nodal=self.nodal[..., modes],
            column=self.column[modes],
            dampers=self.dampers[:, modes],
        )


@dataclass(frozen=True, kw_only=True)
class Load:
    """A force pattern times cos(frequency t + phase), from a half-cosine ramp to an end."""

    rotor: FloatArray  #: modal force [N kg^-1/2], (rotor modes,)
    casing: FloatArray  #: modal force [N kg^-1/2], (casing modes,)
    end: float = NEVER  #: the load is zero from this time on [s]
    ramp: float = 0.0  #: length of the half-cosine ramp from zero [s]
    frequency: float = 0.0  #: [rad/s]
    phase: float = 0.0  #: [rad]

    def take(self, rotor_modes: IntArray, casing_modes: IntArray) -> Load:
        """The load on some of the modes: its projection on them."""
        return replace(self, rotor=self.rotor[rotor_modes], casing=self.casing[casing_modes])


@dataclass(frozen=True, kw_only=True)
class Start:
    """Displacement and velocity at t = 0, modal coordinates."""

    rotor: FloatArray  #: [kg^1/2 m], (rotor modes,)
    rotor_velocity: FloatArray  #: [kg^1/2 m/s]
    casing: FloatArray  #: (casing modes,)
    casing_velocity: FloatArray

    def take(self, rotor_modes: IntArray, casing_modes: IntArray) -> Start:
        """The start in some of the modes: its mass-orthogonal projection on them."""
        return Start(
            rotor=self.rotor[rotor_modes],
            rotor_velocity=self.rotor_velocity[rotor_modes],
            casing=self.casing[casing_modes],
            casing_velocity=self.casing_velocity[casing_modes],
        )


@dataclass(frozen=True, kw_only=True)
class ContactProblem:
    """Everything that decides a march but its time step."""

    rotor: ReducedRotor
    casing: ReducedCasing
    speed: float  #: Omega, counter-clockwise [rad/s]
    friction: float  #: Coulomb coefficient
    sliding: Literal["permanent", "signed"]
    tip_rotation: bool  #: whether the angle of a tip follows u_t / R
    displacement_limit: float  #: limit of small displacements [m]
    loads: tuple[Load, ...]
    start: Start
    springs: CouplingSprings | None = None  #: between the bodies
    restitution: float = 0.0  #: e of the scheme "moreau-jean"
    penalty_stiffness: float = 1e9  #: of the scheme "penalty" [N/m]
    stick_speed: float = 0.01  #: of the scheme "penalty": below it friction grows with it [m/s]

    @property
    def critical_time_step(self) -> float:
        """Stability limit of central differences [s]."""
        return critical_time_step(self.rotor, self.casing, self.springs)

    def spring_stiffness(self, angle: ArrayLike) -> FloatArray:
        """K* of the springs between the bodies and of the static springs of the shaft [1/s^2].

        Args:
            angle: Omega t [rad], any shape (...).

        Returns:
            (..., n, n) over the modes of rotor and casing.
        """
        rotor, angle = len(self.rotor.frequency), np.asarray(angle, dtype=np.float64)
        stiffness = np.zeros((*angle.shape, *(rotor + len(self.casing.frequency),) * 2))
        stiffness[..., :rotor, :rotor] = self.rotor.anisotropy * difference_of_axes(
            self.rotor.centre, angle
        )
        if self.springs is not None:
            place = self.springs.places(rotor)
            stiffness[..., place[:, None], place] += self.springs.stiffness(angle=angle)
        return stiffness


def critical_time_step(
    rotor: ReducedRotor, casing: ReducedCasing, springs: CouplingSprings | None
) -> float:
    """2 / omega_max of both bodies as coupled, the stability limit of central differences [s].

    With Coriolis forces, of eigenvalue i g of M^-1 G, the limit is k dt^2 <= 2 + 2 sqrt(1 +
    (Omega g dt)^2): never lower, and higher by nothing that matters.
    """
    highest = max(np.abs(rotor.frequency).max(initial=0.0), casing.frequency.max(initial=0.0))
    if springs is not None:
        highest = max(highest, springs.highest_frequency)
    return float(2.0 / np.sqrt(highest**2 + rotor.whirl_stiffness))


def at_rest(rotor: ReducedRotor, casing: ReducedCasing) -> Start:
    """Start without displacement or velocity."""
    still_rotor, still_casing = np.zeros(len(rotor.frequency)), np.zeros(len(casing.frequency))
    return Start(
        rotor=still_rotor,
        rotor_velocity=still_rotor,
        casing=still_casing,
        casing_velocity=still_casing,
    )
