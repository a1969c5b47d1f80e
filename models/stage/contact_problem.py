"""Arrays that define a contact problem: two reduced bodies, loads, contact law, initial state.

The rotor is described in its rotating frame, the casing in the static frame. Both are
mass-normalised modal models; matrices give the motion of the tips, of the centre and of the nodes
of the casing for unit modal coordinates. Rotor and casing can be any structures. Time integration
uses their cyclic symmetry, if the modes have DFT columns.

A tip is a place of the bladed disk that can touch the wall: the end of a blade of beams, or a
contact node of a superelement.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.coupling.equations import difference_of_axes
from bladewhirl.models.coupling.springs import CouplingSprings
from bladewhirl.models.stage.bearings import Bearings
from bladewhirl.models.stage.foreshortening import Foreshortening
from bladewhirl.models.stage.joint_contacts import JointContacts
from bladewhirl.models.stage.modal_loads import Load, Start
from bladewhirl.models.stage.reduced_rotor import ReducedRotor
from bladewhirl.models.stage.varying_speed import FreeSpeed, Rotation, SpeedChange
from bladewhirl.models.stage.wall import ReducedCasing, WallClosure
from bladewhirl.models.stage.wall_coating import WallCoating

Bodies = list[tuple[FloatArray, FloatArray]]
"""Radial displacements of the surface of each body for unit modal coordinates, and frequencies of
the modes."""

ROUNDING = 1e-9
"""A negative damping rate up to this fraction of the largest one is a rounding error."""


@dataclass(frozen=True, kw_only=True)
class ContactProblem:
    """All data of a march except its time steps."""

    rotor: ReducedRotor
    casing: ReducedCasing
    speed: float
    """Speed of rotation Omega, counter-clockwise [rad/s]; if it varies, the speed of the arrays."""
    friction: float  #: Coulomb friction coefficient
    sliding: Literal["permanent", "signed", "full"]
    """See `contact.sliding` of a case."""
    tip_rotation: bool  #: true to add u_t / R to the angle of a tip
    displacement_limit: float  #: displacement at which a march ends as divergent [m]
    loads: tuple[Load, ...]
    start: Start
    springs: CouplingSprings | None = None  #: springs between the bodies
    bearings: Bearings | None = None  #: bearings of a rotor of one copy
    closure: WallClosure | None = None  #: clearance that is lost over time
    coating: WallCoating | None = None  #: abradable coating
    foreshortening: Foreshortening | None = None  #: gaps that open as blades bend
    slope: float | FloatArray = 0.0
    """Slope of a conical wall [rad], in whose axes contact nodes move, see `cone`; under a contour
    that of each contact node of a copy, (nodes,)."""
    change: SpeedChange | None = None  #: None for a constant speed
    drive: FreeSpeed | None = None  #: None for a prescribed speed
    joints: JointContacts | None = None  #: friction joints between blades
    loss: "LostBlades | None" = None  #: None if no blade is lost
    fuse: "FusedSupport | None" = None  #: None if no support fuses

    def speed_at(self, time: float) -> float:
        """Return the speed of rotation at a time [rad/s]."""
        return self.speed if self.change is None else float(self.change.course.speed(time))

    def angle_at(self, time: float) -> float:
        """Return the angle of the rotor at a time [rad]."""
        return self.speed * time if self.change is None else float(self.change.course.angle(time))

    def rotation_at(self, time: float) -> Rotation:
        """Return the rotation at a time [s]; that of a free speed is known at the start only."""
        if self.change is None:
            return Rotation(self.speed * time, self.speed, 0.0)
        course = self.change.course
        each = (course.angle(time), course.speed(time), course.acceleration(time))
        return Rotation(*map(float, each))

    def turning_force(
        self, turned: Rotation, displacement: FloatArray, velocity: FloatArray
    ) -> FloatArray:
        """Return the modal forces of the rotation on the rotor, (modes,); see
        `ReducedRotor.turning_force`."""
        rotor, change = self.rotor, self.change
        if change is None:
            return rotor.turning_force(displacement, velocity)
        if rotor.circulation != 0.0:
            share = turned.speed / self.speed
            rotor = replace(rotor, circulation=share * rotor.circulation)
        force = rotor.turning_force(displacement, velocity)
        return force + change.change_of_force(self.speed, turned, displacement, velocity)

    def contact_pull(self, turned: Rotation, start: Start) -> tuple[FloatArray, FloatArray]:
        """Return the modal forces on rotor and casing of the contact forces of a start."""
        rotor, casing, force = self.rotor, self.casing, start.contact_force
        if not force.any():
            return np.zeros(len(rotor.frequency)), np.zeros(len(casing.frequency))
        by_copy = force.reshape(rotor.copies, -1, 3)
        pull = by_copy[..., 0] @ rotor.tip_radial + by_copy[..., 1] @ rotor.tip_tangential
        pull = pull + by_copy[..., 2] @ rotor.tip_axial
        pushed = casing.shapes_at(rotor.tip_angle + turned.angle, rotor.wall)
        return pull.ravel(), -np.einsum("td,tdm->m", force[:, :2], pushed)

    def clearance(self, time: float) -> FloatArray:
        """Return the clearance and its derivative by s at each node [m, 1], (nodes, 2)."""
        at_start = self.casing.clearance
        return at_start if self.closure is None else at_start - self.closure.at(time)

    @property
    def metal_recess(self) -> FloatArray:
        """Distance of each tip at rest from the metal wall, which is under the coating if there is
        one, minus the clearance [m], (tips,)."""
        removable = 0.0 if self.coating is None else self.coating.removable
        return np.asarray(self.rotor.tip_recess + removable)

    def free_bodies(self) -> tuple[float, Bodies]:
        """Return the smallest clearance of the tips [m], and the bodies.

        Raises:
            ValueError: the energy of free motion need not decay; the message states the reason.
        """
        rotor, casing = self.rotor, self.casing
        if self.joints is not None:
            raise ValueError("joints tie the blades together")
        static = self.springs is not None or self.bearings is not None
        if static or rotor.anisotropy or rotor.circulation:
            raise ValueError("springs or dampers in the static frame can feed energy to the rotor")
        if rotor.by_velocity is not None:
            rates = 2.0 * rotor.damping_ratio * np.abs(rotor.frequency)
            coupled = 0.5 * (rotor.by_velocity + rotor.by_velocity.T)
            lowest = np.diag(rotor.by_copy(rates).min(axis=0)) + coupled
            losses = np.linalg.eigvalsh(lowest)
            if losses[0] < -ROUNDING * max(losses[-1], 0.0):
                raise ValueError(
                    "the damping matrix of the superelement feeds energy to some motion"
                )
        smallest = casing.clearance[:, 0].min() * rotor.normal_part + rotor.tip_recess
        clearance = float(smallest.min())
        bodies = [(rotor.tip_radial, frequency) for frequency in rotor.by_copy(rotor.frequency)]
        if casing.is_flexible:
            bodies.append((casing.nodal[:, 0], casing.frequency))
        return clearance, bodies

    def initial_gap(self, time: float = 0.0) -> FloatArray:
        """Return the gap of each tip to the metal at the initial displacements, by Hermite
        interpolation [m], (tips,).

        Args:
            time: time, which determines the angle of the rotor and the clearance [s].
        """
        casing, rotor, start = self.casing, self.rotor, self.start
        angle = rotor.tip_angle + self.angle_at(time)
        if self.tip_rotation:
            around = rotor.at_tips(rotor.tip_tangential, start.rotor)
            angle = angle + (around.reshape(rotor.copies, -1) / rotor.contact_radius).ravel()
        field = casing.nodal[:, :2] @ start.casing + self.clearance(time)
        surface = casing.at(field, angle, rotor.wall)
        gap = (
            rotor.normal_part * surface
            + self.metal_recess
            - rotor.at_tips(rotor.tip_radial, start.rotor)
        )
        if start.contact_force.size and rotor.compliance is not None:
            pushed = start.contact_force.reshape(rotor.copies, -1, 1)
            gap = gap - (rotor.compliance @ pushed)[:, ::3].ravel()
        if self.foreshortening is not None:
            gap = gap + self.foreshortening.opening(start.rotor)
        return np.asarray(gap)

    def at_speed(self, speed: float) -> "ContactProblem":
        """Return the problem with the Coriolis forces and the contact nodes at another speed
        [rad/s]."""
        rotor, change = self.rotor, self.change
        assert change is not None
        if change.rotor is not None:
            further = 2.0 * (speed - self.speed) * change.rotor.coriolis
            assert rotor.by_velocity is not None
            rotor = replace(rotor, by_velocity=rotor.by_velocity + further)
        if change.compliance is not None:
            rotor = replace(rotor, compliance=change.compliance.at(speed))
        return replace(self, rotor=rotor)

    @property
    def phases(self) -> "Iterator[ContactProblem]":
        """This problem, and those after each of its sudden changes."""
        yield self
        for change in (self.loss, self.fuse):
            if change is not None:
                yield from change.after.phases

    @property
    def critical_time_step(self) -> float:
        """Stability limit of the time step for central differences [s]."""
        return critical_time_step(self.rotor, self.casing, self.springs, self.bearings)

    def spring_force(self, angle: float, displacement: FloatArray) -> FloatArray:
        """Return the modal forces -K* x on rotor and casing, see `spring_stiffness`, (n,)."""
        if self.springs is None and self.rotor.anisotropy == 0.0:
            return np.zeros(len(displacement))
        return np.asarray(-self.spring_stiffness(angle) @ displacement)

    def spring_stiffness(self, angle: ArrayLike) -> FloatArray:
        """Return the stiffness K* of the coupling springs and of unequal static shaft springs.

        Args:
            angle: angle Omega t of the rotor [rad], any shape (...).

        Returns:
            matrices over the n modes of rotor and casing [1/s^2], (..., n, n).
        """
        rotor, angle = len(self.rotor.frequency), np.asarray(angle, dtype=np.float64)
        stiffness = np.zeros((*angle.shape, *(rotor + len(self.casing.frequency),) * 2))
        stiffness[..., :rotor, :rotor] = self.rotor.anisotropy * difference_of_axes(
            self.rotor.centre, angle
        )
        if self.springs is not None:
            place = self.springs.places
            stiffness[..., place[:, None], place] += self.springs.stiffness(angle=angle)
        return stiffness


@dataclass(frozen=True, kw_only=True)
class Aftermath:
    """Contact problem after a sudden change of the rotor, in coordinates of its own."""

    after: ContactProblem  #: contact problem after the change
    restriction: FloatArray
    """Coordinates after for unit coordinates before, (modes after, modes before)."""
    extension: FloatArray
    """Coordinates before for unit coordinates after, (modes before, modes after)."""
    tips: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    """Tips that are lost, (lost,)."""
    reach: FloatArray = field(default_factory=lambda: np.zeros(0))
    """Radial distance of the fracture of each lost tip from the wall [m], (lost,)."""


@dataclass(frozen=True, kw_only=True)
class LostBlades(Aftermath):
    """Blades that are lost during a march.

    Tips of lost blades stay in the arrays; they do not move and are far from the wall. The
    extension gives the motion of what remains; the motion of lost parts has no meaning.
    """

    time: float  #: time of the loss [s]


@dataclass(frozen=True, kw_only=True)
class FusedSupport(Aftermath):
    """Springs at the centre whose stiffness changes when their force passes a limit."""

    force: FloatArray  #: force in the springs along x and y [N kg^-1/2 m^-1], (2, modes)
    constant: FloatArray  #: part of the force that does not depend on coordinates [N], (2,)
    limit: float  #: force at which the support fuses [N]


def critical_time_step(
    rotor: ReducedRotor,
    casing: ReducedCasing,
    springs: CouplingSprings | None,
    bearings: Bearings | None = None,
) -> float:
    """Return the stability limit of the time step for central differences, 2 / omega_max [s].

    omega_max is the highest frequency of the bodies including coupling springs and bearings.
    Coriolis forces are neglected: they raise the limit slightly, to omega^2 dt^2 <= 2 + 2 sqrt(1 +
    (Omega g dt)^2) for an eigenvalue i g of M^-1 G.
    """
    highest = max(rotor.highest_frequency, casing.frequency.max(initial=0.0))
    for joined in (springs, bearings):
        if joined is not None:
            highest = max(highest, joined.highest_frequency(rotor.stiffness, casing.frequency**2))
    # Upper bound of the increase of squared frequencies due to unequal bearings.
    increase = abs(rotor.anisotropy) * np.linalg.eigvalsh(rotor.centre @ rotor.centre.T).max()
    return float(2.0 / np.sqrt(highest**2 + increase))
