"""The contact march once more, from the definitions, dense and without the kernel.

    A x_{n+1} = f_n - K_n x_n + 2 x_n / dt^2 + (D / (2 dt) - 1 / dt^2) x_{n-1} + (B_N + mu B_T S) l
    A = 1 / dt^2 + D / (2 dt),     0 <= l  perp  clearance + B_N x_{n+1} >= 0

in mass-normalised modes, rotor before casing. The casing's field between nodes is SciPy's cubic
spline of values and slopes; dampers at points are left out.
"""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.stage.contact_problem import ContactProblem


def dense_march(
    given: ContactProblem, dt: float, steps: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """March with dense matrices; return gaps [m], normal and friction impulses [N s] by step."""
    rotor, casing, speed = given.rotor, given.casing, given.speed
    m, tips = len(rotor.frequency), len(rotor.tip_angle)
    omega = np.r_[rotor.frequency, casing.frequency]
    damping = 2.0 * np.r_[rotor.damping_ratio, casing.damping_ratio] * omega
    compliance = 1.0 / (1.0 / dt**2 + damping / (2.0 * dt))
    around = [*range(len(casing.nodal)), 0]
    angles = np.linspace(0.0, 2.0 * np.pi, len(around))
    radial, along, clearance = (
        CubicHermiteSpline(angles, value[around], casing.radius * slope[around])
        for value, slope in (
            (casing.nodal[:, 0], casing.nodal[:, 1]),
            (casing.nodal[:, 2], casing.nodal[:, 3]),
            (casing.clearance[:, 0], casing.clearance[:, 1]),
        )
    )

    def pull(n: int, x: FloatArray) -> FloatArray:
        """Loads less restoring forces at step n."""
        force, time = -(omega**2) * x, n * dt
        for load in given.loads:
            rise = 0.5 - 0.5 * np.cos(np.pi * time / load.ramp) if time < load.ramp else 1.0
            factor = rise * np.cos(load.frequency * time + load.phase) * (time < load.end)
            force = force + factor * np.r_[load.rotor, load.casing]
        if given.springs is not None:
            place = given.springs.places(m)
            force[place] -= given.springs.stiffness(angle=speed * time) @ x[place]
        return np.asarray(force)

    start = given.start
    x, v = np.r_[start.rotor, start.casing], np.r_[start.rotor_velocity, start.casing_velocity]
    before = x - dt * v + 0.5 * dt**2 * (pull(0, x) - damping * v)
    computed = np.zeros((3, steps + 1, tips))
    computed[0, 0] = clearance(np.mod(rotor.tip_angle, 2 * np.pi)) + rotor.tip_recess
    for n in range(steps):
        inertia = 2.0 * x / dt**2 + (damping / (2.0 * dt) - 1.0 / dt**2) * before
        free = compliance * (pull(n, x) + inertia)
        angle = rotor.tip_angle + speed * dt * (n + 1)
        if given.tip_rotation:
            angle = angle + rotor.tip_tangential @ free[:m] / rotor.tip_radius
        angle = np.mod(angle, 2.0 * np.pi)
        normal = np.hstack([-rotor.tip_radial, radial(angle)])
        tangential = np.hstack([-rotor.tip_tangential, along(angle)])
        slides = np.full(tips, speed)
        if given.sliding == "signed":
            slides = rotor.tip_radius * speed - tangential @ (x - before) / dt
        drag = given.friction * np.sign(slides)
        rows = compliance[:, None] * (normal + drag[:, None] * tangential).T
        gap = clearance(angle) + rotor.tip_recess + normal @ free
        force = complementary(gap, normal @ rows)
        before, x = x, free + rows @ force
        left = clearance(angle) + rotor.tip_recess + normal @ x
        computed[:, n + 1] = left, dt * force, dt * drag * force
    return computed[0], computed[1], computed[2]


def complementary(gap: FloatArray, delassus: FloatArray) -> FloatArray:
    """Return forces >= 0 without negative gaps, by correcting an assumed active set.

    Raises:
        ArithmeticError: it goes round in circles.
    """
    touching = gap < 0.0
    for _ in range(4 * len(gap)):
        force, block = np.zeros(len(gap)), np.ix_(touching, touching)
        force[touching] = np.linalg.lstsq(delassus[block], -gap[touching], rcond=None)[0]
        left = gap + delassus @ force
        better = np.where(touching, force >= 0.0, left < -1e-15)
        if (better == touching).all():
            return force
        touching = better
    raise ArithmeticError("no set of touching tips found")
