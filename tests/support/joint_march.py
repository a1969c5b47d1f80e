"""An independent march of all blades of a wheel with joints, in NumPy."""

from dataclasses import dataclass

import numpy as np
import scipy.linalg as la
from joint_cases import TIP, blade

from bladewhirl.meshes.line_mesh import FloatArray


@dataclass(frozen=True)
class Wheel:
    """A wheel of the blades of `joint_cases`, pushed tangentially at the tips."""

    blades: int
    modes: int
    ratio: float  #: damping ratio
    speed: float  #: [rad/s]
    order: int
    amplitude: float  #: of the force on each tip [N]
    gap: float  #: [m]
    friction: float
    angle: float  #: of the normal [rad]
    factors: tuple[float, ...] = ()  #: on the stiffness of each blade
    close: float = 1e-6  #: relative change of the forces at which their iteration ends
    damper: tuple[float, float] | None = None
    """Mass [kg] of dampers in place of joints, and the force that presses each of them outward [N];
    `angle` is that of the normals of their faces from the tangential to the radial direction. They
    do not move along the axis."""
    wall: tuple[float, float, int, float] | None = None
    """Mean clearance [m], amplitude of lobes [m], their number, and friction at the tips."""

    def march(self, steps: int, periods: int) -> tuple[FloatArray, FloatArray]:
        """Return the amplitude of the engine order of the displacement of each tip, (blades, 3),
        and the normal forces of all joints and then tips in the last period, (steps, nodes). Forces
        are constant in a step, with the value at its end."""
        part, n = blade(self.blades), self.blades
        mass, stiffness = np.asarray(part.mass), np.asarray(part.stiffness)
        squares, shapes = la.eigh(stiffness, mass)
        squares, shapes = squares[: self.modes], shapes[:, : self.modes]
        rows = np.vstack(
            [own @ self._cylindrical(part, node) for node, own in enumerate(self._axes)]
        )
        p = rows @ shapes
        c = rows @ la.solve(stiffness, rows.T) - p / squares @ p.T
        load = np.zeros(len(mass))
        load[part.contact_dofs[2, 1]] = self.amplitude
        push = shapes.T @ load
        static = rows @ la.solve(stiffness, load) - p / squares @ push
        static[6:] = 0.0  # tips move with the modes and by forces on them
        turn = self.order * self.speed
        h = 2.0 * np.pi / turn / steps
        given, tuned = np.array(self.factors or (1.0,) * n)[:, None], squares
        squares = given * tuned
        w = np.sqrt(squares)
        wd, decay = w * np.sqrt(1.0 - self.ratio**2), np.exp(-self.ratio * w * h)
        cos, sin = np.cos(wd * h), np.sin(wd * h)
        qq, qv = decay * (cos + self.ratio * w / wd * sin), decay * sin / wd
        vq, vv = -squares * qv, decay * (cos - self.ratio * w / wd * sin)
        by_force = (1.0 - qq) / squares
        count = len(rows)
        tie: FloatArray = np.zeros((3 * n, count * n))
        bodies: FloatArray = np.zeros((3 * n, 3 * n))
        mobility, pull = np.zeros((2, 3 * n))
        for j in range(n):
            following = count * ((j + 1) % n)
            tie[3 * j : 3 * j + 3, following : following + 3] = np.eye(3)
            tie[3 * j : 3 * j + 3, count * j + 3 : count * j + 6] = -np.eye(3)
        if self.damper is not None:
            left, right = tie.clip(min=0.0), -tie.clip(max=0.0)
            tie = np.stack([left.reshape(n, 3, -1), right.reshape(n, 3, -1)], 1).reshape(6 * n, -1)
            bodies = la.block_diag(*[-np.vstack(self._axes)] * n)
            mobility = np.tile([1.0, 1.0, 0.0], n) / self.damper[0]
            pull[::3] = self.damper[1]
        gap, friction = np.full(len(tie) // 3, self.gap), np.full(len(tie) // 3, self.friction)
        slip, angle = np.zeros(len(gap)), 2.0 * np.pi / n * np.arange(n)
        if self.wall is not None:
            tips = np.kron(np.eye(n), np.eye(9)[6:])
            tie, bodies = np.vstack([tie, tips]), np.zeros((6 * n, 3 * n))
            gap, friction = np.append(gap, np.zeros(n)), np.append(friction, [self.wall[3]] * n)
            slip = np.append(slip, np.full(n, TIP * self.speed * h))
        soft = [c / f + p * answer @ p.T for f, answer in zip(given[:, 0], by_force, strict=True)]
        flexible = tie @ la.block_diag(*soft) @ tie.T
        flexible = flexible + 0.5 * h**2 * (bodies * mobility) @ bodies.T
        ahead = np.exp(2j * np.pi * self.order * np.arange(n) / n)[:, None]
        q, v = np.zeros((2, n, self.modes))
        x, rate = np.zeros((2, 3 * n))
        force, place = np.zeros((2, len(tie) // 3, 3))
        normal = np.zeros((steps, len(tie) // 3))
        seen = np.zeros((steps, n, self.modes))
        for step in range(1, steps * periods + 1):
            pushed = (np.exp(1j * turn * h * (step - 0.5)) * ahead).real * push
            pushed = pushed * np.sinc(turn * h / 2.0 / np.pi)
            shift = (np.exp(1j * turn * h * step) * ahead).real * static / given
            q, v = qq * q + qv * v + by_force * pushed, vq * q + vv * v + qv * pushed
            x, rate = x + h * rate + 0.5 * h**2 * mobility * pull, rate + h * mobility * pull
            free = (tie @ (q @ p.T + shift).ravel() + bodies @ x).reshape(-1, 3)
            if self.wall is not None:
                mean, high, lobes, _ = self.wall
                gap[n:] = mean + high * np.cos(lobes * (angle + self.speed * h * step))
            off = np.column_stack([gap, slip - place[:, 1], -place[:, 2]])
            force = self._forces(flexible, free + off, friction, force)
            place = free + (flexible @ force.ravel()).reshape(-1, 3)
            taken = mobility * (bodies.T @ force.ravel())
            x, rate = x + 0.5 * h**2 * taken, rate + h * taken
            joint = (tie.T @ force.ravel()).reshape(n, count) @ p
            q, v = q + by_force * joint, v + qv * joint
            seen[step % steps], normal[step % steps] = q, force[:, 0]
        amplitude = np.fft.fft(seen, axis=0)[1] * 2.0 / steps
        return np.abs(amplitude @ shapes[part.contact_dofs[2]].T), normal

    @property
    def _axes(self) -> tuple[FloatArray, ...]:
        """Normal and tangents of the left and the right node, and of the tip at a wall, by row."""
        cos, sin = np.cos(self.angle), np.sin(self.angle)
        if self.damper is None:
            own = np.array([[0.0, cos, sin], [0.0, -sin, cos], [1.0, 0.0, 0.0]])
            return (own, own) if self.wall is None else (own, own, np.diag([-1.0, 1.0, 1.0]))
        return (
            np.array([[sin, cos, 0.0], [cos, -sin, 0.0], [0.0, 0.0, 1.0]]),
            np.array([[sin, -cos, 0.0], [cos, sin, 0.0], [0.0, 0.0, 1.0]]),
        )

    def _cylindrical(self, part: object, node: int) -> FloatArray:
        position, dofs = part.contact_position[node], part.contact_dofs[node]  # type: ignore[attr-defined]
        a = np.arctan2(position[1], position[0])
        rows = np.zeros((3, len(part.mass)))  # type: ignore[attr-defined]
        rows[:, dofs] = [[np.cos(a), np.sin(a), 0.0], [-np.sin(a), np.cos(a), 0.0], [0.0, 0.0, 1.0]]
        return rows

    def _forces(
        self, flexible: FloatArray, free: FloatArray, friction: FloatArray, force: FloatArray
    ) -> FloatArray:
        """Projected relaxation of the contact law at the end of a step, from gaps and slips without
        forces."""
        own = np.diag(flexible).reshape(-1, 3).max(axis=1)
        unit = np.repeat(own**-0.5, 3)
        soft = (own * np.linalg.eigvalsh(unit[:, None] * flexible * unit)[-1])[:, None]
        for _ in range(20000):
            moved = free + (flexible @ force.ravel()).reshape(-1, 3)
            after = force - moved / soft
            after[:, 0] = np.maximum(after[:, 0], 0.0)
            size = np.hypot(after[:, 1], after[:, 2])
            limit = friction * after[:, 0]
            after[:, 1:] *= (np.minimum(size, limit) / np.where(size > 0.0, size, 1.0))[:, None]
            change = np.abs(after - force).max()
            force = after
            if change <= self.close * np.abs(force).max():
                break
        return force
