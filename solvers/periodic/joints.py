"""Periodic motions of a tuned wheel with friction joints or a rub, by harmonic balance.

All blades have the same motion one after another, u_{j+1}(t) = u_j(t + theta / Omega), so that one
joint is enough, see `models.joints.wheel`. The period is that of the engine orders, T = 2 pi / (p
|Omega|) with the greatest common divisor p of them and of the lobes of the wall, and the harmonic h
of the forces l on a joint moves it by S_h l_h with the nodal diameter h p. Displacements are d =
d_0 + S l with those d_0 without joint forces, and slips are derivatives by the angle h p Omega t,
of harmonics i h d_h.

The unknowns are the harmonics 0 to H of the forces. At equally spaced instants of a period, trial
forces follow from them, from the gaps and from the slips, and the law of `joint_law` gives forces.
The unknowns are right if they are the harmonics of the forces of the law:

    l = F P(F^-1 (l - g / f_n, l - s / f_t)).

The flexibilities f are of the size of those of the joint. As the modes respond exactly to the
harmonics of the forces, the work of the engine orders is that of the damping and of the joints, and
joints that are open, stuck or without friction have exactly the linear response.

Tips at the wall are nodes of which the gap varies with the angle of the rotation, and that slip by
it, besides their own motion. If their friction opposes the rotation alone, its part of the slip is
`FAST` times as large, so that their motion has no effect on the direction.

If nodes are stuck all the time, the mean of their tangential forces is not unique. Joints are
assembled without tangential force, and the mean is zero: a slip of `CREEP` times it is added.
"""

from dataclasses import dataclass
from functools import cached_property
from math import gcd

import numpy as np

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray, IntArray
from bladewhirl.models.joints.pressed import NoStaticForces
from bladewhirl.models.joints.wheel import DIRECTIONS, JointedWheel
from bladewhirl.solvers.periodic import joint_law
from bladewhirl.solvers.periodic.contact import NotConverged
from bladewhirl.solvers.periodic.joint_dampers import Balance

SAMPLED = 8  #: instants for each harmonic
FAST = 1e9  #: factor of the slip by the rotation if friction opposes it alone
CREEP = 1e-8  #: slip per mean tangential force, relative to the flexibility


