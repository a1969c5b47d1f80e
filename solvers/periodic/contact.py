"""Periodic contact forces on a grid of instants, by a semismooth Newton method.

With the normal forces lambda and the angles psi of the directions of sliding d = (cos psi, sin psi)
along the tangent and the axis, f = -lambda (e_r + mu d). On the active set lambda > eps g, with a
stiffness 1 / eps of the contact nodes, the equations are

    g = 0,    v_z cos psi - v_t sin psi = 0

with the gap g and the slip velocity v; outside it lambda = 0. All of them have exact derivatives.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from bladewhirl.meshes.line_mesh import BoolArray, FloatArray
from bladewhirl.solvers.periodic.blade import DIRECTIONS, Grid

TOGETHER = 15  #: Newton steps with changes of all wrong members of the active set
MEMORY = 8  #: periods divided by the time in which a wrong member causes others
FIRST_RELAXATION, LAST_RELAXATION = 1.0, 1e-10
"""Largest and smallest product lambda g of `relaxed`, relative to the square of a gap."""
RELAXED_STEPS = 12  #: largest number of Newton steps for one product
REPEATED = 1e-6  #: harmonics of forces below this fraction of the largest are zero
SAME, SAME_ANGLE = 1e-11, 1e-8
"""Relative change of the forces, and change of the directions of sliding [rad], at which Newton's
method ends."""
STRAIGHT = 0.5  #: largest change of a direction of sliding in a Newton step [rad]
PATIENT_INSTANTS = 256  #: most instants for which few wrong members change at once
SMALLEST_SHARE = 1e-3  #: smallest step of the distance by which the wall moves in


class NotConverged(ArithmeticError):
    """Newton's method found no periodic motion."""


@dataclass(frozen=True)
class Motion:
    """Contact forces over one period; arrays have the shape (instants, nodes)."""

    grid: Grid
    normal: FloatArray  #: normal forces lambda [N]
    angle: FloatArray  #: angles psi of the directions of sliding [rad]
    offset: float | FloatArray = field(default=0.0, kw_only=True)
    """Distance by which the wall is moved out [m], also one for each instant and node."""

    @classmethod
    def free(cls, grid: Grid, offset: float | FloatArray = 0.0) -> "Motion":
        """Return the motion without contact forces; sliding is along the rotation."""
        rest = np.zeros(grid.free_gap.shape)
        return cls(grid, rest, rest + (0.0 if grid.blade.speed > 0.0 else np.pi), offset=offset)

    @cached_property
    def ways(self) -> FloatArray:
        """Directions e_r + mu d against which forces act, (instants, nodes, 3)."""
        mu = self.grid.blade.friction
        return np.stack(
            [np.ones_like(self.angle), mu * np.cos(self.angle), mu * np.sin(self.angle)], axis=-1
        )

    @cached_property
    def force(self) -> FloatArray:
        """Contact forces [N], (instants, 3 * nodes)."""
        force = -self.normal[..., None] * self.ways
        return np.asarray(force.reshape(self.grid.instants, -1))

    @cached_property
    def modes(self) -> FloatArray:
        """Modal coordinates [kg^1/2 m] and velocities [kg^1/2 m/s], (2, instants, modes)."""
        return self.grid.modes(self.force)

    @cached_property
    def displacement(self) -> FloatArray:
        """Displacements of the contact nodes [m], (instants, 3 * nodes)."""
        return self.grid.displacement(self.force, self.modes)

    @cached_property
    def gap(self) -> FloatArray:
        """Gaps [m]."""
        moved = self.displacement + self.grid.against_ring(self.force)[0]
        return np.asarray(self.grid.wall - moved[:, ::DIRECTIONS] + self.offset)

    @cached_property
    def slip(self) -> FloatArray:
        """Tangential and axial slip velocities [m/s], (instants, nodes, 2)."""
        return self.grid.slip(self.force, self.modes)

    @cached_property
    def across(self) -> FloatArray:
        """Slip velocities across the directions of sliding, relative to the rotation."""
        cosine, sine = np.cos(self.angle), np.sin(self.angle)
        across = self.slip[..., 1] * cosine - self.slip[..., 0] * sine
        return np.asarray(across / np.abs(self.grid.blade.speed * self.grid.blade.radius))

    @property
    def sliding(self) -> FloatArray:
        """Angles of the slip velocities [rad]; those of the rotation if they are known."""
        ahead = self.grid.blade.speed > 0.0
        if not self.grid.blade.turns:
            return np.full(self.normal.shape, 0.0 if ahead else np.pi)
        along, axial = (1.0 if ahead else -1.0) * np.moveaxis(self.slip, -1, 0)
        return np.asarray(np.arctan2(axial, along) + (0.0 if ahead else np.pi))

    @property
    def touches(self) -> bool:
        """True if there is contact."""
        return bool(self.normal.any())

    @property
    def impulse(self) -> float:
        """Impulse of the normal forces in a revolution [N s]."""
        return float(self.normal.sum() * self.grid.step * self.grid.blade.first_order)

    @property
    def repeats(self) -> bool:
        """True if the forces repeat in less than the period of the motion."""
        spectrum, periods = np.abs(np.fft.rfft(self.normal, axis=0)), self.grid.blade.periods
        number = np.arange(len(spectrum))
        return any(
            spectrum[number % part != 0].max(initial=0.0) <= REPEATED * spectrum.max()
            for part in range(2, periods + 1)
            if periods % part == 0
        )

    @property
    def residual(self) -> float:
        """Largest |min(g, eps lambda)| relative to the largest eps lambda, or the largest sine of
        the angle between friction and slip velocity under forces, whichever is larger."""
        flexible = self.normal / self.grid.blade.stiffness_scale
        scale = flexible.max() if self.touches else np.abs(self.gap).max()
        worst = float(np.abs(np.minimum(self.gap, flexible)).max() / scale)
        if not self.grid.blade.turns or not self.touches:
            return worst
        along = self.slip[..., 0] * np.cos(self.angle) + self.slip[..., 1] * np.sin(self.angle)
        along = along / np.abs(self.grid.blade.speed * self.grid.blade.radius)
        turned = np.abs(np.arctan2(self.across, along))[self.normal > 0.0]
        return max(worst, float(np.sin(np.minimum(turned, 0.5 * np.pi)).max()))

    def on(self, grid: Grid) -> "Motion":
        """Return the motion on another grid, between its instants by linear interpolation; the wall
        has its own place."""
        normal, angle = (resampled(each, grid.instants) for each in (self.normal, self.angle))
        return Motion(grid, normal, angle)


