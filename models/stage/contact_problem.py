"""Arrays that define a contact problem: two reduced bodies, loads, contact law, initial state.

The rotor is described in its rotating frame, the casing in the static frame. Both are
mass-normalised modal models; matrices give the motion of the tips, of the centre and of the nodes
of the casing for unit modal coordinates. Rotor and casing can be any structures. Time integration
uses their cyclic symmetry, if the modes have DFT columns.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.case.closure import Closure
from bladewhirl.models.case.schemes import SCHEMES
from bladewhirl.models.coupling.equations import difference_of_axes
from bladewhirl.models.coupling.springs import CouplingSprings
from bladewhirl.models.elements.cyclic import evenly_spaced

Bodies = list[tuple[FloatArray, FloatArray]]
"""Radial displacements of the surface of each body for unit modal coordinates, and frequencies of
the modes."""

NEVER = np.inf  #: end time of a load that does not end


@dataclass(frozen=True, kw_only=True)
class ReducedRotor:
    """A bladed disk in modal coordinates in the rotating frame."""

    frequency: FloatArray
    """Frequency [rad/s], (modes,); negative if spin softening makes its square negative, see
    `stiffness`."""
    damping_ratio: FloatArray  #: damping ratio of each mode, (modes,)
    tip_radial: FloatArray  #: radial displacement of each tip [kg^-1/2], (tips, modes)
    tip_tangential: FloatArray  #: displacement of each tip towards +theta [kg^-1/2], (tips, modes)
    centre: FloatArray  #: x and y of the centre node [kg^-1/2], (2, modes); zero if clamped
    tip_angle: FloatArray  #: angle of each tip from +x [rad], (tips,)
    tip_radius: float  #: radius from which the clearance is measured [m]
    tip_recess: FloatArray  #: `tip_radius` minus the radius of each tip [m], (tips,)
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
    `damping_ratio` and `dampers` [1/s], (modes, modes); None without Coriolis forces. With this
    matrix, dampers respond to contact within the time step."""
    circulation: float = 0.0
    """Damping at the centre in the static frame, times the speed [N/m]. In rotating axes a
    displacement (x, y) of the centre causes the force `circulation` times (y, -x)."""

    @property
    def stiffness(self) -> FloatArray:
        """Squared frequencies with their signs [rad2/s2], (modes,)."""
        return self.frequency * np.abs(self.frequency)

    @property
    def damping(self) -> FloatArray:
        """Matrix of all forces due to velocities, including Coriolis forces [1/s], (modes,
        modes)."""
        by_ratio = np.diag(2.0 * self.damping_ratio * np.abs(self.frequency))
        coupled = 0.0 if self.by_velocity is None else self.by_velocity
        return np.asarray(by_ratio + self.dampers.T @ self.dampers + coupled)

    @property
    def circulation_stiffness(self) -> FloatArray:
        """Skew stiffness due to dampers in the static frame [rad2/s2], (modes, modes)."""
        x, y = self.centre
        return np.asarray(self.circulation * (np.outer(y, x) - np.outer(x, y)))

    @property
    def by_harmonics(self) -> bool:
        """True if time integration treats each harmonic separately.

        This needs symmetry, and more modes than tips; with fewer modes dense products are faster.
        """
        tips = len(self.tip_angle)
        return (
            3 <= tips < len(self.column)
            and bool(np.all(self.column >= 0))
            and evenly_spaced(self.tip_angle)
        )

    def take(self, modes: IntArray) -> "ReducedRotor":
        """Return the rotor with the chosen modes."""
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
        """Return the modal forces due to `by_velocity` and due to `circulation`, (modes,).

        Args:
            displacement: modal displacements, (modes,).
            velocity: modal velocities, (modes,).
        """
        force = -self.circulation_stiffness @ displacement
        return force if self.by_velocity is None else force - self.by_velocity @ velocity


@dataclass(frozen=True, kw_only=True)
class ReducedCasing:
    """A casing in modal coordinates in the static frame."""

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

    def take(self, modes: IntArray) -> "ReducedCasing":
        """Return the casing with the chosen modes."""
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
        cls, course: Closure | None, angle: FloatArray, radius: float = 1.0
    ) -> "WallClosure | None":
        """Return the closure at angles [rad] around a ring; None if `course` is None. Derivatives
        are with respect to the arc length at the radius [m]; by default, to the angle."""
        if course is None:
            return None
        share = [course.around.value(angle), course.around.slope(angle) / radius]
        return cls(course=course, share=np.column_stack(share))

    def at(self, time: float) -> FloatArray:
        """Return the closure and its derivative by s at each node [m, 1], (nodes, 2)."""
        return np.asarray(self.course.value(time) * self.share)


@dataclass(frozen=True, kw_only=True)
class CoatingLaw:
    """Law of the elastic-plastic rods of an abradable coating.

    Source: Legrand, Batailly and Pierre, J. Comput. Nonlinear Dyn. 7 (2012).
    """

    thickness: float  #: thickness [m]
    young_modulus: float  #: Young's modulus [Pa]
    yield_stress: float  #: yield stress [Pa]
    hardening: float  #: increase of the yield stress per plastic strain [Pa]
    limit: float  #: largest plastic strain

    @property
    def removable(self) -> float:
        """Depth of the metal below the surface of the new coating [m]."""
        return self.limit * self.thickness


