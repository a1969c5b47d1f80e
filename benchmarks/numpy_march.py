"""The contact march in vectorised NumPy: what one would write without a compiler.

The same algorithm as the compiled kernel: a diagonal recurrence in modal coordinates, gaps by
dense products, complementarity by an active set, correction, energy ledger. Every product is
dense and every array is made once where it can be.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.stage.contact_problem import ContactProblem, Load

BoolArray = NDArray[np.bool_]


class NumpyMarch:
    """A march with permanent sliding and without tip rotation, as the paper's stage has it.

    Args:
        problem: what to march.
        dt: time step [s].
        before, now: modal displacements x_{n-1}, x_n, rotor first [kg^1/2 m], (modes,) each.
        step: n.
    """

    def __init__(
        self, problem: ContactProblem, dt: float, before: FloatArray, now: FloatArray, step: int
    ) -> None:
        if problem.sliding != "permanent" or problem.tip_rotation:
            raise ValueError("expected permanent sliding and no tip rotation")
        rotor, casing = problem.rotor, problem.casing
        frequency = np.concatenate([rotor.frequency, casing.frequency])
        ratio = np.concatenate([rotor.damping_ratio, casing.damping_ratio])
        self.problem, self.dt, self.step = problem, dt, step
        self.before, self.now = before.copy(), now.copy()
        self.stiffness, self.damping = frequency**2, 2.0 * ratio * frequency
        self.inverse = 1.0 / (1.0 / dt**2 + self.damping / (2.0 * dt))
        self.a = self.inverse * (2.0 / dt**2 - self.stiffness)
        self.b = self.inverse * (self.damping / (2.0 * dt) - 1.0 / dt**2)
        self.patterns = [np.concatenate([load.rotor, load.casing]) for load in problem.loads]
        self.rotor_modes, self.nodes = len(rotor.frequency), len(casing.nodal)
        # Nodal w and w' of the casing, node after node, node 0 again at the end.
        again = np.append(np.arange(self.nodes), 0)
        self.surface = casing.nodal[again, :2].reshape(-1, len(casing.frequency))
        self.clearance = casing.clearance[again].ravel()
        self.friction = problem.friction * np.sign(problem.speed)
        tips = len(rotor.tip_angle)
        self.work = np.zeros(4)  # external, normal, friction, damping [J]
        self.gap, self.impulse, self.drag = np.full(tips, np.inf), np.zeros(tips), np.zeros(tips)
        self.touched, self.contacts = np.zeros(tips), 0
        self.records: list[tuple[FloatArray, ...]] = []

    def advance(self, steps: int, record_every: int) -> None:
        """Do that many steps."""
        for _ in range(steps):
            before, now = self.before, self.now
            force = self._force()
            after = self.a * now + self.b * before
            if force is not None:
                after += self.inverse * force
            element, weights = self._place_tips()
            gap = self._gaps(after, element, weights)
            free, free_gap, held = after, gap, gap < 0.0
            active = np.flatnonzero(held)
            while active.size:
                multiplier, normal, tangential = self._multipliers(free_gap, held, element, weights)
                active = np.flatnonzero(held)
                pressed = multiplier @ normal
                dragged = self.friction * (multiplier @ tangential)
                after = free + self.inverse * (pressed + dragged)
                gap = self._gaps(after, element, weights)
                joining = ~held & (gap < 0.0)
                if not joining.any():
                    break
                held |= joining
            moved = 0.5 * (after - before)
            if self.step % record_every == 0:
                self._record(after)
            if force is not None:
                self.work[0] += moved @ force
            if active.size:
                self.work[1] += moved @ pressed
                self.work[2] += moved @ dragged
                self.impulse[active] += self.dt * multiplier
                self.drag[active] += self.dt * self.friction * multiplier
                self.touched[active] += 1.0
            self.contacts = active.size
            self.work[3] += moved @ (self.damping * moved) / self.dt
            np.minimum(self.gap, gap, out=self.gap)
            self.before, self.now, self.step = now, after, self.step + 1

    def _force(self) -> FloatArray | None:
        """Modal force f_n; none where every load is zero."""
        force = None
        for load, pattern in zip(self.problem.loads, self.patterns, strict=True):
            factor = load_factor(load, self.step * self.dt)
            if factor != 0.0:
                force = factor * pattern if force is None else force + factor * pattern
        return force

    def _place_tips(self) -> tuple[IntArray, FloatArray]:
        """Element under each tip at step n + 1 and its Hermite weights, (tips, 4)."""
        problem, nodes = self.problem, self.nodes
        turn = problem.speed * self.dt * (self.step + 1)
        at = np.mod((problem.rotor.tip_angle + turn) * (nodes / (2.0 * np.pi)), nodes)
        element = at.astype(np.int64)
        xi = at - element
        rest, length = 1.0 - xi, problem.casing.element_length
        weights = np.empty((len(xi), 4))
        weights[:, 0] = rest * rest * (1.0 + 2.0 * xi)
        weights[:, 1] = length * xi * rest * rest
        weights[:, 2] = xi * xi * (3.0 - 2.0 * xi)
        weights[:, 3] = -length * xi * xi * rest
        return element % nodes, weights

    def _gaps(self, x: FloatArray, element: IntArray, weights: FloatArray) -> FloatArray:
        """Gap of each tip [m]."""
        radial = self.problem.rotor.tip_radial @ x[: self.rotor_modes]
        surface = (self.surface @ x[self.rotor_modes :] + self.clearance).reshape(-1, 2)
        ends = np.concatenate([surface[element], surface[element + 1]], axis=1)
        return np.einsum("je,je->j", weights, ends) - radial

    def _multipliers(
        self, gap: FloatArray, held: BoolArray, element: IntArray, weights: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Multipliers that close the gaps of the tips held; those they would hold back are let go.

        Returns:
            multipliers [N] of the tips that stay in ``held``, and their rows of B_N and B_T.
        """
        while True:
            active = np.flatnonzero(held)
            normal, tangential = self._rows(active, element, weights)
            response = self.inverse * (normal + self.friction * tangential)
            multiplier = np.linalg.solve(normal @ response.T, -gap[active])
            if (multiplier >= 0.0).all():
                return multiplier, normal, tangential
            held[active[multiplier < 0.0]] = False

    def _rows(
        self, tips: IntArray, element: IntArray, weights: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """B_N and B_T of some tips, (tips, modes) each."""
        rotor, nodal = self.problem.rotor, self.problem.casing.nodal
        e, h = element[tips], weights[tips][:, None, :]
        ends = np.concatenate([nodal[e], nodal[(e + 1) % self.nodes]], axis=1)
        w = (h @ ends[:, [0, 1, 4, 5]])[:, 0]
        u = (h @ ends[:, [2, 3, 6, 7]])[:, 0]
        return np.hstack([-rotor.tip_radial[tips], w]), np.hstack([-rotor.tip_tangential[tips], u])

    def _record(self, after: FloatArray) -> None:
        """What is known at step n; what counts between records starts anew."""
        v = (self.now - self.before) / self.dt
        energy = 0.5 * (v @ v) + 0.5 * self.before @ (self.stiffness * self.now)
        velocity = (after - self.before) / (2.0 * self.dt)
        self.records.append(
            (self.now, velocity, self.gap, self.impulse, self.drag, self.touched,
             np.array([energy, self.contacts]), self.work.copy())
        )  # fmt: skip
        self.gap, self.impulse = np.full_like(self.gap, np.inf), np.zeros_like(self.impulse)
        self.drag, self.touched = np.zeros_like(self.drag), np.zeros_like(self.touched)


def load_factor(load: Load, time: float) -> float:
    """What a load pattern is multiplied with."""
    if time >= load.end:
        return 0.0
    rise = 0.5 - 0.5 * np.cos(np.pi * time / load.ramp) if time < load.ramp else 1.0
    return float(rise * np.cos(load.frequency * time + load.phase))
