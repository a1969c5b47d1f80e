"""Speed of rotation that varies over time, prescribed or free, and what it changes in a rotor."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.speed_course import SpeedCourse
from bladewhirl.models.structure.rotating import Rotating


class Rotation(NamedTuple):
    """Rotation of the rotor at an instant."""

    angle: float  #: [rad]
    speed: float  #: [rad/s]
    acceleration: float  #: [rad/s2]


@dataclass(frozen=True, kw_only=True)
class SpeedChange:
    """Speed of rotation that varies over time, and the rotor whose matrices depend on it.

    Displacements are those from the state of steady rotation at the speed of `rotor`.
    """

    course: SpeedCourse
    rotor: Rotating[FloatArray] | None = None
    """A copy in its modes at the speed of the contact problem, with Coriolis forces, (modes,
    modes); None without rotation effects."""
    factor: FloatArray = field(default_factory=lambda: np.ones(1))
    """Factor on the changes of the stiffness of each copy, (copies,)."""
    compliance: "ComplianceOverSpeeds | None" = None
    """None if the flexibility of contact nodes is the same at every speed."""

    def change_of_force(
        self, base: float, turned: Rotation, displacement: FloatArray, velocity: FloatArray
    ) -> FloatArray:
        """Return the modal forces on the rotor that the rotor at the speed `base` [rad/s] lacks,
        (modes,)."""
        if self.rotor is None:
            return np.zeros(len(displacement))
        speed, rate = turned.speed, turned.acceleration
        x, v = (each.reshape(len(self.factor), -1) for each in (displacement, velocity))
        stiffness = self.factor[:, None] * (x @ self.rotor.change(speed).T)
        turning = rate * x + 2.0 * (speed - base) * v
        return -(stiffness + turning @ self.rotor.coriolis.T).ravel()


@dataclass(frozen=True, kw_only=True)
class ComplianceOverSpeeds:
    """Flexibility of the contact nodes of a superelement at a few speeds. Between them it is
    interpolated by polynomials."""

    speeds: FloatArray  #: speeds [rad/s], (speeds,)
    compliance: FloatArray  #: see `ReducedRotor.compliance`, (speeds, copies, 3c, 3c)

    def at(self, speed: ArrayLike) -> FloatArray:
        """Return the compliance at speeds [rad/s] of any shape (...), (..., copies, 3c, 3c)."""
        from scipy.interpolate import BarycentricInterpolator  # long to load

        return np.asarray(BarycentricInterpolator(self.speeds, self.compliance)(speed))

    def displacement(self, force: FloatArray, speed: FloatArray) -> FloatArray:
        """Return the displacements of contact nodes due to forces on them [m].

        Args:
            force: contact forces at some instants [N], (instants, copies, 3c).
            speed: speeds at these instants [rad/s], (instants,).
        """
        from scipy.interpolate import BarycentricInterpolator  # long to load

        parts = BarycentricInterpolator(self.speeds, np.eye(len(self.speeds)))(speed)
        terms = zip(parts.T, self.compliance, strict=True)
        return np.asarray(
            sum(part[:, None, None] * displacement_by(force, each) for part, each in terms)
        )


def displacement_by(force: FloatArray, compliance: FloatArray) -> FloatArray:
    """Return the displacements due to forces at some instants [m], (instants, copies, 3c).

    Each instant is a product of its own: in one product of all, the last bits of an instant depend
    on how many there are, and a march that is continued has others than one without a break.

    Args:
        force: contact forces [N], (instants, copies, 3c).
        compliance: see `ReducedRotor.compliance`, (copies, 3c, 3c).
    """
    moved = np.zeros(force.shape)
    for copy, by_force in enumerate(compliance):
        pushed = np.flatnonzero(force[:, copy].any(axis=1))
        moved[pushed, copy] = (by_force @ force[pushed, copy, :, None])[..., 0]
    return moved


@dataclass(frozen=True, kw_only=True)
class FreeSpeed:
    """Rotor whose speed follows from its angular momentum, see `solvers/kernel/drive.h`. The course
    of `SpeedChange` is then the speed at the start."""

    inertia: float
    """Moment of inertia about the axis, of the bladed disk in the state of steady rotation at the
    start and of all that turns with it [kg m2]."""
    torque: float = 0.0  #: torque of the drive [N m]
    loss: float = 0.0  #: torque of losses by speed [N m s]
    damping: float = 0.0  #: damping at the centre in static axes [N s/m]
    along: FloatArray = field(default_factory=lambda: np.zeros(0))
    """Load pattern of Omega^2 [N s2 kg^-1/2], (rotor modes,); empty without rotation effects."""
    across: FloatArray = field(default_factory=lambda: np.zeros(0))
    """Load pattern of -Omega' [N s2 kg^-1/2], (rotor modes,); empty without rotation effects."""

    def momentum(self, speed: float, change: SpeedChange, x: FloatArray, v: FloatArray) -> float:
        """Return the angular momentum at a speed [rad/s] for modal displacements and velocities
        [N m s]."""
        if change.rotor is None:
            return self.inertia * speed
        softer = 2.0 * self.along - change.rotor.known("stiffness_speed") @ x
        inertia = self.inertia + softer @ x
        return float(speed * inertia + self.across @ v + v @ change.rotor.coriolis @ x)

    def acceleration(
        self,
        speed: float,
        change: SpeedChange,
        centre: FloatArray,
        motion: tuple[FloatArray, FloatArray, FloatArray],
        spun: float = 0.0,
    ) -> tuple[float, float, FloatArray]:
        """Return the torque without contact [N m], the acceleration of the rotation [rad/s2], and
        the modal accelerations that it causes, (modes,).

        Args:
            speed: speed of rotation [rad/s].
            change: matrices that depend on the speed.
            centre: x and y of the centre [kg^-1/2], (2, modes).
            motion: modal displacements, velocities, and accelerations without that of the rotation.
            spun: torque of bearings [N m].
        """
        x, v, free = motion
        torque = self.torque - self.loss * speed + spun
        if change.rotor is None:
            return torque, torque / self.inertia, np.zeros(len(x))
        (place, rate), softer = (
            (centre @ x, centre @ v),
            self.along - change.rotor.known("stiffness_speed") @ x,
        )
        swept = place[0] * rate[1] - place[1] * rate[0] + speed * place @ place
        torque = float(torque - self.damping * swept)
        coupled = self.across + change.rotor.coriolis @ x
        inertia = self.inertia + (self.along + softer) @ x - coupled @ coupled
        lost = coupled @ free + 2.0 * speed * softer @ v
        alpha = float((torque - lost) / inertia)
        return torque, alpha, -alpha * coupled
