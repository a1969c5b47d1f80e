"""A bladed disk in modal coordinates, in its rotating frame."""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.elements.cyclic import evenly_spaced
from bladewhirl.models.superelements.further_modes import stiffest


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
    contact: FloatArray
    """Radial, tangential (towards +theta) and axial displacements of the tips of a copy [kg^-1/2],
    (3 * tips, modes)."""
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
    joined: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    """Contact nodes of a copy that are in friction joints and do not touch the wall, (joined,)."""
    wall: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    """Number of the wall around each tip, (all tips,); empty with one wall."""
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
            contact=contact,
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
    def tip_radial(self) -> FloatArray:
        """Radial displacement of the tips of a copy [kg^-1/2], (tips, modes)."""
        return self.contact[0::3]

    @property
    def tip_tangential(self) -> FloatArray:
        """Displacement of the tips of a copy towards +theta [kg^-1/2], (tips, modes)."""
        return self.contact[1::3]

    @property
    def tip_axial(self) -> FloatArray:
        """Axial displacement of the tips of a copy [kg^-1/2], (tips, modes)."""
        return self.contact[2::3]

    def at_tips(self, rows: FloatArray, displacement: FloatArray) -> FloatArray:
        """Return a component of the displacements of all tips, (tips,).

        Args:
            rows: `tip_radial` or another component for the tips of a copy, (tips, modes).
            displacement: modal displacements, (modes,).
        """
        return np.concatenate([rows @ own for own in self.by_copy(displacement)])

    @property
    def all_contact(self) -> sp.csr_array:
        """Displacements of the tips of all copies [kg^-1/2], (3 * all tips, all modes)."""
        return sp.block_diag([self.contact] * self.copies, format="csr")

    @cached_property
    def highest_frequency(self) -> float:
        """Highest frequency of the modes [rad/s]. Tips without mass are then fixed in each
        direction with a residual flexibility."""
        if self.compliance is None:
            return float(np.abs(self.frequency).max(initial=0.0))
        squares, contact = self.by_copy(self.frequency) ** 2, self.contact
        alike, flexible = bool((squares == squares[0]).all()), self.compliance
        if len(self.joined):
            at_wall = np.setdiff1d(np.arange(len(contact) // 3), self.joined)
            if not len(at_wall):
                return float(np.sqrt(squares.max(initial=0.0)))
            kept = (3 * at_wall[:, None] + np.arange(3)).ravel()
            contact, flexible = contact[kept], flexible[:, kept[:, None], kept]
        found = zip(squares, flexible, strict=True)
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
            contact=self.contact[:, modes],
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


def contact_rows(radial: FloatArray, tangential: FloatArray, axial: FloatArray) -> FloatArray:
    """Return `ReducedRotor.contact` of displacements in each direction, (tips, modes) each."""
    return np.stack([radial, tangential, axial], axis=1).reshape(-1, radial.shape[1])
