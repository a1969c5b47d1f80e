"""A wheel of blades with shrouds: beams in space, and cases with joints between them."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

import bladewhirl as bw
from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.superelements.superelement import Superelement

BLADES = 7
ROOT, TIP = 0.2, 0.35  #: radii [m]
YOUNG, SHEAR, DENSITY = 210e9, 80e9, 7800.0
STAGGER = 0.6  #: angle of the chord from the axis [rad]
ELEMENTS = 5


def beam(start: FloatArray, end: FloatArray, across: FloatArray, sides: tuple[float, float]) -> Any:
    """Stiffness and mass of a beam in space with a rectangular section, of which `across` is the
    direction of the first side, on x, y, z displacements and rotations of both ends."""
    b, h = sides
    length = float(np.linalg.norm(end - start))
    ex = (end - start) / length
    ey = across - (across @ ex) * ex
    ey /= np.linalg.norm(ey)
    area, iz, iy = b * h, h * b**3 / 12.0, b * h**3 / 12.0
    torsion = 0.3 * min(b, h) ** 3 * max(b, h)
    k, m = np.zeros((12, 12)), np.zeros((12, 12))
    weight = DENSITY * area * length
    line = np.array([[1.0, -1.0], [-1.0, 1.0]])
    both = np.array([[2.0, 1.0], [1.0, 2.0]]) / 6.0
    for place, stiff, mass in (
        ((0, 6), YOUNG * area / length, weight),
        ((3, 9), SHEAR * torsion / length, weight * (iy + iz) / area),
    ):
        k[np.ix_(place, place)] += stiff * line
        m[np.ix_(place, place)] += mass * both
    s = length
    bend = np.array([[12, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]])
    heavy = np.array([[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]])
    scale = np.array([1.0, s, 1.0, s])
    bend, heavy = (scale[:, None] * each * scale for each in (bend, heavy))
    for of_plane, inertia, sign in (((1, 5, 7, 11), iz, 1.0), ((2, 4, 8, 10), iy, -1.0)):
        turn = np.diag([1.0, sign, 1.0, sign])
        k[np.ix_(of_plane, of_plane)] += YOUNG * inertia / s**3 * turn @ bend @ turn
        m[np.ix_(of_plane, of_plane)] += weight / 420.0 * turn @ heavy @ turn
    axes = np.kron(np.eye(4), np.stack([ex, ey, np.cross(ex, ey)]))
    return axes.T @ k @ axes, axes.T @ m @ axes


def blade(blades: int = BLADES) -> Superelement:
    """A clamped blade with a shroud, whose ends are contact nodes 0, clockwise, and 1; its tip is
    node 2, and the points are the tip and the middle of the blade."""
    half = np.pi / blades
    span = np.linspace(ROOT, TIP, ELEMENTS + 1)
    arm = TIP * np.array([[np.cos(half), -np.sin(half), 0.0], [np.cos(half), np.sin(half), 0.0]])
    position = np.vstack([np.column_stack([span, *np.zeros((2, len(span)))]), arm])
    lines = [(n, n + 1) for n in range(ELEMENTS)] + [
        (ELEMENTS, ELEMENTS + 1),
        (ELEMENTS, ELEMENTS + 2),
    ]
    k, m = np.zeros((2, 6 * len(position), 6 * len(position)))
    chord = np.array([0.0, np.sin(STAGGER), np.cos(STAGGER)])
    for number, (a, b) in enumerate(lines):
        own = beam(
            position[a],
            position[b],
            chord if number < ELEMENTS else np.array([0.0, 0.0, 1.0]),
            (0.04, 4e-3) if number < ELEMENTS else (0.02, 5e-3),
        )
        place = np.concatenate([6 * a + np.arange(6), 6 * b + np.arange(6)])
        k[np.ix_(place, place)] += own[0]
        m[np.ix_(place, place)] += own[1]
    k, m = k[6:, 6:], m[6:, 6:]
    nodes = np.array([ELEMENTS + 1, ELEMENTS + 2, ELEMENTS])
    shown = np.array([ELEMENTS, ELEMENTS // 2])
    recovery = np.zeros((6, len(k)))
    recovery[np.arange(6), (6 * (shown - 1)[:, None] + np.arange(3)).ravel()] = 1.0
    return Superelement(
        mass=m,
        stiffness=k,
        contact_position=position[nodes],
        contact_dofs=6 * (nodes - 1)[:, None] + np.arange(3),
        points=position[shown],
        recovery=recovery,
        joint_left=np.array([0]),
        joint_right=np.array([1]),
        name="shrouded blade",
    )


def tables(folder: Path, **joint: Any) -> dict[str, Any]:
    """Tables of a case of a wheel of these blades with one joint and engine order 2."""
    file = folder / "blade.npz"
    bw.write_superelement(file, blade())
    own: Mapping[str, Any] = {"name": "shroud", "angle": "30 deg", "friction": 0.3} | joint
    return {
        "bladed_disk": {"superelement": {"file": str(file), "copies": BLADES}},
        "reduction": {"free_interface_modes": 30},
        "damping": {"ratio": 2e-3},
        "casing": {"type": "rigid", "clearance": "10 mm"},
        "excitation": {"type": "engine-order", "order": 2, "points": [0], "amplitude": 5.0},
        "joint": [own],
        "march": {"speed": "3000 rpm"},
    }
