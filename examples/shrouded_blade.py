"""Make shrouded_blade.npz: a steel blade of hexahedra whose shroud touches its neighbours.

python examples/shrouded_blade.py
"""

from pathlib import Path

import numpy as np
import skfem
from skfem.io.meshio import to_meshio

import bladewhirl as bw

BLADES = 24
ROOT, TIP, CHORD, THICKNESS = 0.2, 0.33, 0.045, 4e-3  #: [m]
STAGGER = np.radians(30.0)  #: angle of the chord from the axis
FACE = np.radians(45.0)  #: angle of the faces of the shroud from the axis

block = skfem.MeshHex.init_tensor(
    np.array([0.0, 0.38, 0.42, 0.71, 1.0]),
    np.array([-0.5, -0.05, 0.05, 0.5]),
    np.array([-0.5, 0.0, 0.5]),
)
span, across, _ = block.p[:, block.t].mean(axis=1)
whole = block.restrict(np.flatnonzero((abs(span - 0.4) < 0.02) | (abs(across) < 0.05)))
mesh = to_meshio(skfem.MeshHex2.from_mesh(whole))
u, v, w = mesh.points.T  # along the span, around the axis and along the chord
radius = ROOT + (TIP - ROOT) * u
wing = np.clip((abs(v) - 0.05) / 0.45, 0.0, 1.0) * np.sign(v)  # of the shroud, 0 in the blade
axial = CHORD * w * np.cos(STAGGER) * (1.0 - 0.3 * abs(wing))
blade = THICKNESS * np.clip(v / 0.1, -0.5, 0.5) / np.cos(STAGGER)
lean = np.where(abs(wing) > 0.0, abs(wing), 0.0)
chord = axial * np.tan(STAGGER) * (1.0 - lean) - axial * np.tan(FACE) * lean
angle = (blade + chord) / radius + wing * (np.pi / BLADES - THICKNESS / (2.0 * radius))
mesh.points = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), axial])
mesh.point_sets = {
    "root": np.flatnonzero(u < 1e-9),
    "tip": np.flatnonzero((u > 1 - 1e-9) & (abs(v) < 1e-9)),
    "clockwise": np.flatnonzero(v < -0.5 + 1e-9),
    "counter-clockwise": np.flatnonzero(v > 0.5 - 1e-9),
}
part = bw.mesh3d(
    mesh,
    young_modulus="210 GPa",
    poisson_ratio=0.3,
    density="7800 kg/m3",
    contacts=3,
    joint_left="clockwise",
    joint_right="counter-clockwise",
    joint_nodes=1,
    stress=True,
    name="shrouded blade",
)

if __name__ == "__main__":
    bw.write_superelement(Path(__file__).with_suffix(".npz"), part)
