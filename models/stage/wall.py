"""The wall around a bladed disk: a ring in its modes or rigid, and clearance that is lost."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import block_diag

from bladewhirl.meshes.hermite import cubic_weights
from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.case.closure import Closure

SEEN = 1e-9  #: harmonics below this fraction of the largest value are rounding errors


@dataclass(frozen=True, kw_only=True)
class ReducedCasing:
    """A casing in modal coordinates in the static frame; a rigid wall has no modes. It has one wall
    or several, each around a wheel: the nodes of walls of equal number of nodes follow each
    other."""

    frequency: FloatArray  #: natural frequency [rad/s], (modes,)
    damping_ratio: FloatArray  #: damping ratio of each mode, (modes,)
    nodal: FloatArray
    """Radial displacement w, tangential displacement u and their derivatives by the arc length s
    along the first wall at each node, in the order w, dw/ds, u, du/ds [kg^-1/2], (nodes, 4,
    modes)."""
    clearance: FloatArray  #: clearance and its derivative by s at each node [m, 1], (nodes, 2)
    radius: float  #: radius of the ring, the first one [m]
    column: IntArray
    """Column of the discrete Fourier transform over the nodes to which the shape of each mode
    belongs, (modes,); -1 without symmetry."""
    dampers: FloatArray
    """Rows G of the damping matrix G^T G of point dampers [s^-1/2], (dampers, modes)."""
    supports: int = 0
    """Number of supports of bearings, whose displacements along x and y are the last modes."""
    walls: int = 1  #: number of walls

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
    def wall_modes(self) -> int:
        """Number of modes that move the wall."""
        return len(self.frequency) - 2 * self.supports

    @property
    def is_flexible(self) -> bool:
        """True if modes move the wall."""
        return self.wall_modes > 0

    @property
    def wall(self) -> "ReducedCasing":
        """The casing without supports."""
        return replace(self.take(np.arange(self.wall_modes)), supports=0)

    @property
    def elements(self) -> int:
        """Number of elements, and of nodes, of a wall."""
        return len(self.nodal) // self.walls

    @property
    def closed(self) -> IntArray:
        """Numbers of the nodes of each wall and of its first node again, (walls, elements + 1)."""
        nodes = np.arange(len(self.nodal)).reshape(self.walls, -1)
        return np.hstack([nodes, nodes[:, :1]])

    @property
    def angle(self) -> FloatArray:
        """Angle of each node from +x [rad], (nodes,)."""
        return np.tile(2.0 * np.pi * np.arange(self.elements) / self.elements, self.walls)

    @property
    def element_length(self) -> float:
        """Arc length of one element of the first wall [m]."""
        return 2.0 * np.pi * self.radius / self.elements

    @property
    def by_harmonics(self) -> bool:
        """True if time integration treats each harmonic separately.

        This needs symmetry, and more modes than nodes; with fewer modes dense products are faster.
        """
        return len(self.column) > len(self.nodal) and bool(np.all(self.column >= 0))

    def shapes_at(self, angle: FloatArray, wall: int | IntArray = 0) -> FloatArray:
        """Return the radial and tangential displacements of a wall, or of one for each angle, at
        angles [rad] for unit modal coordinates [kg^-1/2], (angles, 2, modes)."""
        found = np.zeros((len(angle), 2, len(self.frequency)))
        for direction, rows in enumerate((slice(0, 2), slice(2, 4))):
            for mode in range(len(self.frequency)):
                found[:, direction, mode] = self.at(self.nodal[:, rows, mode], angle, wall)
        return found

    def at(self, field: FloatArray, angle: FloatArray, wall: int | IntArray = 0) -> FloatArray:
        """Return a field (nodes, 2) on a wall, or on one for each angle, at angles [rad], see
        `around_wall`."""
        if self.walls == 1:
            return around_wall(field, self.element_length, angle)
        own = np.broadcast_to(wall, angle.shape)
        each = [around_wall(one, self.element_length, angle) for one in np.split(field, self.walls)]
        return np.asarray(np.take_along_axis(np.stack(each), own[None], axis=0)[0])

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


def joined_walls(rings: Sequence[ReducedCasing]) -> ReducedCasing:
    """Return the casing of several rings of equal number of elements, each around a wheel; one ring
    as it is."""
    first, *others = rings
    if not others:
        return first
    # A slope is multiplied by the arc length of an element, for all walls that of the first.
    scale = [np.array([1.0, one.radius / first.radius]) for one in rings]
    nodal = [one.nodal * np.tile(own, 2)[:, None] for one, own in zip(rings, scale, strict=True)]
    return replace(
        first,
        frequency=np.concatenate([one.frequency for one in rings]),
        damping_ratio=np.concatenate([one.damping_ratio for one in rings]),
        nodal=np.concatenate(
            [block_diag(*(one[:, kind] for one in nodal))[:, None] for kind in range(4)], axis=1
        ),
        clearance=np.concatenate(
            [one.clearance * own for one, own in zip(rings, scale, strict=True)]
        ),
        column=np.full(sum(len(one.frequency) for one in rings), -1),
        dampers=block_diag(*(one.dampers for one in rings)),
        walls=len(rings),
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


def harmonics_around(clearance: FloatArray) -> dict[int, complex]:
    """Return the complex amplitudes of the harmonics n > 0 of a clearance (angles,) that are no
    rounding errors, by n, for the factor exp(i n theta) [m]."""
    amplitude = 2.0 * np.fft.rfft(clearance) / len(clearance)
    smallest = 2.0 * SEEN * np.abs(clearance).max()
    return {
        int(n): complex(amplitude[n]) for n in np.flatnonzero(np.abs(amplitude) > smallest) if n
    }


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