@dataclass(frozen=True)
class Equations:
    """Equations of an active set at a motion: rows are the gaps and, with unknown directions of
    sliding, the slip across them; columns belong to the normal forces and to the angles."""

    value: FloatArray  #: residuals, (rows,)
    matrix: FloatArray  #: derivatives, (rows, rows)


def resampled(values: FloatArray, instants: int) -> FloatArray:
    """Return values over a period on another number of instants by linear interpolation."""
    place = np.arange(instants) * (len(values) / instants)
    low = place.astype(int)
    share = (place - low)[:, None]
    return np.asarray((1.0 - share) * values[low] + share * values[(low + 1) % len(values)])


def active(motion: Motion) -> BoolArray:
    """Return the active set, (instants, nodes)."""
    return np.asarray(motion.normal > motion.grid.blade.stiffness_scale * motion.gap)


def equations(motion: Motion, chosen: BoolArray, by: Grid | None = None) -> Equations:
    """Return the equations of the active set `chosen`, (instants, nodes), outside of which normal
    forces are zero; the derivatives are those of responses of the grid `by`, if given."""
    grid, blade = motion.grid, motion.grid.blade
    instant, node = np.nonzero(chosen)
    lag = (instant[:, None] - instant) % grid.instants
    place = (node[:, None] * blade.nodes + node) * grid.instants + lag
    ways = motion.ways[chosen]

    (moved,), (tangential_rate, axial_rate) = (grid if by is None else by).lagged

    def answer(row: FloatArray, forces: FloatArray) -> FloatArray:
        """Return how a component of displacement or velocity at each member answers to forces on
        each member."""
        total = np.zeros(place.shape)
        for column in range(DIRECTIONS):
            if forces[:, column].any():
                total += np.take(row[column], place) * forces[:, column]
        return total

    by_normal = answer(moved, ways)  # gap: -u_r, and forces are -lambda ways
    if not blade.turns:
        return Equations(values(motion, chosen), by_normal)
    cosine, sine = np.cos(motion.angle[chosen]), np.sin(motion.angle[chosen])
    pressed = blade.friction * motion.normal[chosen]
    turned = np.stack([0.0 * sine, -pressed * sine, pressed * cosine], axis=-1)
    tangential, axial = motion.slip[chosen].T
    unit = 1.0 / abs(blade.speed * blade.radius[node])
    blocks = [
        -(unit * cosine)[:, None] * answer(axial_rate, by)
        + (unit * sine)[:, None] * answer(tangential_rate, by)
        for by in (ways, turned)
    ]
    blocks[1] -= np.diag(unit * (axial * sine + tangential * cosine))
    matrix = np.block([[by_normal, answer(moved, turned)], blocks])
    return Equations(values(motion, chosen), matrix)


