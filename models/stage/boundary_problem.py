"""Arrays that define a contact problem with many contact nodes."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from bladewhirl.meshes.hermite import cubic_weights
from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.schemes import NODE_SCHEMES
from bladewhirl.models.stage.contact_problem import (
    Bodies,
    ContactProblem,
    Load,
    NodeCoating,
    ReducedCasing,
    Start,
    WallClosure,
)

ROUNDING = 1e-9
"""A negative damping rate up to this fraction of the largest one is a rounding error."""

RIGID = 1e-6
"""An eigenvector of the residual flexibility counts as rigid if its eigenvalue is at most this
fraction of the largest."""


@dataclass(frozen=True, kw_only=True)
class BoundaryProblem:
    """Equal or similar structures, called copies, inside a rigid wall or a flexible ring; all in
    modal coordinates."""

    schemes: ClassVar[Mapping[str, str]] = NODE_SCHEMES  #: classes of the schemes, by name

    frequency: FloatArray  #: frequency of each mode [rad/s], (copies, modes)
    damping_ratio: FloatArray  #: damping ratio of each mode, (copies, modes)
    by_velocity: FloatArray | None = None
    """Matrix of the Coriolis forces and of the damping that `damping_ratio` does not contain, equal
    for all copies [1/s], (modes, modes); None without such forces."""
    contact: FloatArray
    """Radial, tangential and axial displacements of the contact nodes of a copy for unit modal
    coordinates [kg^-1/2], (3 * nodes, modes)."""
    compliance: FloatArray
    """Residual flexibility of the contact nodes of each copy [m/N], (copies, 3 * nodes,
    3 * nodes); zero if the contact nodes have mass."""
    massless: bool  #: true if the contact nodes have no mass
    angle: FloatArray  #: angle of each contact node from +x at t = 0 [rad], (copies, nodes)
    radius: FloatArray  #: radius of the contact nodes of a copy [m], (nodes,)
    recess: FloatArray
    """Radius from which the clearance is measured, minus the radius of each contact node [m],
    (nodes,). With a coating, the depth of the metal below the surface of the coating is added."""
    wall: FloatArray
    """Clearance [m] and its derivative with respect to the angle [m], (angles, 2), at equally
    spaced angles from 0 or at the nodes of a flexible casing."""
    speed: float  #: speed of rotation [rad/s]
    friction: float  #: friction coefficient
    full_sliding: bool
    """True if friction is opposite to the slip velocity in the contact plane; false if it acts
    against the rotation."""
    displacement_limit: float  #: largest radial displacement of a contact node [m]
    start: Start  #: motion of each copy, and of the casing, at t = 0
    loads: tuple[Load, ...] = ()  #: loads, with forces on each copy
    casing: ReducedCasing | None = None  #: flexible casing; None: a rigid wall
    coating: NodeCoating | None = None  #: abradable coating
    closure: WallClosure | None = None
    """Closure of the clearance over time; `share` has the form of `wall`."""

    @property
    def initial_gap(self) -> FloatArray:
        """Gap of each contact node at t = 0 [m], (copies, nodes)."""
        values = self.wall if self.closure is None else self.wall - self.closure.at(0.0)
        angles = len(values)
        place = np.mod(self.angle * angles / (2.0 * np.pi), angles)
        first = place.astype(np.int64) % angles
        one, two = values[first], values[(first + 1) % angles]
        at = cubic_weights(place - np.floor(place), 2.0 * np.pi / angles)
        clearance = at[0] * one[..., 0] + at[1] * one[..., 1]
        clearance = clearance + at[2] * two[..., 0] + at[3] * two[..., 1]
        return np.asarray(clearance + self.recess - self.start.rotor @ self.contact[::3].T)

    def free_bodies(self) -> tuple[float, Bodies]:
        """Return the smallest clearance of the contact nodes [m], and the bodies.

        Raises:
            ValueError: the energy of free motion need not decay; the message states the reason.
        """
        damping = np.diag((2.0 * self.damping_ratio * self.frequency).min(axis=0))
        if self.by_velocity is not None:
            damping = damping + 0.5 * (self.by_velocity + self.by_velocity.T)
        rates = np.linalg.eigvalsh(damping)
        if rates[0] < -ROUNDING * max(rates[-1], 0.0):
            raise ValueError("the damping matrix of the superelement feeds energy to some motion")
        covered = 0.0 if self.coating is None else self.coating.removable
        clearance = float(self.wall[:, 0].min() + self.recess.min() - covered)
        bodies = [(self.contact[::3], frequency) for frequency in self.frequency]
        if self.casing is not None:
            bodies.append((self.casing.nodal[:, 0], self.casing.frequency))
        return clearance, bodies

    @property
    def critical_time_step(self) -> float:
        """Largest stable time step [s]: 2 / omega with the highest frequency of the modes. Massless
        contact nodes are then fixed in each direction with a residual flexibility."""
        highest = 0.0 if self.casing is None else self.casing.frequency.max()
        return float(2.0 / max(self._highest_frequency, highest))

    @property
    def _highest_frequency(self) -> float:
        squares = self.frequency**2
        if not self.massless:
            return float(np.sqrt(squares.max()))
        stiffest = 0.0
        for copy, square in enumerate(squares):
            flexibility, ways = np.linalg.eigh(self.compliance[copy])
            flexible = flexibility > RIGID * flexibility[-1]
            rows = (ways[:, flexible] / np.sqrt(flexibility[flexible])).T @ self.contact
            constrained = rows.T @ rows
            stiffest = max(stiffest, np.linalg.eigvalsh(np.diag(square) + constrained)[-1])
            if np.array_equal(squares, np.broadcast_to(squares[0], squares.shape)):
                break
        return float(np.sqrt(stiffest))


Problem = ContactProblem | BoundaryProblem
"""Arrays that define a contact problem, of tips of beams or of contact nodes."""
