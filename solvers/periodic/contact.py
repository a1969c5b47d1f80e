"""Periodic contact forces on a grid of instants, by a semismooth Newton method.

With the normal forces lambda and the angles psi of the directions of sliding d = (cos psi, sin psi)
along the tangent and the axis, f = -lambda (e_r + mu d). On the active set lambda > eps g, with a
stiffness 1 / eps of the contact nodes, the equations are

    g = 0,    v_z cos psi - v_t sin psi = 0

with the gap g and the slip velocity v; outside it lambda = 0. All of them have exact derivatives.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from bladewhirl.meshes.line_mesh import BoolArray, FloatArray
from bladewhirl.solvers.periodic.blade import DIRECTIONS, Blade, Grid

TOGETHER = 15  #: Newton steps with changes of all wrong members of the active set
MEMORY = 8  #: periods divided by the time in which a wrong member causes others
FIRST_RELAXATION, LAST_RELAXATION = 1.0, 1e-10
"""Largest and smallest product lambda g of `relaxed`, relative to the square of a gap."""
RELAXED_STEPS = 12  #: largest number of Newton steps for one product
SAME, SAME_ANGLE = 1e-11, 1e-8
"""Relative change of the forces, and change of the directions of sliding [rad], at which Newton's
method ends."""
STRAIGHT = 0.5  #: largest change of a direction of sliding in a Newton step [rad]
FIRST_INSTANTS, LEAST_INSTANTS, MOST_INSTANTS = 64, 512, 2048
"""Instants of the first grid, of the coarsest grid of a result, and of the finest grid."""
IMPULSE_ERROR = 1e-3
"""Change of the impulse with the last refinement; the error of the finer grid is smaller."""
SMALLEST_SHARE = 1e-3  #: smallest step of the distance by which the wall moves in


class NotConverged(ArithmeticError):
    """Newton's method found no periodic motion."""


@dataclass(frozen=True)
class Motion:
    """Contact forces over one period; arrays have the shape (instants, nodes)."""

    grid: Grid
    normal: FloatArray  #: normal forces lambda [N]
    angle: FloatArray  #: angles psi of the directions of sliding [rad]
    offset: float = field(default=0.0, kw_only=True)  #: distance by which the wall is moved out [m]

    @classmethod
    def free(cls, grid: Grid, offset: float = 0.0) -> "Motion":
        """Return the motion without contact forces; sliding is along the rotation."""
        rest = np.zeros(grid.free_gap.shape)
        return cls(grid, rest, rest + (0.0 if grid.blade.speed > 0.0 else np.pi), offset=offset)

    @property
    def ways(self) -> FloatArray:
        """Directions e_r + mu d against which forces act, (instants, nodes, 3)."""
        mu = self.grid.blade.friction
        return np.stack(
            [np.ones_like(self.angle), mu * np.cos(self.angle), mu * np.sin(self.angle)], axis=-1
        )

    @property
    def force(self) -> FloatArray:
        """Contact forces [N], (instants, 3 * nodes)."""
        force = -self.normal[..., None] * self.ways
        return np.asarray(force.reshape(self.grid.instants, -1))

    @property
    def gap(self) -> FloatArray:
        """Gaps [m]."""
        return self.grid.gap(self.force) + self.offset

    @property
    def touches(self) -> bool:
        """True if there is contact."""
        return bool(self.normal.any())

    @property
    def impulse(self) -> float:
        """Impulse of the normal forces in a revolution [N s]."""
        return float(self.normal.sum() * self.grid.step * self.grid.blade.lobes)

    @property
    def residual(self) -> float:
        """Largest |min(g, eps lambda)| relative to the largest eps lambda, or the largest sine of
        the angle between friction and slip velocity under forces, whichever is larger."""
        flexible = self.normal / self.grid.blade.stiffness_scale
        scale = flexible.max() if self.touches else np.abs(self.gap).max()
        worst = float(np.abs(np.minimum(self.gap, flexible)).max() / scale)
        if not self.grid.blade.turns or not self.touches:
            return worst
        slip = self.grid.slip(self.force)
        across = slip[..., 1] * np.cos(self.angle) - slip[..., 0] * np.sin(self.angle)
        along = slip[..., 0] * np.cos(self.angle) + slip[..., 1] * np.sin(self.angle)
        turned = np.abs(np.arctan2(across, along))[self.normal > 0.0]
        return max(worst, float(np.sin(np.minimum(turned, 0.5 * np.pi)).max()))

    def on(self, grid: Grid) -> "Motion":
        """Return the motion on another grid, between its instants by linear interpolation."""
        place = np.arange(grid.instants) * (self.grid.instants / grid.instants)
        low = place.astype(int)
        share = (place - low)[:, None]
        high = (low + 1) % self.grid.instants
        normal, angle = (
            (1.0 - share) * each[low] + share * each[high] for each in (self.normal, self.angle)
        )
        return Motion(grid, normal, angle, offset=self.offset)