@dataclass(frozen=True)
class JointGrid:
    """A wheel with joints, and its responses to the harmonics 0 to H of forces."""

    wheel: JointedWheel
    harmonics: int  #: highest harmonic H

    @property
    def instants(self) -> int:
        """Number of instants in a period."""
        return SAMPLED * self.harmonics

    @property
    def order(self) -> int:
        """Number of periods in a turn p."""
        return common_order(self.wheel)

    @property
    def period(self) -> float:
        """Period of the motion [s]."""
        return 2.0 * np.pi / (self.order * abs(self.wheel.speed))

    @property
    def number(self) -> IntArray:
        """Numbers of the harmonics, (H + 1,)."""
        return np.arange(self.harmonics + 1)

    @property
    def rates(self) -> ComplexArray:
        """Slips by displacements of the harmonics, (H + 1,)."""
        return np.asarray(1j * self.number, dtype=np.complex128)

    @cached_property
    def responses(self) -> ComplexArray:
        """Displacements S of a joint by forces on it [m/N], (H + 1, values, values)."""
        wheel, diameter = self.wheel, self.order if self.wheel.speed > 0.0 else -self.order
        w = np.asarray(2.0 * np.pi / self.period * self.number, dtype=np.float64)
        return wheel.flexibilities(diameter * self.number, wheel.wave(0).admittance(w))

    @cached_property
    def effects(self) -> ComplexArray:
        """Normal displacements and tangential slips of a joint by forces on it [m/N], (H + 1,
        values, values)."""
        found, tangential = self.responses.copy(), self.tangential
        found[:, tangential] *= self.rates[:, None, None]
        found[0, tangential, tangential] = CREEP * self.soft[tangential]
        return found

    @cached_property
    def balance(self) -> Balance:
        """The balance of the mean forces on dampers."""
        return Balance.of(self.wheel, self.soft)

    @cached_property
    def free(self) -> ComplexArray:
        """Harmonics of the displacements of a joint without joint forces [m], (H + 1, values)."""
        wheel = self.wheel
        found = np.zeros((self.harmonics + 1, wheel.values), dtype=np.complex128)
        for order in wheel.orders:
            moved = wheel.unloaded(order)
            found[order // self.order] += moved if wheel.speed > 0.0 else moved.conj()
        return found

    @cached_property
    def uneven(self) -> ComplexArray:
        """Harmonics of the gaps by the wall [m], (H + 1, nodes)."""
        wheel = self.wheel
        found = np.zeros((self.harmonics + 1, len(wheel.joint)), dtype=np.complex128)
        for order, gap in wheel.wall.items():
            if order <= self.harmonics * self.order:
                found[order // self.order] = gap if wheel.speed > 0.0 else gap.conj()
        return found

    @property
    def turning(self) -> FloatArray:
        """Slip of each node by the rotation [m], (nodes,) or (1,)."""
        return np.asarray(np.sign(self.wheel.speed) / self.order * self.wheel.radius)

    @cached_property
    def soft(self) -> FloatArray:
        """Flexibilities f of the trial forces, equal for both tangents of a node [m/N],
        (values,)."""
        each = np.abs(np.diagonal(self.responses[1:], axis1=1, axis2=2))
        tangential = self.tangential
        each[:, tangential] *= np.abs(self.rates[1:, None])
        soft = np.asarray(np.median(each, axis=0))
        soft[tangential] = soft[tangential].reshape(-1, 2).mean(axis=1).repeat(2)
        return soft

    @property
    def tangential(self) -> IntArray:
        """Numbers of the tangential values."""
        numbers = np.arange(self.wheel.values)
        return numbers[numbers % DIRECTIONS > 0]

    @cached_property
    def load(self) -> FloatArray:
        """Coefficients of the part of the trial forces due to engine orders and lobes of the wall
        [N], (2 H + 1, values)."""
        moved = self.free.copy()
        moved[:, ::DIRECTIONS] += self.uneven
        moved[:, self.tangential] *= self.rates[:, None]
        return -coefficients(moved) / self.soft

    @cached_property
    def rest(self) -> FloatArray:
        """Coefficients of the part of the trial forces due to mean gaps and the slip by the
        rotation [N], (2 H + 1, values)."""
        found, balance = np.zeros_like(self.load), self.balance
        found[0, ::DIRECTIONS] = -self.wheel.gap / self.soft[::DIRECTIONS]
        slip = self.turning * (FAST if self.wheel.permanent else 1.0)
        found[0, 1::DIRECTIONS] = -slip / self.soft[1::DIRECTIONS]
        by_pull = (self.effects[0].real - balance.moved) @ balance.pulled
        found[0] += balance.pulled - by_pull / self.soft
        return found

    @cached_property
    def to_trial(self) -> FloatArray:
        """Matrices from the real and imaginary parts of the harmonics of forces to those of trial
        forces; of the mean, the imaginary part is not used, (H + 1, 2 * values, 2 * values)."""
        real, imaginary = self.effects.real, self.effects.imag
        found = np.block([[real, -imaginary], [imaginary, real]]) / -np.tile(self.soft, 2)[:, None]
        each = np.arange(found.shape[1])
        found[:, each, each] += 1.0
        own, balance = slice(self.wheel.values), self.balance
        by_place = balance.moved - self.effects[0].real @ balance.share
        found[0, own, own] -= balance.share + by_place / self.soft[:, None]
        return found

    @cached_property
    def series(self) -> FloatArray:
        """Matrix from coefficients to values at the instants, (instants, 2 H + 1)."""
        return series(self.harmonics, self.instants)

    @cached_property
    def to_coefficients(self) -> FloatArray:
        """Matrix from values at the instants to coefficients, (2 H + 1, instants)."""
        found = 2.0 / self.instants * self.series.T
        found[0] *= 0.5
        return found

    @property
    def size(self) -> float:
        """Typical force [N]."""
        return float(np.abs(self.load).max() + np.abs(self.rest[:, ::DIRECTIONS]).max())


def common_order(wheel: JointedWheel) -> int:
    """Return the greatest common divisor of the engine orders and those of the wall, 0 without
    any."""
    return gcd(*wheel.orders, *wheel.wall)


def series(harmonics: int, instants: int) -> FloatArray:
    """Return the values of 1, cos t, -sin t, cos 2 t ... at instants of a period, (instants,
    2 * harmonics + 1)."""
    turn = 2j * np.pi / instants * np.outer(np.arange(instants), np.arange(1, harmonics + 1))
    wave = np.exp(turn)
    each = np.stack([wave.real, -wave.imag], axis=-1).reshape(instants, -1)
    return np.hstack([np.ones((instants, 1)), each])


def coefficients(harmonics: ComplexArray) -> FloatArray:
    """Return the mean, and real and imaginary parts, of complex amplitudes (H + 1, values), (2 H +
    1, values)."""
    parts = np.stack([harmonics.real, harmonics.imag], axis=1).reshape(-1, harmonics.shape[1])
    return np.delete(parts, 1, axis=0)


@dataclass(frozen=True)
class JointMotion:
    """Forces on a joint over one period."""

    grid: JointGrid
    parts: FloatArray
    """Mean of the forces, or with dampers p of `joint_dampers`, and real and imaginary parts of
    their harmonics [N], (2 H + 1, values)."""
    change: float = np.inf
    """Relative change with the harmonics, see `joint_search`; infinite if unknown."""

    @classmethod
    def at_rest(cls, grid: JointGrid) -> "JointMotion":
        """Return the motion whose forces are the static normal forces without friction.

        Raises:
            NotConverged: there are no such forces.
        """
        normal = slice(None, None, DIRECTIONS)
        parts = np.zeros_like(grid.load)
        try:
            flexible = grid.responses[0].real[normal, normal]
            parts[0] = grid.balance.at_rest(flexible, grid.wheel.gap)
        except NoStaticForces as error:
            raise NotConverged(str(error)) from error
        return cls(grid, parts)

    def on(self, grid: JointGrid) -> "JointMotion":
        """Return the motion on another grid, without harmonics and tips that one of both does not
        have."""
        values = grid.wheel.values
        found = np.zeros((grid.harmonics + 1, values), dtype=np.complex128)
        orders, shared = self.grid.number * self.grid.order, min(values, self.grid.wheel.values)
        kept = (orders % grid.order == 0) & (orders <= grid.harmonics * grid.order)
        found[orders[kept] // grid.order, :shared] = self.harmonics[kept, :shared]
        parts = coefficients(found)
        parts[0] = grid.balance.unknowns(parts[0], self._place)
        return JointMotion(grid, parts)

    @property
    def forces(self) -> FloatArray:
        """Mean of the forces, and real and imaginary parts of their harmonics [N], (2 H + 1,
        values)."""
        return np.vstack([self.grid.balance.forces(self.parts[0]), self.parts[1:]])

    @property
    def harmonics(self) -> ComplexArray:
        """Complex amplitudes of the forces [N], (H + 1, values)."""
        parts = self.forces
        real = np.vstack([parts[:1], parts[1::2]])
        return np.asarray(real + 1j * np.vstack([0.0 * parts[:1], parts[2::2]]))

    @cached_property
    def moved(self) -> ComplexArray:
        """Complex amplitudes of the displacements of the joint [m], (H + 1, values)."""
        pushed = np.einsum("hij,hj->hi", self.grid.responses, self.harmonics)
        found = self.grid.free + pushed
        found[0] += self.grid.balance.rows @ np.where(self.grid.balance.walks, 0.0, self._place)
        return np.asarray(found)

    @property
    def _place(self) -> FloatArray:
        """Mean place of the dampers [m], or the distance by which they walk in a radian,
        (dampers,)."""
        return self.grid.balance.place(self.parts[0])

    @property
    def walks(self) -> dict[str, float]:
        """Distances by which the dampers of joints walk along the axis in a period, by the names of
        the joints [m]."""
        wheel, balance = self.grid.wheel, self.grid.balance
        joint = wheel.joint[np.abs(balance.rows).argmax(axis=0) // DIRECTIONS]
        each = zip(joint[balance.walks], self._place[balance.walks], strict=True)
        return {wheel.names[n]: 2.0 * np.pi * float(place) for n, place in each}

    def trial(self, share: float = 1.0) -> FloatArray:
        """Return the coefficients of the trial forces under a share of the engine orders [N],
        (2 H + 1, values)."""
        grid, parts, values = self.grid, self.parts, self.grid.wheel.values
        own = np.empty_like(parts)
        own[0] = grid.to_trial[0, :values, :values] @ parts[0]
        both = parts[1:].reshape(-1, 2 * values, 1)
        own[1:] = (grid.to_trial[1:] @ both).reshape(-1, values)
        return np.asarray(own + share * grid.load + grid.rest)

    @cached_property
    def _at_instants(self) -> FloatArray:
        return self._sampled(self.grid.series @ self.trial())

    def _sampled(self, values: FloatArray) -> FloatArray:
        return values.reshape(len(values), -1, DIRECTIONS)

    @property
    def states(self) -> IntArray:
        """States, see `joint_law`, (instants, nodes)."""
        return joint_law.states(self._at_instants, self.grid.wheel.friction)

    @property
    def force(self) -> FloatArray:
        """Forces of the law: normal, two tangents [N], (instants, nodes, 3)."""
        return joint_law.projected(self._at_instants, self.grid.wheel.friction, 0.0).force

    def at(self, instants: int) -> tuple[FloatArray, FloatArray, IntArray]:
        """Return forces [N] and displacements [m], normal and two tangents, (instants, nodes, 3),
        and states (instants, nodes) at equally spaced instants of a period."""
        friction, wave = self.grid.wheel.friction, series(self.grid.harmonics, instants)
        trial = self._sampled(wave @ self.trial())
        force = joint_law.projected(trial, friction, 0.0).force
        moved = self._sampled(wave @ coefficients(self.moved))
        return force, moved, joint_law.states(trial, friction)

    @property
    def error(self) -> float:
        """Largest error of the forces times the flexibility [m]."""
        grid = self.grid
        values = self.force.reshape(grid.instants, -1)
        return float(np.abs((self.forces - grid.to_coefficients @ values) * grid.soft).max())

    @property
    def smallest_gap(self) -> float:
        """Smallest gap of a node [m]."""
        grid = self.grid
        moved = coefficients(self.moved[:, ::DIRECTIONS] + grid.uneven)
        return float((grid.wheel.gap + grid.series @ moved).min())

    @property
    def touches(self) -> bool:
        """True if there is contact at some time."""
        return bool((self.states != joint_law.OPEN).any())

    def of_order(self, order: int) -> ComplexArray:
        """Return the complex amplitude of the forces of an engine order r for the time factor exp(i
        r Omega t) [N], (values,)."""
        found = self.harmonics[order // self.grid.order]
        return np.asarray(found if self.grid.wheel.speed > 0.0 else found.conj())

    @cached_property
    def of_points(self) -> FloatArray:
        """Displacements of `JointedWheel.points` [m], (instants, points, 3)."""
        grid = self.grid
        orders = (grid.number * grid.order).tolist()
        moved = np.stack([grid.wheel.at_points(each, self.of_order(each)) for each in orders])
        moved = moved if grid.wheel.speed > 0.0 else moved.conj()
        values = grid.series @ coefficients(moved.reshape(len(moved), -1))
        return np.asarray(values.reshape(grid.instants, -1, DIRECTIONS))

    @cached_property
    def work(self) -> FloatArray:
        """Work that each node takes from the blades in a period [J], (nodes,): the integral of the
        force times the velocity."""
        power = np.pi * self.grid.number[:, None] * (self.harmonics.conj() * self.moved).imag
        return np.asarray(power.sum(axis=0).reshape(-1, DIRECTIONS).sum(axis=1))
