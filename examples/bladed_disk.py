"""Make bladed_disk.npz: a sector of a disk of titanium with 18 twisted blades, at 9000 rpm.

python examples/bladed_disk.py
"""

from pathlib import Path

import numpy as np
import skfem
from skfem.io.meshio import to_meshio

import bladewhirl as bw

SECTORS = 18
BORE, RIM, TIP, WIDTH = 0.05, 0.115, 0.2, 0.046  #: radii and axial width [m]
THICKNESS = 6e-3, 3e-3  #: of a blade at root and tip [m]
STAGGER = np.radians([25.0, 60.0])  #: angle of the chord from the axis at root and tip
FOOT = 0.012  #: length over which the rim becomes a blade [m]

block = skfem.MeshHex.init_tensor(
    np.linspace(0.0, 1.0, 11), np.linspace(-0.5, 0.5, 4), np.array([-0.5, 0.5])
)
span, pitch, depth = block.p[:, block.t].mean(axis=1)
whole = block.restrict(np.flatnonzero((span < 0.3) | (abs(pitch) < 1 / 6)))
mesh = to_meshio(skfem.MeshHex2.from_mesh(whole))
u, v, w = mesh.points.T  # along the radius, around the axis and along the axis
radius = np.interp(u, [0.0, 0.3, 1.0], [BORE, RIM, TIP])
height = np.maximum(radius - RIM, 0.0)
along, share = height / (TIP - RIM), np.minimum(height / FOOT, 1.0)
stagger, thickness = np.interp(along, [0, 1], STAGGER), np.interp(along, [0, 1], THICKNESS)
across, axial = 3.0 * thickness * v, WIDTH * w * np.interp(u, [0, 0.15, 0.3, 1], [1, 0.5, 1, 0.9])
y = np.stack([radius * 2 * np.pi / SECTORS * v, across * np.cos(stagger) + axial * np.sin(stagger)])
z = np.stack([axial, axial * np.cos(stagger) - across * np.sin(stagger)])
y, z = (1.0 - share) * y[0] + share * y[1], (1.0 - share) * z[0] + share * z[1]
angle = np.where(share > 0.0, np.arcsin(y / radius), y / radius)
mesh.points = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), z])
mesh.point_sets = {
    "root": np.flatnonzero(u < 1e-9),
    "tip": np.flatnonzero(u > 1 - 1e-9),
    "blade": np.flatnonzero(u > 0.3 - 1e-9),
    "left": np.flatnonzero((v < -0.5 + 1e-9) & (u < 0.3 + 1e-9)),
    "right": np.flatnonzero((v > 0.5 - 1e-9) & (u < 0.3 + 1e-9)),
}
part = bw.mesh3d(
    mesh,
    young_modulus="114 GPa",
    poisson_ratio=0.32,
    density="4430 kg/m3",
    contacts=3,
    blade="blade",
    left="left",
    right="right",
    copies=SECTORS,
    speed="9000 rpm",
    stress=True,
    name="bladed disk",
)

if __name__ == "__main__":
    bw.write_superelement(Path(__file__).with_suffix(".npz"), part)
