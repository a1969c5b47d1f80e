"""Loads and initial states in modal coordinates."""

from dataclasses import dataclass, field, replace

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.stage.reduced_rotor import ReducedRotor
from bladewhirl.models.stage.varying_speed import Rotation
from bladewhirl.models.stage.wall import ReducedCasing

NEVER = np.inf  #: end time of a load that does not end


@dataclass(frozen=True, kw_only=True)
class Load:
    """A force pattern times cos(frequency t + phase), with a half-cosine ramp and an end."""

    rotor: FloatArray  #: modal force [N kg^-1/2], (rotor modes,)
    casing: FloatArray = field(default_factory=lambda: np.zeros(0))
    """Modal force [N kg^-1/2], (casing modes,); empty for a rigid wall."""
    end: float = NEVER  #: the load is zero from this time on [s]
    ramp: float = 0.0  #: length of the half-cosine ramp from zero [s]
    frequency: float = 0.0  #: frequency of the cosine [rad/s]
    phase: float = 0.0  #: phase of the cosine [rad]
    order: float = 0.0
    """Multiple of the angle of the rotor that is added to the argument of the cosine. This and the
    parts due to the speed need `SpeedChange`."""
    constant: float = 1.0
    """The pattern is multiplied by the sum of this number and of the next three parts."""
    by_square: float = 0.0
    """Factor of Omega^2 less the square of the speed of the contact problem [s2]."""
    by_fourth: float = 0.0  #: the same of the fourth powers [s4]
    by_acceleration: float = 0.0  #: factor of Omega' [s2]

    def amplitude(self, time: float, turned: Rotation, base: float) -> float:
        """Return the factor of the pattern at a time [s] and a rotation; `base` is the speed of the
        contact problem [rad/s]."""
        if not time < self.end:
            return 0.0
        scale = self.constant + self.by_square * (turned.speed**2 - base**2)
        scale += self.by_fourth * (turned.speed**4 - base**4)
        scale += self.by_acceleration * turned.acceleration
        factor = np.cos(self.frequency * time + self.phase + self.order * turned.angle)
        if time < self.ramp:
            factor *= 0.5 - 0.5 * np.cos(np.pi * time / self.ramp)
        return float(factor * scale)

    def take(self, rotor_modes: IntArray, casing_modes: IntArray) -> "Load":
        """Return the load on the chosen modes, that is, its projection on these modes."""
        return replace(self, rotor=self.rotor[rotor_modes], casing=self.casing[casing_modes])


@dataclass(frozen=True, kw_only=True)
class Start:
    """Displacement and velocity at t = 0 in modal coordinates."""

    rotor: FloatArray
    """Modal displacements of the rotor [kg^1/2 m], (rotor modes,); for a superelement (copies,
    modes)."""
    rotor_velocity: FloatArray  #: modal velocities of the rotor [kg^1/2 m/s], in the same shape
    casing: FloatArray
    """Modal displacements of the casing [kg^1/2 m], (casing modes,); empty for a rigid wall."""
    casing_velocity: FloatArray  #: modal velocities of the casing [kg^1/2 m/s], (casing modes,)
    contact_force: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    """Radial, tangential and axial contact force on each tip at t = 0 [N], (tips, 3); empty: no
    contact. Tips of beams have no axial force."""

    @classmethod
    def of_rotor(
        cls, rotor: FloatArray, rotor_velocity: FloatArray, casing_modes: int = 0
    ) -> "Start":
        """Return a start at which the casing is at rest."""
        still = np.zeros(casing_modes)
        return cls(rotor=rotor, rotor_velocity=rotor_velocity, casing=still, casing_velocity=still)

    def take(self, rotor_modes: IntArray, casing_modes: IntArray) -> "Start":
        """Return the start in the chosen modes: its mass-orthogonal projection on these modes."""
        return Start(
            rotor=self.rotor[rotor_modes],
            rotor_velocity=self.rotor_velocity[rotor_modes],
            casing=self.casing[casing_modes],
            casing_velocity=self.casing_velocity[casing_modes],
            contact_force=self.contact_force,
        )


def at_rest(rotor: ReducedRotor, casing: ReducedCasing) -> Start:
    """Return a start without displacement and velocity."""
    still = np.zeros(len(rotor.frequency))
    return Start.of_rotor(still, still, len(casing.frequency))
