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
`models.joints.wheel` and i a (C + A). For high harmonics the modes respond to forces that are
constant between the instants, see `steps`, and the slip is the change of their displacements
between the ends of a step about the instant; that of the residual flexibility C is the backward
difference 1 - exp(-i a), whose real part is positive. The direction of slip, unlike that of
backward differences alone, does not lag behind the motion.

If nodes are stuck all the time, the mean of their tangential forces is not unique: joints are
assembled without tangential force, and the mean is the smallest possible one, zero.
"""

from collections.abc import Callable, Iterator
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
EXACT, BACKWARD = 8.0, 4.0
"""Instants in a period of the highest harmonic whose response is exact, and of the lowest one with
backward differences of the residual flexibility."""
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
FIRST_INSTANTS, LEAST_INSTANTS, MOST_INSTANTS = 64, 128, 512
"""Instants of the first grid, of a result, and of the finest grid, approximately."""
COMPARED = 4  #: number of harmonics of the forces of which two grids are compared
CONVERGED = 5e-3
"""Largest relative change of these harmonics with the last refinement; the error of the finer grid
is smaller."""
LARGE_RATIO, SMALL_RATIO = 1.0, 3e-4
"""First damping ratio that is added where damping falls, and the smallest before none is."""
FALL, SLOWEST = 0.3, 0.93
"""Factor of the damping ratio in a step, and the largest one."""
FIRST_SHARE, SHORTEST, GROWTH, QUICK = 0.25, 2e-3, 1.6, 8
"""First and shortest step of growing loads, relative to the loads; the factor by which steps grow
after so many Newton steps or fewer."""


@dataclass(frozen=True)
class JointGrid:
    """A wheel with joints and its responses at equally spaced instants of a period."""

    wheel: JointedWheel
    instants: int  #: number of instants n
    share: float = 1.0  #: factor on the loads

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

    def loaded(self, share: float) -> "JointGrid":
        """Return the grid with a share of the loads."""
        other = replace(self, share=share)
        for name in ("responses", "soft", "lagged"):  # they do not depend on the loads
            other.__dict__[name] = getattr(self, name)
        return other

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
        exact = number * EXACT <= self.instants
        of_waves: dict[int, ComplexArray] = {}
        modal = np.empty((count, wheel.values, wheel.values), dtype=np.complex128)
        residual = np.empty_like(modal)
        for h, k in enumerate(self.diameter.tolist()):
            wave = wheel.wave(k)
            if exact[h]:
                answers = wave.admittance(turn[h] / self.step)
            else:
                if id(wave) not in of_waves:
                    steps = Steps(wave.stiffness, wave.damping, self.step)
                    of_waves[id(wave)] = steps.answers(self.instants)[0]
                each = of_waves[id(wave)][..., h]
                answers = each.ravel() if each.shape[1] == 1 else each[0]
            modal[h], residual[h] = wheel.by_modes(k, answers), wheel.residual(k)
        by_modes = 1j * np.where(exact, turn, 2.0 * np.tan(0.5 * turn))
        by_modes[-1] = 0.0  # modes hardly move at the highest harmonic
        place = (np.log(number + 1e-300) - np.log(self.instants / EXACT)) / np.log(EXACT / BACKWARD)
        share = np.cos(0.5 * np.pi * np.clip(place, 0.0, 1.0)) ** 2
        direct = share * 1j * turn + (1.0 - share) * (1.0 - np.exp(-1j * turn))
        slip = by_modes[:, None, None] * modal + direct[:, None, None] * residual
        return modal + residual, slip

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
        return self.share * self.instants * spectrum

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


def loaded(grid: JointGrid) -> JointMotion:
    """Return the periodic motion to which growing loads lead from the joints at rest.

    Raises:
        NotConverged: the loads could not grow to their whole size.
    """
    reached, step, before = 0.0, FIRST_SHARE, (0.0, JointMotion.at_rest(grid).force)
    force = before[1]
    while reached < 1.0:
        share = min(1.0, reached + step)
        ahead = (share - reached) / (reached - before[0]) if reached > before[0] else 0.0
        guess = JointMotion(grid.loaded(share), force + ahead * (force - before[1]))
        try:
            motion = solve(guess)
        except NotConverged:
            step *= 0.5
            if step < SHORTEST:
                raise
            continue
        before, force, reached = (reached, force), motion.force, share
        step *= GROWTH if motion.steps <= QUICK else 1.0
    return replace(motion, grid=grid)


def damped(grid: JointGrid) -> JointMotion:
    """Return the periodic motion to which falling damping leads from large damping, with which the
    memory of the modes is short and Newton's method finds the motion.

    Raises:
        NotConverged: the damping could not fall to its value.
    """
    ratio, factor, motion = LARGE_RATIO, FALL, None
    while True:
        at = grid if ratio == 0.0 else replace(grid, wheel=grid.wheel.damped(ratio))
        try:
            motion = stuck(at) if motion is None else solve(JointMotion(at, motion.force))
        except NotConverged:
            factor = np.sqrt(factor)
            if motion is None or factor > SLOWEST:
                raise
        else:
            if ratio == 0.0:
                return motion
            reached, factor = ratio, max(FALL, factor**1.5)
        ratio = reached * factor if reached * factor > SMALL_RATIO else 0.0
        if ratio == 0.0 and factor > 0.5:
            ratio = reached * factor if reached > 0.1 * SMALL_RATIO else 0.0


def joint_motion(wheel: JointedWheel, start: JointMotion | None = None) -> JointMotion:
    """Return a periodic motion on so many instants that the forces have converged.

    Newton's method begins on a coarse grid with the start, with closed joints without slip, and
    with open ones; then damping falls from a large one, or loads grow from zero. Each method can
    fail on one grid only.

    Args:
        wheel: the wheel with joints.
        start: a motion near it, as at another speed; None: none is known.

    Raises:
        NotConverged: no motion was found.
    """
    grid = JointGrid.near(wheel, FIRST_INSTANTS)
    missed = NotConverged("no attempt")
    while grid.instants <= MOST_INSTANTS:
        for way in _ways(grid, start):
            try:
                return _refined(way())
            except NotConverged as reason:
                missed = reason
        grid = JointGrid.near(wheel, 2 * grid.instants)
        if grid.instants > 2 * LEAST_INSTANTS:
            break
    raise missed


def _ways(grid: JointGrid, start: JointMotion | None) -> Iterator[Callable[[], JointMotion]]:
    """Yield methods that may find a motion on a grid."""
    if start is not None:
        yield lambda: solve(start.on(grid))
    yield lambda: stuck(grid)
    yield lambda: solve(JointMotion(grid, np.zeros_like(grid.free)))
    yield lambda: damped(grid)
    yield lambda: loaded(grid)


def _refined(motion: JointMotion) -> JointMotion:
    """Return a motion on so many instants that the forces have converged.

    Raises:
        NotConverged: there is no such motion on finer grids, or the forces still change.
    """
    missed = NotConverged("the forces still change with the finest grid")
    while True:
        grid = JointGrid.near(motion.grid.wheel, 2 * motion.grid.instants)
        if grid.instants > 2 * MOST_INSTANTS:
            raise missed
        try:
            finer = solve(motion.on(grid))
        except NotConverged:
            finer = damped(grid)
        one, other = (each.harmonics[:COMPARED] for each in (motion, finer))
        size = float(np.linalg.norm(other))
        motion = finer
        if np.linalg.norm(other - one) <= CONVERGED * size and grid.instants >= LEAST_INSTANTS:
            return motion
