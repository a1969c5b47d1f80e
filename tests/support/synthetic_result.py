"""A result Dataset with closed-form motions, laid out like `result.nc`, for tests of postprocess.

Nothing here comes from the package: shapes and histories are written out, so what postprocess
makes of them can be compared with formulas.

Rotor modes (unit coordinate): 0, 1 rigid translation along x and y, 2 rigid rotation, 3, 4 first
blade bending with one nodal diameter (cos, sin), tip amplitude 1. Casing modes: 0, 1 translation
along x and y, 2, 3 ovalisation cos 2 theta and sin 2 theta (inextensional), all of unit radial
amplitude and exact Hermite data.
"""

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from bladewhirl.solvers.march.schema import RESULT_FORMAT

REPORT = {
    "complementarity_residual": 3.25e-12,
    "unsolved_steps": 0,
    "dt_over_critical": 0.2125,
    "steps": 400_000,
    "wall_time": 1.75,
    "us_per_step": 4.375,
}
"""Quality measures of a march."""

Array = NDArray[np.float64]

TIP_RADIUS = 0.25
DISK_RADIUS = 0.15
CLEARANCE = 1e-3
YOUNG_MODULUS = 2.1e11
SPEED = 80.0  # rad/s
RECORD_STEP = 1e-3
ROTOR_FREQUENCY = np.array([190.0, 190.0, 400.0, 75.0, 75.0])  # rad/s
CASING_FREQUENCY = np.array([5.0, 5.0, 60.0, 60.0])


def rotor_geometry(blades: int, elements: int) -> tuple[Array, NDArray[np.int64], list[str], Array]:
    """Points (node, 2), lines (line, 2), part of each line, tip angles; node 0 is the centre."""
    angles = 2 * np.pi * np.arange(blades) / blades
    radii = np.linspace(DISK_RADIUS, TIP_RADIUS, elements + 1)
    directions = np.column_stack([np.cos(angles), np.sin(angles)])
    blade_points = radii[None, :, None] * directions[:, None, :]
    points = np.vstack([np.zeros((1, 2)), blade_points.reshape(-1, 2)])
    node = 1 + np.arange(blades * (elements + 1)).reshape(blades, elements + 1)
    spokes = np.column_stack([np.zeros(blades, dtype=np.int64), node[:, 0]])
    rim = np.column_stack([node[:, 0], np.roll(node[:, 0], -1)])
    along = np.stack([node[:, :-1], node[:, 1:]], axis=-1).reshape(-1, 2)
    parts = ["spokes"] * blades + ["rim"] * blades + ["blades"] * len(along)
    return points, np.vstack([spokes, rim, along]), parts, angles


def rotor_shapes(points: Array) -> Array:
    """Shapes (node, component x y rotation, mode) of the five rotor modes."""
    x, y = points.T
    radius = np.hypot(x, y)
    angle = np.arctan2(y, x)
    shape = np.zeros((len(points), 3, 5))
    shape[:, 0, 0] = 1.0
    shape[:, 1, 1] = 1.0
    shape[:, 0, 2], shape[:, 1, 2], shape[:, 2, 2] = -y, x, 1.0
    length = TIP_RADIUS - DISK_RADIUS
    xi = np.clip((radius - DISK_RADIUS) / length, 0.0, None)
    bending, slope = xi**2 * (3 - xi) / 2, (6 * xi - 3 * xi**2) / (2 * length)
    for mode, wave in ((3, np.cos(angle)), (4, np.sin(angle))):
        shape[:, 0, mode] = -np.sin(angle) * bending * wave
        shape[:, 1, mode] = np.cos(angle) * bending * wave
        shape[:, 2, mode] = slope * wave
    return shape


def casing_shapes(angles: Array, radius: float) -> Array:
    """Shapes (node, component w w_s u u_s, mode) of the four casing modes."""
    shape = np.empty((len(angles), 4, 4))
    for pair, k in ((0, 1), (2, 2)):
        c, s = np.cos(k * angles), np.sin(k * angles)
        shape[:, :, pair] = np.column_stack([c, -k * s / radius, -s / k, -c / radius])
        shape[:, :, pair + 1] = np.column_stack([s, k * c / radius, c / k, -s / radius])
    return shape


def casing_w(angle: Array, coordinates: Array) -> Array:
    """Radial displacement of the ring at angles (..., point) for coordinates (..., 4)."""
    waves = np.stack([np.cos(angle), np.sin(angle), np.cos(2 * angle), np.sin(2 * angle)], axis=-1)
    w: Array = np.einsum("...pm,...m->...p", waves, coordinates)
    return w