@dataclass(frozen=True)
class Equations:
    """Equations of an active set at a motion: rows are the gaps and, with unknown directions of
    sliding, the slip across them; columns belong to the normal forces and to the angles."""

    value: FloatArray  #: residuals, (rows,)
    matrix: FloatArray  #: derivatives, (rows, rows)


def active(motion: Motion) -> BoolArray:
    """Return the active set, (instants, nodes)."""
    return np.asarray(motion.normal > motion.grid.blade.stiffness_scale * motion.gap)


def equations(motion: Motion, chosen: BoolArray) -> Equations:
    """Return the equations of the active set `chosen`, (instants, nodes), outside of which normal
    forces are zero."""
    grid, blade = motion.grid, motion.grid.blade
    instant, node = np.nonzero(chosen)
    apart = (instant[:, None] - instant) % grid.instants
    ways = motion.ways[chosen]
    gap = motion.gap[chosen]

    def answer(kernel: FloatArray, row: int, by: FloatArray) -> FloatArray:
        """Return how component `row` at each member answers to forces `by` on each member."""
        total = np.zeros(apart.shape)
        for column in range(DIRECTIONS):
            if by[:, column].any():
                total += (
                    kernel[apart, DIRECTIONS * node[:, None] + row, DIRECTIONS * node + column]
                    * by[:, column]
                )
        return total

    by_normal = answer(grid.by_force, 0, ways)  # gap: -u_r, and forces are -lambda ways
    if not blade.turns:
        return Equations(gap, by_normal)
    cosine, sine = np.cos(motion.angle[chosen]), np.sin(motion.angle[chosen])
    pressed = blade.friction * motion.normal[chosen]
    turned = np.stack([0.0 * sine, -pressed * sine, pressed * cosine], axis=-1)
    tangential, axial = grid.slip(motion.force)[chosen].T
    # Slip across the direction of sliding, relative to that of the rotation.
    unit = 1.0 / abs(blade.speed * blade.radius[node])
    across = unit * (axial * cosine - tangential * sine)
    blocks = [
        -(unit * cosine)[:, None] * answer(grid.rate_by_force, 2, by)
        + (unit * sine)[:, None] * answer(grid.rate_by_force, 1, by)
        for by in (ways, turned)
    ]
    blocks[1] -= np.diag(unit * (axial * sine + tangential * cosine))
    matrix = np.block([[by_normal, answer(grid.by_force, 0, turned)], blocks])
    return Equations(np.concatenate([gap, across]), matrix)


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
    return replace(motion, normal=np.where(chosen, motion.normal, 0.0))


def solve(start: Motion) -> Motion:
    """Return the periodic motion to which Newton's method leads.

    All wrong members of the active set change at once. If this fails, only those change that follow
    no other wrong member within a part of the period: errors propagate forward in time.

    Raises:
        NotConverged: no motion was found.
    """
    try:
        return _newton(start, 0, TOGETHER)
    except NotConverged:
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


def solve_from(start: Motion) -> Motion:
    """Return the periodic motion that `solve` finds from a motion, if necessary by `relaxed`.

    Raises:
        NotConverged: no motion was found.
    """
    try:
        return solve(start)
    except NotConverged:
        return solve(relaxed(start))


def periodic_motion(blade: Blade, start: Motion | None = None) -> Motion:
    """Return a periodic motion on so many instants that the impulse has converged.

    Coarse grids can have motions that finer grids do not have, and Newton's method can fail on one
    grid only. The grid is therefore refined until two in turn agree.

    Args:
        blade: the structure in its wall.
        start: where Newton's method begins; None: the motion without contact.

    Raises:
        NotConverged: no motion was found.
    """
    grid = Grid(blade, FIRST_INSTANTS)
    motion = solve_from(Motion.free(grid) if start is None else start.on(grid))
    if not motion.touches:
        return motion
    missed = "on finer grids Newton's method does not converge"
    while (grid := grid.finer()).instants <= MOST_INSTANTS:
        try:
            finer = solve(motion.on(grid))
        except NotConverged:
            continue
        error = abs(finer.impulse - motion.impulse)
        motion = finer
        if grid.instants >= LEAST_INSTANTS and error <= IMPULSE_ERROR * motion.impulse:
            return motion
        missed = (
            f"with {grid.instants} instants the impulse still changes by"
            f" {error / motion.impulse:.2%}"
        )
    raise NotConverged(missed)
