"""A wheel whose neighbouring blades touch in joints or rub, for motions that follow one another.

Joint j ties the right nodes of blade j to the left nodes of blade j + 1, counter-clockwise. With
the normal n, which points from j to j + 1, and two tangents as columns of A, in the radial,
tangential and axial directions at the joint,

    d = A^T (u_left(j + 1) - u_right(j)),      g = g_0 + d_n,

forces l on the joint act on blade j + 1 and -l on blade j. In a wave of nodal diameter k, blade
j + 1 is ahead of blade j by the phase 2 pi k / N. On the displacements (A^T u_left, -A^T u_right)
of one blade the rows R_k = [exp(2 pi i k / N) 1, 1] give d, and R_k^* l are the forces; nodes have
their own radial and tangential directions, so that nothing else is turned. In modal coordinates

    d = R_k (C_k + P_k A(w) P_k^*) R_k^* l,    A(w) = (W^2 - w^2 + i w D)^-1.

Blades of a file of one blade do not influence each other, and P and C are those of the blade for
all k. Those of a wheel are sums over its blades j,

    P_k = sum_j exp(-2 pi i j k / N) P_j / N^(1/2),  C_k = sum_j exp(-2 pi i j k / N) C_j0.

A tip that touches a rigid wall is such a node, too, without the left part: the normal points from
the wall into the blade, the first tangent along the rotation, and d is that of the tip. Its gap g_0
varies as the blade turns, and its slip contains that of the rotation.

A damper between blades j and j + 1 is a body of blade j with the displacement x, which two
contacts press, l_1 on blade j + 1 and l_2 on blade j: one has the left part alone and the other the
right part, and the damper adds B x to both. Its directions are modes without stiffness: at w = 0
they are still in A(w), as the mean of x follows from the balance B^T l + F = 0 with the centrifugal
force F.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray, IntArray

DIRECTIONS = 3  #: normal and two tangents


@dataclass(frozen=True, kw_only=True)
class Wave:
    """Motions of a nodal diameter: modes, and the joint nodes (A^T u_left, -A^T u_right) of the
    first blade."""

    stiffness: FloatArray  #: squared frequencies W^2 [rad2/s2], (modes,)
    damping: FloatArray  #: matrix D [1/s], (modes, modes)
    rows: ComplexArray  #: P_k [kg^-1/2], (2 * values, modes)
    compliance: ComplexArray  #: C_k [m/N], (2 * values, 2 * values)

    def admittance(self, w: float | FloatArray) -> ComplexArray:
        """Return A(w), (..., modes, modes), or its diagonal, (..., modes), if D is diagonal."""
        rates, w = np.diag(self.damping), np.asarray(w)[..., None]
        still = ((self.stiffness == 0.0) & (w == 0.0)).astype(np.float64)
        if not np.count_nonzero(self.damping - np.diag(rates)):
            return np.asarray(1.0 / (self.stiffness - w**2 + 1j * w * rates + still) - still)
        still, w, own = still[..., None] * np.eye(len(rates)), w[..., None], np.diag(self.stiffness)
        dynamic = own - w**2 * np.eye(len(own)) + 1j * w * self.damping
        return np.asarray(np.linalg.inv(dynamic + still) - still)


def times(admittance: ComplexArray, values: ComplexArray) -> ComplexArray:
    """Return the product of A(w), see `Wave.admittance`, with (modes,) or (modes, columns)."""
    if admittance.ndim == 2:
        return np.asarray(admittance @ values)
    return np.asarray((admittance * values.T).T)


@dataclass(frozen=True, kw_only=True)
class JointedWheel:
    """A tuned wheel with joints at a speed; values of joints are those of all their nodes, the
    normal and two tangents of a node in turn. Tips at a wall are nodes of the last joint."""

    names: tuple[str, ...]  #: names of the joints
    joint: IntArray  #: number of the joint of each node, (nodes,)
    friction: FloatArray  #: friction coefficient of each node, (nodes,)
    gap: FloatArray
    """Mean over the rotation of the gap g_0 of each node, negative if they overlap [m], (nodes,)"""
    speed: float  #: speed of rotation [rad/s]
    blades: int  #: number of blades N
    stiffness: FloatArray  #: squared frequencies of each copy [rad2/s2], (copies, modes)
    damping: FloatArray  #: matrix D of each copy [1/s], (copies, modes, modes)
    contact: FloatArray
    """Displacements (A^T u_left, -A^T u_right) of the joint nodes of each blade of a copy
    [kg^-1/2], (blades of a copy, 2 * values, modes)."""
    compliance: FloatArray
    """Residual flexibility of the same displacements [m/N], (blades of a copy, 2 * values, blades
    of a copy, 2 * values)."""
    loads: Mapping[int, ComplexArray]
    """Complex modal forces on the first copy of each engine order r for the time factor exp(i r
    Omega t) [kg^1/2 m/s2], (modes,)."""
    static: Mapping[int, ComplexArray]
    """Complex displacements of the joint nodes of the first blade due to the modes that are left
    out, by engine order [m], (2 * values,)."""
    points: FloatArray
    """Radial, tangential and axial displacements of loaded points, and then of the tips of the
    first blade [kg^-1/2], (3 * points, modes)."""
    loaded: tuple[int, ...]  #: numbers of the loaded points in the file
    tips: tuple[int, ...] = ()  #: numbers of the contact nodes of the tips
    points_by_force: FloatArray
    """Their displacements by forces on the joint nodes of each blade of a copy without their part
    in the modes [m/N], (3 * points, blades of a copy, 2 * values)."""
    wall: Mapping[int, ComplexArray] = field(default_factory=dict)
    """Complex variation of the gap of each node by the order r of the wall, for the time factor
    exp(i r Omega t) [m], (nodes,)."""
    radius: FloatArray = field(default_factory=lambda: np.zeros(1))
    """Distance by which each node slides along its first tangent in a radian of the rotation: the
    radius of a tip, zero in joints [m], (nodes,) or (1,)."""
    dampers: FloatArray = field(default_factory=lambda: np.zeros((0, 0)))
    """Displacements B of the joints of a blade by those of its dampers, in the directions in which
    these move, (values, dampers); (0, 0) without dampers."""
    pull: FloatArray = field(default_factory=lambda: np.zeros(0))
    """Centrifugal force F on dampers in these directions [N], (dampers,)."""
    permanent: bool = False
    """True if the friction of tips opposes the rotation, false if it opposes the slip."""

    @property
    def rubs(self) -> bool:
        """True if tips can touch a wall."""
        return bool(self.radius.any())

    @property
    def values(self) -> int:
        """Number of normal and tangential displacements of the joints of a blade."""
        return DIRECTIONS * len(self.joint)

    @property
    def shown(self) -> tuple[int, ...]:
        """Numbers of the points whose amplitudes are results: the loaded ones, or the tips."""
        return self.loaded or self.tips

    @property
    def orders(self) -> list[int]:
        """Engine orders of the loads, ascending."""
        return sorted(self.loads)

    @property
    def varies(self) -> bool:
        """True if loads or the wall vary with time."""
        return any(self.loads) or bool(self.wall)

    @property
    def shown_order(self) -> int:
        """Lowest engine order of the loads, or the largest one of the wall without loads."""
        return next(order for order in (*self.orders, *self.main_orders) if order)

    @property
    def main_orders(self) -> list[int]:
        """Engine orders of the loads, and the largest one of the wall, ascending."""
        size = {order: float(np.abs(gap).max()) for order, gap in self.wall.items()}
        return sorted({*self.loads, *sorted(size, key=size.__getitem__)[-1:]})

    @cached_property
    def _waves(self) -> dict[int, Wave]:
        return {}

    def wave(self, k: int) -> Wave:
        """Return the wave of a nodal diameter, whose sign is that of its direction."""
        own = len(self.contact)
        k = k % self.blades if own > 1 else 0
        if k not in self._waves:
            turn = np.exp(-2j * np.pi * k / self.blades * np.arange(own))
            self._waves[k] = Wave(
                stiffness=self.stiffness[0],
                damping=self.damping[0],
                rows=np.tensordot(turn, self.contact, 1) / np.sqrt(own),
                compliance=np.einsum("a,aibj,b->ij", turn, self.compliance, turn.conj()) / own,
            )
        return self._waves[k]

    def phase(self, k: int) -> complex:
        """Return the factor from a blade to the next one in a wave of a nodal diameter."""
        return complex(np.exp(2j * np.pi * k / self.blades))

    def joined(self, k: int, of_blade: ComplexArray) -> ComplexArray:
        """Return R_k times displacements of the joint nodes of a blade, (2 * values, ...)."""
        left, right = np.split(of_blade, 2)
        return np.asarray(self.phase(k) * left + right)

    def spread(self, k: int, force: ComplexArray) -> ComplexArray:
        """Return the forces R_k^* l on the joint nodes of a blade, (2 * values, ...)."""
        return np.concatenate([np.conj(self.phase(k)) * force, force])

    def flexibility(self, k: int, w: float) -> ComplexArray:
        """Return the displacements d of the joints by forces on them in a wave of a nodal diameter
        at a frequency [rad/s]: [m/N], (values, values)."""
        admittance = self.wave(k).admittance(np.array([w]))
        return np.asarray(self.flexibilities(np.array([k]), admittance)[0])

    def flexibilities(self, k: IntArray, admittance: ComplexArray) -> ComplexArray:
        """Return `flexibility` in waves of nodal diameters.

        Args:
            k: nodal diameters, (waves,).
            admittance: answers to modal forces, see `Wave.admittance`, (waves, modes) or (waves,
                modes, modes).
        """
        found = np.empty((len(k), self.values, self.values), dtype=np.complex128)
        same = k % self.blades if len(self.contact) > 1 else np.zeros_like(k)
        for each in np.unique(same).tolist():
            at, wave = np.flatnonzero(same == each), self.wave(each)
            phase = np.exp(2j * np.pi * k[at] / self.blades)[:, None, None]
            rows, flexible = (
                phase * one[: self.values] + one[self.values :]
                for one in (wave.rows, wave.compliance)
            )
            back = rows.conj().swapaxes(1, 2)
            full = admittance.ndim == 3
            modal = rows @ (admittance[at] @ back if full else admittance[at, :, None] * back)
            left, right = np.split(flexible, 2, axis=2)
            found[at] = phase.conj() * left + right + modal
        return found

    def frequency(self, order: int) -> float:
        """Return the frequency of an engine order, positive in the direction of time [rad/s]."""
        return order * self.speed

    def unloaded(self, order: int) -> ComplexArray:
        """Return the displacements d without joint forces for an engine order and the time factor
        exp(i r Omega t) [m], (values,)."""
        if order not in self.loads:
            return np.zeros(self.values, dtype=np.complex128)
        wave = self.wave(order)
        modal = times(wave.admittance(self.frequency(order)), self._load(order))
        return self.joined(order, wave.rows @ modal + self.static[order])

    def _load(self, order: int) -> ComplexArray:
        return np.asarray(self.loads[order] / np.sqrt(len(self.contact)))

    def at_points(self, order: int, force: ComplexArray) -> ComplexArray:
        """Return the complex displacements of `points` for an engine order and the time factor
        exp(i r Omega t): radial, tangential and axial [m], (points, 3).

        Args:
            order: engine order, also one without load.
            force: complex forces on the joints [N], (values,).
        """
        wave, own = self.wave(order), len(self.contact)
        spread = self.spread(order, force)
        pushed = wave.rows.conj().T @ spread
        if order in self.loads:
            pushed = pushed + self._load(order)
        modal = times(wave.admittance(self.frequency(order)), pushed)
        ahead = np.exp(2j * np.pi * order / self.blades * np.arange(own))
        moved = np.sqrt(own) * self.points @ modal
        moved = moved + np.einsum("pbi,b,i->p", self.points_by_force, ahead, spread)
        return np.asarray(moved.reshape(-1, 3))

    def limit(self, order: int, held: Sequence[int]) -> ComplexArray:
        """Return the displacements of `points` for an engine order as of `at_points` if some
        directions of all nodes do not move, 0 the normal one, 1 and 2 the tangents."""
        force = np.zeros(self.values, dtype=np.complex128)
        fixed = np.flatnonzero(np.isin(np.arange(self.values) % DIRECTIONS, held))
        flexible = self.flexibility(order, self.frequency(order))[np.ix_(fixed, fixed)]
        force[fixed] = np.linalg.solve(flexible, -self.unloaded(order)[fixed])
        return self.at_points(order, force)

    @cached_property
    def all_blades(self) -> tuple[FloatArray, FloatArray]:
        """Displacements d of the joints of all blades by the modes of all copies, (blades * values,
        copies * modes) [kg^-1/2], and by forces on them [m/N], (blades * values, blades * values).
        """
        copies, own, values = len(self.stiffness), len(self.contact), self.values
        modes = self.stiffness.shape[1]
        of_blades = np.einsum("cd,bim->cbidm", np.eye(copies), self.contact)
        of_blades = of_blades.reshape(self.blades, 2, values, copies * modes)
        rows = np.roll(of_blades[:, 0], -1, axis=0) + of_blades[:, 1]
        flexible = np.einsum("cd,biaj->cbidaj", np.eye(copies), self.compliance)
        flexible = flexible.reshape(self.blades, 2, values, self.blades, 2, values)
        left = np.roll(flexible[:, 0], -1, axis=0) + flexible[:, 1]
        both = np.roll(left[:, :, :, 0], -1, axis=2) + left[:, :, :, 1]
        size = self.blades * values
        assert own * copies == self.blades
        return rows.reshape(size, -1), both.reshape(size, size)
