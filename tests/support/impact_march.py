"""A march with another time rule and another contact law than the compiled march: the midpoint rule
with the impacts of Moreau and Jean, in plain NumPy.

With A = 1 + h C / 2 + h^2 K / 4 and the forces f at half the step, the velocities without contact
follow from A v_f = v_n - h C v_n / 2 - h K (x_n + h v_n / 4) + h f. With the impulses P_N and P_T
at all tips whose gap would be closed then,

    v_{n+1} = v_f + A^-1 (B_N P_N + B_T P_T),     x_{n+1} = x_n + h (v_n + v_{n+1}) / 2,
    0 <= P_N  perp  u_N >= 0,     |P_T| <= mu P_N,     P_T = -mu P_N sign(u_T) if sliding,

where u_N is the rate of the gap after the step, and u_T the velocity relative to the wall. Tips
stick and slip, and penetrate by the motion in half a step at most.
"""

import numpy as np
from reference_march import Reference

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.stage.contact_problem import ContactProblem

ROUNDS, CLOSE = 2000, 1e-12
"""Largest number of iterations for the impulses, and their change, over the largest velocity, at
which they end."""


class ImpactMarch(Reference):
    """March from rest or motion at t = 0.

    Args:
        problem: contact problem.
        time_step: time step h [s].
    """

    def __init__(self, problem: ContactProblem, time_step: float) -> None:
        super().__init__(problem, time_step, 1)
        start, tips = problem.start, len(problem.rotor.tip_angle)
        self._lost = np.diag(self._damping) + self._by_velocity
        matrix = np.diag(1.0 + 0.25 * time_step**2 * self._stiffness) + 0.5 * time_step * self._lost
        self._answer = np.linalg.inv(matrix)
        self.displacement = np.concatenate([start.rotor, start.casing])  #: x_n, (modes,)
        self.velocity = np.concatenate([start.rotor_velocity, start.casing_velocity])  #: v_n
        self.normal = np.zeros(tips)  #: normal impulse so far [N s], (tips,)
        self.friction = np.zeros(tips)  #: friction impulse so far [N s], (tips,)
        self.stuck = 0  #: number of steps of all tips in which one sticks

    def march(self, steps: int) -> None:
        """Do a number of steps from t = 0."""
        h = self._dt
        for n in range(steps):
            x, v, half = self.displacement, self.velocity, n + 0.5
            middle = x + 0.5 * h * v
            force = (
                self._force(half)
                - self._spring_force(half, middle)
                + self._turning(half, middle, h * v)
            )
            restoring = self._stiffness * (x + 0.25 * h * v)
            after = self._answer @ (v - 0.5 * h * self._lost @ v + h * (force - restoring))
            after = after + self._impacts(n + 1, x + 0.5 * h * (v + after), after)
            self.displacement, self.velocity = x + 0.5 * h * (v + after), after

    def _impacts(self, n: int, seen: FloatArray, free: FloatArray) -> FloatArray:
        """Return the change of the velocities by impulses in step n."""
        normal, tangential, clearance = self._rows(seen, n)
        hit = np.flatnonzero(clearance + normal @ seen < 0.0)
        if not hit.size:
            return np.zeros_like(free)
        passing = self._passing(n, seen)[hit]
        rows = np.concatenate([normal[hit], tangential[hit]])
        answers = self._answer @ rows.T
        rolling = np.full(len(hit), self._problem.rotor.tip_radius * self._problem.speed)
        start, w = rows @ free + np.concatenate([passing, -rolling]), rows @ answers
        impulse, scale = np.zeros(len(rows)), np.abs(start).max()
        for _ in range(ROUNDS):
            before = impulse.copy()
            for i in range(len(hit)):
                for row in (i, i + len(hit)):
                    at = impulse[row] - (start[row] + w[row] @ impulse) / w[row, row]
                    most = np.inf if row == i else self._problem.friction * impulse[i]
                    impulse[row] = np.clip(at, 0.0 if row == i else -most, most)
            if (np.diag(w) * np.abs(impulse - before)).max() <= CLOSE * scale:
                break
        pressed, dragged = np.split(impulse, 2)
        self.normal[hit] += pressed
        self.friction[hit] += dragged
        sticking = np.abs(dragged) < 0.999 * self._problem.friction * pressed
        self.stuck += int(sticking.sum())
        return np.asarray(answers @ impulse)

    def _passing(self, n: int, x: FloatArray) -> FloatArray:
        """Return the rate of each gap by the motion of the tip along the wall and by closure."""
        gaps = []
        for side in (-1e-3, 1e-3):
            normal, _, clearance = self._rows(x, n + side)
            gaps.append(clearance + normal @ x)
        return np.asarray((gaps[1] - gaps[0]) / (2e-3 * self._dt))
