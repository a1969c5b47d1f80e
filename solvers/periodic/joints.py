"""Periodic motions of a tuned wheel with friction joints, by a semismooth Newton method.

All blades have the same motion one after another, u_{j+1}(t) = u_j(t + theta / Omega), so that one
joint is enough, see `models.joints.wheel`. The period is that of the engine orders, T = 2 pi / (p
|Omega|) with their greatest common divisor p, and the harmonic h of the forces l on a joint moves
it by S_h l_h with the nodal diameter h p. Forces and displacements are collocated at n instants;
n p / N is a whole number, so that all N blades have the same instants.

With the gap g, the normal force l_n, tangential forces l_t and a friction coefficient mu,

    0 <= l_n, g >= 0, l_n g = 0,    |l_t| <= mu l_n,    l_t = -mu l_n s / |s| where s is not zero

with the slip s in a step, the velocity times the step. The natural map of Alart and Curnier (1991),

    p = l_n - rho_n g,    tau = l_t - rho_t s,

tells the state of a node at an instant: open (p <= 0, l = 0), stuck (|tau| <= mu p, s = 0), or
slipping (l_t = mu l_n tau / |tau|); closed nodes have g = 0. A Newton step solves the linearised
equations of the states, and changes the states.

Newton's method needs a discrete slip in which forces that oppose it take energy, as in the
equations of motion. With the phase a = 2 pi h / n of a step, the low harmonics are exact: C + A of
`models.joints.wheel` and i a (C + A), so that the direction of slip does not lag behind the motion.
For high harmonics the modes respond to forces that are constant in each step, see `steps`, with the
value at its end, and the slip is the backward difference, as in an implicit march. Between them the
responses and the slips are blended; each part takes energy. Modes that turn far in a step are
damped in the high harmonics: impacts of their masses would have many motions that mean nothing.

If nodes are stuck all the time, the mean of their tangential forces is not unique: joints are
assembled without tangential force, and the mean is the smallest possible one, zero.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from math import gcd

import numpy as np

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray, IntArray
from bladewhirl.models.joints.wheel import DIRECTIONS, JointedWheel
from bladewhirl.solvers.periodic.contact import NotConverged
from bladewhirl.solvers.periodic.steps import Steps

OPEN, STUCK, SLIPPING = range(3)
"""States of a node at an instant."""
EXACT, BACKWARD = 32.0, 8.0
"""Instants in a period of the highest harmonic whose response is exact, and of the lowest one whose
slip is a backward difference."""
STIFF, STIFF_RATIO, RESOLVED = 0.25, 1.0, 140.0
"""Angle of a mode in a step from which on damping is added to it outside of the exact harmonics,
and the damping ratio added from twice this angle on."""
CAUTION = 10.0
"""Factor of the flexibilities 1 / rho to typical ones; with smaller ones, nodes in whose slip a
Newton step errs change into the opposite slip in place of sticking."""
STEPS = 30  #: largest number of Newton steps
SAME = 1e-9
"""Largest error of gaps, slips and slipping forces times flexibility, relative to the displacements
without joint forces, at which Newton's method ends."""
WILD = 1e6  #: growth of the forces at which Newton's method gives up
REGULAR = 1e-9
"""Change of the diagonal of the equations of stuck nodes, relative to the flexibility."""