def synthetic_result(
    *,
    blades: int = 22,
    elements: int = 4,
    casing_elements: int = 40,
    records: int = 401,
    shaft_radius: float = 0.8e-3,
    bending: float = 0.3e-3,
    ovalisation: float = 0.2e-3,
    growth: float = 0.0,
    speed: float = SPEED,
    friction: float = 0.1,
) -> xr.Dataset:
    """A shaft that whirls backward in rotating axes at 70 rad/s, blades that bend, a casing
    that ovalises. `growth` [1/s] makes the whirl grow exponentially. Gaps below zero are cut to
    zero and pushed upon with 1e6 N per metre of penetration, as if contact had done that.
    """
    radius = TIP_RADIUS + CLEARANCE
    points, lines, parts, tip_angle = rotor_geometry(blades, elements)
    tips = 1 + elements + (elements + 1) * np.arange(blades)
    ring = 2 * np.pi * np.arange(casing_elements) / casing_elements
    time = RECORD_STEP * np.arange(records)

    def history(amplitude: Array, rate: Array, phase: Array, growth: Array) -> tuple[Array, Array]:
        turn = rate * time[:, None] + phase
        size = amplitude * np.exp(growth * time[:, None])
        return size * np.cos(turn), size * (growth * np.cos(turn) - rate * np.sin(turn))

    quarter = np.pi / 2
    q, q_dot = history(
        np.array([shaft_radius, shaft_radius, 1e-4, bending, bending]),
        np.array([-70.0, -70.0, 40.0, -75.0, -75.0]),
        np.array([0.0, -quarter, -quarter, 0.0, -quarter]),
        np.array([growth, growth, 0.0, growth, growth]),
    )
    c, c_dot = history(
        np.array([1e-4, 1e-4, ovalisation, ovalisation]),
        np.array([5.0, 5.0, 60.0, 60.0]),
        np.array([0.0, -quarter, 0.0, -quarter]),
        np.zeros(4),
    )
    rotor_shape = rotor_shapes(points)
    cos, sin = np.cos(tip_angle), np.sin(tip_angle)
    polar = np.array([[cos, sin], [-sin, cos], [0.0 * cos, 0.0 * cos]])  # direction, axis, blade
    tip_shape = np.einsum("dab,bam->bdm", polar, rotor_shape[tips, :2])
    turned = tip_angle[None, :] + speed * time[:, None]
    gap = CLEARANCE + casing_w(turned, c) - q @ tip_shape[:, 0].T
    impulse = 1e6 * np.clip(-gap, 0.0, None) * RECORD_STEP
    energy = 0.5 * (
        np.sum(q_dot**2 + (ROTOR_FREQUENCY * q) ** 2, axis=1)
        + np.sum(c_dot**2 + (CASING_FREQUENCY * c) ** 2, axis=1)
    )
    friction_work = -np.cumsum(np.sum(friction * impulse, axis=1)) * speed * radius
    damping_work = 0.1 * energy[0] * time / time[-1] if records > 1 else np.zeros(records)
    coupling_work = -0.5 * damping_work
    taken = damping_work - coupling_work
    per_node = ("time", "contact_node")
    return xr.Dataset(
        data_vars={
            "rotor_displacement": (("time", "rotor_mode"), q),
            "rotor_velocity": (("time", "rotor_mode"), q_dot),
            "casing_displacement": (("time", "casing_mode"), c),
            "casing_velocity": (("time", "casing_mode"), c_dot),
            "gap": (per_node, np.clip(gap, 0.0, None)),
            "contact_impulse": (per_node, impulse),
            "friction_impulse": (per_node, friction * impulse),
            "axial_impulse": (per_node, np.zeros_like(impulse)),
            "contact_steps": (per_node, np.where(impulse > 0, 1000, 0)),
            "contacts": ("time", np.sum(impulse > 0, axis=1)),
            "energy": ("time", energy),
            "external_work": ("time", energy - energy[0] - friction_work + taken),
            "normal_work": ("time", np.zeros(records)),
            "closing_work": ("time", np.zeros(records)),
            "friction_work": ("time", friction_work),
            "damping_work": ("time", damping_work),
            "coupling_work": ("time", coupling_work),
            **{
                f"rotor_{way}frequency": ("rotor_mode", ROTOR_FREQUENCY)
                for way in ("", "backward_", "forward_")
            },
            "rotor_nodal_diameter": ("rotor_mode", np.array([1, 1, 0, 1, 1])),
            "rotor_family": (
                "rotor_mode",
                np.array(["suspension", "suspension", "2F", "1F", "1F"], dtype=object),
            ),
            "rotor_spring_share": ("rotor_mode", np.array([0.9, 0.9, 0.0, 0.05, 0.05])),
            "casing_frequency": ("casing_mode", CASING_FREQUENCY),
            "casing_nodal_diameter": ("casing_mode", np.array([1, 1, 2, 2])),
            "casing_family": ("casing_mode", np.array(["radial"] * 4, dtype=object)),
            "rotor_point": (("rotor_node", "axis"), points),
            "rotor_line": (("rotor_line", "end"), lines),
            "rotor_thickness": ("rotor_line", np.where(np.array(parts) == "blades", 0.010, 0.030)),
            **{
                f"rotor_{name}_change": ("rotor_line", np.zeros(len(lines)))
                for name in ("thickness", "width", "young_modulus")
            },
            "rotor_width": ("rotor_line", np.full(len(lines), 0.1)),
            "rotor_young_modulus": ("rotor_line", np.full(len(lines), YOUNG_MODULUS)),
            "rotor_part": ("rotor_line", np.array(parts, dtype=object)),
            "rotor_shape": (("rotor_node", "rotor_component", "rotor_mode"), rotor_shape),
            "tip_node": ("contact_node", tips),
            "blade": ("contact_node", np.arange(blades)),
            "node": ("contact_node", np.zeros(blades, dtype=np.int64)),
            "tip_angle": ("contact_node", tip_angle),
            "contact_radius": ("contact_node", np.full(blades, TIP_RADIUS)),
            "axial_position": ("contact_node", np.zeros(blades)),
            **{name: ("contact_node", np.zeros(blades)) for name in ("tip_recess", "tip_growth")},
            "contact_shape": (("contact_node", "direction", "mode"), tip_shape),
            "contact_displacement": (
                ("time", "contact_node", "direction"),
                np.einsum("rm,bdm->rbd", q, tip_shape),
            ),
            "copy_angle": ("copy", np.zeros(1)),
            "centre_node": ((), 0),
            "centre_shape": (("axis", "rotor_mode"), rotor_shape[0, :2]),
            "shaft_frame": ((), "rotating"),
            "shaft_stiffness": ("axis", np.full(2, 3.4e7)),
            "shaft_damping": ("axis", np.zeros(2)),
            "casing_angle": ("casing_node", ring),
            "casing_thickness": ("casing_node", np.full(casing_elements, 0.010)),
            "casing_width": ("casing_node", np.full(casing_elements, 0.1)),
            "casing_young_modulus": ("casing_node", np.full(casing_elements, YOUNG_MODULUS)),
            "casing_curvature": ((), "exact"),
            "casing_shape": (
                ("casing_node", "casing_component", "casing_mode"),
                casing_shapes(ring, radius),
            ),
            "casing_foundation": ((), 0.0),
            "wall_angle": ("wall_angle", ring),
            "clearance": ("wall_angle", np.full(casing_elements, CLEARANCE)),
        },
        coords={"time": time},
        attrs={
            "title": "synthetic",
            "version": "0.1.0",
            "speed": speed,
            "reference_frequency": 75.0,
            "casing_radius": radius,
            "tip_radius": TIP_RADIUS,
            "friction": friction,
            "format": RESULT_FORMAT,
            "derived": "axial_impulse contact_shape contact_displacement copy_angle",
            "time_step": 1e-6,
            "record_step": RECORD_STEP,
            "clamped": 0,
            "end_reason": "completed",
            "end_message": "",
            "case": 'title = "synthetic"\n',
            "steps": 1000 * (records - 1),
        },
    )


def resting(records: int = 2, speed: float = SPEED, **motion: ArrayLike) -> xr.Dataset:
    """A result at rest, but for the given modal coordinates and rates, such as
    `rotor_displacement`: (mode,), or (record, mode)."""
    result = synthetic_result(records=records, speed=speed)
    for body in ("rotor", "casing"):
        for name in (f"{body}_displacement", f"{body}_velocity"):
            values = np.broadcast_to(motion.pop(name, 0.0), result[name].shape)
            result[name] = result[name].dims, np.array(values, dtype=np.float64)
    assert not motion
    return with_moved_tips(result)


def with_moved_tips(result: xr.Dataset) -> xr.Dataset:
    """A result whose contact nodes move as its modal coordinates say."""
    shape = result["contact_shape"].values
    moved = np.einsum("rm,bdm->rbd", result["rotor_displacement"].values, shape)
    return result.assign(contact_displacement=(result["contact_displacement"].dims, moved))
