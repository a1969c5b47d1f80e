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

from bladewhirl.meshes.hermite import cubic_weights
from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.case.closure import Closure
from bladewhirl.models.coupling.equations import difference_of_axes
from bladewhirl.models.coupling.springs import CouplingSprings
from bladewhirl.models.elements.cyclic import evenly_spaced
from bladewhirl.models.stage.varying_speed import FreeSpeed, Rotation, SpeedChange
from bladewhirl.models.superelements.further_modes import stiffest

Bodies = list[tuple[FloatArray, FloatArray]]
"""Radial displacements of the surface of each body for unit modal coordinates, and frequencies of
the modes."""

NEVER = np.inf  #: end time of a load that does not end

ROUNDING = 1e-9
"""A negative damping rate up to this fraction of the largest one is a rounding error."""


@dataclass(frozen=True, kw_only=True)
class ReducedRotor:
    """A bladed disk in modal coordinates in the rotating frame.

    It consists of one structure, or of equal or similar structures, called copies, that do not
    influence each other. Modal coordinates and tips of a copy follow those of the copy before.
    """

    frequency: FloatArray
    """Frequency [rad/s], (modes,); negative if spin softening makes its square negative, see
    `stiffness`."""
    damping_ratio: FloatArray  #: damping ratio of each mode, (modes,)
    tip_radial: FloatArray  #: radial displacement of the tips of a copy [kg^-1/2], (tips, modes)
    tip_tangential: FloatArray
    """Displacement of the tips of a copy towards +theta [kg^-1/2], (tips, modes)."""
    tip_axial: FloatArray  #: axial displacement of the tips of a copy [kg^-1/2], (tips, modes)
    centre: FloatArray  #: x and y of the centre node [kg^-1/2], (2, modes); zero if clamped
    tip_angle: FloatArray  #: angle of each tip from +x [rad], (tips,)
    tip_radius: float  #: radius from which the clearance is measured [m]
    tip_recess: FloatArray  #: `tip_radius` minus the radius of each tip [m], (tips,)
    contact_radius: FloatArray  #: radius of the tips of a copy [m], (tips,)
    column: IntArray
    """Column of the discrete Fourier transform (DFT) over the tips to which the shape of each mode
    belongs, (modes,); -1 without symmetry."""
    dampers: FloatArray
    """Rows G of the damping matrix G^T G of point dampers [s^-1/2], (dampers, modes)."""
    anisotropy: float = 0.0
    """Half the difference of the springs at the centre that are fixed in the static frame:
    stiffness along x minus stiffness along y [N/m]."""
    by_velocity: FloatArray | None = None
    """Matrix of the Coriolis forces 2 Omega G and of the damping that does not follow from
    `damping_ratio` and `dampers` [1/s], (modes, modes), of one copy; None without such forces. With
    this matrix, dampers respond to contact within the time step."""
    copies: int = 1  #: number of copies
    compliance: FloatArray | None = None
    """Residual flexibility of the tips of each copy [m/N], (copies, 3 * tips, 3 * tips); the first
    three rows belong to tip 0. Tips with this flexibility have no mass. None: tips move with the
    modes only."""
    normal_share: float | FloatArray = 1.0
    """Part of radial lengths that is normal to the wall at each tip of a copy, where the slope of
    the wall varies, (tips,); a slope common to all tips is in the clearance."""
    circulation: float = 0.0
    """Damping at the centre in the static frame, times the speed [N/m]. In rotating axes a
    displacement (x, y) of the centre causes the force `circulation` times (y, -x)."""

    @classmethod
    def of_copies(
        cls,
        *,
        frequency: FloatArray,
        damping_ratio: FloatArray,
        contact: FloatArray,
        compliance: FloatArray | None,
        angle: FloatArray,
        radius: FloatArray,
        recess: FloatArray,
        tip_radius: float,
        centre: FloatArray | None = None,
        by_velocity: FloatArray | None = None,
    ) -> "ReducedRotor":
        """Return a rotor of copies with contact nodes.

        Args:
            frequency: frequency of each mode [rad/s], (copies, modes).
            damping_ratio: damping ratio of each mode, (copies, modes).
            contact: radial, tangential and axial displacements of the contact nodes of a copy
                [kg^-1/2], (3 * nodes, modes).
            compliance: see `ReducedRotor`.
            angle: angle of each contact node from +x [rad], (copies, nodes).
            radius: radius of the contact nodes of a copy [m], (nodes,).
            recess: `tip_radius` minus the radius of the contact nodes of a copy [m], (nodes,).
            tip_radius: radius from which the clearance is measured [m].
            centre: x and y of the centre of a copy [kg^-1/2], (2, modes); None if it is fixed.
            by_velocity: see `ReducedRotor`.
        """
        copies, modes = frequency.shape
        return cls(
            frequency=frequency.ravel(),
            damping_ratio=damping_ratio.ravel(),
            tip_radial=contact[0::3],
            tip_tangential=contact[1::3],
            tip_axial=contact[2::3],
            centre=np.zeros((2, copies * modes)) if centre is None else np.tile(centre, copies),
            tip_angle=angle.ravel(),
            tip_radius=tip_radius,
            tip_recess=np.tile(recess, copies),
            contact_radius=radius,
            column=np.full(copies * modes, -1),
            dampers=np.zeros((0, copies * modes)),
            by_velocity=by_velocity,
            copies=copies,
            compliance=compliance,
        )

    @property
    def normal_part(self) -> FloatArray:
        """See `normal_share`, (all tips,)."""
        of_copy = np.broadcast_to(self.normal_share, len(self.tip_angle) // self.copies)
        return np.tile(of_copy, self.copies)

    @property
    def stiffness(self) -> FloatArray:
        """Squared frequencies with their signs [rad2/s2], (modes,)."""
        return self.frequency * np.abs(self.frequency)

    @property
    def velocity_forces(self) -> FloatArray:
        """Matrix of all forces due to velocities, damping and Coriolis forces, of each copy [1/s],
        (copies, modes, modes). Dampers need a rotor of one copy."""
        ratio, frequency = self.by_copy(self.damping_ratio), self.by_copy(self.frequency)
        rates = 2.0 * ratio * np.abs(frequency)
        coupled = 0.0 if self.by_velocity is None else self.by_velocity
        joined = self.dampers.T @ self.dampers if len(self.dampers) else 0.0
        return np.array([np.diag(row) + joined + coupled for row in rates])

    @property
    def damping(self) -> FloatArray:
        """The only matrix of `velocity_forces` of a rotor of one copy [1/s], (modes, modes)."""
        (only,) = self.velocity_forces
        return np.asarray(only)

    def by_copy(self, values: FloatArray) -> FloatArray:
        """Return values of all modes or of all tips by copy, (copies, modes) or (copies, tips)."""
        return values.reshape(self.copies, -1)

    @property
    def contact(self) -> FloatArray:
        """Radial, tangential and axial displacements of the tips of a copy [kg^-1/2],
        (3 * tips, modes)."""
        components = (self.tip_radial, self.tip_tangential, self.tip_axial)
        return np.stack(components, axis=1).reshape(-1, self.tip_radial.shape[1])

    def at_tips(self, rows: FloatArray, displacement: FloatArray) -> FloatArray:
        """Return a component of the displacements of all tips, (tips,).

        Args:
            rows: `tip_radial` or another component for the tips of a copy, (tips, modes).
            displacement: modal displacements, (modes,).
        """
        return np.concatenate([rows @ own for own in self.by_copy(displacement)])

    @property
    def highest_frequency(self) -> float:
        """Highest frequency of the modes [rad/s]. Tips without mass are then fixed in each
        direction with a residual flexibility."""
        if self.compliance is None:
            return float(np.abs(self.frequency).max(initial=0.0))
        squares, contact = self.by_copy(self.frequency) ** 2, self.contact
        alike = bool((squares == squares[0]).all())
        found = zip(squares, self.compliance, strict=True)
        chosen = [next(found)] if alike else list(found)
        return max(stiffest(square, contact, compliance) for square, compliance in chosen)

    @property
    def circulation_stiffness(self) -> FloatArray:
        """Skew stiffness due to dampers in the static frame [rad2/s2], (modes, modes)."""
        x, y = self.centre
        return np.asarray(self.circulation * (np.outer(y, x) - np.outer(x, y)))

    @property
    def by_harmonics(self) -> bool:
        """True if time integration treats each harmonic of the DFT columns separately.

        This needs symmetry, and more modes than tips; with fewer modes dense products are faster.
        """
        tips = len(self.tip_angle)
        return (
            3 <= tips < len(self.column)
            and bool(np.all(self.column >= 0))
            and evenly_spaced(self.tip_angle)
        )

    def take(self, modes: IntArray) -> "ReducedRotor":
        """Return the rotor with the chosen modes; one of several copies has all of them."""
        if len(modes) == len(self.frequency):
            return self
        return replace(
            self,
            frequency=self.frequency[modes],
            damping_ratio=self.damping_ratio[modes],
            tip_radial=self.tip_radial[:, modes],
            tip_tangential=self.tip_tangential[:, modes],
            tip_axial=self.tip_axial[:, modes],
            centre=self.centre[:, modes],
            column=self.column[modes],
            dampers=self.dampers[:, modes],
            by_velocity=(
                None if self.by_velocity is None else self.by_velocity[np.ix_(modes, modes)]
            ),
        )

    def turning_force(self, displacement: FloatArray, velocity: FloatArray) -> FloatArray:
        """Return the modal forces due to `by_velocity` and due to `circulation`, (modes,).

        Args:
            displacement: modal displacements, (modes,).
            velocity: modal velocities, (modes,).
        """
        force = np.zeros(len(displacement))
        if self.circulation != 0.0:
            force = -self.circulation_stiffness @ displacement
        if self.by_velocity is None:
            return force
        each = [self.by_velocity @ own for own in self.by_copy(velocity)]
        return np.asarray(force - np.concatenate(each))


@dataclass(frozen=True, kw_only=True)
class ReducedCasing:
    """A casing in modal coordinates in the static frame; a rigid wall has no modes."""

    frequency: FloatArray  #: natural frequency [rad/s], (modes,)
    damping_ratio: FloatArray  #: damping ratio of each mode, (modes,)
    nodal: FloatArray
    """Radial displacement w, tangential displacement u and their derivatives by the arc length s at
    each node, in the order w, dw/ds, u, du/ds [kg^-1/2], (nodes, 4, modes)."""
    clearance: FloatArray  #: clearance and its derivative by s at each node [m, 1], (nodes, 2)
    radius: float  #: radius of the ring [m]
    column: IntArray
    """Column of the discrete Fourier transform over the nodes to which the shape of each mode
    belongs, (modes,); -1 without symmetry."""
    dampers: FloatArray
    """Rows G of the damping matrix G^T G of point dampers [s^-1/2], (dampers, modes)."""

    @classmethod
    def rigid(cls, clearance: FloatArray, radius: float) -> "ReducedCasing":
        """Return a rigid wall.

        Args:
            clearance: clearance and its derivative by the arc length at equal angles, (nodes, 2).
            radius: radius of the wall [m].
        """
        none = np.zeros(0)
        return cls(
            frequency=none,
            damping_ratio=none,
            nodal=np.zeros((len(clearance), 4, 0)),
            clearance=clearance,
            radius=radius,
            column=np.zeros(0, dtype=np.int64),
            dampers=np.zeros((0, 0)),
        )

    @property
    def is_flexible(self) -> bool:
        """True if the casing has modes."""
        return len(self.frequency) > 0

    @property
    def angle(self) -> FloatArray:
        """Angle of each node from +x [rad], (nodes,)."""
        nodes = len(self.nodal)
        return np.asarray(2.0 * np.pi * np.arange(nodes) / nodes)

    @property
    def element_length(self) -> float:
        """Arc length of one element [m]."""
        return 2.0 * np.pi * self.radius / len(self.nodal)

    @property
    def by_harmonics(self) -> bool:
        """True if time integration treats each harmonic separately.

        This needs symmetry, and more modes than nodes; with fewer modes dense products are faster.
        """
        return len(self.column) > len(self.nodal) and bool(np.all(self.column >= 0))

    def shapes_at(self, angle: FloatArray) -> FloatArray:
        """Return the radial and tangential displacements at angles [rad] for unit modal
        coordinates [kg^-1/2], (angles, 2, modes)."""
        found = np.zeros((len(angle), 2, len(self.frequency)))
        for direction, rows in enumerate((slice(0, 2), slice(2, 4))):
            for mode in range(len(self.frequency)):
                field = self.nodal[:, rows, mode]
                found[:, direction, mode] = around_wall(field, self.element_length, angle)
        return found

    def take(self, modes: IntArray) -> "ReducedCasing":
        """Return the casing with the chosen modes."""
        if len(modes) == len(self.frequency):
            return self
        return replace(
            self,
            frequency=self.frequency[modes],
            damping_ratio=self.damping_ratio[modes],
            nodal=self.nodal[..., modes],
            column=self.column[modes],
            dampers=self.dampers[:, modes],
        )


@dataclass(frozen=True, kw_only=True)
class WallClosure:
    """Clearance that is lost over time."""

    course: Closure  #: closure over time
    share: FloatArray
    """Closure at each node divided by that of `course`, and the derivative of this ratio by the arc
    length s [1, 1/m], (nodes, 2)."""

    @classmethod
    def around(
        cls, course: Closure | None, wall: ReducedCasing, normal: float
    ) -> "WallClosure | None":
        """Return the closure around a wall, whose radial lengths have the part `normal` across it;
        None if `course` is None."""
        if course is None:
            return None
        share = [course.around.value(wall.angle), course.around.slope(wall.angle) / wall.radius]
        return cls(course=course, share=normal * np.column_stack(share))

    def at(self, time: float) -> FloatArray:
        """Return the closure and its derivative by s at each node [m, 1], (nodes, 2)."""
        return np.asarray(self.course.value(time) * self.share)


@dataclass(frozen=True, kw_only=True)
class WallCoating:
    """Abradable coating on the wall: elastic-plastic rods in tracks, one track for each axial
    position of tips.

    Source: Legrand, Batailly and Pierre, J. Comput. Nonlinear Dyn. 7 (2012).
    """

    thickness: float  #: thickness [m]
    young_modulus: float  #: Young's modulus [Pa]
    yield_stress: float  #: yield stress [Pa]
    hardening: float  #: increase of the yield stress per plastic strain [Pa]
    limit: float  #: largest plastic strain
    strain: FloatArray  #: plastic strain of each rod at the start, (tracks, rods)
    axial: FloatArray  #: axial position of each track [m], (tracks,)
    width: FloatArray  #: size of each track along the axis [m], (tracks,)
    track: IntArray  #: track of each tip of a copy, (tips,)
    footprint: FloatArray  #: arc that each tip of a copy covers [m], (tips,)
    radius: float  #: radius of the wall [m]

    @property
    def removable(self) -> float:
        """Depth of the metal below the surface of the new coating [m]."""
        return self.limit * self.thickness

    @property
    def arc(self) -> float:
        """Arc length of a rod [m]."""
        return float(2.0 * np.pi * self.radius / self.strain.shape[1])


@dataclass(frozen=True, kw_only=True)
class Foreshortening:
    """Quadratic forms of the distances by which tips move inward as their blades bend.

    The gap of tip j opens by 1/2 sum_i s_ji y_ji^2 with y_j = F_j x and the modal displacements x
    of the rotor.
    """

    rows: FloatArray  #: rows F of each tip [kg^-1/2 m^-1/2], (tips, terms, rotor modes)
    sign: FloatArray  #: signs s, 1 or -1, or 0 for terms that a tip does not have, (tips, terms)
    frequency: float  #: frequency of the fastest large term [rad/s]

    def opening(self, displacement: FloatArray) -> FloatArray:
        """Return the opening of each gap [m], (..., tips).

        Args:
            displacement: modal displacements of the rotor, (..., modes).
        """
        bent = np.einsum("jim,...m->...ji", self.rows, displacement)
        return np.asarray(0.5 * np.einsum("ji,...ji->...j", self.sign, bent**2))


def rod_angles(rods: int) -> FloatArray:
    """Return the angle of the middle of each rod of a coating [rad], (rods,)."""
    return np.asarray(2.0 * np.pi / rods * (np.arange(rods) + 0.5))


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

    def amplitude(self, time: float, turned: "Rotation", base: float) -> float:
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
    closure: WallClosure | None = None  #: clearance that is lost over time
    coating: WallCoating | None = None  #: abradable coating
    foreshortening: Foreshortening | None = None  #: gaps that open as blades bend
    slope: float | FloatArray = 0.0
    """Slope of a conical wall [rad], in whose axes contact nodes move, see `cone`; under a contour
    that of each contact node of a copy, (nodes,)."""
    change: SpeedChange | None = None  #: None for a constant speed
    drive: FreeSpeed | None = None  #: None for a prescribed speed
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
        pushed = casing.shapes_at(rotor.tip_angle + turned.angle)
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
        if self.springs is not None or rotor.anisotropy or rotor.circulation:
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
        surface = around_wall(field, casing.element_length, angle)
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
        return critical_time_step(self.rotor, self.casing, self.springs)

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


def around_wall(field: FloatArray, length: float, angle: FloatArray) -> FloatArray:
    """Return a field on the wall at angles by Hermite interpolation, in the shape of the angles.

    Args:
        field: value and derivative by the arc length at equally spaced angles, (nodes, 2).
        length: arc length between two of these angles [m].
        angle: angles from +x [rad], any shape.
    """
    nodes = len(field)
    position = np.mod(angle * nodes / (2.0 * np.pi), nodes)
    element = position.astype(np.int64) % nodes
    first, second = field[element], field[(element + 1) % nodes]
    at = cubic_weights(position - np.floor(position), length)
    return np.asarray(
        at[0] * first[..., 0]
        + at[1] * first[..., 1]
        + at[2] * second[..., 0]
        + at[3] * second[..., 1]
    )


def critical_time_step(
    rotor: ReducedRotor, casing: ReducedCasing, springs: CouplingSprings | None
) -> float:
    """Return the stability limit of the time step for central differences, 2 / omega_max [s].

    omega_max is the highest frequency of the bodies including coupling springs. Coriolis forces are
    neglected: they raise the limit slightly, to omega^2 dt^2 <= 2 + 2 sqrt(1 + (Omega g dt)^2) for
    an eigenvalue i g of M^-1 G.
    """
    highest = max(rotor.highest_frequency, casing.frequency.max(initial=0.0))
    if springs is not None:
        highest = max(highest, springs.highest_frequency)
    # Upper bound of the increase of squared frequencies due to unequal bearings.
    increase = abs(rotor.anisotropy) * np.linalg.eigvalsh(rotor.centre @ rotor.centre.T).max()
    return float(2.0 / np.sqrt(highest**2 + increase))


def at_rest(rotor: ReducedRotor, casing: ReducedCasing) -> Start:
    """Return a start without displacement and velocity."""
    still = np.zeros(len(rotor.frequency))
    return Start.of_rotor(still, still, len(casing.frequency))