def values(motion: Motion, chosen: BoolArray) -> FloatArray:
    """Return the residuals of the equations of an active set, see `Equations`."""
    across = motion.across[chosen] if motion.grid.blade.turns else ()
    return np.concatenate([motion.gap[chosen], across])


def moved(motion: Motion, chosen: BoolArray, change: FloatArray) -> Motion:
    """Return a motion whose normal forces and angles on an active set have changed."""
    normal, angle = motion.normal.copy(), motion.angle.copy()
    count = np.count_nonzero(chosen)
    normal[chosen] += change[:count]
    angle[chosen] += (
        np.clip(change[count : 2 * count], -STRAIGHT, STRAIGHT) if len(change) > count else 0.0
    )
    return replace(motion, normal=normal, angle=angle)


def released(motion: Motion, chosen: BoolArray) -> Motion:
    """Return a motion without normal forces outside an active set."""
    if not motion.normal[~chosen].any():
        return motion
    return replace(motion, normal=np.where(chosen, motion.normal, 0.0))


def solve(start: Motion) -> Motion:
    """Return the periodic motion to which Newton's method leads.

    All wrong members of the active set change at once. If this fails on a coarse grid, only those
    change that follow no other wrong member within a part of the period: errors propagate forward
    in time.

    Raises:
        NotConverged: no motion was found.
    """
    try:
        return _newton(start, 0, TOGETHER)
    except NotConverged:
        if start.grid.instants > PATIENT_INSTANTS:
            raise
        return _newton(start, start.grid.instants // MEMORY, start.grid.instants)


def _newton(start: Motion, memory: int, most: int) -> Motion:
    """Return the motion of `solve`; members change that follow none within `memory` instants."""
    motion, chosen = start, active(start)
    for _ in range(most):
        motion = released(motion, chosen)
        if chosen.any():
            system = equations(motion, chosen)
            try:
                change = np.asarray(np.linalg.solve(system.matrix, -system.value), dtype=np.float64)
            except np.linalg.LinAlgError:
                break
            motion = moved(motion, chosen, change)
            forces, angles = np.split(np.abs(change), [np.count_nonzero(chosen)])
            converged = forces.max() < SAME * np.abs(motion.normal).max()
            converged &= angles.max(initial=0.0) < SAME_ANGLE
        else:
            converged = True
        wrong = active(motion) != chosen
        if not wrong.any() and converged:
            return motion
        if memory:
            late, instants = wrong.any(axis=1), np.arange(len(wrong))
            before = sum(late[(instants - k) % len(wrong)] for k in range(1, memory))
            wrong &= (before == 0)[:, None]
        chosen = chosen ^ wrong
    raise NotConverged(
        f"Newton's method did not converge in {most} steps with {start.grid.instants} instants"
    )


def relaxed(start: Motion) -> Motion:
    """Return a motion near which `solve` finds a periodic one, by an interior-point method.

    All members satisfy lambda g = tau with a tau that decreases, in the form of Chen and Harker,
    a + b - ((a - b)^2 + 4 tau)^(1/2) = 0 with a = eps lambda and b = g.
    """
    motion, every = start, np.ones(start.normal.shape, dtype=np.bool_)
    soft, count = start.grid.blade.stiffness_scale, start.normal.size

    def errors(motion: Motion, system: Equations, tau: float) -> tuple[FloatArray, FloatArray]:
        """Return the residuals, and the derivatives by a minus one."""
        a, b = motion.normal.ravel() / soft, system.value[:count]
        root = np.sqrt((a - b) ** 2 + 4.0 * tau)
        return np.concatenate([(a + b - root) / unit, system.value[count:]]), (b - a) / root

    unit = float(np.abs(start.gap).min(axis=1).mean() + np.abs(np.minimum(start.gap, 0.0)).max())
    tau = FIRST_RELAXATION * unit**2
    system = equations(motion, every)
    while tau > LAST_RELAXATION * unit**2:
        for _ in range(RELAXED_STEPS):
            value, lean = errors(motion, system, tau)
            matrix = system.matrix.copy()
            matrix[:count] *= (1.0 - lean)[:, None] / unit
            matrix[np.arange(count), np.arange(count)] += (1.0 + lean) / (soft * unit)
            try:
                change = np.asarray(np.linalg.solve(matrix, -value), dtype=np.float64)
            except np.linalg.LinAlgError:
                return motion
            share, size = 1.0, float(np.linalg.norm(value))
            while True:
                trial = moved(motion, every, np.asarray(share * change))
                further = equations(trial, every)
                after = float(np.linalg.norm(errors(trial, further, tau)[0]))
                if after < size or share < SMALLEST_SHARE:
                    break
                share *= 0.5
            motion, system = trial, further
            if after < 0.1 * np.sqrt(tau) / unit or share < SMALLEST_SHARE:
                break
        tau *= 0.1
    return motion