@dataclass(frozen=True)
class JointGrid:
    """A wheel with joints and its responses at equally spaced instants of a period."""

    wheel: JointedWheel
    instants: int  #: number of instants n

    @classmethod
    def near(cls, wheel: JointedWheel, instants: int) -> "JointGrid":
        """Return the grid of the least even number of instants that is at least `instants` and at
        which all blades have the same instants."""
        passages = wheel.blades // gcd(wheel.blades, common_order(wheel))
        unit = passages if passages % 2 == 0 else 2 * passages
        return cls(wheel, unit * -(-instants // unit))

    @property
    def order(self) -> int:
        """Number of periods in a turn p."""
        return common_order(self.wheel)

    @property
    def period(self) -> float:
        """Period of the motion [s]."""
        return 2.0 * np.pi / (self.order * abs(self.wheel.speed))

    @property
    def shift(self) -> int:
        """Instants by which a blade is ahead of the one before it."""
        ahead = self.instants * self.order // self.wheel.blades
        return ahead if self.wheel.speed > 0.0 else -ahead

    @property
    def step(self) -> float:
        """Time between two instants [s]."""
        return self.period / self.instants

    @cached_property
    def responses(self) -> tuple[ComplexArray, ComplexArray]:
        """Displacements of a joint [m/N], and their slip in a step, by forces on it for each
        harmonic 0 to n / 2, (harmonics, values, values)."""
        wheel, count = self.wheel, self.instants // 2 + 1
        number = np.arange(count)
        turn = 2.0 * np.pi / self.instants * number
        of_waves: dict[int, ComplexArray] = {}
        found = np.empty((2, count, wheel.values, wheel.values), dtype=np.complex128)
        place = np.log(np.maximum(number, 0.5) * EXACT / self.instants) / np.log(EXACT / BACKWARD)
        exact = np.cos(0.5 * np.pi * np.clip(place, 0.0, 1.0)) ** 2
        for h, k in enumerate(self.diameter.tolist()):
            wave = wheel.wave(k)
            if id(wave) not in of_waves:
                fast = np.sqrt(np.abs(wave.stiffness))
                angle = max(self.step, self.period / RESOLVED) * fast
                ratio = STIFF_RATIO * np.clip(angle / STIFF - 1.0, 0.0, 1.0)
                steps = Steps(wave.stiffness, wave.damping + np.diag(2.0 * ratio * fast), self.step)
                of_waves[id(wave)] = steps.answers(self.instants, at_ends=True)[0]
            each = of_waves[id(wave)][..., h]
            stepped = wheel.by_modes(k, each.ravel() if each.shape[1] == 1 else each[0])
            true = wheel.by_modes(k, wave.admittance(turn[h] / self.step))
            rates = 1j * turn[h], 1.0 - np.exp(-1j * turn[h])
            for n, (smooth, backward) in enumerate(((1.0, 1.0), rates)):
                found[n, h] = exact[h] * smooth * (true + wheel.residual(k))
                found[n, h] += (1.0 - exact[h]) * backward * (stepped + wheel.residual(k))
        return found[0], found[1]

    @property
    def diameter(self) -> IntArray:
        """Nodal diameter of each harmonic 0 to n / 2 in the direction of rotation."""
        sign = 1 if self.wheel.speed > 0.0 else -1
        return sign * self.order * np.arange(self.instants // 2 + 1)

    @cached_property
    def free(self) -> FloatArray:
        """Displacements of a joint without joint forces [m], (instants, values)."""
        return np.fft.irfft(self.free_spectrum, self.instants, axis=0)

    @cached_property
    def free_spectrum(self) -> ComplexArray:
        """Harmonics 0 to n / 2 of `free` as of `np.fft.rfft` [m], (harmonics, values)."""
        wheel = self.wheel
        spectrum = np.zeros((self.instants // 2 + 1, wheel.values), dtype=np.complex128)
        for order in wheel.orders:
            moved = wheel.unloaded(order)
            moved = moved if wheel.speed > 0.0 else moved.conj()
            spectrum[order // self.order] += moved * (1.0 if order == 0 else 0.5)
        return self.instants * spectrum

    @cached_property
    def soft(self) -> FloatArray:
        """Flexibilities 1 / rho of the natural map, the same for both tangents of a node [m/N],
        (values,)."""
        each = np.abs(np.diagonal(self.responses[0], axis1=1, axis2=2))
        soft = CAUTION * np.median(each, axis=0)
        soft[self.tangential] = soft[self.tangential].mean(axis=1)[:, None]
        return np.asarray(soft)

    @cached_property
    def tangential(self) -> IntArray:
        """Numbers of the tangential values, (nodes, 2)."""
        nodes = np.arange(len(self.wheel.joint))
        return DIRECTIONS * nodes[:, None] + np.arange(1, DIRECTIONS)

    @cached_property
    def lagged(self) -> FloatArray:
        """Normal displacements [m/N], and tangential slip, at each lag after a unit force at one
        instant of each period, (instants, values, values)."""
        found, slip = self.responses
        spectrum = found.copy()
        spectrum[:, self.tangential.ravel()] = slip[:, self.tangential.ravel()]
        return np.fft.irfft(spectrum, self.instants, axis=0)

    def moved(self, force: FloatArray) -> FloatArray:
        """Return the displacements of a joint under forces [m], (instants, values)."""
        if not force.any():
            return self.free
        spectrum = self.responses[0] @ np.fft.rfft(force, axis=0)[..., None]
        return np.asarray(self.free + np.fft.irfft(spectrum[..., 0], self.instants, axis=0))


def common_order(wheel: JointedWheel) -> int:
    """Return the greatest common divisor of the engine orders, 0 without any."""
    return gcd(*wheel.orders)


@dataclass(frozen=True)
class JointMotion:
    """Forces on a joint over one period."""

    grid: JointGrid
    force: FloatArray  #: normal and tangential forces of each node [N], (instants, values)
    steps: int = 0  #: Newton steps that led to it
    change: float = np.inf  #: relative change of its low harmonics with the last refinement

    @classmethod
    def at_rest(cls, grid: JointGrid) -> "JointMotion":
        """Return the motion whose forces are the static normal forces without friction."""
        wheel = grid.wheel
        normal = slice(None, None, DIRECTIONS)
        flexible = wheel.flexibility(0, 0.0).real[normal, normal]
        force = np.zeros((grid.instants, wheel.values))
        force[:, normal] = pressed(flexible, wheel.gap)
        return cls(grid, force)

    @cached_property
    def displacement(self) -> FloatArray:
        """Displacements d of the joint [m], (instants, values)."""
        return self.grid.moved(self.force)

    @cached_property
    def normal(self) -> FloatArray:
        """Normal forces [N], (instants, nodes)."""
        return self.force[:, ::DIRECTIONS]

    @cached_property
    def tangential(self) -> FloatArray:
        """Tangential forces [N], (instants, nodes, 2)."""
        return self.force[:, self.grid.tangential]

    @cached_property
    def gap(self) -> FloatArray:
        """Gaps [m], (instants, nodes)."""
        return np.asarray(self.displacement[:, ::DIRECTIONS] + self.grid.wheel.gap)

    @cached_property
    def slip(self) -> FloatArray:
        """Slip in a step [m], (instants, nodes, 2)."""
        grid = self.grid
        turn = 2j * np.pi / grid.instants * np.arange(len(grid.free_spectrum))
        pushed = grid.responses[1] @ np.fft.rfft(self.force, axis=0)[..., None]
        spectrum = turn[:, None] * grid.free_spectrum + pushed[..., 0]
        return np.fft.irfft(spectrum, grid.instants, axis=0)[:, grid.tangential]

    @cached_property
    def trial(self) -> FloatArray:
        """Tangential forces tau of the natural map [N], (instants, nodes, 2)."""
        return self.tangential - self.slip / self.grid.soft[self.grid.tangential]

    @cached_property
    def pressure(self) -> FloatArray:
        """Normal forces p of the natural map [N], (instants, nodes)."""
        return self.normal - self.gap / self.grid.soft[::DIRECTIONS]

    @cached_property
    def states(self) -> IntArray:
        """States by the natural map, (instants, nodes)."""
        limit = self.grid.wheel.friction * self.pressure
        slips = np.linalg.norm(self.trial, axis=-1) > limit
        closed = np.where(slips, SLIPPING, STUCK)
        return np.where(self.pressure > 0.0, closed, OPEN)

    @property
    def error(self) -> float:
        """Largest error of the equations of the states [m]."""
        states, friction = self.states, self.grid.wheel.friction
        tau = self.trial
        size = np.linalg.norm(tau, axis=-1, keepdims=True)
        way = np.divide(tau, size, out=np.zeros_like(tau), where=size > 0.0)
        off = self.tangential - (friction * self.normal)[..., None] * way
        soft = self.grid.soft[self.grid.tangential]
        return max(
            float(np.abs(self.gap[states != OPEN]).max(initial=0.0)),
            float(np.abs(self.slip[states == STUCK]).max(initial=0.0)),
            float(np.abs((soft * off)[states == SLIPPING]).max(initial=0.0)),
        )

    @property
    def touches(self) -> bool:
        """True if there is contact at some time."""
        return bool(self.normal.any())

    @property
    def harmonics(self) -> ComplexArray:
        """Complex amplitudes of the forces [N], (harmonics, values)."""
        spectrum = np.fft.rfft(self.force, axis=0) * (2.0 / self.grid.instants)
        spectrum[0] *= 0.5
        return np.asarray(spectrum)

    def of_order(self, order: int) -> ComplexArray:
        """Return the complex amplitude of the forces of an engine order r for the time factor exp(i
        r Omega t) [N], (values,)."""
        found = self.harmonics[order // self.grid.order]
        return np.asarray(found if self.grid.wheel.speed > 0.0 else found.conj())

    def of_points(self) -> FloatArray:
        """Return the displacements of `JointedWheel.points` [m], (instants, points, 3)."""
        wheel, count = self.grid.wheel, self.grid.instants
        orders = [h * self.grid.order for h in range(count // 2)]
        moved = np.stack([wheel.at_points(each, self.of_order(each)) for each in orders])
        moved = moved if wheel.speed > 0.0 else moved.conj()
        moved[1:] *= 0.5
        return np.fft.irfft(count * moved, count, axis=0)

    @cached_property
    def work(self) -> FloatArray:
        """Work that each node takes from the blades in a period [J], (nodes,): the integral of the
        force times the velocity of the trigonometric interpolants."""
        count = self.grid.instants
        numbers = 2j * np.pi * np.arange(count // 2 + 1)
        numbers[-1] = 0.0
        rate = np.fft.irfft(
            numbers[:, None] * np.fft.rfft(self.displacement, axis=0), count, axis=0
        )
        power = -(self.force * rate).mean(axis=0)
        return np.asarray(power.reshape(-1, DIRECTIONS).sum(axis=1))

    def on(self, grid: JointGrid) -> "JointMotion":
        """Return the motion on another grid, by linear interpolation."""
        place = np.arange(grid.instants) * (len(self.force) / grid.instants)
        low = place.astype(int)
        share = (place - low)[:, None]
        ahead = self.force[(low + 1) % len(self.force)]
        return JointMotion(grid, (1.0 - share) * self.force[low] + share * ahead)


def pressed(flexible: FloatArray, gap: FloatArray) -> FloatArray:
    """Return the normal forces that close gaps: 0 <= l, flexible l + gap >= 0, of which one is zero
    for each node (nodes,), by a semismooth Newton method.

    Raises:
        NotConverged: there are no such forces.
    """
    force, closed = np.zeros(len(gap)), gap < 0.0
    for _ in range(STEPS):
        force = np.zeros(len(gap))
        force[closed] = np.linalg.solve(flexible[np.ix_(closed, closed)], -gap[closed])
        after = force - (flexible @ force + gap) / np.diag(flexible) > 0.0
        if (after == closed).all():
            return force
        closed = after
    raise NotConverged("the static forces of the joints do not converge")


def _stepped(motion: JointMotion, states: IntArray) -> JointMotion:
    """Return the motion after a Newton step of the equations of states, (instants, nodes).

    Raises:
        NotConverged: the equations are singular.
    """
    grid, wheel = motion.grid, motion.grid.wheel
    closed = np.repeat(states != OPEN, DIRECTIONS, axis=1)
    force = np.where(closed, motion.force, 0.0)
    motion = replace(motion, force=force)
    if not closed.any():
        return motion
    instant, value = np.nonzero(closed)
    lag = (instant[:, None] - instant) % grid.instants
    place = (lag * wheel.values + value[:, None]) * wheel.values + value
    matrix = np.take(grid.lagged.ravel(), place)
    side = np.empty(motion.force.shape)
    side[:, ::DIRECTIONS], side[:, grid.tangential] = motion.gap, motion.slip
    side = side[closed]
    own, node = np.nonzero(states)
    row = DIRECTIONS * np.arange(len(own))[:, None] + np.arange(1, DIRECTIONS)
    stuck = row[states[own, node] == STUCK].ravel()
    matrix[stuck, stuck] += REGULAR * grid.soft[value[stuck]]
    for component in grid.tangential[(states == STUCK).all(axis=0)].ravel():
        always = np.flatnonzero(value == component)  # no slip leaves the mean of the forces open
        matrix[np.ix_(always, always)] += grid.soft[component] / grid.instants
        side[always] += grid.soft[component] * force[:, component].mean()
    slipping = states[own, node] == SLIPPING
    rows, own, node = row[slipping], own[slipping], node[slipping]
    tau, limit = motion.trial[own, node], wheel.friction[node] * motion.normal[own, node]
    size = np.linalg.norm(tau, axis=1)
    e = tau / np.where(size > 0.0, size, 1.0)[:, None]
    share = np.clip(limit / np.where(size > 0.0, size, 1.0), 0.0, 1.0)
    across = np.eye(2) - e[:, :, None] * e[:, None]
    soft = grid.soft[grid.tangential[node]][:, :, None]
    turned = np.einsum("kab,kbc->kac", share[:, None, None] * across, matrix[rows])
    each = np.arange(len(rows))
    diagonal = soft * (np.eye(2) - share[:, None, None] * across)
    for b in range(2):
        for a in range(2):
            turned[each, a, rows[:, b]] += diagonal[:, a, b]
    turned[each, :, rows[:, 0] - 1] -= soft[:, :, 0] * wheel.friction[node][:, None] * e
    matrix[rows] = turned
    side[rows] = soft[:, :, 0] * (motion.tangential[own, node] - limit[:, None] * e)
    try:
        change = np.linalg.solve(matrix, -side)
    except np.linalg.LinAlgError:
        raise NotConverged("the equations of the joints are singular") from None
    force = motion.force.copy()
    force[closed] += change
    return replace(motion, force=force)


def solve(start: JointMotion, states: IntArray | None = None) -> JointMotion:
    """Return the periodic motion to which Newton's method leads.

    Args:
        start: where it begins.
        states: states of the first step, (instants, nodes); those of the start if None.

    Raises:
        NotConverged: no motion was found.
    """
    motion, states = start, start.states if states is None else states
    size = np.abs(start.grid.free).max() + np.abs(start.grid.wheel.gap).max()
    for step in range(STEPS):
        motion = _stepped(motion, states)
        if (motion.states == states).all() and motion.error <= SAME * size:
            return replace(motion, steps=step + 1)
        if not motion.error < WILD * size:
            break
        states = motion.states
    raise NotConverged(
        f"Newton's method did not converge with {start.grid.instants} instants; joints can have"
        " several motions here, and jump"
    )


def stuck(grid: JointGrid) -> JointMotion:
    """Return the periodic motion to which Newton's method leads from closed joints without slip.

    Raises:
        NotConverged: no motion was found.
    """
    start = JointMotion.at_rest(grid)
    return solve(start, np.full(start.states.shape, STUCK))