@dataclass(frozen=True, kw_only=True)
class WallCoating(CoatingLaw):
    """Abradable coating on the inner face of the casing: rods at equal angles."""

    strain: FloatArray  #: plastic strain of each rod at the start, (rods,)
    footprint: FloatArray  #: arc that each tip covers [m], (tips,)
    arc: float  #: arc length of a rod [m]
    width: float  #: width of the coating [m]
    friction: float  #: friction coefficient

    @property
    def area(self) -> float:
        """Area of a rod [m2]."""
        return self.arc * self.width

    @property
    def angle(self) -> FloatArray:
        """Angle of the middle of each rod [rad], (rods,)."""
        return rod_angles(len(self.strain))

    @property
    def stiffness(self) -> float:
        """Largest stiffness under a tip [N/m]."""
        rods = float(np.floor(self.footprint.max() / self.arc)) + 1.0
        return float(self.young_modulus * self.area / self.thickness * rods)


@dataclass(frozen=True, kw_only=True)
class NodeCoating(CoatingLaw):
    """Abradable coating under many contact nodes: rods in tracks, one track for each axial position
    of contact nodes."""

    strain: FloatArray  #: plastic strain of each rod at the start, (tracks, rods)
    axial: FloatArray  #: axial position of each track [m], (tracks,)
    width: FloatArray  #: size of each track along the axis [m], (tracks,)
    track: IntArray  #: track of each contact node of a copy, (nodes,)
    footprint: FloatArray  #: arc that each contact node of a copy covers [m], (nodes,)
    radius: float  #: radius of the wall [m]

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

    rotor: FloatArray
    """Modal force [N kg^-1/2], (rotor modes,); for a superelement (copies, modes)."""
    casing: FloatArray = field(default_factory=lambda: np.zeros(0))
    """Modal force [N kg^-1/2], (casing modes,); empty for a rigid wall."""
    end: float = NEVER  #: the load is zero from this time on [s]
    ramp: float = 0.0  #: length of the half-cosine ramp from zero [s]
    frequency: float = 0.0  #: frequency of the cosine [rad/s]
    phase: float = 0.0  #: phase of the cosine [rad]

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
        )


@dataclass(frozen=True, kw_only=True)
class ContactProblem:
    """All data of a march except its time steps and its scheme."""

    schemes: ClassVar[Mapping[str, str]] = SCHEMES  #: classes of the schemes, by name

    rotor: ReducedRotor
    casing: ReducedCasing
    speed: float  #: speed of rotation Omega, counter-clockwise [rad/s]
    friction: float  #: Coulomb friction coefficient
    sliding: Literal["permanent", "signed"]  #: see `contact.sliding` of a case
    tip_rotation: bool  #: true to add u_t / R to the angle of a tip
    displacement_limit: float  #: displacement at which a march ends as divergent [m]
    loads: tuple[Load, ...]
    start: Start
    springs: CouplingSprings | None = None  #: springs between the bodies
    closure: WallClosure | None = None  #: clearance that is lost over time
    coating: WallCoating | None = None  #: abradable coating
    foreshortening: Foreshortening | None = None  #: gaps that open as blades bend
    restitution: float = 0.0  #: restitution coefficient e of the scheme "moreau-jean"
    penalty_stiffness: float = 1e9  #: contact stiffness of the scheme "penalty" [N/m]
    stick_speed: float = 0.01
    """Sliding speed up to which friction in the scheme "penalty" is proportional to the speed
    [m/s]."""

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
        clearance = float(casing.clearance[:, 0].min() + rotor.tip_recess.min())
        return clearance, [
            (rotor.tip_radial, rotor.frequency),
            (casing.nodal[:, 0], casing.frequency),
        ]

    @property
    def critical_time_step(self) -> float:
        """Stability limit of the time step for central differences [s]."""
        return critical_time_step(self.rotor, self.casing, self.springs)

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
            place = self.springs.places(rotor)
            stiffness[..., place[:, None], place] += self.springs.stiffness(angle=angle)
        return stiffness


def critical_time_step(
    rotor: ReducedRotor, casing: ReducedCasing, springs: CouplingSprings | None
) -> float:
    """Return the stability limit of the time step for central differences, 2 / omega_max [s].

    omega_max is the highest frequency of the bodies including coupling springs. Coriolis forces are
    neglected: they raise the limit slightly, to omega^2 dt^2 <= 2 + 2 sqrt(1 + (Omega g dt)^2) for
    an eigenvalue i g of M^-1 G.
    """
    highest = max(np.abs(rotor.frequency).max(initial=0.0), casing.frequency.max(initial=0.0))
    if springs is not None:
        highest = max(highest, springs.highest_frequency)
    # Upper bound of the increase of squared frequencies due to unequal bearings.
    increase = abs(rotor.anisotropy) * np.linalg.eigvalsh(rotor.centre @ rotor.centre.T).max()
    return float(2.0 / np.sqrt(highest**2 + increase))


def at_rest(rotor: ReducedRotor, casing: ReducedCasing) -> Start:
    """Return a start without displacement and velocity."""
    still = np.zeros(len(rotor.frequency))
    return Start.of_rotor(still, still, len(casing.frequency))
